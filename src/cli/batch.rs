//! `relcp batch`: many runs from one file.

use super::arguments::{Backend, Batch as Arguments, Compute as ComputeArguments};
use super::batch_devices::Devices;
use super::batch_progress::{BatchProgress, chain};
use super::exit::{CliError, Exit};
use super::run::RUNS;
use super::{compute, driver, output};
use relcp::batch::{BatchError, Ended, Folders, Member, MemberError, Options, Pilot, Plan, RowStatus, Table, run};
use relcp::record::RecordError;
use relcp::scene::Scene;
use relcp::simulation::Compute;
use serde_json::json;
use std::path::{Path, PathBuf};

pub(super) fn batch(arguments: &Arguments) -> Result<Exit, CliError> {
    compute::set_threads(&arguments.compute)?;
    let plan = Plan::open(&arguments.sweep)?;
    let out = arguments.out.clone().unwrap_or_else(|| plan.folder_in(Path::new(RUNS)));
    let members = match arguments.index {
        None => plan.members(),
        Some(index) => plan.members().get(index..=index).ok_or_else(|| {
            let count = plan.members().len();
            CliError::Usage(format!("there is no member {index}; the sweep has {count}, numbered from 0"))
        })?,
    };
    if arguments.count {
        return count(arguments, members.len());
    }
    if arguments.list {
        return list(arguments, &plan, &out);
    }
    if !arguments.table {
        let at_once = arguments.jobs.map_or(members.len(), |jobs| members.len().min(jobs.into()));
        driver::compute_side_by_side(&arguments.compute, at_once, threads(arguments), &arguments.sweep);
    }
    let silent = arguments.print.quiet || arguments.index.is_some();
    for stranger in Folders::read(&out).map_err(BatchError::from)?.strangers(&plan).iter().filter(|_| !silent) {
        output::message(&format!("{} belongs to no member of this sweep; left unchanged", stranger.display()));
    }
    if arguments.table {
        return table(arguments, &plan, &out);
    }
    run_members(arguments, &plan, &out, members)
}

fn count(arguments: &Arguments, members: usize) -> Result<Exit, CliError> {
    if arguments.print.json {
        output::json(&json!({ "members": members }))?;
    } else {
        output::write(|out| writeln!(out, "{members}"))?;
    }
    Ok(Exit::Done)
}

fn list(arguments: &Arguments, plan: &Plan, out: &Path) -> Result<Exit, CliError> {
    let folders = Folders::read(out).map_err(BatchError::from)?;
    let folder = |member: &Member| -> PathBuf {
        folders.of(plan, member).map_or_else(|_| out.join(member.name()), |(folder, _)| folder)
    };
    let members = plan.members();
    if arguments.print.json {
        let entry = |m: &Member| {
            let (index, set, values, hash) = (m.index, &m.set, &m.values, &m.scene_hash);
            json!({ "index": index, "folder": folder(m), "set": set, "values": values, "scene_hash": hash, "steps": m.steps })
        };
        let members: Vec<_> = members.iter().map(entry).collect();
        output::json(&json!({ "name": plan.sweep().name, "out": out, "columns": plan.columns(), "members": members }))?;
    } else {
        let width = members.len().saturating_sub(1).to_string().len();
        output::write(|out| {
            let mut line = |m: &Member| writeln!(out, "{:>width$}  {}  {}", m.index, folder(m).display(), m.label());
            members.iter().try_for_each(&mut line)
        })?;
    }
    Ok(Exit::Done)
}

fn table(arguments: &Arguments, plan: &Plan, out: &Path) -> Result<Exit, CliError> {
    let table = Table::of(plan, out, plan.members())?;
    std::fs::create_dir_all(out).map_err(RecordError::io(out, "create the folder"))?;
    table.write(out)?;
    print(arguments, &table)?;
    let left = table.rows.iter().filter(|row| !row.status.finished()).count();
    if left > 0 {
        output::message(&format!("{left} of {} members are unfinished", table.rows.len()));
    }
    Ok(table.rows.iter().map(|row| standing(row.status)).fold(Exit::Done, Exit::worse))
}

/// What a member that is not being run counts for: what is still to be run is no fault.
fn standing(status: RowStatus) -> Exit {
    match status {
        RowStatus::OutOfTolerance | RowStatus::Stopped => Exit::OutOfTolerance,
        RowStatus::Fault | RowStatus::Failed => Exit::Internal,
        RowStatus::Refused => Exit::Usage,
        RowStatus::Done | RowStatus::Interrupted | RowStatus::Unfinished | RowStatus::Missing => Exit::Done,
    }
}

