//! The verbs carried out.

use super::narrow_phase::Earlier;
use super::team::Team;
use super::{Cpu, boxes, narrow_phase, near, timed, walls};
use crate::dynamics::Waiting;
use crate::freedom::PLANAR;
use crate::lcp::{Outcome, Status, Stored};
use crate::step::{Effect, Failed, Fault, Overlap, Passed, Phases, Piece, Surplus, Take, TwoSided, Verbs};
use std::time::Instant;

impl<const D: usize, T: Team> Verbs for Cpu<D, T> {
    fn begin(&mut self) -> Result<(), Fault> {
        let begun = Instant::now();
        let step = self.step();
        // A step that is taken again was led astray once: its pieces are linearised at their starts.
        let whole = self.next.is_none() && !self.start.parting;
        let taken = self.next.take().unwrap_or((Piece::WHOLE, Waiting::None));
        self.begin_with(taken, whole)?;
        self.trial.begin();
        self.rebuilt.clear();
        let Cpu { setup, start, motions, first, candidates, phases, .. } = self;
        candidates.set_periods(start.periods);
        phases.growth += begun.elapsed();
        let begun = Instant::now();
        setup.prepare(start, step)?;
        first.predict(setup, start, D == PLANAR && setup.leads_ahead && whole);
        motions.set(setup, start, first, step);
        phases.integrate += begun.elapsed();
        Ok(())
    }

    fn middle(&mut self) -> Result<(), Fault> {
        let begun = Instant::now();
        let step = self.step();
        self.set_trial()?;
        let left = self.warm_start();
        let Cpu { setup, start, motions, first, pairs, trial, phases, .. } = self;
        pairs.remember(&left);
        let mut middle = start.bodies.clone();
        middle.periods = start.periods;
        trial.arrive(&mut middle, &trial.arrived(setup, start, motions));
        trial.begin();
        start.set_middle(setup, middle);
        first.set_middle(&trial.twist, &trial.poses);
        setup.prepare(start, step)?;
        motions.set(setup, start, first, step);
        phases.integrate += begun.elapsed();
        Ok(())
    }

    fn append_near(&mut self) -> Result<(), Fault> {
        self.append_first()?;
        if self.first.is_too_deep(&self.setup) {
            self.first.predict(&self.setup, &self.start, false);
            self.motions.set(&self.setup, &self.start, &self.first, self.state.step + 1);
            self.append_first()?;
        }
        Ok(())
    }

    fn solve(&mut self, tolerance: f64) -> Result<Outcome, Fault> {
        let Cpu { phases, solve, rows, team, .. } = self;
        let outcome = timed(&mut phases.solve, || {
            rows.set_changed(|changed| team.any(changed));
            solve.solve(rows, tolerance)
        });
        if outcome.status == Status::TooLarge {
            return Err(Fault::TooLarge { step: self.step(), rows: self.constraints() });
        }
        Ok(outcome)
    }

    fn relax(&mut self, allowed: f64) -> Result<Option<Outcome>, Fault> {
        let Cpu { phases, solve, rows, .. } = self;
        Ok(timed(&mut phases.solve, || solve.relax(rows, allowed)))
    }

    fn trial(&mut self, violating: f64) -> Result<Overlap, Fault> {
        let begun = Instant::now();
        self.set_trial()?;
        let Cpu { setup, start, pairs, trial, candidates, team, phases, .. } = self;
        phases.integrate += begun.elapsed();
        let begun = Instant::now();
        let boxes = boxes(&start.bodies.shape, |i| trial.poses[i], |_| 0.0);
        let candidates = team.candidates(candidates, &boxes)?;
        phases.broad_phase += begun.elapsed();
        let begun = Instant::now();
        let placed = |a: usize, b: usize| trial.pair(start, a, b);
        let limit = |a: usize, b: usize| if start.never_collide(a, b) { f64::NEG_INFINITY } else { 0.0 };
        let rests = trial.rests();
        let earlier = Earlier { found: &trial.overlapping, rests: &rests };
        let mut overlapping = narrow_phase::within(candidates, (pairs, earlier), Self::SEPARATE, placed, limit);
        pairs.renew(&overlapping);
        let bodies = start.bodies.len();
        let limit = |i: usize| if start.is_idle(i) { f64::NEG_INFINITY } else { 0.0 };
        near::join(&mut overlapping, walls::near(start.walls(setup), bodies, |i| trial.placed(start, i), limit));
        let own = trial.set_overlapping(setup, start, overlapping, violating);
        let worst = || trial.worst().map(|near| (near.pair, near.found.separation));
        let mut overlap = team.all_overlaps(own, worst, &setup.walls);
        (overlap.stretch, overlap.bond) = self.stretch();
        self.phases.narrow_phase += begun.elapsed();
        Ok(overlap)
    }

