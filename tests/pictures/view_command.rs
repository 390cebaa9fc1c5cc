//! `relcp view` from outside, on runs made by the program itself: the page holds what was recorded, within the error
//! that it states.

use crate::program::relcp;
use base64::Engine;
use relcp::Shape;
use relcp::bodies::Bodies;
use relcp::glam::{DQuat, DVec3};
use relcp::record::{States, contacts};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs;
use std::io::Read;
use std::path::Path;

/// A colony from one cell to eight, in six states.
fn colony(folder: &Path, more: &[&str]) -> String {
    let sets = ["time.dt=0.02", "time.end=2.5", "growth.reorientation_degrees=20", "output.every=0.5"];
    let mut arguments = vec!["run", "colony", "--out", "run", "--backend", "cpu"];
    arguments.extend(sets.iter().flat_map(|set| ["--set", set]));
    arguments.extend(more);
    relcp(folder, &arguments, 0).0
}

/// Bodies of every shape that fall, turn and touch, in a box or in a periodic cell.
fn mixed(folder: &Path, space: &Value, rings: bool) -> usize {
    let body = |shape: Value, at: [f64; 3], turn: [f64; 4]| {
        let fast = [0.3 - 0.1 * at[0], 0.1, -0.5];
        json!({"shape": shape, "position": at, "orientation": turn, "velocity": fast, "angular_velocity": [0.4, -1.1, 2.0]})
    };
    let rod =
        body(json!({"spherocylinder": {"diameter": 0.4, "length": 1.6}}), [-0.4, 0.3, -1.2], [0.6, 0.0, 0.8, 0.0]);
    let bodies = match rings {
        true => vec![
            rod,
            body(json!({"torus": {"major_radius": 0.6, "minor_radius": 0.2}}), [1.6, 0.4, -1.2], [0.8, 0.0, 0.6, 0.0]),
        ],
        false => vec![
            rod,
            body(json!({"sphere": {"radius": 0.5}}), [-1.9, 0.0, -1.2], [1.0, 0.0, 0.0, 0.0]),
            body(json!({"ellipsoid": {"radii": [0.3, 0.5, 0.8]}}), [0.8, -0.3, -1.0], [0.5, 0.5, -0.5, 0.5]),
            body(json!({"ellipsoid": {"radii": [0.4, 0.4, 0.7]}}), [0.8, 1.3, -1.0], [0.5, -0.5, -0.5, 0.5]),
        ],
    };
    let count = bodies.len();
    let mut scene = json!({
        "name": "mixed", "dynamics": {"inertial": {"density": 1.0}}, "time": {"dt": 0.01, "end": 0.6},
        "forces": [{"gravity": {"acceleration": [0.0, 0.0, -3.0]}}],
        "bodies": bodies,
        "output": {"every": 0.1, "forces": true},
    });
    scene.as_object_mut().unwrap().extend(space.as_object().unwrap().clone());
    fs::write(folder.join("mixed.json"), scene.to_string()).unwrap();
    relcp(folder, &["run", "mixed.json", "--out", "run", "--quiet", "--backend", "cpu"], 0);
    count
}

/// A page, taken apart by what `docs/view.md` says of it.
struct Page {
    header: Value,
    blocks: BTreeMap<String, Vec<u8>>,
}

impl Page {
    fn read(path: &Path) -> Page {
        let text = fs::read_to_string(path).unwrap();
        let mut blocks = BTreeMap::new();
        for part in text.split("<script type=\"text/plain\" id=\"").skip(1) {
            let (name, rest) = part.split_once("\">").unwrap();
            let packed =
                base64::engine::general_purpose::STANDARD.decode(rest.split_once("</script>").unwrap().0).unwrap();
            let mut bytes = Vec::new();
            flate2::read::ZlibDecoder::new(packed.as_slice()).read_to_end(&mut bytes).unwrap();
            blocks.insert(name.to_owned(), bytes);
        }
        Page { header: serde_json::from_slice(&blocks["run"]).unwrap(), blocks }
    }

