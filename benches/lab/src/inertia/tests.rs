//! What the study measures.

use super::*;

const TINY: Size = Size { angles: &[0.5], turns: 3.0, device_steps: 10, orders: &[0.2, 0.1], heaps: 2, end: 0.1 };

#[test]
fn a_small_study_holds_and_has_its_files() {
    let mut study = Study::begin(TINY, vec![Compute::Cpu]);
    assert!(study.targets().iter().all(|target| target.met.is_none()));
    while study.next_run().unwrap().is_some() {}
    assert_eq!((study.tops().len(), study.orders().len(), study.heaps().len()), (2 * SHAPES.len(), 4, 4));
    let targets = study.targets();
    assert!(targets.iter().all(|target| target.met != Some(false)), "{targets:?}");
    assert!(
        !study.missed() && study.page().contains("| prolate | CPU f64 | midpoint | 0.5 | 38 | 3 |"),
        "{}",
        study.page()
    );
    assert_eq!(study.files().unwrap().len(), 3);
    assert!(study.plots().unwrap()[0].1.svg().starts_with("<svg"));
    assert_eq!(study.numbers().unwrap()["heaps"][1]["shape"], "rods");
}

#[test]
fn heaps_come_round_after_forty() {
    let heap = |number| settle(&Heap::number(number, Stepping::Euler, 0.0)).unwrap();
    let [first, last] = [heap(0), heap(40)];
    assert_eq!((first.shape, first.place, first.dt), (last.shape, last.place, last.dt));
    assert!(first.first_energy != last.first_energy, "drawn anew");
}
