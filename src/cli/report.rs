//! The report at a run's end.

use super::output;
use relcp::digits::{beside, few, short, time};
use relcp::record::{PassedStep, Retried};
use relcp::run::{RunStatus, Summary};
use relcp::scene::StopReason;
use std::io::{self, Write};
use std::path::Path;

/// Writes the summary of the run in `folder`, with its page if it has one.
pub(super) fn print(out: &mut dyn Write, folder: &Path, page: Option<&Path>, s: &Summary) -> io::Result<()> {
    let (steps, bodies) = (counted(s.steps, "step", "steps"), output::count(s.bodies, "body", "bodies"));
    writeln!(out, "{}: {steps} to time {} with {bodies}", s.name, time(s.time, s.dt))?;
    match s.stopped_by {
        Some(StopReason::NoBodies) => writeln!(out, "  ended because no body was left")?,
        Some(reason) => writeln!(out, "  stopped by growth.stop.{}", reason.name())?,
        None => {}
    }
    if !s.removed.is_empty() {
        let by_rule: Vec<String> = s.removed.iter().map(u64::to_string).collect();
        writeln!(out, "  removed {} bodies, by rule: {}", s.removed.iter().sum::<u64>(), by_rule.join(", "))?;
    }
    let (rows, recursions) = (&s.constraints, &s.recursions);
    writeln!(out, "  constraints {} at the end, {:.1} on average, {} at most", rows.last, rows.mean, rows.max)?;
    writeln!(
        out,
        "  recursions  {:.2} a step, {} at most, {} in all",
        recursions.mean, recursions.max, recursions.total
    )?;
    let (worst, allowed) = (s.max_overlap, s.overlap_tolerance);
    let [worst, last] = [worst, s.final_max_overlap].map(|overlap| beside(overlap, allowed));
    writeln!(out, "  overlap     {worst} at most of {allowed} allowed, {last} at the end", allowed = short(allowed))?;
    if let Some(broken) = s.broken_bonds {
        writeln!(out, "  bonds       {} broke", broken)?;
    }
    if let Some(friction) = &s.friction {
        let (work, slip) = (few(friction.work), few(friction.elastic_slip));
        writeln!(out, "  friction    took {work} of energy; elastic slip {slip}")?;
    }
    if let Some(proxy) = s.proxy_max_overlap {
        writeln!(out, "  sub-spheres {} overlap at most", few(proxy))?;
    }
    s.warnings.iter().try_for_each(|warning| writeln!(out, "  warning: {warning}"))?;
    misses(out, s)?;
    let wall = &s.wall_seconds;
    let phases = wall.phases().into_iter().filter(|(_, seconds)| *seconds > 0.0);
    let phases: Vec<String> = phases.map(|(name, seconds)| format!("{name} {seconds:.2}")).collect();
    writeln!(out, "  wall time   {:.2} s: {}", wall.total, phases.join(", "))?;
    computed_by(out, s)?;
    writeln!(out, "  in          {}", folder.display())?;
    match page {
        Some(page) => writeln!(out, "  page        {}", page.display())?,
        None => writeln!(out, "  look at it  relcp view {} --open", output::argument(folder))?,
    }
    verdict(out, s)
}

/// How a run ended, in a sentence.
pub(super) fn in_a_sentence(s: &Summary, folder: &Path) -> String {
    let (steps, time, folder) = (counted(s.steps, "step", "steps"), time(s.time, s.dt), folder.display());
    let how = match (s.status, &s.message) {
        (RunStatus::Interrupted, _) => "stopped, to be resumed".into(),
        (_, Some(message)) => format!("stopped: {message}"),
        _ => out_of_tolerance(s).unwrap_or_else(|| "done".into()),
    };
    format!("{how}, after {steps} at time {time}; in {folder}")
}

/// Writes which backend computed the run, unless it was the CPU alone.
fn computed_by(out: &mut dyn Write, s: &Summary) -> io::Result<()> {
    match &s.adapter {
        _ if s.legs.iter().any(|leg| leg.machine != s.backend) => {
            s.legs.iter().try_for_each(|leg| writeln!(out, "  computed    {leg}"))
        }
        Some(adapter) => writeln!(out, "  computed by {adapter}, in {}", s.precision),
        None => Ok(()),
    }
}