    fn columns(&self, name: &str, layout: &Value) -> BTreeMap<String, Vec<u32>> {
        let mut bytes = self.blocks[name].as_slice();
        let mut columns = BTreeMap::new();
        for column in layout.as_array().unwrap() {
            let [count, planes] = [1, 2].map(|k| column[k].as_u64().unwrap() as usize);
            let mut values = vec![0; count];
            for plane in 0..planes {
                let (part, rest) = bytes.split_at(count);
                values.iter_mut().zip(part).for_each(|(value, byte)| *value |= u32::from(*byte) << (8 * plane));
                bytes = rest;
            }
            columns.insert(column[0].as_str().unwrap().to_owned(), values);
        }
        assert!(bytes.is_empty(), "{name}");
        columns
    }
}

fn signed(value: u32) -> i64 {
    i64::from(value >> 1) ^ -i64::from(value & 1)
}

fn numbers<const N: usize>(value: &Value) -> [f64; N] {
    std::array::from_fn(|k| value[k].as_f64().unwrap())
}

/// Checks every state of the page of `source` against what was recorded, and returns the page.
#[track_caller]
fn check(source: &Path, file: &Path) -> Page {
    let page = Page::read(file);
    let states = States::open(source.to_str().unwrap()).unwrap();
    let table = page.columns("bodies", &page.header["table"]["columns"]);
    let count = table["id"].len();
    let (mut centres, mut turns, mut rows) = (vec![[0_i64; 3]; count], vec![DQuat::IDENTITY; count], Vec::new());
    assert_eq!(page.header["states"].as_array().unwrap().len(), states.len());
    for i in 0..states.len() {
        let about = &page.header["states"][i];
        let state = states.read(i).unwrap();
        let read = page.columns(&format!("state-{i}"), &about["columns"]);
        assert_eq!((about["step"].as_u64(), about["time"].as_f64()), (Some(state.step), Some(state.time)));
        if let Some(differences) = read.get("row") {
            rows = differences
                .iter()
                .scan(0, |row, d| {
                    *row += signed(*d);
                    Some(*row as usize)
                })
                .collect();
        }
        assert_eq!(rows.len(), state.bodies.len());
        let bodies = state.bodies.wrapped();
        for (k, &row) in rows.iter().enumerate() {
            assert_eq!(u64::from(table["id"][row]), bodies.lineage[k].id);
            let parent = (table["has_parent"][row] == 1).then(|| u64::from(table["parent"][row]));
            assert_eq!((parent, table["generation"][row]), (bodies.lineage[k].parent, bodies.lineage[k].generation));
            for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
                centres[row][axis] += signed(read[name][k]);
            }
            turns[row] = turned(turns[row], &read, k);
            check_pose(&page.header, &bodies, k, centres[row], turns[row]);
            check_size(&page.header, about, &table, &read, (row, k), &bodies.shape[k]);
        }
        let pairs = contacts(&state, None);
        assert!(about["contacts"].as_u64().unwrap() as usize >= pairs.len());
    }
    page
}

fn turned(last: DQuat, read: &BTreeMap<String, Vec<u32>>, k: usize) -> DQuat {
    let three = ["turn_1", "turn_2", "turn_3"].map(|name| signed(read[name][k]) as f64 / (32767.0 * 2.0_f64.sqrt()));
    let rest = (1.0 - three.iter().map(|part| part * part).sum::<f64>()).max(0.0).sqrt();
    let mut parts = three.to_vec();
    parts.insert(read["turn_largest"][k] as usize, rest);
    (last * DQuat::from_slice(&parts)).normalize()
}

