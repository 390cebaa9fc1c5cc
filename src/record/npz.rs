//! Named arrays in one file that numpy opens as `.npz`: an uncompressed zip of little-endian `.npy` entries. `header`
//! is one of them, the bytes of a JSON text; up to version 0.1 it was an entry `header.json`, which no array is.
//!
//! The zip holds a CRC-32 of every entry. A seal closes the file, as the zip's comment: the FNV-1a of all bytes before
//! it, so that a damaged byte is found wherever it lies, in the directory too. No entry has a date: the same arrays are
//! the same bytes.

use super::error::StateError;
use super::hash::Fnv;
use npyz::WriterBuilder;
use std::io::{BufWriter, Cursor, Read, Write};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipArchive, ZipWriter};

/// The entry that says what the arrays are, and what files of earlier versions have in its place.
pub(super) const HEADER: &str = "header.npy";
pub(super) const EARLIER_HEADER: &str = "header.json";
/// What a zip starts with.
pub(super) const MAGIC: &[u8] = b"PK\x03\x04";
/// What stands before the seal's digits.
const SEAL: &[u8] = b"relcp fnv1a64 ";
/// Hexadecimal digits of the seal.
const DIGITS: usize = 16;
/// What a `.npy` entry starts with: the magic and version 1.0 of the format.
const NPY_MAGIC: &[u8] = b"\x93NUMPY\x01\x00";

/// The values of an array.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Data {
    F64(Vec<f64>),
    U64(Vec<u64>),
    U32(Vec<u32>),
    I64(Vec<i64>),
    I32(Vec<i32>),
}

/// A named array of `columns` numbers a row; one column is a plain vector, none a single number.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Block {
    pub(super) name: &'static str,
    pub(super) columns: usize,
    pub(super) data: Data,
}

/// The file's bytes.
pub(super) fn write(header: &[u8], blocks: &[Block]) -> Result<Vec<u8>, StateError> {
    let fault = |e: zip::result::ZipError| StateError::Unwritable(e.to_string());
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let header = array("|u1", 1, header).map_err(|e| StateError::Unwritable(e.to_string()))?;
    zip.start_file(HEADER, options(header.len())).map_err(fault)?;
    zip.write_all(&header).map_err(|e| StateError::Unwritable(e.to_string()))?;
    for block in blocks {
        let bytes = npy(block).map_err(|e| StateError::Unwritable(e.to_string()))?;
        zip.start_file(format!("{}.npy", block.name), options(bytes.len())).map_err(fault)?;
        zip.write_all(&bytes).map_err(|e| StateError::Unwritable(e.to_string()))?;
    }
    let comment = [SEAL, &[b'0'; DIGITS]].concat();
    zip.set_raw_comment(comment.into()).map_err(fault)?;
    let mut bytes = zip.finish().map_err(fault)?.into_inner();
    let sealed = bytes.len() - DIGITS;
    let seal = seal(&bytes[..sealed]);
    bytes[sealed..].copy_from_slice(seal.as_bytes());
    Ok(bytes)
}

fn seal(bytes: &[u8]) -> String {
    let mut hash = Fnv::default();
    hash.update(bytes);
    hash.hex()
}

/// Whether the seal of a file holds, where it has one: `None` for files of other programs.
pub(super) fn seal_holds(bytes: &[u8]) -> Option<bool> {
    let split = bytes.len().saturating_sub(DIGITS);
    bytes[..split].ends_with(SEAL).then(|| seal(&bytes[..split]).as_bytes() == &bytes[split..])
}

fn options(size: usize) -> SimpleFileOptions {
    SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .last_modified_time(DateTime::default())
        .unix_permissions(0o644)
        .large_file(size as u64 >= u64::from(u32::MAX))
}

fn npy(block: &Block) -> std::io::Result<Vec<u8>> {
    match &block.data {
        Data::F64(values) => array("<f8", block.columns, values),
        Data::U64(values) => array("<u8", block.columns, values),
        Data::U32(values) => array("<u4", block.columns, values),
        Data::I64(values) => array("<i8", block.columns, values),
        Data::I32(values) => array("<i4", block.columns, values),
    }
}

fn array<T: npyz::Serialize + Copy>(descr: &str, columns: usize, values: &[T]) -> std::io::Result<Vec<u8>> {
    let ty = descr.parse().map_err(|e| std::io::Error::other(format!("{descr}: {e}")))?;
    let rows = (values.len() / columns.max(1)) as u64;
    let shape = match columns {
        0 => vec![],
        1 => vec![rows],
        columns => vec![rows, columns as u64],
    };
    let mut bytes = Vec::with_capacity(std::mem::size_of_val(values) + 128);
    let out = BufWriter::new(&mut bytes);
    let mut writer = npyz::WriteOptions::new().dtype(npyz::DType::Plain(ty)).shape(&shape).writer(out).begin_nd()?;
    writer.extend(values.iter().copied())?;
    writer.finish()?;
    Ok(bytes)
}

/// A file's bytes, opened.
pub(super) struct Archive<'a> {
    zip: ZipArchive<Cursor<&'a [u8]>>,
    size: u64,
}

