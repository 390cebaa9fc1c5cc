use super::page::PAPER;
use super::*;

const SMALL: Size = Size { runs: &[runs(None, 4, 2), runs(Some(7), 4, 1), runs(Some(5), 3, 1)] };

#[test]
fn a_small_colony_is_grown_by_both_methods() {
    let mut study = Study::begin(SMALL);
    let said: Vec<String> = std::iter::from_fn(|| study.next_run().unwrap()).collect();
    assert!(said.len() == 4 && said[0].starts_with("ReLCP, seed 1: 16 cells in "), "{said:?}");
    for run in study.runs() {
        let bodies: Vec<usize> = run.generations.iter().map(|of| of.bodies).collect();
        let expected: Vec<usize> = (1..=run.case.generations).map(|k| 1 << k).collect();
        assert_eq!(bodies, expected);
        // Divisions are ln 2 apart.
        for (k, of) in (1..).zip(&run.generations) {
            assert!((of.time - f64::from(k) * LN_2).abs() < 3.0 * DT, "{of:?}");
        }
        assert!(run.picture.starts_with(b"\x89PNG"));
    }
    assert_ne!(study.runs()[0].generations[3], study.runs()[1].generations[3]);
    let rows = study.rows();
    let names: Vec<&str> = rows.iter().map(|row| &*row.method).collect();
    assert_eq!(names, ["ReLCP", "LCP-MS 7", "LCP-MS 5"]);
    assert_eq!((rows[0].relative_constraints, rows[0].relative_time), (Some(1.0), Some(1.0)));
    assert!(rows[1].relative_constraints.unwrap() > 1.0 && rows[2].bodies == 8 && !study.missed());
    let lines = study.by_generation();
    assert_eq!(lines.iter().filter(|line| line.method == "ReLCP").count(), 4);
    assert_eq!(lines.iter().find(|line| line.bodies == 8).unwrap().relative_time, Some(1.0));
    let morphology = study.morphology();
    let gyration = morphology.iter().rfind(|line| line.quantity == "radius of gyration").unwrap();
    assert_eq!((gyration.bodies, gyration.relcp_seeds, gyration.spheres_seeds), (16, 2, 1));
    assert!(gyration.relcp_deviation.is_some() && gyration.significance().is_none());
    let targets = study.targets();
    assert_eq!((targets[0].met, targets[1].met, targets[7].met), (Some(true), Some(true), None), "{targets:?}");
    // Also in colonies as small as this.
    assert_eq!(targets[4].met, Some(true), "{targets:?}");
    let page = study.page();
    assert!(page.contains("LCP-MS 5 was ended at 8") && page.contains("(colony-lcp-ms-7.png)"), "{page}");
    assert!(page.contains("Runs: 2 of ReLCP, one of the others") && page.contains("fewer than 8 there are gaps"));
    let names: Vec<String> = study.files().unwrap().into_iter().map(|file| file.0).collect();
    assert!(names.contains(&"colony-relcp.png".into()) && names.len() == 8, "{names:?}");
    assert!(study.plots().unwrap()[0].1.svg().starts_with("<svg"));
}

#[test]
fn differences_are_told_in_standard_errors() {
    let line = Morphology {
        bodies: 4,
        quantity: "correlation length",
        relcp: 2.0,
        relcp_deviation: morphology::deviation(&[1.0, 3.0]),
        relcp_seeds: 2,
        spheres: 5.0,
        spheres_deviation: Some(0.0),
        spheres_seeds: 2,
    };
    // A deviation of sqrt(2) of two is a standard error of 1.
    assert!((line.significance().unwrap() - 3.0).abs() < 1e-12);
    assert_eq!(morphology::deviation(&[1.0]), None);
    assert_eq!(Morphology { relcp_deviation: Some(0.0), ..line }.significance(), None);
}

#[test]
fn the_papers_methods_are_all_run() {
    for size in [Size::FULL, Size::QUICK] {
        assert!(PAPER.iter().all(|(count, ..)| size.runs.iter().any(|runs| runs.spheres == *count)));
        assert!(size.runs[0].spheres.is_none());
    }
}
