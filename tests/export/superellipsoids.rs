//! Superellipsoids in other programs' formats: surfaces for ParaView, meshes in GSD, exponents by the names that OVITO
//! and LAMMPS have for them.

use crate::gsd_file;
use crate::vtp_file::{Vtp, collection};
use glam::{DQuat, DVec3};
use relcp::bodies::{Bodies, NO_GROUP};
use relcp::export::{Format, export};
use relcp::record::{Snapshot, States};
use relcp::separation::Placed;
use relcp::shape::{Shape, Superellipsoid};

const RADII: [[f64; 3]; 3] = [[0.4, 0.5, 0.6], [1.0, 1.0, 0.3], [0.7, 0.2, 0.9]];
const EXPONENTS: [[f64; 2]; 3] = [[4.0, 4.0], [2.5, 2.0], [10.0, 3.0]];
/// The rows of the superellipsoids.
const ROWS: [usize; 3] = [0, 2, 3];

/// Three superellipsoids and a ball between them.
pub fn snapshot() -> Snapshot {
    let mut bodies = Bodies::default();
    let of = |k: usize| Shape::Superellipsoid(Superellipsoid::new(RADII[k], EXPONENTS[k]));
    for (k, shape) in [of(0), Shape::Sphere { radius: 0.5 }, of(1), of(2)].into_iter().enumerate() {
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

/// The left side of the inequality of superellipsoid `k` of the list, at a point of space.
fn left(k: usize, point: DVec3) -> f64 {
    let ([n1, n2], bodies) = (EXPONENTS[k], snapshot().bodies);
    let row = ROWS[k];
    let v = (bodies.orientation[row].inverse() * (point - bodies.position[row]) / DVec3::from_array(RADII[k])).abs();
    (v.x.powf(n2) + v.y.powf(n2)).powf(n1 / n2) + v.z.powf(n1)
}

#[test]
fn paraview_has_their_surfaces_and_no_glyphs() {
    let (folder, files) = exported(Format::Vtk { cutoff: None });
    let bodies = Vtp::read(&collection(&folder.path().join("bodies.pvd"))[0].1);
    assert_eq!(bodies.column("shape"), [5.0, 0.0, 5.0, 5.0]);
    let rows = |name| bodies.rows("PointData", name);
    assert_eq!(rows("glyph"), [[0.0; 3], [1.0; 3], [0.0; 3], [0.0; 3]]);
    for (k, row) in ROWS.into_iter().enumerate() {
        assert_eq!(
            (rows("size")[row].as_slice(), rows("exponents")[row].as_slice()),
            (&RADII[k][..], &EXPONENTS[k][..])
        );
    }
    assert!(files.contains(&folder.path().join("surfaces.pvd")));
    let listed = collection(&folder.path().join("surfaces.pvd"));
    assert_eq!((listed.len(), listed[0].0), (1, 0.5));
    let surfaces = Vtp::read(&listed[0].1);
    let (points, body, normals) =
        (surfaces.rows("Points", "Points"), surfaces.column("body"), surfaces.rows("PointData", "Normals"));
    let vector = |row: &Vec<f64>| DVec3::from_slice(row);
    for (k, row) in ROWS.into_iter().enumerate() {
        let own: Vec<usize> = (0..points.len()).filter(|point| body[*point] == row as f64).collect();
        assert_eq!(own.len(), 602);
        for point in own {
            let (at, normal) = (vector(&points[point]), vector(&normals[point]));
            assert!((left(k, at) - 1.0).abs() < 1e-12, "{k} {at}");
            assert!((normal.length() - 1.0).abs() < 1e-6);
            // It is the steepest way out: nothing across it is inside by more than the surface bends.
            let h = 1e-4;
            assert!(left(k, at + h * normal) > 1.0 && left(k, at - h * normal) < 1.0);
            for across in [normal.any_orthonormal_vector(), normal.cross(normal.any_orthonormal_vector())] {
                let slope = (left(k, at + h * across) - left(k, at - h * across)) / (2.0 * h);
                let out = (left(k, at + h * normal) - left(k, at - h * normal)) / (2.0 * h);
                assert!(slope.abs() < 1e-5 * out, "{k} {at}: {slope:e} of {out}");
            }
        }
    }
    let faces = surfaces.cells("Polys");
    assert_eq!((faces.len(), surfaces.counts["NumberOfPolys"]), (1800, 1800));
    for face in faces {
        assert!(face.len() == 4 && face.iter().all(|corner| body[*corner] == body[face[0]]));
        let [a, b, c] = [0, 1, 2].map(|corner| vector(&points[face[corner]]));
        assert!((b - a).cross(c - a).dot(vector(&normals[face[0]])) > 0.0);
    }
}

#[test]
fn text_files_have_their_names_sizes_and_exponents() {
    let (_folder, files) = exported(Format::Lammps);
    let text = std::fs::read_to_string(&files[0]).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let columns: Vec<&str> = lines[10].split(' ').skip(2).collect();
    let at = |name: &str| columns.iter().position(|column| *column == name).unwrap();
    for (k, row) in ROWS.into_iter().enumerate() {
        let words: Vec<&str> = lines[11 + row].split(' ').collect();
        assert_eq!((words.len(), words[at("type")]), (columns.len(), "6"));
        assert_eq!(numbers(&words[at("d_size1")..][..3]), RADII[k]);
        assert_eq!(numbers(&[words[at("block1")], words[at("block2")]]), EXPONENTS[k]);
        for (extent, radius) in numbers(&words[at("shapex")..][..3]).into_iter().zip(RADII[k]) {
            assert!((extent - 2.0 * radius).abs() < 1e-15, "{extent} {radius}");
        }
    }
    assert!(lines[12].ends_with(" 2.0 2.0"));
    let (_folder, files) = exported(Format::Xyz);
    let text = std::fs::read_to_string(&files[0]).unwrap();
    assert!(text.lines().nth(1).unwrap().ends_with(":group:I:1:exponents:R:2:superquadric_roundness:R:2"));
    let words = |row: usize| text.lines().nth(2 + row).unwrap().split(' ').collect::<Vec<&str>>();
    for (k, row) in ROWS.into_iter().enumerate() {
        let words = words(row);
        assert_eq!(
            (numbers(&words[11..14]), words[14], numbers(&words[15..18])),
            (RADII[k].into(), "superellipsoid", RADII[k].into())
        );
        let [n1, n2] = EXPONENTS[k];
        assert_eq!(numbers(&words[26..]), [n1, n2, 2.0 / n2, 2.0 / n1]);
    }
    assert_eq!(numbers(&words(1)[26..]), [2.0, 2.0, 1.0, 1.0]);
}

#[test]
fn gsd_has_meshes_with_their_corners_on_the_surface() {
    let (_folder, files) = exported(Format::Gsd);
    let frames = gsd_file::read(&files[0]);
    let (types, drawn) = (frames[0]["particles/typeid"].u32s(), gsd_file::shapes(&frames[0]));
    let bodies = snapshot().bodies;
    for (k, row) in ROWS.into_iter().enumerate() {
        let of = &drawn[types[row] as usize];
        assert_eq!(of["type"], "Mesh");
        let corners: Vec<DVec3> = serde_json::from_value::<Vec<[f64; 3]>>(of["vertices"].clone())
            .unwrap()
            .into_iter()
            .map(|corner| bodies.position[row] + bodies.orientation[row] * DVec3::from_array(corner))
            .collect();
        assert_eq!((corners.len(), of["indices"].as_array().unwrap().len()), (602, 600));
        // Corners are 32-bit floats, which the exponents multiply.
        for corner in corners {
            assert!((left(k, corner) - 1.0).abs() < 1e-6, "{k} {corner}: {:e}", left(k, corner) - 1.0);
        }
    }
    assert_eq!(drawn[types[1] as usize]["type"], "Sphere");
    assert_eq!(frames[0]["log/particles/size"].f64s()[..3], RADII[0]);
    assert_eq!(frames[0]["log/particles/exponents"].f64s()[..4], [4.0, 4.0, 0.0, 0.0]);
}

/// Beyond the number of meshes they are classes, drawn as ellipsoids with their own semi-axes.
#[test]
fn many_sizes_are_ellipsoids_in_gsd_and_it_says_so() {
    let mut snapshot = snapshot();
    for k in 0..60 {
        let shape = Shape::Superellipsoid(Superellipsoid::new([0.3 + 0.01 * f64::from(k), 0.4, 0.5], [6.0, 6.0]));
        let position = DVec3::new(3.0 * f64::from(k), 5.0, 0.0);
        snapshot.bodies.push(Placed { shape, position, orientation: DQuat::IDENTITY }, NO_GROUP);
    }
    let folder = tempfile::tempdir().unwrap();
    let states = States::single("dice", snapshot);
    let done = export(&states, Format::Gsd, folder.path(), &mut |_, _| true).unwrap();
    assert!(done.notes.iter().any(|note| note.contains("OVITO draws them as ellipsoids")), "{:?}", done.notes);
    let frames = gsd_file::read(&done.files[0]);
    let (types, drawn) = (frames[0]["particles/typeid"].u32s(), gsd_file::shapes(&frames[0]));
    assert_eq!(drawn[types[63] as usize]["type"], "Ellipsoid");
    let own = frames[0]["log/particles/Aspherical Shape"].f32s();
    assert_eq!(own[3 * 63..], [(0.3 + 0.01 * 59.0) as f32, 0.4, 0.5]);
}
