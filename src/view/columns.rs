//! How numbers become text: columns of whole numbers, byte by byte from the lowest, packed by zlib, in base64.
//!
//! Bytes of one order stand together, for the higher ones are mostly zero. `assets/view/data.js` reads what this
//! writes.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use serde::Serialize;
use std::io::Write;

/// What is known of a column: its name, how many numbers, and bytes a number.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Column(&'static str, usize, u32);

/// Columns, one after the other.
#[derive(Default)]
pub(super) struct Block {
    layout: Vec<Column>,
    bytes: Vec<u8>,
}

impl Block {
    /// Adds a column, with as many bytes a number as its largest takes.
    pub fn add(&mut self, name: &'static str, values: &[u32]) {
        let most = values.iter().fold(0, |most, value| most | value);
        let planes = (u32::BITS - most.leading_zeros()).div_ceil(8);
        for plane in 0..planes {
            self.bytes.extend(values.iter().map(|value| (value >> (8 * plane)) as u8));
        }
        self.layout.push(Column(name, values.len(), planes));
    }

    /// Adds a column of numbers of either sign.
    pub fn add_signed(&mut self, name: &'static str, values: &[i32]) {
        self.add(name, &values.iter().map(|value| zigzag(*value)).collect::<Vec<_>>());
    }

    /// Adds a column of floats.
    pub fn add_floats(&mut self, name: &'static str, values: impl Iterator<Item = f64>) {
        self.add(name, &values.map(|value| (value as f32).to_bits()).collect::<Vec<_>>());
    }

    /// Adds numbers from `low` to `high` in 65,535 steps; those that are not numbers stand at `low`.
    pub fn add_between(&mut self, name: &'static str, values: impl Iterator<Item = f64>, [low, high]: [f64; 2]) {
        let step = |value: f64| (((value - low) / (high - low)).clamp(0.0, 1.0) * f64::from(u16::MAX)).round() as u32;
        self.add(name, &values.map(step).collect::<Vec<_>>());
    }

    /// What its columns are.
    pub fn layout(&self) -> Vec<Column> {
        self.layout.clone()
    }

    /// Its bytes.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }
}

/// 0, 1, 2, 3, 4, ... for 0, -1, 1, -2, 2, ...: numbers near zero have few bytes.
fn zigzag(value: i32) -> u32 {
    ((value << 1) ^ (value >> 31)) as u32
}

/// Packed bytes as text.
pub(super) fn text(bytes: &[u8]) -> String {
    let mut packed = ZlibEncoder::new(Vec::new(), Compression::default());
    // A vector takes all that is written to it.
    let packed = packed.write_all(bytes).and_then(|()| packed.finish()).unwrap_or_default();
    STANDARD.encode(packed)
}
