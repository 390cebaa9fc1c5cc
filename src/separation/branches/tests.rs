//! Branches of poses with known answers, and properties of all poses.

use super::*;
use crate::shape::Shape;
use glam::DQuat;

#[test]
fn an_end_has_the_same_separation_by_its_number() {
    let rod = |length: f64, x: f64, turn: f64| Placed {
        shape: Shape::Spherocylinder { diameter: 0.5, length },
        position: DVec3::new(x, 0.2 * x, 0.1),
        orientation: DQuat::from_rotation_x(turn) * DQuat::from_rotation_z(0.3),
    };
    let mut ends = 0;
    for turn in [0.0, 0.01, 0.4, 1.2] {
        let (a, b) = (rod(2.0, 0.0, 0.0), rod(3.0, 0.7, turn));
        let nearest = crate::separation::separation(&a, &b, None).unwrap();
        branches(&a, &b, &nearest, f64::INFINITY, |feature, found| match separation_at(&a, &b, feature) {
            Some(separation) => {
                assert!((separation - found.separation).abs() < 1e-14, "{turn} {feature}");
                ends += 1;
            }
            None => assert_eq!(feature, WHOLE),
        });
    }
    assert!(ends >= 12, "{ends}");
}

/// For linked rings under tension, in many poses: the nearest minimum is the pair's separation, and a minimum has the
/// same number for every slack.
#[test]
fn two_rings_have_a_branch_for_each_minimum() {
    let ring = |major_radius: f64, position: DVec3, orientation: DQuat| Placed {
        shape: Shape::Torus { major_radius, minor_radius: 0.1 },
        position,
        orientation,
    };
    let mut several = 0;
    for k in 0..200 {
        let t = f64::from(k);
        let (turn, tilt) = (DQuat::from_rotation_x(1.3 * t.sin()), DQuat::from_rotation_z(0.7 * t));
        let radius = if k % 3 == 0 { 1.0 } else { 0.7 + 0.6 * (0.3 * t).sin().abs() };
        let a = ring(1.0, DVec3::ZERO, tilt);
        let b = ring(radius, DVec3::new(0.6 + radius, 0.1 * t.cos(), 0.05), turn * tilt);
        let nearest = crate::separation::separation(&a, &b, None).unwrap();
        let found = |slack: f64| {
            let mut all = Vec::new();
            branches(&a, &b, &nearest, slack, |feature, found| all.push((feature, found.separation)));
            all
        };
        let all = found(0.1);
        let least = all.iter().map(|(_, separation)| *separation).fold(f64::INFINITY, f64::min);
        assert!((least - nearest.separation).abs() < 1e-12, "{k}: {least} {nearest:?}");
        assert!(all.iter().all(|(feature, _)| place_of_branch(*feature).is_some()), "{k}: {all:?}");
        for (feature, separation) in &all {
            let wanted = branch(&a, &b, &nearest, *feature);
            assert_eq!(wanted.separation, *separation, "{k}");
        }
        for part in [found(0.0), found(0.03)] {
            assert!(!part.is_empty() && part.iter().all(|one| all.contains(one)), "{k}: {part:?} of {all:?}");
        }
        several += usize::from(all.len() > 1);
    }
    assert!(several > 20, "{several}");
}

#[test]
fn a_rod_across_a_ring_touches_it_twice() {
    let torus = Shape::Torus { major_radius: 1.0, minor_radius: 0.1 };
    let ring = Placed { shape: torus, position: DVec3::ZERO, orientation: DQuat::IDENTITY };
    for tilt in [0.0, 0.01, -0.02] {
        let rod = Placed {
            shape: Shape::Spherocylinder { diameter: 0.4, length: 3.0 },
            position: DVec3::new(0.1, 0.2, 0.3),
            orientation: DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2 + tilt),
        };
        for (a, b) in [(ring, rod), (rod, ring)] {
            let nearest = crate::separation::separation(&a, &b, None).unwrap();
            let mut found = Vec::new();
            branches(&a, &b, &nearest, 0.2, |feature, found_there| found.push((feature, found_there)));
            assert_eq!(found.len(), 2, "{tilt}: {found:?}");
            let least = found.iter().map(|(_, there)| there.separation).fold(f64::INFINITY, f64::min);
            assert_eq!(least, nearest.separation);
            let [one, two] = [found[0].1, found[1].1].map(|there| a.position + there.lever_a);
            assert!((one - two).length() > 1.5, "{one} {two}");
            assert_eq!(branch(&a, &b, &nearest, found[1].0).separation, found[1].1.separation);
        }
    }
}

/// If the rod's point nearest to the axis is its end, both pieces of the search have that end.
#[test]
fn an_end_of_a_rod_at_a_ring_counts_once() {
    let torus = Shape::Torus { major_radius: 1.0, minor_radius: 0.1 };
    let ring = Placed { shape: torus, position: DVec3::ZERO, orientation: DQuat::IDENTITY };
    for x in [1.6, 2.0, -1.7] {
        let rod = Placed {
            shape: Shape::Spherocylinder { diameter: 0.4, length: 1.0 },
            position: DVec3::new(x, 0.1, 0.2),
            orientation: DQuat::from_rotation_y(1.4),
        };
        let nearest = crate::separation::separation(&ring, &rod, None).unwrap();
        let mut found = Vec::new();
        branches(&ring, &rod, &nearest, 1.0, |feature, there| found.push((feature, there.separation)));
        assert_eq!(found.len(), 1, "{x}: {found:?}");
        assert_eq!(found[0].1, nearest.separation);
    }
}

#[test]
fn every_branch_has_a_place_of_its_own() {
    for place in 0..BRANCHES {
        assert!(is_branch(branch_in_place(place)));
        assert_eq!(place_of_branch(branch_in_place(place)), Some(place));
    }
    assert_eq!([3, BRANCH | 4, u32::MAX].map(place_of_branch), [None; 3]);
}
