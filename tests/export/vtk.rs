//! Collections for ParaView: structure, counts and values.

use crate::scenes::{colony, every_shape};
use crate::vtp_file::{Vtp, collection};
use glam::DVec3;
use relcp::bodies::{Bodies, NO_GROUP};
use relcp::export::vtk;
use relcp::fields::{Concentration, Grid};
use relcp::record::{Snapshot, States, TOUCHING, read_state};
use relcp::separation::separation;
use relcp::shape::Shape;
use std::path::Path;

/// The files of state `which` in the collections of `folder`.
fn files(folder: &Path, which: usize) -> [Vtp; 3] {
    ["bodies", "axes", "contacts"].map(|name| Vtp::read(&collection(&folder.join(format!("{name}.pvd")))[which].1))
}

fn exported(states: &States, cutoff: Option<f64>) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let done = vtk(states, folder.path(), cutoff, &mut |_, _| true).unwrap();
    assert_eq!(done.states, states.len());
    assert!(done.files.iter().all(|file| file.exists()));
    folder
}

/// Each field has a collection of image data: its grid, and the bits of the state.
#[test]
fn fields_are_image_data() {
    let concentration = |name: &str, cells: [u32; 3], center: [f64; 3]| Concentration {
        name: name.into(),
        grid: Grid { cells, spacing: 0.5, center },
        values: (0..cells.iter().product()).map(|i| f64::from(i).sqrt()).collect(),
    };
    let fields = vec![concentration("food", [4, 3, 2], [1.0, 2.0, 3.0]), concentration("waste", [2, 2, 1], [0.0; 3])];
    let state = Snapshot { fields: fields.clone(), ..every_shape() };
    let folder = exported(&States::single("fed", state), None);
    for (field, extent, origin) in
        [(&fields[0], "0 4 0 3 0 2", "0.0 1.25 2.5"), (&fields[1], "0 2 0 2 0 1", "-0.5 -0.5 -0.25")]
    {
        let [(time, path)] = collection(&folder.path().join(format!("field-{}.pvd", field.name))).try_into().unwrap();
        let vti = Vtp::read(&path);
        assert_eq!((time, vti.time()), (0.1 + 0.2, 0.1 + 0.2));
        assert_eq!(vti.rows("CellData", "concentration").concat(), field.values);
        let head = String::from_utf8_lossy(&std::fs::read(&path).unwrap()).into_owned();
        let grid = format!("<ImageData WholeExtent=\"{extent}\" Origin=\"{origin}\" Spacing=\"0.5 0.5 0.5\">");
        assert!(head.contains(&grid) && head.contains(&format!("<Piece Extent=\"{extent}\">")), "{grid}");
    }
}

#[test]
fn bodies_are_the_states_bits() {
    let state = every_shape();
    let folder = exported(&States::single("mixed", state.clone()), None);
    assert_eq!(collection(&folder.path().join("bodies.pvd"))[0].0, 0.1 + 0.2);
    let [vtp, ..] = files(folder.path(), 0);
    let Snapshot { bodies, .. } = &state;
    assert_eq!((vtp.points(), vtp.counts["NumberOfVerts"], vtp.time()), (40, 40, 0.1 + 0.2));
    assert_eq!(vtp.cells("Verts"), (0..40).map(|i| vec![i]).collect::<Vec<_>>());
    let (points, turns) = (vtp.rows("Points", "Points"), vtp.rows("PointData", "orientation"));
    let (sizes, glyphs) = (vtp.rows("PointData", "size"), vtp.rows("PointData", "glyph"));
    let (velocity, spins) = (vtp.rows("PointData", "velocity"), vtp.rows("PointData", "angular_velocity"));
    let [shapes, ids, parents, births, generations, groups] =
        ["shape", "id", "parent", "birth", "generation", "group"].map(|name| vtp.column(name));
    for i in 0..40 {
        assert_eq!(points[i], bodies.position[i].to_array());
        let q = bodies.orientation[i];
        assert_eq!(turns[i], [q.w, q.x, q.y, q.z]);
        let (tag, size) = bodies.shape[i].code();
        assert_eq!((shapes[i], sizes[i].as_slice()), (f64::from(tag), size.as_slice()));
        let glyph = match bodies.shape[i] {
            Shape::Sphere { radius } => [2.0 * radius; 3],
            Shape::Ellipsoid { radii } => radii.map(|radius| 2.0 * radius),
            _ => [0.0; 3],
        };
        assert_eq!(glyphs[i], glyph);
        assert_eq!(velocity[i], bodies.velocity[i].to_array());
        assert_eq!(spins[i], bodies.angular_velocity[i].to_array());
        let lineage = bodies.lineage[i];
        assert_eq!((ids[i], parents[i]), (lineage.id as f64, lineage.parent.map_or(-1.0, |id| id as f64)));
        assert_eq!((births[i], generations[i]), (lineage.birth, f64::from(lineage.generation)));
        assert_eq!(groups[i], if bodies.group[i] == NO_GROUP { -1.0 } else { 1.0 });
    }
}

