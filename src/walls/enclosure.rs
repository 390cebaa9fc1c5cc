//! Whether walls leave a way to infinity.
//!
//! Every surface has bodies on its convex side, so the space that walls leave is convex, and it is unlimited exactly
//! where it has a direction in which one may go for ever: its recession cone (R. T. Rockafellar, Convex Analysis, 1970,
//! section 8). If there is one, then there is one along the axis of a cylinder, at right angles to two planes, to one,
//! or, without planes, along any axis.

use crate::separation::Surface;
use glam::DVec3;

/// A direction that leads towards a plane by no more than this leads along it.
const ALONG: f64 = 1e-9;

/// Whether no body can leave: surfaces, and pairs of planes at right angles to `closed` axes, as periods and the plane
/// of a planar scene are, leave no direction to go for ever.
pub(super) fn is_closed(surfaces: &[Surface], closed: &[DVec3]) -> bool {
    let mut normals: Vec<DVec3> = closed.iter().flat_map(|axis| [*axis, -*axis]).collect();
    let mut along: Option<DVec3> = None;
    for surface in surfaces {
        match *surface {
            Surface::Plane { normal, .. } => normals.push(normal),
            Surface::Sphere { .. } => return true,
            Surface::Cylinder { axis, .. } if along.is_some_and(|other| other.cross(axis).length() > ALONG) => {
                return true;
            }
            Surface::Cylinder { axis, .. } => along = Some(axis),
        }
    }
    let is_open = |direction: DVec3| normals.iter().all(|normal| normal.dot(direction) >= -ALONG);
    !directions(&normals, along).into_iter().any(|direction| is_open(direction) || is_open(-direction))
}

/// The directions that are tried, both ways.
fn directions(normals: &[DVec3], along: Option<DVec3>) -> Vec<DVec3> {
    if let Some(axis) = along {
        return vec![axis];
    }
    let pairs = normals.iter().enumerate().flat_map(|(i, a)| normals[..i].iter().map(|b| a.cross(*b)));
    let single = normals.iter().flat_map(|normal| <[DVec3; 2]>::from(normal.any_orthonormal_pair()));
    pairs.filter(|line| line.length() > ALONG).map(DVec3::normalize).chain(single).chain(DVec3::AXES).collect()
}

#[cfg(test)]
mod tests {
    use super::super::{Wall, Walls};
    use super::*;

    fn closed(walls: &str, planar: bool) -> bool {
        let walls: Vec<Wall> = serde_json::from_str(walls).unwrap();
        let plane = [DVec3::Z];
        is_closed(Walls::new(&walls, planar).surfaces(), if planar { &plane } else { &[] })
    }

    #[test]
    fn containers_are_closed_and_what_has_an_opening_is_not() {
        let sphere = r#"{"sphere": {"center": [1, 2, 0], "radius": 3}}"#;
        let boxed = r#"{"box": {"minimum": [0, 0, -1], "maximum": [2, 3, 1]}}"#;
        let tube = r#"{"cylinder": {"center": [0, 0, 0], "axis": [0.2, -0.1, 1], "radius": 6.5}}"#;
        let capped = r#"{"cylinder": {"center": [0, 0, 0], "axis": [0.2, -0.1, 1], "radius": 6.5, "length": 13}}"#;
        let disc = r#"{"cylinder": {"center": [0, 0, 0], "axis": [0, 0, 1], "radius": 6.5}}"#;
        let crossed = r#"{"cylinder": {"center": [0, 0, 0], "axis": [1, 0, 0], "radius": 6.5}}"#;
        let channel = r#"{"channel": {"center": [0, 0, 0], "normal": [0.3, 1, 0], "width": 2}}"#;
        let end = r#"{"half_space": {"normal": [1, -0.3, 0], "offset": -4}}"#;
        let other_end = r#"{"half_space": {"normal": [-1, 0.4, 0], "offset": -4}}"#;
        let floor = r#"{"half_space": {"normal": [0, 0, 1], "offset": 0}}"#;
        for (walls, in_plane, in_space) in [
            (vec![], false, false),
            (vec![sphere], true, true),
            (vec![boxed], true, true),
            (vec![disc], true, false),
            (vec![tube], false, false),
            (vec![tube, floor], false, false),
            (vec![tube, disc], true, true),
            (vec![disc, crossed], true, true),
            (vec![capped], true, true),
            (vec![channel], false, false),
            (vec![channel, end], false, false),
            (vec![channel, end, other_end], true, false),
            (vec![floor], false, false),
        ] {
            let text = format!("[{}]", walls.join(", "));
            // A tilted tube is no wall of a planar scene.
            if !text.contains("-0.1") {
                assert_eq!(closed(&text, true), in_plane, "in the plane: {text}");
            }
            assert_eq!(closed(&text, false), in_space, "in space: {text}");
        }
    }

    #[test]
    fn periods_close_a_channel() {
        let walls: Vec<Wall> =
            serde_json::from_str(r#"[{"channel": {"center": [0, 0, 0], "normal": [0, 1, 0], "width": 2}}]"#).unwrap();
        let surfaces = Walls::new(&walls, true).surfaces().to_vec();
        assert!(is_closed(&surfaces, &[DVec3::Z, DVec3::X]));
        assert!(!is_closed(&surfaces, &[DVec3::Z, DVec3::Y]));
        assert!(is_closed(&[], &DVec3::AXES));
    }
}
