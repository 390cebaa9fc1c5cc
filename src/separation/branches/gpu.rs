//! Branches in WGSL: the fragments of a kernel for the branches of a scene's pairs.

use super::{BRANCHES, DEEPEST, LEAST_SLACK, RING_ROUNDING, ROUNDING, SLACK_IN_SPACE, WINDOW};
use crate::gpu::{Source, fragment};
use crate::separation::gpu::{
    Family, add_minima_of_circle_and_ellipsoid_to, add_minima_of_circles_to, add_tolerances_to,
};
use crate::shape::Shape;
use std::fmt::Write as _;

/// Two ways to compute a distance differ by less than this many rounding errors of the sizes: by at most 2.1 in 7
/// million random pairs of rods with aspect ratios of 1.5 to 100.
const ROUNDINGS: f64 = 8.0;

/// The pairs of a scene that have several branches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Branched {
    rods: bool,
    rings: bool,
    /// Rings and ellipsoids.
    ringed: bool,
}

impl Branched {
    /// The pairs of bodies of these shapes.
    pub fn of(shapes: &[Shape]) -> Self {
        Branched {
            rods: shapes.iter().any(|shape| matches!(shape, Shape::Spherocylinder { .. })),
            rings: Family::Circle.has_any(shapes),
            ringed: Family::Circle.has_any(shapes) && Family::Ellipsoid.has_any(shapes),
        }
    }

    /// Whether there are any.
    pub fn any(self) -> bool {
        self.rods || self.rings
    }

    /// Whether some have branches whose separation follows from their number alone.
    pub fn has_ends(self) -> bool {
        self.rods
    }

    /// The largest number of branches of a pair.
    pub fn most(self) -> u32 {
        if self.any() { BRANCHES } else { 1 }
    }

    /// Adds, to a source with bodies, the flag `BRANCHED`, which is set if there are any; the bit `WHOLE`, which stands
    /// for the separation itself in a mask of branches; and the functions
    ///
    /// * `has_branches(a, b)`: whether a pair has several;
    /// * `branches_within(delta, a, b, nearest, limit, most_active, pushed)`: the mask of the branches of such a pair
    ///   with the separation `nearest` that are at most `limit`; of those above `most_active` only the `pushed` ones;
    ///   at least one;
    /// * `branch_separation(delta, a, b, nearest, k)`: the separation at branch `k > 0`;
    /// * `branch_slack(a, b, normal, turned, slid)`: how far a branch may lie above the pair's separation and still
    ///   become active, with the relative rotation vector `turned` and the slide `slid`.
    pub fn add_to(self, source: Source) -> Source {
        let epsilon = source.precision().epsilon();
        let mut source = add_tolerances_to(source)
            .flag("BRANCHED", self.any())
            .integer("WHOLE", 1)
            .real("DEEPEST", DEEPEST)
            .real("LEAST_SLACK", LEAST_SLACK)
            .real("SLACK_IN_SPACE", SLACK_IN_SPACE)
            .real("BRANCH_ROUNDING", (ROUNDINGS * epsilon).max(ROUNDING))
            .include(fragment!("separation/nearest.wgsl"));
        if self.rods {
            source = source.include(fragment!("separation/branches_of_rods.wgsl"));
        }
        if self.rings {
            source = add_minima_of_circles_to(source)
                .real("WINDOW", WINDOW)
                .real("RING_ROUNDING", (ROUNDINGS * epsilon).max(RING_ROUNDING))
                .include(fragment!("separation/branches_of_rings.wgsl"));
        }
        if self.rods && self.rings {
            source = source
                .include(fragment!("separation/circle_segment_minima.wgsl"))
                .include(fragment!("separation/branches_of_ring_and_rod.wgsl"));
        }
        if self.ringed {
            source = add_minima_of_circle_and_ellipsoid_to(source)
                .include(fragment!("separation/branches_of_ring_and_ellipsoid.wgsl"));
        }
        source.text(&self.functions())
    }