#[test]
fn axes_run_through_rods_and_rings() {
    let state = every_shape();
    let folder = exported(&States::single("mixed", state.clone()), None);
    let [_, vtp, _] = files(folder.path(), 0);
    let Snapshot { bodies, .. } = &state;
    let points: Vec<DVec3> = vtp.rows("Points", "Points").iter().map(|row| DVec3::from_slice(row)).collect();
    let [of, radius, cap, ids, shapes] = ["body", "radius", "cap", "id", "shape"].map(|name| vtp.column(name));
    let (lines, vertices) = (vtp.cells("Lines"), vtp.cells("Verts"));
    assert_eq!((lines.len(), vertices.len()), (19, 1), "the rod of no length is a point");
    let drawn: Vec<usize> = vertices.iter().chain(&lines).map(|cell| of[cell[0]] as usize).collect();
    assert_eq!(vtp.rows("CellData", "axis_of").concat(), drawn.iter().map(|i| *i as f64).collect::<Vec<_>>());
    for cell in vertices.iter().chain(&lines) {
        let i = of[cell[0]] as usize;
        assert!(cell.iter().all(|k| of[*k] as usize == i && ids[*k] == bodies.lineage[i].id as f64));
        let local: Vec<DVec3> =
            cell.iter().map(|k| bodies.orientation[i].inverse() * (points[*k] - bodies.position[i])).collect();
        match bodies.shape[i] {
            Shape::Spherocylinder { diameter, length } => {
                let half = 0.5 * (length - diameter);
                let ends: &[f64] = if half == 0.0 { &[0.0] } else { &[-half, half] };
                assert_eq!(local.len(), ends.len());
                assert!(local.iter().zip(ends).all(|(x, end)| x.abs_diff_eq(DVec3::Z * *end, 1e-14)));
                assert!(cell.iter().all(|k| (radius[*k], cap[*k], shapes[*k]) == (0.5 * diameter, diameter, 1.0)));
            }
            Shape::Torus { major_radius, minor_radius } => {
                assert!(
                    local.iter().all(|x| (x.truncate().length() - major_radius).abs() < 1e-14 && x.z.abs() < 1e-14)
                );
                assert!(cell.iter().all(|k| (radius[*k], cap[*k], shapes[*k]) == (minor_radius, 0.0, 3.0)));
                // Once around, and a segment more at each end.
                assert_eq!(local.len(), 67);
                assert!(local[1].abs_diff_eq(local[65], 1e-14) && local[2].abs_diff_eq(local[66], 1e-14));
            }
            shape => panic!("{shape:?} has no axis"),
        }
    }
    assert_eq!(drawn.iter().collect::<std::collections::BTreeSet<_>>().len(), 20);
}

