//! Named arrays in one file that numpy opens as `.npz`: an uncompressed zip of little-endian `.npy` entries. `header`
//! is one of them, the bytes of a JSON text; in version 1 of the format it was an entry `header.json`, which is not an
//! array.
//!
//! The zip has a CRC-32 of every entry. A seal closes the file, as the zip's comment: the FNV-1a of all bytes before
//! it, so any damaged byte is detected, also in the directory. No entry has a date, so the same arrays give the same
//! bytes.

use super::error::StateError;
use super::fnv::Fnv;
use std::io::{Cursor, Read, Write};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipArchive, ZipWriter};

/// The entry that describes the arrays, and that of earlier versions' files.
pub(super) const HEADER: &str = "header.npy";
pub(super) const EARLIER_HEADER: &str = "header.json";
/// The first bytes of a zip.
pub(super) const MAGIC: &[u8] = b"PK\x03\x04";
/// The text before the seal's digits.
const SEAL: &[u8] = b"relcp fnv1a64 ";
/// Hexadecimal digits of the seal.
const DIGITS: usize = 16;
/// The first bytes of a `.npy` entry: the magic and version 1.0 of the format.
const NPY_MAGIC: &[u8] = b"\x93NUMPY\x01\x00";
/// The alignment of its numbers in bytes.
const NPY_ALIGNMENT: usize = 64;

/// The values of an array.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Data {
    F64(Vec<f64>),
    U64(Vec<u64>),
    U32(Vec<u32>),
    I64(Vec<i64>),
    I32(Vec<i32>),
}

/// A named array of `columns` numbers per row; one column gives a vector, none a scalar.
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
    let header = array("|u1", 1, header, |byte| [byte]);
    zip.start_file(HEADER, options(header.len())).map_err(fault)?;
    zip.write_all(&header).map_err(|e| StateError::Unwritable(e.to_string()))?;
    for block in blocks {
        let bytes = npy(block);
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

/// Whether the seal of a file holds: `None` for files of other programs, which have none.
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

fn npy(block: &Block) -> Vec<u8> {
    match &block.data {
        Data::F64(values) => array("<f8", block.columns, values, f64::to_le_bytes),
        Data::U64(values) => array("<u8", block.columns, values, u64::to_le_bytes),
        Data::U32(values) => array("<u4", block.columns, values, u32::to_le_bytes),
        Data::I64(values) => array("<i8", block.columns, values, i64::to_le_bytes),
        Data::I32(values) => array("<i4", block.columns, values, i32::to_le_bytes),
    }
}

/// The bytes of a `.npy` entry (numpy, "NEP 1: a simple file format for numpy arrays").
fn array<T: Copy, const W: usize>(
    descr: &str,
    columns: usize,
    values: &[T],
    bytes_of: impl Fn(T) -> [u8; W],
) -> Vec<u8> {
    let rows = values.len() / columns.max(1);
    let shape = match columns {
        0 => String::new(),
        1 => format!("{rows}, "),
        columns => format!("{rows}, {columns}, "),
    };
    let text = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({shape}), }}");
    // The magic, two bytes of length and the text, padded with blanks and terminated by a newline.
    let before = (NPY_MAGIC.len() + 2 + text.len() + 1).next_multiple_of(NPY_ALIGNMENT);
    let length = before - NPY_MAGIC.len() - 2;
    let mut bytes = Vec::with_capacity(before + size_of_val(values));
    bytes.extend_from_slice(NPY_MAGIC);
    bytes.extend_from_slice(&(length as u16).to_le_bytes());
    bytes.extend_from_slice(text.as_bytes());
    bytes.resize(before - 1, b' ');
    bytes.push(b'\n');
    for value in values {
        bytes.extend_from_slice(&bytes_of(*value));
    }
    bytes
}

/// A file's bytes, opened.
pub(super) struct Archive<'a> {
    zip: ZipArchive<Cursor<&'a [u8]>>,
    size: u64,
}

impl<'a> Archive<'a> {
    /// Opens a file: `accept` checks its header before the seal, so that a file of a newer format is recognized even if
    /// its seal differs.
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

    /// If the seal does not hold, the first entry with a wrong CRC.
    fn find_damage(&mut self) -> StateError {
        // Overlapping entries would multiply the bytes to read.
        if !matches!(self.zip.has_overlapping_entries(), Ok(false)) {
            return StateError::damaged("the directory", "its entries overlap");
        }
        let names: Vec<String> = self.zip.file_names().filter_map(|n| n.ok().map(|n| n.into_owned())).collect();
        let broken = names.iter().find_map(|name| self.entry(name).err());
        broken.unwrap_or_else(|| StateError::damaged("the seal", "the bytes are not those that were written"))
    }

