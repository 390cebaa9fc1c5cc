//! Tests: every kernel of every kind of scene is valid, and host and device use the same layout for shared data.

use super::*;
use crate::backend::gpu::bonds::BondKernels;
use crate::backend::gpu::branches::BranchKernels;
use crate::backend::gpu::candidates::CandidateKernels;
use crate::backend::gpu::effect::EffectKernels;
use crate::backend::gpu::first::FirstKernels;
use crate::backend::gpu::growing::GrowthKernels;
use crate::backend::gpu::heat::{self, RandomLoads};
use crate::backend::gpu::held::HeldKernels;
use crate::backend::gpu::motions::{FreeMotion, MotionKernels};
use crate::backend::gpu::narrow_phase::{NarrowKernels, Report};
use crate::backend::gpu::parted::PartedKernels;
use crate::backend::gpu::passing::PassingKernels;
use crate::backend::gpu::row_set::{MiddleRowKernels, PaperKernels, RowKernels};
use crate::backend::gpu::trial::TrialKernels;
use crate::backend::gpu::walls::WallKernels;
use crate::dynamics::{Bond, Bonds, Frame, Heat, Thermal, Window};
use crate::gpu::{LatticePeriods, Made, Precision, validate};
use crate::periodic::{Axis, CellShear};
use crate::scene::{self, Flow, GrowingShape, Growth, Periodic, Rows, Scene, Stepping, Wall, WallMotion};

fn setups() -> Vec<Setup> {
    let mut setups = Vec::new();
    // The scenes of the paper's sizes have the same kernels as the smaller ones.
    for built_in in scene::BuiltIn::ALL.iter().filter(|scene| !scene.name.ends_with("-full")) {
        let mut scene = Scene::parse(built_in.text, built_in.name).unwrap();
        let shapes: Vec<_> = scene.build().unwrap().shape;
        let plain = Setup::new(&scene.model(), &shapes, Precision::F32).unwrap();
        assert!(!plain.midpoint && plain.branches > 0);
        setups.push(plain);
        scene.walls = vec![Wall::Sphere { center: [0.0; 3], radius: 1e3, motion: None, friction: None }];
        scene.time.stepping = Stepping::Midpoint;
        scene.forces.extend(driven());
        let inertial = |drag| Dynamics::Inertial { density: 2.0, drag };
        let overdamped = |drag| Dynamics::Overdamped { drag };
        let axes = Drag::Axes { parallel: 1.0, perpendicular: 2.0, rotation: 3.0 };
        let drags = [Drag::Even(3.0), axes, Drag::Viscosity(0.5)];
        let laws = [None].into_iter().chain(drags.map(Some)).map(inertial).chain(drags.map(overdamped));
        let laws: Vec<Dynamics> = laws.collect();
        for (dynamics, rows) in laws.into_iter().flat_map(|law| [(law, Rows::Auto), (law, Rows::Paper)]) {
            (scene.dynamics, scene.contact.rows) = (dynamics, rows);
            let heat = Some(Heat { thermal: Thermal::new(0.5), seed: 3 << 40, dynamics, planar: scene.planar });
            let held = |p| Setup { heat, bonds: bonds(), ..Setup::new(&scene.model(), &shapes, p).unwrap() };
            setups.extend([Precision::F32, Precision::F64].map(held));
        }
        carry(&mut scene);
        setups.extend([Precision::F32, Precision::F64].map(|p| Setup::new(&scene.model(), &shapes, p).unwrap()));
    }
    for stepping in [Stepping::Euler, Stepping::Midpoint] {
        let mut scene = Scene::built_in("two-ellipsoids").unwrap();
        scene.time.stepping = stepping;
        scene.growth = vec![Growth { shape: GrowingShape::Ellipsoid, ..Growth::new(1e-3, 9.0) }];
        let shapes: Vec<_> = scene.build().unwrap().shape;
        for (rows, precision) in [(Rows::Auto, Precision::F32), (Rows::Paper, Precision::F64)] {
            scene.contact.rows = rows;
            setups.push(Setup::new(&scene.model(), &shapes, precision).unwrap());
        }
    }
    setups
}

/// Adds a flow and a moving wall to a scene with drag.
fn carry(scene: &mut Scene) {
    scene.flow = Some(Flow::Shear { rate: 2.0, direction: [1.0, 0.0, 0.0], gradient: [0.0, 1.0, 0.0] });
    let motion = Some(WallMotion { angular_velocity: Some([0.0, 0.0, 1.0]), ..WallMotion::new([1.0, 0.0, 0.0]) });
    scene.walls.push(Wall::HalfSpace { normal: [1.0, 0.0, 0.0], offset: -1e3, motion, friction: None, load: None });
}