#[test]
fn a_growing_colony_has_its_times_and_its_last_forces() {
    let parent = tempfile::tempdir().unwrap();
    let run = colony(parent.path());
    let states = States::open(run.path().to_str().unwrap()).unwrap();
    let folder = exported(&states, None);
    for name in ["bodies", "axes", "contacts"] {
        let listed = collection(&folder.path().join(format!("{name}.pvd")));
        let times: Vec<f64> = listed.iter().map(|(time, _)| *time).collect();
        let expected: Vec<f64> = (0..26).map(|i| states.read(i).unwrap().time).collect();
        assert_eq!(times, expected);
    }
    let mut known = 0;
    for i in 0..26 {
        let state = states.read(i).unwrap();
        let [bodies, axes, contacts] = files(folder.path(), i);
        assert_eq!((bodies.points(), axes.points()), (state.bodies.len(), 2 * state.bodies.len()));
        known += contacts.column("gamma").iter().filter(|gamma| gamma.is_finite()).count();
        if i < 25 {
            assert!(contacts.column("gamma").iter().all(|gamma| gamma.is_nan()));
        }
    }
    assert!(known > 0);
    // The last state is the checkpoint's: every pair that pushes is there, with the sum of its rows' multipliers.
    let (_, state) = read_state(&run.checkpoint()).unwrap();
    let [.., contacts] = files(folder.path(), 25);
    let [a, b, gamma, separations] = ["a", "b", "gamma", "separation"].map(|name| contacts.column(name));
    let (points, normals) = (contacts.rows("Points", "Points"), contacts.rows("PointData", "normal"));
    let pushing = state.warm.iter().filter(|warm| warm.gamma > 0.0);
    assert!(pushing.clone().count() > 0);
    for warm in pushing {
        let row = (0..a.len()).find(|k| [a[*k], b[*k]] == warm.pair.map(f64::from)).unwrap();
        let of_pair = state.warm.iter().filter(|other| other.pair == warm.pair);
        assert_eq!(gamma[row], of_pair.map(|warm| warm.gamma).sum::<f64>());
    }
    for k in 0..a.len() {
        let pair = [a[k] as usize, b[k] as usize].map(|i| state.bodies.placed(i));
        let exact = separation(&pair[0], &pair[1], None).unwrap();
        assert_eq!(separations[k], exact.separation);
        assert!(separations[k] <= TOUCHING * 0.5 || gamma[k] > 0.0);
        let places = state.warm.iter().filter(|warm| warm.pair.map(f64::from) == [a[k], b[k]] && warm.gamma > 0.0);
        if places.count() > 1 {
            // The resultant of two parallel forces is between them.
            assert!(DVec3::from_slice(&normals[k]).dot(exact.normal) > 0.99);
            continue;
        }
        assert_eq!(DVec3::from_slice(&normals[k]), exact.normal);
        let [on_a, on_b] = [pair[0].position + exact.lever_a, pair[1].position + exact.lever_b];
        assert!(DVec3::from_slice(&points[k]).abs_diff_eq(0.5 * (on_a + on_b), 1e-14));
    }
}

#[test]
fn a_cutoff_decides_what_is_a_contact() {
    let parent = tempfile::tempdir().unwrap();
    let run = colony(parent.path());
    let last = States::open(run.state(250).to_str().unwrap()).unwrap();
    let count = |cutoff| files(exported(&last, cutoff).path(), 0)[2].points();
    let near = relcp::step::contacts(&last.read(0).unwrap().bodies, 0.3).len();
    assert_eq!(count(Some(0.3)), near);
    assert!(near > count(None));
    assert_eq!(count(Some(-1.0)), 0);
}

#[test]
fn no_bodies_are_files_of_no_points() {
    let empty = Snapshot { bodies: Bodies::default(), ..every_shape() };
    let folder = exported(&States::single("empty", empty), None);
    for vtp in files(folder.path(), 0) {
        assert_eq!((vtp.points(), vtp.time()), (0, 0.1 + 0.2));
    }
}

#[test]
fn what_is_not_finite_is_refused_with_its_place() {
    let folder = tempfile::tempdir().unwrap();
    let mut state = every_shape();
    state.bodies.angular_velocity[31].x = f64::NAN;
    let error = vtk(&States::single("mine", state), folder.path(), None, &mut |_, _| true).unwrap_err();
    assert!(error.to_string().contains("mine: body 31: its angular velocity of NaN is not finite"), "{error}");
    assert!(!folder.path().join("bodies.pvd").exists());
}

#[test]
fn the_script_stands_beside_them_and_knows_where() {
    let folder = exported(&States::single("mixed", every_shape()), None);
    let script = std::fs::read_to_string(folder.path().join("show.py")).unwrap();
    let place = folder.path().canonicalize().unwrap();
    assert!(script.contains(&format!("FOLDER = \"{}\"", place.display())) && !script.contains("FOLDER = None"));
}
