//! Mutated sweeps.

use super::mutants::{Fate, each};
use super::text::mutate;
use relcp::batch::{BatchError, Plan, Seeds, Sweep};
use std::fs;
use std::path::Path;

/// Members up to which a mutant is planned: each is a scene to be read.
const PLANNED: u64 = 300;

const SWEEPS: [&str; 3] = [
    r#"{ "name": "steps", "scene": "three-capsules", "grid": { "time.dt": [0.1, 0.05], "contact.method": ["relcp", "snsd"] }, "seeds": [1, 2] }"#,
    r#"{ "name": "rods", "scene": "rods.json", "set": { "time.end": 0.1, "output.every": 0.05 },
         "list": [ { "forces.0.uniform.force.2": -2, "seed": 4 }, { "forces.0.uniform.force": [0, 0, 1] } ] }"#,
    r#"{ "name": "many", "scene": "colony", "grid": { "growth.rate": [0.1, 0.2], "growth.stop": [{ "population": 5 }, null] },
         "seeds": { "from": 3, "count": 2 } }"#,
];

const WORDS: [&str; 10] = [
    "count",
    "from",
    "grid",
    "list",
    "set",
    "three-capsules",
    "two-ellipsoids",
    "../rods.json",
    "planar",
    "solver.kind",
];

/// How many members a sweep would have.
fn members(sweep: &Sweep) -> u64 {
    let grid = sweep.grid.0.iter().map(|(_, values)| values.len() as u64);
    let list = sweep.list.as_ref().map_or(1, |list| list.len() as u64);
    grid.chain([list, sweep.seeds.as_ref().map_or(1, Seeds::len)]).fold(1, u64::saturating_mul)
}

#[test]
fn mutated_sweeps_are_read_or_refused() {
    let base = tempfile::tempdir().unwrap();
    fs::write(base.path().join("rods.json"), include_str!("../data/rods.json")).unwrap();
    let (base, runs) = (base.path(), Path::new("runs"));
    let read = |bytes: &[u8]| {
        let text = String::from_utf8_lossy(bytes);
        let long = serde_json::from_str::<Sweep>(&text)
            .is_ok_and(|s| (PLANNED..=relcp::batch::MAX_MEMBERS).contains(&members(&s)));
        if long {
            return Fate::Read;
        }
        let plan = match Plan::parse(&text, "mutant.json", base) {
            Ok(plan) => plan,
            Err(error) => {
                let BatchError::Scene(error) = error else { panic!("{error}") };
                assert!(!format!("{:?}", miette::Report::new(error)).is_empty());
                return Fate::Refused;
            }
        };
        // Nothing that a sweep says leads out of the folder of runs.
        let folder = plan.folder_in(runs);
        assert_eq!((folder.parent(), folder.components().count()), (Some(runs), 2), "{folder:?}");
        for member in plan.members() {
            assert_eq!(Path::new(&member.name()).components().count(), 1);
            // An entry of a list may set nothing: then the member is the scene itself.
            assert_eq!(member.label().is_empty(), member.set.0.is_empty());
        }
        plan.scene(plan.members().len() - 1).unwrap();
        assert!(plan.scene(plan.members().len()).is_err());
        Fate::Made
    };
    for sweep in SWEEPS {
        assert!(read(sweep.as_bytes()) == Fate::Made, "{sweep}");
    }
    let tally = each((3, "sweeps"), &SWEEPS, |random, sweep| mutate(random, sweep, &WORDS), read);
    assert!(tally.made > tally.refused / 20 && tally.refused > tally.made / 20, "{tally:?}");
}
