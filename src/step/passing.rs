//! Tunnelling: pairs of bodies that pass through each other within a step.
//!
//! A test of the end positions alone misses a pair that ends on the far sides of each other without overlap. So for
//! pairs that move far enough, the path itself is checked, `C(s U)` for `s` from 0 to 1: a pair has *passed* if its
//! surfaces overlap somewhere on the path by three quarters of the thinner body's thickness more than at both ends. Two
//! equal spheres that slide around each other in one step reach this depth beyond a turn of 151 degrees. To get that
//! much deeper and out again, the two must move by one and a half thicknesses relative to each other, so for most steps
//! a check of the speeds suffices.
//!
//! The depth changes by at most the relative motion of the surfaces, which bounds it between two points of the path (S.
//! A. Piyavskii, "An algorithm for finding the absolute extremum of a function", 1972); parts of the path that cannot
//! reach the threshold are skipped.
//!
//! A pair also counts as passed if one of the two turns by more than a whole turn in the step within the other's reach.
//! Constraints linearize rotations, so after such a step the path has no meaning: bodies may be thrown apart by many
//! lengths without any overlap.

use crate::bodies::Bodies;
use crate::broad_phase::{Aabb, BroadPhase, Grid, Periodic};
use crate::dynamics::{Pose, Twist, advance};
use crate::periodic::CellShear;
use crate::separation::{Placed, Separation};
use glam::DVec3;
use rayon::prelude::*;

/// The threshold of the depth on the path beyond that at both ends, as a part of the thinner body's thickness: at 1 the
/// middles of two equal spheres, or of two crossing rods, coincide. In the hard cases (the study `hard`), pairs that
/// reach 0.5 at all reach 0.9, so every threshold between 0.5 and 0.9 detects the same steps.
pub(crate) const DEEPER: f64 = 0.75;

/// A part of the path on which a pair moves by less than this part of the thinner body's thickness is not divided: a
/// missed depth exceeds the threshold by at most half of it.
const FINEST: f64 = 0.125;

/// The constraints of a body that turns by more than this angle in a step have no meaning. Twenty rods of aspect 3 that
/// each turn by 1.6 in a step stay within the ball that they fill; with a turn of 100 they end up to 26 of its radii
/// outside (`benches/peers/run --atlas`).
const WHOLE_TURN: f64 = std::f64::consts::TAU;

/// A loop over fewer bodies than this runs on one thread: the path of a body takes some 50 ns.
const LEAST_BODIES_A_TASK: usize = 512;

/// The pairs that passed in a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Passed {
    /// Their number.
    pub pairs: usize,
    /// The first of them.
    pub pair: [usize; 2],
}

/// The pairs of bodies that pass each other if all move from `start` for `dt` with the constant velocities `twist`;
/// none if no pair does. `separate` is the separation of a pair, in space or in the plane. In periodic space the image
/// that is nearest at the start counts, in a sheared cell with its velocity. The pairs of `but`, ascending, do not
/// count.
pub fn passed(
    start: &Bodies,
    twist: &[Twist],
    (dt, shear): (f64, Option<CellShear>),
    but: &[[u32; 2]],
    separate: impl Fn(&Placed, &Placed) -> Option<Separation> + Sync,
) -> Option<Passed> {
    let ways = ways(start, twist, (dt, shear));
    let [farthest, thinnest] = extremes(&ways);
    if !may_pass(farthest, thinnest) {
        return None;
    }
    let boxes: Vec<Aabb> = ways.par_iter().with_min_len(LEAST_BODIES_A_TASK).map(Way::swept).collect();
    let mut near = Vec::new();
    Periodic::new(Grid::default(), start.periods).pairs(&boxes, &mut near);
    let passes = |pair: &[u32; 2]| {
        if but.binary_search(pair).is_ok() {
            return false;
        }
        let [a, b] = pair.map(|i| &ways[i as usize]);
        let image = start.periods.nearest(b.from.position - a.from.position);
        let drift = shear.map_or(DVec3::ZERO, |shear| shear.velocity(image));
        Approach { a, b, delta: image, drift }.passes(&separate)
    };
    let found: Vec<[u32; 2]> = near.into_par_iter().filter(passes).collect();
    let pair = found.first()?.map(|i| i as usize);
    Some(Passed { pairs: found.len(), pair })
}

