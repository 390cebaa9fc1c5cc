//! `relcp render` from outside, on runs made by the program itself.

use assert_cmd::Command;
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::BufReader;
use std::path::Path;

/// Runs the program with `path` as the folders of programs.
#[track_caller]
fn relcp_on(path: &Path, folder: &Path, arguments: &[&str], status: i32) -> (String, String) {
    let mut command = Command::cargo_bin("relcp").unwrap();
    let output = command.current_dir(folder).env("PATH", path).args(arguments).output().unwrap();
    let [out, err] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {out}{err}");
    (out, err)
}

/// Where there is no `ffmpeg`.
#[track_caller]
fn relcp(folder: &Path, arguments: &[&str], status: i32) -> (String, String) {
    relcp_on(Path::new("/no/programs"), folder, arguments, status)
}

/// A colony from one cell to eight, in six states.
fn colony(folder: &Path, run: &str, forces: bool) {
    let forces = format!("output.forces={forces}");
    let sets = ["time.dt=0.02", "time.end=2.5", "growth.reorientation_degrees=20", "output.every=0.5", &forces];
    let mut arguments = vec!["run", "colony", "--out", run, "--quiet", "--backend", "cpu"];
    arguments.extend(sets.iter().flat_map(|set| ["--set", set]));
    relcp(folder, &arguments, 0);
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<_> = entries.collect();
    names.sort();
    names
}

fn frames(folder: &Path) -> Vec<Vec<u8>> {
    names(&folder.join("frames")).iter().map(|name| fs::read(folder.join("frames").join(name)).unwrap()).collect()
}

fn document(folder: &Path) -> Value {
    serde_json::from_slice(&fs::read(folder.join("frames.json")).unwrap()).unwrap()
}

/// Width and bytes of a picture.
fn pixels(path: &Path) -> (u32, u32, Vec<[u8; 3]>) {
    let mut reader = png::Decoder::new(BufReader::new(File::open(path).unwrap())).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    (info.width, info.height, bytes.as_chunks::<3>().0.to_vec())
}

#[test]
fn a_run_has_a_picture_a_state_with_one_camera_and_one_scale() {
    let place = tempfile::tempdir().unwrap();
    colony(place.path(), "run", false);
    let (out, err) = relcp(place.path(), &["render", "run", "--colour", "length", "--size", "400x250"], 0);
    assert!(out.starts_with("6 pictures of 400 x 250 in run/render/frames") && err.is_empty(), "{out}{err}");
    assert!(out.contains("note: no movie.mp4: `ffmpeg` is not on the path"), "{out}");
    let folder = place.path().join("run/render");
    assert_eq!(names(&folder), ["frames", "frames.json"]);
    assert_eq!(names(&folder.join("frames")), (0..6).map(|k| format!("{k:06}.png")).collect::<Vec<_>>());
    let document = document(&folder);
    assert_eq!((&document["complete"], &document["side"]), (&true.into(), &"top".into()));
    let shown = document["frames"].as_array().unwrap();
    let steps: Vec<_> = shown.iter().map(|frame| frame["step"].as_u64().unwrap()).collect();
    assert_eq!(steps, [0, 25, 50, 75, 100, 125]);
    assert_eq!((&shown[0]["bodies"], &shown[5]["bodies"]), (&1.into(), &8.into()));
    let mut covered = Vec::new();
    let mut bars = BTreeSet::new();
    for frame in shown {
        for key in ["centre", "pixels_per_length", "scale"] {
            assert_eq!(frame[key], shown[5][key]);
        }
        let (width, height, pixels) = pixels(&folder.join(frame["file"].as_str().unwrap()));
        assert_eq!((width, height), (400, 250));
        assert!(pixels.iter().collect::<BTreeSet<_>>().len() > 50);
        covered.push(pixels.iter().filter(|pixel| **pixel != [255; 3]).count());
        // The lower border has the bar of length to the left and the scale of colours to the right, and no body.
        bars.insert(pixels[241 * 400..].to_vec());
    }
    // A cell grows to twice its length and divides: in a still frame more and more is covered, by a bounded factor.
    assert!(covered.windows(2).all(|pair| pair[1] > pair[0]), "{covered:?}");
    assert_eq!(bars.len(), 1);
    let scale = &shown[0]["scale"];
    assert!(scale["low"].as_f64().unwrap() >= 2.0 && scale["high"].as_f64().unwrap() <= 4.0, "{scale}");

    relcp(place.path(), &["render", "run", "--fit", "each", "--out", "each", "--size", "200x200", "--quiet"], 0);
    let each = self::document(&place.path().join("each"));
    let lengths: Vec<_> = (0..6).map(|k| each["frames"][k]["pixels_per_length"].as_f64().unwrap()).collect();
    assert!(lengths.windows(2).all(|pair| pair[1] < pair[0]), "{lengths:?}");
}