    fn effect(&mut self, gap: f64) -> Result<Effect, Fault> {
        let begun = Instant::now();
        let effect = self.team.all_effects(self.find_effect(gap));
        self.phases.narrow_phase += begun.elapsed();
        Ok(effect)
    }

    fn two_sided(&mut self) -> Option<&mut dyn TwoSided> {
        if self.team.is_distributed() { None } else { Some(self) }
    }

    fn throws(&mut self, gap: f64) -> Result<bool, Fault> {
        Ok(self.effect(gap)?.apart > 0)
    }

    fn append_violations(&mut self, over_corrects: bool) -> Result<(), Fault> {
        let surplus = if over_corrects { Surplus::of(self.setup.thinnest) } else { Surplus::NONE };
        self.answer_violations(false, surplus);
        Ok(())
    }

    fn tighten_violations(&mut self) -> Result<(), Fault> {
        self.answer_violations(true, Surplus::NONE);
        Ok(())
    }

    fn renew_bonds(&mut self) -> Result<(), Fault> {
        let begun = Instant::now();
        self.make_bonds_again();
        self.phases.narrow_phase += begun.elapsed();
        Ok(())
    }

    fn passed(&mut self) -> Result<Option<Passed>, Fault> {
        let begun = Instant::now();
        let passed = self.find_passed();
        self.phases.narrow_phase += begun.elapsed();
        Ok(passed)
    }

    fn accept(&mut self) -> Result<Phases, Fault> {
        let begun = Instant::now();
        // What parts bodies in no time is no force, and no motion.
        let left = if self.start.parting { Vec::new() } else { self.warm_start() };
        let Cpu { setup, state, start, motions, rows, trial, team, broken, phases, .. } = self;
        state.warm = team.with_global_indices(left);
        let arrived = trial.arrived(setup, start, motions);
        let mut end = std::mem::take(&mut start.bodies);
        end.periods = start.periods;
        trial.arrive(&mut end, &arrived);
        start.leave_walls(&mut end.walls);
        if let Some(incidence) = &start.bonds {
            setup.bonds.find_broken(incidence, &mut end);
        }
        let mut of_daughters = 0;
        if !start.parting {
            of_daughters = start.break_bonds(setup, rows, &mut end).len() as u32;
            end.bonds = if team.is_distributed() { Vec::new() } else { start.held_after(setup, rows, &end) };
        }
        let (bodies, own) = (end.len() as u32, |body: &u32| !start.is_foreign(*body as usize));
        let first = rows.problem.pair.iter().map(|[a, b]| if *b < bodies { *a.min(b) } else { *a });
        team.finish_step(setup, &mut end, first.filter(own));
        // Of all processes, which `finish_step` brings together.
        let of_scene = (end.broken_bonds.len() - state.bodies.broken_bonds.len()) as u32;
        *broken = if start.parting { 0 } else { of_daughters + of_scene };
        start.bodies = std::mem::replace(&mut state.bodies, end);
        state.next_id = start.next_id;
        state.changed = false;
        state.step += u64::from(start.piece.ends_step() && !start.parting);
        phases.integrate += begun.elapsed();
        Ok(std::mem::take(phases))
    }

    fn broken_bonds(&self) -> u32 {
        self.broken
    }

    fn take_again(&mut self, take: &mut Take<'_>) -> Result<(), Fault> {
        // Pieces are taken by everyone alone.
        let together = self.team.work_alone(&mut self.state);
        let taken = take(self, if together { Failed::Together } else { Failed::Itself });
        self.team.work_together();
        taken
    }

    fn multipliers(&self) -> Result<Vec<f64>, Fault> {
        let mut start = self.rows.gamma.clone();
        start.resize(self.rows.problem.q.len(), 0.0);
        Ok(start)
    }

    fn stored_lcp(&self, start: Vec<f64>) -> Result<Stored, Fault> {
        Ok(Stored::new(&self.rows.problem, start, &self.rows.gamma))
    }

    fn constraints(&self) -> usize {
        if self.team.is_distributed() { self.solve.all_rows() } else { self.rows.gamma.len() }
    }
}
