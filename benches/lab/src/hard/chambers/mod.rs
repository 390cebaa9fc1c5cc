//! Random growth chambers: channels that are closed below by a floor and open above, where cells leave. Each runs until
//! it has overflowed for two generations.

mod page;
mod run;

pub use page::{csv, page};
pub use run::{End, Row, run, run_all};

use super::start::{Random, body, rod};
use glam::{DQuat, DVec3};
use relcp::scene::{Growth, OnNoRoom, Removal, Scene, Stop, Time, Wall};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Streams of chambers come after those of all drawn scenes.
const FIRST_STREAM: u64 = 3 << 32;
/// Widths and heights, in diameters, which are 1.
const WIDTH: [f64; 2] = [5.0, 20.0];
const HEIGHT: [f64; 2] = [10.0, 20.0];
/// Tilts of a floor at most, in degrees, where it is not flat.
const MOST_TILT: f64 = 15.0;
/// Relative growth per time, and the length that a cell adds before it divides.
const RATE: f64 = 1.0;
const ADDED: f64 = 2.0;
/// Noises of both are from none to this.
const MOST_NOISE: f64 = 0.2;
/// Degrees by which daughters turn at most.
const MOST_TURN: f64 = 5.0;
/// Length of the founder.
const FOUNDER: f64 = 2.0;
/// How far above the floor the founder may be beside what its length takes.
const ABOVE: [f64; 2] = [0.05, 0.5];
/// Steps.
const DT: [f64; 2] = [5e-4, 5e-3];
/// Cells at which a run stops.
pub const POPULATION: u64 = 300;
/// The latest end: the largest chamber has room for some 150 cells and overflows before time 7.
const END: f64 = 12.0;
/// Generations for which a chamber overflows before its run ends.
const GENERATIONS: f64 = 2.0;

/// A chamber that was drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Chamber {
    /// Its number.
    pub number: u64,
    /// The distance of its sides.
    pub width: f64,
    /// The height at which cells leave.
    pub height: f64,
    /// The floor's angle, degrees.
    pub tilt: f64,
    /// The scene; its `time.end` is the latest end of the run.
    pub scene: Scene,
}

/// Chamber `number` of a seed. `stalls` changes `growth.on_no_room` and nothing else.
///
/// ```
/// use relcp_lab::hard::chambers::chamber;
/// let drawn = chamber(1, 3, false);
/// assert_eq!(drawn.scene.name, "chamber-1-3");
/// assert_eq!(drawn.scene.build()?.len(), 1);
/// # Ok::<(), relcp::scene::SceneError>(())
/// ```
pub fn chamber(seed: u64, number: u64, stalls: bool) -> Chamber {
    let mut random = Random::of_stream(seed, FIRST_STREAM + number);
    let random = &mut random;
    let width = random.within(WIDTH[0], WIDTH[1]);
    let width = random.either(0.5, width.round(), width);
    let tilt = random.within(-MOST_TILT, MOST_TILT);
    let tilt = random.either(0.5, 0.0, tilt);
    let height = random.within(HEIGHT[0], HEIGHT[1]);
    let on_no_room = if stalls { OnNoRoom::Stall } else { OnNoRoom::Stop };
    let growth = with!(on_no_room, ..growth(random));
    let (sin, cos) = tilt.to_radians().sin_cos();
    let half_space =
        |normal: [f64; 3], offset: f64| Wall::HalfSpace { normal, offset, motion: None, friction: None, load: None };
    let founder = founder(random, width, DVec3::new(-sin, cos, 0.0));
    let dt = random.log_within(DT[0], DT[1]);
    let scene = with!(
        seed: random.any(),
        planar: true,
        growth: vec![growth],
        walls: vec![
            Wall::Channel { normal: [1.0, 0.0, 0.0], center: [0.0; 3], width, motion: None, friction: None },
            half_space([-sin, cos, 0.0], 0.0),
        ],
        removal: vec![Removal::outside(half_space([0.0, -1.0, 0.0], -height))],
        bodies: vec![founder],
        ..Scene::new(format!("chamber-{seed}-{number}"), Time::new(dt, (END / dt).ceil() * dt))
    );
    Chamber { number, width, height, tilt, scene }
}

fn growth(random: &mut Random) -> Growth {
    with!(
        rate_noise: random.within(0.0, MOST_NOISE),
        added_length_noise: random.within(0.0, MOST_NOISE),
        reorientation_degrees: random.within(0.0, MOST_TURN),
        stop: Some(with!(population: Some(POPULATION), ..Stop::default())),
        ..Growth::adder(RATE, ADDED)
    )
}

/// Draws the founder near the floor, which passes through the origin, in a random orientation.
fn founder(random: &mut Random, width: f64, up: DVec3) -> relcp::scene::Body {
    let x = (0.5 * (width - FOUNDER)) * random.within(-0.95, 0.95);
    let above = 0.5 * FOUNDER + random.within(ABOVE[0], ABOVE[1]);
    let y = (above - x * up.x) / up.y;
    let turned = DQuat::from_rotation_z(TAU * random.within(0.0, 1.0)) * DQuat::from_rotation_y(FRAC_PI_2);
    body(rod(1.0, FOUNDER), [x, y, 0.0], turned.normalize())
}

/// The time for which a chamber overflows before its run ends.
fn overflowing() -> f64 {
    GENERATIONS * 2.0_f64.ln() / RATE
}

#[cfg(test)]
mod tests;
