//! Zips of arrays: taken apart, damaged entry by entry, put together again and sealed, so that damage gets past the
//! checksums.

use super::mutants::{damage, pick};
use super::text;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::io::{Cursor, Read, Write};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

/// What stands before the digits of a seal.
pub const SEAL: &[u8] = b"relcp fnv1a64 ";
/// Its digits.
const DIGITS: usize = 16;

/// The entries of a zip, with their names.
pub fn entries(bytes: &[u8]) -> Vec<(String, Vec<u8>)> {
    let mut zip = ZipArchive::new(Cursor::new(bytes)).unwrap();
    let read = |index| {
        let mut entry = zip.by_index(index).unwrap();
        let mut data = Vec::new();
        entry.read_to_end(&mut data).unwrap();
        (entry.name().unwrap().into_owned(), data)
    };
    (0..ZipArchive::new(Cursor::new(bytes)).unwrap().len()).map(read).collect()
}

/// A zip of entries; with a seal, as this program makes it.
pub fn pack(entries: &[(String, Vec<u8>)], method: CompressionMethod, sealed: bool) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, data) in entries {
        // A name that is there twice is refused by the writer; the reader is not given one.
        if zip.start_file(name.as_str(), SimpleFileOptions::default().compression_method(method)).is_ok() {
            zip.write_all(data).unwrap();
        }
    }
    if sealed {
        zip.set_raw_comment([SEAL, &[b'0'; DIGITS]].concat().into()).unwrap();
    }
    let mut bytes = zip.finish().unwrap().into_inner();
    seal(&mut bytes);
    bytes
}

/// Makes the seal right, where there is one: FNV-1a of all that stands before its digits.
pub fn seal(bytes: &mut [u8]) {
    let split = bytes.len().saturating_sub(DIGITS);
    if bytes[..split].ends_with(SEAL) {
        let hash = bytes[..split]
            .iter()
            .fold(0xcbf2_9ce4_8422_2325_u64, |h, b| (h ^ u64::from(*b)).wrapping_mul(0x0100_0000_01b3));
        bytes[split..].copy_from_slice(format!("{hash:016x}").as_bytes());
    }
}

/// A zip with one to four faults, some of them past its checksums and its seal.
pub fn mutate(random: &mut ChaCha8Rng, bytes: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    if random.random_bool(0.4) {
        for _ in 0..random.random_range(1..=4) {
            damage(random, &mut bytes);
        }
        if random.random_bool(0.7) {
            seal(&mut bytes);
        }
        return bytes;
    }
    let mut entries = entries(&bytes);
    for _ in 0..random.random_range(1..=3) {
        damage_entry(random, &mut entries);
    }
    let method = if random.random_bool(0.8) { CompressionMethod::Stored } else { CompressionMethod::Deflated };
    pack(&entries, method, random.random_bool(0.8))
}

/// Takes the text out of a header: an array of bytes, which is a description, 10 bytes and as many as the two last of
/// them say, then the text.
pub fn header_json(array: &mut Vec<u8>) -> String {
    let described = array.get(8..10).map_or(0, |n| 10 + usize::from(u16::from_le_bytes([n[0], n[1]])));
    let json = array.split_off(described.min(array.len()));
    String::from_utf8_lossy(&json).into_owned()
}

fn damage_entry(random: &mut ChaCha8Rng, entries: &mut Vec<(String, Vec<u8>)>) {
    let at = random.random_range(0..entries.len().max(1));
    let other = random.random_range(0..entries.len().max(1));
    let Some((name, data)) = entries.get_mut(at) else { return };
    match random.random_range(0..10) {
        0 => {
            *name =
                pick(random, &["../x.npy", "/etc/x.npy", "q.npy", "header.npy", "header.json", "", "a\0b"]).to_owned()
        }
        1 => drop(entries.remove(at)),
        2 => entries[other].1 = entries[at].1.clone(),
        3 => entries.swap(at, other),
        4 | 5 => match entries.iter_mut().find(|(name, _)| name == "header.npy") {
            Some((_, array)) => {
                let json = header_json(array);
                array.extend(text::mutate(random, &json, &["relcp-state", "relcp-lcp"]));
            }
            None => damage(random, &mut entries[at].1),
        },
        6 | 7 => reshape(random, data),
        8 if data.len() >= 136 => {
            let number =
                [f64::NAN, f64::INFINITY, -1.0, 0.0, 1e308, 1e-308, f64::from_bits(1 << 40)][random.random_range(0..7)];
            let to = 128 + 8 * random.random_range(0..(data.len() - 128) / 8);
            data[to..to + 8].copy_from_slice(&number.to_le_bytes());
        }
        _ => damage(random, data),
    }
}

/// Another shape or type in the text of an array, its length made right mostly.
fn reshape(random: &mut ChaCha8Rng, data: &mut Vec<u8>) {
    let Some((head, body)) = data.split_at_checked(10) else { return };
    let length = usize::from(u16::from_le_bytes([head[8], head[9]])).min(body.len());
    let old = String::from_utf8_lossy(&body[..length]).into_owned();
    let from = pick(random, &["'shape': (", "<f8", "<u4", "False", "3", "1", ",", ")"]);
    let to = [
        "'shape': (1000000000000, ",
        "18446744073709551615",
        "<i8",
        "|O",
        "True",
        "-1",
        "1e9",
        "(((((",
        "<f4",
        "2",
        "0",
        "\u{e9}",
    ];
    let new = old.replacen(from, pick(random, &to), 1);
    let length = if random.random_bool(0.9) { new.len() as u16 } else { random.random() };
    *data = [&head[..8], &length.to_le_bytes(), new.as_bytes(), &body[old.len().min(body.len())..]].concat();
}
