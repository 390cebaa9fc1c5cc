//! Inputs that ask for more than there is: each is refused by arithmetic, before anything is allocated.

use super::archives::{self, entries, pack};
use super::{lcps, states};
use relcp::batch::{BatchError, Plan};
use relcp::record::{decode, decode_lcp};
use relcp::run::peak_bytes;
use relcp::scene::{FaultKind, Scene};
use std::io::{Cursor, Write};
use std::path::Path;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// What the readers, and the tests beside them, may take of memory: far above what they need, far below what is asked
/// for.
const MEMORY: u64 = 384 << 20;

/// Does something that must not take much memory, where the system tells how much was taken.
fn in_bounds<T>(what: impl FnOnce() -> T) -> T {
    let before = peak_bytes().unwrap_or(0);
    let done = what();
    let taken = peak_bytes().unwrap_or(0) - before;
    assert!(taken < MEMORY, "{taken} bytes");
    done
}

/// A scene with these keys beside those that every scene has.
fn scene(time: &str, more: &str) -> String {
    let body =
        r#""bodies": [ { "shape": { "spherocylinder": { "diameter": 1, "length": 2 } }, "position": [0, 0, 0] } ]"#;
    format!(r#"{{ "name": "bomb", "time": {time}, {body}{more} }}"#)
}

#[test]
fn scenes_that_ask_for_too_much_are_refused() {
    const TIME: &str = r#"{ "dt": 0.1, "end": 1 }"#;
    const BALL: &str = r#""shape": { "sphere": { "radius": 1 } }, "volume_fraction": 0.01"#;
    let balls = |count: &str| format!(r#"{{ "isotropic": {{ "count": {count}, {BALL} }} }}"#);
    let rings = |columns: &str, rows: &str| {
        let radii = r#""major_radius": 1, "minor_radius": 0.1"#;
        format!(r#"{{ "chainmail": {{ "columns": {columns}, "rows": {rows}, {radii} }} }}"#)
    };
    let generated = |rules: &[String]| scene(TIME, &format!(r#", "generate": [{}]"#, rules.join(",")));
    const MOST: &str = "18446744073709551615";
    for (text, key) in [
        (generated(&[balls("1000000000000")]), "generate.0.isotropic.count"),
        (generated(&[balls(MOST), balls(MOST)]), "generate.0.isotropic.count"),
        (generated(&[balls("9000000"), balls("9000000")]), "generate.1.isotropic.count"),
        (generated(&[rings("1000000000000", "1")]), "generate.0.chainmail"),
        (generated(&[rings("1000000", "1000000")]), "generate.0.chainmail"),
        (generated(&[rings(MOST, MOST)]), "generate.0.chainmail"),
        (
            scene(TIME, r#", "contact": { "method": { "multisphere": { "count": 4294967295 } } }"#),
            "contact.method.multisphere.count",
        ),
        (scene(r#"{ "dt": 1, "end": 1e9 }"#, r#", "output": { "every": 1 }"#), "output.every"),
        (scene(r#"{ "dt": 1e-9, "end": 1e9 }"#, ""), "time.dt"),
        (scene(r#"{ "dt": 0.1, "end": 1e6 }"#, r#", "growth": { "rate": 1, "division_length": 2 }"#), "time.end"),
    ] {
        let error = in_bounds(|| Scene::parse(&text, "bomb.json").unwrap_err());
        assert_eq!((error.kind(), error.key()), (FaultKind::TooLarge, key), "{text}");
    }
}

#[test]
fn sweeps_of_too_many_members_are_refused() {
    let thousand = format!("[{}]", (1..=1000).map(|n| n.to_string()).collect::<Vec<_>>().join(","));
    for more in [
        r#""seeds": { "from": 0, "count": 1000000000000 }"#.to_owned(),
        r#""seeds": { "from": 0, "count": 18446744073709551615 }"#.to_owned(),
        format!(r#""grid": {{ "time.dt": {thousand}, "time.end": {thousand} }}"#),
        format!(r#""grid": {{ {} }}"#, (0..30).map(|n| format!(r#""k{n}": {thousand}"#)).collect::<Vec<_>>().join(",")),
    ] {
        let text = format!(r#"{{ "name": "bomb", "scene": "colony", {more} }}"#);
        let error = in_bounds(|| Plan::parse(&text, "bomb.json", Path::new(".")).err().unwrap());
        assert!(matches!(error, BatchError::Scene(_)));
        assert!(error.to_string().contains("more than 100000 members"), "{error}");
    }
}

#[test]
fn states_that_claim_too_many_rows_are_refused() {
    let whole = entries(&states::files()[0]);
    for (from, to) in
        [("\"bodies\": 3", "\"bodies\": 1000000000000"), ("\"bodies\": 3", "\"bodies\": 18446744073709551615")]
    {
        let mut forged = whole.clone();
        let json = archives::header_json(&mut forged[0].1);
        assert!(json.contains(from), "{json}");
        forged[0].1.extend(json.replace(from, to).into_bytes());
        let error = in_bounds(|| decode(&pack(&forged, CompressionMethod::Stored, true)).unwrap_err());
        assert!(error.to_string().contains("more rows than the file can hold"), "{error}");
    }
    let mut forged = whole;
    let position = forged.iter_mut().find(|(name, _)| name == "position.npy").unwrap();
    let tail = position.1[128..].to_vec();
    let start = b"\x93NUMPY\x01\x00";
    let described = b"{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000000, 3, ), }\n";
    position.1 = [&start[..], &(described.len() as u16).to_le_bytes(), described, &tail].concat();
    let error = in_bounds(|| decode(&pack(&forged, CompressionMethod::Stored, true)).unwrap_err());
    assert!(error.to_string().contains("it is not 3 rows"), "{error}");
}

/// A directory that claims 2^40 entries, in the zip's 64-bit form.
#[test]
fn zips_that_claim_too_many_entries_are_refused() {
    let claim = (1_u64 << 40).to_le_bytes();
    let mut bytes = b"PK\x03\x04".to_vec();
    let end = bytes.len() as u64;
    bytes.extend(b"PK\x06\x06");
    bytes.extend(44_u64.to_le_bytes());
    bytes.extend([45, 0, 45, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
    bytes.extend([claim, claim, 0_u64.to_le_bytes(), 4_u64.to_le_bytes()].concat());
    bytes.extend(b"PK\x06\x07\0\0\0\0");
    bytes.extend(end.to_le_bytes());
    bytes.extend(1_u32.to_le_bytes());
    bytes.extend(b"PK\x05\x06\0\0\0\0");
    bytes.extend([0xff; 12]);
    bytes.extend([0, 0]);
    in_bounds(|| {
        decode(&bytes).unwrap_err();
        decode_lcp(&bytes).unwrap_err();
    });
}

/// A mebibyte that stands for one to a thousand of them.
#[test]
fn a_deflate_bomb_is_refused_before_it_is_unpacked() {
    const MEBIBYTES: usize = 1_000;
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, data) in entries(&lcps::files()[3]).iter().filter(|(name, _)| name != "q.npy") {
        zip.start_file(name.as_str(), SimpleFileOptions::default()).unwrap();
        zip.write_all(data).unwrap();
    }
    let packed = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
    zip.start_file("q.npy", packed).unwrap();
    let described = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({},), }}\n", MEBIBYTES << 17);
    zip.write_all(b"\x93NUMPY\x01\x00").unwrap();
    zip.write_all(&(described.len() as u16).to_le_bytes()).unwrap();
    zip.write_all(described.as_bytes()).unwrap();
    let zeros = vec![0; 1 << 20];
    for _ in 0..MEBIBYTES {
        zip.write_all(&zeros).unwrap();
    }
    let bomb = zip.finish().unwrap().into_inner();
    assert!(bomb.len() < 2 << 20);
    let error = in_bounds(|| decode_lcp(&bomb).unwrap_err());
    assert!(error.to_string().contains("q.npy") && error.to_string().contains("unpack"), "{error}");
}

/// Names that all stand for the same bytes: reading each of them would take as many times as long as the file is.
#[test]
fn a_directory_of_overlapping_entries_is_not_read_through() {
    const NAMES: usize = 50_000;
    let large = vec![("00000000.npy".to_owned(), vec![0; 1 << 21])];
    for mut bytes in [states::files().swap_remove(2), lcps::files().swap_remove(0)] {
        let header = entries(&bytes).swap_remove(0);
        assert_eq!(header.0, "header.npy");
        bytes = pack(&[&[header][..], &large].concat(), CompressionMethod::Stored, false);
        let directory = bytes.windows(4).position(|four| four == b"PK\x01\x02").unwrap();
        let end = bytes.windows(4).rposition(|four| four == b"PK\x05\x06").unwrap();
        let last = bytes[..end].windows(4).rposition(|four| four == b"PK\x01\x02").unwrap();
        let (entry, mut tail) = (bytes[last..end].to_vec(), bytes[end..].to_vec());
        let name = entry.windows(12).position(|name| name == b"00000000.npy").unwrap();
        bytes.truncate(end);
        for number in 1..NAMES {
            let mut entry = entry.clone();
            entry[name..name + 8].copy_from_slice(format!("{number:08}").as_bytes());
            bytes.extend(entry);
        }
        let count = (NAMES as u16 + 1).to_le_bytes();
        tail[8..12].copy_from_slice(&[count, count].concat());
        tail[12..16].copy_from_slice(&((bytes.len() - directory) as u32).to_le_bytes());
        bytes.extend(tail);
        decode(&bytes).unwrap_err();
        decode_lcp(&bytes).unwrap_err();
    }
}

/// A key of so many parts that trying all of them together would take as long as the text is, as many times as it has
/// parts.
#[test]
fn a_key_of_thousands_of_parts_is_told_at_once() {
    let key = "a.".repeat(100_000) + "a";
    let error = Scene::parse(&scene("{}", &format!(r#", "{key}": 1"#)), "parts.json").unwrap_err();
    assert_eq!(error.line(), Some(1));
    let sweep = format!(r#"{{ "name": "parts", "scene": "colony", "grid": {{ "{key}": [1, 2] }} }}"#);
    assert!(matches!(Plan::parse(&sweep, "parts.json", Path::new(".")), Err(BatchError::Scene(_))));
}

#[test]
fn a_sweep_of_many_keys_is_read_in_time() {
    let keys: Vec<String> = (0..100_000).map(|n| format!(r#""k{n}": 1"#)).collect();
    let text = format!(r#"{{ "name": "keys", "scene": "colony", "list": [{{ {} }}] }}"#, keys.join(","));
    assert!(matches!(Plan::parse(&text, "keys.json", Path::new(".")), Err(BatchError::Scene(_))));
}

/// The cells that a large body covers of a grid for small ones are more than 64-bit integers hold.
#[test]
fn bodies_of_very_different_sizes_are_placed_by_rule() {
    let text = r#"{ "name": "sizes", "time": { "dt": 0.1, "end": 1 }, "contact": { "overlap_tolerance": 1e-45 },
      "bodies": [ { "shape": { "sphere": { "radius": 1e-40 } }, "position": [0, 0, 0] } ],
      "generate": [ { "isotropic": { "count": 3, "shape": { "sphere": { "radius": 1 } }, "volume_fraction": 0.001 } } ] }"#;
    let bodies = Scene::parse(text, "sizes.json").unwrap().build().unwrap();
    assert_eq!(bodies.len(), 4);
    assert!(bodies.position[1..].iter().all(|position| position.length() > 1.0));
}

#[test]
fn the_echoed_scene_of_the_smallest_numbers_can_be_read_again() {
    let text = r#"{ "name": "small", "time": { "dt": 1e-60, "end": 1e-60 }, "contact": { "overlap_tolerance": 1e-60 },
      "bodies": [ { "shape": { "sphere": { "radius": 1 } }, "position": [0, 0, 0] } ] }"#;
    let echoed = Scene::parse(text, "small.json").unwrap().with_defaults();
    let again = Scene::parse(&serde_json::to_string(&echoed).unwrap(), "scene.json").unwrap();
    assert_eq!(again, echoed);
}