fn ways(start: &Bodies, twist: &[Twist], (dt, shear): (f64, Option<CellShear>)) -> Vec<Way> {
    let of_body = |i: usize| match shear {
        None => Way::of(start.placed(i), twist[i], dt),
        Some(shear) => Way::of(start.placed(i), twist[i], dt).beside(shear),
    };
    (0..start.len()).into_par_iter().with_min_len(LEAST_BODIES_A_TASK).map(of_body).collect()
}

/// The largest displacement of a surface point, and the thickness of the thinnest body.
fn extremes(ways: &[Way]) -> [f64; 2] {
    let each = ways.par_iter().with_min_len(LEAST_BODIES_A_TASK).map(|way| [way.motion, way.thickness]);
    each.reduce(|| [0.0, f64::INFINITY], |[far, thin], [other, thinner]| [far.max(other), thin.min(thinner)])
}

/// The largest displacement of a surface point of these bodies, and the thickness of the thinnest, as in [`passed`].
#[cfg(feature = "mpi")]
pub(crate) fn farthest_and_thinnest(
    start: &Bodies,
    twist: &[Twist],
    interval_and_shear: (f64, Option<CellShear>),
) -> [f64; 2] {
    extremes(&ways(start, twist, interval_and_shear))
}

/// Whether two bodies can pass if no surface point moves by more than `farthest` and no body is thinner than
/// `thinnest`.
pub(crate) fn may_pass(farthest: f64, thinnest: f64) -> bool {
    farthest >= DEEPER * thinnest
}

/// A body's path through a step.
struct Way {
    from: Placed,
    twist: Twist,
    dt: f64,
    /// The largest displacement of a surface point.
    motion: f64,
    radius: f64,
    thickness: f64,
    /// The part of the motion from the difference of a flow over the body.
    drifts: f64,
}

impl Way {
    fn of(from: Placed, twist: Twist, dt: f64) -> Way {
        let (radius, thickness) = (from.shape.bounding_radius(), from.shape.thickness());
        let mut way = Way { from, twist, dt, motion: 0.0, radius, thickness, drifts: 0.0 };
        way.motion = dt * twist.linear.length() + way.arc(1.0);
        way
    }

    /// The path relative to the flow of a sheared cell at the start position. The difference of that flow over the body
    /// is part of its motion: two bodies that meet are no farther apart.
    fn beside(mut self, shear: CellShear) -> Way {
        self.twist.linear -= shear.velocity(self.from.position);
        self.drifts = self.dt * shear.rate.abs() * self.radius;
        self.motion = self.dt * self.twist.linear.length() + self.arc(1.0) + self.drifts;
        self
    }

    /// The largest displacement of a surface point by the rotation over the part `s` of the path; the rotation is less
    /// than half a turn at any speed.
    fn arc(&self, s: f64) -> f64 {
        self.radius * 2.0 * (0.5 * s * self.dt * self.twist.angular.length()).atan()
    }

    /// Whether the body turns so far that constraints, which linearize rotations, have no meaning: by more than a whole
    /// turn, with a lever that gives a larger displacement than a pair needs to pass. The normals of a sphere have no
    /// lever.
    fn spins(&self, thinner: f64) -> bool {
        let (turn, lever) = (self.dt * self.twist.angular.length(), self.radius - 0.5 * self.thickness);
        turn > WHOLE_TURN && lever * turn > 2.0 * DEEPER * thinner
    }

    /// The body after the part `s` of the path, relative to `origin`.
    fn at(&self, s: f64, origin: DVec3) -> Placed {
        let from = Pose { position: origin, orientation: self.from.orientation };
        let Pose { position, orientation } = advance(from, self.twist, s * self.dt);
        Placed { shape: self.from.shape, position, orientation }
    }

    /// A box that contains the body on its whole path: a point on an arc is within half of its length of one of its
    /// ends.
    fn swept(&self) -> Aabb {
        let [first, last] = [0.0, 1.0].map(|s| {
            let placed = self.at(s, self.from.position);
            let half = placed.shape.half_extents(placed.orientation) + DVec3::splat(0.5 * self.arc(1.0) + self.drifts);
            [placed.position - half, placed.position + half]
        });
        Aabb { min: first[0].min(last[0]), max: first[1].max(last[1]) }
    }
}

/// Two moving bodies, with `delta` from a's centre to b's at the start.
struct Approach<'a> {
    a: &'a Way,
    b: &'a Way,
    delta: DVec3,
    /// The velocity of b beyond its twist.
    drift: DVec3,
}

