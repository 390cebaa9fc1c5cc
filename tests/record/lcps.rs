//! Files of LCPs: their bits, damage in them, those of other programs, and which a run saves.

use relcp::lcp::{Stored, velocity};
use relcp::record::{
    Folder, LCP_FORMAT, LCP_VERSION, LcpFileError, LcpHeader, decode_lcp, encode, encode_lcp, read_lcp,
};
use relcp::run::Run;
use relcp::{Compute, Scene, Simulation, State};
use std::io::{Cursor, Write};
use std::time::Duration;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// Two rows between three bodies, with numbers that a decimal or narrower form would lose.
fn lcp(unknowns: usize) -> Stored {
    let awkward = [0.1 + 0.2, -0.0, f64::MIN_POSITIVE / 3.0, f64::MAX, 1.0 / 3.0, -1e-300];
    let numbers = |n: usize, from: usize| (0..n).map(|i| awkward[(i + from) % awkward.len()]).collect::<Vec<f64>>();
    Stored {
        unknowns,
        bodies: 3,
        pair: vec![[0, 2], [2, 1]],
        rows: [numbers(2 * unknowns, 0), numbers(2 * unknowns, 1)],
        q: numbers(2, 2),
        start: numbers(2, 3),
        gamma: numbers(2, 4),
        velocity: numbers(3 * unknowns, 5),
    }
}

fn header() -> LcpHeader {
    LcpHeader {
        format: LCP_FORMAT.into(),
        version: LCP_VERSION,
        program: "0".into(),
        scene: "a scene".into(),
        step: 7,
        recursion: 2,
        solver: "apgd".into(),
        tolerance: 1e-6,
        precision: "f64".into(),
        status: "no_progress".into(),
        products: 99,
    }
}

fn bits(lcp: &Stored) -> Vec<u64> {
    let vectors = [&lcp.rows[0], &lcp.rows[1], &lcp.q, &lcp.start, &lcp.gamma, &lcp.velocity];
    vectors.into_iter().flatten().map(|x| x.to_bits()).collect()
}

#[test]
fn an_lcp_round_trips_bit_for_bit() {
    for unknowns in [3, 6] {
        let lcp = lcp(unknowns);
        let (read, about) = decode_lcp(&encode_lcp(&lcp, &header()).unwrap()).unwrap();
        assert_eq!((&read, about), (&lcp, Some(header())));
        assert_eq!(bits(&read), bits(&lcp));
    }
    let empty = Stored { unknowns: 6, ..Stored::default() };
    assert_eq!(decode_lcp(&encode_lcp(&empty, &header()).unwrap()).unwrap().0, empty);
    let mut broken = lcp(3);
    (broken.q[0], broken.gamma[1]) = (f64::NAN, f64::INFINITY);
    let read = decode_lcp(&encode_lcp(&broken, &header()).unwrap()).unwrap().0;
    assert_eq!(bits(&read), bits(&broken));
}

#[test]
fn every_damaged_byte_and_every_cut_is_found() {
    let bytes = encode_lcp(&lcp(3), &header()).unwrap();
    for at in 0..bytes.len() {
        for flip in [0x01, 0x20, 0xff] {
            let mut damaged = bytes.clone();
            damaged[at] ^= flip;
            assert!(decode_lcp(&damaged).is_err(), "byte {at} of {}", bytes.len());
        }
        assert!(decode_lcp(&bytes[..at]).is_err(), "cut at {at}");
    }
    assert!(matches!(decode_lcp(b"a text"), Err(LcpFileError::NotAnLcp(_))));
    assert!(matches!(decode_lcp(&[]), Err(LcpFileError::NotAnLcp(_))));
    let state = encode(&State::default(), "0123456789abcdef", 0.0, None).unwrap();
    let refused = decode_lcp(&state).unwrap_err();
    assert_eq!(refused, LcpFileError::NotAnLcp("it is a `relcp-state`".into()));
    let newer = LcpHeader { version: 2, ..header() };
    let newer = decode_lcp(&encode_lcp(&lcp(3), &newer).unwrap()).unwrap_err();
    assert_eq!(newer, LcpFileError::Newer { found: 2, known: LCP_VERSION });
}

/// A file like numpy's: deflated, without header and seal; each array with its type, shape and bytes.
fn foreign(arrays: &[(&str, &str, &str, Vec<u8>)]) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, kind, shape, data) in arrays {
        let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
        zip.start_file(format!("{name}.npy"), options).unwrap();
        let text = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({shape}), }}\n");
        zip.write_all(b"\x93NUMPY\x01\x00").unwrap();
        zip.write_all(&(text.len() as u16).to_le_bytes()).unwrap();
        zip.write_all(text.as_bytes()).unwrap();
        zip.write_all(data).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

