//! Bonds as thin sticks from end to end.

use crate::bodies::{Bodies, HeldBond, NO_GROUP};
use crate::separation::Placed;
use crate::shape::Shape;
use glam::{DQuat, DVec3, Vec3};

/// The diameter of a stick over the thickness of the thinner of its bodies.
const DIAMETER: f64 = 0.3;
/// Its linear colour, a grey that no scale has.
pub(super) const COLOUR: Vec3 = Vec3::new(0.09, 0.09, 0.1);

/// Where a bond is drawn: its first end, the way to the second, and its diameter. None where both are one point.
pub(super) fn stick(bodies: &Bodies, bond: &HeldBond) -> Option<(DVec3, DVec3, f64)> {
    let (way, from) = bond.way(bodies);
    let thickness = |body: u32| bodies.shape[body as usize].thickness();
    let diameter = DIAMETER * bond.bodies.map(thickness).into_iter().fold(f64::INFINITY, f64::min);
    (way.is_finite() && way.length() > 0.0).then_some((from, way, diameter))
}

/// The bodies with a stick for each bond, and the colours of all; none where there are no bonds.
pub(super) fn added(bodies: &Bodies, colours: &[Vec3]) -> Option<(Bodies, Vec<Vec3>)> {
    if bodies.bonds.is_empty() {
        return None;
    }
    let (mut all, mut colours) = (bodies.clone(), colours.to_vec());
    for (from, way, diameter) in bodies.bonds.iter().filter_map(|bond| stick(bodies, bond)) {
        // A spherocylinder is at least as long as thick.
        let shape = Shape::Spherocylinder { diameter, length: way.length().max(diameter) };
        let orientation = DQuat::from_rotation_arc(DVec3::Z, way.normalize());
        all.push(Placed { shape, position: from + 0.5 * way, orientation }, NO_GROUP);
        colours.push(COLOUR);
    }
    Some((all, colours))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::{View, picture};

    /// Two balls far apart with a bond from centre to centre: a dark stick between them.
    #[test]
    fn a_bond_is_a_stick_between_its_ends() {
        let mut bodies = Bodies::default();
        for x in [-2.0, 2.0] {
            let shape = Shape::Sphere { radius: 0.5 };
            bodies.push(Placed { shape, position: DVec3::X * x, orientation: DQuat::IDENTITY }, NO_GROUP);
        }
        let view = View { width: 200, height: 80, planar: true, scale_bar: false, ..View::default() };
        assert_eq!(picture(&bodies, &view).pixel(100, 40), Some([255; 3]));
        let (at, force) = ([DVec3::ZERO; 2], DVec3::ZERO);
        let bond = HeldBond {
            number: 0,
            bodies: [0, 1],
            at,
            length: 4.0,
            force,
            torque: force,
            bending_energy: 0.0,
            contact: true,
        };
        bodies.bonds.push(bond);
        let [r, g, b] = picture(&bodies, &view).pixel(100, 40).unwrap();
        assert!(r < 140 && g < 140 && b < 140, "{r} {g} {b}");
        assert_eq!(picture(&bodies, &view).pixel(100, 10), Some([255; 3]));
    }
}