#[track_caller]
fn check_pose(header: &Value, bodies: &Bodies, k: usize, steps: [i64; 3], turn: DQuat) {
    let step = header["length_step"].as_f64().unwrap();
    let middle: [f64; 3] = numbers(&header["middle"]);
    let origin = DVec3::from_array(numbers(&header["origin"]));
    let shown = origin + (DVec3::from_array(steps.map(|x| x as f64)) - DVec3::from_array(middle)) * step;
    let error = (shown - bodies.position[k]).abs().max_element();
    let stated = header["errors"]["centre"].as_f64().unwrap();
    assert!(error <= stated * (1.0 + 1e-6) + 1e-12 && stated <= 0.51 * step, "{error:e} {stated:e} {step:e}");
    let true_turn = bodies.orientation[k];
    let round = match bodies.shape[k] {
        Shape::Sphere { .. } => return,
        Shape::Ellipsoid { radii } => radii[0] == radii[1],
        _ => true,
    };
    let degrees = match round {
        true => (turn * DVec3::Z).cross(true_turn * DVec3::Z).length().asin().to_degrees(),
        false => {
            2.0 * (turn.inverse() * true_turn).to_array()[..3]
                .iter()
                .map(|x| x * x)
                .sum::<f64>()
                .sqrt()
                .asin()
                .to_degrees()
        }
    };
    let stated = header["errors"]["turn_degrees"].as_f64().unwrap();
    // Reckoned in 64 bits here and kept in 32 in the page.
    assert!(degrees <= stated + 1e-4 && stated < 0.01, "{degrees:e} {stated:e}");
}

#[track_caller]
fn check_size(
    header: &Value,
    about: &Value,
    table: &BTreeMap<String, Vec<u32>>,
    read: &BTreeMap<String, Vec<u32>>,
    (row, k): (usize, usize),
    shape: &Shape,
) {
    let [mut first, second, third] =
        ["size_1", "size_2", "size_3"].map(|name| f64::from(f32::from_bits(table[name][row])));
    if let (Some(half), 1) = (read.get("half_length"), table["kind"][row]) {
        let [low, high] = numbers(&about["ranges"]["half_length"]);
        first = low + (high - low) * f64::from(half[k]) / 65535.0;
    }
    let shown = match table["kind"][row] {
        0 => Shape::Sphere { radius: second },
        1 => Shape::Spherocylinder { diameter: 2.0 * second, length: 2.0 * (first + second) },
        2 => Shape::Torus { major_radius: first, minor_radius: second },
        _ => Shape::Ellipsoid { radii: [first, second, third] },
    };
    let allowed = header["errors"]["length"].as_f64().unwrap() + 1e-6 * shape.bounding_radius();
    assert_eq!(shown.name(), shape.name());
    assert!((shown.bounding_radius() - shape.bounding_radius()).abs() <= allowed, "{shown:?} {shape:?}");
    assert!((shown.thickness() - shape.thickness()).abs() <= allowed, "{shown:?} {shape:?}");
}

#[test]
fn a_growing_colony_is_in_one_file_that_asks_for_nothing() {
    let place = tempfile::tempdir().unwrap();
    let out = colony(place.path(), &["--view"]);
    assert!(out.contains("  page        run/view.html\n"), "{out}");
    let file = place.path().join("run/view.html");
    let page = check(&place.path().join("run"), &file);
    assert!(page.header["planar"].as_bool().unwrap());
    assert!(page.columns("bodies", &page.header["table"]["columns"])["id"].len() >= 15);
    let steps = &page.header["steps"];
    assert_eq!((steps["time"].as_array().unwrap().len(), &steps["bodies"][124]), (125, &json!(8)));
    let text = fs::read_to_string(&file).unwrap();
    for outside in ["http:", "https:", "src=", "href=", "url(", "import ", "fetch(", "XMLHttpRequest", "WebSocket"] {
        assert!(!text.contains(outside), "{outside}");
    }
    assert!(text.contains("default-src 'none'"));
    for mark in ["/*STYLE*/", "/*SHADERS*/", "/*SCRIPT*/", "<!--DATA-->"] {
        assert!(!text.contains(mark), "{mark}");
    }
}