impl Approach<'_> {
    fn passes(&self, separate: &impl Fn(&Placed, &Placed) -> Option<Separation>) -> bool {
        let thickness = self.a.thickness.min(self.b.thickness);
        let travel = self.a.dt * (self.b.twist.linear - self.a.twist.linear + self.drift);
        let turned = |s: f64| self.a.arc(s) + self.b.arc(s);
        let moved = |s: f64, t: f64| travel.length() * (t - s) + (turned(t) - turned(s));
        // So far in one step that rounding hides a body: such a path has no meaning.
        let hidden = (travel.length() + self.delta.length()) * f64::EPSILON > FINEST * thickness;
        if hidden || moved(0.0, 1.0) < 2.0 * DEEPER * thickness {
            return false;
        }
        if self.within_reach() && [self.a, self.b].iter().any(|way| way.spins(thickness)) {
            return true;
        }
        // The centres must come at least this near, because a depth is at most the overlap of the bounding spheres.
        let reach = self.a.radius + self.b.radius - DEEPER * thickness;
        let Some(part) = self.within(travel, reach) else { return false };
        let depth = |s: f64| {
            // Both are relative to a's start, so that no digits are lost far from the origin.
            let [a, b] = [self.a.at(s, DVec3::ZERO), self.b.at(s, self.delta + s * self.b.dt * self.drift)];
            separate(&a, &b).map_or(f64::NEG_INFINITY, |found| -found.separation)
        };
        let bar = depth(0.0).max(depth(1.0)).max(0.0) + DEEPER * thickness;
        reaches(bar, moved, FINEST * thickness, part.map(|s| (s, depth(s))), &depth)
    }

    /// Whether the two may touch at the start in any orientation.
    fn within_reach(&self) -> bool {
        self.delta.length() < self.a.radius + self.b.radius
    }

    /// The part of the path on which the two centres are within `reach` of each other.
    fn within(&self, travel: DVec3, reach: f64) -> Option<[f64; 2]> {
        let square = travel.length_squared();
        if square == 0.0 {
            return (self.delta.length() < reach).then_some([0.0, 1.0]);
        }
        let nearest = -self.delta.dot(travel) / square;
        let left = reach * reach - (self.delta + nearest * travel).length_squared();
        let half = (left.max(0.0) / square).sqrt();
        let part = [(nearest - half).max(0.0), (nearest + half).min(1.0)];
        (left > 0.0 && part[0] < part[1]).then_some(part)
    }
}

