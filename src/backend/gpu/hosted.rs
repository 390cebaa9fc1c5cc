//! The rows of scenes with friction, restitution or implicit bonds. The device finds contacts, makes their normal rows
//! and computes trials; the host reads the normal rows, adds tangents and bonds ([`crate::backend::cpu::hosted`]), and
//! writes the multipliers of normal rows and the velocities. It solves in f64, or the device does where a scene asks
//! for it ([`FrictionSolver`]).

use super::Setup;
use super::candidates::Candidates;
use super::lists::Lists;
use super::parted::Parted;
use super::row_set::RowSet;
use super::solve::with_joined;
use super::source::{NEAR, VIOLATING};
use crate::backend::cpu::hosted::{Broken, DeviceRow, DeviceStart, Hosted, hosted};
use crate::bodies::{Bodies, HeldBond};
use crate::dynamics::BondName;
use crate::freedom::SPATIAL;
use crate::gpu::{Gpu, GpuError, Precision};
use crate::lcp::gpu::{DeviceProblem, FrictionSolver};
use crate::lcp::{Outcome, Problem, Settings, SolverKind, Status};
use crate::separation::Separation;
use crate::separation::branches::branch_in_place;
use crate::step::{Effect, Fault, Model, State};
use crate::walls::{AtSurface, number_of};
use crate::warm::Warm;
use glam::DVec3;
use std::collections::{BTreeMap, HashMap, VecDeque};

/// In f32 a device solves to this part of the overlap tolerance at best, as without friction.
const FINEST_PER_OVERLAP: f64 = 0.1;

/// The host's part of the steps, and the contact of each row of the device.
pub(super) struct HostedRows {
    own: Box<dyn Hosted>,
    of_row: Vec<RowOf>,
    /// The device's own solver of contacts with friction.
    frictional: Option<Frictional>,
    /// In scenes with bonds whose bodies do not collide.
    pub parted: Option<Parted>,
}

/// What a row of the device belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct RowOf {
    /// The device's pair.
    pair: [u32; 2],
    /// The number of the contact on the host.
    contact: usize,
}

/// A row as it was read, with its pair; only its pair if it was made before.
type ReadRow = ([u32; 2], Option<DeviceRow>);

impl HostedRows {
    /// The host's part of a scene's steps; `None` if the device solves on its own.
    pub fn new(gpu: &Gpu, setup: &Setup, model: &Model, state: &State) -> Result<Option<Self>, GpuError> {
        let frictional = Frictional::new(gpu, setup, model)?;
        // The host has all methods for what the device leaves.
        let solver = if frictional.is_some() { SolverKind::Auto } else { model.solver };
        let own = hosted(&Model { solver, ..model.clone() }, state, setup.precision);
        let own = own.map_err(|fault| GpuError::Refused { message: fault.to_string() })?;
        let Some(own) = own else { return Ok(None) };
        Ok(Some(HostedRows { own, of_row: Vec::new(), frictional, parted: Parted::new(gpu, setup)? }))
    }

    /// Begins a step.
    pub fn begin(&mut self, gpu: &Gpu, start: DeviceStart) -> Result<(), Fault> {
        self.own.begin(start)?;
        if let Some(parted) = &mut self.parted {
            parted.write(gpu, self.own.without_contact())?;
        }
        Ok(())
    }

    /// The pairs that do not collide in the present step.
    pub fn without_contact(&self) -> &[[u32; 2]] {
        self.own.without_contact()
    }

