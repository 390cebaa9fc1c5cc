//! The file layer of GSD, version 2.1: named chunks of rows in frames, with an index and a list of names.
//!
//! Written from the specification (<https://gsd.readthedocs.io>, "File layer"): a header of 256 bytes, the chunks, the
//! names separated by zero bytes in a block of a multiple of 64, and 32 bytes of index a chunk, sorted by frame and
//! name, closed by an empty entry. Everything is little-endian. The header is written last, so that an unfinished file
//! is not a GSD file.

use std::collections::HashMap;
use std::io::{self, Seek, SeekFrom, Write};

/// The first bytes of a GSD file.
const MAGIC: u64 = 0x65DF_65DF_65DF_65DF;
/// Bytes of the header.
const HEADER: usize = 256;
/// Bytes of a name in the header, and the unit of the length of the list of names.
const NAME: usize = 64;
/// Bytes of an index entry.
const ENTRY: usize = 32;
/// Version of the file layer, as `major << 16 | minor`.
const VERSION: u32 = 2 << 16 | 1;
/// Bytes that are buffered before they are written.
const BLOCK: usize = 1 << 16;

/// The number type of a chunk.
pub(super) trait Element: Copy {
    /// Its code in the index.
    const CODE: u8;
    /// Appends its bytes.
    fn put(self, bytes: &mut Vec<u8>);
}

macro_rules! element {
    ($($number:ty: $code:literal),*) => {$(
        impl Element for $number {
            const CODE: u8 = $code;
            fn put(self, bytes: &mut Vec<u8>) {
                bytes.extend_from_slice(&self.to_le_bytes());
            }
        }
    )*};
}

element!(u8: 1, u32: 3, u64: 4, i8: 5, i32: 7, i64: 8, f32: 9, f64: 10);

struct Entry {
    frame: u64,
    rows: u64,
    location: u64,
    columns: u32,
    name: u16,
    code: u8,
}

/// A GSD file during writing.
pub(super) struct GsdFile<W: Write + Seek> {
    out: W,
    at: u64,
    frame: u64,
    names: Vec<&'static str>,
    numbers: HashMap<&'static str, u16>,
    index: Vec<Entry>,
}

impl<W: Write + Seek> GsdFile<W> {
    /// Starts a file.
    pub(super) fn new(mut out: W) -> io::Result<Self> {
        out.write_all(&[0; HEADER])?;
        let (names, numbers, index) = (Vec::new(), HashMap::new(), Vec::new());
        Ok(GsdFile { out, at: HEADER as u64, frame: 0, names, numbers, index })
    }

    /// Adds a chunk to the frame: rows of `columns` numbers.
    pub(super) fn chunk<T: Element>(
        &mut self,
        name: &'static str,
        columns: usize,
        values: impl IntoIterator<Item = T>,
    ) -> io::Result<()> {
        let location = self.at;
        let mut block = Vec::with_capacity(BLOCK + size_of::<T>());
        let mut count = 0_u64;
        for value in values {
            value.put(&mut block);
            count += 1;
            if block.len() >= BLOCK {
                self.write(&block)?;
                block.clear();
            }
        }
        self.write(&block)?;
        let columns = u32::try_from(columns).map_err(io::Error::other)?;
        let (name, rows) = (self.number(name)?, count / u64::from(columns.max(1)));
        self.index.push(Entry { frame: self.frame, rows, location, columns, name, code: T::CODE });
        Ok(())
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.at += bytes.len() as u64;
        self.out.write_all(bytes)
    }

    fn number(&mut self, name: &'static str) -> io::Result<u16> {
        if let Some(number) = self.numbers.get(name) {
            return Ok(*number);
        }
        let number = u16::try_from(self.names.len()).map_err(io::Error::other)?;
        self.names.push(name);
        self.numbers.insert(name, number);
        Ok(number)
    }

    /// Ends the frame.
    pub(super) fn end_frame(&mut self) {
        self.frame += 1;
    }

