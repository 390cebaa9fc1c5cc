//! The scenes whose ends are measured. They are small, and short enough that two schemes agree on their ends.

use super::pose::{Pose, poses};
use super::reference::Making;
use crate::StudyError;
use relcp::internals::record::Fnv;
use relcp::scene::{ContactSettings, Output, Scene, Solver, Stepping};

/// Starts that differ by less count as equal: sines differ in their last bits between machines.
const START_ROUNDING: f64 = 1e-9;

/// A scene that is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Problem {
    /// Its name.
    pub name: &'static str,
    /// Its description and the reason for its settings.
    pub about: &'static str,
    /// The built-in scene that it is made from.
    pub scene: &'static str,
    /// The settings that are changed.
    pub sets: &'static [&'static str],
    /// The time of the end, which each run's step divides.
    pub end: f64,
    /// Steps of the coarsest run; the others take this times powers of two.
    pub coarsest: u64,
    /// Sub-spheres of a body.
    pub spheres: &'static [u32],
    /// The method of its reference.
    pub making: Making,
    /// Its plot's file.
    pub plot: &'static str,
    /// Its reference's file.
    pub(super) stored: &'static str,
}

macro_rules! problem {
    ($name:literal, $($field:ident: $value:expr),* $(,)?) => {
        Problem {
            name: $name,
            plot: concat!("work-precision-", $name),
            stored: include_str!(concat!("../../../../assets/references/", $name, ".json")),
            $($field: $value),*
        }
    };
}

/// The overlap tolerance of midpoint runs. In the colony, which amplifies most, 1e-9 and 1e-11 change the end by 5e-8.
const TIGHT_OVERLAP: f64 = 1e-10;

/// The tolerance of LCPs: a tenth of that, as by default.
const TIGHT_SOLVER: f64 = 1e-11;

const fn making(midpoint_steps: u64, euler_steps: u64, euler_tolerance: f64) -> Making {
    Making {
        midpoint_steps,
        midpoint_tolerance: TIGHT_OVERLAP,
        euler_steps,
        euler_tolerance,
        solver_tolerance: TIGHT_SOLVER,
    }
}

/// All of them.
pub const PROBLEMS: [Problem; 5] = [
    problem!(
        "two-ellipsoids",
        about: "Two ellipsoids are pushed together, slide and turn past each other: the paper's refinement study.",
        scene: "two-ellipsoids",
        sets: &[],
        end: 40.0,
        coarsest: 100,
        spheres: &[7, 17],
        making: making(100 << 9, 100 << 9, 1e-5),
    ),
    problem!(
        "three-capsules",
        about: "Three capsules, the middle one turned by 0.01 radians, are pressed together along y and lie flat on each other: a contact between nearly parallel lines jumps from end to end. They start apart: where they overlap at the start, as in \
                the paper, a step of each scheme pushes them apart in a way of its own, and the two schemes converge to ends that are 0.5 apart at time 2.",
        scene: "three-capsules",
        sets: &[
            "bodies.0.group=lower",
            "bodies.2.group=upper",
            "bodies.0.position=[5,4.74,5.5]",
            "bodies.1.position=[5,5,5.5]",
            "bodies.2.position=[5,5.26,5.5]",
            r#"forces=[{"uniform":{"force":[0,1,0],"group":"lower"}},{"uniform":{"force":[0,-1,0],"group":"upper"}}]"#,
        ],
        end: 0.5,
        coarsest: 25,
        spheres: &[7, 27],
        making: making(25 << 12, 25 << 10, TIGHT_OVERLAP),
    ),
    problem!(
        "compaction",
        about: "36 ellipsoids are drawn towards the origin and pack, until most of them touch some others.",
        scene: "compaction",
        sets: &["generate.0.isotropic.count=36", "generate.0.isotropic.volume_fraction=0.1"],
        end: 20.0,
        coarsest: 50,
        spheres: &[7, 17],
        making: making(50 << 8, 50 << 8, 1e-5),
    ),
    problem!(
        "colony",
        about: "One cell grows and divides to eight, which lie end to end and buckle. A time unit is a doubling, so that cells divide at steps' starts whatever the step: a division that falls between two waits for the next, \
                which is an error of first order by any scheme. The buckling amplifies small differences: of the overlap tolerance too, and at sixteen cells, one doubling later, two schemes are 0.15 apart at tolerances of 1e-9.",
        scene: "colony",
        sets: &["growth.rate=0.6931471805599453", "growth.division_length=3.9999"],
        end: 4.0,
        coarsest: 64,
        spheres: &[7, 17],
        making: making(64 << 10, 64 << 9, 1e-8),
    ),
    problem!(
        "chainmail",
        about: "A sheet of 3 by 3 interlaced rings is stretched until its rings hold each other.",
        scene: "chainmail",
        sets: &["generate.0.chainmail.columns=3", "generate.0.chainmail.rows=3"],
        end: 2.0,
        coarsest: 16,
        spheres: &[32],
        making: making(16 << 9, 16 << 8, TIGHT_OVERLAP),
    ),
];

impl Problem {
    /// The scene at the coarsest step.
    ///
    /// # Errors
    /// [`StudyError::Scene`]; tests check that it does not occur.
    pub fn scene(&self) -> Result<Scene, StudyError> {
        let time = [format!("time.end={}", self.end), format!("time.dt={}", self.end / self.coarsest as f64)];
        let sets: Vec<String> = self.sets.iter().map(|set| (*set).to_owned()).chain(time).collect();
        let mut scene = Scene::load(self.scene, &sets)?;
        // The methods and tolerances are the cases'; so is the cutoff, which one of the built-in scenes sets.
        scene.contact = ContactSettings::default();
        Ok(scene)
    }

    /// Returns the unit of lengths: the length of the longest body at the start.
    ///
    /// # Errors
    /// As [`Problem::scene`].
    pub fn length(&self) -> Result<f64, StudyError> {
        let bodies = self.scene()?.build()?;
        Ok(bodies.shape.iter().map(|shape| shape.major_axis()).fold(0.0, f64::max))
    }

    /// Returns a hash of everything that the exact solution depends on: the scene without its steps, contact, solver
    /// and output, and the initial poses of its bodies.
    ///
    /// # Errors
    /// As [`Problem::scene`].
    pub fn hash(&self) -> Result<String, StudyError> {
        let mut scene = self.scene()?;
        let bodies = scene.build()?;
        scene.time.dt = 1.0;
        scene.time.stepping = Stepping::default();
        (scene.contact, scene.solver, scene.output) =
            (ContactSettings::default(), Solver::default(), Output::default());
        let mut hash = Fnv::default();
        hash.update(scene.to_json().as_bytes());
        for Pose { id, position, orientation } in poses(&bodies) {
            hash.update(&id.to_le_bytes());
            for number in position.into_iter().chain(orientation) {
                hash.update(&((number / START_ROUNDING).round() as i64).to_le_bytes());
            }
        }
        Ok(hash.hex())
    }
}
