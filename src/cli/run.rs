//! `relcp run`: steps a scene to its end, or until it is interrupted.

use super::arguments::{Backend, Run as Arguments};
use super::exit::{CliError, Exit};
use super::interrupt::Interrupt;
use super::progress::Progress;
use super::{compiling, compute, driver, output, placing, processes, view};
use relcp::gpu::Profile;
use relcp::record::{Folder, PassedStep, RecordError, Retried};
use relcp::run::{Run, RunError, RunStatus, Summary};
use relcp::scene::{Scene, StopReason};
use relcp::simulation::{Compute, Machine, Simulation};
use serde::Serialize;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Where runs go that are not told where.
pub(super) const RUNS: &str = "runs";

/// What process 0 says when it is asked to end: a launcher asks for it too where another process has ended, and then no
/// step will come to its end.
const STOPPING: &str = "stopping after this step. If another process has ended, the step cannot end, and the run goes on \
                        from its last checkpoint: relcp run --resume with the same --out, by any number of processes";

/// What `--json` prints: the summary, and where the run is.
#[derive(Serialize)]
struct Document<'a> {
    folder: &'a Path,
    #[serde(skip_serializing_if = "Option::is_none")]
    view: Option<&'a Path>,
    #[serde(skip_serializing_if = "Option::is_none")]
    profile: Option<&'a Profile>,
    #[serde(flatten)]
    summary: &'a Summary,
}

pub(super) fn run(arguments: &Arguments) -> Result<Exit, CliError> {
    match arguments.compute.backend {
        Backend::Mpi => processes::run(arguments, lead),
        _ => lead(arguments),
    }
}

/// Runs the scene in this process, which others may follow.
fn lead(arguments: &Arguments) -> Result<Exit, CliError> {
    compute::set_threads(&arguments.compute)?;
    let interrupt = match arguments.compute.backend {
        Backend::Mpi => Interrupt::listen_and(|| output::message(STOPPING)),
        _ => Interrupt::listen(),
    };
    let begun = Instant::now();
    let mut run = if arguments.resume { resume(arguments)? } else { start(arguments, &interrupt)? };
    for note in run.notes() {
        output::message(note);
    }
    if let Some(gpu) = run.simulation().device().filter(|_| arguments.profile) {
        gpu.start_timing();
    }
    let first = run.simulation().steps();
    let mut progress = Progress::new(&run, arguments.print.quiet);
    if let Some(every) = arguments.checkpoint_every {
        run.checkpoint_every(every);
    }
    let mut stopped = None;
    let out_of_time = || arguments.max_wall.is_some_and(|most| begun.elapsed() >= most);
    while !run.done() && !interrupt.asked() && !out_of_time() {
        match run.advance() {
            Ok(report) => progress.step(&run, &report),
            Err(RunError::Fault(fault)) if fault.is_of_scene() => {
                stopped = Some(fault);
                break;
            }
            Err(error) => return Err(error.into()),
        }
    }
    progress.end();
    if let Some(fault) = &stopped {
        output::message(&format!("stopped: {fault}"));
    }
    let folder = run.folder().clone();
    let simulation = run.simulation();
    let profile = simulation.device().filter(|_| arguments.profile);
    let profile = profile.map(|gpu| Profile::of(gpu, device_steps(simulation, first)));
    let summary = run.finish()?;
    // A page that cannot be written must not hide how the run ended.
    let page = arguments.view.then(|| view::after(folder.path())).transpose();
    let (page, fault) = page.map_or_else(|fault| (None, Some(fault)), |page| (page, None));
    show(arguments, folder.path(), &summary, profile.as_ref(), page.as_deref())?;
    fault.map_or(Ok(summary.status.into()), Err)
}

fn start(arguments: &Arguments, interrupt: &Interrupt) -> Result<Run, CliError> {
    let Some(source) = &arguments.scene else {
        return Err(CliError::Usage("which scene? `relcp scenes` lists the built-in ones".into()));
    };
    let begun = Instant::now();
    let scene = Scene::load(source, &arguments.sets)?;
    driver::compute_alone(&arguments.compute, &scene, Some(source));
    let bodies = placing::place(&scene, interrupt, arguments.print.quiet)?;
    let compute = settle(arguments, &scene)?;
    let builder = Simulation::builder(scene).bodies(bodies).on(&compute);
    let simulation = compiling::watch(&compute, arguments.print.quiet, || builder.build()).map_err(CliError::start)?;
    let folder = match &arguments.out {
        Some(path) => Folder::create(path)?,
        None => Folder::create_in(Path::new(RUNS), &simulation.scene().name)?,
    };
    Ok(Run::start(simulation, folder, begun.elapsed())?)
}

