//! `relcp contacts`: the near pairs of a state.

use super::arguments::{Backend, Compute as Arguments, Contacts};
use super::exit::{CliError, Exit};
use super::{compute, output};
use relcp::bodies::Bodies;
use relcp::digits::{few, short};
use relcp::gpu::Precision;
use relcp::record::{Folder, read_state};
use relcp::scene::{self, Scene};
use relcp::simulation::Compute;
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
    /// The number of periods along each axis from b to its image that is nearest to a; only in periodic space.
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
    backend: &'static str,
    /// The adapter and its driver, if a device computed the contacts.
    adapter: Option<String>,
    precision: &'static str,
}

pub(super) fn contacts(arguments: &Contacts) -> Result<Exit, CliError> {
    compute::set_thread_count(arguments.threads)?;
    let State { bodies, walls, scene } = open(&arguments.state)?;
    let report = find(&bodies, &walls, arguments.cutoff, &settle(arguments, scene.as_ref())?)?;
    if arguments.print.json {
        output::json(&report)?;
    } else if !arguments.print.quiet {
        print(&report)?;
    }
    Ok(Exit::Done)
}

/// The starting bodies of a scene, those of a state file, or those of a run's last state; and the walls and the scene,
/// which a state file lacks.
struct State {
    bodies: Bodies,
    walls: Walls,
    scene: Option<Scene>,
}

fn open(path: &Path) -> Result<State, CliError> {
    let of = |mut bodies: Bodies, scene: Option<Scene>| {
        // A state of an older program lacks this flag.
        bodies.planar |= scene.as_ref().is_some_and(|scene| scene.planar);
        State { bodies, walls: scene.as_ref().map(Scene::walls).unwrap_or_default(), scene }
    };
    if path.is_dir() {
        let (header, state) = read_state(&path.join("checkpoint.npz"))?;
        let scene = Folder::view(path).scene();
        let found = of(state.bodies, if scene.exists() { Some(Scene::read(&scene)?) } else { None });
        let walls = found.walls.at(header.time).gone(&found.bodies.walls);
        return Ok(State { walls, ..found });
    }
    if path.extension().is_some_and(|extension| extension == "npz") {
        return Ok(of(read_state(path)?.1.bodies, None));
    }
    let scene = Scene::load(path, scene::NO_OVERRIDES)?;
    Ok(of(scene.build()?, Some(scene)))
}

/// The scene for which a device is opened if the bodies have none: contacts need no steps.
const STAND_IN: &str = "three-capsules";

/// Chooses the backend for the contacts. A device is refused if it does not support the shapes or rows of the scene.
fn settle(arguments: &Contacts, scene: Option<&Scene>) -> Result<Compute, CliError> {
    let Contacts { backend, adapter, precision, threads, .. } = arguments.clone();
    if backend == Backend::Mpi {
        return Err(compute::no_mpi());
    }
    if backend == Backend::Gpu {
        scene.map_or(Ok(()), Compute::check)?;
    }
    compute::settle(&Arguments { backend, adapter, precision, threads }, &Scene::built_in(STAND_IN)?)
}

fn find(bodies: &Bodies, walls: &Walls, cutoff: f64, compute: &Compute) -> Result<Report, CliError> {
    let mut report = Report {
        contacts: Vec::new(),
        walls: Vec::new(),
        max_overlap: 0.0,
        backend: "cpu",
        adapter: None,
        precision: Precision::F64.name(),
    };
    if let Compute::Gpu { gpu, precision } = compute {
        report.backend = "gpu";
        report.adapter = Some(format!("{} ({})", gpu.name(), gpu.driver()));
        report.precision = precision.name();
    }
    // All overlapping pairs are found, even with a negative cutoff.
    let reach = cutoff.max(0.0);
    let deeper = |worst: f64, separation: f64| if -separation > worst { -separation } else { worst };
    for near in compute.wall_contacts(bodies, walls, reach)? {
        report.max_overlap = deeper(report.max_overlap, near.separation);
        if near.separation <= cutoff {
            report.walls.push(AtWall {
                body: near.body,
                id: bodies.lineage[near.body].id,
                wall: near.wall,
                separation: near.separation,
                normal: near.normal.to_array(),
                point: near.point(bodies).to_array(),
            });
        }
    }
    for near in compute.contacts(bodies, reach)? {
        report.max_overlap = deeper(report.max_overlap, near.separation);
        if near.separation <= cutoff {
            let ([a, b], [point_a, point_b]) = (near.bodies, near.points(bodies).map(|x| x.to_array()));
            report.contacts.push(Pair {
                a,
                b,
                id_a: bodies.lineage[a].id,
                id_b: bodies.lineage[b].id,
                image: (!bodies.periods.is_none()).then(|| near.image.to_array()),
                separation: near.separation,
                normal: near.normal.to_array(),
                point_a,
                point_b,
            });
        }
    }
    Ok(report)
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
            write!(out, "{body_a:>7} {body_b:>7} {id_a:>7} {id_b:>7} {:>13}", short(*separation))?;
            writeln!(out, "  normal {normal}  at {a}  and {b}")?;
        }
        if !report.walls.is_empty() {
            head(out, ["body", "wall", "id", ""])?;
        }
        for c in &report.walls {
            let (normal, at) = (point(c.normal), point(c.point));
            let AtWall { body, wall, id, separation, .. } = c;
            writeln!(
                out,
                "{body:>7} {wall:>7} {id:>7} {:>7} {:>13}  normal {normal}  at {at}",
                "",
                short(*separation)
            )?;
        }
        let pairs = output::count(report.contacts.len(), "pair", "pairs");
        writeln!(out, "{pairs}, largest overlap {}", few(report.max_overlap))?;
        match &report.adapter {
            Some(adapter) => writeln!(out, "computed by {adapter}, in {}", report.precision),
            None => Ok(()),
        }
    })
}

/// The names of the columns.
fn head(out: &mut dyn Write, [a, b, c, d]: [&str; 4]) -> io::Result<()> {
    writeln!(out, "{a:>7} {b:>7} {c:>7} {d:>7} {:>13}", "separation")
}
