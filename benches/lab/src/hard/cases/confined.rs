//! Colonies that grow in confined spaces until the spaces are full, and bodies in spaces that they fit exactly.
//!
//! Cells have the diameter 0.5, so a channel of 4 is eight diameters wide: rows of cells fit exactly, and then a step
//! may have no solution.

use super::Case;
use crate::hard::start::{Start, body, ellipsoid, rod, sphere, upright};
use glam::{DQuat, DVec3};
use relcp::scene::{Body, Dynamics, Force, Growth, OnNoRoom, Periodic, Stepping, Wall};
use std::f64::consts::FRAC_PI_2;

const DIAMETER: f64 = 0.5;

pub(super) fn cases() -> Vec<Case> {
    [channels(), closed(), others(), exact()].concat()
}

/// The default growth of cells.
const GROWTH: Growth = {
    let mut growth = EVEN;
    growth.reorientation_degrees = 4.0;
    growth.division_length_noise = 0.1;
    growth.rate_noise = 0.1;
    growth
};
/// Equal growth of all cells: cells in line stay in line.
const EVEN: Growth = Growth::new(0.9, 3.0);

fn cell(length: f64, position: [f64; 3], turn: f64) -> Body {
    let turned = DQuat::from_rotation_z(turn) * DQuat::from_rotation_y(FRAC_PI_2);
    body(rod(DIAMETER, length), position, turned.normalize())
}

/// A planar colony of one cell along x.
fn colony(dt: f64, growth: Growth, walls: Vec<Wall>) -> Start {
    let mut start = Start::still(dt, vec![cell(1.5, [0.0; 3], 0.0)]);
    start.scene.planar = true;
    start.scene.growth = vec![growth];
    start.scene.walls = walls;
    start
}

fn case(name: impl Into<String>, steps: u64, start: Start) -> Case {
    let mut case = Case::contact("confined", name, steps, start);
    // Half a step before its last one's end: as many steps, whatever is rounded.
    case.start.scene.time.end = (steps as f64 - 0.5) * case.start.scene.time.dt;
    case
}

fn channel(width: f64) -> Wall {
    Wall::Channel { normal: [0.0, 1.0, 0.0], center: [0.0; 3], width, motion: None, friction: None }
}

fn side(normal: [f64; 3], away: f64) -> Wall {
    Wall::HalfSpace { normal, offset: -away, motion: None, friction: None, load: None }
}

fn disc(radius: f64) -> Wall {
    Wall::Sphere { center: [0.0; 3], radius, motion: None, friction: None }
}

fn cube(half: [f64; 3]) -> Wall {
    Wall::Box { minimum: half.map(|x| -x), maximum: half, motion: None, friction: None }
}

fn channels() -> Vec<Case> {
    let of = |width: f64, dt: f64, steps: u64| {
        let name = format!("colony in a channel of {} diameters, dt {dt}", width / DIAMETER);
        case(name, steps, colony(dt, GROWTH, vec![channel(width)]))
    };
    let slow = with!(rate: 0.7, ..GROWTH);
    let mut fine = colony(0.005, GROWTH, vec![channel(4.0)]);
    fine.scene.contact.overlap_tolerance = 1e-3;
    let mut half = colony(0.01, GROWTH, vec![channel(4.0)]);
    half.scene.time.stepping = Stepping::Midpoint;
    let tilted = Wall::Channel { normal: [-0.3, 1.0, 0.0], center: [0.0; 3], width: 3.0, motion: None, friction: None };
    vec![
        of(4.0, 0.002, 2700),
        of(3.0, 0.004, 1350),
        of(3.5, 0.004, 1350),
        of(5.0, 0.005, 1100),
        of(4.0, 0.01, 560),
        of(1.0, 0.01, 500),
        // In a single file, both walls touched, nothing can turn.
        of(0.5, 0.01, 420),
        case("colony in a channel of 8 diameters, slower", 1380, colony(0.005, slow, vec![channel(4.0)])),
        case("colony in a channel of 8 diameters, tolerance 1e-3", 1080, fine),
        case("colony in a channel of 8 diameters, midpoint", 560, half),
        case("colony in a channel of 4 diameters, all cells alike", 500, colony(0.01, EVEN, vec![channel(2.0)])),
        case("colony in a tilted channel", 560, colony(0.01, GROWTH, vec![tilted])),
    ]
}