#[test]
fn pictures_are_the_same_for_any_number_of_threads_and_all_are_made_again() {
    let place = tempfile::tempdir().unwrap();
    colony(place.path(), "run", true);
    let folder = place.path().join("run/render");
    for colour in ["pressure", "orientation"] {
        let small = ["render", "run", "--size", "200x160", "--quiet", "--colour", colour, "--threads"];
        relcp(place.path(), &[&small[..], &["1"]].concat(), 0);
        let one = frames(&folder);
        // What a rendering that was stopped leaves, and one of more states.
        fs::write(folder.join("frames/000002.png"), b"half").unwrap();
        fs::write(folder.join("frames/000099.png"), b"old").unwrap();
        fs::write(folder.join("frames/.relcp-x.part"), b"half").unwrap();
        relcp(place.path(), &[&small[..], &["3"]].concat(), 0);
        assert_eq!(one.len(), 6);
        assert!(one == frames(&folder));
    }
}

#[test]
fn every_colour_that_the_states_have_is_told_apart() {
    let place = tempfile::tempdir().unwrap();
    colony(place.path(), "run", true);
    let mut all = BTreeSet::new();
    let colours =
        ["orientation", "age", "generation", "length", "speed", "contacts", "overlap", "force", "pressure", "plain"];
    for colour in colours {
        let arguments =
            ["render", "run", "--colour", colour, "--from", "2", "--size", "300x200", "--bare", "--json", "--out", "x"];
        let (out, _) = relcp(place.path(), &arguments, 0);
        let document: Value = serde_json::from_str(&out).unwrap();
        assert_eq!((&document["colour"], &document["folder"]), (&colour.into(), &"x".into()));
        let scaled = !["orientation", "plain"].contains(&colour);
        let scale = &document["frames"][0]["scale"];
        assert_eq!(scale.is_object() && scale["high"].as_f64().unwrap() > scale["low"].as_f64().unwrap(), scaled);
        all.insert(frames(&place.path().join("x")));
    }
    assert_eq!(all.len(), colours.len());
}

