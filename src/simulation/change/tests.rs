//! Changes of the state: what they set, refuse and keep.

use super::*;
use crate::bodies::NO_GROUP;
use crate::dynamics::Load;
use crate::gpu::{Choice, Precision};
use crate::record::{Totals, decode, encode};
use crate::scene::{FaultKind, Scene};
use crate::shape::Shape;
use crate::simulation::Compute;

/// A crowd of rods in two groups, drawn together, in the plane or in space, with or without inertia.
fn crowd(planar: bool, dynamics: &str) -> Scene {
    let rods = |group: &str| {
        format!(
            r#"{{ "isotropic": {{ "count": 8, "group": "{group}", "shape": {{ "spherocylinder": {{ "diameter": 0.5, "length": 2 }} }},
            "volume_fraction": 0.2 }} }}"#
        )
    };
    let (a, b) =
        (rods("a"), rods("b").replace("\"volume_fraction\": 0.2", "\"volume_fraction\": 0.2, \"center\": [9, 0, 0]"));
    let text = format!(
        r#"{{ "name": "crowd", "time": {{ "dt": 0.02, "end": 2 }}, "planar": {planar}, "dynamics": {dynamics},
        "forces": [ {{ "trap": {{ "stiffness": 3, "center": [4, 0, 0], "axes": [true, true, {}] }} }} ],
        "generate": [ {a}, {b} ] }}"#,
        !planar
    );
    Scene::parse(&text, "crowd").unwrap()
}