    /// Takes over the first rows, made at the start or `ahead`, where `overlap` is the deepest overlap.
    pub fn take_first(
        &mut self,
        (gpu, setup): (&Gpu, &Setup),
        lists: &Lists,
        rows: &RowSet,
        (ahead, overlap): (bool, f64),
    ) -> Result<(), GpuError> {
        let (pairs, made): (Vec<_>, Vec<_>) = read_rows(gpu, setup, lists, (rows, NEAR))?.into_iter().unzip();
        self.of_row = pairs.into_iter().enumerate().map(|(contact, pair)| RowOf { pair, contact }).collect();
        let made: Vec<DeviceRow> = made.into_iter().flatten().collect();
        if self.own.make_first(&made, ahead, overlap) {
            let offsets = self.of_row.iter().map(|of| self.own.offset(of.contact));
            let bytes = setup.precision.encode(offsets);
            rows.problem.q.write(gpu, 0, &bytes);
            self.set_offsets(&setup.precision.decode(&bytes));
        }
        Ok(())
    }

    /// Takes over rows that were appended, and offsets that moved.
    pub fn take_appended(
        &mut self,
        (gpu, setup): (&Gpu, &Setup),
        lists: &Lists,
        rows: &RowSet,
    ) -> Result<(), GpuError> {
        let mut old: HashMap<[u32; 2], VecDeque<usize>> = HashMap::new();
        for RowOf { pair, contact } in &self.of_row {
            old.entry(*pair).or_default().push_back(*contact);
        }
        let (mut of_row, mut appended) = (Vec::new(), Vec::new());
        for (pair, made) in read_rows(gpu, setup, lists, (rows, VIOLATING))? {
            let contact = match made {
                Some(made) => {
                    appended.push(made);
                    self.own.contacts() + appended.len() - 1
                }
                None => old.get_mut(&pair).and_then(|old| old.pop_front()).ok_or_else(|| GpuError::Refused {
                    message: format!("a row of the pair {pair:?} is not known on the host"),
                })?,
            };
            of_row.push(RowOf { pair, contact });
        }
        self.own.append(&appended);
        self.of_row = of_row;
        self.take_offsets(gpu, setup, rows)
    }

    /// Takes over the offsets of all rows.
    pub fn take_offsets(&mut self, gpu: &Gpu, setup: &Setup, rows: &RowSet) -> Result<(), GpuError> {
        let q = &rows.problem.q;
        let read = gpu.record().read(&[(q, 0..rows.problem.rows * q.element() as u64)])?;
        self.set_offsets(&setup.precision.decode(&read[0]));
        Ok(())
    }

    fn set_offsets(&mut self, offsets: &[f64]) {
        for (of, offset) in self.of_row.iter().zip(offsets) {
            self.own.set_offset(of.contact, *offset);
        }
    }

    /// Solves from the present multipliers: on the device where the scene asks for it, and on the host what is left.
    pub fn solve(
        &mut self,
        gpu: &Gpu,
        (candidates, rows): (&mut Candidates, &mut RowSet),
        tolerance: f64,
    ) -> Result<Outcome, GpuError> {
        let HostedRows { own, of_row, frictional, .. } = self;
        let Some(frictional) = frictional.as_mut().filter(|_| !of_row.is_empty()) else {
            return Ok(own.solve(tolerance));
        };
        let contacts: Vec<usize> = of_row.iter().map(|of| of.contact).collect();
        let Some(packed) = own.packed(&contacts) else { return Ok(own.solve(tolerance)) };
        let solver = &mut frictional.solver;
        solver.set_settings(Settings { tolerance: tolerance.max(frictional.finest), ..solver.settings() });
        let solve = |problem: &mut DeviceProblem| solver.solve(gpu, problem, &packed);
        let (outcome, gammas) = with_joined(gpu, candidates, &mut rows.problem, solve)?;
        own.take_solved(&contacts, &gammas, &outcome, tolerance);
        if outcome.status == Status::Solved && outcome.residual <= tolerance {
            return Ok(outcome);
        }
        let rest = own.solve(tolerance);
        let (iterations, products) = (outcome.iterations + rest.iterations, outcome.products + rest.products);
        Ok(Outcome { iterations, products, ..rest })
    }

    /// Solves in the sense of the least overlap.
    pub fn relax(&mut self, allowed: f64) -> Option<Outcome> {
        self.own.relax(allowed)
    }

