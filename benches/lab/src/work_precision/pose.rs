//! The final poses of the bodies of a scene, and the distance between two such ends.
//!
//! Bodies are matched by id. Only the line of the body's z axis counts in an orientation. Every shape here is a body of
//! revolution about this axis with a perpendicular plane of symmetry, so a spin about the axis and an end-for-end turn
//! leave the surface unchanged and do not count.

use glam::{DQuat, DVec3};
use relcp::bodies::Bodies;
use serde::{Deserialize, Serialize};

/// The pose of a body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pose {
    /// The body's id.
    pub id: u64,
    /// Its centre.
    pub position: [f64; 3],
    /// `[w, x, y, z]`, as in a scene.
    pub orientation: [f64; 4],
}

impl Pose {
    fn axis(&self) -> DVec3 {
        let [w, x, y, z] = self.orientation;
        DQuat::from_xyzw(x, y, z, w) * DVec3::Z
    }
}

/// The bodies' poses, by their ids.
pub fn poses(bodies: &Bodies) -> Vec<Pose> {
    let pose = |i: usize| {
        let DQuat { x, y, z, w } = bodies.orientation[i];
        Pose { id: bodies.lineage[i].id, position: bodies.position[i].to_array(), orientation: [w, x, y, z] }
    };
    let mut poses: Vec<Pose> = (0..bodies.len()).map(pose).collect();
    poses.sort_by_key(|pose| pose.id);
    poses
}

/// The distance between two ends: root mean squares over the bodies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Apart {
    /// Root mean square of the distances of their centres, divided by the scene's length.
    pub position: f64,
    /// Root mean square of the angles between their axes, radians.
    pub angle: f64,
}

impl Apart {
    /// Returns the larger of the two, which is called the error.
    pub fn worst(&self) -> f64 {
        self.position.max(self.angle)
    }
}

/// Returns the distance between two ends for the scene's `length`, or `None` if their bodies differ.
pub fn apart(a: &[Pose], b: &[Pose], length: f64) -> Option<Apart> {
    if a.len() != b.len() || a.iter().zip(b).any(|(a, b)| a.id != b.id) {
        return None;
    }
    let mut squares = [0.0; 2];
    for (a, b) in a.iter().zip(b) {
        let between = DVec3::from_array(a.position) - DVec3::from_array(b.position);
        squares[0] += between.length_squared() / (length * length);
        squares[1] += angle(a.axis(), b.axis()).powi(2);
    }
    let [position, angle] = squares.map(|sum| (sum / a.len().max(1) as f64).sqrt());
    Some(Apart { position, angle })
}

/// Returns the angle between two lines. The formula also uses the sine, because the cosine alone cannot resolve angles
/// under 1e-8.
fn angle(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b).abs())
}

/// The limit of ends that converge at first order, from those at a step and at half of it (Richardson); `None` if their
/// bodies differ. Axes are extrapolated as vectors.
pub fn limit(coarse: &[Pose], fine: &[Pose]) -> Option<Vec<Pose>> {
    if coarse.len() != fine.len() || coarse.iter().zip(fine).any(|(a, b)| a.id != b.id) {
        return None;
    }
    let pose = |(coarse, fine): (&Pose, &Pose)| {
        let ahead = |coarse: DVec3, fine: DVec3| fine + (fine - coarse);
        let position = ahead(DVec3::from_array(coarse.position), DVec3::from_array(fine.position));
        let (from, to) = (coarse.axis(), fine.axis());
        let axis = ahead(from * from.dot(to).signum(), to).normalize();
        let [w, x, y, z] = fine.orientation;
        let DQuat { x, y, z, w } = DQuat::from_rotation_arc(to, axis) * DQuat::from_xyzw(x, y, z, w);
        Pose { id: fine.id, position: position.to_array(), orientation: [w, x, y, z] }
    };
    Some(coarse.iter().zip(fine).map(pose).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use relcp::bodies::NO_GROUP;
    use relcp::separation::Placed;
    use relcp::shape::Shape;

    fn pose(id: u64, x: f64, turn: f64) -> Pose {
        let DQuat { x: i, y: j, z: k, w } = DQuat::from_rotation_y(turn);
        Pose { id, position: [x, 0.0, 0.0], orientation: [w, i, j, k] }
    }

    #[test]
    fn ends_are_apart_by_root_mean_squares() {
        let a = [pose(0, 1.0, 0.3), pose(3, -1.0, 0.0)];
        let b = [pose(0, 1.6, 0.3 + 3e-9), pose(3, -1.0, 0.0)];
        let found = apart(&a, &b, 2.0).unwrap();
        assert!((found.position - 0.3 / 2f64.sqrt()).abs() < 1e-15 && found.worst() == found.position);
        assert!((found.angle / (3e-9 / 2f64.sqrt()) - 1.0).abs() < 1e-6, "{found:?}");
        // End for end, and spun about its own axis: the same surface.
        let spun = |pose: &Pose| {
            let [w, x, y, z] = pose.orientation;
            let turned = DQuat::from_xyzw(x, y, z, w) * DQuat::from_rotation_x(std::f64::consts::PI);
            let DQuat { x, y, z, w } = turned * DQuat::from_rotation_z(0.7);
            Pose { orientation: [w, x, y, z], ..*pose }
        };
        assert!(apart(&a, &a.each_ref().map(spun), 2.0).unwrap().worst() < 1e-15);
        assert_eq!(apart(&a, &b[..1], 2.0), None);
        assert_eq!(apart(&a, &[pose(0, 1.0, 0.3), pose(4, -1.0, 0.0)], 2.0), None);
    }

    #[test]
    fn the_limit_of_known_sequences() {
        let end = |dt: f64| vec![pose(5, 2.0 - 0.7 * dt, 0.4 + 0.2 * dt)];
        let found = limit(&end(1e-3), &end(5e-4)).unwrap();
        let away = apart(&found, &end(0.0), 1.0).unwrap();
        assert!(away.position < 1e-15 && away.angle < 1e-7, "{away:?}");
        assert!(apart(&end(5e-4), &end(0.0), 1.0).unwrap().angle > 9e-5);
        assert_eq!(limit(&end(1e-3), &[]), None);
    }

    #[test]
    fn poses_are_in_the_order_of_their_ids() {
        let mut bodies = Bodies::default();
        for x in [1.0, 2.0] {
            let shape = Shape::Sphere { radius: 1.0 };
            let orientation = DQuat::from_rotation_z(x);
            bodies.push(Placed { shape, position: DVec3::X * x, orientation }, NO_GROUP);
        }
        bodies.lineage[0].id = 9;
        let found = poses(&bodies);
        assert_eq!(found.iter().map(|pose| (pose.id, pose.position[0])).collect::<Vec<_>>(), [(1, 2.0), (9, 1.0)]);
        assert_eq!(found[0].orientation, [1f64.cos(), 0.0, 0.0, 1f64.sin()]);
    }
}
