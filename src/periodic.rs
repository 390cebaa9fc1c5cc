//! Periodic space: the images of a body, and which of them is met.
//!
//! Along an axis with a period `L` space goes on as it began: a body at `x` is also at `x + n L` for every integer `n`.
//! Positions are never wrapped. A pair of bodies meets at the image of b that is nearest to a, `Delta = x_b - x_a - L
//! round((x_b - x_a) / L)`, the minimum image (M. P. Allen, D. J. Tildesley, "Computer Simulation of Liquids", 1987,
//! section 1.5.3), and separations, rows and levers are computed from `Delta` alone: they depend neither on where a
//! cell begins nor on the image that a body is at.
//!
//! One image is enough while the two reaches, the cutoff, and what both move freely in a step are together at most half
//! a period: every other image has its centre at least that far away along the axis. A scene whose bodies are longer,
//! or may grow so long, is refused ([`Scene::validate`](crate::Scene::validate)), and a step whose bodies would move
//! too far is a [`Fault`](crate::step::Fault). What audits a state ([`contacts`](crate::step::contacts)) does not rest
//! on this: it looks at all images whose boxes touch.

use crate::motion::Aabb;
use crate::separation::Placed;
use glam::{DVec3, I64Vec3};
#[cfg(feature = "files")]
use schemars::JsonSchema;
#[cfg(feature = "files")]
use serde::{Deserialize, Serialize};

/// Periods of space along its axes. A body, with the cutoff, is at most half as long as the shortest period. Positions
/// are not wrapped: a body that leaves the cell keeps its unwrapped position; others meet it at its nearest image.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema))]
#[cfg_attr(feature = "files", serde(deny_unknown_fields))]
#[non_exhaustive]
pub struct Periodic {
    /// The period along x, y and z; null where space is open. In a planar scene along z it is null.
    pub lengths: [Option<f64>; 3],
    /// The engineering strain rates along x, y and z, one over time, of a cell whose lengths change: at a time `t` they
    /// are `lengths (1 + strain_rate t)`. Bodies are carried by the flow that goes with it. Along an open axis it is 0.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub strain_rate: Option<[f64; 3]>,
}

impl Periodic {
    /// These periods along x, y and z; `None` where space is open.
    pub const fn new(lengths: [Option<f64>; 3]) -> Periodic {
        Periodic { lengths, strain_rate: None }
    }

    /// What each length at `time` is of that at time 0.
    fn stretch(&self, time: f64) -> [f64; 3] {
        self.strain_rate.map_or([1.0; 3], |rates| rates.map(|rate| 1.0 + rate * time))
    }

    /// The periods at `time`.
    pub(crate) fn at(&self, time: f64) -> Periods {
        let stretch = self.stretch(time);
        Periods::new(std::array::from_fn(|axis| self.lengths[axis].map(|length| length * stretch[axis])))
    }

    /// The rates at which the lengths change at `time`, over the lengths then.
    pub(crate) fn rates(&self, time: f64) -> DVec3 {
        let (rates, stretch) = (self.strain_rate.unwrap_or_default(), self.stretch(time));
        DVec3::from(rates) / DVec3::from(stretch)
    }
}

/// The translations under which a periodic space is the same: those by whole lengths along the axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Periods {
    /// Period along each axis, 0 for an open axis.
    length: DVec3,
    /// Its inverse, zero where there is none.
    inverse: DVec3,
}

impl Periods {
    /// No periods.
    pub const NONE: Periods = Periods { length: DVec3::ZERO, inverse: DVec3::ZERO };

    /// These periods; a number that is not a positive length is none.
    pub fn new(lengths: [Option<f64>; 3]) -> Periods {
        let length = lengths.map(|length| length.filter(|l| *l > 0.0 && l.is_finite()).unwrap_or(0.0));
        let inverse = length.map(|length| if length > 0.0 { 1.0 / length } else { 0.0 });
        Periods { length: length.into(), inverse: inverse.into() }
    }

    /// Whether no axis has a period.
    #[inline]
    pub fn is_none(&self) -> bool {
        self.length == DVec3::ZERO
    }

    /// The period along each axis, where there is one.
    pub fn lengths(&self) -> [Option<f64>; 3] {
        self.length.to_array().map(|length| (length > 0.0).then_some(length))
    }

    /// The period along each axis; zero where there is none.
    pub fn length(&self) -> DVec3 {
        self.length
    }

    /// The largest coordinate of a point along an axis with a period.
    pub fn farthest(&self, x: DVec3) -> f64 {
        DVec3::select(self.length.cmpgt(DVec3::ZERO), x.abs(), DVec3::ZERO).max_element()
    }

    /// The shortest period.
    pub fn shortest(&self) -> Option<f64> {
        self.lengths().into_iter().flatten().reduce(f64::min)
    }

    /// The volume of a cell, in the plane its area; none where an axis has no period.
    pub fn volume(&self, planar: bool) -> Option<f64> {
        let axes = if planar { 2 } else { 3 };
        self.lengths()[..axes].iter().copied().product()
    }