    /// Writes the multipliers of the normal rows, and the velocities of `bodies` that all multipliers give.
    pub fn write_trial(&mut self, gpu: &Gpu, setup: &Setup, rows: &RowSet, bodies: u64) {
        self.own.set_trial();
        let gamma = self.of_row.iter().map(|of| self.own.multiplier(of.contact));
        rows.problem.gamma.write(gpu, 0, &setup.precision.encode(gamma));
        let vectors = if setup.planar { 1 } else { 2 };
        let of_body = |body: u64| {
            let [x, y, z, u, v, w] = self.own.velocity(body as usize);
            [x, y, z, 0.0, u, v, w, 0.0].into_iter().take(4 * vectors)
        };
        rows.problem.velocity.write(gpu, 0, &setup.precision.encode((0..bodies).flat_map(of_body)));
    }

    /// The effect of contact up to the trial.
    pub fn effect(&self, gap: f64) -> Effect {
        self.own.effect(gap)
    }

    /// By how much the worst implicit bond is off at the trial, a length; and which one it is.
    pub fn stretch(&self) -> (f64, Option<(BondName, [usize; 2])>) {
        self.own.stretch()
    }

    /// Makes the rows of implicit bonds again at the trial.
    pub fn renew_bonds(&mut self) {
        self.own.renew_bonds();
    }

    /// Ends a step with the trial, and returns what breaks.
    pub fn accept(&mut self) -> Broken {
        self.own.accept()
    }

    /// The forces and torques of implicit bonds, by number.
    pub fn pulls(&self) -> &BTreeMap<usize, [DVec3; 2]> {
        self.own.pulls()
    }

    /// The bonds of daughters that hold in the state `bodies` after the last step.
    pub fn held_daughters(&self, bodies: &Bodies) -> Vec<HeldBond> {
        self.own.held_daughters(bodies)
    }

    /// The host's present problem and its multipliers.
    pub fn lcp(&self) -> (Problem<SPATIAL>, Vec<f64>) {
        self.own.lcp()
    }

    /// The number of rows, those of tangents too.
    pub fn rows(&self) -> usize {
        self.own.rows()
    }

    /// Continues from another state.
    pub fn load(&mut self, state: &State) {
        self.own.load(state);
        self.of_row.clear();
    }

    /// Replaces what the device knows of contacts by what the host does: it has more digits, and friction forces.
    /// Normals are the device's.
    pub fn complete(&self, warm: &mut Vec<Warm>) {
        let own = self.own.warm();
        let mut used = vec![false; own.len()];
        for warm in warm.iter_mut() {
            let found = own.binary_search_by_key(&(warm.pair, warm.feature), |own| (own.pair, own.feature)).ok();
            (warm.gamma, warm.tangent) = found.map_or((0.0, DVec3::ZERO), |at| {
                used[at] = true;
                (own[at].gamma, own[at].tangent)
            });
        }
        let left = own.iter().zip(used).filter(|(_, used)| !used).map(|(own, _)| *own);
        warm.extend(left);
        warm.sort_by_key(|warm| (warm.pair, warm.feature));
    }
}

/// The device's own solver of contacts with friction.
struct Frictional {
    solver: FrictionSolver,
    /// The least tolerance that it solves to; the host goes on from there.
    finest: f64,
}

impl Frictional {
    /// That of a scene which names `pair_block_cg`; none without friction, with bonds among the rows, or with another
    /// method. `auto` solves on the host: on a software adapter an iteration takes four times as long
    /// (docs/notes/friction-solver.md), and no hardware was measured.
    fn new(gpu: &Gpu, setup: &Setup, model: &Model) -> Result<Option<Self>, GpuError> {
        let asked = model.solver == SolverKind::PairBlockCg;
        if model.friction.is_none() || model.bonds.first_implicit().is_some() || !asked {
            return Ok(None);
        }
        let mut solver = FrictionSolver::new(gpu, setup.precision, setup.planar, model.lcp)?;
        let finest = match setup.precision {
            Precision::F32 => FINEST_PER_OVERLAP * model.contact.overlap_tolerance,
            Precision::F64 => 0.0,
        };
        solver.compile(gpu)?;
        Ok(Some(Frictional { solver, finest }))
    }
}