fn run_members(arguments: &Arguments, plan: &Plan, out: &Path, members: &[Member]) -> Result<Exit, CliError> {
    let threads = threads(arguments);
    let mut devices = devices(arguments, plan, members, threads)?;
    let mut jobs_of_all = jobs(arguments, plan, devices.as_ref(), threads)?;
    if arguments.compute.backend == Backend::Auto
        && let Some(devices_of_all) = &devices
        && !pays(arguments, plan, devices_of_all, (jobs_of_all.min(members.len()), threads))
    {
        devices = None;
        jobs_of_all = jobs(arguments, plan, None, threads)?;
    }
    let progress = BatchProgress::new(arguments.print.quiet);
    let settle = |scene: &Scene| match &devices {
        Some(devices) => {
            Compute::check(scene).map_err(MemberError::Device)?;
            Ok(Compute::Gpu { gpu: devices.member(), precision: devices.precision })
        }
        None if arguments.compute.backend == Backend::Auto => Ok(Compute::Cpu),
        None => compute::settle_many(&arguments.compute, scene).map_err(unfit),
    };
    let options = Options { jobs: jobs_of_all, threads, retry: arguments.retry };
    let ended = run(plan, out, members, options, &settle, &progress)?;
    progress.end();
    let mut table = Table::of(plan, out, members)?;
    for (member, ended) in members.iter().zip(&ended) {
        if let Ended::Failed(error) = ended {
            table.failed(member.index, chain(error));
        }
    }
    if arguments.index.is_none() && out.is_dir() {
        table.write(out)?;
    }
    print(arguments, &table)?;
    let exit = ended.iter().map(Exit::of_member).fold(Exit::Done, Exit::worse);
    if exit == Exit::Interrupted {
        output::message("stopped; the same command goes on");
    }
    Ok(exit)
}

fn print(arguments: &Arguments, table: &Table) -> Result<(), CliError> {
    if arguments.print.json {
        return output::json(table);
    }
    if arguments.print.quiet {
        return Ok(());
    }
    output::write(|out| write!(out, "{table}"))
}

fn threads(arguments: &Arguments) -> usize {
    let cores = || std::thread::available_parallelism().map_or(1, usize::from);
    arguments.compute.threads.map_or_else(cores, usize::from)
}

/// How many members run at once: as many as there are threads, or as fit on the devices.
fn jobs(arguments: &Arguments, plan: &Plan, devices: Option<&Devices>, threads: usize) -> Result<usize, CliError> {
    let asked = arguments.jobs.map(usize::from);
    let Some(devices) = devices else { return Ok(asked.unwrap_or(threads)) };
    devices.jobs(asked, most_bodies(&plan.scene(0)?), arguments.compute.backend == Backend::Gpu)
}

/// The most bodies that a scene says it will have.
fn most_bodies(scene: &Scene) -> u64 {
    let placed = scene.generate.iter().map(|rule| rule.count()).sum::<u64>() + scene.bodies.len() as u64;
    placed.max(scene.stop().and_then(|stop| stop.population).unwrap_or(0))
}

/// The devices that may compute all members together, decided by the first; reports an unusable one before any run.
fn devices(
    arguments: &Arguments,
    plan: &Plan,
    members: &[Member],
    threads: usize,
) -> Result<Option<Devices>, CliError> {
    let ComputeArguments { backend, precision, adapter, .. } = &arguments.compute;
    let asks = *backend == Backend::Gpu || precision.is_some() || adapter.is_some();
    // One member alone is never faster on a device where many are on a processor.
    if !asks && (*backend != Backend::Auto || members.len() < 2) {
        return Ok(None);
    }
    Devices::open(&arguments.compute, &plan.scene(0)?, threads)
}

/// Whether so many members at a time take less time on a device than on so many threads, measured; and says so.
fn pays(arguments: &Arguments, plan: &Plan, devices: &Devices, (members, threads): (usize, usize)) -> bool {
    let pilot = plan.scene(0).map_err(|e| chain(&e)).and_then(|scene| {
        Pilot::run(&scene, (&|| devices.member(), devices.precision), members, threads).map_err(|e| chain(&e))
    });
    let pays = pilot.as_ref().is_ok_and(Pilot::device_is_faster);
    if !arguments.print.quiet {
        let on = if pays { "on the device" } else { "on the CPU" };
        output::message(&match pilot {
            Ok(pilot) => format!("{pilot}; computed {on}"),
            Err(fault) => format!("no device was measured ({fault}); computed {on}"),
        });
    }
    pays
}

fn unfit(error: CliError) -> MemberError {
    match error {
        CliError::Device(fault) => MemberError::Device(fault),
        other => MemberError::Unfit(other.to_string()),
    }
}