/// Writes which steps missed their tolerances.
fn misses(out: &mut dyn Write, s: &Summary) -> io::Result<()> {
    let allowed = s.overlap_tolerance;
    if s.steps_over_tolerance > 0 {
        let named = s.first_over_tolerance.iter().map(|over| match (over.pair, over.wall) {
            (Some([a, b]), _) => format!("{} ({}, bodies {a} and {b})", over.step, beside(over.max_overlap, allowed)),
            (None, Some([a, wall])) => {
                format!("{} ({}, body {a} and wall {wall})", over.step, beside(over.max_overlap, allowed))
            }
            (None, None) => format!("{} ({})", over.step, beside(over.max_overlap, allowed)),
        });
        let (count, list) = (s.steps_over_tolerance, list(named, s.first_over_tolerance.len(), s.steps_over_tolerance));
        writeln!(out, "  {count} of {} steps left more overlap than allowed: {list}", s.steps)?;
    }
    if s.steps_unsettled > 0 {
        let named = s.first_unsettled.iter().map(|step| format!("{} ({})", step.step, few(step.residual)));
        let list = list(named, s.first_unsettled.len(), s.steps_unsettled);
        writeln!(out, "  {} of {} steps have velocity errors above the tolerance: {list}", s.steps_unsettled, s.steps)?;
    }
    if s.steps_passed > 0 {
        let named = s.first_passed.iter().map(|PassedStep { step, pairs, pair: [a, b] }| {
            let more = if *pairs > 1 { format!(" and {} pairs more", pairs - 1) } else { String::new() };
            format!("{step} (bodies {a} and {b}{more})")
        });
        let list = list(named, s.first_passed.len(), s.steps_passed);
        writeln!(out, "  bodies tunnelled in {} of {} steps; use a smaller dt: {list}", s.steps_passed, s.steps)?;
    }
    if s.solver.fallbacks > 0 {
        writeln!(out, "  {} solves used the interior-point safeguard", s.solver.fallbacks)?;
    }
    if s.solver.unconverged > 0 {
        let steps = &s.solver.unconverged_steps;
        let named = steps.iter().map(|step| format!("{} ({})", step.step, few(step.residual)));
        let list = list(named, steps.len(), s.solver.unconverged);
        writeln!(out, "  {} unconverged solves, in steps {list}", s.solver.unconverged)?;
    }
    if let Some(friction) = s.friction.filter(|friction| friction.held_solves > 0) {
        let (count, gap) = (counted(friction.held_solves, "solve", "solves"), few(friction.largest_gap));
        let allowed = few(friction.elastic_slip.max(s.overlap_tolerance));
        writeln!(
            out,
            "  {count} did not meet the law of friction: gaps of what slides are up to {gap} of {allowed} allowed"
        )?;
    }
    retried(out, s)
}

/// Writes which steps were repeated.
fn retried(out: &mut dyn Write, s: &Summary) -> io::Result<()> {
    let Retried { in_pieces, most_pieces, by_cpu, squeezed, turned_less, shaken, .. } = s.retried;
    let Retried { with_waiting_cells, relaxed_solves, .. } = s.retried;
    if relaxed_solves > 0 {
        let count = counted(relaxed_solves, "solve", "solves");
        writeln!(out, "  {count} with contradictory constraints, solved for the smallest overlap")?;
    }
    if in_pieces > 0 {
        writeln!(out, "  {in_pieces} of {} steps cut into pieces, {most_pieces} at most", s.steps)?;
    }
    if squeezed > 0 {
        writeln!(
            out,
            "  in {squeezed} of {} steps, a small overlap was left and then removed without advancing time",
            s.steps
        )?;
    }
    if by_cpu > 0 {
        writeln!(out, "  {by_cpu} of {} steps taken by the CPU instead of the device", s.steps)?;
    }
    if turned_less > 0 {
        writeln!(
            out,
            "  in {turned_less} of {} steps, daughters had no room to turn as they drew, and turned less",
            s.steps
        )?;
    }
    if shaken > 0 {
        writeln!(
            out,
            "  in {shaken} of {} steps, cells pressed each other and found a way out only after a small random move",
            s.steps
        )?;
    }
    if with_waiting_cells > 0 {
        writeln!(out, "  in {with_waiting_cells} of {} steps, cells without room waited", s.steps)?;
    }
    Ok(())
}

/// Why a run ended out of tolerance, if it did.
pub(super) fn out_of_tolerance(s: &Summary) -> Option<String> {
    let (steps, Summary { steps_over_tolerance, steps_passed, steps_unsettled, .. }) = (s.steps, s);
    let why = match s.reason.as_deref().filter(|_| s.message.is_none())? {
        "overlap" => format!("{steps_over_tolerance} of {steps} steps overlap by more than allowed"),
        "final_overlap" => {
            let (last, allowed) = (s.final_max_overlap, s.overlap_tolerance);
            format!("the final state overlaps by {}, {} is allowed", beside(last, allowed), short(allowed))
        }
        "passed" => format!("bodies went through each other in {steps_passed} of {steps} steps"),
        _ => format!("{steps_unsettled} of {steps} steps have velocity errors above the tolerance"),
    };
    Some(format!("out of tolerance: {why}"))
}

/// The last line of a run that missed a tolerance: which one.
fn verdict(out: &mut dyn Write, s: &Summary) -> io::Result<()> {
    let stopped = s.message.as_ref().map(|message| format!("stopped: {message}"));
    stopped.or_else(|| out_of_tolerance(s)).map_or(Ok(()), |why| writeln!(out, "  {why}"))
}

/// A list of step numbers, with an ellipsis if there are more.
fn list(named: impl Iterator<Item = String>, shown: usize, all: u64) -> String {
    let more = if all > shown as u64 { ", ..." } else { "" };
    format!("{}{more}", named.collect::<Vec<_>>().join(", "))
}

/// Writes the wall time by phase and the work of the solver.
pub(super) fn profile(out: &mut dyn Write, s: &Summary) -> io::Result<()> {
    let total = s.wall_seconds.total;
    for (name, seconds) in s.wall_seconds.phases() {
        writeln!(out, "  {name:<12} {seconds:>10.3} s  {:>5.1} %", 100.0 * seconds / total)?;
    }
    let named: f64 = s.wall_seconds.phases().iter().map(|(_, seconds)| seconds).sum();
    writeln!(out, "  {:<12} {:>10.3} s  {:>5.1} %", "other", total - named, 100.0 * (total - named) / total)?;
    let products = s.solver.products;
    writeln!(out, "  {} LCP iterations, {products} products with A", s.solver.iterations)?;
    if let Some(bytes) = s.peak_bytes.host {
        writeln!(out, "  at most {:.1} MiB of memory", bytes as f64 / f64::from(1 << 20))?;
    }
    Ok(())
}

/// A number with its noun, such as `3 bodies`.
fn counted(number: u64, one: &str, many: &str) -> String {
    output::count(usize::try_from(number).unwrap_or(usize::MAX), one, many)
}