impl<'a> Archive<'a> {
    /// Opens a file: `accept` judges its header, before the seal, so that a file of a newer format is known as such
    /// even where that format seals otherwise.
    pub(super) fn open<H>(
        bytes: &'a [u8],
        accept: impl FnOnce(&[u8]) -> Result<H, StateError>,
    ) -> Result<(Self, H), StateError> {
        if bytes.is_empty() {
            return Err(StateError::Truncated);
        }
        if !bytes.starts_with(MAGIC) {
            return Err(StateError::NotAState);
        }
        let sealed = seal_holds(bytes);
        let zip = match ZipArchive::new(Cursor::new(bytes)) {
            Ok(zip) => zip,
            Err(_) if sealed.is_none() => return Err(StateError::Truncated),
            Err(e) => return Err(StateError::damaged("the directory", e)),
        };
        let mut archive = Archive { zip, size: bytes.len() as u64 };
        let header = accept(&archive.header()?)?;
        if sealed != Some(true) {
            return Err(archive.find_damage());
        }
        Ok((archive, header))
    }

    /// The JSON text of the header.
    fn header(&mut self) -> Result<Vec<u8>, StateError> {
        if self.zip.index_for_name(HEADER).is_none() {
            return self.entry(EARLIER_HEADER);
        }
        header_json(self.entry(HEADER)?).ok_or_else(|| StateError::damaged(HEADER, "it is no array"))
    }

    /// The first entry whose CRC does not hold, where the seal does not.
    fn find_damage(&mut self) -> StateError {
        // Entries that share bytes would be read as many times as there are of them.
        if !matches!(self.zip.has_overlapping_entries(), Ok(false)) {
            return StateError::damaged("the directory", "its entries overlap");
        }
        let names: Vec<String> = self.zip.file_names().filter_map(|n| n.ok().map(|n| n.into_owned())).collect();
        let broken = names.iter().find_map(|name| self.entry(name).err());
        broken.unwrap_or_else(|| StateError::damaged("the seal", "the bytes are not those that were written"))
    }

    /// An entry whole, its CRC checked.
    fn entry(&mut self, name: &str) -> Result<Vec<u8>, StateError> {
        let mut entry = self.zip.by_name(name).map_err(|e| StateError::damaged(name, e))?;
        if entry.compression() != CompressionMethod::Stored || entry.size() > self.size {
            return Err(StateError::damaged(name, "its size or packing cannot be"));
        }
        let mut bytes = Vec::with_capacity(entry.size() as usize);
        entry.read_to_end(&mut bytes).map_err(|e| StateError::damaged(name, e))?;
        Ok(bytes)
    }

    /// Whether there is an array of this name.
    pub(super) fn has(&self, name: &str) -> bool {
        self.zip.index_for_name(&format!("{name}.npy")).is_some()
    }

    /// An array of 64-bit floats.
    pub(super) fn f64s<const N: usize>(
        &mut self,
        name: &'static str,
        rows: usize,
    ) -> Result<Vec<[f64; N]>, StateError> {
        self.array("<f8", name, rows)
    }

    /// An array of 64-bit integers.
    pub(super) fn u64s(&mut self, name: &'static str, rows: usize) -> Result<Vec<u64>, StateError> {
        Ok(self.array::<u64, 1>("<u8", name, rows)?.into_iter().map(|[v]| v).collect())
    }

    /// An array of 32-bit integers.
    pub(super) fn u32s<const N: usize>(
        &mut self,
        name: &'static str,
        rows: usize,
    ) -> Result<Vec<[u32; N]>, StateError> {
        self.array("<u4", name, rows)
    }

    fn array<T: npyz::Deserialize + Copy, const N: usize>(
        &mut self,
        descr: &str,
        name: &'static str,
        rows: usize,
    ) -> Result<Vec<[T; N]>, StateError> {
        let bytes = self.entry(&format!("{name}.npy"))?;
        let shape = if N == 1 { format!("({rows})") } else { format!("({rows},{N})") };
        let data = rows.checked_mul(N * std::mem::size_of::<T>());
        // Judged from its text, since a forged shape must not reach arithmetic that trusts it.
        let text = format!("{{'descr':'{descr}','fortran_order':False,'shape':{shape}}}");
        let found = header_text(&bytes);
        if found.as_ref().map(|(text, _)| text) != Some(&text) || found.map(|(_, rest)| rest) != data {
            return Err(StateError::damaged(name, format!("it is not {rows} rows of {N} numbers of type {descr}")));
        }
        let file = npyz::NpyFile::new(bytes.as_slice()).map_err(|e| StateError::damaged(name, e))?;
        let flat: Vec<T> = file.into_vec().map_err(|e| StateError::damaged(name, e))?;
        Ok(flat.as_chunks::<N>().0.to_vec())
    }
}

/// The JSON text in the entry [`HEADER`].
pub(super) fn header_json(mut entry: Vec<u8>) -> Option<Vec<u8>> {
    let (_, length) = header_text(&entry)?;
    Some(entry.split_off(entry.len() - length))
}

/// The description in a `.npy` entry, without blanks and trailing commas, and how many bytes follow it.
pub(super) fn header_text(bytes: &[u8]) -> Option<(String, usize)> {
    let rest = bytes.strip_prefix(NPY_MAGIC)?;
    let (length, rest) = rest.split_first_chunk::<2>()?;
    let (text, data) = rest.split_at_checked(u16::from_le_bytes(*length).into())?;
    let text: String = std::str::from_utf8(text).ok()?.chars().filter(|c| !c.is_whitespace()).collect();
    Some((text.replace(",}", "}").replace(",)", ")"), data.len()))
}