/// Reads all rows, in their order. Those that were made since the last call of [`RowSet::begin`] or [`RowSet::extend`]
/// come with their contacts. Of the paper's rows these are the last rows of pairs whose flag is at least the threshold.
fn read_rows(
    gpu: &Gpu,
    setup: &Setup,
    lists: &Lists,
    (rows, threshold): (&RowSet, u32),
) -> Result<Vec<ReadRow>, GpuError> {
    let (problem, pairs) = (&rows.problem, lists.pairs_count);
    let of_rows = |element: usize| 0..problem.rows * element as u64;
    let contacts = match &rows.branches {
        Some(branches) => (branches.staged(), of_rows(branches.staged().element())),
        None => (&lists.contacts, 0..pairs * lists.contacts.element() as u64),
    };
    let read = gpu.record().read(&[
        (&lists.pairs, 0..8 * pairs),
        (&problem.block_start, 0..4 * (pairs + 1)),
        contacts,
        (&problem.jacobian, of_rows(problem.jacobian.element())),
        (&problem.q, of_rows(problem.q.element())),
    ])?;
    let pairs: Vec<[u32; 2]> = bytemuck::pod_collect_to_vec(&read[0]);
    let starts: Vec<u32> = bytemuck::pod_collect_to_vec(&read[1]);
    let [contacts, jacobian, q] = [2, 3, 4].map(|i| setup.precision.decode(&read[i]));
    let width = if setup.planar { 4 } else { 8 };
    // The place of a branch and its contact, of a row that is new.
    let made = |nth: usize, row: usize| {
        let contact = |at: usize| &contacts[12 * at..12 * at + 12];
        if rows.branches.is_some() {
            return (contact(row)[11] as u32).checked_sub(1).map(|place| (place, contact(row)));
        }
        let is_new = row + 1 == starts[nth + 1] as usize && contact(nth)[11] as u32 >= threshold;
        is_new.then(|| (0, contact(nth)))
    };
    let row = |nth: usize, row: usize| {
        let block = |side: usize| {
            let at = (2 * row + side) * width;
            std::array::from_fn(|k| if k / 3 * 4 < width { jacobian[at + k / 3 * 4 + k % 3] } else { 0.0 })
        };
        let row_of = |(place, contact)| device_row(pairs[nth], place, contact, [block(0), block(1)], q[row]);
        (pairs[nth], made(nth, row).map(row_of))
    };
    let of_pair = |(nth, range): (usize, &[u32])| (range[0]..range[1]).map(move |at| (nth, at as usize));
    Ok(starts.windows(2).enumerate().flat_map(of_pair).map(|(nth, at)| row(nth, at)).collect())
}

/// A row of a pair's branch in this place, from its contact (`shaders/constraint/stage.wgsl`, and
/// `shaders/separation/narrow.wgsl` for the paper's rows).
fn device_row([a, b]: [u32; 2], place: u32, staged: &[f64], blocks: [[f64; SPATIAL]; 2], offset: f64) -> DeviceRow {
    let vector = |at: usize| DVec3::new(staged[at], staged[at + 1], staged[at + 2]);
    let found = Separation { separation: staged[3], normal: vector(0), lever_a: vector(4), lever_b: vector(8) };
    let (second, feature) = match AtSurface::of_number(b) {
        Some(at) => (number_of(at.surface), at.place),
        None => (b, branch_in_place(place)),
    };
    DeviceRow { pair: [a, second], feature, found, blocks, offset }
}