fn closed() -> Vec<Case> {
    let felt = with!(rate: 1.0, stress_sensitivity: 0.01, ..GROWTH);
    let stalls = with!(on_no_room: OnNoRoom::Stall, ..GROWTH);
    let box_of = |half: [f64; 2]| cube([half[0], half[1], 1.0]);
    let of = |name: &str, dt: f64, steps: u64, growth: Growth, walls: &[Wall]| {
        case(format!("colony fills {name}"), steps, colony(dt, growth, walls.to_vec()))
    };
    let short = [channel(2.0), side([1.0, 0.0, 0.0], 3.0), side([-1.0, 0.0, 0.0], 3.0)];
    vec![
        of("a disc of 24 diameters, slowed by pressure", 0.005, 1200, felt, &[disc(6.0)]),
        of("a disc of 8 diameters", 0.005, 900, GROWTH, &[disc(2.0)]),
        of("a disc of 8 diameters, all cells alike", 0.005, 900, EVEN, &[disc(2.0)]),
        of("a box of 12 by 12 diameters", 0.005, 900, GROWTH, &[box_of([3.0, 3.0])]),
        of("a box of 8 by 4 diameters, all cells alike", 0.01, 400, EVEN, &[box_of([2.0, 1.0])]),
        of("a closed channel", 0.005, 800, GROWTH, &short),
        of("a disc of 8 diameters, and stalls", 0.01, 500, stalls.clone(), &[disc(2.0)]),
        of("a box of 8 by 8 diameters, and stalls", 0.01, 500, stalls, &[box_of([2.0, 2.0])]),
    ]
}

/// Cups, corners, tubes, periods, and a colony that has inertia.
fn others() -> Vec<Case> {
    let cup = [channel(3.0), side([1.0, 0.0, 0.0], 1.0)];
    let wedge = [side([0.5, 1.0, 0.0], 0.8), side([0.5, -1.0, 0.0], 0.8)];
    let mut heavy = colony(0.01, GROWTH, vec![cube([2.0, 2.0, 1.0])]);
    heavy.scene.dynamics = Dynamics::Inertial { density: 1.0, drag: None };
    let mut periodic = colony(0.01, GROWTH, Vec::new());
    periodic.scene.periodic = Some(Periodic::new([Some(7.0), Some(7.0), None]));
    let spatial = |walls: Vec<Wall>| {
        let mut start = colony(0.01, GROWTH, walls);
        start.scene.planar = false;
        start
    };
    let tube = Wall::Cylinder {
        center: [0.0; 3],
        axis: [1.0, 0.0, 0.0],
        radius: 0.75,
        length: Some(8.0),
        motion: None,
        friction: None,
    };
    vec![
        case("colony grows out of a cup", 560, colony(0.01, GROWTH, cup.to_vec())),
        case("colony grows out of a corner", 560, colony(0.01, GROWTH, wedge.to_vec())),
        case("colony with inertia fills a box", 450, heavy),
        case("colony fills a periodic cell", 500, periodic),
        case("colony fills a can, in space", 450, spatial(vec![tube])),
        case("colony fills a ball, in space", 450, spatial(vec![disc(1.7)])),
    ]
}

/// Bodies that fit a space exactly, and are pressed.
fn exact() -> Vec<Case> {
    let lattice = |side: u32, pitch: f64| -> Vec<DVec3> {
        let middle = 0.5 * f64::from(side - 1);
        let at = |i: u32| DVec3::from([i % side, i / side % side, i / (side * side)].map(f64::from)) - middle;
        (0..side.pow(3)).map(|i| pitch * at(i)).collect()
    };
    let spheres = lattice(3, 1.0).into_iter().map(|x| upright(sphere(0.5), x.to_array())).collect();
    let mut full = Start::still(0.01, spheres);
    full.scene.walls = vec![cube([1.5; 3])];
    full.scene.forces = vec![Force::Uniform { force: [1.0, 2.0, -3.0], group: None, window: None }];
    let balls = lattice(2, 1.0).into_iter().map(|x| upright(ellipsoid([0.5, 0.5, 0.5]), x.to_array())).collect();
    let mut drawn = Start::still(0.01, balls);
    drawn.scene.walls = vec![cube([1.0; 3])];
    drawn.scene.forces = vec![Force::RadialInward { group: None, window: None }];
    let file: Vec<Body> = (0..6).map(|i| cell(1.0, [f64::from(i) - 2.5, 0.0, 0.0], 0.0)).collect();
    let mut pressed =
        colony(0.01, with!(on_no_room: OnNoRoom::Stall, ..EVEN), vec![channel(0.5), cube([3.0, 1.0, 1.0])]);
    pressed.scene.bodies = file;
    let mut grid = colony(0.002, with!(division_length: Some(1.5), ..EVEN), vec![cube([3.0, 1.0, 1.0])]);
    // Side by side and end to end, without a gap: there is no room from the first step on.
    grid.scene.bodies =
        (0..16).map(|i| cell(1.5, [1.5 * f64::from(i % 4) - 2.25, 0.5 * f64::from(i / 4) - 0.75, 0.0], 0.0)).collect();
    vec![
        case("27 spheres that fill a box, pushed", 40, full),
        case("8 balls that fill a box, drawn inwards", 40, drawn),
        case("6 cells that fill a channel of their diameter, and stall", 40, pressed),
        case("16 cells that fill a box, all dividing", 20, grid),
    ]
}