fn resume(arguments: &Arguments) -> Result<Run, CliError> {
    let (folder, scene) = match (&arguments.out, &arguments.scene) {
        (None, None) => return Err(CliError::Usage("which run? Name its folder with --out, or its scene".into())),
        (Some(path), source) => {
            let folder = Folder::open(path)?;
            let recorded = folder.scene();
            let scene = match source {
                Some(source) => Scene::load(source, &arguments.sets)?,
                None => Scene::load(&recorded, &arguments.sets)?,
            };
            (folder, scene)
        }
        (None, Some(source)) => {
            let scene = Scene::load(source, &arguments.sets)?;
            (latest(&scene)?, scene)
        }
    };
    driver::compute_alone(&arguments.compute, &scene, arguments.scene.as_deref());
    let compute = settle(arguments, &scene)?;
    let resume = || match arguments.until {
        Some(until) => Run::resume_until(scene, folder, until, &compute),
        None => Run::resume(scene, folder, &compute),
    };
    Ok(compiling::watch(&compute, arguments.print.quiet, resume)?)
}

/// What computes; for a profile kernels are compiled when they are made, so that it tells how long that took.
fn settle(arguments: &Arguments, scene: &Scene) -> Result<Compute, CliError> {
    let compute = compute::settle(&arguments.compute, scene)?;
    if let (true, Compute::Gpu { gpu, .. }) = (arguments.profile, &compute) {
        gpu.compile_at_once();
    }
    Ok(compute)
}

/// Steps after the `first` that a device took.
fn device_steps(simulation: &Simulation, first: u64) -> u64 {
    let legs = simulation.legs();
    let ends = legs.iter().skip(1).map(|next| next.from_step).chain([simulation.steps() + 1]);
    let on_device = legs.iter().zip(ends).filter(|(leg, _)| leg.machine == Machine::Gpu);
    on_device.map(|(leg, end)| end.saturating_sub(leg.from_step.max(first + 1))).sum()
}

fn latest(scene: &Scene) -> Result<Folder, RecordError> {
    let runs = PathBuf::from(RUNS);
    match Folder::latest_in(&runs, &scene.name) {
        Some(path) => Folder::open(&path),
        None => Err(RecordError::NoCheckpoint { path: runs }),
    }
}

fn show(
    arguments: &Arguments,
    folder: &Path,
    summary: &Summary,
    device: Option<&Profile>,
    page: Option<&Path>,
) -> Result<(), CliError> {
    if summary.status == RunStatus::Interrupted {
        let on = format!("relcp run --resume --out {}", folder.display());
        output::message(&format!("stopped after step {}; go on with: {on}", summary.steps));
    }
    if arguments.print.json {
        return output::json(&Document { folder, view: page, profile: device, summary });
    }
    if arguments.print.quiet {
        return Ok(());
    }
    output::write(|out| {
        print(out, folder, summary)?;
        page.map_or(Ok(()), |page| writeln!(out, "  page        {}", page.display()))?;
        if arguments.profile {
            profile(out, summary)?;
            processes::traffic(out)?;
        }
        device.map_or(Ok(()), |device| write!(out, "{device}"))
    })
}

