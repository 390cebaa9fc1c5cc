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
//!
//! In a sheared cell the images across the gradient axis are displaced along the direction by `s = g t L`, kept within
//! half a period (A. W. Lees, S. F. Edwards, J. Phys. C 5, 1921 (1972)). Space is the same under the translations `(s,
//! L)` and `(L_d, 0)`: one more period in `s` changes nothing. The nearest image is found across the gradient first,
//! then along the direction.

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
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema), serde(deny_unknown_fields))]
#[non_exhaustive]
pub struct Periodic {
    /// The period along x, y and z; null for an open axis, such as z in a planar scene.
    pub lengths: [Option<f64>; 3],
    /// The engineering strain rates along x, y and z, one over time, of a cell whose lengths change: at a time `t` they
    /// are `lengths (1 + strain_rate t)`. The matching flow carries bodies. Along an open axis it is 0.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub strain_rate: Option<[f64; 3]>,
    /// A steady simple shear of the cell: Lees-Edwards boundaries. The matching shear flow carries bodies.
    #[cfg_attr(feature = "files", serde(default, skip_serializing_if = "Option::is_none"))]
    pub shear: Option<CellShear>,
}

/// An axis of space.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema), serde(rename_all = "snake_case"))]
pub enum Axis {
    /// The first axis.
    X,
    /// The second axis.
    Y,
    /// The third axis.
    Z,
}

impl Axis {
    /// Its place among the axes.
    pub const fn index(self) -> usize {
        self as usize
    }

    /// Its unit vector.
    pub const fn unit(self) -> DVec3 {
        [DVec3::X, DVec3::Y, DVec3::Z][self as usize]
    }
}

/// A steady simple shear of a periodic cell: at the time `t` an image one period `L` farther along the gradient is
/// `rate t L` farther along the direction, and faster by `rate L`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema), serde(deny_unknown_fields))]
#[non_exhaustive]
pub struct CellShear {
    /// The shear rate, one over time; of either sign.
    pub rate: f64,
    /// The axis that images move along; it has a period.
    pub direction: Axis,
    /// The axis along which their velocity grows; a later one, with a period.
    pub gradient: Axis,
}

impl CellShear {
    /// This shear.
    pub const fn new(rate: f64, direction: Axis, gradient: Axis) -> CellShear {
        CellShear { rate, direction, gradient }
    }

    /// The velocity of its flow at a place, or what that differs by over a distance.
    pub fn velocity(&self, x: DVec3) -> DVec3 {
        self.rate * x[self.gradient.index()] * self.direction.unit()
    }
}

impl Periodic {
    /// These periods along x, y and z; `None` where space is open.
    pub const fn new(lengths: [Option<f64>; 3]) -> Periodic {
        Periodic { lengths, strain_rate: None, shear: None }
    }

    /// Whether the cell changes in time.
    pub(crate) fn changes(&self) -> bool {
        self.strain_rate.is_some() || self.shear.is_some()
    }

    /// What each length at `time` is of that at time 0.
    fn stretch(&self, time: f64) -> [f64; 3] {
        self.strain_rate.map_or([1.0; 3], |rates| rates.map(|rate| 1.0 + rate * time))
    }

    /// The periods at `time`.
    pub(crate) fn at(&self, time: f64) -> Periods {
        let stretch = self.stretch(time);
        let periods = Periods::new(std::array::from_fn(|axis| self.lengths[axis].map(|length| length * stretch[axis])));
        let Some(CellShear { rate, direction, gradient }) = self.shear else { return periods };
        periods.tilted(Tilt { direction, gradient, offset: rate * time * periods.length[gradient.index()] })
    }

    /// The rates at which the lengths change at `time`, over the lengths then.
    pub(crate) fn rates(&self, time: f64) -> DVec3 {
        let (rates, stretch) = (self.strain_rate.unwrap_or_default(), self.stretch(time));
        DVec3::from(rates) / DVec3::from(stretch)
    }
}

/// By how much the images across one axis of a periodic space are displaced along another.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(Serialize, Deserialize, JsonSchema), serde(deny_unknown_fields))]
pub struct Tilt {
    /// Along which the images one period farther along the gradient are displaced.
    pub direction: Axis,
    /// Across which they are.
    pub gradient: Axis,
    /// By what, a length; at most half a period along the direction, of either sign.
    pub offset: f64,
}

/// The period along each axis, and the places of the axes of a tilt with its offset.
type AxesAndTilt = ([Option<f64>; 3], Option<([usize; 2], f64)>);

/// The translations under which a periodic space is the same: those by whole lengths along the axes, of which one may
/// be tilted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Periods {
    /// Period along each axis, 0 for an open axis.
    length: DVec3,
    /// Its inverse, zero where there is none.
    inverse: DVec3,
    /// In a sheared cell; also where the offset is zero now.
    tilt: Option<Tilt>,
}