/// One row between two of three planar bodies, with other number types than this program's.
fn arrays() -> Vec<(&'static str, &'static str, &'static str, Vec<u8>)> {
    let reals = |numbers: &[f64]| numbers.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let singles = [0.5_f32, -2.0, 3.25].iter().flat_map(|x| x.to_le_bytes()).collect();
    vec![
        ("bodies", "<i8", "", 3_i64.to_le_bytes().to_vec()),
        ("a", "<u4", "1,", 2_u32.to_le_bytes().to_vec()),
        ("b", "<i8", "1,", 0_i64.to_le_bytes().to_vec()),
        ("row_a", "<f4", "1, 3", singles),
        ("row_b", "<f8", "1, 3", reals(&[1.0, 2.0, 3.0])),
        ("q", "<f8", "1,", reals(&[-1.0])),
        ("gamma0", "<f8", "1,", reals(&[0.0])),
        ("gamma", "<f8", "1,", reals(&[0.5])),
        ("v", "<f8", "3, 3", reals(&[0.0; 9])),
    ]
}

#[test]
fn files_of_other_programs_are_read() {
    let (read, about) = decode_lcp(&foreign(&arrays())).unwrap();
    assert_eq!((read.unknowns, read.bodies, &read.pair[..], about), (3, 3, &[[2, 0]][..], None));
    assert_eq!(read.rows, [vec![0.5, -2.0, 3.25], vec![1.0, 2.0, 3.0]]);
}

#[test]
fn damage_in_files_of_other_programs_is_found_or_harmless() {
    let bytes = foreign(&arrays());
    let whole = decode_lcp(&bytes).unwrap();
    let mut refused = 0;
    for at in 0..bytes.len() {
        for flip in [0x01, 0x20, 0xff] {
            let mut damaged = bytes.clone();
            damaged[at] ^= flip;
            // Dates and permissions may be arbitrary; the numbers may not.
            match decode_lcp(&damaged) {
                Ok(read) => assert_eq!(read, whole, "byte {at}"),
                Err(_) => refused += 1,
            }
        }
        assert!(decode_lcp(&bytes[..at]).is_err(), "cut at {at}");
    }
    assert!(refused > 2 * bytes.len());
}

#[test]
fn what_no_lcp_can_have_is_refused_with_its_array() {
    let with = |name: &str, change: (&'static str, &'static str, Vec<u8>)| {
        let mut arrays = arrays();
        let array = arrays.iter_mut().find(|array| array.0 == name).unwrap();
        (array.1, array.2, array.3) = change;
        decode_lcp(&foreign(&arrays)).unwrap_err()
    };
    let word = |n: i64| n.to_le_bytes().to_vec();
    let cases = [
        ("bodies", ("<i8", "", word(-1)), "bodies", "one number"),
        ("bodies", ("<i8", "2,", [word(3), word(3)].concat()), "bodies", "one number"),
        ("bodies", ("<f8", "", word(3)), "bodies", "not whole"),
        ("bodies", ("<i8", "", word(2)), "a", "row 0 has body 2 of 2"),
        ("b", ("<i8", "1,", word(-1)), "b", "row 0 has body -1 of 3"),
        ("b", ("<i8", "1,", word(2)), "b", "same body twice"),
        ("row_a", ("<f8", "1, 4", [0; 32].to_vec()), "row_a", "3 or 6 numbers"),
        ("row_a", ("<f8", "1, 6", [0; 48].to_vec()), "row_b", "its shape is [1, 3]"),
        ("row_b", ("<i8", "1, 3", [0; 24].to_vec()), "row_b", "not reals"),
        ("q", ("<f8", "4611686018427387905, 4", word(0)), "q", "shape is not that of its numbers"),
        ("q", ("<f8", "2,", [0; 16].to_vec()), "row_a", "2 rows"),
        ("gamma0", ("<f8", "", word(0)), "gamma0", "its shape is []"),
        ("v", ("<f8", "1, 3", [0; 24].to_vec()), "v", "not [3, 3]"),
        ("v", (">f8", "3, 3", [0; 72].to_vec()), "v", "no array of numbers"),
        ("v", ("|O", "3, 3", [0; 72].to_vec()), "v", "no array of numbers"),
    ];
    for (array, change, wrong, says) in cases {
        match with(array, change) {
            LcpFileError::Damaged { place, what } => {
                assert_eq!(place, wrong, "{what}");
                assert!(what.contains(says), "{array}: {what}");
            }
            other => panic!("{array}: {other}"),
        }
    }
    let mut missing = arrays();
    missing.remove(7);
    let refused = decode_lcp(&foreign(&missing)).unwrap_err();
    assert_eq!(refused, LcpFileError::NotAnLcp("it has no gamma.npy".into()));
}

