//! A colony grown from one cell, by generation: wall time split by phase, constraints, recursions and products per
//! step, peak memory.
//!
//! `cargo bench --bench colony` grows 256 cells; `RELCP_CELLS=1024 cargo bench --bench colony` the size of the
//! published table.

use relcp::Scene;
use relcp::simulation::Simulation;
use relcp::step::{Phases, StepReport};
use std::time::{Duration, Instant};

/// Sums over the steps of one generation.
#[derive(Default)]
struct Generation {
    steps: u64,
    wall: Duration,
    phases: Phases,
    constraints: usize,
    recursions: u64,
    products: u64,
    worst_overlap: f64,
    unconverged: u32,
}

impl Generation {
    fn add(&mut self, report: &StepReport, wall: Duration) {
        self.steps += 1;
        self.wall += wall;
        self.phases.broad_phase += report.phases.broad_phase;
        self.phases.narrow_phase += report.phases.narrow_phase;
        self.phases.solve += report.phases.solve;
        self.phases.integrate += report.phases.integrate;
        self.phases.growth += report.phases.growth;
        self.constraints += report.constraints;
        self.recursions += u64::from(report.recursions);
        self.products += report.products;
        self.worst_overlap = self.worst_overlap.max(report.max_overlap);
        self.unconverged += report.unconverged;
    }

    fn row(&self, cells: usize) -> String {
        let steps = self.steps.max(1) as f64;
        let ms = |d: Duration| 1e3 * d.as_secs_f64() / steps;
        format!(
            "| {cells} | {} | {:.1} | {:.1} | {:.2} | {:.0} | {:.1e} | {} | {:.3} | {:.3} | {:.3} | {:.3} | {:.3} |",
            self.steps,
            self.wall.as_secs_f64(),
            self.constraints as f64 / steps,
            self.recursions as f64 / steps,
            self.products as f64 / steps,
            self.worst_overlap,
            self.unconverged,
            ms(self.phases.broad_phase),
            ms(self.phases.narrow_phase),
            ms(self.phases.solve),
            ms(self.phases.integrate),
            ms(self.phases.growth),
        )
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let cells: usize = std::env::var("RELCP_CELLS").ok().and_then(|n| n.parse().ok()).unwrap_or(256);
    let generations = (cells as f64).log2().ceil();
    let scene = Scene::load("colony", &[format!("time.end={}", generations * 2f64.ln() + 0.005)])?;
    let mut simulation = Simulation::new(scene)?;
    println!(
        "| cells | steps | wall s | rows | recursions | products | worst overlap | unconverged | broad ms | narrow ms | solve ms | integrate ms | growth ms |"
    );
    println!("| ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |");
    let (begun, mut generation, mut count) = (Instant::now(), Generation::default(), 1);
    while !simulation.done() {
        let at = Instant::now();
        let report = simulation.step()?;
        if report.bodies != count {
            println!("{}", generation.row(count));
            (generation, count) = (Generation::default(), report.bodies);
        }
        generation.add(&report, at.elapsed());
    }
    println!("{}", generation.row(count));
    println!("total {:.1} s on {} threads", begun.elapsed().as_secs_f64(), rayon::current_num_threads());
    if let Some(bytes) = relcp::run::peak_bytes() {
        println!("peak memory {:.1} MiB", bytes as f64 / 1048576.0);
    }
    Ok(())
}