impl Periods {
    /// No periods.
    pub const NONE: Periods = Periods { length: DVec3::ZERO, inverse: DVec3::ZERO, tilt: None };

    /// These periods; a number that is not a positive length is none.
    pub fn new(lengths: [Option<f64>; 3]) -> Periods {
        let length = lengths.map(|length| length.filter(|l| *l > 0.0 && l.is_finite()).unwrap_or(0.0));
        let inverse = length.map(|length| if length > 0.0 { 1.0 / length } else { 0.0 });
        Periods { length: length.into(), inverse: inverse.into(), tilt: None }
    }

    /// The same space tilted: with the offset less whole periods along its direction. Where one of both axes has no
    /// period, or the offset is not finite, it is none.
    ///
    /// ```
    /// use glam::DVec3;
    /// use relcp::periodic::{Axis, Periods, Tilt};
    /// let tilt = Tilt { direction: Axis::X, gradient: Axis::Y, offset: 5.0 };
    /// let periods = Periods::new([Some(4.0), Some(3.0), None]).tilted(tilt);
    /// assert_eq!(periods.tilt().unwrap().offset, 1.0);
    /// assert_eq!(periods.nearest(DVec3::new(1.25, 3.0, 0.0)), DVec3::new(0.25, 0.0, 0.0));
    /// ```
    #[must_use]
    pub fn tilted(self, Tilt { direction, gradient, offset }: Tilt) -> Periods {
        let along = self.length[direction.index()];
        let has_both = along > 0.0 && self.length[gradient.index()] > 0.0 && direction != gradient;
        if !has_both || !offset.is_finite() {
            return self;
        }
        // One that is kept within half a period already keeps its bits, as a state that is read does.
        let half = 0.5 * along;
        let kept = if offset.abs() <= half { offset } else { offset - along * (offset / along).round() };
        let offset = kept.clamp(-half, half);
        Periods { tilt: Some(Tilt { direction, gradient, offset }), ..self }
    }

    /// The tilt of a sheared cell.
    pub fn tilt(&self) -> Option<Tilt> {
        self.tilt
    }

    /// Whether no axis has a period.
    #[inline]
    pub fn is_none(&self) -> bool {
        self.length == DVec3::ZERO
    }

    /// The period along each axis, and the offset of a sheared cell with the places of its direction and gradient.
    #[doc(hidden)]
    pub fn numbers(&self) -> AxesAndTilt {
        let numbers = |tilt: Tilt| ([tilt.direction.index(), tilt.gradient.index()], tilt.offset);
        (self.lengths(), self.tilt.map(numbers))
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
        let farthest = DVec3::select(self.length.cmpgt(DVec3::ZERO), x.abs(), DVec3::ZERO).max_element();
        match self.tilt {
            None => farthest,
            Some(tilt) => {
                farthest.max((x[tilt.gradient.index()] * self.inverse[tilt.gradient.index()] * tilt.offset).abs())
            }
        }
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
        if self.is_none() {
            delta
        } else if let Some(tilt) = self.tilt {
            self.reduced(tilt, delta, |x| x.round()).0
        } else {
            delta - self.length * self.cell(delta)
        }
    }

    /// The periods by which what is at the distance `delta` is moved to its nearest image.
    pub fn nearest_image(&self, delta: DVec3) -> I64Vec3 {
        match self.tilt {
            Some(tilt) => -self.reduced(tilt, delta, |x| x.round()).1.as_i64vec3(),
            None => -self.cell(delta).as_i64vec3(),
        }
    }

    /// `x` less the periods that `whole` makes of its parts of them, and these: across the gradient first, then along
    /// the other axes.
    #[inline]
    fn reduced(&self, tilt: Tilt, x: DVec3, whole: impl Fn(DVec3) -> DVec3) -> (DVec3, DVec3) {
        let Tilt { direction, gradient, offset } = tilt;
        let across = whole(x * self.inverse) * gradient.unit();
        let x = x - self.length * across - offset * across[gradient.index()] * direction.unit();
        let along = whole(x * self.inverse) * (DVec3::ONE - gradient.unit());
        (x - self.length * along, across + along)
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
        if let Some(tilt) = self.tilt {
            let (position, image) = self.reduced(tilt, position, |x| (x + 0.5).floor());
            return (position, image.as_i64vec3());
        }
        let image = (position * self.inverse + 0.5).floor();
        (position - self.length * image, image.as_i64vec3())
    }

    /// As [`Periods::wrapped`], of a sheared cell into the parallelepiped of its edges that is centred on the origin,
    /// as programs have it that know of triclinic boxes.
    #[cfg(feature = "files")]
    pub(crate) fn wrapped_into_edges(&self, position: DVec3) -> (DVec3, I64Vec3) {
        let Some(Tilt { direction, gradient, offset }) = self.tilt else { return self.wrapped(position) };
        let (place, image) = self.wrapped(position);
        let (along, across) = (direction.index(), gradient.index());
        let leaning = place[across] * self.inverse[across] * offset;
        let more = ((place[along] - leaning) * self.inverse[along] + 0.5).floor() * direction.unit();
        (place - self.length * more, image + more.as_i64vec3())
    }