    /// A whole entry, with its CRC checked.
    fn entry(&mut self, name: &str) -> Result<Vec<u8>, StateError> {
        let mut entry = self.zip.by_name(name).map_err(|e| StateError::damaged(name, e))?;
        if entry.compression() != CompressionMethod::Stored || entry.size() > self.size {
            return Err(StateError::damaged(name, "its size or packing cannot be"));
        }
        let mut bytes = Vec::with_capacity(entry.size() as usize);
        entry.read_to_end(&mut bytes).map_err(|e| StateError::damaged(name, e))?;
        Ok(bytes)
    }

    /// Whether an array of this name exists.
    pub(super) fn has(&self, name: &str) -> bool {
        self.zip.index_for_name(&format!("{name}.npy")).is_some()
    }

    /// An array of 64-bit floats.
    pub(super) fn f64s<const N: usize>(
        &mut self,
        name: &'static str,
        rows: usize,
    ) -> Result<Vec<[f64; N]>, StateError> {
        self.array("<f8", name, rows, f64::from_le_bytes)
    }

    /// An array of 64-bit integers.
    pub(super) fn u64s(&mut self, name: &'static str, rows: usize) -> Result<Vec<u64>, StateError> {
        Ok(self.array::<_, _, 1>("<u8", name, rows, u64::from_le_bytes)?.into_iter().map(|[v]| v).collect())
    }

    /// An array of 32-bit integers.
    pub(super) fn u32s<const N: usize>(
        &mut self,
        name: &'static str,
        rows: usize,
    ) -> Result<Vec<[u32; N]>, StateError> {
        self.array("<u4", name, rows, u32::from_le_bytes)
    }

    fn array<T: Copy, const W: usize, const N: usize>(
        &mut self,
        descr: &str,
        name: &'static str,
        rows: usize,
        number: impl Fn([u8; W]) -> T,
    ) -> Result<Vec<[T; N]>, StateError> {
        let bytes = self.entry(&format!("{name}.npy"))?;
        let shape = if N == 1 { format!("({rows})") } else { format!("({rows},{N})") };
        let data = rows.checked_mul(N * W);
        let text = format!("{{'descr':'{descr}','fortran_order':False,'shape':{shape}}}");
        let numbers = match header_text(&bytes) {
            Some((found, length)) if found == text && Some(length) == data => &bytes[bytes.len() - length..],
            _ => {
                let message = format!("it is not {rows} rows of {N} numbers of type {descr}");
                return Err(StateError::damaged(name, message));
            }
        };
        let flat: Vec<T> = numbers.as_chunks().0.iter().map(|bytes| number(*bytes)).collect();
        Ok(flat.as_chunks::<N>().0.to_vec())
    }
}

/// The JSON text in the entry [`HEADER`].
pub(super) fn header_json(mut entry: Vec<u8>) -> Option<Vec<u8>> {
    let (_, length) = header_text(&entry)?;
    Some(entry.split_off(entry.len() - length))
}

/// The description in a `.npy` entry, without blanks and trailing commas, and the number of bytes after it.
pub(super) fn header_text(bytes: &[u8]) -> Option<(String, usize)> {
    let rest = bytes.strip_prefix(NPY_MAGIC)?;
    let (length, rest) = rest.split_first_chunk::<2>()?;
    let (text, data) = rest.split_at_checked(u16::from_le_bytes(*length).into())?;
    let text: String = std::str::from_utf8(text).ok()?.chars().filter(|c| !c.is_whitespace()).collect();
    Some((text.replace(",}", "}").replace(",)", ")"), data.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_are_numpys() {
        let single = npy(&Block { name: "bodies", columns: 0, data: Data::I64(vec![-2]) });
        let mut expected = b"\x93NUMPY\x01\x00\x76\x00{'descr': '<i8', 'fortran_order': False, 'shape': (), }".to_vec();
        expected.resize(127, b' ');
        expected.extend_from_slice(b"\n\xfe\xff\xff\xff\xff\xff\xff\xff");
        assert_eq!(single, expected);
        let rows = npy(&Block { name: "a", columns: 2, data: Data::U32(vec![1, 2, 3, 0x0405_0607]) });
        assert_eq!(header_text(&rows), Some(("{'descr':'<u4','fortran_order':False,'shape':(2,2)}".into(), 16)));
        assert!(rows.ends_with(b" \n\x01\0\0\0\x02\0\0\0\x03\0\0\0\x07\x06\x05\x04"));
        let row = npy(&Block { name: "q", columns: 1, data: Data::F64(vec![0.0; 3]) });
        assert_eq!(header_text(&row), Some(("{'descr':'<f8','fortran_order':False,'shape':(3)}".into(), 24)));
        assert_eq!(array("|u1", 1, b"{}", |byte| [byte]).len(), 130);
    }
}
