//! Progress on standard error while a scene's bodies are placed, which may take minutes for millions, and a prompt stop
//! at a signal.

use super::interrupt::Interrupt;
use super::output;
use indicatif::{ProgressBar, ProgressStyle};
use relcp::Bodies;
use relcp::scene::{Scene, SceneError};
use std::io::IsTerminal;
use std::time::{Duration, Instant};

/// Placement prints nothing before this much time has passed; most scenes need less.
const QUIET_FOR: Duration = Duration::from_secs(1);
/// Time between lines without a terminal.
const LINE_EVERY: Duration = Duration::from_secs(5);
/// Memory of a run per body. A million ellipsoids at a volume fraction of 2 % peak at 1.6 kB each in a step; the rest
/// is for the constraints of bodies that touch.
const BYTES_A_BODY: u64 = 3_000;
/// Below this memory, no line is printed.
const WORTH_A_LINE: u64 = 4_000_000_000;

/// Places the bodies of a scene before its run. `FaultKind::Interrupted` after a signal.
pub(super) fn place(scene: &Scene, interrupt: &Interrupt, quiet: bool) -> Result<Bodies, SceneError> {
    let of = scene.generate.iter().map(|rule| rule.count()).sum::<u64>() + scene.bodies.len() as u64;
    let bytes = of * BYTES_A_BODY;
    if !quiet && bytes >= WORTH_A_LINE {
        output::message(&format!("{of} bodies: the run needs about {:.0} GB of memory", bytes as f64 / 1e9));
    }
    let mut progress = Progress { of, quiet, begun: Instant::now(), shown: Instant::now(), bar: None };
    let bodies = scene.build_while(&mut |placed| {
        progress.show(placed);
        !interrupt.asked()
    });
    if let Some(bar) = progress.bar {
        bar.finish_and_clear();
    }
    bodies
}

struct Progress {
    of: u64,
    quiet: bool,
    begun: Instant,
    shown: Instant,
    bar: Option<ProgressBar>,
}

impl Progress {
    fn show(&mut self, placed: usize) {
        if self.quiet || self.begun.elapsed() < QUIET_FOR {
            return;
        }
        if std::io::stderr().is_terminal() {
            let of = self.of;
            let bar = self.bar.get_or_insert_with(|| {
                let style = ProgressStyle::with_template("{bar:24} {percent:>3}%  placed {pos} of {len} bodies");
                ProgressBar::new(of).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
            });
            bar.set_position(placed as u64);
        } else if self.shown.elapsed() >= LINE_EVERY {
            self.shown = Instant::now();
            output::message(&format!("placed {placed} of {} bodies", self.of));
        }
    }
}
