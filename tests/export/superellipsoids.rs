//! Superellipsoids in other programs' formats, which have none: exports draw the ellipsoid with their semi-axes, and
//! name the shape and its sizes.

use crate::gsd_file;
use crate::vtp_file::{Vtp, collection};
use glam::{DQuat, DVec3};
use relcp::bodies::{Bodies, NO_GROUP};
use relcp::export::{Format, export};
use relcp::record::{Snapshot, States};
use relcp::separation::Placed;
use relcp::shape::{Shape, Superellipsoid};

const RADII: [[f64; 3]; 3] = [[0.4, 0.5, 0.6], [1.0, 1.0, 0.3], [0.7, 0.2, 0.9]];

/// Three superellipsoids and a ball between them.
fn snapshot() -> Snapshot {
    let mut bodies = Bodies::default();
    let [a, b, c] = [[4.0, 4.0], [2.5, 2.0], [10.0, 3.0]];
    let of = |k: usize, exponents| Shape::Superellipsoid(Superellipsoid::new(RADII[k], exponents));
    for (k, shape) in [of(0, a), Shape::Sphere { radius: 0.5 }, of(1, b), of(2, c)].into_iter().enumerate() {
        let position = DVec3::new(3.0 * k as f64, 0.25, -0.5);
        bodies.push(Placed { shape, position, orientation: DQuat::from_rotation_x(0.5 * k as f64) }, NO_GROUP);
    }
    Snapshot { step: 3, time: 0.5, bodies, warm: None, removed: Vec::new(), fields: Vec::new() }
}

fn exported(format: Format) -> (tempfile::TempDir, Vec<std::path::PathBuf>) {
    let folder = tempfile::tempdir().unwrap();
    let states = States::single("dice", snapshot());
    let done = export(&states, format, folder.path(), &mut |_, _| true).unwrap();
    assert_eq!((done.states, done.bodies), (1, 4));
    (folder, done.files)
}

fn numbers(words: &[&str]) -> Vec<f64> {
    words.iter().map(|word| word.parse().unwrap()).collect()
}

#[test]
fn paraview_has_their_sizes_and_glyphs_of_their_semi_axes() {
    let (folder, _) = exported(Format::Vtk { cutoff: None });
    let vtp = Vtp::read(&collection(&folder.path().join("bodies.pvd"))[0].1);
    assert_eq!(vtp.column("shape"), [5.0, 0.0, 5.0, 5.0]);
    let (sizes, glyphs) = (vtp.rows("PointData", "size"), vtp.rows("PointData", "glyph"));
    for (k, radii) in [0, 2, 3].into_iter().zip(RADII) {
        assert_eq!((sizes[k].as_slice(), glyphs[k].as_slice()), (radii.as_slice(), radii.map(|r| 2.0 * r).as_slice()));
    }
}

#[test]
fn text_files_have_their_names_sizes_and_extents() {
    let (_folder, files) = exported(Format::Lammps);
    let text = std::fs::read_to_string(&files[0]).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let columns: Vec<&str> = lines[10].split(' ').skip(2).collect();
    let at = |name: &str| columns.iter().position(|column| *column == name).unwrap();
    for (k, radii) in [0, 2, 3].into_iter().zip(RADII) {
        let words: Vec<&str> = lines[11 + k].split(' ').collect();
        assert_eq!(numbers(&words[at("d_size1")..][..3]), radii);
        for (extent, radius) in numbers(&words[at("shapex")..][..3]).into_iter().zip(radii) {
            assert!((extent - 2.0 * radius).abs() < 1e-15, "{extent} {radius}");
        }
    }
    let (_folder, files) = exported(Format::Xyz);
    let text = std::fs::read_to_string(&files[0]).unwrap();
    for (k, radii) in [0, 2, 3].into_iter().zip(RADII) {
        let words: Vec<&str> = text.lines().nth(2 + k).unwrap().split(' ').collect();
        assert_eq!(
            (numbers(&words[11..14]), words[14], numbers(&words[15..18])),
            (radii.into(), "superellipsoid", radii.into())
        );
    }
}

#[test]
fn ovito_draws_the_ellipsoids_with_their_semi_axes() {
    let (_folder, files) = exported(Format::Gsd);
    let frames = gsd_file::read(&files[0]);
    let (types, drawn) = (frames[0]["particles/typeid"].u32s(), gsd_file::shapes(&frames[0]));
    for (k, radii) in [0, 2, 3].into_iter().zip(RADII) {
        let of = &drawn[types[k] as usize];
        assert_eq!(of["type"], "Ellipsoid");
        for (key, radius) in ["a", "b", "c"].into_iter().zip(radii) {
            assert_eq!(of[key].as_f64(), Some(radius));
        }
    }
    assert_eq!(drawn[types[1] as usize]["type"], "Sphere");
    assert_eq!(frames[0]["log/particles/size"].f64s()[..3], RADII[0]);
}
