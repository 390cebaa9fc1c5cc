//! Atomic, durable files: written to a temporary file, synced, renamed, and the folder synced.

use super::error::RecordError;
use serde::Serialize;
use std::fs::{self, File};
use std::io::Write;
use std::path::Path;

/// The prefix and the suffix of temporary files; a crash may leave one behind.
const PART: (&str, &str) = (".relcp-", ".part");

/// Writes `bytes` as the file `path`, atomically and durably.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), RecordError> {
    place(path, bytes)?;
    sync_folder(folder_of(path))
}

/// Writes `bytes` as the file `path`, atomically; its name is durable once [its folder is synced](sync_folder).
pub fn place(path: &Path, bytes: &[u8]) -> Result<(), RecordError> {
    place_with(path, |part| part.write_all(bytes).map_err(RecordError::io(path, "write it")))
}

/// As [`place`], with the content from `fill`, for contents too large for memory. If `fill` fails, no file is created.
pub fn place_with<T, E: From<RecordError>>(path: &Path, fill: impl FnOnce(&mut File) -> Result<T, E>) -> Result<T, E> {
    place_part(path, |part| fill(part.as_file_mut()))
}

/// As [`place_with`] by a path, for files that another program writes.
pub fn place_by<T, E: From<RecordError>>(path: &Path, fill: impl FnOnce(&Path) -> Result<T, E>) -> Result<T, E> {
    place_part(path, |part| fill(part.path()))
}

fn place_part<T, E: From<RecordError>>(
    path: &Path,
    fill: impl FnOnce(&mut tempfile::NamedTempFile) -> Result<T, E>,
) -> Result<T, E> {
    let folder = folder_of(path);
    let fault = |action| RecordError::io(path, action);
    let mut builder = tempfile::Builder::new();
    builder.prefix(PART.0).suffix(PART.1);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // The usual permissions of a new file, subject to the user's mask, instead of those of a private temporary
        // file.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    let mut part = builder.tempfile_in(folder).map_err(fault("create it"))?;
    let made = fill(&mut part)?;
    part.as_file().sync_all().map_err(fault("write it"))?;
    part.persist(path).map_err(|e| fault("put it in place")(e.error))?;
    Ok(made)
}

/// Writes `value` as the JSON file `path`.
pub fn write_json<T: Serialize>(path: &Path, value: &T) -> Result<(), RecordError> {
    let mut bytes = serde_json::to_vec_pretty(value).map_err(|e| RecordError::io(path, "write it")(e.into()))?;
    bytes.push(b'\n');
    write(path, &bytes)
}

/// Gives the file `from` the name `to`, in the same folder.
pub fn rename(from: &Path, to: &Path) -> Result<(), RecordError> {
    fs::rename(from, to).map_err(RecordError::io(from, "rename it"))
}

/// Removes temporary files in `folder` that a crash may have left.
pub fn sweep(folder: &Path) -> Result<(), RecordError> {
    for entry in fs::read_dir(folder).map_err(RecordError::io(folder, "list it"))? {
        let entry = entry.map_err(RecordError::io(folder, "list it"))?;
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if name.starts_with(PART.0) && name.ends_with(PART.1) {
            fs::remove_file(entry.path()).map_err(RecordError::io(&entry.path(), "remove it"))?;
        }
    }
    Ok(())
}

/// The folder that a file is in.
pub fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Makes the names in a folder durable. Only Unix can sync a folder.
pub fn sync_folder(folder: &Path) -> Result<(), RecordError> {
    if cfg!(unix) {
        File::open(folder).and_then(|f| f.sync_all()).map_err(RecordError::io(folder, "sync it"))?;
    }
    Ok(())
}