/// Only the kernel of forces contains a flow. Moving walls add one kernel to midpoint steps, for the walls in the
/// middle.
#[test]
fn a_flow_and_moving_walls_change_no_other_kernel() {
    for (stepping, more) in [(Stepping::Euler, 0), (Stepping::Midpoint, 1)] {
        let mut scene = Scene::built_in("two-ellipsoids").unwrap();
        scene.walls = vec![Wall::Sphere { center: [0.0; 3], radius: 1e3, motion: None, friction: None }];
        scene.time.stepping = stepping;
        let sources = |scene: &Scene| {
            let shapes: Vec<_> = scene.build().unwrap().shape;
            every_source(&Setup::new(&scene.model(), &shapes, Precision::F32).unwrap())
        };
        let plain = sources(&scene);
        carry(&mut scene);
        let carried = sources(&scene);
        assert_eq!(carried.len(), plain.len() + more);
        for source in carried.iter().filter(|source| !plain.iter().any(|plain| plain.code() == source.code())) {
            assert!(["motion", "normals of surfaces"].contains(&source.name()), "{}", source.name());
        }
    }
}

/// Kernels of a cell whose lengths change read its periods as parameters, in every precision and with rows of each
/// kind.
#[test]
fn a_changing_cell_is_in_no_constant() {
    for (name, rows) in [("two-ellipsoids", Rows::Paper), ("two-ellipsoids", Rows::Auto), ("colony", Rows::Auto)] {
        let mut scene = Scene::built_in(name).unwrap();
        let mut cell = Periodic::new([Some(99.0), Some(98.0), None]);
        scene.contact.rows = rows;
        let sources = |cell: Periodic, scene: &mut Scene, precision| {
            scene.periodic = Some(cell);
            let shapes: Vec<_> = scene.build().unwrap().shape;
            every_source(&Setup::new(&scene.model(), &shapes, precision).unwrap())
        };
        for precision in [Precision::F32, Precision::F64] {
            cell.strain_rate = None;
            let still = sources(cell, &mut scene, precision);
            cell.strain_rate = Some([0.01, 0.0, 0.0]);
            let mut changing = sources(cell, &mut scene, precision);
            cell.strain_rate = None;
            cell.shear = Some(CellShear::new(0.01, Axis::X, Axis::Y));
            let sheared = sources(cell, &mut scene, precision);
            cell.shear = None;
            // The kernels that use velocities include the image's velocity, and its load is that of a flow.
            let with_images: Vec<_> =
                sheared.iter().filter(|source| source.code().contains("image_velocity(a, b)")).collect();
            assert_eq!(with_images.len(), if rows == Rows::Auto { 2 } else { 1 });
            assert!(sheared.iter().any(|source| source.code().contains("flow_load")));
            changing.extend(sheared);
            assert!(still.iter().any(|source| source.code().contains("const PERIOD_CELLS")));
            assert!(changing.iter().any(|source| source.code().contains("parameters.periods[0]")));
            for source in changing {
                let (name, code) = (source.name(), source.code());
                assert!(!code.contains("PERIOD_CELLS") && code.matches("var<storage").count() <= 8, "{name}");
                validate(&source).unwrap_or_else(|e| panic!("{name}: {e}"));
            }
        }
    }
}

/// The forces that are in no built-in scene, one of them with a window.
fn driven() -> [Force; 4] {
    let torque = |frame| Force::Torque { torque: [0.0, 0.0, 2.0], frame, group: None, window: None };
    let center = [0.0; 3];
    [
        Force::Propulsion { force: 1.0, axis: [1.0, 0.0, 2.0], group: None, window: Some(Window::between(1.0, 2.0)) },
        torque(Frame::Space),
        torque(Frame::Body),
        Force::Trap { stiffness: 1.0, center, axes: [true, true, false], group: Some("none".into()), window: None },
    ]
}

/// A bond that can break.
fn bonds() -> Bonds {
    let bond = Bond { break_force: Some(1.0), ..Bond::new([0, 1], [[0.0; 3]; 2], 1.0) };
    Bonds::new(&[bond], |body| body as u64)
}

/// Declares [`every_source`] and the names of the tables that it lists.
macro_rules! every_source {
    ($setup:ident: $($Table:ident = $from:expr),* $(,)?) => {
        const LISTED: &[&str] = &[$(stringify!($Table)),*];

        /// The sources of all kernels of a scene.
        fn every_source($setup: &Setup) -> Vec<Source> {
            [$(<Option<$Table>>::sources($from)),*].concat()
        }
    };
}

every_source! { setup:
    MotionKernels = Some(setup),
    FreeMotion = Some(motion(setup, true)),
    FirstKernels = Some(setup),
    CandidateKernels = Some(setup),
    NarrowKernels = Some(setup),
    RowKernels = Some(setup),
    TrialKernels = Some(setup),
    EffectKernels = Some(setup),
    PassingKernels = Some(setup),
    RandomLoads = heat::source(setup),
    GrowthKernels = setup.growth.is_some().then_some(setup),
    WallKernels = (!setup.walls.is_empty()).then_some(setup),
    BondKernels = (!setup.bonds.is_empty()).then_some(setup),
    HeldKernels = Some(setup),
    PartedKernels = Some(setup),
    BranchKernels = (setup.branches > 0).then_some(setup),
}

