//! Branches in WGSL: the fragments of a kernel that knows the branches of a scene's pairs.

use super::{BRANCHES, DEEPEST, LEAST_SLACK, RING_ROUNDING, ROUNDING, SLACK_IN_SPACE, WINDOW};
use crate::gpu::{Source, fragment};
use crate::separation::gpu::{Family, add_minima_of_circles_to, add_tolerances_to};
use crate::shape::Shape;
use std::fmt::Write as _;

/// Two ways to compute a distance differ by less than this many roundings of the sizes: by 2.1 at most in 7 million
/// random pairs of rods, aspect 1.5 to 100.
const ROUNDINGS: f64 = 8.0;

/// The pairs of a scene that have several branches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Branched {
    rods: bool,
    rings: bool,
}

impl Branched {
    /// Those of bodies of these shapes.
    pub fn of(shapes: &[Shape]) -> Self {
        Branched {
            rods: shapes.iter().any(|shape| matches!(shape, Shape::Spherocylinder { .. })),
            rings: Family::Circle.has_any(shapes),
        }
    }

    /// Whether there are some.
    pub fn any(self) -> bool {
        self.rods || self.rings
    }

    /// Whether some have branches whose separation follows from their number alone.
    pub fn has_ends(self) -> bool {
        self.rods
    }

    /// How many branches a pair has at most.
    pub fn most(self) -> u32 {
        if self.any() { BRANCHES } else { 1 }
    }

    /// Adds, to a source with bodies, `BRANCHED`, whether there are some; the bit `WHOLE` of the separation itself in a
    /// mask of branches; and the functions
    ///
    /// * `has_branches(a, b)`, whether a pair has several;
    /// * `branches_within(delta, a, b, nearest, limit, most_active, pushed)`: the mask of the branches of such a pair,
    ///   `nearest` apart, that are at most `limit`, and of those over `most_active` only the `pushed` ones; at least
    ///   one;
    /// * `branch_separation(delta, a, b, nearest, k)`: the separation at branch `k > 0`;
    /// * `branch_slack(a, b, normal, turned, slid)`: how far a branch may lie above the pair's separation and still
    ///   become active, if the pair turns against each other by the rotation vector `turned` and slides by `slid`.
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
        source.text(&self.functions())
    }

    /// The functions that choose by the shapes of a pair.
    fn functions(self) -> String {
        let mut text = String::new();
        let mut function = |head: &str, rods: &str, rings: &str, otherwise: &str| {
            let _ = writeln!(text, "fn {head} {{");
            for (test, value, there) in [("are_rods", rods, self.rods), ("are_rings", rings, self.rings)] {
                if there {
                    let _ = writeln!(text, "    if {test}(a, b) {{ return {value}; }}");
                }
            }
            let _ = writeln!(text, "    return {otherwise};\n}}");
        };
        function("has_branches(a: Placed, b: Placed) -> bool", "true", "true", "false");
        function(
            "branches_within(delta: vec3r, a: Placed, b: Placed, nearest: real, limit: real, most_active: real, pushed: u32) -> u32",
            "rods_within(delta, a, b, nearest, limit, most_active, pushed)",
            "rings_within(delta, a, b, nearest, limit, most_active, pushed)",
            "WHOLE",
        );
        function(
            "branch_separation(delta: vec3r, a: Placed, b: Placed, nearest: real, k: u32) -> Separation",
            "separation_of_rods(delta, a, b, k)",
            "separation_of_rings(delta, a, b, nearest, k)",
            "Separation(nearest, vec3r(), vec3r(), vec3r())",
        );
        function(
            "branch_slack(a: Placed, b: Placed, normal: vec3r, turned: vec3r, slid: real) -> real",
            "slack_of_rods(a, b, normal, turned, slid)",
            "slack_of_rings(a, b, turned, slid)",
            "real(0.0)",
        );
        text
    }
}
