//! A movie of pictures: an animated PNG, or a video by the program `ffmpeg` if it is on the path.

use super::frames::picture_file;
use super::{RenderError, animation};
use crate::figure::Format;
use crate::record::RecordError;
use crate::record::durable;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Endings of a video's name, and the encoder's names of these formats.
const VIDEOS: [(&str, &str); 3] = [("mp4", "mp4"), ("mov", "mov"), ("mkv", "matroska")];
/// Endings of an animated PNG's name.
const ANIMATIONS: [&str; 2] = ["png", "apng"];
/// All of them, in a message.
pub const ENDINGS: &str = ".png, .apng, .mp4, .mov or .mkv";
/// Options of the video encoders; the first that the program supports is used: H.264 at its default quality, else
/// MPEG-4.
const CODECS: [&[&str]; 2] = [&["-c:v", "libx264"], &["-c:v", "mpeg4", "-q:v", "2"]];
/// The last picture is held for a second. Players need even widths and heights: adds a column or a row if necessary.
const EVEN: &str = "tpad=stop_mode=clone:stop_duration=1,pad=ceil(iw/2)*2:ceil(ih/2)*2";
/// The number of bytes of the encoder's output in a message.
const SAID: usize = 600;

/// The program that makes movies.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Encoder(PathBuf);

impl Encoder {
    /// `ffmpeg`, in the first folder of the path that has it.
    pub fn find() -> Option<Encoder> {
        let path = std::env::var_os("PATH")?;
        let name = format!("ffmpeg{}", std::env::consts::EXE_SUFFIX);
        std::env::split_paths(&path).map(|folder| folder.join(&name)).find(|file| is_program(file)).map(Encoder)
    }
}

/// The kind of a movie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MovieKind {
    /// An animated PNG, which the program writes itself.
    Animation,
    /// A video, with its format name for `ffmpeg`.
    Video(&'static str),
}

impl MovieKind {
    /// The kind of a movie of this name, by its ending.
    pub fn of(movie: &Path) -> Option<MovieKind> {
        let ending = movie.extension()?.to_str()?.to_ascii_lowercase();
        if ANIMATIONS.contains(&ending.as_str()) {
            return Some(MovieKind::Animation);
        }
        VIDEOS.iter().find(|(of, _)| *of == ending).map(|(_, format)| MovieKind::Video(format))
    }
}

#[cfg(unix)]
fn is_program(file: &Path) -> bool {
    use std::os::unix::fs::PermissionsExt;
    file.metadata().is_ok_and(|found| found.is_file() && found.permissions().mode() & 0o111 != 0)
}

#[cfg(not(unix))]
fn is_program(file: &Path) -> bool {
    file.is_file()
}

/// Makes a movie of the pictures of [`render`](super::render) in `folder`, with `frames_a_second`. It is written
/// atomically; a file of that name is replaced. An animation needs no encoder, repeats, and shows its last picture for
/// a second.
///
/// # Errors
/// [`RenderError::Encoder`] if the program fails or the name has an unknown ending; [`RenderError::NoEncoder`] for
/// a video without one; a file that cannot be read or written.
pub fn movie(encoder: Option<&Encoder>, folder: &Path, frames_a_second: u32, movie: &Path) -> Result<(), RenderError> {
    match MovieKind::of(movie) {
        Some(MovieKind::Animation) => {
            let pictures: Vec<PathBuf> = (0..)
                .map(|number| folder.join(picture_file(number, Format::Png)))
                .take_while(|file| file.is_file())
                .collect();
            animation::write(&pictures, frames_a_second, movie)
        }
        Some(MovieKind::Video(format)) => {
            video(encoder.ok_or(RenderError::NoEncoder)?, format, folder, frames_a_second, movie)
        }
        None => {
            let what = format!("its name must end in {ENDINGS}");
            Err(RenderError::Encoder { path: movie.into(), what })
        }
    }
}

fn video(
    encoder: &Encoder,
    format: &str,
    folder: &Path,
    frames_a_second: u32,
    movie: &Path,
) -> Result<(), RenderError> {
    let pictures = folder.join("frames").join("%06d.png");
    durable::place_by(movie, |part| {
        let mut said = String::new();
        for codec in CODECS {
            let mut command = Command::new(&encoder.0);
            command.args(["-nostdin", "-hide_banner", "-loglevel", "error", "-y"]);
            command.arg("-framerate").arg(frames_a_second.to_string()).arg("-i").arg(&pictures);
            command.args(["-vf", EVEN]).args(codec).args(["-pix_fmt", "yuv420p", "-f", format]).arg(part);
            let done = command.stdin(Stdio::null()).output();
            let done = done.map_err(RecordError::io(&encoder.0, "run it")).map_err(RenderError::Record)?;
            if done.status.success() {
                return Ok(());
            }
            said = format!("{} ({})", last(&done.stderr), done.status);
        }
        Err(RenderError::Encoder { path: movie.into(), what: said })
    })
}

/// The end of a program's output, in one line.
fn last(said: &[u8]) -> String {
    let text = String::from_utf8_lossy(&said[said.len().saturating_sub(SAID)..]);
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