/// Whether `depth`, which changes by at most `moved(s, t)` from `s` to `t`, exceeds `bar` somewhere between two points
/// where it is known.
fn reaches(
    bar: f64,
    moved: impl Fn(f64, f64) -> f64,
    finest: f64,
    ends: [(f64, f64); 2],
    depth: &impl Fn(f64) -> f64,
) -> bool {
    if ends.iter().any(|(_, depth)| *depth > bar) {
        return true;
    }
    let mut parts = vec![ends];
    while let Some([(s, here), (t, there)]) = parts.pop() {
        let moved = moved(s, t);
        // Without a separation the bound is NaN, and the result is false.
        let possible = 0.5 * (here + there + moved) > bar;
        if !possible || moved < finest {
            continue;
        }
        let middle = (0.5 * (s + t), depth(0.5 * (s + t)));
        if middle.1 > bar {
            return true;
        }
        parts.push([middle, (t, there)]);
        parts.push([(s, here), middle]);
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::separation::separation;
    use crate::shape::Shape;
    use glam::DQuat;

    fn find_passed(bodies: &[(Shape, DVec3, DVec3, DVec3)]) -> Option<Passed> {
        let mut start = Bodies::default();
        let mut twist = Vec::new();
        for (shape, position, linear, angular) in bodies {
            start.push(Placed { shape: *shape, position: *position, orientation: DQuat::IDENTITY }, 0);
            twist.push(Twist { linear: *linear, angular: *angular });
        }
        passed(&start, &twist, (0.5, None), &[], |a, b| separation(a, b, None))
    }

    const SPHERE: Shape = Shape::Sphere { radius: 0.5 };

    #[test]
    fn a_sphere_that_jumps_over_another_passes_it_and_one_that_stops_before_does_not() {
        let wall = (SPHERE, DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
        let fast = |x: f64, y: f64| (SPHERE, DVec3::new(-1.5, y, 0.0), DVec3::new(x, 0.0, 0.0), DVec3::ZERO);
        assert_eq!(find_passed(&[wall, fast(6.0, 0.0)]), Some(Passed { pairs: 1, pair: [0, 1] }));
        assert_eq!(find_passed(&[wall, fast(6.0, 0.2)]), Some(Passed { pairs: 1, pair: [0, 1] }));
        assert_eq!(find_passed(&[wall, fast(6.0, 0.3)]), None);
        assert_eq!(find_passed(&[wall, fast(1.0, 0.0)]), None);
        assert_eq!(find_passed(&[wall, fast(600.0, 0.0)]), Some(Passed { pairs: 1, pair: [0, 1] }));
    }

    #[test]
    fn both_move_far_together_and_none_passes() {
        let far = DVec3::new(1e3, 0.0, 0.0);
        assert_eq!(find_passed(&[(SPHERE, DVec3::ZERO, far, DVec3::ZERO), (SPHERE, DVec3::X, far, DVec3::ZERO)]), None);
    }

    #[test]
    fn a_rod_that_turns_through_another_passes_it() {
        let rod = Shape::Spherocylinder { diameter: 0.2, length: 4.0 };
        let still = (rod, DVec3::new(0.0, 0.5, 0.0), DVec3::ZERO, DVec3::ZERO);
        // About x, by 2 atan(0.5): the upper half of one sweeps over the other, which is beside it.
        let turn = (rod, DVec3::ZERO, DVec3::ZERO, DVec3::new(-2.0, 0.0, 0.0));
        let aside = (rod, DVec3::new(0.3, 0.0, 0.0), DVec3::ZERO, DVec3::new(-2.0, 0.0, 0.0));
        assert!(find_passed(&[still, turn]).is_none(), "it has come to lie across, and still overlaps at the end");
        let small = (SPHERE, DVec3::new(0.0, 0.5, 1.4), DVec3::ZERO, DVec3::ZERO);
        assert!(find_passed(&[small, turn]).is_some());
        assert!(find_passed(&[small, aside]).is_some());
        let clear = (rod, DVec3::new(0.7, 0.0, 0.0), DVec3::ZERO, DVec3::new(-2.0, 0.0, 0.0));
        assert!(find_passed(&[small, clear]).is_none());
    }

    #[test]
    fn a_rod_that_turns_many_times_in_a_step_beside_another_is_not_accepted_unseen() {
        let rod = Shape::Spherocylinder { diameter: 0.5, length: 1.5 };
        let spun = |speed: f64| (rod, DVec3::ZERO, DVec3::ZERO, speed * DVec3::Z);
        let thrown = |x: f64| (rod, DVec3::new(x, 0.0, 0.0), DVec3::new(80.0, 0.0, 0.0), DVec3::ZERO);
        // Steps of half a unit of time.
        assert_eq!(find_passed(&[spun(200.0), thrown(0.6)]), Some(Passed { pairs: 1, pair: [0, 1] }));
        assert_eq!(find_passed(&[spun(200.0), thrown(1.6)]), None, "out of reach");
        assert_eq!(find_passed(&[spun(12.0), thrown(0.6)]), None, "less than a whole turn");
        let sphere = (SPHERE, DVec3::ZERO, DVec3::ZERO, 200.0 * DVec3::Z);
        assert_eq!(find_passed(&[sphere, thrown(0.9)]), None, "a sphere may spin");
    }

    #[test]
    fn the_bound_finds_a_peak_between_the_places_that_were_looked_at_first() {
        let peak = |s: f64| -(s - 0.371f64).abs() * 40.0 + 1.0;
        let ends = [(0.0, peak(0.0)), (1.0, peak(1.0))];
        assert!(reaches(0.9, |s, t| 40.0 * (t - s), 0.01, ends, &peak));
        assert!(!reaches(1.1, |s, t| 40.0 * (t - s), 0.01, ends, &peak));
    }

    #[test]
    fn bodies_that_are_thrown_without_measure_are_looked_at_in_no_time() {
        let ellipsoid = Shape::Ellipsoid { radii: [0.3, 0.5, 1.0] };
        let rod = Shape::Spherocylinder { diameter: 0.2, length: 4.0 };
        for speed in [1e3, 1e9, 1e12, 1e20, 1e150, 1e300, f64::MAX] {
            let thrown = (rod, DVec3::new(-3.0, 0.1, 0.0), speed * DVec3::X, speed * DVec3::Z);
            let still = (ellipsoid, DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
            let spun = (ellipsoid, DVec3::new(3.0, 0.0, 0.0), DVec3::ZERO, -speed * DVec3::Y);
            let found = find_passed(&[thrown, still, spun]);
            // As long as points of the path are distinguishable, it passes both.
            assert_eq!(found.map(|found| found.pairs), (speed < 1e13).then_some(2), "{speed:e}");
        }
    }
}