/// The names and contents of the saved LCPs of a built-in scene's run.
fn run(name: &str, sets: &[&str], clean: bool) -> Vec<(String, Stored, LcpHeader)> {
    let parent = tempfile::tempdir().unwrap();
    let sets: Vec<String> = sets.iter().map(|set| set.to_string()).collect();
    let scene = Scene::load(name, &sets).unwrap();
    let bodies = scene.build().unwrap();
    let folder = Folder::create(parent.path()).unwrap();
    let mut run =
        Run::start(Simulation::builder(scene).bodies(bodies).build().unwrap(), folder.clone(), Duration::ZERO).unwrap();
    while !run.done() {
        run.advance().unwrap();
    }
    assert_eq!(run.totals().clean(), clean);
    saved(&folder)
}

fn saved(folder: &Folder) -> Vec<(String, Stored, LcpHeader)> {
    let Ok(entries) = std::fs::read_dir(folder.lcps()) else { return Vec::new() };
    let mut paths: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    let read = |path: &std::path::PathBuf| {
        let (lcp, header) = read_lcp(path).unwrap();
        (path.file_name().unwrap().to_str().unwrap().to_owned(), lcp, header.unwrap())
    };
    paths.iter().map(read).collect()
}

fn names(saved: &[(String, Stored, LcpHeader)]) -> Vec<&str> {
    saved.iter().map(|(name, ..)| name.as_str()).collect()
}

#[test]
fn a_run_saves_what_its_scene_asks_for() {
    let none = run("three-capsules", &[], true);
    assert_eq!(none, []);
    let all = run("three-capsules", &["solver.dump.when=all", "solver.dump.most=3"], true);
    let expected = ["step-000001-rec-0.npz", "step-000001-rec-1.npz", "step-000002-rec-0.npz"];
    assert_eq!(names(&all), expected);
    for (name, lcp, header) in &all {
        assert!(lcp.residual(&lcp.gamma) <= header.tolerance, "{name}");
        let problem = lcp.problem::<6>().unwrap();
        assert_eq!(velocity(&problem, &lcp.gamma).into_flattened(), lcp.velocity, "{name}");
        assert_eq!((header.solver.as_str(), header.status.as_str()), ("auto", "solved"));
        assert_eq!((header.scene.as_str(), header.precision.as_str()), ("three-capsules", "f64"));
    }
    // A recursion continues from the multipliers before it, and a new row starts from zero.
    let [first, second] = [&all[0].1, &all[1].1];
    assert_eq!(first.gamma[..], second.start[..first.gamma.len()]);
    assert!(second.start[first.gamma.len()..].iter().all(|x| *x == 0.0));
    assert!(second.pair.len() > first.pair.len());
}

#[test]
fn solves_that_fail_or_are_slow_are_saved_alone() {
    let failing = [
        "solver.dump.when=unconverged",
        "solver.kind=pair_block_cg",
        "solver.max_iterations=1",
        "contact.on_failure=continue",
    ];
    let failed = run("three-capsules", &failing, false);
    assert!(!failed.is_empty() && failed.len() <= 10);
    for (name, lcp, header) in &failed {
        assert_eq!(header.status, "max_iterations", "{name}");
        assert!(lcp.residual(&lcp.gamma) > header.tolerance, "{name}");
    }
    assert_eq!(run("three-capsules", &["solver.dump.when=unconverged"], true), []);
    let most = run("three-capsules", &["solver.dump.when=all", "solver.dump.most=100"], true);
    let limit = most.iter().map(|(.., header)| header.products).max().unwrap();
    let set = format!("solver.dump={{\"when\": \"slow\", \"products\": {limit}, \"most\": 100}}");
    let slow = run("three-capsules", &[&set], true);
    assert!(!slow.is_empty() && slow.len() < most.len());
    assert!(slow.iter().all(|(.., header)| header.products == limit));
}

#[test]
fn a_run_that_is_taken_up_again_saves_no_more_and_the_same() {
    let sets = ["solver.dump.when=all".to_string(), "solver.dump.most=5".into()];
    let scene = || Scene::load("three-capsules", &sets).unwrap();
    let whole = run("three-capsules", &["solver.dump.when=all", "solver.dump.most=5"], true);
    assert_eq!(whole.len(), 5);
    let parent = tempfile::tempdir().unwrap();
    let folder = Folder::create(parent.path()).unwrap();
    let simulation = Simulation::new(scene()).unwrap();
    let mut first = Run::start(simulation, folder.clone(), Duration::ZERO).unwrap();
    first.advance().unwrap();
    first.checkpoint().unwrap();
    first.advance().unwrap();
    // As if it were killed here: the files of step 2 are made again.
    drop(first);
    let mut again = Run::resume(scene(), folder.clone(), &Compute::Cpu).unwrap();
    assert!(saved(&folder).iter().all(|(.., header)| header.step == 1));
    while !again.done() {
        again.advance().unwrap();
    }
    let expected: Vec<&str> = names(&whole);
    assert_eq!(names(&saved(&folder)), expected);
    assert_eq!(saved(&folder), whole);
}
