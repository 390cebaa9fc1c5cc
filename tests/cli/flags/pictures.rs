//! Flags of `relcp render` and `relcp view`.

use super::{Case, Place, case, comes, compute, fresh, json, ran, same, shows_json, shows_quiet, threads};
use serde_json::{Value, json};
use std::fs;
use std::path::PathBuf;

pub const CASES: &[Case] = &[
    case("render", "--out", out),
    case("render", "--colour", colour),
    case("render", "--range", range),
    case("render", "--size", size),
    case("render", "--view", view),
    case("render", "--background", background),
    case("render", "--format", format),
    case("render", "--fit", fit),
    case("render", "--bare", bare),
    case("render", "--last", last),
    case("render", "--every", every),
    case("render", "--from", from),
    case("render", "--to", to),
    case("render", "--fps", movies::fps),
    case("render", "--movie", movies::movie),
    case("render", "--no-movie", movies::no_movie),
    case("render", "--backend", compute::shows_backend),
    case("render", "--adapter", compute::shows_adapter),
    case("render", "--threads", threads::shows),
    case("render", "--json", shows_json),
    case("render", "--quiet", shows_quiet),
    case("view", "--out", page),
    case("view", "--colour", colour_of_page),
    case("view", "--last", last),
    case("view", "--every", every),
    case("view", "--from", from),
    case("view", "--to", to),
    case("view", "--open", movies::open),
    case("view", "--threads", threads::shows),
    case("view", "--json", shows_json),
    case("view", "--quiet", shows_quiet),
];

/// Renders the last state: the document, and its picture.
fn last_picture(place: &Place, more: &[&str]) -> (Value, PathBuf) {
    let document = json(place, "render", &[&["--last"], more].concat());
    let picture = place.at(document["folder"].as_str().unwrap()).join("frames/000000.png");
    (document, picture)
}

/// The times of the states that are shown: all in a document of pictures, in a page the first and the last.
fn times(place: &Place, command: &str, more: &[&str]) -> Vec<f64> {
    let document = json(place, command, more);
    let states = match command {
        "render" => document["frames"].clone(),
        _ => header(place, &document)["states"].clone(),
    };
    states.as_array().unwrap().iter().map(|state| state["time"].as_f64().unwrap()).collect()
}

/// What the page of a document says of its run.
fn header(place: &Place, document: &Value) -> Value {
    use base64::Engine;
    let page = fs::read_to_string(place.at(document["file"].as_str().unwrap())).unwrap();
    let (_, rest) = page.split_once("<script type=\"text/plain\" id=\"run\">").unwrap();
    let packed = base64::engine::general_purpose::STANDARD.decode(rest.split_once("</script>").unwrap().0).unwrap();
    serde_json::from_reader(flate2::read::ZlibDecoder::new(packed.as_slice())).unwrap()
}

fn out(place: &Place, _: &str) {
    let (document, picture) = last_picture(place, &[]);
    assert!(document["folder"].as_str().unwrap().starts_with("out-") && picture.is_file());
    assert!(!place.at("run/render").exists());
    let elsewhere = ["--last", "--size", "64x36", "--no-movie", "--backend", "cpu", "--quiet"];
    for (run, folder) in [("run", "run/render"), ("rods.json", "rods-render")] {
        place.relcp(&[&["render", run], &elsewhere[..]].concat()).expect(0);
        assert!(place.at(folder).join("frames/000000.png").is_file(), "{folder}");
    }
}

fn colour(place: &Place, _: &str) {
    let ((speed, a), (plain, b)) =
        (last_picture(place, &["--colour", "speed"]), last_picture(place, &["--colour", "plain"]));
    assert_eq!((&speed["colour"], &plain["colour"]), (&json!("speed"), &json!("plain")));
    assert!(!same(&a, &b));
    ran(place, "render", &["--colour", "taste"]).expect(2);
}

fn range(place: &Place, _: &str) {
    let (document, _) = last_picture(place, &["--colour", "length", "--range", "-1:2.5"]);
    let scale = &document["frames"][0]["scale"];
    assert_eq!((&scale["low"], &scale["high"]), (&json!(-1.0), &json!(2.5)));
    ran(place, "render", &["--range", "2:1"]).expect(2);
}

