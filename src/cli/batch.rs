//! `relcp batch`: many runs from one file.

use super::arguments::Batch as Arguments;
use super::batch_devices::{Devices, MEMBERS_AT_ONCE};
use super::batch_progress::{BatchProgress, chain};
use super::exit::{CliError, Exit};
use super::run::RUNS;
use super::{compute, driver, output};
use relcp::batch::{BatchError, Ended, Folders, Member, MemberError, Options, Plan, RowStatus, Table, run};
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
            CliError::Usage(format!("no member {index}: the sweep has {count}, numbered from 0"))
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
        output::message(&format!("{} is not a member of this sweep; left unchanged", stranger.display()));
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
    Ok(table.rows.iter().map(|row| exit_of(row.status)).fold(Exit::Done, Exit::worse))
}

/// The exit status of a member that was not run: an unfinished member is not a fault.
fn exit_of(status: RowStatus) -> Exit {
    match status {
        RowStatus::OutOfTolerance | RowStatus::Stopped => Exit::OutOfTolerance,
        RowStatus::Fault | RowStatus::Failed => Exit::Internal,
        RowStatus::Refused => Exit::Usage,
        RowStatus::Done | RowStatus::Interrupted | RowStatus::Unfinished | RowStatus::Missing => Exit::Done,
    }
}

fn run_members(arguments: &Arguments, plan: &Plan, out: &Path, members: &[Member]) -> Result<Exit, CliError> {
    let threads = threads(arguments);
    // An unusable device is reported before any run; the first member decides.
    let first = plan.scene(0)?;
    let devices = Devices::open(&arguments.compute, &first, threads)?;
    let asked = arguments.jobs.map(usize::from);
    let jobs = match &devices {
        Some(devices) => devices.jobs(asked, most_bodies(&first))?,
        None => asked.unwrap_or(threads),
    };
    if !arguments.print.quiet {
        compute::propose_device(&arguments.compute, &first, members.len().min(MEMBERS_AT_ONCE));
    }
    let progress = BatchProgress::new(arguments.print.quiet);
    let settle = |scene: &Scene| match &devices {
        Some(devices) => {
            Compute::check(scene).map_err(MemberError::Device)?;
            Ok(Compute::Gpu { gpu: devices.member(), precision: devices.precision })
        }
        None => Ok(Compute::Cpu),
    };
    let options = Options { jobs, threads, retry: arguments.retry };
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
        output::message("stopped; the same command continues");
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

/// The largest number of bodies of a scene, by its settings.
fn most_bodies(scene: &Scene) -> u64 {
    let placed = scene.generate.iter().map(|rule| rule.count()).sum::<u64>() + scene.bodies.len() as u64;
    placed.max(scene.stop().and_then(|stop| stop.population).unwrap_or(0))
}