    /// The functions that dispatch on the shapes of a pair.
    fn functions(self) -> String {
        let mut text = String::new();
        let tests = [
            ("are_rods", self.rods),
            ("are_rings", self.rings),
            ("are_ring_and_rod", self.rods && self.rings),
            ("are_ring_and_ellipsoid", self.ringed),
        ];
        let mut function = |head: &str, values: [&str; 4], otherwise: &str| {
            let _ = writeln!(text, "fn {head} {{");
            for ((test, _), value) in tests.iter().zip(values).filter(|((_, there), _)| *there) {
                let _ = writeln!(text, "    if {test}(a, b) {{ return {value}; }}");
            }
            let _ = writeln!(text, "    return {otherwise};\n}}");
        };
        function("has_branches(a: Placed, b: Placed) -> bool", ["true"; 4], "false");
        function(
            "branches_within(delta: vec3r, a: Placed, b: Placed, nearest: real, limit: real, most_active: real, pushed: u32) -> u32",
            [
                "rods_within(delta, a, b, nearest, limit, most_active, pushed)",
                "rings_within(delta, a, b, nearest, limit, most_active, pushed)",
                "ring_and_rod_within(delta, a, b, nearest, limit, most_active, pushed)",
                "ring_and_ellipsoid_within(delta, a, b, nearest, limit, most_active, pushed)",
            ],
            "WHOLE",
        );
        function(
            "branch_separation(delta: vec3r, a: Placed, b: Placed, nearest: real, k: u32) -> Separation",
            [
                "separation_of_rods(delta, a, b, k)",
                "separation_of_rings(delta, a, b, nearest, k)",
                "separation_of_ring_and_rod(delta, a, b, k)",
                "separation_of_ring_and_ellipsoid(delta, a, b, nearest, k)",
            ],
            "Separation(nearest, vec3r(), vec3r(), vec3r())",
        );
        function(
            "branch_slack(a: Placed, b: Placed, normal: vec3r, turned: vec3r, slid: real) -> real",
            [
                "slack_of_rods(a, b, normal, turned, slid)",
                "slack_of_rings(a, b, turned, slid)",
                "slack_of_ring_and_rod(a, b, turned, slid)",
                "slack_of_ring_and_ellipsoid(a, b, turned, slid)",
            ],
            "real(0.0)",
        );
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::{Precision, validate};
    use crate::separation::gpu::add_bodies_to;

    #[test]
    fn the_functions_of_every_mixture_are_valid_in_both_precisions() {
        let cases = [
            (false, false, false),
            (true, false, false),
            (false, true, false),
            (true, true, false),
            (false, true, true),
            (true, true, true),
        ];
        for (precision, (rods, rings, ringed)) in
            [Precision::F32, Precision::F64].into_iter().flat_map(|p| cases.map(|c| (p, c)))
        {
            let source =
                add_bodies_to(Source::new("branches", precision)).flag("PLANAR", false).integer("BRANCHES", BRANCHES);
            let source = Branched { rods, rings, ringed }.add_to(source).text(
                "@group(0) @binding(0) var<storage, read_write> out: array<vec4r>;
                 @compute @workgroup_size(WORKGROUP)
                 fn main(@builtin(local_invocation_index) i: u32) {
                     let body = Placed(i % 4u, out[i].xyz, out[i + 1u]);
                     let apart = out[i + 2u];
                     if !BRANCHED || !has_branches(body, body) { return; }
                     let slack = branch_slack(body, body, apart.xyz, apart.xyz, apart.w);
                     let mask = branches_within(apart.xyz, body, body, apart.w, apart.w, slack, 0u);
                     if mask != WHOLE { out[i] = vec4r(branch_separation(apart.xyz, body, body, apart.w, 1u).normal, slack); }
                 }",
            );
            validate(&source)
                .unwrap_or_else(|e| panic!("{precision:?}, rods {rods}, rings {rings}, with ellipsoids {ringed}: {e}"));
        }
    }
}
