//! A small reader of GSD files.

use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// A chunk: type, columns and bytes.
pub struct Chunk {
    pub code: u8,
    pub rows: usize,
    pub columns: usize,
    bytes: Vec<u8>,
}

macro_rules! numbers {
    ($($name:ident: $number:ty, $code:literal);*) => {$(
        pub fn $name(&self) -> Vec<$number> {
            assert_eq!(self.code, $code);
            self.bytes.chunks_exact(size_of::<$number>()).map(|b| <$number>::from_le_bytes(b.try_into().unwrap())).collect()
        }
    )*};
}

impl Chunk {
    numbers!(u32s: u32, 3; u64s: u64, 4; i32s: i32, 7; i64s: i64, 8; f32s: f32, 9; f64s: f64, 10);

    /// Rows of text, each up to its first zero.
    pub fn texts(&self) -> Vec<String> {
        assert_eq!(self.code, 5);
        let row = |row: &[u8]| row.iter().copied().take_while(|byte| *byte != 0).collect();
        self.bytes.chunks_exact(self.columns).map(|bytes| String::from_utf8(row(bytes)).unwrap()).collect()
    }
}

/// The frames of a file: chunks by name.
pub fn read(path: &Path) -> Vec<BTreeMap<String, Chunk>> {
    let bytes = std::fs::read(path).unwrap();
    let word = |at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap()) as usize;
    let text =
        |at: usize| bytes[at..].split(|byte| *byte == 0).next().map(|t| std::str::from_utf8(t).unwrap()).unwrap();
    assert_eq!(word(0), 0x65DF_65DF_65DF_65DF);
    assert_eq!(word(40), 0x0002_0001_0001_0004, "file layer 2.1, schema 1.4");
    assert_eq!((&text(48)[..5], text(112)), ("relcp", "hoomd"));
    let [index, entries, names, blocks] = [8, 16, 24, 32].map(word);
    let block = &bytes[names..names + 64 * blocks];
    let names: Vec<&[u8]> = block.split(|byte| *byte == 0).take_while(|name| !name.is_empty()).collect();
    let mut frames = Vec::new();
    let mut last = (0, None);
    for at in (0..entries).map(|entry| index + 32 * entry) {
        let [frame, rows, location, rest] = [0, 8, 16, 24].map(|field| word(at + field));
        if location == 0 {
            break;
        }
        let [columns, name, code, flags] = [rest & 0xFFFF_FFFF, rest >> 32 & 0xFFFF, rest >> 48 & 0xFF, rest >> 56];
        assert!(last < (frame, Some(name)) && flags == 0, "sorted by frame and name");
        last = (frame, Some(name));
        let size = [0, 1, 2, 4, 8, 1, 2, 4, 8, 4, 8, 1][code];
        let data = bytes[location..location + rows * columns * size].to_vec();
        frames.resize_with(frame + 1, BTreeMap::new);
        let name = String::from_utf8(names[name].to_vec()).unwrap();
        frames[frame].insert(name, Chunk { code: code as u8, rows, columns, bytes: data });
    }
    frames
}

/// The shapes of the types.
pub fn shapes(frame: &BTreeMap<String, Chunk>) -> Vec<Value> {
    frame["particles/type_shapes"].texts().iter().map(|text| serde_json::from_str(text).unwrap()).collect()
}