fn size(place: &Place, _: &str) {
    let out = fresh();
    let render = ["render", "run", "--last", "--size", "70x40", "--no-movie", "--backend", "cpu", "--quiet"];
    place.relcp(&[&render[..], &["--out", &out]].concat()).expect(0);
    let bytes = fs::read(place.at(&out).join("frames/000000.png")).unwrap();
    let side = |at: usize| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap());
    assert_eq!((side(16), side(20)), (70, 40));
}

fn view(place: &Place, _: &str) {
    let sides = ["top", "front", "right", "oblique"].map(|side| {
        let (document, picture) = last_picture(place, &["--view", side]);
        assert_eq!(document["side"], side);
        fs::read(picture).unwrap()
    });
    assert!(sides.iter().enumerate().all(|(k, picture)| !sides[..k].contains(picture)));
    assert_eq!(last_picture(place, &[]).0["side"], "oblique");
}

fn background(place: &Place, _: &str) {
    let corners = ["white", "dark", "transparent"].map(|background| {
        let (_, picture) = last_picture(place, &["--bare", "--background", background]);
        let mut decoder = png::Decoder::new(std::io::BufReader::new(fs::File::open(picture).unwrap()));
        decoder.set_transformations(png::Transformations::ALPHA);
        let mut reader = decoder.read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut bytes).unwrap();
        [bytes[0], bytes[3]]
    });
    let [[white, opaque], [dark, _], [_, clear]] = corners;
    assert!(white == 255 && dark < 100 && opaque == 255 && clear == 0, "{corners:?}");
}

/// Vectors are of planar scenes.
fn format(place: &Place, _: &str) {
    let out = fresh();
    for (format, head) in super::measure::HEADS {
        let words = ["render", "colony", "--backend", "cpu", "--quiet", "--out", &out, "--format", format];
        place.relcp(&words).expect(0);
        let pictures = place.at(&out).join("frames");
        assert!(fs::read(pictures.join(format!("000000.{format}"))).unwrap().starts_with(head), "{format}");
    }
    ran(place, "render", &["--format", "jpeg"]).expect(2);
}

fn fit(place: &Place, _: &str) {
    let scales = |fit: &str| -> Vec<String> {
        let document = json(place, "render", &["--fit", fit, "--every", "6"]);
        assert_eq!(document["fit"], fit);
        document["frames"].as_array().unwrap().iter().map(|frame| frame["pixels_per_length"].to_string()).collect()
    };
    let (run, each) = (scales("run"), scales("each"));
    assert!(run.iter().all(|scale| *scale == run[0]) && each.iter().any(|scale| *scale != each[0]), "{run:?} {each:?}");
}

fn bare(place: &Place, _: &str) {
    // Words and bars have room in a picture of this size.
    let picture = |more: &[&str]| {
        let out = fresh();
        let render = ["render", "run", "--last", "--size", "320x240", "--no-movie", "--backend", "cpu", "--quiet"];
        place.relcp(&[&render[..], &["--out", &out], more].concat()).expect(0);
        place.at(&out).join("frames/000000.png")
    };
    let (bare, full) = (picture(&["--bare"]), picture(&[]));
    assert!(!same(&bare, &full) && fs::metadata(bare).unwrap().len() < fs::metadata(full).unwrap().len());
}

fn last(place: &Place, command: &str) {
    assert_eq!(times(place, command, &["--last"]), [1.2]);
    ran(place, command, &["--last", "--from", "1"]).expect(2);
}

fn every(place: &Place, command: &str) {
    let shown = times(place, command, &["--every", "6"]);
    assert!(shown.len() == 3 && (shown[1] - 0.6).abs() < 1e-9, "{shown:?}");
    ran(place, command, &["--every", "0"]).expect(2);
}

fn from(place: &Place, command: &str) {
    let shown = times(place, command, &["--from", "0.95"]);
    assert!(shown.len() == 3 && (shown[0] - 1.0).abs() < 1e-9, "{shown:?}");
}

fn to(place: &Place, command: &str) {
    let shown = times(place, command, &["--to", "0.25"]);
    assert!(shown.len() == 3 && (shown[2] - 0.2).abs() < 1e-9, "{shown:?}");
}

