//! Colonies that fill a confined space (channels, discs, boxes and cups) until there is no room.

use super::{Drawn, draw};
use crate::hard::start::{Random, body, rod};
use glam::{DQuat, DVec3};
use relcp::scene::{Body, Growth, OnNoRoom, Scene, SceneError, Stop, Time, Wall};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Streams of colonies come after those of any other scene.
const FIRST_STREAM: u64 = 1 << 32;
/// Diameter of a cell.
const DIAMETER: f64 = 0.5;
/// Lengths at which cells divide, in diameters.
const DIVISION: [f64; 2] = [4.0, 8.0];
/// Widths, in diameters.
const WIDTH: [f64; 2] = [2.0, 12.0];
/// The factor by which discs and boxes are wider: the largest have room for some hundred cells.
const CLOSED: f64 = 2.0;
/// Widths of discs and boxes at least, in diameters: the founder is in them however it lies.
const LEAST_CLOSED: f64 = 5.0;
/// The same in lengths at which cells divide: those with the greatest length of their own fit too.
const LEAST_IN_LENGTHS: f64 = 1.3;
/// Steps, two thirds of a decade to either side of those that colonies are usually run at.
const DT: [f64; 2] = [5e-4, 1e-2];
/// Relative growth rate.
const RATE: [f64; 2] = [0.7, 1.4];
/// Noises are from none to this.
const MOST_NOISE: f64 = 0.2;
/// Degrees by which daughters turn at most.
const MOST_TURN: f64 = 10.0;
/// Sensitivities to pressure.
const SENSITIVITY: [f64; 2] = [1e-3, 0.1];
/// Cells at which a run stops.
pub const POPULATION: u64 = 500;
/// The run time relative to an unpressed colony that grows to as many cells: pressure slows growth.
const PATIENCE: f64 = 1.5;
/// Steps at most: an unpressed colony takes as many at the slowest growth and the shortest step.
const MOST_STEPS: f64 = 20_000.0;

/// Confined colony `number` of a seed.
///
/// ```
/// use relcp_lab::hard::random::confined;
/// assert_eq!(confined(1, 3)?.scene.name, "confined-1-3");
/// # Ok::<(), relcp::scene::SceneError>(())
/// ```
///
/// # Errors
/// As [`random`](super::random()).
pub fn confined(seed: u64, number: u64) -> Result<Drawn, SceneError> {
    let name = format!("confined-{seed}-{number}");
    draw(Random::of_stream(seed, FIRST_STREAM + number), |random| attempt(random, name.clone()))
}

fn attempt(random: &mut Random, name: String) -> Drawn {
    let division = random.within(DIVISION[0], DIVISION[1]) * DIAMETER;
    // Half of the widths are whole numbers of diameters: rows of cells then fit exactly.
    let width = random.within(WIDTH[0], WIDTH[1]);
    let width = DIAMETER * random.either(0.5, width.round(), width);
    let (walls, founder, what, width) = space(random, width, division);
    let growth = growth(random, division);
    let dt = random.log_within(DT[0], DT[1]);
    let alone = (2.0 * POPULATION as f64).ln() / growth.rate;
    let steps = (PATIENCE * alone / dt).ceil().min(MOST_STEPS);
    let scene = with!(
        seed: random.any(),
        planar: true,
        growth: vec![growth.clone()],
        walls,
        bodies: vec![founder],
        ..Scene::new(name, Time::new(dt, steps * dt))
    );
    let what = format!(
        "{what}, {:.2} diameters wide, dt {dt:.1e}, noise of lengths {:.2}, of rates {:.2}, turns to {:.0} degrees{}",
        width / DIAMETER,
        growth.division_length_noise,
        growth.rate_noise,
        growth.reorientation_degrees,
        if growth.stress_sensitivity > 0.0 { ", slowed by pressure" } else { "" }
    );
    Drawn { what, scene }
}

fn growth(random: &mut Random, division_length: f64) -> Growth {
    let noise = |random: &mut Random| {
        let drawn = random.within(0.0, MOST_NOISE);
        random.either(0.75, drawn, 0.0)
    };
    let turn = random.within(0.0, MOST_TURN);
    let sensitivity = random.log_within(SENSITIVITY[0], SENSITIVITY[1]);
    with!(
        rate: random.within(RATE[0], RATE[1]),
        division_length: Some(division_length),
        reorientation_degrees: random.either(0.8, turn, 0.0),
        division_length_noise: noise(random),
        rate_noise: noise(random),
        stress_sensitivity: random.either(0.2, sensitivity, 0.0),
        stop: Some(with!(population: Some(POPULATION), ..Stop::default())),
        on_no_room: OnNoRoom::Stop,
        ..Growth::new(0.0, 0.0)
    )
}

/// A space of a width, a founder in it, what they are, and the width, which of closed spaces is at least what a cell
/// needs.
fn space(random: &mut Random, width: f64, division: f64) -> (Vec<Wall>, Body, &'static str, f64) {
    let length = random.within(0.5, 0.95) * division;
    let angle = TAU * random.within(0.0, 1.0);
    let angle = random.either(0.5, 0.0, angle);
    let (lying, half_length) = (random.within(-0.1, 0.1), random.within(1.0, 6.0) * division);
    let founder = |turn: f64| {
        let turned = DQuat::from_rotation_z(turn) * DQuat::from_rotation_y(FRAC_PI_2);
        body(rod(DIAMETER, length), [0.0; 3], turned.normalize())
    };
    let closed = (CLOSED * width).max(LEAST_CLOSED * DIAMETER).max(LEAST_IN_LENGTHS * division);
    let along = DVec3::new(angle.cos(), angle.sin(), 0.0);
    let across = DVec3::new(-angle.sin(), angle.cos(), 0.0);
    let channel = Wall::Channel { normal: across.to_array(), center: [0.0; 3], width, motion: None, friction: None };
    let end = |normal: DVec3| Wall::HalfSpace {
        normal: normal.to_array(),
        offset: -half_length,
        motion: None,
        friction: None,
        load: None,
    };
    // In a narrow channel the founder lies along it.
    let most = (width - DIAMETER) / length;
    let lying = lying.clamp(-most, most);
    match random.below(6) {
        0 | 1 => (vec![channel], founder(angle + lying), "a channel", width),
        2 => (vec![channel, end(along)], founder(angle + lying), "a cup", width),
        3 => (vec![channel, end(along), end(-along)], founder(angle + lying), "a short closed channel", width),
        4 => {
            let wall = Wall::Sphere { center: [0.0; 3], radius: 0.5 * closed, motion: None, friction: None };
            (vec![wall], founder(angle + lying), "a disc", closed)
        }
        _ => {
            let (w, h) = (0.5 * closed, 0.5 * closed * random.within(1.0, 3.0));
            let wall = Wall::Box { minimum: [-w, -h, -1.0], maximum: [w, h, 1.0], motion: None, friction: None };
            (vec![wall], founder(angle + lying), "a box", closed)
        }
    }
}