    /// The offsets xy, xz and yz of a sheared cell's edges, as programs have them that know of triclinic boxes.
    #[cfg(feature = "files")]
    pub(crate) fn tilts(&self) -> Option<[f64; 3]> {
        let Tilt { direction, gradient, offset } = self.tilt?;
        let axes = [(Axis::X, Axis::Y), (Axis::X, Axis::Z), (Axis::Y, Axis::Z)];
        Some(axes.map(|axes| if axes == (direction, gradient) { offset } else { 0.0 }))
    }

    /// The images of `b` whose boxes share a point with `a`, faces counted, as the first and the last number of periods
    /// that it is moved by along each axis. In a sheared cell `found` is called for each number across the gradient.
    #[doc(hidden)]
    pub fn images(&self, a: &Aabb, b: &Aabb, mut found: impl FnMut([I64Vec3; 2])) {
        let Some(Tilt { direction, gradient, offset }) = self.tilt else {
            return self.images_of(a, b).into_iter().for_each(found);
        };
        let across = gradient.index();
        let untilted = Periods { tilt: None, ..*self };
        let length = self.length[across];
        let first = ((a.min[across] - b.max[across]) / length).ceil();
        let last = ((a.max[across] - b.min[across]) / length).floor();
        // Not a number is no image.
        if first.is_nan() || last.is_nan() {
            return;
        }
        for n in first as i64..=last as i64 {
            let moved = offset * n as f64 * direction.unit();
            let there = Aabb { min: b.min + moved, max: b.max + moved };
            if let Some([mut first, mut last]) = untilted.images_of(a, &there) {
                (first[across], last[across]) = (n, n);
                found([first, last]);
            }
        }
    }

    /// The same without a tilt; none where they share none.
    fn images_of(&self, a: &Aabb, b: &Aabb) -> Option<[I64Vec3; 2]> {
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
        if self.is_none() {
            return a.touches(b);
        }
        if self.tilt.is_none() {
            return self.images_of(a, b).is_some();
        }
        let mut touches = false;
        self.images(a, b, |_| touches = true);
        touches
    }

    /// The distance that an image is moved by.
    pub fn shift(&self, image: I64Vec3) -> DVec3 {
        let image = image.as_dvec3();
        match self.tilt {
            None => self.length * image,
            Some(tilt) => self.length * image + image[tilt.gradient.index()] * tilt.offset * tilt.direction.unit(),
        }
    }

    /// The images of a box by which a search without periods finds every pair that meets in this space: `found` is
    /// called with the box moved so that its lower corner is in the cell from 0 to `L`, and with that moved back by a
    /// period along every set of the axes where it reaches beyond that cell. Two boxes meet through a difference of -1,
    /// 0 or 1 periods along each axis, and of each axis one of the two reaches beyond.
    ///
    /// The boxes are wider than the given one by the rounding of the moves. One as wide as a period fills it.
    ///
    /// In a sheared cell a box that reaches beyond the side across the gradient goes back by a period there, with its
    /// offset, and from where that leads it is unfolded along the other axes: of two boxes that meet through that side
    /// the one that reaches beyond it is then where the other is, but for periods along those axes.
    pub(crate) fn unfold(&self, aabb: &Aabb, mut found: impl FnMut(Aabb)) {
        let Some(Tilt { direction, gradient, offset }) = self.tilt else { return self.unfold_along_axes(aabb, found) };
        let (across, along) = (gradient.index(), direction.index());
        let others = self.only(|axis| axis != across);
        let middle = 0.5 * (aabb.min[across] + aabb.max[across]);
        self.only(|axis| axis == across).unfold_along_axes(aabb, |mut image| {
            // The periods that it was moved by, and with each of them the offset.
            let n = ((0.5 * (image.min[across] + image.max[across]) - middle) * self.inverse[across]).round();
            let fills = aabb.max[across] - aabb.min[across] >= self.length[across];
            let (moved, slack) = (n * offset, ROUNDINGS * f64::EPSILON * (n * offset).abs());
            image.min[along] += moved - slack;
            image.max[along] += moved + slack;
            if fills {
                // It meets what is anywhere along the direction, through some image.
                (image.min[along], image.max[along]) = (0.0, self.length[along]);
            }
            others.unfold_along_axes(&image, &mut found);
        });
    }

    /// These periods along some axes, without a tilt.
    fn only(&self, along: impl Fn(usize) -> bool) -> Periods {
        let kept = |of: DVec3| DVec3::from_array(std::array::from_fn(|axis| if along(axis) { of[axis] } else { 0.0 }));
        Periods { length: kept(self.length), inverse: kept(self.inverse), tilt: None }
    }

    fn unfold_along_axes(&self, aabb: &Aabb, mut found: impl FnMut(Aabb)) {
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
