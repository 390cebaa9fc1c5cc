use super::page::PAPER;
use super::*;

const TINY: Size = Size {
    bodies: 8,
    volume_fraction: 0.1,
    end: 20.0,
    steps: &[(0.2, &[3]), (0.1, &[])],
    dense: &[3, 7],
    public: &[7],
    dense_time: 2.0,
};

#[test]
fn a_tiny_suspension_is_compacted() {
    let mut study = Study::begin(TINY);
    let said: Vec<String> = std::iter::from_fn(|| study.next_run().unwrap()).collect();
    assert_eq!((said.len(), TINY.cases().len()), (13, 13), "{said:?}");
    assert!(said[3].starts_with("LCP-MS 3, dt 0.2 from the dense state: "), "{said:?}");
    let rows = study.rows();
    let of = |part: Part, dt: f64| rows.iter().filter(move |row| row.part == part && row.dt == dt);
    assert_eq!([of(Part::Whole, 0.2), of(Part::Dense, 0.1), of(Part::Public, 0.1)].map(Iterator::count), [2, 3, 2]);
    for (row, run) in rows.iter().zip(study.runs()) {
        let (steps, windows) = if row.part == Part::Whole { (20.0, 100) } else { (2.0, 2) };
        assert_eq!((row.steps, run.summary.windows.len()), ((steps / row.dt).round() as u64, windows), "{row:?}");
        assert!(row.relative_time.is_some_and(|time| time > 0.0) && row.gyration.is_some_and(|radius| radius < 4.0));
    }
    // Every run from the dense state goes on from the one of its own step.
    let starts: Vec<f64> = study.runs().iter().map(|run| run.summary.windows[0].time).collect();
    assert!(starts[2..7].iter().all(|time| (*time - 21.0).abs() < 1e-9), "{starts:?}");
    let dense: Vec<f64> = of(Part::Dense, 0.2).map(|row| row.constraints).collect();
    assert!(dense[0] >= 8.0 && dense[2] > dense[1], "{dense:?}");
    assert_eq!(rows.iter().filter(|row| row.part != Part::Public && row.relative_constraints == Some(1.0)).count(), 4);
    // The solver of public codes comes to the same, and its time is over that of ReLCP by the default one.
    let (own, public) = (&rows[4], &rows[6]);
    assert_eq!([own, public].map(|row| (row.spheres, row.part)), [(Some(7), Part::Dense), (Some(7), Part::Public)]);
    assert!((own.gyration.unwrap() - public.gyration.unwrap()).abs() < 1e-4, "{own:?} {public:?}");
    assert_eq!(public.relative_time.unwrap(), public.milliseconds / rows[2].milliseconds);
    assert!(!study.missed() && study.targets()[0].met == Some(true));
    // Whole runs count where there are; else those from the dense state.
    let rows_of = &study.targets()[1].found;
    for (counts, times) in
        [("(LCP-MS 3 at 0.2)", 1), ("(LCP-MS 7 at 0.2, dense)", 1), ("LCP-MS 3 at", 2), ("LCP-MS", 4)]
    {
        assert_eq!(rows_of.matches(counts).count(), times, "{counts}: {rows_of}");
    }
    let page = study.page();
    assert!(page.contains("With 7 sub-spheres whole runs would take too long") && page.contains("| LCP-MS 7 | "));
    let files = study.files().unwrap();
    let lines = |at: usize| String::from_utf8(files[at].1.clone()).unwrap().lines().count();
    assert_eq!((lines(0), lines(1)), (14, 301));
    assert!(study.plots().unwrap()[0].1.svg().starts_with("<svg"));
}

#[test]
fn the_papers_figures_stand_beside_ours() {
    let mut study =
        Study::begin(Size { steps: &[(0.1, &[])], dense: &[3, 7], public: &[], end: 2.0, dense_time: 0.4, ..TINY });
    while study.next_run().unwrap().is_some() {}
    let set = |run: &mut Run, rows: f64, milliseconds: f64| {
        let window = run.summary.windows.last_mut().unwrap();
        (window.constraints, window.milliseconds) = (rows, milliseconds);
    };
    // The paper's own ratios of rows to 3 and 7 spheres, 2.03 and 9.66; times 1 and 56 instead of 1.9 and 28.
    for (run, (rows, milliseconds)) in study.runs[1..].iter_mut().zip([(29e2, 1.0), (59e2, 1.0), (28e3, 56.0)]) {
        set(run, rows, milliseconds);
    }
    let page = study.page();
    assert!(page.contains("| LCP-MS 3 | 5900 | 2.03 | 2.0 (1.00) | 1.00 | 1.00 | 1.9 (0.53) |"), "{page}");
    assert!(page.contains("| LCP-MS 7 | 28000 | 9.66 | 9.7 (1.00) | 56.00 | 56.00 | 28.0 (2.00) |"), "{page}");
    assert!(
        page.contains("rows grow with their number to the power 1.84 and time a step to 4.75; at dt 0.1"),
        "{page}"
    );
    let met: Vec<Option<bool>> = study.targets().iter().map(|target| target.met).collect();
    assert_eq!(met[1..7], [Some(true), Some(true), Some(true), Some(false), None, Some(true)]);
    assert_eq!(met[8], None);
    assert!(page.contains("| 0.10 | "), "{page}");
    assert!(
        PAPER
            .iter()
            .all(|(dt, count, ..)| Size::FULL.dense.contains(count) && Size::FULL.steps.iter().any(|s| s.0 == *dt))
    );
}