    /// The cell, as numbers of periods, that a point or a distance is in; cells are centred on the origin.
    #[inline]
    fn cell(&self, x: DVec3) -> DVec3 {
        (x * self.inverse).round()
    }

    /// The distance to the nearest image of what is at the distance `delta`.
    #[inline]
    pub fn nearest(&self, delta: DVec3) -> DVec3 {
        if self.is_none() { delta } else { delta - self.length * self.cell(delta) }
    }

    /// The periods by which what is at the distance `delta` is moved to its nearest image.
    pub fn nearest_image(&self, delta: DVec3) -> I64Vec3 {
        -self.cell(delta).as_i64vec3()
    }

    /// A pair as its separation is computed from: with a period, a at the origin and the nearest image of b from there.
    #[inline]
    pub fn pair(&self, a: Placed, b: Placed) -> [Placed; 2] {
        if self.is_none() {
            return [a, b];
        }
        let delta = self.nearest(b.position - a.position);
        [Placed { position: DVec3::ZERO, ..a }, Placed { position: delta, ..b }]
    }

    /// The image of a point in the cell that is centred on the origin, from `-L/2` to under `L/2`, and the cell that
    /// the point is in.
    ///
    /// ```
    /// use glam::{DVec3, I64Vec3};
    /// use relcp::periodic::Periods;
    /// let periods = Periods::new([Some(4.0), None, None]);
    /// let (position, image) = periods.wrapped(DVec3::new(7.0, 7.0, 7.0));
    /// assert_eq!((position, image), (DVec3::new(-1.0, 7.0, 7.0), I64Vec3::new(2, 0, 0)));
    /// ```
    pub fn wrapped(&self, position: DVec3) -> (DVec3, I64Vec3) {
        if self.is_none() {
            return (position, I64Vec3::ZERO);
        }
        let image = (position * self.inverse + 0.5).floor();
        (position - self.length * image, image.as_i64vec3())
    }

    /// The images of `b` whose boxes share a point with `a`, faces counted, as the first and the last number of periods
    /// that it is moved by along each axis; none where they share none.
    #[doc(hidden)]
    pub fn images(&self, a: &Aabb, b: &Aabb) -> Option<[I64Vec3; 2]> {
        let (mut first, mut last) = (I64Vec3::ZERO, I64Vec3::ZERO);
        for axis in 0..3 {
            let (low, high) = (a.min[axis] - b.max[axis], a.max[axis] - b.min[axis]);
            if self.length[axis] == 0.0 {
                if !(low <= 0.0 && high >= 0.0) {
                    return None;
                }
            } else {
                let (low, high) = ((low / self.length[axis]).ceil(), (high / self.length[axis]).floor());
                // Not a number is no image.
                let meet = low <= high;
                if !meet {
                    return None;
                }
                (first[axis], last[axis]) = (low as i64, high as i64);
            }
        }
        Some([first, last])
    }

    /// Whether a proper box shares a point with some image of another.
    #[doc(hidden)]
    pub fn touches(&self, a: &Aabb, b: &Aabb) -> bool {
        if self.is_none() { a.touches(b) } else { self.images(a, b).is_some() }
    }

    /// The distance that an image is moved by.
    pub fn shift(&self, image: I64Vec3) -> DVec3 {
        self.length * image.as_dvec3()
    }

    /// The images of a box by which a search without periods finds every pair that meets in this space: `found` is
    /// called with the box moved so that its lower corner is in the cell from 0 to `L`, and with that moved back by a
    /// period along every set of the axes where it reaches beyond that cell. Two boxes meet through a difference of -1,
    /// 0 or 1 periods along each axis, and of each axis one of the two reaches beyond.
    ///
    /// The boxes are wider than the given one by the rounding of the moves. One as wide as a period fills it.
    pub(crate) fn unfold(&self, aabb: &Aabb, mut found: impl FnMut(Aabb)) {
        let farthest = aabb.min.abs().max(aabb.max.abs());
        // Axes without a period are left as they are.
        let periodic = self.length.cmpgt(DVec3::ZERO);
        let slack = DVec3::select(periodic, ROUNDINGS * f64::EPSILON * (farthest + self.length), DVec3::ZERO);
        let (min, max) = (aabb.min - slack, aabb.max + slack);
        let moved = self.length * (min * self.inverse).floor();
        let (mut min, mut max) = (min - moved, max - moved);
        let fills = periodic & (max - min).cmpge(self.length);
        min = DVec3::select(fills, -slack, min);
        max = DVec3::select(fills, self.length + slack, max);
        let beyond = (periodic & max.cmpge(self.length) & !fills).bitmask();
        for axes in 0..8_u32 {
            if axes & !beyond == 0 {
                let back = DVec3::from_array([0, 1, 2].map(|axis| f64::from(axes >> axis & 1))) * self.length;
                found(Aabb { min: min - back, max: max - back });
            }
        }
    }
}

/// Roundings of the largest number that boxes are widened by before they are moved: a move takes four operations.
const ROUNDINGS: f64 = 8.0;
