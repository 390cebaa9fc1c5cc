//! Measures of states with known answers.

mod contacts;
mod groups;
mod motion;
mod order;
mod packing;
mod shear;
mod table;
mod wall_balances;
mod walls;

use super::*;
use crate::bodies::{Bodies, NO_GROUP};
use crate::record::{Snapshot, States};
use crate::separation::Placed;
use crate::shape::Shape;
use crate::warm::Warm;
use glam::{DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeSet;
use std::f64::consts::{E, FRAC_PI_2, PI, TAU};

const ROD: Shape = Shape::Spherocylinder { diameter: 1.0, length: 3.0 };

const BALL: Shape = Shape::Sphere { radius: 0.5 };

/// A rod's orientation at an angle in the plane.
fn lying(angle: f64) -> DQuat {
    DQuat::from_rotation_z(angle) * DQuat::from_rotation_y(FRAC_PI_2)
}

fn bodies(placed: impl IntoIterator<Item = (Shape, DVec3, DQuat)>) -> Bodies {
    let mut bodies = Bodies::default();
    for (shape, position, orientation) in placed {
        bodies.push(Placed { shape, position, orientation }, NO_GROUP);
    }
    bodies
}

fn state(bodies: Bodies, forces: Option<&[([u32; 2], f64)]>) -> Snapshot {
    let warm =
        |&(pair, gamma): &([u32; 2], f64)| Warm { pair, feature: 0, gamma, normal: DVec3::ZERO, tangent: DVec3::ZERO };
    Snapshot {
        step: 7,
        time: 0.7,
        bodies,
        warm: forces.map(|forces| forces.iter().map(warm).collect()),
        removed: Vec::new(),
        fields: Vec::new(),
    }
}

fn frame(planar: bool) -> Frame {
    Frame {
        planar,
        planar_from: "a test".into(),
        drag: Some(2.0.into()),
        shear: None,
        fixed: Default::default(),
        friction: None,
        walls: Vec::new(),
        group_names: Vec::new(),
        sub_spheres: false,
        growth: Vec::new(),
        removes: false,
    }
}

fn of_settings(name: &str, state: &Snapshot, planar: bool, settings: &Settings) -> Result<Found, LeftOut> {
    select(&[name.into()]).unwrap()[0].of(&View::new(state, &frame(planar), settings))
}

fn of(name: &str, state: &Snapshot, planar: bool) -> Found {
    of_settings(name, state, planar, &Settings::default()).unwrap()
}

#[track_caller]
fn value(found: &Found, measure: &str, column: &str) -> Cell {
    let measure = ALL.iter().find(|m| m.name() == measure).unwrap();
    found.values[measure.columns().iter().position(|c| c.name == column).unwrap()]
}

#[track_caller]
fn assert_near(found: Cell, expected: f64, tolerance: f64) {
    let found = found.unwrap();
    assert!((found - expected).abs() <= tolerance, "{found} is not {expected} to {tolerance}");
}

fn square(side: usize, shape: Shape, orientation: impl Fn(usize) -> DQuat) -> Bodies {
    let place = |k: usize| DVec3::new((k % side) as f64, (k / side) as f64, 0.0);
    bodies((0..side * side).map(|k| (shape, place(k), orientation(k))))
}
