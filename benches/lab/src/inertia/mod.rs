//! What inertial motion keeps: angular momentum and energy of tops that turn freely over many turns, the order of their
//! attitudes, and the energy of heaps that settle.
//!
//! Everything is audited from accepted states alone. Tops are measured on the CPU and on a device where there is one,
//! heaps on the CPU.

mod heap;
mod page;
mod plot;
#[cfg(test)]
mod tests;
mod top;

pub use heap::{Heap, HeapRow, settle};
pub use top::{Order, SHAPES, TopRow, attitude_error, turn};

use super::StudyError;
use super::paper::{Measured, Target};
use super::table::csv_table;
use relcp::figure::Figure;
use relcp::scene::Stepping;
use relcp::simulation::Compute;
use serde::Serialize;
use serde_json::{Value, json};

/// Both steppings.
pub const STEPPINGS: [Stepping; 2] = [Stepping::Euler, Stepping::Midpoint];

/// How much is measured.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Size {
    /// Angles by which tops turn in a step, radians.
    pub angles: &'static [f64],
    /// Turns of a top on the CPU.
    pub turns: f64,
    /// Steps of tops on a device at most.
    pub device_steps: u64,
    /// Angles by which the top turns in a step whose attitude is compared with the closed form.
    pub orders: &'static [f64],
    /// Heaps.
    pub heaps: usize,
    /// The time for which heaps are followed.
    pub end: f64,
}

impl Size {
    /// Some twenty minutes.
    pub const FULL: Size = Size {
        angles: &[0.01, 0.1, 0.3, 1.0],
        turns: 1000.0,
        device_steps: 2000,
        orders: &[0.2, 0.1, 0.05, 0.025],
        heaps: 50,
        end: 2.5,
    };
    /// A minute.
    pub const QUICK: Size =
        Size { angles: &[0.1, 1.0], turns: 20.0, device_steps: 200, orders: &[0.2, 0.1], heaps: 4, end: 0.6 };
}

/// What is run next.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Case {
    Tops { compute: usize, stepping: Stepping, angle: f64 },
    Order { stepping: Stepping, angle: f64 },
    Heap(Heap),
}

/// What was measured so far.
pub struct Study {
    size: Size,
    computes: Vec<Compute>,
    cases: Vec<Case>,
    done: usize,
    tops: Vec<TopRow>,
    orders: Vec<Order>,
    heaps: Vec<HeapRow>,
}

impl Study {
    /// Nothing yet.
    pub fn begin(size: Size, computes: Vec<Compute>) -> Self {
        let mut cases = Vec::new();
        for compute in 0..computes.len() {
            for stepping in STEPPINGS {
                cases.extend(size.angles.iter().map(|angle| Case::Tops { compute, stepping, angle: *angle }));
            }
        }
        for stepping in STEPPINGS {
            cases.extend(size.orders.iter().map(|angle| Case::Order { stepping, angle: *angle }));
        }
        for stepping in STEPPINGS {
            cases.extend((0..size.heaps).map(|number| Case::Heap(Heap::number(number, stepping, size.end))));
        }
        Study { size, computes, cases, done: 0, tops: Vec::new(), orders: Vec::new(), heaps: Vec::new() }
    }

    /// What it measures.
    pub fn size(&self) -> &Size {
        &self.size
    }

    /// The tops so far.
    pub fn tops(&self) -> &[TopRow] {
        &self.tops
    }

    /// Attitudes so far.
    pub fn orders(&self) -> &[Order] {
        &self.orders
    }

    /// The heaps so far.
    pub fn heaps(&self) -> &[HeapRow] {
        &self.heaps
    }

    /// What it is to show, and whether it does.
    pub fn targets(&self) -> Vec<Target> {
        page::targets(self)
    }

    fn tops_of(&mut self, compute: usize, stepping: Stepping, angle: f64) -> Result<String, StudyError> {
        let compute = &self.computes[compute];
        let steps = (self.size.turns * std::f64::consts::TAU / angle).ceil() as u64;
        let steps = if matches!(compute, Compute::Cpu) { steps } else { steps.min(self.size.device_steps) };
        let rows = turn(compute, stepping, angle, steps)?;
        let worst = |of: fn(&TopRow) -> f64| rows.iter().map(of).fold(0.0, f64::max);
        let said = format!(
            "tops by {stepping:?} steps, {angle} a step, {}: momentum off by {:.1e}, energy by {:.1e}",
            rows.first().map_or("", |row| &row.computed_by),
            worst(|row| row.momentum),
            worst(|row| row.energy)
        );
        self.tops.extend(rows);
        Ok(said)
    }
}

impl Measured for Study {
    fn name(&self) -> &'static str {
        "inertia"
    }

    fn next_run(&mut self) -> Result<Option<String>, StudyError> {
        let Some(case) = self.cases.get(self.done).copied() else { return Ok(None) };
        self.done += 1;
        let said = match case {
            Case::Tops { compute, stepping, angle } => self.tops_of(compute, stepping, angle)?,
            Case::Order { stepping, angle } => {
                let order = attitude_error(stepping, angle)?;
                let said = format!("attitude by {stepping:?} steps, {angle} a step: off by {:.1e}", order.error);
                self.orders.push(order);
                said
            }
            Case::Heap(heap) => {
                let row = settle(&heap)?;
                let said = format!(
                    "heap {} of {}, {stepping:?} steps of {}: rises by {:.1e} at most",
                    row.number,
                    row.shape,
                    row.dt,
                    row.most_rise,
                    stepping = heap.stepping,
                );
                self.heaps.push(row);
                said
            }
        };
        Ok(Some(said))
    }

    fn missed(&self) -> bool {
        self.targets().iter().any(|target| target.met == Some(false))
    }

    fn page(&self) -> String {
        page::page(self)
    }

    fn numbers(&self) -> Result<Value, StudyError> {
        let value = |of: serde_json::Result<Value>| of.map_err(|e| StudyError::Table(e.to_string()));
        Ok(json!({
            "size": value(serde_json::to_value(self.size))?,
            "tops": value(serde_json::to_value(&self.tops))?,
            "orders": value(serde_json::to_value(&self.orders))?,
            "heaps": value(serde_json::to_value(&self.heaps))?,
            "targets": value(serde_json::to_value(self.targets()))?,
        }))
    }

    fn files(&self) -> Result<Vec<(String, Vec<u8>)>, StudyError> {
        Ok(vec![
            ("inertia-tops.csv".into(), csv_table(self.tops.iter())?),
            ("inertia-orders.csv".into(), csv_table(self.orders.iter())?),
            ("inertia-heaps.csv".into(), csv_table(self.heaps.iter())?),
        ])
    }

    fn plots(&self) -> Result<Vec<(&'static str, Figure)>, StudyError> {
        Ok(vec![("inertia", plot::plot(self)?)])
    }
}
