//! What `relcp measure` would tell of the state that a run is in.

use crate::StudyError;
use relcp::measure::{ALL, Frame, Settings, View};
use relcp::record::Snapshot;
use relcp::simulation::Simulation;

/// The numbers of these columns of the measures, with their default settings; none where the state has none.
pub(super) fn measure_columns<const N: usize>(
    simulation: &Simulation,
    columns: [&str; N],
) -> Result<[Option<f64>; N], StudyError> {
    let bodies = simulation.state()?.bodies.clone();
    let state = Snapshot {
        step: simulation.steps(),
        time: simulation.time(),
        bodies,
        warm: None,
        removed: Vec::new(),
        fields: Vec::new(),
    };
    let frame = Frame::of_scene(simulation.scene(), simulation.scene().name.clone());
    let settings = Settings::default();
    let view = View::new(&state, &frame, &settings);
    let mut values = [None; N];
    for measure in ALL.iter().filter(|measure| measure.columns().iter().any(|has| columns.contains(&has.name))) {
        let Ok(found) = measure.of(&view) else { continue };
        for (column, number) in measure.columns().iter().zip(found.values) {
            let asked = columns.iter().position(|name| *name == column.name);
            if let Some(value) = asked.and_then(|at| values.get_mut(at)) {
                *value = number;
            }
        }
    }
    Ok(values)
}

#[cfg(test)]
mod tests {
    use super::*;
    use relcp::scene::Scene;

    #[test]
    fn columns_of_several_measures_are_told_in_the_order_asked_for() {
        let scene = Scene::load("chainmail", ["generate.0.chainmail.columns=1"]).unwrap();
        let simulation = Simulation::new(scene).unwrap();
        // Six centres in a row, 1.6 apart: the mean square is 1.6^2 (6^2 - 1) / 12.
        let [order, gyration, none] =
            measure_columns(&simulation, ["nematic_order", "radius_gyration", "no_such_column"]).unwrap();
        assert!((gyration.unwrap() - 1.6 * (35.0f64 / 12.0).sqrt()).abs() < 1e-12, "{gyration:?}");
        assert!(order.is_some() && none.is_none());
    }
}
