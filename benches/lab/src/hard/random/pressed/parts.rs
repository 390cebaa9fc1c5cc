//! Common parts of pressed scenes: the speed at which spaces close, moving walls, and the misalignment of bodies.

use super::super::drive;
use crate::hard::start::Random;
use glam::{DQuat, DVec3};
use relcp::scene::{Dynamics, Scene, Stepping, Time, Wall, WallMotion, Window};
use std::f64::consts::FRAC_PI_2;

/// The range of the distance that a space closes by in a step, in thicknesses of the bodies.
const STEP: [f64; 2] = [1e-4, 0.05];
/// Steps of a scene.
const STEPS: [f64; 2] = [20.0, 400.0];
/// The largest product of steps and bodies.
const BODY_STEPS: f64 = 6000.0;
/// The probability that bodies are exactly in line.
const IN_LINE: f64 = 0.4;
/// The range of the misalignment otherwise, relative to their size.
const OUT_OF_LINE: [f64; 2] = [1e-9, 3e-2];

/// The speed and the duration of the closing of a space.
#[derive(Clone, Copy, Debug)]
pub(super) struct Closing {
    pub(super) dt: f64,
    pub(super) steps: f64,
    pub(super) speed: f64,
    /// The time at which it stops.
    pub(super) end: f64,
}

impl Closing {
    /// By `way` in all where there is time for it, in steps that each close by a part of `thickness`.
    pub(super) fn draw(random: &mut Random, way: f64, thickness: f64, bodies: usize) -> Closing {
        let dt = random.log_within(drive::DT[0], drive::DT[1]);
        let step = random.log_within(STEP[0], STEP[1]) * thickness;
        let most = STEPS[1].min(BODY_STEPS / bodies.max(1) as f64);
        // A few further steps without motion.
        let steps = (way / step + STEPS[0]).ceil().min(most);
        Closing { dt, steps, speed: step / dt, end: way / step * dt }
    }

    /// A half space, `away` from the origin, that closes along its normal.
    pub(super) fn wall(&self, normal: DVec3, away: f64) -> Wall {
        let velocity = (self.speed * normal).to_array();
        let motion = Some(with!(window: Some(Window::between(0.0, self.end)), ..WallMotion::new(velocity)));
        Wall::HalfSpace { normal: normal.to_array(), offset: -away, motion, friction: None, load: None }
    }
}

/// Returns a scene without bodies and walls, with its law, stepping and settings, and a description of them.
pub(super) fn scene(
    random: &mut Random,
    name: &str,
    planar: bool,
    closing: &Closing,
    thinnest: f64,
) -> (Scene, String) {
    let (contact, solver, settings) = drive::settings(random, thinnest);
    let time = with!(stepping: drive::stepping(random), ..Time::new(closing.dt, closing.steps * closing.dt));
    let dynamics = drive::dynamics(random);
    let scene = with!(seed: random.any(), dynamics, contact, solver, planar, ..Scene::new(name, time));
    (scene, settings)
}

/// Returns the description of a scene, from its contents and the description of its kind.
pub(super) fn described(scene: &Scene, what: &str, driven: &str, settings: &str) -> String {
    let space = if scene.planar { "planar" } else { "spatial" };
    let law = if matches!(scene.dynamics, Dynamics::Overdamped { .. }) { "overdamped" } else { "inertial" };
    let midpoint = if scene.time.stepping == Stepping::Midpoint { ", midpoint" } else { "" };
    let said = [driven, settings].into_iter().filter(|said| !said.is_empty()).map(|said| format!(", {said}"));
    format!("{space}, {law}{midpoint}, dt {:.1e}, {what}{}", scene.time.dt, said.collect::<String>()).to_lowercase()
}

/// The body's z along a unit vector, in a planar scene one of the plane.
pub(super) fn along(way: DVec3, planar: bool) -> DQuat {
    match planar {
        true => DQuat::from_rotation_z(way.y.atan2(way.x)) * DQuat::from_rotation_y(FRAC_PI_2),
        false => DQuat::from_rotation_arc(DVec3::Z, way),
    }
    .normalize()
}

/// Draws the misalignment of bodies, relative to their size; zero if they are in line.
pub(super) fn misalignment(random: &mut Random) -> f64 {
    let out = random.log_within(OUT_OF_LINE[0], OUT_OF_LINE[1]);
    random.either(IN_LINE, 0.0, out)
}

/// A turn by up to `most` radians, about z where the scene is planar.
pub(super) fn turn(random: &mut Random, most: f64, planar: bool) -> DQuat {
    let about = if planar { DVec3::Z } else { random.direction() };
    DQuat::from_axis_angle(about, random.within(-most, most))
}

/// Describes the misalignment of bodies.
pub(super) fn out_of_line(misalignment: f64) -> String {
    if misalignment > 0.0 { format!("{misalignment:.0e} out of line") } else { "in line".into() }
}