fn print(out: &mut dyn Write, folder: &Path, s: &Summary) -> io::Result<()> {
    writeln!(out, "{}: {} steps to time {} with {} bodies", s.name, s.steps, s.time, s.bodies)?;
    match s.stopped_by {
        Some(StopReason::NoBodies) => writeln!(out, "  ended as no body was left")?,
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
    writeln!(
        out,
        "  overlap     {worst:.3e} at most of {allowed:.1e} allowed, {:.3e} at the end",
        s.final_max_overlap
    )?;
    if let Some(proxy) = s.proxy_max_overlap {
        writeln!(out, "  sub-spheres {proxy:.3e} overlap at most")?;
    }
    if s.start_max_overlap > allowed {
        writeln!(out, "  the scene itself starts with an overlap of {:.3e}", s.start_max_overlap)?;
    }
    misses(out, s)?;
    let wall = &s.wall_seconds;
    let phases = wall.phases().into_iter().filter(|(_, seconds)| *seconds > 0.0);
    let phases: Vec<String> = phases.map(|(name, seconds)| format!("{name} {seconds:.2}")).collect();
    writeln!(out, "  wall time   {:.2} s: {}", wall.total, phases.join(", "))?;
    computed_by(out, s)?;
    writeln!(out, "  in          {}", folder.display())?;
    verdict(out, s)
}

/// Says what computed it, where that is not the CPU alone.
fn computed_by(out: &mut dyn Write, s: &Summary) -> io::Result<()> {
    let one = s.legs.iter().all(|leg| leg.machine.name() == s.backend);
    match &s.adapter {
        Some(adapter) if one => return writeln!(out, "  computed by {adapter}, in {}", s.precision),
        None if one => return Ok(()),
        _ => {}
    }
    for leg in s.legs.iter().filter(|leg| !leg.is_trial() && !leg.is_return()) {
        writeln!(out, "  computed    {leg}")?;
    }
    let (trials, lost) =
        (s.legs.iter().filter(|leg| leg.is_trial()).count(), s.legs.last().map(|leg| leg.lost_seconds));
    match lost {
        Some(lost) if trials > 0 => {
            let trials = output::count(trials, "trial", "trials");
            writeln!(out, "  {trials} of the machine not in use, which cost {lost:.2} s")
        }
        _ => Ok(()),
    }
}

/// Says which steps did not meet their tolerances.
fn misses(out: &mut dyn Write, s: &Summary) -> io::Result<()> {
    if s.steps_over_tolerance > 0 {
        let named = s.first_over_tolerance.iter().map(|over| match (over.pair, over.wall) {
            (Some([a, b]), _) => format!("{} ({:.2e}, bodies {a} and {b})", over.step, over.max_overlap),
            (None, Some([a, wall])) => format!("{} ({:.2e}, body {a} and wall {wall})", over.step, over.max_overlap),
            (None, None) => format!("{} ({:.2e})", over.step, over.max_overlap),
        });
        let (count, list) = (s.steps_over_tolerance, list(named, s.first_over_tolerance.len(), s.steps_over_tolerance));
        writeln!(out, "  {count} of {} steps left more overlap than allowed: {list}", s.steps)?;
    }
    if s.steps_unsettled > 0 {
        let named = s.first_unsettled.iter().map(|step| format!("{} ({:.2e})", step.step, step.residual));
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
        let named = steps.iter().map(|step| format!("{} ({:.2e})", step.step, step.residual));
        let list = list(named, steps.len(), s.solver.unconverged);
        writeln!(out, "  {} unconverged solves, in steps {list}", s.solver.unconverged)?;
    }
    retried(out, s)
}

/// Says which steps did not go at once.
fn retried(out: &mut dyn Write, s: &Summary) -> io::Result<()> {
    let Retried { in_pieces, most_pieces, by_cpu, squeezed, with_waiting_cells, relaxed_solves, .. } = s.retried;
    if relaxed_solves > 0 {
        writeln!(out, "  {relaxed_solves} solves with contradictory constraints, solved for the smallest overlap")?;
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
        writeln!(out, "  {by_cpu} of {} steps taken by the CPU in the place of the device", s.steps)?;
    }
    if with_waiting_cells > 0 {
        writeln!(out, "  in {with_waiting_cells} of {} steps, cells without room waited", s.steps)?;
    }
    Ok(())
}

/// The last line of a run that misses something: what.
fn verdict(out: &mut dyn Write, s: &Summary) -> io::Result<()> {
    let (steps, Summary { steps_over_tolerance, steps_passed, steps_unsettled, .. }) = (s.steps, s);
    match s.reason.as_deref() {
        None => Ok(()),
        Some(_) if s.message.is_some() => writeln!(out, "  stopped: {}", s.message.as_deref().unwrap_or_default()),
        Some("overlap") => {
            writeln!(out, "  out of tolerance: {steps_over_tolerance} of {steps} steps overlap by more than allowed")
        }
        Some("final_overlap") => {
            let (last, allowed) = (s.final_max_overlap, s.overlap_tolerance);
            writeln!(out, "  out of tolerance: the final state overlaps by {last:.3e}, {allowed:.1e} is allowed")
        }
        Some("passed") => {
            writeln!(out, "  out of tolerance: bodies went through each other in {steps_passed} of {steps} steps")
        }
        Some(_) => writeln!(out, "  out of tolerance: {steps_unsettled} of {steps} steps have velocities that are off"),
    }
}

fn list(named: impl Iterator<Item = String>, shown: usize, all: u64) -> String {
    let more = if all > shown as u64 { ", ..." } else { "" };
    format!("{}{more}", named.collect::<Vec<_>>().join(", "))
}

fn profile(out: &mut dyn Write, s: &Summary) -> io::Result<()> {
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