#[test]
fn every_shape_is_shown_where_it_is_between_walls_and_in_periodic_space() {
    let walls = json!({"walls": [{"box": {"minimum": [-3.0, -3.0, -2.0], "maximum": [3.0, 3.0, 3.0]}}]});
    let spaces = [walls, json!({"periodic": {"lengths": [6.0, 6.0, 6.0]}}), json!({})];
    for (space, rings) in spaces.into_iter().flat_map(|space| [(space.clone(), false), (space, true)]) {
        let place = tempfile::tempdir().unwrap();
        let count = mixed(place.path(), &space, rings);
        let (out, err) = relcp(place.path(), &["view", "run"], 0);
        assert!(
            out.starts_with(&format!("run/view.html: 7 states of up to {count} bodies, ")) && err.is_empty(),
            "{out}{err}"
        );
        let page = check(&place.path().join("run"), &place.path().join("run/view.html"));
        assert_eq!(page.header["walls"].as_array().unwrap().len(), usize::from(!space["walls"].is_null()));
        assert_eq!(page.header["periods"][0].as_f64(), space["periodic"]["lengths"][0].as_f64());
        let quantities = page.header["quantities"].as_array().unwrap();
        let missing: Vec<_> =
            quantities.iter().filter(|it| !it["missing"].is_null()).map(|it| it["name"].as_str().unwrap()).collect();
        assert_eq!(missing, ["age", "generation", "group"]);
        if !space["walls"].is_null() {
            // Bodies that lie on the floor push the wall, which is the number past the last body.
            let last = &page.header["states"][6];
            let read = page.columns("state-6", &last["columns"]);
            let mut a = 0;
            let with: Vec<_> = read["contact_a"]
                .iter()
                .zip(&read["contact_b"])
                .map(|(d, b)| {
                    a += *d;
                    i64::from(a) + signed(*b)
                })
                .collect();
            assert!(with.contains(&(count as i64)) && read["contact_force"].iter().any(|force| *force > 0), "{with:?}");
        }
    }
}

#[test]
fn a_part_of_a_run_and_a_scene_have_pages_and_threads_do_not_matter() {
    let place = tempfile::tempdir().unwrap();
    colony(place.path(), &["--quiet"]);
    let part = ["view", "run", "--from", "0.9", "--every", "2", "--out", "part.html", "--colour", "age", "--json"];
    let (out, _) = relcp(place.path(), &part, 0);
    let document: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(
        (&document["file"], &document["states"], &document["bodies"]),
        (&json!("part.html"), &json!(2), &json!(4))
    );
    let page = Page::read(&place.path().join("part.html"));
    assert_eq!(page.header["states"][1]["time"].as_f64(), Some(2.0));
    assert_eq!(page.header["colour"], "age");
    let mut pages = Vec::new();
    for threads in ["1", "3"] {
        relcp(place.path(), &["view", "run", "--threads", threads, "--quiet"], 0);
        pages.push(fs::read(place.path().join("run/view.html")).unwrap());
    }
    assert!(pages[0] == pages[1]);
    relcp(place.path(), &["view", "chainmail", "--quiet"], 0);
    let page = Page::read(&place.path().join("chainmail-view.html"));
    assert_eq!((&page.header["steps"], page.header["planar"].as_bool()), (&Value::Null, Some(false)));
}

#[test]
fn what_cannot_be_shown_is_told_and_leaves_the_page_before() {
    let place = tempfile::tempdir().unwrap();
    colony(place.path(), &["--view", "--quiet"]);
    let file = place.path().join("run/view.html");
    let before = fs::read(&file).unwrap();
    let (_, err) = relcp(place.path(), &["view", "run", "--from", "9"], 2);
    assert!(err.contains("none of the 6 states is at time 9 or later"), "{err}");
    let state = place.path().join("run/states/state_0000000050.npz");
    let mut bytes = fs::read(&state).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&state, bytes).unwrap();
    let (_, err) = relcp(place.path(), &["view", state.to_str().unwrap(), "--out", "run/view.html"], 4);
    assert!(err.contains("state_0000000050.npz"), "{err}");
    assert!(before == fs::read(&file).unwrap());
    let parts = fs::read_dir(place.path().join("run"))
        .unwrap()
        .filter(|entry| entry.as_ref().unwrap().path().extension().is_some_and(|e| e == "part"));
    assert_eq!(parts.count(), 0);
    fs::create_dir(place.path().join("empty")).unwrap();
    let (_, err) = relcp(place.path(), &["view", "empty"], 4);
    assert!(err.contains("empty: no state to draw"), "{err}");
    let (_, err) = relcp(place.path(), &["view", "three-capsules", "--out", "no/such/folder/x.html"], 4);
    assert!(err.contains("no/such/folder"), "{err}");
    // A row that was cut short ends the plot, not the page.
    fs::remove_file(&state).unwrap();
    let steps = place.path().join("run/steps.csv");
    let text = fs::read_to_string(&steps).unwrap();
    fs::write(&steps, &text[..text.len() - 40]).unwrap();
    let (out, _) = relcp(place.path(), &["view", "run"], 0);
    assert!(
        out.contains("note: ") && out.contains("steps.csv") && out.contains("the plot ends after 124 steps"),
        "{out}"
    );
}

