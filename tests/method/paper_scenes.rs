//! The paper's larger scenes, small: they run to their end within tolerance, and the other methods fail as the paper
//! says.

use relcp::Scene;
use relcp::shape::Shape;
use relcp::simulation::Simulation;
use relcp::step::StepReport;

fn run(name: &str, sets: &[&str]) -> (Simulation, Vec<StepReport>) {
    let sets: Vec<String> = sets.iter().map(|s| s.to_string()).collect();
    let scene = Scene::load(name, &sets).unwrap();
    let mut simulation = Simulation::new(scene).unwrap();
    let mut reports = Vec::new();
    while !simulation.done() {
        reports.push(simulation.step().unwrap());
    }
    (simulation, reports)
}

fn worst(reports: &[StepReport]) -> f64 {
    reports.iter().map(|r| r.max_overlap).fold(0.0, f64::max)
}

fn assert_within(simulation: &Simulation, reports: &[StepReport]) {
    let over = reports.iter().filter(|r| !r.within(1e-5)).count();
    let unconverged: u32 = reports.iter().map(|r| r.unconverged).sum();
    let recursions: u32 = reports.iter().map(|r| r.recursions).sum();
    let products: u64 = reports.iter().map(|r| r.products).sum();
    println!(
        "{}: {} steps, worst {:.2e}, {recursions} recursions, {products} products",
        simulation.scene().name,
        reports.len(),
        worst(reports)
    );
    assert_eq!((over, unconverged), (0, 0));
    let audited = simulation.contacts(0.0).unwrap().iter().map(|contact| -contact.separation).fold(0.0, f64::max);
    assert!(audited <= 1e-5, "the state itself overlaps by {audited:e}");
    assert!((audited - reports.last().unwrap().max_overlap).abs() < 1e-12);
}

#[test]
fn the_compaction_runs_to_its_end() {
    let (simulation, reports) = run("compaction", &[]);
    assert_within(&simulation, &reports);
    let positions = &simulation.state().unwrap().bodies.position;
    let gyration = (positions.iter().map(|x| x.length_squared()).sum::<f64>() / positions.len() as f64).sqrt();
    println!("radius of gyration {gyration}");
    // 1,000 bodies of volume 8.38: packed at a volume fraction of 0.74 to 0.55 they fill a ball of radius 14 to 15.5.
    assert!((10.5..12.5).contains(&gyration), "{gyration}");
}

#[test]
fn the_colony_grows_to_512_cells_in_the_plane() {
    let (simulation, reports) = run("colony", &[]);
    assert_within(&simulation, &reports);
    let bodies = &simulation.state().unwrap().bodies;
    assert_eq!(bodies.len(), 512);
    for i in 0..bodies.len() {
        assert_eq!(bodies.position[i].z, 0.0);
        assert!((bodies.orientation[i] * glam::DVec3::Z).z.abs() < 1e-12);
        assert_eq!(bodies.lineage[i].generation, 9);
    }
}

/// Linked rings that are drawn apart touch in two places. With one constraint per pair every step recursed for the
/// second one.
#[test]
fn taut_chainmail_does_not_recurse() {
    let sheet = ["generate.0.chainmail.columns=4", "generate.0.chainmail.rows=4", "time.end=1.3"];
    let taut = |rows: &str| {
        let rows = format!("contact.rows={rows}");
        let (simulation, reports) = run("chainmail", &[sheet.as_slice(), &[rows.as_str()]].concat());
        assert_within(&simulation, &reports);
        let taut = &reports[reports.len() - 100..];
        taut.iter().map(|report| report.recursions).sum::<u32>()
    };
    let (paper, auto) = (taut("paper"), taut("auto"));
    println!("recursions in 100 steps of a taut sheet: {paper} with one constraint per pair, {auto} by branches");
    assert!(paper >= 90 && auto <= 5, "{paper} {auto}");
}

#[test]
fn on_chainmail_only_relcp_holds_the_true_surfaces() {
    let sheet = ["generate.0.chainmail.columns=4", "generate.0.chainmail.rows=4"];
    let (simulation, reports) = run("chainmail", &sheet);
    assert_within(&simulation, &reports);
    let Shape::Torus { minor_radius, .. } = simulation.state().unwrap().bodies.shape[0] else { unreachable!() };

    let proxies = [sheet.as_slice(), &["contact.method={\"multisphere\":{\"count\":32}}"]].concat();
    let (_, spheres) = run("chainmail", &proxies);
    let between_spheres = spheres.iter().filter_map(|r| r.proxy_overlap).fold(0.0, f64::max);
    println!(
        "multisphere: {between_spheres:.1e} between spheres, {:.2} of the minor radius",
        worst(&spheres) / minor_radius
    );
    assert!(worst(&spheres) > 0.1 * minor_radius, "{}", worst(&spheres));

    let (_, snsd) = run("chainmail", &[sheet.as_slice(), &["contact.method=\"snsd\""]].concat());
    println!("snsd: {:.2e}", worst(&snsd));
    assert!(worst(&snsd) > 1e-3, "{}", worst(&snsd));
    assert!(between_spheres < 1e-5, "{between_spheres}");
}
