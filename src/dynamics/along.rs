//! What acts on a body's vectors along its own axes: factors, and roots of mobilities.

use crate::freedom::{pack, unpack};
use glam::{DMat3, DQuat, DVec3};

/// A factor of a body's vectors: the same in all directions, or another along each of its axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Along {
    /// In all directions.
    Even(f64),
    /// Along x, y and z of the body.
    Axes(DVec3),
}

impl Along {
    /// This factor of a vector, space axes.
    pub fn of(&self, orientation: DQuat, v: DVec3) -> DVec3 {
        match *self {
            Along::Even(factor) => factor * v,
            Along::Axes(factors) => along_axes(orientation, factors, v),
        }
    }

    /// The factor by axis.
    pub fn axes(&self) -> DVec3 {
        match *self {
            Along::Even(factor) => DVec3::splat(factor),
            Along::Axes(factors) => factors,
        }
    }

    /// Another factor made of this one, and of the same of `with`.
    pub fn with(&self, with: impl Fn(f64) -> f64) -> Along {
        match *self {
            Along::Even(factor) => Along::Even(with(factor)),
            Along::Axes(factors) => Along::Axes(factors.map(with)),
        }
    }

    /// The product of a vector with its image.
    pub fn square(&self, orientation: DQuat, v: DVec3) -> f64 {
        match *self {
            Along::Even(factor) => factor * v.length_squared(),
            Along::Axes(factors) => {
                let v = orientation.conjugate() * v;
                (factors * v).dot(v)
            }
        }
    }

    /// The least one.
    pub fn least(&self) -> f64 {
        self.axes().min_element()
    }

    /// The largest one.
    pub fn largest(&self) -> f64 {
        self.axes().max_element()
    }

    /// As the root of a mobility at an orientation.
    pub fn root(&self, orientation: DQuat) -> Root {
        match *self {
            Along::Even(factor) => Root::Even(factor),
            Along::Axes(factors) => Root::Axes(about(orientation, factors)),
        }
    }
}

/// A vector, space axes, by these factors along the body's axes.
pub fn along_axes(orientation: DQuat, factors: DVec3, v: DVec3) -> DVec3 {
    let axes = DMat3::from_quat(orientation);
    axes * (factors * (axes.transpose() * v))
}

/// The matrix with these values along the body's axes.
pub fn about(orientation: DQuat, values: DVec3) -> DMat3 {
    let axes = DMat3::from_quat(orientation);
    axes * DMat3::from_diagonal(values) * axes.transpose()
}

/// The root of a translational mobility.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Root {
    /// The same in all directions.
    Even(f64),
    /// A symmetric matrix, space axes.
    Axes(DMat3),
}

impl Root {
    /// `scale` times this of a vector.
    #[inline]
    pub fn times(&self, scale: f64, v: DVec3) -> DVec3 {
        match *self {
            Root::Even(root) => scale * root * v,
            Root::Axes(root) => root * (scale * v),
        }
    }

    /// This of a vector of the unknowns of one body, over `scale`. What a planar scene does not carry stays zero.
    #[inline]
    pub fn over<const D: usize>(&self, scale: f64, v: DVec3) -> DVec3 {
        match *self {
            Root::Even(root) => root / scale * v,
            Root::Axes(root) => unpack::<D>(&pack(root * v / scale, DVec3::ZERO)).0,
        }
    }

    /// The product of `a` with what this makes `b` of.
    pub fn between(&self, a: DVec3, b: DVec3) -> f64 {
        match *self {
            Root::Even(root) => a.dot(b) / root,
            Root::Axes(root) => a.dot(root.inverse() * b),
        }
    }

    /// The mean mobility over all directions.
    pub fn mean_square(&self) -> f64 {
        match *self {
            Root::Even(root) => root * root,
            Root::Axes(root) => {
                (root.x_axis.length_squared() + root.y_axis.length_squared() + root.z_axis.length_squared()) / 3.0
            }
        }
    }
}
