//! `relcp scenes`, `relcp check` and `relcp schema`.

use super::arguments::{Check, Scenes, Schema};
use super::exit::{CliError, Exit};
use super::output;
use relcp::run::start_warning;
use relcp::{Scene, batch, scene};
use serde_json::json;

pub(super) fn scenes(arguments: &Scenes) -> Result<Exit, CliError> {
    let built_in = scene::BuiltIn::ALL;
    if let Some(name) = &arguments.name {
        let scene = scene::BuiltIn::find(name)?;
        output::write(|out| writeln!(out, "{}", scene.text.trim_end()))?;
    } else if arguments.json {
        let list: Vec<_> = built_in.iter().map(|s| json!({"name": s.name, "summary": s.summary})).collect();
        output::json(&json!({ "scenes": list }))?;
    } else {
        let width = built_in.iter().map(|scene| scene.name.len()).max().unwrap_or(0);
        output::write(|out| built_in.iter().try_for_each(|s| writeln!(out, "{:width$}  {}", s.name, s.summary)))?;
    }
    Ok(Exit::Done)
}

pub(super) fn check(arguments: &Check) -> Result<Exit, CliError> {
    let scene = Scene::load(&arguments.scene, &arguments.sets)?;
    let bodies = scene.build().map_err(|fault| fault.located_in(&arguments.scene, &arguments.sets))?;
    let (name, count, steps) = (&scene.name, bodies.len(), scene.time.steps());
    let warnings: Vec<String> = scene.warnings().into_iter().chain(start_warning(&scene, &bodies)).collect();
    if arguments.print.json {
        let document =
            json!({"valid": true, "name": name, "bodies": count, "steps": steps, "warnings": warnings, "scene": scene});
        output::json(&document)?;
        return Ok(Exit::Done);
    }
    output::warn(&warnings);
    if !arguments.print.quiet {
        let bodies = output::count(count, "body", "bodies");
        let steps = output::count(usize::try_from(steps).unwrap_or(usize::MAX), "step", "steps");
        output::write(|out| writeln!(out, "{name}: a valid scene of {bodies} and {steps}"))?;
    }
    Ok(Exit::Done)
}

pub(super) fn schema(arguments: &Schema) -> Result<Exit, CliError> {
    if arguments.markdown {
        output::write(|out| write!(out, "{}", scene::reference()))?;
        return Ok(Exit::Done);
    }
    output::json(&if arguments.sweep { batch::schema() } else { scene::schema() })?;
    Ok(Exit::Done)
}
