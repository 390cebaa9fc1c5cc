//! What a step did: the figures that a run logs, sums up and is judged by.

use super::Passed;
use crate::lcp::{Outcome, Status};
use crate::step::{Effect, Overlap};
use std::ops::AddAssign;
use std::time::Duration;

/// The phases of a step whose wall times are taken, each with its doc, its name, and its name in tables.
macro_rules! step_phases {
    ($then:ident) => {
        $then! {
            /// Finding candidate pairs.
            broad_phase, "broad phase";
            /// Separations, rows, violations.
            narrow_phase, "narrow phase";
            /// The LCPs.
            solve, "solve";
            /// Forces, mobilities, trial configurations.
            integrate, "integrate";
            /// Growth and division.
            growth, "growth";
        }
    };
}
#[cfg(any(feature = "files", test))]
pub(crate) use step_phases;

macro_rules! phases {
    ($($(#[$doc:meta])* $name:ident, $label:literal;)*) => {
        /// Wall time by phase.
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        #[non_exhaustive]
        pub struct Phases {
            $($(#[$doc])* pub $name: Duration,)*
        }

        impl AddAssign for Phases {
            fn add_assign(&mut self, other: Phases) {
                $(self.$name += other.$name;)*
            }
        }
    };
}

step_phases!(phases);

/// The figures of a step: each with its doc, its type, its value before a step, how that of a piece joins that of a
/// step in pieces, and in braces where else it is. `$then!` gets all of them; so what has a figure for each is written
/// once: the report, how pieces join, `steps.csv`, a run's totals, the report in Python and its stub.
///
/// * `sum`: of all pieces. `most`: the largest one's. `last`: the last piece's. `first`: the first one's that there is.
///   `total`: the sum of those that there are.
/// * `own`: no figure of a piece; what takes the step says it. `solves`: as [`StepReport::join_solves`] says.
///
/// In braces, in this order:
/// * `column(type = "absent")`: it is a column of `steps.csv`; the rows of files that were begun before it was have
///   `absent` there.
/// * `counts(name: type = how)`: whole numbers of [`Totals`](crate::record::Totals), each the `sum`, the `most` or the
///   `last` of the steps' figures, or the number of `steps` that have some or `several`. `retried(...)`: the same of
///   [`Retried`](crate::record::Retried).
/// * `total(name)`: an energy of [`Totals`](crate::record::Totals), the sum of the steps' that have some.
/// * `largest(name)`: a length, an energy or an angle of [`Totals`](crate::record::Totals), the largest of the steps'.
macro_rules! step_figures {
    ($then:ident) => {
        $then! {
            /// Its number, from 1.
            step: u64 = 0, own, { column(u64) };
            /// Time after it.
            time: f64 = 0.0, own, { column(f64) };
            /// Bodies after it.
            bodies: usize = 0, own, { column(usize) };
            /// Bodies removed at its end. The report's pairs have the indices before.
            removed: usize = 0, own, {};
            /// Rows of its last LCP.
            constraints: usize = 0, last, {
                column(usize)
                counts(constraints: u64 = sum, final_constraints: u64 = last, max_constraints: u64 = most)
            };
            /// Recursions after its first solve.
            recursions: u32 = 0, sum, { column(u32) counts(recursions: u64 = sum, max_recursions: u32 = most) };
            /// LCP iterations, over all its solves.
            iterations: u64 = 0, sum, { column(u64) counts(iterations: u64 = sum) };
            /// Applications of the LCP's matrix `A`, over all its solves.
            products: u64 = 0, sum, { column(u64) counts(products: u64 = sum) };
            /// Solves that the safeguard of the solver `auto` went on with.
            fallbacks: u32 = 0, sum, { counts(fallbacks: u64 = sum) };
            /// Residual that its last solve ended with, a length; the largest of those that did not reach their
            /// tolerance, where some did not.
            residual: f64 = 0.0, solves, { column(f64) largest(worst_residual) };
            /// Solves that did not reach the solver's tolerance.
            unconverged: u32 = 0, solves, { counts(unconverged: u64 = sum) };
            /// `Solved`, or how the last of its solves that did not converge ended.
            status: Status = Status::Solved, solves, {};
            /// Residual of the solves behind the accepted velocities, a length: of the last solve; in a midpoint step,
            /// the larger one of both halves; of a step in pieces the largest one. It is what velocities times `dt` may
            /// be off by.
            velocity_residual: f64 = 0.0, most, {};
            /// Largest overlap of smooth surfaces in the trial of its first solve, a length: what the recursion then
            /// takes away. Of a midpoint step its second half's.
            first_violation: f64 = 0.0, own, { column(f64) };
            /// Largest true overlap of smooth surfaces, with each other or with walls, in the accepted configuration, a
            /// length.
            max_overlap: f64 = 0.0, own, { column(f64) largest(max_overlap) };
            /// The pair of bodies that overlaps by `max_overlap`, where one does.
            worst_pair: Option<[usize; 2]> = None, own, {};
            /// The body and the wall (by its index in the scene) that overlap by it, if they do.
            worst_wall: Option<[usize; 2]> = None, own, {};
            /// Pairs of bodies that went through each other on the step's way; none where no pair did.
            passed: Option<Passed> = None, first, {};
            /// Largest overlap between sub-spheres, where the method makes its rows from them.
            proxy_overlap: Option<f64> = None, own, {};
            /// The number of pieces that it was taken in: 1 for a whole step.
            pieces: u32 = 0, own, {
                column(Option<u32> = "1")
                retried(in_pieces: u64 = several, most_pieces: u32 = most)
            };
            /// Whether the CPU took the step instead of a device.
            by_cpu: bool = false, own, { retried(by_cpu: u64 = steps) };
            /// Whether bodies overlapped too deeply for the step and were separated before it, without advancing time.
            parted: bool = false, own, {};
            /// Pieces that were taken as well as they go, off by less than the cutoff, and then parted in no time.
            squeezed: u32 = 0, sum, { retried(squeezed: u64 = steps) };
            /// Pieces in which daughters turned less than they drew, as there was no room.
            turned_less: u32 = 0, sum, { retried(turned_less: u64 = steps) };
            /// Pieces before which cells that pressed each other and found no way out were moved by a draw.
            shaken: u32 = 0, sum, { retried(shaken: u64 = steps) };
            /// Pieces whose contacts had no restitution, as it would have made energy.
            restitution_dropped: u32 = 0, sum, { retried(restitution_dropped: u64 = steps) };
            /// Cells that had to wait, as there was no room for them.
            waiting: usize = 0, own, { retried(with_waiting_cells: u64 = steps) };
            /// Attempts that failed before it was taken.
            failed_attempts: u32 = 0, own, { retried(failed_attempts: u64 = sum) };
            /// Solves whose rows contradict each other, or nearly do, and that were solved in the sense of the least
            /// overlap.
            relaxed: u32 = 0, sum, { retried(relaxed_solves: u64 = sum) };
            /// How often rows that contradict each other were tilted.
            tilts: u32 = 0, sum, { retried(tilted: u64 = steps) };
            /// Rows that were rebuilt because they pushed bodies that no longer touched.
            loosened: u32 = 0, sum, { counts(steps_loosened: u64 = steps) };
            /// The farthest that contact moved a body's centre from where its free motion leads, a length; of a step in
            /// pieces that of all pieces together at most.
            largest_move: f64 = 0.0, sum, { column(Option<f64> = "") largest(largest_move) };
            /// The body that it moved so far; of a step in pieces that of the piece that moved one farthest.
            moved: Option<usize> = None, own, {};
            /// The largest separation of a contact that pushes, a length; zero where contact parts no bodies by more
            /// than 0.005 of the thinner one's thickness.
            largest_push_gap: f64 = 0.0, most, { column(Option<f64> = "") largest(largest_push_gap) };
            /// The energy that contact added, if bodies have inertia; negative if it removed some.
            contact_energy: f64 = 0.0, sum, { column(Option<f64> = "") largest(largest_contact_energy) };
            /// The largest angle by which contact turned a body of revolution about its own axis.
            axial_spin: f64 = 0.0, sum, { column(Option<f64> = "") largest(largest_axial_spin) };
            /// Bonds that broke. On a device they are not counted by step.
            broken_bonds: u32 = 0, sum, { column(Option<u32> = "") counts(broken_bonds: u64 = sum) };
            /// Contacts that push and slide, so that their friction is at its limit; none in a scene without friction.
            sliding: Option<usize> = None, last, { column(Option<usize> = "") };
            /// Contacts with friction that push and stick.
            sticking: Option<usize> = None, last, { column(Option<usize> = "") };
            /// The energy that friction took, with what the springs of stick took up.
            friction_work: Option<f64> = None, total, { column(Option<f64> = "") total(friction_work) };
            /// Solves in which the law of friction was not met to the tolerance, so that its corrections were held.
            friction_held: u32 = 0, sum, { counts(friction_held: u64 = sum) };
            /// What friction's law is off by, a length: the largest gap at a contact that pushes, or slip of one that
            /// has friction left.
            friction_gap: f64 = 0.0, most, { largest(largest_friction_gap) };
        }
    };
}
#[cfg(any(feature = "files", test))]
pub(crate) use step_figures;

macro_rules! report {
    ($($(#[$doc:meta])* $name:ident: $type:ty = $before:expr, $joins:ident, $elsewhere:tt;)*) => {
        /// What one step did.
        #[derive(Clone, Copy, Debug, PartialEq)]
        #[non_exhaustive]
        pub struct StepReport {
            $($(#[$doc])* pub $name: $type,)*
            /// Wall time by phase.
            pub phases: Phases,
        }

        impl Default for StepReport {
            fn default() -> Self {
                StepReport { $($name: $before,)* phases: Phases::default() }
            }
        }

        impl StepReport {
            /// Adds a piece that was accepted after those that are in it.
            pub(super) fn add_piece(&mut self, piece: &StepReport) {
                self.join_moved(piece);
                self.join_solves(piece);
                $(join!($joins, self.$name, piece.$name);)*
                self.pieces += 1;
                self.phases += piece.phases;
            }
        }
    };
}

/// Joins a figure of a piece to that of a step.
macro_rules! join {
    (sum, $of_step:expr, $of_piece:expr) => {
        $of_step += $of_piece
    };
    (most, $of_step:expr, $of_piece:expr) => {
        $of_step = $of_step.max($of_piece)
    };
    (last, $of_step:expr, $of_piece:expr) => {
        $of_step = $of_piece
    };
    (first, $of_step:expr, $of_piece:expr) => {
        $of_step = $of_step.or($of_piece)
    };
    (total, $of_step:expr, $of_piece:expr) => {
        $of_step = match ($of_step, $of_piece) {
            (Some(of_step), Some(of_piece)) => Some(of_step + of_piece),
            (of_step, of_piece) => of_step.or(of_piece),
        }
    };
    (own, $of_step:expr, $of_piece:expr) => {};
    (solves, $of_step:expr, $of_piece:expr) => {};
}

step_figures!(report);

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
        self.sliding = effect.friction.map(|friction| friction.sliding);
        self.sticking = effect.friction.map(|friction| friction.sticking);
        self.friction_work = effect.friction.map(|friction| friction.work);
        self.friction_gap = effect.friction.map_or(0.0, |friction| friction.gap);
    }

    /// Adds how far bodies were moved to part them.
    pub(super) fn add_parting(&mut self, parting: &StepReport) {
        self.join_moved(parting);
        self.largest_move += parting.largest_move;
    }

    /// Names the body of the piece that moved one farthest so far.
    fn join_moved(&mut self, piece: &StepReport) {
        if piece.largest_move > self.largest_move || self.moved.is_none() {
            self.moved = piece.moved;
        }
    }

    /// Adds how the solves of a piece ended.
    fn join_solves(&mut self, piece: &StepReport) {
        if piece.unconverged > 0 {
            self.status = piece.status;
            self.residual = if self.unconverged > 0 { self.residual.max(piece.residual) } else { piece.residual };
        } else if self.unconverged == 0 {
            self.residual = piece.residual;
        }
        self.unconverged += piece.unconverged;
    }

    /// Adds the cost of an attempt that was not accepted.
    pub(super) fn add_cost(&mut self, failed: &StepReport) {
        self.iterations += failed.iterations;
        self.products += failed.products;
        self.fallbacks += failed.fallbacks;
        self.failed_attempts += 1;
    }

    /// Adds one solve, and the one that replaced it if it failed.
    pub(super) fn count(&mut self, outcome: &Outcome, relaxed: Option<&Outcome>) {
        for outcome in [Some(outcome), relaxed].into_iter().flatten() {
            self.add_solve(outcome);
        }
        self.judge(relaxed.unwrap_or(outcome));
    }

    /// Adds what a solve cost.
    pub(super) fn add_solve(&mut self, outcome: &Outcome) {
        self.iterations += outcome.iterations;
        self.products += outcome.products;
        self.fallbacks += u32::from(outcome.fallback);
    }

    /// Takes note of how a solve ended.
    pub(super) fn judge(&mut self, last: &Outcome) {
        self.relaxed += u32::from(matches!(last.status, Status::LeastOverlap | Status::WithoutFriction));
        self.friction_held += u32::from(last.status == Status::HeldFriction);
        match last.status {
            Status::Solved | Status::LeastOverlap if self.unconverged == 0 => self.residual = last.residual,
            Status::Solved | Status::LeastOverlap => {}
            failed => {
                self.residual = if self.unconverged > 0 { self.residual.max(last.residual) } else { last.residual };
                self.unconverged += 1;
                self.status = failed;
            }
        }
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
