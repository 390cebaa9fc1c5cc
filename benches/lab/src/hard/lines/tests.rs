use super::*;

#[test]
fn every_line_is_a_scene_that_starts_without_overlap() {
    for line in all(Size::FULL) {
        let start = line.start(0.01);
        let bodies = start.scene.build().unwrap_or_else(|refused| panic!("{line:?}: {refused}"));
        assert_eq!(bodies.len(), line.count);
        let overlap = relcp::step::contacts(&bodies, 0.0).iter().map(|at| -at.separation).fold(0.0, f64::max);
        // Turned rods and ellipsoids are in each other by a part of their angle squared.
        assert!(overlap <= 2e-2 * line.misalignment + 1e-12, "{line:?}: {overlap}");
    }
    let with_closed_forms = all(Size::FULL).iter().filter(|line| line.right_offset().is_some()).count();
    assert_eq!((all(Size::FULL).len(), all(Size::QUICK).len(), with_closed_forms), (160, 64, 16));
}

/// Where two balls stand clearly out of line they end where they should, at any step, and as others do. In a ball that
/// just holds both they are always in line, and run ahead of the wall (docs/two-sided.md).
#[test]
fn two_balls_that_are_clearly_out_of_line_are_well() {
    let well = |line: &Line| {
        line.count == 2 && line.misalignment == 1e-2 && line.kind == Kind::Balls && line.right_offset().is_some()
    };
    let lines: Vec<Line> = all(Size::FULL).into_iter().filter(well).collect();
    assert_eq!(lines.len(), 2);
    for line in &lines {
        let rows = run(line, &[1e-2], 1e-4);
        assert!(rows.iter().all(Row::is_well), "{rows:#?}");
    }
}

#[test]
fn a_study_of_lines_is_the_same_on_any_number_of_threads_and_lists_every_run() {
    let lines: Vec<Line> =
        all(Size::FULL).into_iter().filter(|line| line.count == 3 && line.misalignment == 1e-2).collect();
    let rows = run_all(&lines, Size::QUICK, 2, &|_| ()).unwrap();
    assert_eq!(rows, run_all(&lines, Size::QUICK, 1, &|_| ()).unwrap());
    assert_eq!(rows.len(), 2 * lines.len());
    let compared = rows.iter().filter(|row| row.error.is_some()).count();
    assert!(compared <= lines.len(), "{compared}");
    let page = page(&rows);
    assert!(page.contains("## 3 balls\n") && page.contains("## 3 rods end to end\n"), "{page}");
    assert_eq!(String::from_utf8(csv(&rows).unwrap()).unwrap().lines().count(), 1 + rows.len());
}