    /// Writes names, index and header, and returns the length of the file.
    pub(super) fn finish(mut self, application: &str, schema: &str, schema_version: [u16; 2]) -> io::Result<u64> {
        let names_at = self.at;
        let mut names: Vec<u8> = self.names.iter().flat_map(|name| name.bytes().chain([0])).collect();
        // One more zero closes the list.
        names.resize((names.len() + 1).next_multiple_of(NAME), 0);
        self.write(&names)?;
        let index_at = self.at;
        self.index.sort_by_key(|entry| (entry.frame, entry.name));
        let mut index = Vec::with_capacity((self.index.len() + 1) * ENTRY);
        self.index.iter().for_each(|entry| entry.put(&mut index));
        index.resize(index.len() + ENTRY, 0);
        self.write(&index)?;
        let [major, minor] = schema_version.map(u32::from);
        let mut header = Vec::with_capacity(HEADER);
        let blocks = [index_at, (index.len() / ENTRY) as u64, names_at, (names.len() / NAME) as u64];
        [MAGIC].into_iter().chain(blocks).for_each(|number| number.put(&mut header));
        [major << 16 | minor, VERSION].into_iter().for_each(|number| number.put(&mut header));
        header.extend(field(application));
        header.extend(field(schema));
        header.resize(HEADER, 0);
        self.out.seek(SeekFrom::Start(0))?;
        self.out.write_all(&header)?;
        self.out.flush()?;
        Ok(self.at)
    }
}

impl Entry {
    fn put(&self, bytes: &mut Vec<u8>) {
        [self.frame, self.rows, self.location].into_iter().for_each(|number| number.put(bytes));
        self.columns.put(bytes);
        bytes.extend_from_slice(&self.name.to_le_bytes());
        // The last byte holds the entry's flags, none.
        bytes.extend_from_slice(&[self.code, 0]);
    }
}

/// A name as a field of the header, terminated by a zero.
fn field(name: &str) -> [u8; NAME] {
    let mut field = [0; NAME];
    let bytes = name.as_bytes();
    let length = bytes.len().min(NAME - 1);
    field[..length].copy_from_slice(&bytes[..length]);
    field
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    fn u64_at(bytes: &[u8], at: usize) -> u64 {
        u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap())
    }

    #[test]
    fn the_layout_is_that_of_the_specification() {
        let mut out = Cursor::new(Vec::new());
        let mut file = GsdFile::new(&mut out).unwrap();
        file.chunk("a", 2, [1.0_f32, 2.0, 3.0, 4.0]).unwrap();
        file.chunk("b", 1, [7_u64]).unwrap();
        file.end_frame();
        // In the opposite order: the index is still sorted by the name's index.
        file.chunk("b", 1, [8_u64]).unwrap();
        file.chunk::<f32>("a", 2, []).unwrap();
        file.end_frame();
        let length = file.finish("relcp", "hoomd", [1, 4]).unwrap();
        let bytes = out.into_inner();
        assert_eq!(bytes.len() as u64, length);
        assert_eq!(bytes[..8], [0xDF, 0x65, 0xDF, 0x65, 0xDF, 0x65, 0xDF, 0x65]);
        let [index, entries, names, blocks] = [8, 16, 24, 32].map(|at| u64_at(&bytes, at) as usize);
        assert_eq!((entries, blocks), (5, 1));
        assert_eq!((names, index), (256 + 16 + 8 + 8, names + 64));
        assert_eq!((u64_at(&bytes, 40), &bytes[48..54]), (0x0002_0001_0001_0004, b"relcp\0".as_slice()));
        assert_eq!(&bytes[112..118], b"hoomd\0");
        assert_eq!(&bytes[names..names + 5], b"a\0b\0\0");
        // frame, rows, location, columns | name << 32 | code << 48
        let entry = |i: usize| [0, 8, 16, 24].map(|at| u64_at(&bytes, index + 32 * i + at));
        assert_eq!(entry(0), [0, 2, 256, 2 | 9 << 48]);
        assert_eq!(entry(1), [0, 1, 272, 1 | 1 << 32 | 4 << 48]);
        assert_eq!(entry(2), [1, 0, 288, 2 | 9 << 48]);
        assert_eq!(entry(3), [1, 1, 280, 1 | 1 << 32 | 4 << 48]);
        assert_eq!(entry(4), [0; 4]);
        assert_eq!((u64_at(&bytes, 272), u64_at(&bytes, 280)), (7, 8));
    }

    #[test]
    fn long_chunks_come_out_whole_and_names_fill_blocks() {
        let mut out = Cursor::new(Vec::new());
        let mut file = GsdFile::new(&mut out).unwrap();
        let name: &'static str = "0123456789012345678901234567890123456789012345678901234567890123";
        file.chunk(name, 1, 0..40_000_u32).unwrap();
        file.finish("x", "y", [1, 0]).unwrap();
        let bytes = out.into_inner();
        assert_eq!(u64_at(&bytes, 32), 2);
        let last = 256 + 4 * 39_999;
        assert_eq!(bytes[last..last + 4], 39_999_u32.to_le_bytes());
    }
}
