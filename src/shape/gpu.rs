//! Shapes in WGSL: their tags, and the shape functions for a body's dynamics.

use super::Tag;
pub use super::superellipsoid::gpu::Exponents;
use crate::gpu::{Source, fragment};

/// Adds the tags of shapes: a constant for each kind that kernels support.
#[must_use]
pub(crate) fn add_tags_to(source: Source) -> Source {
    let constants = Tag::ALL.iter().filter_map(|tag| Some((tag.constant()?, *tag as u32)));
    source.constants("tags of shapes", constants)
}

/// Adds volumes, moments of inertia, drag lengths and growing lengths: the functions of `shaders/shape/shape.wgsl`.
#[must_use]
pub(crate) fn add_shapes_to(source: Source) -> Source {
    add_tags_to(source).include(fragment!("shape/shape.wgsl"))
}
