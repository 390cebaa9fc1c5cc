//! Fixed rods along a line of points, which share the ends of their axes; a single point is a ball.

use super::super::orientation::along;
use super::Fence;
use super::copied::{copies, offsets};
use crate::bodies::Bodies;
use crate::separation::Placed;
use crate::shape::Shape;
use glam::{DQuat, DVec3};

impl Fence {
    /// The ends of each rod's axis; of a post, its point twice.
    pub(in super::super) fn segments(&self) -> Vec<[DVec3; 2]> {
        let point = |i: usize| DVec3::from(self.points[i % self.points.len()]);
        let rods = match self.points.len() {
            0 => 0,
            1 => return vec![[point(0); 2]],
            count if self.closed => count,
            count => count - 1,
        };
        (0..rods).map(|i| [point(i), point(i + 1)]).collect()
    }

    fn shape(&self, [from, to]: [DVec3; 2]) -> Shape {
        let (diameter, span) = (self.diameter, from.distance(to));
        if self.points.len() == 1 {
            return Shape::Sphere { radius: 0.5 * diameter };
        }
        Shape::Spherocylinder { diameter, length: span + diameter }
    }

    /// The number of bodies of each shape: each segment of the line, with its copies.
    pub(in super::super) fn components(&self) -> Vec<(u64, Shape)> {
        let copies = copies(&self.repeat);
        self.segments().into_iter().map(|ends| (copies, self.shape(ends))).collect()
    }

    /// The farthest coordinate of an end.
    pub(in super::super) fn farthest(&self) -> f64 {
        let points = self.points.iter().flatten().fold(0.0_f64, |most, x| most.max(x.abs()));
        points + super::copied::farthest(&self.repeat)
    }
}

/// Places all copies of each rod in turn. `groups` has the group of each segment.
pub(super) fn add(fence: &Fence, bodies: &mut Bodies, groups: &[u32]) {
    let offsets = offsets(&fence.repeat);
    for (ends, group) in fence.segments().into_iter().zip(groups) {
        let [from, to] = ends;
        let (shape, way) = (fence.shape(ends), to - from);
        let orientation = if way == DVec3::ZERO { DQuat::IDENTITY } else { along(way) };
        for offset in &offsets {
            let position = 0.5 * (from + to) + *offset;
            bodies.push(Placed { shape, position, orientation }, *group);
        }
    }
}