fn page(place: &Place, _: &str) {
    let out = json(place, "view", &[])["file"].as_str().unwrap().to_owned();
    assert!(out.starts_with("out-") && place.at(&out).is_file() && !place.at("run/view.html").exists());
    place.relcp(&["view", "run", "--quiet"]).expect(0);
    place.relcp(&["view", "rods.json", "--quiet"]).expect(0);
    assert!(place.at("run/view.html").is_file() && place.at("rods-view.html").is_file());
}

fn colour_of_page(place: &Place, _: &str) {
    assert_eq!(header(place, &json(place, "view", &["--last", "--colour", "speed"]))["colour"], "speed");
    assert_eq!(header(place, &json(place, "view", &["--last"]))["colour"], Value::Null);
}

/// Flags that have other programs do something: substitutes for them say what they were asked for.
mod movies {
    use super::*;

    /// Runs the program where only this script, by this name, is on the path.
    #[cfg(unix)]
    fn beside(place: &Place, name: &str, script: &str, words: &[&str]) -> String {
        use std::os::unix::fs::PermissionsExt;
        let programs = place.at("programs");
        fs::create_dir_all(&programs).unwrap();
        let program = programs.join(name);
        fs::write(&program, format!("#!/bin/sh\n{script}\n")).unwrap();
        fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
        let mut command = assert_cmd::Command::cargo_bin("relcp").unwrap();
        let output = command.current_dir(&place.0).env("PATH", &programs).args(words).output().unwrap();
        assert!(output.status.success(), "{output:?}");
        String::from_utf8(output.stdout).unwrap()
    }

    #[cfg(not(unix))]
    fn beside(_: &Place, name: &str, _: &str, _: &[&str]) -> String {
        println!("SKIP what {name} is asked for: the substitute is a script of sh");
        String::new()
    }

    /// Renders two pictures with an encoder that writes its arguments into the movie: what was asked for, where a movie
    /// is made.
    fn encoded(place: &Place, more: &[&str], movie: Option<&str>) -> Option<String> {
        let out = fresh();
        let render = ["render", "run", "--every", "12", "--size", "64x36", "--backend", "cpu", "--out", &out];
        let script = "for last in \"$@\"; do :; done\necho \"$*\" > \"$last\"";
        beside(place, "ffmpeg", script, &[&render[..], more].concat());
        fs::read_to_string(movie.map_or(place.at(&out).join("movie.mp4"), |movie| place.at(movie))).ok()
    }

    pub fn fps(place: &Place, _: &str) {
        ran(place, "render", &["--fps", "0"]).expect(2);
        if cfg!(unix) {
            let (asked, default) = (encoded(place, &["--fps", "7"], None), encoded(place, &[], None));
            assert!(asked.unwrap().contains("-framerate 7 ") && default.unwrap().contains("-framerate 25 "));
        }
    }

    pub fn movie(place: &Place, _: &str) {
        if cfg!(unix) {
            assert!(encoded(place, &["--movie", "own.mkv"], Some("own.mkv")).is_some());
        }
        let out = fresh();
        let render = ["render", "run", "--every", "12", "--size", "64x36", "--backend", "cpu", "--out", &out];
        place.relcp(&[&render[..], &["--movie", "own.png"]].concat()).expect(0);
        let decoder = png::Decoder::new(std::io::BufReader::new(fs::File::open(place.at("own.png")).unwrap()));
        assert_eq!(decoder.read_info().unwrap().info().animation_control().unwrap().num_frames, 2);
        place.relcp(&["render", "run", "--movie", "own.gif"]).expect(2);
    }

    pub fn no_movie(place: &Place, _: &str) {
        assert!(encoded(place, &["--no-movie"], None).is_none());
    }

    /// The browser is not waited for.
    pub fn open(place: &Place, _: &str) {
        if !cfg!(target_os = "linux") {
            println!("SKIP what shows a page: the substitute is that of Linux");
            return;
        }
        let words = ["view", "run", "--last", "--open", "--quiet", "--out", "shown.html"];
        beside(place, "xdg-open", "echo \"$1\" > asked.part\nexec /bin/mv asked.part asked", &words);
        assert!(comes(|| place.at("asked").exists()), "nothing was shown");
        assert_eq!(fs::read_to_string(place.at("asked")).unwrap().trim(), "shown.html");
    }
}
