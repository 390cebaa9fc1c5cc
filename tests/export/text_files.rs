//! LAMMPS dumps and extended XYZ, read back line by line.

use crate::scenes::{colony, every_shape};
use relcp::export::{Format, export};
use relcp::record::{Snapshot, States};
use relcp::shape::Shape;
use std::fs;

fn written(snapshot: &Snapshot, format: Format) -> String {
    let out = tempfile::tempdir().unwrap();
    let states = States::single("bodies", snapshot.clone());
    let done = export(&states, format, out.path(), &mut |_, _| true).unwrap();
    assert_eq!((done.states, done.bodies, done.files.len()), (1, snapshot.bodies.len(), 1));
    let text = fs::read_to_string(&done.files[0]).unwrap();
    assert_eq!(text.len() as u64, done.bytes);
    text
}

fn numbers(words: &[&str]) -> Vec<f64> {
    words.iter().map(|word| word.parse().unwrap()).collect()
}

#[test]
fn a_lammps_dump_has_all_digits_and_extents_of_every_shape() {
    let snapshot = every_shape();
    let text = written(&snapshot, Format::Lammps);
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[..2], ["ITEM: TIME", &format!("{:?}", snapshot.time)]);
    assert_eq!(lines[4..7], ["ITEM: NUMBER OF ATOMS", "40", "ITEM: BOX BOUNDS ff ff ff"]);
    let columns: Vec<&str> = lines[10].split(' ').skip(2).collect();
    let at = |name: &str| columns.iter().position(|column| *column == name).unwrap();
    for (k, line) in lines[11..].iter().enumerate() {
        let words: Vec<&str> = line.split(' ').collect();
        assert_eq!(words.len(), columns.len());
        let bodies = &snapshot.bodies;
        assert_eq!(words[at("id")], (bodies.lineage[k].id + 1).to_string());
        assert_eq!(numbers(&words[at("x")..][..3]), bodies.position[k].to_array());
        let q = bodies.orientation[k];
        assert_eq!(numbers(&words[at("quatw")..][..4]), [q.w, q.x, q.y, q.z]);
        let extents = match bodies.shape[k] {
            Shape::Sphere { radius } => [2.0 * radius; 3],
            Shape::Spherocylinder { diameter, length } => [diameter, diameter, length],
            Shape::Ellipsoid { radii } => radii.map(|radius| 2.0 * radius),
            Shape::Torus { major_radius: major, minor_radius: minor } => {
                [2.0 * (major + minor), 2.0 * (major + minor), 2.0 * minor]
            }
            _ => unreachable!(),
        };
        for (found, wanted) in numbers(&words[at("shapex")..][..3]).into_iter().zip(extents) {
            assert!((found - wanted).abs() <= 1e-15 * wanted, "{found} for {wanted}");
        }
        let parent = bodies.lineage[k].parent.map_or(0, |parent| parent + 1);
        assert_eq!(words[at("i_parent")], parent.to_string());
    }
    assert_eq!(lines.len(), 11 + 40);
}

#[test]
fn an_extended_xyz_file_has_a_column_for_every_word() {
    let snapshot = every_shape();
    let text = written(&snapshot, Format::Xyz);
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[0], "40");
    assert!(
        lines[1].contains("pbc=\"F F F\"") && lines[1].contains(&format!("Time={:?}", snapshot.time)),
        "{}",
        lines[1]
    );
    let properties = lines[1].split("Properties=").nth(1).unwrap();
    let parts: Vec<&str> = properties.split(':').collect();
    let words: usize = parts.chunks(3).map(|part| part[2].parse::<usize>().unwrap()).sum();
    for (k, line) in lines[2..].iter().enumerate() {
        let found: Vec<&str> = line.split(' ').collect();
        assert_eq!(found.len(), words, "{line}");
        assert_eq!(numbers(&found[1..4]), snapshot.bodies.position[k].to_array());
        assert_eq!(found[14], snapshot.bodies.shape[k].name());
    }
}

#[test]
fn a_planar_colony_is_two_dimensional_in_every_format() {
    let place = tempfile::tempdir().unwrap();
    let run = colony(place.path());
    let states = States::open(run.path().to_str().unwrap()).unwrap();
    assert!(states.planar().unwrap());
    let out = tempfile::tempdir().unwrap();
    let lammps = export(&states, Format::Lammps, out.path(), &mut |_, _| true).unwrap();
    let text = fs::read_to_string(&lammps.files[0]).unwrap();
    assert!(text.contains("ITEM: BOX BOUNDS ff ff pp\n") && text.contains("\n-0.5 0.5\n"));
    assert_eq!(text.matches("ITEM: TIMESTEP").count(), states.len());
    let gsd = export(&states, Format::Gsd, out.path(), &mut |_, _| true).unwrap();
    let frames = crate::gsd_file::read(&gsd.files[0]);
    assert_eq!(frames[0]["configuration/box"].f32s()[2], 0.0);
}
