//! Runs drawn scenes, each on its own thread, and judges each run.

use super::keyed::furnish;
use super::rough::roughen;
use super::watch::Watch;
use super::{Drawn, confined, pressed, random};
use crate::StudyError;
use crate::hard::threads::spread;
use crate::hard::{End, Figures, Finding, Measure, Start, Verdict, follow_on, weigh};
use relcp::scene::{Scene, SceneError};
use relcp::simulation::Compute;
use serde::Serialize;

/// The source of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum From {
    /// [`random()`](super::random()).
    Random,
    /// [`confined()`](super::confined()).
    Confined,
    /// [`pressed()`](super::pressed()).
    Pressed,
}

/// A planned scene: its kind and its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Ticket {
    /// Its source.
    pub from: From,
    /// Its number.
    pub number: u64,
}

/// A drawn scene that was run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Its source.
    pub from: From,
    /// Its name.
    pub name: String,
    /// The description of the draw.
    pub what: String,
    /// The verdict.
    pub verdict: Verdict,
    /// The findings against it.
    pub why: Vec<Finding>,
    /// How it ended.
    pub ended: String,
    /// The figures of the run.
    pub figures: Figures,
    /// The measurements in addition to contact.
    pub measures: Vec<Measure>,
    /// The scene, if there are findings against it.
    #[serde(skip)]
    pub scene: Option<Scene>,
}

/// Options of the runs.
#[derive(Clone)]
pub struct Options {
    /// The seed of the draws.
    pub seed: u64,
    /// The number of concurrent scenes, each on one thread.
    pub threads: usize,
    /// The largest number of steps of each scene.
    pub most_steps: u64,
    /// Whether scenes get friction, and some restitution.
    pub rough: bool,
    /// Whether they get fields, loads, drag of real bodies, regions, fences or removal.
    pub keys: bool,
    /// The backend.
    pub compute: Compute,
}

/// Runs scenes. `seen` is called when a scene ends, in any order. The rows have the order of `tickets`, independent of
/// the threads.
///
/// # Errors
/// [`StudyError::Scene`] if no start of a scene is valid, [`StudyError::Threads`].
pub fn run_all(tickets: &[Ticket], options: &Options, seen: &(dyn Fn(&Row) + Sync)) -> Result<Vec<Row>, StudyError> {
    let rows = spread(tickets.len(), options.threads, &|place| {
        let ticket = tickets[place];
        let row = ticket.draw(options.seed).map(|mut drawn| {
            if options.rough {
                roughen(options.seed, ticket.number, &mut drawn);
            }
            if options.keys {
                furnish(options.seed, ticket.number, &mut drawn);
            }
            run(ticket.from, drawn, options.most_steps, &options.compute)
        });
        if let Ok(row) = &row {
            seen(row);
        }
        row
    })?;
    rows.into_iter().map(|row| row.map_err(StudyError::Scene)).collect()
}

impl Ticket {
    /// Returns the tickets of the given numbers of scenes of each kind, in the order of [`From`]. Each kind begins with
    /// the scene number `first`.
    pub fn of([random, confined, pressed]: [u64; 3], first: u64) -> Vec<Ticket> {
        let counts = [(From::Random, random), (From::Confined, confined), (From::Pressed, pressed)];
        let numbers = |count: u64| first..first.saturating_add(count);
        counts.into_iter().flat_map(|(from, count)| numbers(count).map(move |number| Ticket { from, number })).collect()
    }

    fn draw(self, seed: u64) -> Result<Drawn, SceneError> {
        match self.from {
            From::Random => random(seed, self.number),
            From::Confined => confined(seed, self.number),
            From::Pressed => pressed(seed, self.number),
        }
    }
}

/// Runs a drawn scene to its end, or to the first step over its tolerance, because later steps would be meaningless.
pub fn run(from: From, drawn: Drawn, most_steps: u64, compute: &Compute) -> Row {
    let Drawn { what, scene } = drawn;
    let mut watch = Watch::new(from, &scene);
    let start = Start { scene, pull: None };
    let run = follow_on(compute, &start, [most_steps, 1], |before, simulation| watch.see(before, simulation));
    let figures = run.figures;
    let measures = watch.measures();
    let (verdict, why) = weigh(&figures, &measures);
    let ended = ended(&start.scene, &figures, most_steps);
    let name = start.scene.name.clone();
    let scene = (verdict != Verdict::Holds).then_some(start.scene);
    Row { from, name, what, verdict, why, ended, figures, measures, scene }
}

fn ended(scene: &Scene, figures: &Figures, most_steps: u64) -> String {
    let population = scene.stop().and_then(|stop| stop.population);
    match &figures.end {
        End::Fault(_) => format!("a typed error: {}", figures.stopped.unwrap_or("of no name")),
        End::Panic(_) => "a panic".into(),
        End::Refused(_) => "refused".into(),
        End::Done if figures.binding && figures.steps_over > 0 => "a step over the tolerance".into(),
        End::Done if population.is_some_and(|most| figures.bodies as u64 >= most) => {
            "all cells that it may have".into()
        }
        End::Done if figures.steps >= most_steps && most_steps < scene.time.steps() => "the study's last step".into(),
        End::Done => "its end".into(),
    }
}
