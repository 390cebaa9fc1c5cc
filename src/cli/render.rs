//! `relcp render`: pictures of a run's states, and a movie.

use super::arguments::{Backend, Render as Arguments};
use super::exit::{CliError, Exit};
use super::watched::watched;
use super::{compute, output};
use relcp::figure::Format;
use relcp::gpu::{Choice, Gpu};
use relcp::record::{RecordError, States, durable};
use relcp::render::{
    Background, ENDINGS, Encoder, Frames, MOVIE, MovieKind, Rays, RenderError, Rendered, movie, render_on,
};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What `--json` prints: the document with the paths of its files.
#[derive(Serialize)]
struct Document<'a> {
    folder: &'a Path,
    movie: Option<&'a Path>,
    #[serde(flatten)]
    rendered: &'a Rendered,
}

pub(super) fn render(arguments: &Arguments) -> Result<Exit, CliError> {
    compute::set_thread_count(arguments.threads)?;
    let encoder = if arguments.no_movie { None } else { Encoder::find() };
    if arguments.movie.is_some() && arguments.format != Format::Png {
        return Err(CliError::Usage("--movie: movies need pixel pictures; omit --format".into()));
    }
    if let Some(movie) = &arguments.movie {
        check_movie(movie, encoder.as_ref())?;
    }
    let rays = rays(arguments)?;
    let states = States::open(&arguments.run).map_err(RenderError::from)?;
    let states = if arguments.which.last { states.last() } else { states };
    let folder = arguments.out.clone().unwrap_or_else(|| place(&arguments.run, states.name()));
    if let Some(movie) = arguments.movie.as_deref().filter(|movie| is_among_pictures(movie, &folder)) {
        return Err(CliError::Usage(format!("--movie: {} is among the pictures", movie.display())));
    }
    let mut rendered = watched(arguments.print.quiet, |watch| {
        render_on(rays.as_ref(), &arguments.run, &states, &frames(arguments), &folder, watch)
    })?;
    let movie = make_movie(arguments, encoder.as_ref(), &folder, &mut rendered)?;
    if arguments.print.json {
        output::json(&Document { folder: &folder, movie: movie.as_deref(), rendered: &rendered })?;
    } else if !arguments.print.quiet {
        print(&rendered, &folder, movie.as_deref())?;
    }
    Ok(Exit::Done)
}

/// Refuses a movie that cannot be made, before any work.
fn check_movie(movie: &Path, encoder: Option<&Encoder>) -> Result<(), CliError> {
    match MovieKind::of(movie) {
        None => return Err(CliError::Usage(format!("--movie: the name must end in {ENDINGS}"))),
        Some(MovieKind::Video(_)) if encoder.is_none() => return Err(RenderError::NoEncoder.into()),
        Some(_) => {}
    }
    let folder = durable::folder_of(movie);
    let found = folder.metadata().map_err(RecordError::io(folder, "find the movie's folder"))?;
    if !found.is_dir() {
        return Err(CliError::Usage(format!("--movie: {} is not a folder", folder.display())));
    }
    Ok(())
}

/// Whether the movie would be written into the folder of the pictures, where it could replace one.
fn is_among_pictures(movie: &Path, folder: &Path) -> bool {
    let pictures = folder.join("frames");
    let whole = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_owned());
    whole(durable::folder_of(movie)) == whole(&pictures)
}

/// The device that casts the rays, if any.
fn rays(arguments: &Arguments) -> Result<Option<Rays>, CliError> {
    match arguments.backend {
        Backend::Mpi => Err(super::compute::no_mpi()),
        Backend::Gpu => {
            let choice = Choice { name: arguments.adapter.clone(), software: true, ..Choice::default() };
            Ok(Some(Gpu::open(&choice).and_then(|gpu| Rays::new(Arc::new(gpu)))?))
        }
        Backend::Auto | Backend::Cpu if arguments.adapter.is_some() => {
            let usage = "--adapter names a device, but the CPU draws these pictures; add --backend gpu";
            Err(CliError::Usage(usage.into()))
        }
        Backend::Auto | Backend::Cpu => Ok(None),
    }
}

fn frames(arguments: &Arguments) -> Frames {
    Frames {
        colour: arguments.colour,
        range: arguments.range,
        size: arguments.size,
        side: arguments.view,
        background: arguments.background,
        format: arguments.format,
        fit: arguments.fit,
        words: !arguments.bare,
        every: arguments.which.every as usize,
        from: arguments.which.from.unwrap_or(f64::NEG_INFINITY),
        to: arguments.which.to.unwrap_or(f64::INFINITY),
    }
}

/// Makes the requested movie, or a default one if there is more than one picture.
fn make_movie(
    arguments: &Arguments,
    encoder: Option<&Encoder>,
    folder: &Path,
    rendered: &mut Rendered,
) -> Result<Option<PathBuf>, RenderError> {
    let fits_a_movie = arguments.background != Background::Transparent && arguments.format == Format::Png;
    if arguments.no_movie
        || (!fits_a_movie && arguments.movie.is_none())
        || (arguments.movie.is_none() && rendered.frames.len() < 2)
    {
        return Ok(None);
    }
    if encoder.is_none() && arguments.movie.is_none() {
        rendered.notes.push("no movie.mp4: `ffmpeg` is not on the path; --movie NAME.png needs none".into());
        return Ok(None);
    }
    let path = arguments.movie.clone().unwrap_or_else(|| folder.join(MOVIE));
    movie(encoder, folder, arguments.fps, &path)?;
    Ok(Some(path))
}

/// In a run's folder, otherwise in the current folder, named after the source.
fn place(run: &Path, name: &str) -> PathBuf {
    if run.is_dir() { run.join("render") } else { PathBuf::from(format!("{name}-render")) }
}

fn print(rendered: &Rendered, folder: &Path, movie: Option<&Path>) -> Result<(), CliError> {
    output::write(|out| {
        let [width, height] = rendered.size;
        let pictures = output::count(rendered.frames.len(), "picture", "pictures");
        writeln!(out, "{pictures} of {width} x {height} in {}", folder.join("frames").display())?;
        if let Some(movie) = movie {
            writeln!(out, "{}", movie.display())?;
        }
        rendered.notes.iter().try_for_each(|note| writeln!(out, "note: {note}"))
    })
}
