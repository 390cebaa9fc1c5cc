//! `relcp contacts`: the near pairs of a state.

use super::arguments::Contacts;
use super::exit::{CliError, Exit};
use super::output;
use relcp::bodies::Bodies;
use relcp::record::{Folder, read_state};
use relcp::scene::{self, Scene};
use relcp::walls::Walls;
use serde::Serialize;
use std::path::Path;

#[derive(Serialize)]
struct Pair {
    a: usize,
    b: usize,
    /// The periods by which b is moved to the image that a meets; in periodic space only.
    #[serde(skip_serializing_if = "Option::is_none")]
    image: Option<[i64; 3]>,
    separation: f64,
    normal: [f64; 3],
    point_a: [f64; 3],
    point_b: [f64; 3],
}

#[derive(Serialize)]
struct AtWall {
    body: usize,
    wall: usize,
    separation: f64,
    normal: [f64; 3],
    point: [f64; 3],
}

#[derive(Serialize)]
struct Report {
    contacts: Vec<Pair>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    walls: Vec<AtWall>,
    max_overlap: f64,
}

pub(super) fn contacts(arguments: &Contacts) -> Result<Exit, CliError> {
    // Always in f64 on the CPU: it is what other results are audited by.
    super::compute::set_threads(&arguments.compute)?;
    let (bodies, walls) = open(&arguments.state)?;
    let report = find(&bodies, &walls, arguments.cutoff);
    if arguments.print.json {
        output::json(&report)?;
    } else if !arguments.print.quiet {
        print(&report)?;
    }
    Ok(Exit::Done)
}

/// The bodies of a scene as they start, of a state file, or of the state that a run's folder stands at; and the walls,
/// of which a state file knows nothing.
fn open(state: &str) -> Result<(Bodies, Walls), CliError> {
    let path = Path::new(state);
    if path.is_dir() {
        let bodies = read_state(&path.join("checkpoint.npz"))?.1.bodies;
        let scene = Folder::view(path).scene();
        let walls = if scene.exists() { Scene::read(&scene)?.walls() } else { Walls::default() };
        return Ok((bodies, walls));
    }
    if path.extension().is_some_and(|extension| extension == "npz") {
        return Ok((read_state(path)?.1.bodies, Walls::default()));
    }
    let scene = Scene::load(state, scene::NO_OVERRIDES)?;
    Ok((scene.build()?, scene.walls()))
}

fn find(bodies: &Bodies, walls: &Walls, cutoff: f64) -> Report {
    let mut report = Report { contacts: Vec::new(), walls: Vec::new(), max_overlap: walls.max_overlap(bodies) };
    for near in walls.contacts(bodies, cutoff) {
        report.walls.push(AtWall {
            body: near.body,
            wall: near.wall,
            separation: near.separation,
            normal: near.normal.to_array(),
            point: near.point(bodies).to_array(),
        });
    }
    // Asked for everything that overlaps even where the cutoff leaves some of it out.
    for near in relcp::contacts(bodies, cutoff.max(0.0)) {
        let ([a, b], [point_a, point_b]) = (near.bodies, near.points(bodies).map(|x| x.to_array()));
        let image = (!bodies.periods.is_none()).then(|| near.image.to_array());
        if -near.separation > report.max_overlap {
            report.max_overlap = -near.separation;
        }
        if near.separation <= cutoff {
            report.contacts.push(Pair {
                a,
                b,
                image,
                separation: near.separation,
                normal: near.normal.to_array(),
                point_a,
                point_b,
            });
        }
    }
    report
}

fn print(report: &Report) -> Result<(), CliError> {
    output::write(|out| {
        let point = |[x, y, z]: [f64; 3]| format!("{x:.6} {y:.6} {z:.6}");
        for c in &report.contacts {
            let (normal, a, b) = (point(c.normal), point(c.point_a), point(c.point_b));
            writeln!(out, "{:>7} {:>7}  {:>13.6e}  normal {normal}  at {a}  and {b}", c.a, c.b, c.separation)?;
        }
        for c in &report.walls {
            let (normal, at) = (point(c.normal), point(c.point));
            writeln!(out, "{:>7} wall {:>2}  {:>13.6e}  normal {normal}  at {at}", c.body, c.wall, c.separation)?;
        }
        let pairs = output::count(report.contacts.len(), "pair", "pairs");
        writeln!(out, "{pairs}, largest overlap {:.3e}", report.max_overlap)
    })
}
