//! `relcp run`: steps a scene to its end, or until it is interrupted.

use super::arguments::{Backend, Recorded, Run as Arguments};
use super::exit::{CliError, Exit};
use super::interrupt::Interrupt;
use super::live::Server;
use super::progress::Progress;
use super::{compiling, compute, driver, live, output, placing, report, resume, view};
use relcp::gpu::Profile;
use relcp::record::{Folder, RecordError};
use relcp::run::{Branch, Run, RunError, RunStatus, Summary, start_warning};
use relcp::scene::Scene;
use relcp::simulation::{Compute, Simulation};
use relcp::step::Fault;
use serde::Serialize;
use std::path::Path;
use std::time::Instant;

/// The default folder of runs.
pub(super) const RUNS: &str = "runs";

/// The message of rank 0 at a signal. A launcher also sends one if another process has ended, and then no step will
/// finish.
const STOPPING: &str = "stopping after this step. If another process has ended, the step cannot finish; continue \
                        from the last checkpoint: relcp run --resume with the same --out, on any number of processes";

/// What `--json` prints: the summary and the run's folder.
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
        #[cfg(feature = "mpi")]
        Backend::Mpi if arguments.live => {
            Err(CliError::Usage("--live watches a run of one process; use --backend cpu or gpu".into()))
        }
        #[cfg(feature = "mpi")]
        Backend::Mpi => super::processes::run(arguments, lead),
        #[cfg(not(feature = "mpi"))]
        Backend::Mpi => Err(compute::no_mpi()),
        _ => lead(arguments),
    }
}

/// Runs the scene in this process; other ranks may follow it.
fn lead(arguments: &Arguments) -> Result<Exit, CliError> {
    compute::set_threads(&arguments.compute)?;
    let interrupt = match arguments.compute.backend {
        Backend::Mpi => Interrupt::listen_and(|| output::message(STOPPING)),
        _ => Interrupt::listen(),
    };
    let begun = Instant::now();
    let server = arguments.live.then(|| Server::open(arguments.port)).transpose()?;
    let mut run = match &arguments.from {
        _ if arguments.resume => resume::resume(arguments)?,
        Some(from) => branch(arguments, from)?,
        None => start(arguments, &interrupt)?,
    };
    for note in run.notes() {
        output::message(note);
    }
    if let Some(gpu) = run.simulation().device().filter(|_| arguments.profile) {
        gpu.start_timing();
    }
    output::warn(&warnings(&run)?);
    let first = run.simulation().steps();
    let mut progress = Progress::new(&run, arguments.print.quiet);
    if let Some(every) = arguments.checkpoint_every {
        run.checkpoint_every(every);
    }
    let mut watched = server.map(|server| live::serve(server, &run)).transpose()?;
    let stop = || interrupt.asked() || arguments.max_wall.is_some_and(|most| begun.elapsed() >= most);
    let stepped = go_on(&mut run, watched.as_mut(), &mut progress, &stop);
    progress.end();
    let stopped = match stepped {
        Ok(stopped) => stopped,
        // Such as a full disk: a page would wait for ever.
        Err(error) => {
            if let Some(live) = watched {
                live.failed(&run, &error.to_string(), &|| interrupt.asked());
            }
            return Err(error);
        }
    };
    if let Some(live) = &mut watched {
        live.ends(&run);
    }
    if let Some(fault) = &stopped {
        output::message(&format!("stopped: {fault}"));
    }
    let folder = run.folder().clone();
    let simulation = run.simulation();
    let profile = simulation.device().filter(|_| arguments.profile);
    let profile = profile.map(|gpu| Profile::of(gpu, simulation.steps() - first));
    let summary = match run.finish() {
        Ok(summary) => summary,
        Err(error) => {
            if let Some(live) = watched {
                live.ended(format!("stopped: {error}"), &|| interrupt.asked());
            }
            return Err(error.into());
        }
    };
    if let Some(live) = watched {
        live.ended(report::in_a_sentence(&summary, folder.path()), &|| interrupt.asked());
    }
    // A failure to write the page must not hide how the run ended.
    let page = arguments.view.then(|| view::after(folder.path())).transpose();
    let (page, fault) = page.map_or_else(|fault| (None, Some(fault)), |page| (page, None));
    show(arguments, folder.path(), &summary, profile.as_ref(), page.as_deref())?;
    fault.map_or(Ok(summary.status.into()), Err)
}

