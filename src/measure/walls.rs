//! The forces of bodies on walls, and the torque and pressure that each surface of a wall bears.
//!
//! A contact that pushes with `gamma` bears on the wall with `gamma n + t`, with the normal `n` towards the wall and
//! the friction force `t`. A surface's force and torque are the sums over its contacts; its pressure is the sum of
//! `gamma` over its area. A torque is about the point that the wall turns about, where that is at the state's time. In
//! periodic space a force acts at all images, so that there is no torque.

use super::{About, Cell, Column, Found, LeftOut, Marks, Measure, Profile, View, cell, count};
use crate::walls::{WallPush, Walls, standing};
use glam::DVec3;

const COLUMNS: [Column; 7] = [
    Column { name: "wall_contacts", what: "places of bodies that push a wall" },
    Column { name: "wall_force", what: "sum of the normal forces on all walls; a force" },
    Column { name: "wall_force_most", what: "the largest of them" },
    Column {
        name: "wall_pressure",
        what: "`wall_force` over the area of all walls, in the plane over their length; none where a wall has no end",
    },
    Column { name: "wall_force_x", what: "force on all walls together" },
    Column { name: "wall_force_y", what: "likewise" },
    Column { name: "wall_force_z", what: "likewise; in space" },
];

const PROFILE: [Column; 13] = [
    Column { name: "surface", what: "the surface's place among those of all walls, from 0" },
    Column { name: "normal_force", what: "sum of the normal forces on it" },
    Column { name: "wall", what: "index of its wall in the scene" },
    Column { name: "face", what: "which of the wall's surfaces it is, from 0" },
    Column { name: "contacts", what: "places of bodies that push it" },
    Column { name: "force_x", what: "force on it" },
    Column { name: "force_y", what: "likewise" },
    Column { name: "force_z", what: "likewise; in space" },
    Column { name: "torque_x", what: "torque on it about the point that its wall turns about; in open space" },
    Column { name: "torque_y", what: "likewise; in open space" },
    Column { name: "torque_z", what: "likewise; also in the plane" },
    Column { name: "area", what: "its area, in the plane its length; none where it has no end" },
    Column { name: "pressure", what: "`normal_force` over `area`" },
];

/// Forces on walls.
pub(super) struct OnWalls;

/// What bears on a surface.
#[derive(Clone, Copy, Default)]
struct Load {
    contacts: usize,
    normal: f64,
    most: f64,
    force: DVec3,
    torque: DVec3,
}

impl Load {
    fn add(&mut self, push: &WallPush, about: DVec3) {
        self.contacts += 1;
        self.normal += push.gamma;
        self.most = self.most.max(push.gamma);
        self.force += push.force;
        self.torque += (push.point - about).cross(push.force);
    }
}

impl Measure for OnWalls {
    fn about(&self) -> &'static About {
        &About {
            name: "walls",
            line: "force, torque and pressure on each wall",
            columns: &COLUMNS,
            profile: Some(Profile { columns: &PROFILE, drawn: 1, counts: None, marks: Marks::Kinds }),
            plots: &[&["wall_force", "wall_force_most"], &["wall_pressure"]],
        }
    }

    fn of(&self, view: &View<'_>) -> Result<Found, LeftOut> {
        if view.frame.walls.is_empty() {
            return Err("the run's scene is not there, or has no walls".into());
        }
        if view.frame.sub_spheres {
            return Err("the contact forces are those of sub-spheres".into());
        }
        let warm = view.forces()?;
        let (planar, periods) = (view.planar(), &view.bodies().periods);
        let frame = &standing(&view.frame.walls, &view.bodies().walls);
        let time = view.state.time;
        let walls = Walls::new(frame, planar).at(time);
        let about = |wall: usize| {
            let reference = frame[wall].reference();
            frame[wall].moved(time).map_or(reference, |moved| moved.point(reference))
        };
        let mut loads = vec![Load::default(); walls.len()];
        for push in walls.pushes(view.bodies(), warm) {
            loads[push.surface].add(&push, about(walls.wall_of(push.surface)));
        }
        let areas: Vec<Cell> = frame.iter().flat_map(|wall| wall.areas(periods, planar)).collect();
        let row = |(surface, (load, area)): (usize, (&Load, &Cell))| {
            let own = [count(surface), cell(load.normal), count(walls.wall_of(surface)), count(walls.face_of(surface))];
            let pressure = area.and_then(|area| cell(load.normal / area));
            let rest = [vector(load.force, planar, false), torque(load.torque, planar, periods.is_none())];
            let row = own.into_iter().chain([count(load.contacts)]).chain(rest.concat());
            row.chain([*area, pressure]).collect()
        };
        let remark = (!periods.is_none()).then(|| "torque: in periodic space a force acts at all images".to_owned());
        let rows = loads.iter().zip(&areas).enumerate().map(row).collect();
        Ok(Found { values: totals(&loads, &areas, planar), rows, remark })
    }
}

/// The numbers of all surfaces together.
fn totals(loads: &[Load], areas: &[Cell], planar: bool) -> Vec<Cell> {
    let normal: f64 = loads.iter().map(|load| load.normal).sum();
    let area: Cell = areas.iter().copied().sum();
    let most = loads.iter().map(|load| load.most).fold(0.0, f64::max);
    let mut values = vec![
        count(loads.iter().map(|load| load.contacts).sum()),
        cell(normal),
        cell(most),
        area.and_then(|area| cell(normal / area)),
    ];
    values.extend(vector(loads.iter().map(|load| load.force).sum(), planar, false));
    values
}

/// The components of a vector; in the plane those of a force, or of a torque, that can be.
fn vector(of: DVec3, planar: bool, turning: bool) -> [Cell; 3] {
    let there = |axis: usize| !planar || (axis == 2) == turning;
    [0, 1, 2].map(|axis| there(axis).then_some(of[axis]).and_then(cell))
}

fn torque(of: DVec3, planar: bool, open: bool) -> [Cell; 3] {
    if open { vector(of, planar, true) } else { [None; 3] }
}