#[test]
fn groups_have_colours_of_their_own() {
    let place = tempfile::tempdir().unwrap();
    let ball =
        |x: f64, group: &str| format!(r#"{{"shape": {{"sphere": {{"radius": 1}}}}, "position": [{x}, 0, 0]{group}}}"#);
    let bodies = [ball(-3.0, ""), ball(0.0, r#", "group": "a""#), ball(3.0, r#", "group": "b""#)].join(", ");
    let scene =
        format!(r#"{{"name": "groups", "time": {{"dt": 0.1, "end": 0}}, "planar": true, "bodies": [{bodies}]}}"#);
    fs::write(place.path().join("groups.json"), scene).unwrap();
    let arguments =
        ["render", "groups.json", "--colour", "group", "--size", "300x120", "--bare", "--out", "x", "--json"];
    let document: Value = serde_json::from_str(&relcp(place.path(), &arguments, 0).0).unwrap();
    let scale = &document["frames"][0]["scale"];
    assert_eq!((scale["low"].as_f64(), scale["high"].as_f64()), (Some(0.0), Some(2.0)));
    let (width, height, pixels) = pixels(&place.path().join("x/frames/000000.png"));
    let middle = |part: f64| pixels[(height / 2 * width) as usize + (part * f64::from(width)) as usize];
    let found: BTreeSet<[u8; 3]> = [0.2, 0.5, 0.8].map(middle).into();
    assert_eq!(found.len(), 3, "{found:?}");
}

#[test]
fn states_are_chosen_by_time_and_number() {
    let place = tempfile::tempdir().unwrap();
    colony(place.path(), "run", false);
    let steps = |more: &[&str]| -> Vec<u64> {
        let arguments = [&["render", "run", "--size", "64x64", "--out", "x", "--json"], more].concat();
        let document: Value = serde_json::from_str(&relcp(place.path(), &arguments, 0).0).unwrap();
        document["frames"].as_array().unwrap().iter().map(|frame| frame["step"].as_u64().unwrap()).collect()
    };
    assert_eq!(steps(&["--every", "2"]), [0, 50, 100]);
    assert_eq!(steps(&["--from", "0.5", "--to", "2"]), [25, 50, 75, 100]);
    assert_eq!(steps(&["--from", "0.1", "--every", "3"]), [25, 100]);
    let (_, err) = relcp(place.path(), &["render", "run", "--from", "2.6", "--out", "none"], 2);
    assert!(err.contains("none of the 6 states is at time 2.6 or later"), "{err}");
    assert!(!place.path().join("none").exists());
}

#[test]
fn scenes_and_single_states_are_drawn_too_and_from_any_side() {
    let place = tempfile::tempdir().unwrap();
    let mut all = BTreeSet::new();
    for view in ["top", "front", "right", "oblique"] {
        let size = ["--size", "120x100", "--bare", "--background", "dark"];
        relcp(place.path(), &[&["render", "two-ellipsoids", "--view", view, "--json"], &size[..]].concat(), 0);
        all.insert(frames(&place.path().join("two-ellipsoids-render")));
    }
    assert_eq!(all.len(), 4);
    colony(place.path(), "run", false);
    // One picture is no movie, so there is nothing to be said of it.
    let state = "run/states/state_0000000050.npz";
    let (out, _) = relcp(place.path(), &["render", state, "--size", "99x99"], 0);
    assert_eq!(out, "1 picture of 99 x 99 in state_0000000050-render/frames\n");
}

#[test]
fn pictures_as_vectors_have_the_camera_of_pictures_in_pixels() {
    let place = tempfile::tempdir().unwrap();
    colony(place.path(), "run", false);
    let render = |format: &str| {
        let arguments = ["render", "run", "--size", "400x300", "--format", format, "--out", format, "--quiet"];
        relcp(place.path(), &arguments, 0);
        (frames(&place.path().join(format)), document(&place.path().join(format)))
    };
    let [(svg, svgs), (pdf, pdfs), (_, pngs)] = ["svg", "pdf", "png"].map(render);
    let last = String::from_utf8(svg.last().unwrap().clone()).unwrap();
    assert!(last.contains("viewBox=\"0 0 400 300\"") && last.contains("t=2.5  n=8"), "{last}");
    assert!(pdf.len() == svg.len() && pdf.iter().all(|bytes| bytes.starts_with(b"%PDF")));
    for (at, frame) in pngs["frames"].as_array().unwrap().iter().enumerate() {
        for vectors in [&svgs, &pdfs] {
            assert_eq!(vectors["frames"][at]["centre"], frame["centre"]);
            assert_eq!(vectors["frames"][at]["pixels_per_length"], frame["pixels_per_length"]);
        }
    }
    // Another format in the same folder replaces what was there.
    relcp(place.path(), &["render", "run", "--last", "--format", "svg", "--out", "pdf", "--quiet"], 0);
    assert_eq!(names(&place.path().join("pdf/frames")), ["000000.svg"]);
}

#[test]
fn what_cannot_be_drawn_is_said_before_anything_is_written() {
    let place = tempfile::tempdir().unwrap();
    colony(place.path(), "run", false);
    fs::create_dir(place.path().join("empty")).unwrap();
    for (arguments, status, said) in [
        (&["render"] as &[&str], 2, "RUN"),
        (&["render", "run/final.json", "--colour", "force"], 2, "output.forces=true"),
        (&["render", "run/final.json", "--colour", "pressure"], 2, "has no contact forces"),
        (&["render", "run", "--colour", "temperature"], 2, "orientation"),
        (&["render", "run", "--range", "0:1"], 2, "orientation has no scale"),
        (&["render", "run", "--colour", "age", "--range", "1:1"], 2, "not below"),
        (&["render", "run", "--size", "0x100"], 2, "1 to 16384"),
        (&["render", "run", "--size", "100"], 2, "1920x1080"),
        (&["render", "run", "--fps", "0"], 2, "fps"),
        (&["render", "run", "--every", "0"], 2, "every"),
        (&["render", "run", "--movie", "x.gif"], 2, ".mp4"),
        (&["render", "run", "--movie", "x.mp4"], 2, "`ffmpeg` is not on the path"),
        (&["render", "two-ellipsoids", "--colour", "age"], 2, "`growth`"),
        (&["render", "colony", "--colour", "group"], 2, "no body of these states has a group"),
        (&["render", "two-ellipsoids", "--format", "pdf"], 2, "this run is seen in space"),
        (&["render", "run", "--format", "svg", "--view", "front"], 2, "this run is seen from a side"),
        (&["render", "run", "--format", "svg", "--movie", "x.mp4"], 2, "--format"),
        (&["render", "run", "--out", "run/scene.json"], 4, "scene.json"),
        (&["render", "empty"], 4, "no state to draw"),
        (&["render", "no-such-run"], 2, "no-such-run"),
    ] {
        let (out, err) = relcp(place.path(), arguments, status);
        // A message is broken into lines and indented.
        let err = err.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ");
        assert!(out.is_empty() && err.contains(said), "{arguments:?}: {out}{err}");
    }
    assert_eq!(names(&place.path().join("empty")), [""; 0]);
    assert!(!place.path().join("run/render").exists() && !place.path().join("x.mp4").exists());
    // The checkpoint knows its forces.
    relcp(place.path(), &["render", "run", "--colour", "force", "--from", "2.5", "--size", "64x64", "--quiet"], 0);
    let state = place.path().join("run/states/state_0000000050.npz");
    let mut bytes = fs::read(&state).unwrap();
    bytes[1500] ^= 1;
    fs::write(&state, bytes).unwrap();
    let before = frames(&place.path().join("run/render"));
    let (_, err) = relcp(place.path(), &["render", state.to_str().unwrap(), "--out", "run/render"], 4);
    assert!(err.contains("state_0000000050.npz") && err.contains("damaged"), "{err}");
    assert!(before == frames(&place.path().join("run/render")));
}

#[test]
fn pictures_of_others_are_left_alone() {
    let place = tempfile::tempdir().unwrap();
    let mine = place.path().join("mine/frames/000003.png");
    fs::create_dir_all(mine.parent().unwrap()).unwrap();
    fs::write(&mine, b"mine").unwrap();
    let arguments = ["render", "three-capsules", "--out", "mine", "--size", "64x64"];
    let (_, err) = relcp(place.path(), &arguments, 2);
    assert!(err.contains("--out"), "{err}");
    assert_eq!(fs::read(&mine).unwrap(), b"mine");
    fs::rename(&mine, mine.with_file_name("photo.png")).unwrap();
    relcp(place.path(), &arguments, 0);
    assert_eq!(names(&place.path().join("mine/frames")), ["000000.png", "photo.png"]);
}

#[cfg(unix)]
mod movies {
    use super::*;
    use std::os::unix::fs::PermissionsExt;

    /// A substitute for `ffmpeg` that says what it was asked for in the file that it writes, which is its last
    /// argument.
    fn programs(folder: &Path, script: &str) -> std::path::PathBuf {
        let programs = folder.join("programs");
        fs::create_dir_all(&programs).unwrap();
        let program = programs.join("ffmpeg");
        fs::write(&program, format!("#!/bin/sh\n{script}\n")).unwrap();
        fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
        programs
    }

    const LAST: &str = "for last in \"$@\"; do :; done";

    #[test]
    fn an_encoder_on_the_path_makes_a_movie() {
        let place = tempfile::tempdir().unwrap();
        colony(place.path(), "run", false);
        let programs = programs(place.path(), &format!("{LAST}\necho \"$*\" > \"$last\""));
        let size = ["render", "run", "--size", "64x64"];
        let (out, _) = relcp_on(&programs, place.path(), &size, 0);
        assert!(out.contains("run/render/movie.mp4"), "{out}");
        let asked = fs::read_to_string(place.path().join("run/render/movie.mp4")).unwrap();
        for said in ["-framerate 25 -i run/render/frames/%06d.png", "-c:v libx264", "-pix_fmt yuv420p -f mp4"] {
            assert!(asked.contains(said), "{asked}");
        }
        // An older movie does not outlive its pictures.
        relcp(place.path(), &size, 0);
        assert_eq!(names(&place.path().join("run/render")), ["frames", "frames.json"]);
        let own = ["--movie", "own.mkv", "--fps", "10", "--json"];
        let (out, _) = relcp_on(&programs, place.path(), &[&size[..], &own].concat(), 0);
        assert_eq!(serde_json::from_str::<Value>(&out).unwrap()["movie"], "own.mkv");
        assert!(fs::read_to_string(place.path().join("own.mkv")).unwrap().contains("-f matroska"));
        relcp_on(&programs, place.path(), &[&size[..], &["--no-movie"]].concat(), 0);
        assert!(!place.path().join("run/render/movie.mp4").exists());
        let (_, err) = relcp_on(&programs, place.path(), &["render", "run", "--movie", "no/x.mp4", "--out", "y"], 4);
        assert!(err.contains("find the movie's folder") && !place.path().join("y").exists(), "{err}");
    }

    #[test]
    fn a_codec_that_is_not_there_is_replaced_and_a_failure_is_said() {
        let place = tempfile::tempdir().unwrap();
        colony(place.path(), "run", false);
        let second = format!("case \"$*\" in *libx264*) exit 1;; esac\n{LAST}\necho \"$*\" > \"$last\"");
        let programs = programs(place.path(), &second);
        relcp_on(&programs, place.path(), &["render", "run", "--size", "64x64"], 0);
        assert!(fs::read_to_string(place.path().join("run/render/movie.mp4")).unwrap().contains("-c:v mpeg4"));
        self::programs(place.path(), "echo no such codec >&2; exit 3");
        let (out, err) = relcp_on(&programs, place.path(), &["render", "run", "--size", "64x64"], 4);
        assert!(out.is_empty() && err.contains("no such codec") && err.contains("pictures are complete"), "{err}");
        assert_eq!(names(&place.path().join("run/render")), ["frames", "frames.json"]);
        assert_eq!(names(&place.path().join("run/render/frames")).len(), 6);
    }
}

/// The pictures of an animated PNG, each as the page shows it, and how long, in seconds.
fn played(path: &Path) -> Vec<(Vec<u8>, f64)> {
    let decoder = png::Decoder::new(std::io::BufReader::new(fs::File::open(path).unwrap()));
    let mut reader = decoder.read_info().unwrap();
    let [width, height] = [reader.info().width, reader.info().height].map(|side| side as usize);
    let count = reader.info().animation_control().unwrap().num_frames;
    let mut shown = vec![0; 3 * width * height];
    let mut played = Vec::new();
    for _ in 0..count {
        let mut part = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut part).unwrap();
        let control = *reader.info().frame_control().unwrap();
        let [left, top, wide, high] =
            [control.x_offset, control.y_offset, control.width, control.height].map(|number| number as usize);
        for row in 0..high {
            let at = 3 * ((top + row) * width + left);
            shown[at..at + 3 * wide].copy_from_slice(&part[3 * row * wide..3 * (row + 1) * wide]);
        }
        played.push((shown.clone(), f64::from(control.delay_num) / f64::from(control.delay_den)));
    }
    played
}

#[test]
fn a_moving_picture_needs_no_other_program() {
    let place = tempfile::tempdir().unwrap();
    colony(place.path(), "run", false);
    let arguments = ["render", "run", "--size", "64x64", "--fps", "10", "--movie", "colony.png"];
    let (out, _) = relcp(place.path(), &arguments, 0);
    assert!(out.contains("colony.png") && !out.contains("ffmpeg"), "{out}");
    let played = played(&place.path().join("colony.png"));
    let pictures = names(&place.path().join("run/render/frames"));
    assert_eq!(played.len(), pictures.len());
    for (name, (shown, _)) in pictures.iter().zip(&played) {
        let file = fs::File::open(place.path().join("run/render/frames").join(name)).unwrap();
        let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().unwrap();
        let mut drawn = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut drawn).unwrap();
        assert!(drawn == *shown, "{name}");
    }
    let among = ["render", "run", "--size", "64x64", "--movie", "run/render/../render/frames/000000.png"];
    let (_, err) = relcp(place.path(), &among, 2);
    assert!(err.contains("is among the pictures"), "{err}");
    let (last, others) = played.split_last().unwrap();
    assert!(last.1 == 1.0 && others.iter().all(|(_, seconds)| *seconds == 0.1));
}

#[test]
fn help_has_examples() {
    let place = tempfile::tempdir().unwrap();
    let (out, _) = relcp(place.path(), &["render", "--help"], 0);
    for said in ["Examples:", "--colour", "--movie", "output.forces", "ffmpeg", "frames.json"] {
        assert!(out.contains(said), "{said}");
    }
}
