use super::start::{Start, sphere, upright};
use super::*;
use glam::{DQuat, DVec3};
use relcp::gpu::Precision;
use relcp::lcp::Status;
use relcp::scene::Wall;
use relcp::step::StepReport;
use relcp::walls::Walls;

fn good() -> Figures {
    Figures { steps: 3, bodies: 2, max_overlap: 9e-6, ..Figures::new(1e-5, 1e-6) }
}

fn verdict(figures: &Figures) -> Verdict {
    judge(figures, None).0
}

#[test]
fn each_rule_can_fail() {
    assert_eq!(judge(&good(), None), (Verdict::Holds, Vec::new()));
    let bad = [
        (Figures { end: End::Panic("index out of bounds".into()), ..good() }, "panicked: index out"),
        (Figures { states_not_finite: 1, ..good() }, "1 accepted states are not finite"),
        (Figures { steps_misreported: 2, ..good() }, "2 steps report another overlap"),
        (Figures { false_claims: 1, worst_residual: 1e-3, ..good() }, "residuals to 1.0e-3"),
        (Figures { steps: 0, ..good() }, "no step"),
    ];
    for (figures, why) in bad {
        let (verdict, said) = judge(&figures, None);
        assert!(verdict == Verdict::Fails && said.len() == 1 && said[0].contains(why), "{said:?}");
        // What is reported beside it excuses nothing.
        assert_eq!(judge(&Figures { unconverged: 1, steps_over: 1, ..figures }, None).0, Verdict::Fails);
    }
    let of = |value: f64| Measure { what: "drift", value, bound: 1e-9, by_passing: false };
    assert_eq!(judge(&good(), Some(&of(1e-9))).0, Verdict::Holds);
    for value in [1.1e-9, f64::NAN, f64::INFINITY] {
        assert_eq!(judge(&good(), Some(&of(value))).0, Verdict::Fails, "{value}");
    }
}

#[test]
fn what_the_program_tells_is_reported_and_not_good() {
    let told = [
        Figures { steps_over: 1, max_overlap: 2e-5, ..good() },
        Figures { steps_unsettled: 1, status: Status::NoProgress.name().into(), ..good() },
        Figures { end: End::Fault("step 4: not finite".into()), ..good() },
        Figures { end: End::Refused("too large".into()), steps: 0, ..good() },
    ];
    for figures in told {
        assert_eq!(verdict(&figures), Verdict::Reported, "{figures:?}");
    }
    let passed = Figures { steps_passed: 1, passed: Some([0, 2]), ..good() };
    let lost = |by_passing: bool| Measure { what: "links lost", value: 1.0, bound: 0.0, by_passing };
    assert_eq!(judge(&passed, Some(&lost(true))).0, Verdict::Reported);
    assert_eq!(judge(&passed, Some(&lost(false))).0, Verdict::Fails, "a passage explains places, and no energy");
    assert_eq!(judge(&good(), Some(&lost(true))).0, Verdict::Fails, "nobody told");
}

#[test]
fn an_audit_finds_what_a_report_hides() {
    let start = Start::still(0.1, vec![upright(sphere(0.5), [0.0; 3]), upright(sphere(0.5), [0.9, 0.0, 0.0])]);
    let overlapping = start.scene.build().unwrap();
    let said = |max_overlap: f64| {
        let mut figures = good();
        figures.audit(
            &with!(max_overlap, ..StepReport::default()),
            (&overlapping, &[]),
            &Walls::default(),
            Precision::F64,
        );
        figures
    };
    let honest = said(1.0 - 0.9);
    assert_eq!((honest.steps_over, honest.steps_misreported, verdict(&honest)), (1, 0, Verdict::Reported));
    assert!((honest.max_overlap - 0.1).abs() < 1e-15);
    for lie in [0.0, 0.05, 0.2, f64::NAN] {
        assert_eq!(verdict(&said(lie)), Verdict::Fails, "{lie}");
    }
    for broken in [DVec3::NAN, DVec3::INFINITY] {
        let mut bodies = overlapping.clone();
        bodies.velocity[1] = broken;
        let mut figures = good();
        figures.audit(
            &with!(max_overlap: 1.0 - 0.9, ..StepReport::default()),
            (&bodies, &[]),
            &Walls::default(),
            Precision::F64,
        );
        assert_eq!((figures.states_not_finite, verdict(&figures)), (1, Verdict::Fails));
    }
    let mut bodies = overlapping;
    bodies.orientation[0] = DQuat::from_xyzw(0.0, 0.0, 0.0, 2.0);
    let mut figures = good();
    figures.audit(
        &with!(max_overlap: 1.0 - 0.9, ..StepReport::default()),
        (&bodies, &[]),
        &Walls::default(),
        Precision::F64,
    );
    assert_eq!(figures.states_not_finite, 1);
}

