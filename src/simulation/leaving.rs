//! Bodies that leave at the end of a step, and the lives that end.

use crate::bodies::Lineage;
use crate::removal::{Cause, Ended, Removals};
use crate::scene::Scene;
use crate::step::{Backend, Fault, StepReport, Time};

/// The rules of a scene's removal, and who was there after the last step.
pub(super) struct Leaving {
    rules: Removals,
    /// The bodies after the last step.
    before: Vec<Lineage>,
    ended: Vec<Ended>,
    /// How many were removed.
    removed: u64,
}

impl Leaving {
    /// That of a scene that a backend is about to step; none where it has no rules.
    pub fn of(scene: &Scene, backend: &dyn Backend) -> Result<Option<Leaving>, Fault> {
        let Some(rules) = scene.removals() else { return Ok(None) };
        let before = backend.identities()?.0.to_vec();
        let removed = backend.state()?.removed.iter().sum();
        Ok(Some(Leaving { rules, before, ended: Vec::new(), removed }))
    }

    /// The lives that ended in the last step.
    pub fn ended(&self) -> &[Ended] {
        &self.ended
    }

    /// How many bodies were removed so far.
    pub fn removed(&self) -> u64 {
        self.removed
    }

    /// Removes bodies after a step, and tells whose lives it ended.
    pub fn follow(&mut self, backend: &mut dyn Backend, time: &Time, report: &mut StepReport) -> Result<(), Fault> {
        let (step, dt) = (report.step, time.span(report.step) * time.dt);
        let (lineage, group) = backend.identities()?;
        self.ended.clear();
        self.add_mothers(lineage, group, step);
        let places = self.rules.asks_places().then(|| backend.placed()).transpose()?;
        let chosen = self.rules.choose((lineage, group), places, (step, dt));
        let mut counts = vec![0_u64; self.rules.len()];
        for (i, rule) in chosen.iter().enumerate() {
            let Some(rule) = *rule else { continue };
            counts[rule] += 1;
            let (line, group, cause) = (lineage[i], group[i], self.rules.cause(rule));
            self.ended.push(Ended { step, time: report.time, line, group, cause, rule: Some(rule) });
        }
        self.before.clear();
        let stay = lineage.iter().zip(&chosen).filter(|(_, rule)| rule.is_none());
        self.before.extend(stay.map(|(line, _)| *line));
        report.removed = chosen.iter().flatten().count();
        if report.removed > 0 {
            let keep: Vec<bool> = chosen.iter().map(Option::is_none).collect();
            backend.remove(&keep, &counts)?;
            self.removed += report.removed as u64;
            report.bodies = backend.bodies();
        }
        Ok(())
    }

    /// The mothers that divided: a daughter has her mother's place.
    fn add_mothers(&mut self, lineage: &[Lineage], group: &[u32], step: u64) {
        for (i, mother) in self.before.iter().enumerate() {
            let (daughter, group) = (lineage[i], group[i]);
            if daughter.id != mother.id {
                let (time, line, cause) = (daughter.birth, *mother, Cause::Division);
                self.ended.push(Ended { step, time, line, group, cause, rule: None });
            }
        }
    }
}
