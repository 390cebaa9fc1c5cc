use super::*;

#[test]
fn a_tiny_sheet_is_stretched_by_every_method() {
    let mut study = Study::begin(Size { side: 2, dt: 5e-3, end: 2.0, drag: 1.0 });
    let said: Vec<String> = std::iter::from_fn(|| study.next_run().unwrap()).collect();
    assert!(said.len() == 3 && said[0].starts_with("ReLCP: ") && said[2].starts_with("LCP-MS 32: "), "{said:?}");
    let [relcp, snsd, spheres] = study.runs() else { panic!("{said:?}") };
    for run in study.runs() {
        assert_eq!((run.summary.steps, run.summary.windows.len(), run.extents.len()), (400, 200, 200));
        assert!(run.first[0] > 0.79 && run.last[0] > run.first[0], "{:?} {:?}", run.first, run.last);
        assert_eq!(run.extents[199], run.last);
    }
    assert_eq!((relcp.summary.steps_over, study.missed()), (0, false));
    assert!(snsd.summary.max_overlap >= relcp.summary.max_overlap && snsd.summary.proxy_overlap.is_none());
    assert!(spheres.summary.max_overlap > 1e-3 && spheres.summary.proxy_overlap.unwrap() < spheres.summary.max_overlap);
    let targets = study.targets();
    assert_eq!((targets[0].met, targets[2].met), (Some(true), Some(true)), "{targets:?}");
    let page = study.page();
    assert!(page.contains("| LCP-MS 32 | ") && page.contains("of the minor radius | "), "{page}");
    let files = study.files().unwrap();
    let lines = |at: usize| String::from_utf8(files[at].1.clone()).unwrap().lines().count();
    assert_eq!((lines(0), lines(1)), (4, 601));
    assert!(study.plots().unwrap()[0].1.svg().starts_with("<svg"));
}

#[test]
fn nothing_is_said_of_what_was_not_run() {
    let study = Study::begin(Size::QUICK);
    assert!(study.targets().iter().all(|target| target.met.is_none()));
    assert!(study.page().contains("not run") && study.plots().unwrap()[0].1.svg().starts_with("<svg"));
}
