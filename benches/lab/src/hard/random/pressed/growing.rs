//! Cells that grow in chambers and out of them: traps closed below and open above, with flat and tilted floors, funnels
//! that widen and narrow, and flat chambers in space.

use super::super::Drawn;
use super::super::room;
use crate::hard::start::{Random, body, rod};
use glam::{DQuat, DVec3};
use relcp::scene::{Body, Growth, OnNoRoom, Removal, Scene, Stop, Time, Wall};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Widths and heights, in diameters, which are 1.
const WIDTH: [f64; 2] = [3.0, 9.0];
const HEIGHT: [f64; 2] = [4.0, 9.0];
/// Tilts of floors and of the sides of funnels at most, in degrees.
const MOST_TILT: f64 = 20.0;
/// The mouth of a funnel at least, in diameters.
const LEAST_MOUTH: f64 = 1.5;
/// Steps.
const DT: [f64; 2] = [1e-3, 1e-2];
/// Relative growth rate.
const RATE: [f64; 2] = [0.7, 1.4];
/// Noises are from none to this.
const MOST_NOISE: f64 = 0.2;
/// Degrees by which daughters turn at most.
const MOST_TURN: f64 = 5.0;
/// Cells at which a run stops.
const POPULATION: u64 = 150;
/// Generations of a run: a chamber of some 30 cells is full after five, and overflows for two or three.
const GENERATIONS: [f64; 2] = [5.0, 8.0];

pub(super) fn draw(random: &mut Random, name: &str) -> Drawn {
    let width = random.within(WIDTH[0], WIDTH[1]);
    let width = random.either(0.5, width.round(), width);
    let height = random.within(HEIGHT[0], HEIGHT[1]);
    let (walls, what) = chamber(random, width, height);
    let flat = random.chance(0.15);
    let lid = random.either(0.5, 1.0, 1.3);
    let lid = flat.then(|| room::channel(DVec3::Z, lid));
    let growth = growth(random);
    let dt = random.log_within(DT[0], DT[1]);
    let time = random.within(GENERATIONS[0], GENERATIONS[1]) * 2.0_f64.ln() / growth.rate;
    let top = Wall::HalfSpace { normal: [0.0, -1.0, 0.0], offset: -height, motion: None, friction: None, load: None };
    let stalls = growth.on_no_room == OnNoRoom::Stall;
    let scene = with!(
        seed: random.any(),
        planar: !flat,
        growth: vec![growth],
        walls: walls.into_iter().chain(lid).collect(),
        removal: vec![Removal::outside(top)],
        bodies: vec![founder(random, height)],
        ..Scene::new(name, Time::new(dt, (time / dt).ceil() * dt))
    );
    let what = format!(
        "a colony in {what} {width:.2} wide and {height:.2} high, dt {dt:.1e}{}{}",
        if flat { ", flat in space" } else { "" },
        if stalls { ", and stalls" } else { "" }
    );
    Drawn { what, scene }
}

/// Walls with y upwards, open above.
fn chamber(random: &mut Random, width: f64, height: f64) -> (Vec<Wall>, &'static str) {
    let tilt = MOST_TILT.to_radians() * random.within(-1.0, 1.0);
    let floor = |tilt: f64| room::floor(DVec3::new(-tilt.sin(), tilt.cos(), 0.0), 0.0);
    let upright = room::channel(DVec3::X, width);
    // Sides that lean by an angle, in where it is positive, as wide apart as is said where they meet the floor.
    let leaning = |lean: f64| {
        [1.0, -1.0].map(|side| room::floor(DVec3::new(side * lean.cos(), -lean.sin(), 0.0), 0.5 * width * lean.cos()))
    };
    match random.below(5) {
        0 => (vec![upright, floor(0.0)], "a trap"),
        1 => (vec![upright, floor(tilt)], "a trap with a tilted floor"),
        2 => {
            let most = (0.5 * (width - LEAST_MOUTH) / height).max(0.0).atan();
            let sides = leaning(tilt.abs().min(most));
            (sides.into_iter().chain([floor(0.0)]).collect(), "a funnel that narrows")
        }
        3 => (leaning(-tilt.abs()).into_iter().chain([floor(0.0)]).collect(), "a funnel that widens"),
        // A corner that stands on its tip.
        _ => {
            let lean = TAU / 8.0 + tilt;
            (vec![floor(lean), floor(lean - TAU / 4.0)], "a corner")
        }
    }
}

fn growth(random: &mut Random) -> Growth {
    let noise = |random: &mut Random| {
        let drawn = random.within(0.0, MOST_NOISE);
        random.either(0.75, drawn, 0.0)
    };
    let turn = random.within(0.0, MOST_TURN);
    let rate = random.within(RATE[0], RATE[1]);
    let (added, length) = (random.within(1.2, 2.0), random.within(2.5, 4.0));
    let (adder, sizer) = (Growth::adder(rate, added), Growth::new(rate, length));
    let noisy = noise(random);
    let growth =
        random.either(0.5, with!(added_length_noise: noisy, ..adder), with!(division_length_noise: noisy, ..sizer));
    with!(
        reorientation_degrees: random.either(0.8, turn, 0.0),
        rate_noise: noise(random),
        on_no_room: random.either(0.3, OnNoRoom::Stall, OnNoRoom::Stop),
        stop: Some(with!(population: Some(POPULATION), ..Stop::default())),
        ..growth
    )
}

/// A cell at half the height, which every chamber has room for.
fn founder(random: &mut Random, height: f64) -> Body {
    let turned = DQuat::from_rotation_z(TAU * random.within(0.0, 1.0)) * DQuat::from_rotation_y(FRAC_PI_2);
    body(rod(1.0, random.within(1.2, 2.0)), [0.0, 0.5 * height, 0.0], turned.normalize())
}
