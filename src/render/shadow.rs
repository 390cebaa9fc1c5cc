//! Cast shadows: the bodies as the main light sees them (Williams, "Casting curved shadows on curved surfaces", 1978),
//! sampled at a few positions around a point, which softens the edge (Reeves, Salesin and Cook, 1987).

use super::camera::Camera;
use super::raster::{SUPERSAMPLING, Samples};
use crate::bodies::Bodies;
use glam::{DVec3, Vec2};

/// The largest side of the light's own picture in pixels: a quarter of a GiB.
const LARGEST_SIDE: u32 = 2048;
/// Half the width of a shadow's soft edge, in median thicknesses of bodies; and the minimum in samples.
const SOFTNESS: f32 = 0.10;
const LEAST_SOFTNESS: f32 = 1.5;
/// A point is sampled this many softnesses above its surface, so that the surface does not shade itself in grazing
/// light.
const LIFT: f32 = 1.5;
/// The sample positions around a point; each ray of a pixel rotates them by its part of a quarter turn.
const PLACES: [Vec2; 4] = [Vec2::new(0.9, 0.2), Vec2::new(-0.15, 0.65), Vec2::new(-0.6, -0.1), Vec2::new(0.25, -0.95)];

/// The shadow map of the main light.
pub(super) struct Shadow {
    samples: Samples,
    camera: Camera,
    /// Half the width of the soft edge in samples.
    softness: f32,
}

impl Shadow {
    /// The shadows of light from the direction of the unit vector `light`; `thickness` is the median of bodies, and
    /// `side` the side of the light's own picture in pixels.
    ///
    /// # Errors
    /// The error of `cast`, which casts the rays of that picture.
    pub fn cast<E>(
        bodies: &Bodies,
        light: DVec3,
        thickness: f64,
        side: u32,
        cast: impl Fn(&Bodies, &Camera, u32, u32) -> Result<Samples, E>,
    ) -> Result<Shadow, E> {
        let side = side.clamp(1, LARGEST_SIDE);
        let right = light.any_orthonormal_vector();
        let camera = Camera::along([right, light.cross(right), light], [side; 2], bodies);
        let samples = cast(bodies, &camera, side, side)?;
        let softness = SOFTNESS * (thickness * camera.pixels_per_length()) as f32 * SUPERSAMPLING as f32;
        Ok(Shadow { samples, camera, softness: softness.max(LEAST_SOFTNESS) })
    }

    /// The part of the main light, from 0 to 1, that reaches a point with this normal. `ray` is the index of the ray in
    /// its pixel.
    pub fn lit(&self, point: DVec3, normal: DVec3, ray: usize) -> f32 {
        let samples_per_length = self.camera.pixels_per_length() * SUPERSAMPLING as f64;
        let lift = f64::from(LIFT * self.softness) / samples_per_length;
        let seen = self.camera.to_view(point + normal * lift - self.camera.centre);
        let turn = Vec2::from_angle(ray as f32 * std::f32::consts::FRAC_PI_8) * self.softness;
        let x = self.samples.width as f32 / 2.0 + (seen.x * samples_per_length) as f32;
        let y = self.samples.height as f32 / 2.0 - (seen.y * samples_per_length) as f32;
        let dark = PLACES.iter().filter(|place| {
            let at = turn.rotate(**place);
            self.samples.near((x + at.x) as isize, (y + at.y) as isize).height > seen.z as f32
        });
        1.0 - dark.count() as f32 / PLACES.len() as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bodies::NO_GROUP;
    use crate::render::on_cpu;
    use crate::separation::Placed;
    use crate::shape::Shape;
    use glam::DQuat;

    fn balls(balls: &[(f64, DVec3)]) -> Bodies {
        let mut bodies = Bodies::default();
        for &(radius, position) in balls {
            let shape = Shape::Sphere { radius };
            bodies.push(Placed { shape, position, orientation: DQuat::IDENTITY }, NO_GROUP);
        }
        bodies
    }

    #[test]
    fn a_body_shades_what_is_behind_it_and_nothing_else() {
        for light in [DVec3::Z, DVec3::new(0.6, 0.0, 0.8), DVec3::new(-0.48, 0.64, 0.6)] {
            let shadow = Shadow::cast(&balls(&[(3.0, DVec3::ZERO), (1.0, light * 6.0)]), light, 2.0, 600, on_cpu);
            let Ok(shadow) = shadow;
            let side = light.any_orthonormal_vector();
            for ray in 0..4 {
                for across in [-2.0, -1.5, -0.5, 0.0, 0.5, 1.5, 2.0_f64] {
                    let point = side * across + light * (9.0 - across * across).sqrt();
                    let lit = shadow.lit(point, point / 3.0, ray);
                    assert_eq!(lit, if across.abs() < 1.0 { 0.0 } else { 1.0 }, "{light} {across} {ray}");
                }
                assert_eq!(shadow.lit(light * 7.0, light, ray), 1.0);
            }
        }
    }

    #[test]
    fn a_lone_body_does_not_shade_its_lit_side() {
        for radius in [0.01, 1.0, 50.0] {
            let shadow = Shadow::cast(&balls(&[(radius, DVec3::ONE)]), DVec3::Z, 2.0 * radius, 600, on_cpu);
            let Ok(shadow) = shadow;
            for k in 0..=400 {
                let slope = k as f64 / 400.0 * 1.4;
                for turn in [0.0, 1.0, 2.0, 4.0] {
                    let normal = DVec3::new(slope.sin() * f64::cos(turn), slope.sin() * f64::sin(turn), slope.cos());
                    assert_eq!(shadow.lit(DVec3::ONE + normal * radius, normal, k % 4), 1.0, "{radius} {slope} {turn}");
                }
            }
        }
    }
}