/// Tables within others.
const WITHIN: [&str; 2] = ["PaperKernels", "MiddleRowKernels"];

#[test]
fn every_table_of_kernels_is_tested() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src/backend/gpu");
    let mut found = 0;
    for file in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).filter(|path| path.is_file()) {
        let text = std::fs::read_to_string(file).unwrap();
        for table in text.split("kernels! {").skip(1).filter_map(|rest| rest.split("struct ").nth(1)) {
            let name = table.split_whitespace().next().unwrap();
            assert!(LISTED.contains(&name) || WITHIN.contains(&name), "{name} is not in `every_source`");
            found += 1;
        }
    }
    assert_eq!(found, LISTED.len() + WITHIN.len() - 2, "two of those listed are single kernels");
}

fn of_branches(setup: &Setup) -> Vec<Source> {
    <Option<BranchKernels>>::sources((setup.branches > 0).then_some(setup))
}

#[test]
fn a_middle_has_the_kernels_that_its_scene_needs() {
    let mut seen = [0; 4];
    for setup in setups().into_iter().filter(|setup| setup.midpoint) {
        let (inertia, grows) = (usize::from(setup.inertia()), usize::from(setup.growth.is_some()));
        assert_eq!(MotionKernels::sources(&setup).len(), 2 + inertia);
        let of_paper = [PaperKernels::sources(&setup).len(), MiddleRowKernels::sources(&setup).len(), grows];
        let more = if setup.branches == 0 { of_paper.iter().sum() } else { 0 };
        assert_eq!(RowKernels::sources(&setup).len(), 6 + more);
        if setup.branches > 0 {
            assert_eq!(of_branches(&setup).len(), 10 + grows);
        }
        seen[usize::from(setup.inertia()) + 2 * usize::from(setup.growth.is_some())] += 1;
    }
    assert!(seen.iter().all(|n| *n > 0), "{seen:?}");
}

#[test]
fn every_kernel_of_every_built_in_scene_is_valid() {
    for setup in setups() {
        for source in every_source(&setup) {
            validate(&source).unwrap_or_else(|e| panic!("{}: {e}", source.name()));
        }
    }
}

#[test]
fn no_kernel_binds_more_arrays_than_every_adapter_has() {
    for setup in setups() {
        for source in every_source(&setup) {
            assert!(source.code().matches("var<storage").count() <= 8, "{}", source.name());
        }
    }
}

#[test]
fn periods_are_in_the_kernels_of_pairs_alone_and_only_where_there_are_some() {
    for mut setup in setups().into_iter().filter(|setup| setup.lattice_periods.is_none()) {
        let open = every_source(&setup);
        // With branches, also the kernels that compute them.
        let own = of_branches(&setup);
        let others = ["passing", "branches", "stage", "aim", "bonds", "breaking bonds"];
        let of_bonds = usize::from(!setup.bonds.is_empty()) + usize::from(setup.bonds.may_break());
        let of_branches = own.iter().filter(|source| others.contains(&source.name())).count();
        let pairs = narrow_sources(&setup).len() + 1 + of_branches + of_bonds;
        let period = Some(5000.3 * setup.lattice.pitch());
        setup.lattice_periods = LatticePeriods::new(setup.lattice, [period, None, None]).unwrap();
        let periodic = every_source(&setup);
        assert!(open.iter().all(|source| !source.code().contains("PERIOD")));
        let changed: Vec<_> = open.iter().zip(&periodic).filter(|(a, b)| a.code() != b.code()).collect();
        assert_eq!(changed.len(), pairs);
        for (_, source) in changed {
            let name = source.name();
            assert!(name.starts_with("separations") || others.contains(&name), "{name}");
            validate(source).unwrap_or_else(|e| panic!("{name}: {e}"));
        }
    }
}

#[test]
fn the_report_is_laid_out_as_in_wgsl() {
    let setup = setups().remove(0);
    let inside = CandidateKernels::sources(&setup).into_iter().find(|s| s.name() == "inside").unwrap();
    let module = validate(&inside).unwrap();
    let mut layouter = naga::proc::Layouter::default();
    layouter.update(module.to_ctx()).unwrap();
    let (handle, report) = module.types.iter().find(|(_, t)| t.name.as_deref() == Some("Report")).unwrap();
    let naga::TypeInner::Struct { members, .. } = &report.inner else { panic!("not a struct") };
    assert_eq!(layouter[handle].size as usize, size_of::<Report>());
    let found: Vec<_> = members.iter().map(|member| (member.name.clone().unwrap(), member.offset)).collect();
    // Each field is one word. The debug text lists the field names in order.
    let text = format!("{:?}", Report::blank());
    let names = text.split(['{', ',', '}']).filter_map(|field| Some(field.split_once(':')?.0.trim().to_owned()));
    assert_eq!(found, names.zip((0..).step_by(4)).collect::<Vec<_>>());
}
