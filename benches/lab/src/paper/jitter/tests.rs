use super::*;
use glam::DVec3;

fn frames(place: impl Fn(f64) -> DVec3) -> Vec<Vec<DVec3>> {
    (0..3).map(|k| vec![place(f64::from(k)), DVec3::ZERO]).collect()
}

#[test]
fn motion_is_smooth_or_shaken() {
    // One of two points moves, so a mean of squares is half of its square.
    let straight = Shake::of(&frames(|k| 0.1 * k * DVec3::X));
    assert!((straight.displacement() - 0.1 * 0.5f64.sqrt()).abs() < 1e-15 && straight.jitter() < 1e-15);
    let back_and_forth = Shake::of(&frames(|k| 0.1 * (k % 2.0) * DVec3::Y));
    assert!((back_and_forth.ratio().unwrap() - 2.0).abs() < 1e-12);
    let parabola = Shake::of(&frames(|k| 0.5 * k * k * DVec3::Z));
    assert!((parabola.jitter() - 0.5f64.sqrt()).abs() < 1e-15);
    assert_eq!(Shake::of(&frames(|_| DVec3::X)).ratio(), None);
    // The second difference needs three frames.
    let two = Shake::of(&frames(|k| 0.5 * k * k * DVec3::Z)[..2]);
    assert_eq!((two.jitter(), two.displacement()), (0.0, 0.5 * 0.5f64.sqrt()));
    let mut both = parabola;
    both.add(&two);
    assert_eq!(both.jitter(), parabola.jitter());
}

#[test]
fn left_alone_the_step_length_does_not_matter() {
    let run = |method, dt| follow(Case { capsules: Capsules::Alone, method, dt }, 8).unwrap();
    let (long, short) = (run(Method::Snsd, 1e-2), run(Method::Snsd, 1e-4));
    for (a, b) in long.windows.iter().zip(&short.windows) {
        assert!((a.max_overlap / b.max_overlap - 1.0).abs() < 1e-3, "{a:?} {b:?}");
    }
    // Those of an independent program, see tests/method/three_capsules.rs.
    assert!((short.first_overlap / 0.172603 - 1.0).abs() < 0.01 && short.steps_over == 8);
    assert_eq!((short.resolved_at, short.windows.len()), (None, 8));
    let relcp = run(Method::Relcp, 1e-4);
    assert_eq!((relcp.steps_over, relcp.resolved_at), (0, Some(1)));
    assert!(relcp.recursions > 0 && relcp.max_overlap < 1e-5);
}

#[test]
fn pressed_capsules_shake_without_recursion() {
    let mut study = Study::begin(Size { alone: &[], steps_alone: 0, pressed: &[1e-2], end: 2.0 });
    for case in study.size().cases() {
        study.run(case).unwrap();
    }
    let [relcp, snsd] = study.runs() else { panic!("{:?}", study.runs()) };
    assert_eq!((relcp.steps, relcp.windows.len()), (200, 100));
    assert!(relcp.windows.iter().all(|window| window.steps == 2) && relcp.steps_over == 0);
    assert!(snsd.late_overlap > 1e-3 && snsd.late.jitter() > 10.0 * relcp.late.jitter(), "{snsd:?}");
    assert!(!study.missed() && study.targets().iter().all(|target| target.met == Some(true)), "{:?}", study.targets());
    let page = study.page();
    assert!(page.contains("| LCP-SNSD | 1e-2 |") && page.contains("200 of 200"), "{page}");
    assert!(study.plot().unwrap().svg().starts_with("<svg"));
    assert_eq!(String::from_utf8(study.csv().unwrap()).unwrap().lines().count(), 3);
    assert_eq!(String::from_utf8(study.steps_csv().unwrap()).unwrap().lines().count(), 201);
}
