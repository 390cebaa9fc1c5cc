//! The removal of bodies at the end of a step, and the lives that end.

use crate::bodies::{Bodies, Lineage};
use crate::removal::{Cause, Ended, Removals};
use crate::scene::Scene;
use crate::step::{Divided, Fault, Keeper, LIFE_WORDS, StepReport, Time};
use std::collections::HashSet;

/// The rules of a scene's removal, and the bodies after the last step.
pub(super) struct Leaving {
    rules: Removals,
    /// The lineages of this process's bodies after the last step.
    before: Vec<Lineage>,
    ended: Vec<Ended>,
    /// How many bodies were removed.
    removed: u64,
}

impl Leaving {
    /// The removal of a scene before its first step, with the count of bodies removed before; none without rules.
    pub fn of(scene: &Scene, keeper: &dyn Keeper, removed: u64) -> Result<Option<Leaving>, Fault> {
        let Some(rules) = scene.removals() else { return Ok(None) };
        let before = keeper.lives()?.lineage.to_vec();
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

    /// Removes bodies after a step and records the lives that ended.
    pub fn apply(&mut self, keeper: &mut dyn Keeper, time: &Time, report: &mut StepReport) -> Result<(), Fault> {
        let (step, dt) = (report.step, time.span(report.step) * time.dt);
        let mut ended: Vec<[u64; LIFE_WORDS]> = keeper.divided(&self.before)?.iter().map(of_mother).collect();
        let lives = keeper.lives()?;
        let (lineage, group) = (lives.lineage, lives.group);
        let places = self.rules.asks_places().then(|| keeper.local_bodies()).transpose()?;
        let chosen = self.rules.choose((lineage, group), places, (step, dt));
        for (i, rule) in chosen.iter().enumerate() {
            let number = rule.and_then(|_| lives.number(i));
            if let (Some(rule), Some(number)) = (*rule, number) {
                ended.push(of_removed(number, rule, &lineage[i], group[i]));
            }
        }
        self.before.clear();
        let stay = lineage.iter().zip(&chosen).filter(|(_, rule)| rule.is_none());
        self.before.extend(stay.map(|(line, _)| *line));
        let ended = keeper.all_gather(ended);
        self.ended = ended.iter().map(|words| self.ended_by(words, step, report.time)).collect();
        let mut counts = vec![0_u64; self.rules.len()];
        self.ended.iter().filter_map(|ended| ended.rule).for_each(|rule| counts[rule] += 1);
        report.removed = counts.iter().sum::<u64>() as usize;
        if report.removed > 0 {
            let keep: Vec<bool> = chosen.iter().map(Option::is_none).collect();
            keeper.remove(&keep, &counts)?;
            self.removed += report.removed as u64;
            report.bodies = keeper.bodies();
        }
        Ok(())
    }

    /// Unpacks a life that ended.
    fn ended_by(&self, words: &[u64; LIFE_WORDS], step: u64, now: f64) -> Ended {
        let [is_removed, _, time, group, rule, line @ ..] = *words;
        let (line, group) = (Lineage::of_words(line), group as u32);
        if is_removed == 0 {
            return Ended { step, time: f64::from_bits(time), line, group, cause: Cause::Division, rule: None };
        }
        let rule = rule as usize;
        Ended { step, time: now, line, group, cause: self.rules.cause(rule), rule: Some(rule) }
    }
}

/// The lives of the bodies that a change took out between two steps, before the step of this number, at this time.
pub(super) fn taken_out(before: &Bodies, after: &Bodies, step: u64, time: f64) -> Vec<Ended> {
    let stay: HashSet<u64> = after.lineage.iter().map(|line| line.id).collect();
    let gone = before.lineage.iter().zip(&before.group).filter(|(line, _)| !stay.contains(&line.id));
    gone.map(|(line, group)| Ended { step, time, line: *line, group: *group, cause: Cause::Change, rule: None })
        .collect()
}

/// Packs a life that ended. The words sort as lives are listed: divisions, then removals, each by body.
fn words(ended: [u64; 5], line: &Lineage) -> [u64; LIFE_WORDS] {
    let ([a, b, c, d, e], [f, g, h, i, j]) = (ended, line.words());
    [a, b, c, d, e, f, g, h, i, j]
}

fn of_mother(mother: &Divided) -> [u64; LIFE_WORDS] {
    words([0, mother.number.into(), mother.time.to_bits(), mother.group.into(), 0], &mother.line)
}

fn of_removed(number: usize, rule: usize, line: &Lineage, group: u32) -> [u64; LIFE_WORDS] {
    words([1, number as u64, 0, group.into(), rule as u64], line)
}