#[test]
fn a_page_has_the_measures_the_numbers_of_the_scene_and_the_bonds() {
    let place = tempfile::tempdir().unwrap();
    let sets = ["time.end=0.2", "output.measures=[\"radius\"]", "output.picture=false"];
    let sets: Vec<&str> = sets.iter().flat_map(|set| ["--set", *set]).collect();
    relcp(place.path(), &[&["run", "filament", "--out", "run", "--backend", "cpu", "--quiet"], &sets[..]].concat(), 0);
    relcp(place.path(), &["view", "run", "--quiet"], 0);
    let page = Page::read(&place.path().join("run/view.html"));
    let header = &page.header;
    assert_eq!((&header["version"], &header["colour"]), (&json!(env!("CARGO_PKG_VERSION")), &Value::Null));
    let parameters = header["parameters"].as_array().unwrap();
    assert!(parameters.iter().any(|pair| pair[0] == "time.dt" && pair[1].as_f64() > Some(0.0)), "{parameters:?}");
    let curves = header["measures"]["curves"].as_array().unwrap();
    assert!(curves.iter().any(|curve| curve[0] == "radius_gyration"), "{curves:?}");
    let text = fs::read_to_string(place.path().join("run/measures.csv")).unwrap();
    let rows = text.lines().count() - 1;
    assert_eq!(header["measures"]["radius_gyration"].as_array().unwrap().len(), rows);
    assert!(check_bonds(&place.path().join("run"), &page).iter().all(|bonds| *bonds > 5));
}

/// Checks the bonds of every state against what was recorded; how many hold in each.
#[track_caller]
fn check_bonds(run: &Path, page: &Page) -> Vec<usize> {
    assert_eq!((&page.header["bonded"], &page.header["bonds"]), (&json!(true), &json!([])));
    let states = States::open(run.to_str().unwrap()).unwrap();
    // A state without them has those of the one before.
    let mut last = BTreeMap::new();
    let of_state = |i: usize| {
        let read = page.columns(&format!("state-{i}"), &page.header["states"][i]["columns"]);
        if read.contains_key("bond_a") {
            last = read;
        }
        let bonds = states.read(i).unwrap().bodies.bonds.clone();
        assert_eq!(last.get("bond_a").map_or(0, Vec::len), bonds.len(), "state {i}");
        for (k, bond) in bonds.iter().enumerate() {
            assert_eq!([last["bond_a"][k], last["bond_b"][k]], bond.bodies, "state {i}");
            for (which, names) in
                [["bond_ax", "bond_ay", "bond_az"], ["bond_bx", "bond_by", "bond_bz"]].iter().enumerate()
            {
                for (axis, name) in names.iter().enumerate() {
                    assert_eq!(f32::from_bits(last[*name][k]), bond.at[which][axis] as f32, "state {i}, {name}");
                }
            }
        }
        bonds.len()
    };
    (0..states.len()).map(of_state).collect()
}

#[test]
fn a_page_has_the_bonds_of_daughters_as_they_come() {
    let place = tempfile::tempdir().unwrap();
    colony(place.path(), &["--set", "growth.bond_daughters={\"stiffness\": 100}", "--quiet"]);
    relcp(place.path(), &["view", "run", "--quiet"], 0);
    let bonds = check_bonds(&place.path().join("run"), &Page::read(&place.path().join("run/view.html")));
    let bodies = States::open(place.path().join("run").to_str().unwrap()).unwrap();
    let bodies: Vec<usize> = (0..bodies.len()).map(|i| bodies.read(i).unwrap().bodies.len()).collect();
    // A chain of cells has a bond less than cells.
    assert!(
        bodies.last() >= Some(&8) && bonds == bodies.iter().map(|bodies| bodies - 1).collect::<Vec<_>>(),
        "{bonds:?}"
    );
}