/// Takes steps until the run is done, `stop` says so, or a step fails: the fault of the scene, if it was one.
fn go_on(
    run: &mut Run,
    mut watched: Option<&mut live::Driver>,
    progress: &mut Progress,
    stop: &dyn Fn() -> bool,
) -> Result<Option<Fault>, CliError> {
    while !run.done() && !stop() {
        if let Some(live) = &mut watched {
            if !live.attend(run, stop)? {
                break;
            }
            if live.waited() {
                progress.leave_out_wait();
            }
        }
        match run.advance() {
            Ok(report) => {
                progress.step(run, &report);
                watched.as_mut().map_or(Ok(()), |live| live.after(run, &report))?;
            }
            Err(RunError::Fault(fault)) if fault.is_of_scene() => return Ok(Some(fault)),
            Err(error) => return Err(error.into()),
        }
    }
    Ok(None)
}

/// Warnings about the scene, and about overlaps where the run begins with it.
fn warnings(run: &Run) -> Result<Vec<String>, CliError> {
    let (simulation, scene) = (run.simulation(), run.simulation().scene());
    let overlaps = simulation.steps() == 0 && run.totals().start_max_overlap > scene.contact.overlap_tolerance;
    let start = if overlaps { start_warning(scene, &simulation.state().map_err(RunError::from)?.bodies) } else { None };
    Ok(scene.warnings().into_iter().chain(start).collect())
}

fn start(arguments: &Arguments, interrupt: &Interrupt) -> Result<Run, CliError> {
    let Some(source) = &arguments.scene else {
        return Err(CliError::Usage("no scene given; `relcp scenes` lists the built-in scenes".into()));
    };
    let begun = Instant::now();
    let scene = Scene::load(source, &arguments.sets)?;
    driver::compute_alone(&arguments.compute, &scene, Some(source));
    let bodies = placing::place(&scene, interrupt, arguments.print.quiet)
        .map_err(|fault| fault.located_in(source, &arguments.sets))?;
    let compute = settle(arguments, &scene)?;
    let builder = Simulation::builder(scene).bodies(bodies).on(&compute);
    let simulation = compiling::watch(&compute, arguments.print.quiet, || builder.build()).map_err(CliError::start)?;
    let folder = new_folder(arguments, simulation.scene())?;
    Ok(Run::start(simulation, folder, begun.elapsed())?)
}

/// Starts a run with a state of another one.
fn branch(arguments: &Arguments, from: &Recorded) -> Result<Run, CliError> {
    let begun = Instant::now();
    let keys = arguments.sets.iter().filter_map(|set| set.split_once('=')).map(|(key, _)| key.trim().to_owned());
    let branch = Branch::open(&from.run, from.time)?.with_keys(keys);
    let own = branch.scene();
    let scene = Scene::load(arguments.scene.as_ref().unwrap_or(&own), &arguments.sets)?;
    driver::compute_alone(&arguments.compute, &scene, arguments.scene.as_deref());
    let compute = settle(arguments, &scene)?;
    let begin = || branch.simulate(scene, &compute);
    let (simulation, parent) = compiling::watch(&compute, arguments.print.quiet, begin)?;
    let folder = new_folder(arguments, simulation.scene())?;
    if !arguments.print.quiet {
        output::message(&format!("from {}, step {}, time {}", parent.run, parent.step, parent.time));
    }
    Ok(Run::start_from(simulation, folder, parent, begun.elapsed())?)
}

fn new_folder(arguments: &Arguments, scene: &Scene) -> Result<Folder, RecordError> {
    match &arguments.out {
        Some(path) => Folder::create(path),
        None => Folder::create_in(Path::new(RUNS), &scene.name),
    }
}

/// The backend. For a profile, kernels are compiled when they are created, so that the profile shows the compile time.
pub(super) fn settle(arguments: &Arguments, scene: &Scene) -> Result<Compute, CliError> {
    let compute = compute::settle(&arguments.compute, scene)?;
    if !arguments.print.quiet {
        compute::propose_device(&arguments.compute, scene, 1);
    }
    if let (true, Compute::Gpu { gpu, .. }) = (arguments.profile, &compute) {
        gpu.compile_at_once();
    }
    Ok(compute)
}

fn show(
    arguments: &Arguments,
    folder: &Path,
    summary: &Summary,
    device: Option<&Profile>,
    page: Option<&Path>,
) -> Result<(), CliError> {
    if summary.status == RunStatus::Interrupted {
        let on = resume::command(folder);
        output::message(&format!("stopped after step {}; continue with: {on}", summary.steps));
    }
    if arguments.print.json {
        return output::json(&Document { folder, view: page, profile: device, summary });
    }
    if arguments.print.quiet {
        report::out_of_tolerance(summary).iter().for_each(|why| output::message(why));
        return Ok(());
    }
    output::write(|out| {
        report::print(out, folder, page, summary)?;
        if arguments.profile {
            report::profile(out, summary)?;
            #[cfg(feature = "mpi")]
            super::processes::traffic(out)?;
        }
        device.map_or(Ok(()), |device| write!(out, "{device}"))
    })
}
