//! The forces of a scene as fields.

use super::{Force, ForceField, Load, Window, pushing};
use crate::bodies::Bodies;
use crate::dynamics::Dynamics;
use glam::{BVec3, DVec3};

/// These forces as fields. `groups` are the names of the groups, by index.
pub fn force_fields(forces: &[Force], groups: &[String], dynamics: &Dynamics) -> Vec<Box<dyn ForceField>> {
    forces.iter().map(|force| Box::new(Field::new(force, groups, dynamics)) as Box<dyn ForceField>).collect()
}

/// A force of a scene.
struct Field {
    force: Force,
    /// The group that it acts on; the name may be one that no body has.
    only: Option<Option<u32>>,
    /// Zero without inertia: bodies have no mass then, and validation refuses a scene that needs one.
    density: f64,
}

impl Field {
    fn new(force: &Force, groups: &[String], dynamics: &Dynamics) -> Field {
        let number = |name: &str| groups.iter().zip(0..).find(|(group, _)| *group == name).map(|(_, number)| number);
        Field { force: force.clone(), only: force.group().map(number), density: dynamics.density().unwrap_or(0.0) }
    }

    fn on(&self, bodies: &Bodies, i: usize) -> Load {
        match &self.force {
            Force::Gravity { acceleration, .. } => {
                pushing(self.density * bodies.shape[i].volume() * DVec3::from(*acceleration))
            }
            Force::RadialInward { .. } => pushing(-radial(bodies.position[i])),
            Force::RadialOutward { .. } => pushing(radial(bodies.position[i])),
            Force::Trap { stiffness, center, axes, .. } => {
                let away = bodies.periods.nearest(bodies.position[i] - DVec3::from(*center));
                pushing(-*stiffness * DVec3::select(BVec3::from_array(*axes), away, DVec3::ZERO))
            }
            Force::Pull { .. } => pulled(&self.force, bodies, i),
            force => force.everywhere(bodies.orientation[i]).unwrap_or_default(),
        }
    }
}

impl ForceField for Field {
    fn load(&self, bodies: &Bodies, i: usize, _time: f64) -> Load {
        let applies = self.only.is_none_or(|group| group == Some(bodies.group[i]));
        if applies { self.on(bodies, i) } else { Load::default() }
    }

    fn share(&self, span: [f64; 2]) -> f64 {
        self.force.window().map_or(1.0, |window: &Window| window.share(span))
    }
}

/// The load of a pull on body `i`.
fn pulled(force: &Force, bodies: &Bodies, i: usize) -> Load {
    let Force::Pull { body, target, stiffness, point, most, damping, .. } = *force else { return Load::default() };
    if bodies.lineage[i].id != body {
        return Load::default();
    }
    let lever = bodies.orientation[i] * DVec3::from(point);
    let way = bodies.periods.nearest(DVec3::from(target) - (bodies.position[i] + lever));
    let spring = (stiffness * way).clamp_length_max(most.unwrap_or(f64::INFINITY));
    let load = Load {
        force: spring - damping.map_or(DVec3::ZERO, |damping| damping * bodies.velocity[i]),
        torque: lever.cross(spring),
    };
    if bodies.planar { load.in_plane() } else { load }
}

/// Below this radius `(r - sin r) / r^2` is summed as its series, which the difference would lose: at 0.1 the first
/// term left out is 1e-12 of the value, and the difference keeps 13 digits.
const SERIES_RADIUS: f64 = 0.1;

/// `x (|x| - sin |x|) / |x|^2`, the paper's radial field; zero at the origin.
fn radial(x: DVec3) -> DVec3 {
    let r = x.length();
    if r < SERIES_RADIUS {
        let s = r * r;
        return x * r * (1.0 / 6.0 - s / 120.0 * (1.0 - s / 42.0 * (1.0 - s / 72.0)));
    }
    x * ((r - r.sin()) / (r * r))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn radial_field_is_continuous_where_the_series_takes_over() {
        let below = radial(DVec3::X * (SERIES_RADIUS - 1e-13));
        let above = radial(DVec3::X * (SERIES_RADIUS + 1e-13));
        assert!((below - above).length() < 1e-13, "{below} {above}");
        assert_eq!(radial(DVec3::ZERO), DVec3::ZERO);
        let far = radial(DVec3::new(0.0, 0.0, 100.0));
        assert!((far.z - (100.0 - 100f64.sin()) / 100.0).abs() < 1e-15);
    }
}
