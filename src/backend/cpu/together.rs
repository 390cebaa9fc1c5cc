//! What of a step the CPU does together with other processes, where there are any, and by itself where there are none.

use super::Cpu;
#[cfg(feature = "mpi")]
use super::domain::Part;
use super::domain::{Domain, Trouble};
use super::row_set::RowSet;
use super::setup::Setup;
use super::start::Start;
use super::trial::Trial;
use crate::bisection::bisect;
use crate::bodies::Bodies;
use crate::broad_phase::{Aabb, Candidates};
#[cfg(feature = "mpi")]
use crate::constraint::RowSource;
use crate::dynamics::{Twist, Waiting};
use crate::lcp::Places;
#[cfg(feature = "mpi")]
use crate::processes::Processes;
use crate::separation::Placed;
use crate::step::{Fault, Passed, Piece, farthest_and_thinnest, may_pass, passed};
#[cfg(feature = "mpi")]
use crate::step::{Model, Rows, Stepping};

/// What a process starts from that has a part of the bodies.
#[cfg(feature = "mpi")]
pub(crate) struct Given {
    pub part: Part,
    /// Of all bodies.
    pub cutoff: f64,
    pub thinnest: f64,
}

/// Whether it is worth it to share out the bodies of a simulation, where that can be done at all. Rows of sub-spheres
/// and of the paper cannot be shared, and a bond in the middle of a step pulls from where bonds of its ends have led
/// these.
#[cfg(feature = "mpi")]
pub(crate) fn shares(model: &Model, processes: Processes) -> bool {
    let rows_of_surfaces = model.contact.rows_of_method() == Rows::Auto
        && matches!(model.contact.method.row_source(), RowSource::Surfaces);
    let bonds_in_middle = model.time.stepping == Stepping::Midpoint && !model.bonds.is_empty();
    processes.size() > 1 && rows_of_surfaces && !bonds_in_middle
}

impl<const D: usize> Cpu<D> {
    /// Takes a part of each step, where that is worth it; other processes, which must take the same steps from the same
    /// state, take the others. `given` is its part of the state that it starts from, and what of all bodies it cannot
    /// tell from it; none where all processes have all bodies.
    #[cfg(feature = "mpi")]
    pub(crate) fn share(mut self, processes: Processes, given: Option<Given>) -> Self {
        if let Some(Given { cutoff, thinnest, .. }) = given {
            (self.setup.cutoff, self.setup.thinnest) = (cutoff, thinnest);
        }
        self.domain = Some(Domain::new(processes, given.map(|given| given.part)));
        self
    }

    /// Grows the bodies of the step, and takes of them what is this process's: how their rows are ordered.
    pub(super) fn begin_with(&mut self, taken: (Piece, Waiting)) -> Result<Places, Fault> {
        let Cpu { setup, state, start, pairs, domain, .. } = self;
        let mut domain = domain.as_mut().and_then(|domain| domain.begin(state).then_some(domain));
        match &mut domain {
            Some(domain) => {
                start.begin(setup, state, &domain.by_place(&state.warm), taken);
                domain.leave_own(start);
                let mothers = start.divide(setup);
                domain.bear(start, state, &mothers);
            }
            None => {
                start.begin(setup, state, &state.warm, taken);
                start.divide(setup);
            }
        }
        start.grow(setup);
        let part = domain.and_then(|domain| domain.share_out(setup, start, state));
        start.settle(setup)?;
        Ok(match part {
            Some((places, warm)) => {
                pairs.remember(&warm);
                places
            }
            None => {
                pairs.remember(&state.warm);
                let blocks = bisect(&start.bodies.position, start.periods);
                let walls = start.bodies.len()..start.bodies.len() + setup.walls.len();
                let place = blocks.places().into_iter().chain(walls.map(|wall| wall as u32)).collect();
                Places { place, blocks: blocks.edges, domain: None }
            }
        })
    }