#[test]
fn an_audit_looks_at_walls() {
    let mut start = Start::still(0.1, vec![upright(sphere(0.5), [0.0; 3])]);
    let bodies = start.scene.build().unwrap();
    start.scene.walls =
        vec![Wall::HalfSpace { normal: [1.0, 0.0, 0.0], offset: -0.4, motion: None, friction: None, load: None }];
    let mut figures = good();
    figures.audit(&StepReport::default(), (&bodies, &[]), &start.scene.walls(), Precision::F64);
    assert_eq!((figures.steps_over, figures.steps_misreported), (1, 1));
    assert!((figures.max_overlap - 0.1).abs() < 1e-15);
}

#[test]
fn a_step_over_the_tolerance_fails_where_the_run_was_to_stop() {
    let over = Figures { steps_over: 1, max_overlap: 2e-5, binding: true, ..good() };
    let (verdict, said) = judge(&over, None);
    assert!(verdict == Verdict::Fails && said[0].contains("1 of 3 steps over the tolerance"), "{said:?}");
    let stopped = Figures { end: End::Fault("no room".into()), stopped: Some("no_room"), binding: true, ..good() };
    let (verdict, against) = weigh(&stopped, &[]);
    assert_eq!((verdict, against[0].kind), (Verdict::Reported, "no_room"));
}

#[test]
fn a_panic_and_a_bad_scene_end_a_run_and_not_the_study() {
    let start = Start::still(0.1, vec![upright(sphere(0.5), [0.0; 3])]);
    let run = follow(&start, 3, |_, simulation| assert!(simulation.steps() < 2, "on purpose"));
    assert_eq!((run.figures.end.clone(), run.figures.steps), (End::Panic("on purpose".into()), 2));
    assert_eq!((verdict(&run.figures), run.figures.ended()), (Verdict::Fails, "panic".into()));
    let refused = follow(&Start::still(-1.0, start.scene.bodies.clone()), 3, |_, _| {});
    assert!(matches!(&refused.figures.end, End::Refused(why) if why.contains("dt")), "{:?}", refused.figures.end);
    assert_eq!(verdict(&refused.figures), Verdict::Reported);
    // So large a force that a step has no end that is a number.
    let mut torn = start;
    torn.pull = Some(Pull { centre: DVec3::splat(1e300), stiffness: 1e300 });
    let torn = follow(&torn, 3, |_, _| {});
    assert!(matches!(torn.figures.end, End::Fault(_)), "{:?}", torn.figures.end);
    assert_eq!((torn.figures.states_not_finite, verdict(&torn.figures)), (0, Verdict::Reported));
}

/// As the program computes all of them: none fails.
#[test]
fn the_quick_study_says_of_every_case_what_it_is() {
    let mut study = Study::begin(Size::QUICK);
    for case in all() {
        study.run(&case);
    }
    let names: std::collections::HashSet<&str> = study.rows().iter().map(|row| row.case.as_str()).collect();
    assert_eq!(names.len(), study.rows().len(), "two cases have one name");
    let of = |verdict: Verdict| study.rows().iter().filter(move |row| row.verdict == verdict);
    let fails: Vec<&str> = of(Verdict::Fails).map(|row| row.case.as_str()).collect();
    assert_eq!(fails, [""; 0], "{:#?}", of(Verdict::Fails).collect::<Vec<&Row>>());
    assert!(!study.missed());
    // A step in which bodies go through each other is taken again in pieces.
    assert!(study.rows().iter().all(|row| row.figures.steps_passed == 0));
    for row in study.rows() {
        let Figures { steps, end, bodies, .. } = &row.figures;
        assert!((*steps > 0 && *end == End::Done && *bodies > 0) || row.verdict != Verdict::Holds, "{row:?}");
        assert_eq!(row.why.is_empty(), row.verdict == Verdict::Holds);
        assert!(!matches!(end, End::Refused(_) | End::Panic(_)), "{row:?}");
    }
    let page = study.page();
    for row in study.rows() {
        assert_eq!(page.matches(&format!("| {} |", row.case)).count(), 1);
        let listed = page.matches(&format!(": {}: {}.", row.case, row.why.join("; "))).count();
        assert_eq!(listed, usize::from(row.verdict != Verdict::Holds), "{}", row.case);
    }
    assert_eq!(String::from_utf8(study.csv().unwrap()).unwrap().lines().count(), 1 + study.rows().len());
}
