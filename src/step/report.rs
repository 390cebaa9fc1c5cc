//! What a step did: the figures that a run logs, sums up and is judged by.

use super::Passed;
use crate::lcp::Status;
use crate::step::{Effect, Overlap};
use std::ops::AddAssign;
use std::time::Duration;

/// Wall time by phase.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Phases {
    /// Finding candidate pairs.
    pub broad_phase: Duration,
    /// Separations, rows, violations.
    pub narrow_phase: Duration,
    /// LCP solves, seconds.
    pub solve: Duration,
    /// Forces, mobilities, trial configurations.
    pub integrate: Duration,
    /// Growth and division.
    pub growth: Duration,
}

impl AddAssign for Phases {
    fn add_assign(&mut self, other: Phases) {
        self.broad_phase += other.broad_phase;
        self.narrow_phase += other.narrow_phase;
        self.solve += other.solve;
        self.integrate += other.integrate;
        self.growth += other.growth;
    }
}

/// What one step did.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct StepReport {
    /// Its number, from 1.
    pub step: u64,
    /// Time after it.
    pub time: f64,
    /// Bodies after it.
    pub bodies: usize,
    /// Bodies that were removed at its end. Pairs that the report names are of the numbers before.
    pub removed: usize,
    /// Rows of its last LCP.
    pub constraints: usize,
    /// Recursions after its first solve.
    pub recursions: u32,
    /// LCP iterations, over all its solves.
    pub iterations: u64,
    /// Applications of `A`, over all its solves.
    pub products: u64,
    /// Solves that the safeguard of the solver `auto` went on with.
    pub fallbacks: u32,
    /// Residual that its last solve ended with, a length; the largest of those that did not reach their tolerance,
    /// where some did not.
    pub residual: f64,
    /// Solves that did not reach the solver's tolerance.
    pub unconverged: u32,
    /// Solves whose rows contradict each other, or nearly do, and that were solved in the sense of the least overlap.
    pub relaxed: u32,
    /// Residual of the solves behind the accepted velocities, a length: of the last solve; in a midpoint step, the
    /// larger one of both halves; of a step in pieces the largest one. It is what velocities times `dt` may be off by.
    pub velocity_residual: f64,
    /// Into how many pieces it was cut: 1 where it was taken at once.
    pub pieces: u32,
    /// Attempts that failed before it was taken.
    pub failed_attempts: u32,
    /// Whether the CPU took it in the place of a device.
    pub by_cpu: bool,
    /// Whether bodies overlapped too deeply for the step and were separated before it, without advancing time.
    pub parted: bool,
    /// Pieces that were taken as well as they go, off by less than the cutoff, and then parted in no time.
    pub squeezed: u32,
    /// Cells that had to wait, as there was no room for them.
    pub waiting: usize,
    /// `Solved`, or how the last of its solves that did not converge ended.
    pub status: Status,
    /// Largest overlap of smooth surfaces in the trial of its first solve, a length: what the recursion then takes
    /// away. Of a midpoint step its second half's.
    pub first_violation: f64,
    /// Largest true overlap of smooth surfaces, with each other or with walls, in the accepted configuration, a length.
    pub max_overlap: f64,
    /// The pair of bodies that overlaps by `max_overlap`, where one does.
    pub worst_pair: Option<[usize; 2]>,
    /// The body and the wall (by its place in the scene's list) that overlap by it, where they do.
    pub worst_wall: Option<[usize; 2]>,
    /// Pairs of bodies that went through each other on the step's way; none where no pair did.
    pub passed: Option<Passed>,
    /// Largest overlap between sub-spheres, where the method makes its rows from them.
    pub proxy_overlap: Option<f64>,
    /// Rows that were made anew as they pushed apart what no longer touched.
    pub loosened: u32,
    /// How often rows that contradict each other were tilted.
    pub tilts: u32,
    /// The farthest that contact moved a body's centre from where its free motion leads, a length; of a step in pieces
    /// that of all pieces together at most.
    pub largest_move: f64,
    /// The body that it moved so far.
    pub moved: Option<usize>,
    /// The largest separation of a contact that pushes, a length; zero where contact parts no bodies by more than 0.005
    /// of the thinner one's thickness.
    pub largest_push_gap: f64,
    /// The energy that contact added, where bodies have inertia; negative where it took some.
    pub contact_energy: f64,
    /// The largest angle by which contact turned a body of revolution about its own axis.
    pub axial_spin: f64,
    /// Wall time by phase.
    pub phases: Phases,
}

impl Default for StepReport {
    fn default() -> Self {
        StepReport {
            step: 0,
            time: 0.0,
            bodies: 0,
            removed: 0,
            constraints: 0,
            recursions: 0,
            iterations: 0,
            products: 0,
            fallbacks: 0,
            residual: 0.0,
            unconverged: 0,
            relaxed: 0,
            velocity_residual: 0.0,
            pieces: 0,
            failed_attempts: 0,
            by_cpu: false,
            parted: false,
            squeezed: 0,
            waiting: 0,
            status: Status::Solved,
            first_violation: 0.0,
            max_overlap: 0.0,
            worst_pair: None,
            worst_wall: None,
            passed: None,
            proxy_overlap: None,
            loosened: 0,
            tilts: 0,
            largest_move: 0.0,
            moved: None,
            largest_push_gap: 0.0,
            contact_energy: 0.0,
            axial_spin: 0.0,
            phases: Phases::default(),
        }
    }
}

impl StepReport {
    /// Records the accepted configuration.
    pub(super) fn measure(&mut self, overlap: &Overlap, step: u64, bodies: usize) {
        self.step = step;
        self.bodies = bodies;
        self.max_overlap = overlap.worst;
        self.worst_pair = overlap.pair;
        self.worst_wall = overlap.wall;
        self.proxy_overlap = overlap.proxy;
    }

    /// Takes what contact did.
    pub(super) fn take_effect(&mut self, effect: &Effect) {
        (self.largest_move, self.moved) = (effect.largest_move, effect.moved);
        self.largest_push_gap = effect.push_gap;
        (self.contact_energy, self.axial_spin) = (effect.energy, effect.axial_spin);
    }

    /// Adds what contact did in a piece.
    pub(super) fn join_effect(&mut self, piece: &StepReport) {
        if piece.largest_move > self.largest_move || self.moved.is_none() {
            self.moved = piece.moved;
        }
        self.largest_move += piece.largest_move;
        self.largest_push_gap = self.largest_push_gap.max(piece.largest_push_gap);
        self.contact_energy += piece.contact_energy;
        self.axial_spin += piece.axial_spin;
    }

    /// Whether the accepted configuration holds the overlap tolerance.
    pub fn within(&self, overlap_tolerance: f64) -> bool {
        self.max_overlap <= overlap_tolerance
    }

    /// Whether the accepted velocities come from solves that are right to the overlap tolerance. One that missed the
    /// solver's own tolerance, a tenth of it unless the scene says otherwise, and not this is worth a note, no more.
    pub fn settled(&self, overlap_tolerance: f64) -> bool {
        self.velocity_residual <= overlap_tolerance
    }
}
