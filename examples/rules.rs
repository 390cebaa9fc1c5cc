//! A colony whose cells decide: they grow slower where neighbours press them, switch state where that lasts, divide
//! earlier in the new state, and count the divisions of their line. The state of a cell is a column of its own, which
//! daughters inherit and saved states hold.

use relcp::simulation::{Cell, CellState, CellValues, Change, Rules, Values, Which};
use relcp::{Scene, Simulation};

const CELLS: usize = 48;

/// The pressure above which a cell counts as crowded, and how long it takes to switch.
const CROWDED: f64 = 2.0;
const PATIENCE: f64 = 0.3;

struct Colony {
    dt: f64,
}

impl Rules for Colony {
    fn update(&mut self, state: &CellState<'_>, cells: &mut CellValues) -> Result<(), String> {
        let pressures = state.pressures();
        for (rate, pressure) in cells.rate.iter_mut().zip(&pressures) {
            *rate = 1.0 / (1.0 + pressure.max(0.0));
        }
        let crowded = cells.columns.get_mut("crowded").ok_or("the cells have no column `crowded`")?;
        for ((time, length), pressure) in crowded.iter_mut().zip(&mut cells.division_length).zip(&pressures) {
            *time += if *pressure > CROWDED { self.dt } else { 0.0 };
            *length = if *time > PATIENCE { 3.0 } else { 4.0 };
        }
        Ok(())
    }

    fn divide(&mut self, mother: &Cell, daughters: [&mut Cell; 2]) -> Result<(), String> {
        let divisions = mother.columns.get("divisions").ok_or("the cells have no column `divisions`")? + 1.0;
        for daughter in daughters {
            daughter.columns.insert("divisions".into(), divisions);
        }
        Ok(())
    }
}

fn main() -> Result<(), relcp::Error> {
    let scene = Scene::load("colony", ["time.dt=0.01", "time.end=12"])?;
    let dt = scene.time.dt;
    let mut simulation = Simulation::new(scene)?;
    let own = |name: &str| Values::Column(name.into(), vec![0.0]);
    simulation.change(&Change::new().set(Which::All, own("crowded")).set(Which::All, own("divisions")))?;
    simulation.set_rules(Box::new(Colony { dt }));
    while !simulation.done() && simulation.bodies() < CELLS {
        assert!(simulation.step()?.max_overlap <= 1e-5);
    }
    let state = simulation.state()?;
    let column = |name: &str| state.bodies.columns.get(name).unwrap_or_default();
    let switched = column("crowded").iter().filter(|time| **time > PATIENCE).count();
    let most = column("divisions").iter().copied().fold(0.0, f64::max);
    println!(
        "{} cells at time {:.2}, {switched} switched, up to {most} divisions",
        state.bodies.len(),
        simulation.time()
    );
    Ok(())
}
