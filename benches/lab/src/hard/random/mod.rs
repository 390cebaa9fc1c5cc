//! Random scenes, which cover cases that nobody wrote down.
//!
//! Scene `k` of a seed is always the same, independent of other draws: it has its own random stream.

mod confined;
mod drive;
mod keyed;
mod page;
mod place;
mod pressed;
mod room;
mod rough;
mod run;
mod shapes;
mod watch;

pub use confined::{POPULATION, confined};
pub use page::{csv, page};
pub use pressed::pressed;
pub use run::{From, Options, Row, Ticket, run, run_all};

use super::start::Random;
use place::{Manner, Placer};
use relcp::scene::{Growth, Scene, SceneError, Time};
use room::{Needs, Room};
use shapes::Mixture;

/// A scene that was drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawn {
    /// What was drawn, for people; the scene's name names the draw.
    pub what: String,
    /// The scene; its `time.end` is the run's.
    pub scene: Scene,
}

/// Draws from one stream before a refusal is passed on. Of 3,000 first draws 115 are refused: cells are to grow and
/// none found a place, or no body did.
const DRAWS: usize = 20;
/// Bodies at most.
const MOST_BODIES: f64 = 60.0;
/// Steps of a scene.
const STEPS: [f64; 2] = [20.0, 400.0];
/// Steps times bodies at most, so that a scene takes a second or so.
const MOST_BODY_STEPS: f64 = 6000.0;
/// What bodies are of the cube, or square, that they are placed in.
const FRACTION: [f64; 2] = [0.03, 0.6];
/// Half a room's least size, in longest extents of a body: each finds a place.
const LEAST_HALF: f64 = 1.1;

/// Scene `number` of a seed.
///
/// ```
/// use relcp_lab::hard::random::random;
/// let scene = random(1, 7)?.scene;
/// assert_eq!(scene, random(1, 7)?.scene);
/// assert_eq!(scene.name, "random-1-7");
/// # Ok::<(), relcp::scene::SceneError>(())
/// ```
///
/// # Errors
/// What refuses the last of the starts that were drawn for it.
pub fn random(seed: u64, number: u64) -> Result<Drawn, SceneError> {
    draw(Random::of_stream(seed, number), |random| attempt(random, format!("random-{seed}-{number}")))
}

/// The first of a stream's draws that the validation takes.
fn draw(mut random: Random, attempt: impl Fn(&mut Random) -> Drawn) -> Result<Drawn, SceneError> {
    let mut drawn = attempt(&mut random);
    for _ in 1..DRAWS {
        match drawn.scene.build() {
            Ok(_) => return Ok(drawn),
            Err(_) => drawn = attempt(&mut random),
        }
    }
    drawn.scene.build().map(|_| drawn)
}

fn attempt(random: &mut Random, name: String) -> Drawn {
    let planar = random.chance(0.4);
    let mixture = Mixture::draw(random);
    let dt = random.log_within(drive::DT[0], drive::DT[1]);
    let count = random.log_within(1.0, MOST_BODIES + 1.0).floor();
    let steps = random.log_within(STEPS[0], STEPS[1]).min(MOST_BODY_STEPS / count).floor();
    let (contact, solver, settings) = drive::settings(random, mixture.thinnest());
    let mut scene = with!(
        seed: random.any(),
        dynamics: drive::dynamics(random),
        contact,
        solver,
        planar,
        ..Scene::new(name, with!(stepping: drive::stepping(random), ..Time::new(dt, steps * dt)))
    );
    scene.growth = drive::growth(random, &mixture, dt, count as u64).into_iter().collect();
    let reach = mixture.reach().max(longest(&scene));
    let needs = needs(random, &mixture, count, planar, reach);
    let room = Room::draw(random, needs);
    (scene.walls, scene.periodic) = (room.walls.clone(), room.periodic);
    let manner = Manner::draw(random);
    scene.bodies = Placer::new(&scene, &room).place(random, &mixture, count as usize, manner);
    let driven = drive::drive(random, &mut scene, mixture.reach());
    Drawn { what: described(&scene, &mixture, &room, manner, &driven, &settings), scene }
}

/// Half the longest that a cell grows to.
fn longest(scene: &Scene) -> f64 {
    let longest = |growth: &Growth| 0.5 * growth.targets()[1] * (growth.fastest_rate() * scene.time.dt).exp();
    scene.growth.iter().map(longest).fold(0.0, f64::max)
}

fn needs(random: &mut Random, mixture: &Mixture, count: f64, planar: bool, reach: f64) -> Needs {
    let fraction = random.log_within(FRACTION[0], FRACTION[1]);
    let sizes = mixture.shapes.iter().map(|shape| match planar {
        true => shape.thickness() * shape.major_axis(),
        false => shape.volume(),
    });
    let size = count * sizes.sum::<f64>() / mixture.shapes.len() as f64;
    let side = if planar { (size / fraction).sqrt() } else { (size / fraction).cbrt() };
    // Twice what the longest body and the default cutoff, or half a thickness, take.
    let least_period = 2.0 * (2.0 * reach + 0.5 * mixture.thinnest());
    Needs { planar, half: (0.5 * side).max(LEAST_HALF * mixture.reach()), least_period }
}

fn described(scene: &Scene, mixture: &Mixture, room: &Room, manner: Manner, driven: &str, settings: &str) -> String {
    let mut out = format!(
        "{}, {}, {:?}, dt {:.1e}, {} {} {} {}, {driven}",
        if scene.planar { "planar" } else { "spatial" },
        match scene.dynamics {
            relcp::scene::Dynamics::Overdamped { .. } => "overdamped",
            _ => "inertial",
        },
        scene.time.stepping,
        scene.time.dt,
        scene.bodies.len(),
        mixture.what,
        manner.name(),
        room.what,
    )
    .to_lowercase();
    if !scene.growth.is_empty() {
        out.push_str(", growing");
    }
    if !settings.is_empty() {
        out.push_str(", ");
        out.push_str(settings);
    }
    out
}

#[cfg(test)]
mod tests;