    /// The first trouble of all processes, from this one's.
    fn first_trouble(&self, own: Option<Trouble>) -> Option<Trouble> {
        self.domain.as_ref().map_or(own, |domain| domain.first(own))
    }

    /// Computes where the multipliers lead.
    ///
    /// # Errors
    /// [`Fault::NotFinite`] names the first body whose velocity or pose is not finite.
    pub(super) fn set_trial(&mut self) -> Result<(), Fault> {
        let Cpu { start, motions, rows, trial, domain, .. } = self;
        trial.set_scaled(rows);
        if let Some(domain) = domain {
            domain.exchange(&mut trial.scaled);
        }
        let own = trial.set(motions, start);
        match self.first_trouble(own) {
            Some(Trouble { kind, body, .. }) => {
                let what = if kind == 0 { "velocity" } else { "pose" };
                Err(Fault::NotFinite { step: self.step(), what, body })
            }
            None => Ok(()),
        }
    }

    /// Refuses bodies that are too long, too fast or too far off for the periods.
    pub(super) fn check_periods(&self) -> Result<(), Fault> {
        let (step, period) = (self.step(), self.start.periods.shortest());
        let Some(period) = period else { return Ok(()) };
        match self.first_trouble(self.motions.beyond_periods(&self.setup, &self.start)) {
            Some(Trouble { kind: 0, body, number }) => Err(Fault::PeriodTooShort { step, body, span: number, period }),
            Some(Trouble { body, .. }) => Err(Fault::TooFar { step, body }),
            None => Ok(()),
        }
    }

    /// The pairs that pass each other on their way to the trial.
    pub(super) fn find_passed(&self) -> Option<Passed> {
        let Cpu { setup, start, trial, domain, .. } = self;
        let course = (start.interval, setup.strain.and_then(|strain| strain.shear()));
        let separate = |a: &Placed, b: &Placed| Self::SEPARATE(a, b, None);
        let Some(domain) = domain.as_ref().filter(|domain| domain.is_shared()) else {
            return passed(&start.bodies, &trial.twist, course, separate);
        };
        let [farthest, thinnest] = farthest_and_thinnest(&start.bodies, &trial.twist, course);
        if !may_pass(domain.largest(farthest), -domain.largest(-thinnest)) {
            return None;
        }
        // Fast bodies may meet far from any halo.
        let (bodies, twists) = domain.all_moving(&start.bodies, &trial.twist)?;
        passed(&bodies, &twists, course, separate)
    }
}

/// The bodies at the end of a step, where their velocities have `arrived`.
pub(super) fn arrive<const D: usize>(
    domain: &mut Option<Domain>,
    (setup, start): (&Setup, &mut Start),
    rows: &RowSet<D>,
    trial: &Trial<D>,
    arrived: &[Twist],
) -> Bodies {
    let mut end = std::mem::take(&mut start.bodies);
    end.periods = start.periods;
    trial.arrive(&mut end, arrived);
    if let Some(incidence) = &start.bonds {
        setup.bonds.find_broken(incidence, &mut end);
    }
    if let Some(domain) = domain {
        let (bodies, own) = (end.len() as u32, |body: &u32| !start.is_foreign(*body as usize));
        let first = rows.problem.pair.iter().map(|[a, b]| if *b < bodies { *a.min(b) } else { *a });
        domain.arrive(setup, &mut end, first.filter(own));
    }
    end
}

/// The pairs that may be near: of all bodies, or of a domain.
pub(super) fn candidates<'a>(
    domain: &'a mut Option<Domain>,
    candidates: &'a mut Candidates,
    boxes: &[Aabb],
) -> Result<&'a [[u32; 2]], Fault> {
    match domain.as_mut().filter(|domain| domain.is_shared()) {
        Some(domain) => domain.candidates(boxes),
        None => Ok(candidates.ensure(boxes)),
    }
}
