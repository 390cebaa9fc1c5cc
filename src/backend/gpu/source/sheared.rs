//! The fragments that kernels of a sheared cell replace. In such a cell, images across the gradient move.

use super::base;
use crate::backend::gpu::Setup;
use crate::gpu::{Source, fragment};

/// The kernel for the poses to which the flow of a changing cell leads bodies.
pub(in crate::backend::gpu) fn carried(setup: &Setup) -> Source {
    let source = base(setup, "carried").include(fragment!("dynamics/carried.wgsl"));
    let Some(shear) = setup.shear() else { return source };
    let strained = "parameters.strain * position";
    let (direction, gradient) = (shear.direction.unit().to_array(), shear.gradient.unit().to_array());
    source
        .mapped(|text| text.replace(strained, "SHEAR_RATE * dot(position, SHEAR_GRADIENT) * SHEAR_DIRECTION"))
        .real("SHEAR_RATE", shear.rate)
        .vector("SHEAR_DIRECTION", direction)
        .vector("SHEAR_GRADIENT", gradient)
}

/// A kernel of pairs whose bodies have the relative velocity `between`. In a sheared cell, the velocity of the nearest
/// image is added.
pub(in crate::backend::gpu) fn beside_images(setup: &Setup, source: Source, between: &str) -> Source {
    let Some(shear) = setup.shear() else { return source };
    let (of_image, gone) = (format!("({between} + image_velocity(a, b))"), source.code().matches(between).count());
    debug_assert_eq!(gone, 1, "{between}");
    source
        .mapped(|text| text.replace(between, &of_image))
        .real("SHEAR_RATE", shear.rate)
        .include(fragment!("dynamics/image_velocity.wgsl"))
}