fn overdamped() -> Scene {
    crowd(true, r#"{ "overdamped": { "drag": 1 } }"#)
}

fn colony() -> Scene {
    Scene::load("colony", ["time.dt=0.01", "time.end=4", "growth.division_length_noise=0.1", "growth.rate_noise=0.2"])
        .unwrap()
}

fn started(scene: &Scene, steps: usize) -> Simulation {
    let mut simulation = Simulation::new(scene.clone()).unwrap();
    (0..steps).for_each(|_| assert!(simulation.step().is_ok()));
    simulation
}

fn state(simulation: &Simulation) -> State {
    simulation.state().unwrap().clone()
}

/// The same simulation, from its state as bytes.
fn resumed(simulation: &Simulation) -> Simulation {
    let bytes = encode(&state(simulation), "", simulation.time(), Some(&Totals::default())).unwrap();
    let (_, read) = decode(&bytes).unwrap();
    assert_eq!(read, state(simulation));
    Simulation::builder(simulation.scene().clone()).resume(read).build().unwrap()
}

fn set(which: Which, values: Values) -> Change {
    Change::new().set(which, values)
}

fn some(which: &[usize]) -> Which {
    Which::Indices(which.to_vec())
}

#[test]
fn writing_what_is_there_changes_no_bit() {
    let (mut written, mut plain) = (started(&overdamped(), 5), started(&overdamped(), 5));
    let before = state(&written);
    let bodies = &before.bodies;
    let change = Change::new()
        .set(Which::All, Values::Position(bodies.position.clone()))
        .set(Which::All, Values::Orientation(bodies.orientation.clone()))
        .set(Which::All, Values::Group(bodies.group.clone()))
        .set(Which::All, Values::Length(vec![2.0; bodies.len()]));
    assert!(!before.warm.is_empty());
    written.change(&change).unwrap();
    assert_eq!(state(&written), before);
    (0..5).for_each(|_| assert_eq!(written.step().unwrap().residual, plain.step().unwrap().residual));
    assert_eq!(state(&written), state(&plain));
}

#[test]
fn multipliers_stay_with_pairs_that_were_not_moved() {
    let mut simulation = started(&overdamped(), 60);
    let before = state(&simulation);
    let moved = before.warm.iter().find(|warm| warm.gamma > 0.0).unwrap().pair[0];
    let up = before.bodies.position[moved as usize] + DVec3::new(0.0, 1e-3, 0.0);
    simulation.change(&set(some(&[moved as usize]), Values::Position(vec![up]))).unwrap();
    let after = state(&simulation);
    let others: Vec<_> = before.warm.iter().filter(|warm| !warm.pair.contains(&moved)).copied().collect();
    assert!(others.len() < before.warm.len() && !others.is_empty());
    assert_eq!((after.warm, after.bodies.position[moved as usize], after.changed), (others, up, true));
    simulation.step().unwrap();
    assert!(!state(&simulation).changed);
}

#[test]
fn a_changed_simulation_goes_on_to_the_bits_of_its_saved_state() {
    for scene in [overdamped(), crowd(false, r#"{ "inertial": { "density": 1 } }"#), colony()] {
        let mut simulation = started(&scene, 40);
        let bodies = state(&simulation).bodies;
        let onto = bodies.position[bodies.len() - 1] + DVec3::new(0.1, 0.0, 0.0);
        let mut change = set(some(&[0]), Values::Position(vec![onto]));
        change = change.set(Which::All, Values::Column("own".into(), (0..bodies.len()).map(|i| i as f64).collect()));
        if !scene.growth.is_empty() {
            change = change.set(some(&[0]), Values::Rate(vec![0.5])).set(some(&[0]), Values::DivisionLength(vec![3.0]));
        } else {
            change = change.remove_bodies(some(&[3, 5]));
        }
        simulation.change(&change).unwrap();
        let mut again = resumed(&simulation);
        for _ in 0..40 {
            let (one, two) = (simulation.step().unwrap(), again.step().unwrap());
            assert!(one.max_overlap <= 1e-5 && one.parted == two.parted, "{one:?}");
        }
        assert_eq!(state(&simulation), state(&again), "{}", scene.name);
        assert!(state(&simulation).bodies.columns.get("own").is_some());
    }
}

#[test]
fn bodies_with_inertia_that_are_put_onto_each_other_are_not_thrown() {
    let scene = crowd(false, r#"{ "inertial": { "density": 1 } }"#);
    let mut simulation = started(&scene, 10);
    let bodies = state(&simulation).bodies;
    simulation.change(&set(some(&[0]), Values::Position(vec![bodies.position[1]]))).unwrap();
    let report = simulation.step().unwrap();
    assert!(report.parted && report.max_overlap <= 1e-5, "{report:?}");
    let fastest = state(&simulation).bodies.velocity.iter().map(|v| v.length()).fold(0.0, f64::max);
    let before = bodies.velocity.iter().map(|v| v.length()).fold(0.0, f64::max);
    assert!(fastest < 2.0 * before + 1.0, "{fastest} after {before}");
}

/// The message of a change that is refused and leaves the state as it was.
fn refusal(simulation: &mut Simulation, change: &Change) -> String {
    let before = state(simulation);
    let said = simulation.change(change).unwrap_err().to_string();
    assert_eq!(state(simulation), before, "{said}");
    said
}

#[test]
fn values_that_are_not_allowed_are_refused_with_argument_and_row() {
    let mut rods = started(&overdamped(), 2);
    let nan = DVec3::new(0.0, f64::NAN, 0.0);
    let cases: Vec<(Change, &str)> = vec![
        (
            set(some(&[4, 2]), Values::Position(vec![DVec3::ZERO, nan])),
            "position[1] (body 2, id 2): must be finite, not NaN",
        ),
        (set(some(&[4]), Values::Position(vec![DVec3::Z])), "position[0] (body 4, id 4): has z = 1"),
        (set(some(&[1]), Values::Position(vec![1e300 * DVec3::X])), "position[0] (body 1, id 1): must be at most 1e60"),
        (set(Which::All, Values::Position(vec![DVec3::ZERO])), "position: 1 rows; expected 16"),
        (
            set(some(&[1]), Values::Orientation(vec![DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0)])),
            "orientation[0] (body 1, id 1): has the norm",
        ),
        (
            set(some(&[1]), Values::Orientation(vec![DQuat::from_rotation_x(0.3)])),
            "orientation[1] (body 1, id 1): the body must be mirrored",
        ),
        (
            set(some(&[1]), Values::Velocity(vec![DVec3::X])),
            "velocity[0] (body 1, id 1): has no meaning without inertia",
        ),
        (
            set(some(&[1]), Values::Length(vec![0.4])),
            "length[0] (body 1, id 1): must be at least the diameter, 0.5, not 0.4",
        ),
        (set(some(&[1]), Values::Length(vec![-1.0])), "length[0] (body 1, id 1): must be at least"),
        (set(some(&[1]), Values::Rate(vec![1.0])), "rate[0] (body 1, id 1): the body does not grow"),
        (set(some(&[1]), Values::Group(vec![2])), "group[0] (body 1, id 1): 2 is no group: the scene has 2"),
        (set(some(&[1]), Values::Column("x".into(), vec![f64::NAN])), "x[0] (body 1, id 1): must be finite"),
        (set(some(&[16]), Values::Length(vec![2.0])), "index 16: there are 16 bodies"),
        (set(some(&[3, 3]), Values::Length(vec![2.0; 2])), "body 3 is named twice"),
        (Change::new().remove_bodies(Which::Ids(vec![99])), "id 99: no body has it now"),
        // What comes before a refused edit does not count.
        (set(some(&[0]), Values::Position(vec![DVec3::ZERO])).remove_bodies(some(&[16])), "index 16"),
    ];
    for (change, expected) in cases {
        let said = refusal(&mut rods, &change);
        assert!(said.starts_with(expected), "{said}: {expected}");
    }
    let mut cells = started(&colony(), 2);
    for (values, expected) in [
        (Values::Rate(vec![-0.5]), "rate[0] (body 0, id 0): must not be negative, not -0.5"),
        (Values::Rate(vec![1e9]), "rate[0] (body 0, id 0): a cell would divide more than once"),
        (Values::DivisionLength(vec![f64::NAN]), "division_length[0] (body 0, id 0): must be positive, not NaN"),
    ] {
        let said = refusal(&mut cells, &set(some(&[0]), values));
        assert!(said.starts_with(expected), "{said}: {expected}");
    }
    let walls = "walls=[{\"half_space\": {\"normal\": [0, 1, 0], \"offset\": -9}}]";
    let mut bounded = started(&Scene::load("three-capsules", [walls]).unwrap(), 1);
    let said = refusal(&mut bounded, &set(some(&[2]), Values::Position(vec![-9.0 * DVec3::Y])));
    assert!(said.starts_with("position[2] (body 2, id 2): the body reaches"), "{said}");
}

#[test]
fn bodies_are_added_and_removed() {
    let mut simulation = started(&overdamped(), 5);
    let rod = |x: f64| Body::new(Shape::Spherocylinder { diameter: 0.5, length: 1.0 }, [x, 0.0, 0.0]);
    let mut lying = rod(-5.0);
    (lying.group, lying.axis) = (Some("b".into()), Some([1.0, 0.2, 0.0]));
    let ids = simulation.change(&Change::new().remove_bodies(some(&[0, 7])).add_bodies(vec![lying.clone()])).unwrap();
    let bodies = state(&simulation).bodies;
    assert_eq!((ids, bodies.len(), simulation.bodies()), (vec![16], 15, 15));
    assert_eq!((bodies.group[14], bodies.lineage[14].id, bodies.lineage[14].birth), (1, 16, simulation.time()));
    assert_eq!(bodies.lineage[0].id, 1);
    simulation.step().unwrap();
    let refuse =
        |simulation: &mut Simulation, body: Body| match simulation.change(&Change::new().add_bodies(vec![body])) {
            Err(ChangeError::Scene(no)) => (no.key().to_owned(), no.kind(), no.message().to_owned()),
            other => panic!("{other:?}"),
        };
    let wrong = Body { group: Some("bb".into()), ..lying.clone() };
    let (key, kind, said) = refuse(&mut simulation, wrong);
    assert_eq!((key.as_str(), kind), ("bodies.0.group", FaultKind::BadValue));
    assert!(said.contains("starts in the group `bb`"), "{said}");
    assert_eq!(refuse(&mut simulation, Body { fixed: true, ..lying.clone() }).0, "bodies.0.fixed");
    assert_eq!(refuse(&mut simulation, Body { position: [0.0, 0.0, 1.0], ..lying.clone() }).0, "bodies.0.position.2");
    let flat = Body { shape: Shape::Spherocylinder { diameter: 0.5, length: 0.2 }, ..lying };
    assert_eq!(refuse(&mut simulation, flat).0, "bodies.0.shape.spherocylinder.length");
    simulation.change(&Change::new().remove_bodies(Which::All)).unwrap();
    assert_eq!((simulation.bodies(), simulation.done()), (0, true));
    simulation.change(&Change::new().add_bodies(vec![rod_along_x()])).unwrap();
    assert!(!simulation.done());
    simulation.step().unwrap();
}

fn rod_along_x() -> Body {
    let mut rod = Body::new(Shape::Spherocylinder { diameter: 0.5, length: 1.0 }, [0.0; 3]);
    rod.axis = Some([1.0, 0.0, 0.0]);
    rod
}

#[test]
fn added_forces_act_on_after_bodies_come() {
    let mut simulation = started(&Scene::load("three-capsules", ["forces=[]", "time.end=10"]).unwrap(), 0);
    simulation.add_force(Box::new(|_: &Bodies, _: usize, _: f64| Load { force: DVec3::X, torque: DVec3::ZERO }));
    let ball = Body::new(Shape::Sphere { radius: 0.1 }, [50.0, 0.0, 0.0]);
    simulation.change(&Change::new().add_bodies(vec![ball])).unwrap();
    simulation.step().unwrap();
    assert!(state(&simulation).bodies.position[3].x > 50.0);
}

#[test]
fn a_group_that_was_emptied_is_not_in_the_final_scene() {
    let mut scene = overdamped();
    scene.contact.friction.groups = vec![crate::scene::GroupFriction::new(["a", "b"], 0.1)];
    scene.validate().unwrap();
    let mut simulation = started(&scene, 1);
    simulation.change(&set(Which::All, Values::Group(vec![NO_GROUP; 16]))).unwrap();
    simulation.final_scene().unwrap().validate().unwrap();
    assert!(scene.group_index("b").is_ok_and(|index| index == 1));
    assert!(scene.group_index("bb").is_err());
}

#[test]
fn a_change_on_a_device_is_that_on_the_cpu() {
    let scene = Scene::load("colony", ["time.dt=0.01"]).unwrap();
    let choice = Choice { software: true, ..Choice::default() };
    let compute = match Compute::open(&choice, Precision::F32, &scene) {
        Ok(compute) => compute,
        Err(no) => {
            println!("SKIP a change on a device: {no}");
            return;
        }
    };
    let mut both = [started(&scene, 0), Simulation::builder(scene).on(&compute).build().unwrap()];
    for simulation in &mut both {
        (0..10).for_each(|_| assert!(simulation.step().is_ok()));
        let values = [Values::Position(vec![DVec3::new(1.0, 2.0, 0.0)]), Values::Length(vec![2.5])];
        let [place, length] = values.map(|values| set(some(&[0]), values));
        simulation.change(&place).unwrap();
        simulation.change(&length).unwrap();
        let own =
            Change::new().set(some(&[0]), Values::Rate(vec![2.0])).set(some(&[0]), Values::DivisionLength(vec![2.7]));
        simulation.change(&own).unwrap();
        simulation.change(&Change::new().add_bodies(vec![rod_along_x()])).unwrap();
        (0..20).for_each(|_| assert!(simulation.step().is_ok()));
    }
    let [cpu, device] = both.each_ref().map(state);
    assert!(cpu.bodies.len() > 2, "{}", cpu.bodies.len());
    assert_eq!(cpu.bodies.lineage, device.bodies.lineage);
    assert_eq!(cpu.bodies.columns, device.bodies.columns);
    let off = cpu.bodies.position.iter().zip(&device.bodies.position).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
    assert!(off < 1e-4, "{off}");
}

mod by_rules {
    use super::*;

    /// Cells that slow down as they age, keep how often their line divided, and divide late after a long mother.
    struct Aging;

    impl Rules for Aging {
        fn update(&mut self, state: &CellState<'_>, cells: &mut CellValues) -> Result<(), String> {
            let ages = state.bodies.lineage.iter().map(|line| state.time - line.birth);
            cells.rate.iter_mut().zip(ages).for_each(|(rate, age)| *rate = 1.5 / (1.0 + age));
            cells.columns.entry("divisions".into()).or_insert_with(|| vec![0.0; state.bodies.len()]);
            Ok(())
        }

        fn divide(&mut self, mother: &Cell, daughters: [&mut Cell; 2]) -> Result<(), String> {
            for (daughter, length) in daughters.into_iter().zip([3.0, 3.5]) {
                daughter.division_length = length;
                *daughter.columns.get_mut("divisions").ok_or("no column")? = mother.columns["divisions"] + 1.0;
            }
            Ok(())
        }
    }

    #[test]
    fn cells_divide_and_inherit_by_rule_to_the_same_bits_after_resuming() {
        let ruled = |mut simulation: Simulation| {
            simulation.set_rules(Box::new(Aging));
            simulation
        };
        let mut simulation = ruled(Simulation::new(colony()).unwrap());
        while simulation.bodies() < 5 {
            simulation.step().unwrap();
        }
        let mut again = ruled(resumed(&simulation));
        for _ in 0..60 {
            simulation.step().unwrap();
            again.step().unwrap();
        }
        let after = state(&simulation);
        assert_eq!(after, state(&again));
        let generations: Vec<f64> = after.bodies.lineage.iter().map(|line| f64::from(line.generation)).collect();
        assert_eq!(after.bodies.columns.get("divisions").unwrap(), generations);
        let lengths = simulation.cell_values().unwrap().division_length;
        assert!(lengths.iter().all(|length| [3.0, 3.5].contains(length)), "{lengths:?}");
        assert!(simulation.take_rules().is_some());
    }

    /// The lower daughter gets this part of her mother.
    struct Uneven(f64);

    impl Rules for Uneven {
        fn divide(&mut self, _: &Cell, [lower, upper]: [&mut Cell; 2]) -> Result<(), String> {
            let whole = lower.length + upper.length;
            lower.length = self.0 * whole;
            upper.length = whole - lower.length;
            Ok(())
        }
    }

    /// The tips of a rod, the lower one first.
    fn tips(bodies: &Bodies, i: usize) -> [DVec3; 2] {
        let reach = 0.5 * bodies.shape[i].major_axis() * (bodies.orientation[i] * DVec3::Z);
        [bodies.position[i] - reach, bodies.position[i] + reach]
    }

    #[test]
    fn daughters_of_other_lengths_keep_their_outer_tips_and_meet_where_their_mother_was_cut() {
        let sizer = r#"{"rate": 1, "division_length": 4}"#;
        let adder = r#"{"rate": 1, "rule": "adder", "added_length": 2}"#;
        let ellipsoid = r#"{"shape": "ellipsoid", "rate": 1, "division_length": 4}"#;
        let founder =
            r#"bodies=[{"shape": {"ellipsoid": {"radii": [0.5, 0.5, 1.2]}}, "position": [0, 0, 0], "angle": 9}]"#;
        for growth in [sizer, adder, ellipsoid] {
            let own = if growth == ellipsoid { vec!["generate=[]", founder] } else { Vec::new() };
            let growth_key = format!("growth={growth}");
            let keys = ["time.dt=0.01", "time.end=4", &growth_key].into_iter().chain(own);
            let scene = Scene::load("colony", keys).unwrap();
            let mut both = [0.5, 0.375].map(|part| {
                let mut simulation = Simulation::new(scene.clone()).unwrap();
                simulation.set_rules(Box::new(Uneven(part)));
                while simulation.bodies() < 2 {
                    simulation.step().unwrap();
                }
                simulation
            });
            let [even, uneven] = both.each_ref().map(|simulation| state(simulation).bodies);
            let whole = even.shape[0].major_axis() + even.shape[1].major_axis();
            for (body, part) in [(0, 0.375), (1, 0.625)] {
                assert!((uneven.shape[body].major_axis() - part * whole).abs() < 1e-14 * whole);
                assert!(tips(&uneven, body)[body].distance(tips(&even, body)[body]) < 1e-14 * whole);
                assert_eq!(uneven.position[body].z, even.position[body].z);
                let born = uneven.lineage[body].birth_length;
                let expected = even.lineage[body].birth_length.map(|birth| birth * 2.0 * part);
                assert!(born.zip(expected).is_none_or(|(born, expected)| (born - expected).abs() < 1e-14));
                assert_eq!(born.is_some(), growth == adder);
            }
            let gap = |bodies: &Bodies| tips(bodies, 0)[1].distance(tips(bodies, 1)[0]);
            assert!((gap(&uneven) - gap(&even)).abs() < 1e-14 * whole);
            // The next steps hold too, and the longer daughter divides first.
            for simulation in &mut both {
                while simulation.bodies() < 3 {
                    assert!(simulation.step().unwrap().max_overlap <= 1e-5);
                }
            }
            let parents = both.each_ref().map(|simulation| state(simulation).bodies.lineage[2].parent);
            assert_eq!(parents[1], Some(2), "{growth}");
        }
    }

    #[test]
    fn uneven_divisions_go_on_to_the_same_bits_after_resuming_also_with_inertia() {
        for law in ["dynamics.overdamped.drag=1", "dynamics.inertial.density=1"] {
            let scene = Scene::load("colony", ["time.dt=0.01", "time.end=6", law]).unwrap();
            let ruled = |mut simulation: Simulation| {
                simulation.set_rules(Box::new(Uneven(0.4)));
                simulation
            };
            let mut simulation = ruled(Simulation::new(scene).unwrap());
            while simulation.bodies() < 4 {
                simulation.step().unwrap();
            }
            let mut again = ruled(resumed(&simulation));
            for _ in 0..40 {
                assert!(simulation.step().unwrap().max_overlap <= 1e-5, "{law}");
                again.step().unwrap();
            }
            assert_eq!(state(&simulation), state(&again), "{law}");
            assert!(simulation.bodies() >= 4);
        }
    }

    #[test]
    fn rules_that_change_nothing_keep_every_bit() {
        struct Idle;
        impl Rules for Idle {}
        let mut ruled = Simulation::new(colony()).unwrap();
        ruled.set_rules(Box::new(Idle));
        let mut plain = Simulation::new(colony()).unwrap();
        while !plain.done() {
            plain.step().unwrap();
            ruled.step().unwrap();
        }
        assert!(plain.bodies() > 8);
        assert_eq!(state(&plain), state(&ruled));
    }

    type Update = fn(&CellState<'_>, &mut CellValues) -> Result<(), String>;
    type Divide = fn(&mut Cell) -> Result<(), String>;

    struct Wrong(Update, Divide);

    impl Rules for Wrong {
        fn update(&mut self, state: &CellState<'_>, cells: &mut CellValues) -> Result<(), String> {
            if state.bodies.len() > 1 { (self.0)(state, cells) } else { Ok(()) }
        }

        fn divide(&mut self, _: &Cell, [_, second]: [&mut Cell; 2]) -> Result<(), String> {
            (self.1)(second)
        }
    }

    #[test]
    fn a_rule_that_fails_ends_the_step_with_the_cell_and_the_state_before() {
        let cases: [(Update, Divide, &str); 8] = [
            (|_, _| Err("no".into()), |_| Ok(()), "rules, update: no"),
            (
                |_, cells| {
                    cells.rate.pop();
                    Ok(())
                },
                |_| Ok(()),
                "rules, update: rate: 1 rows; expected 2",
            ),
            (
                |_, cells| {
                    cells.rate[1] = f64::NAN;
                    Ok(())
                },
                |_| Ok(()),
                "rules, update: rate[1] (body 1, id 2): must be finite",
            ),
            (
                |_, cells| {
                    cells.division_length[1] = -2.0;
                    Ok(())
                },
                |_| Ok(()),
                "rules, update: division_length[1] (body 1, id 2): must be positive, not -2",
            ),
            (|_, _| Ok(()), |_| Err("no".into()), "rules, divide of cell 0: no"),
            (
                |_, _| Ok(()),
                |second| {
                    second.rate = -1.0;
                    Ok(())
                },
                "rules, divide: rate[1] (body 1, id 2): must not be negative",
            ),
            (
                |_, _| Ok(()),
                |second| {
                    second.length += 0.25;
                    Ok(())
                },
                "rules, divide: length[0] (body 0, id 1): the lengths of two daughters add up to",
            ),
            (
                |_, _| Ok(()),
                |second| {
                    second.length = 0.1;
                    Ok(())
                },
                "rules, divide: length[1] (body 1, id 2): must be at least the diameter, 0.5, not 0.1",
            ),
        ];
        for (update, divide, expected) in cases {
            let mut simulation = Simulation::new(colony()).unwrap();
            simulation.set_rules(Box::new(Wrong(update, divide)));
            let (before, fault) = loop {
                let before = state(&simulation);
                if let Err(fault) = simulation.step() {
                    break (before, fault.to_string());
                }
            };
            assert!(fault.contains(expected), "{fault}: {expected}");
            assert_eq!(state(&simulation), before);
            assert!(simulation.step().is_err(), "it fails again");
            simulation.take_rules();
            simulation.step().unwrap();
        }
    }
}
