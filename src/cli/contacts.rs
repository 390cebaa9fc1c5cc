//! `relcp contacts`: the near pairs of a state.

use super::arguments::Contacts;
use super::exit::{CliError, Exit};
use super::output;
use relcp::bodies::Bodies;
use relcp::record::{Folder, read_state};
use relcp::scene;
use relcp::step::image_contacts;
use relcp::walls::Walls;
use serde::Serialize;
use std::io::{self, Write};
use std::path::Path;

#[derive(Serialize)]
struct Pair {
    a: usize,
    b: usize,
    id_a: u64,
    id_b: u64,
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
    id: u64,
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
    super::compute::set_thread_count(arguments.threads)?;
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
        let walls = if scene.exists() { scene::read(&scene)?.walls() } else { Walls::default() };
        return Ok((bodies, walls));
    }
    if path.extension().is_some_and(|extension| extension == "npz") {
        return Ok((read_state(path)?.1.bodies, Walls::default()));
    }
    let scene = scene::load(state, &[])?;
    Ok((scene.build()?, scene.walls()))
}

fn find(bodies: &Bodies, walls: &Walls, cutoff: f64) -> Report {
    let position = &bodies.position;
    let mut report = Report { contacts: Vec::new(), walls: Vec::new(), max_overlap: walls.max_overlap(bodies) };
    for near in walls.contacts(bodies, cutoff) {
        report.walls.push(AtWall {
            body: near.body,
            id: bodies.lineage[near.body].id,
            wall: near.wall,
            separation: near.found.separation,
            normal: near.found.normal.to_array(),
            point: (position[near.body] + near.found.lever_a).to_array(),
        });
    }
    // Asked for everything that overlaps even where the cutoff leaves some of it out.
    for near in image_contacts(bodies, cutoff.max(0.0)) {
        let ([a, b], s) = (near.pair, near.found);
        let image = (!bodies.periods.is_none()).then(|| near.image.to_array());
        if -s.separation > report.max_overlap {
            report.max_overlap = -s.separation;
        }
        if s.separation <= cutoff {
            report.contacts.push(Pair {
                a,
                b,
                id_a: bodies.lineage[a].id,
                id_b: bodies.lineage[b].id,
                image,
                separation: s.separation,
                normal: s.normal.to_array(),
                point_a: (position[a] + s.lever_a).to_array(),
                point_b: (position[b] + bodies.periods.shift(near.image) + s.lever_b).to_array(),
            });
        }
    }
    report
}

fn print(report: &Report) -> Result<(), CliError> {
    output::write(|out| {
        let point = |[x, y, z]: [f64; 3]| format!("{x:.6} {y:.6} {z:.6}");
        if !report.contacts.is_empty() {
            head(out, ["body a", "body b", "id a", "id b"])?;
        }
        for c in &report.contacts {
            let (normal, a, b) = (point(c.normal), point(c.point_a), point(c.point_b));
            let Pair { a: body_a, b: body_b, id_a, id_b, separation, .. } = c;
            write!(out, "{body_a:>7} {body_b:>7} {id_a:>7} {id_b:>7} {separation:>13.6e}")?;
            writeln!(out, "  normal {normal}  at {a}  and {b}")?;
        }
        if !report.walls.is_empty() {
            head(out, ["body", "wall", "id", ""])?;
        }
        for c in &report.walls {
            let (normal, at) = (point(c.normal), point(c.point));
            let AtWall { body, wall, id, separation, .. } = c;
            writeln!(out, "{body:>7} {wall:>7} {id:>7} {:>7} {separation:>13.6e}  normal {normal}  at {at}", "")?;
        }
        let pairs = output::count(report.contacts.len(), "pair", "pairs");
        writeln!(out, "{pairs}, largest overlap {:.3e}", report.max_overlap)
    })
}

/// The names of the columns.
fn head(out: &mut dyn Write, [a, b, c, d]: [&str; 4]) -> io::Result<()> {
    writeln!(out, "{a:>7} {b:>7} {c:>7} {d:>7} {:>13}", "separation")
}
