//! Pictures: the same bytes for any number of threads, whole in a file, and no panic on what cannot be drawn.

use glam::{DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use relcp::bodies::{Bodies, NO_GROUP};
use relcp::render::{Background, Camera, Colour, Image, View, picture, picture_by};
use relcp::separation::Placed;
use relcp::shape::Shape;
use std::io::BufReader;

const SHAPES: [Shape; 4] = [
    Shape::Sphere { radius: 0.7 },
    Shape::Spherocylinder { diameter: 0.8, length: 2.6 },
    Shape::Ellipsoid { radii: [0.5, 0.8, 1.2] },
    Shape::Torus { major_radius: 0.9, minor_radius: 0.3 },
];

fn heap(count: usize, extent: f64) -> Bodies {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut bodies = Bodies::default();
    for k in 0..count {
        let position = DVec3::from_array(std::array::from_fn(|_| rng.random_range(-extent..extent)));
        let turn: [f64; 4] = std::array::from_fn(|_| rng.random_range(-1.0..1.0));
        let orientation = DQuat::from_array(turn).normalize();
        bodies.push(Placed { shape: SHAPES[k % 4], position, orientation }, NO_GROUP);
        bodies.lineage[k].generation = k as u32 % 7;
        bodies.lineage[k].birth = k as f64 * 0.1;
    }
    bodies
}

fn small(planar: bool) -> View {
    View { width: 150, height: 100, planar, ..View::default() }
}

fn white(pixel: [u8; 3]) -> bool {
    pixel == [255; 3]
}

/// Columns and rows of the pixels that are not white.
fn drawn(image: &Image) -> (Vec<u32>, Vec<u32>) {
    (0..image.height())
        .flat_map(|y| (0..image.width()).map(move |x| (x, y)))
        .filter(|&(x, y)| !white(image.pixel(x, y).expect("inside the picture")))
        .unzip()
}

#[test]
fn bytes_are_the_same_for_any_number_of_threads() {
    let bodies = heap(300, 5.0);
    for planar in [true, false] {
        let by = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| picture(&bodies, &View { width: 333, height: 217, planar, ..View::default() }))
        };
        let one = by(1);
        assert!(drawn(&one).0.len() > 10_000);
        assert!(one == by(2) && one == by(5));
    }
}

#[test]
fn a_written_picture_reads_back_and_leaves_nothing_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("final.png");
    std::fs::write(&path, "an older file").unwrap();
    let image = picture(&heap(20, 3.0), &small(false));
    image.write_png(&path).unwrap();
    let mut reader = png::Decoder::new(BufReader::new(std::fs::File::open(&path).unwrap())).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    assert_eq!((info.width, info.height, info.color_type), (150, 100, png::ColorType::Rgb));
    assert_eq!(bytes, image.pixels());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn a_folder_that_is_not_there_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let error = picture(&Bodies::default(), &small(true)).write_png(&folder.path().join("no/final.png")).unwrap_err();
    assert_eq!(error.kind(), std::io::ErrorKind::NotFound);
}

/// The border stays free, and the picture is used from side to side or from top to bottom.
#[test]
fn the_camera_fits_all_bodies() {
    for planar in [true, false] {
        for extent in [0.1, 5.0, 30.0] {
            let image = picture(&heap(100, extent), &View { scale_bar: false, ..small(planar) });
            let (columns, rows) = drawn(&image);
            let span = |values: &[u32]| (*values.iter().min().unwrap(), *values.iter().max().unwrap());
            let ((left, right), (top, bottom)) = (span(&columns), span(&rows));
            assert!(left >= 5 && right <= 144 && top >= 3 && bottom <= 96, "{left} {right} {top} {bottom}");
            assert!(bottom - top >= 88 || right - left >= 134, "{left} {right} {top} {bottom}");
        }
    }
}

#[test]
fn without_bodies_the_picture_is_empty() {
    for background in [Background::White, Background::Dark] {
        let image = picture(&Bodies::default(), &View { background, ..small(false) });
        assert_eq!((image.width(), image.height(), image.pixels().len()), (150, 100, 45_000));
        let first = image.pixel(0, 0).unwrap();
        assert_eq!(white(first), background == Background::White);
        assert!(image.pixels().chunks_exact(3).all(|pixel| pixel == first));
        assert_eq!(image.pixel(150, 0), None);
    }
}

#[test]
fn a_picture_without_width_has_one_pixel() {
    let image = picture(&heap(3, 1.0), &View { width: 0, height: 0, ..View::default() });
    assert_eq!((image.width(), image.height(), image.pixels().len()), (1, 1, 3));
}

#[test]
fn bodies_that_are_not_finite_are_left_out() {
    let sound = heap(40, 3.0);
    let view = View { colour: Colour::Plain, ..small(false) };
    let expected = picture(&sound, &view);
    for bad in [f64::NAN, f64::INFINITY, -f64::INFINITY, 1e200] {
        let mut bodies = sound.clone();
        let mut add = |shape, position, orientation| {
            bodies.push(Placed { shape, position, orientation }, NO_GROUP);
        };
        add(SHAPES[0], DVec3::new(bad, 0.0, 0.0), DQuat::IDENTITY);
        add(Shape::Sphere { radius: bad }, DVec3::ZERO, DQuat::IDENTITY);
        add(Shape::Spherocylinder { diameter: 1.0, length: bad }, DVec3::ZERO, DQuat::IDENTITY);
        add(Shape::Torus { major_radius: bad, minor_radius: 0.5 }, DVec3::ZERO, DQuat::IDENTITY);
        add(Shape::Ellipsoid { radii: [1.0, bad, 1.0] }, DVec3::ZERO, DQuat::IDENTITY);
        if !bad.is_finite() {
            add(SHAPES[1], DVec3::ZERO, DQuat::from_xyzw(bad, 0.0, 0.0, 1.0));
        }
        assert!(expected == picture(&bodies, &view), "{bad}");
    }
}

#[test]
fn a_far_body_does_not_panic() {
    let mut bodies = heap(40, 3.0);
    for far in [1e6, 1e30, 1e99] {
        bodies.position[0] = DVec3::splat(far);
        for planar in [true, false] {
            let camera = Camera::fit(&bodies, &small(planar));
            assert!(camera.pixels_per_length() < 200.0 / far);
            picture(&bodies, &small(planar));
        }
    }
}

#[test]
fn a_kept_camera_shows_lengths_as_before() {
    let (few, many) = (heap(4, 1.0), heap(400, 8.0));
    let view = View { scale_bar: false, ..small(true) };
    let camera = Camera::fit(&many, &view);
    let covered = |image: &Image| drawn(image).0.len() as f64;
    let (own, kept) = (covered(&picture(&few, &view)), covered(&picture_by(&few, &view, &camera)));
    let expected = (camera.pixels_per_length() / Camera::fit(&few, &view).pixels_per_length()).powi(2);
    // Half-covered pixels count as covered; the fewer there are, the more they weigh.
    assert!(kept / own > 0.9 * expected && kept / own < 1.5 * expected, "{kept} {own} {expected}");
}

#[test]
fn every_colour_but_the_plain_one_tells_bodies_apart() {
    let mut bodies = Bodies::default();
    for k in 0..3 {
        let shape = Shape::Spherocylinder { diameter: 1.0, length: 1.5 + f64::from(k) };
        let orientation = DQuat::from_rotation_z(f64::from(k)) * DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2);
        let i = bodies.push(Placed { shape, position: DVec3::X * 5.0 * f64::from(k), orientation }, NO_GROUP);
        bodies.lineage[i].generation = k as u32;
        bodies.lineage[i].birth = f64::from(k);
    }
    // One more far left and one far right, so that the middle of the picture is the second body's centre.
    for x in [-10.0, 20.0] {
        let placed = Placed { shape: SHAPES[0], position: DVec3::X * x, orientation: DQuat::IDENTITY };
        bodies.push(placed, NO_GROUP);
    }
    for colour in [Colour::Orientation, Colour::Generation, Colour::Age, Colour::Size, Colour::Plain] {
        let view = View { width: 321, height: 121, colour, planar: true, scale_bar: false, ..View::default() };
        let (image, scale) = (picture(&bodies, &view), Camera::fit(&bodies, &view).pixels_per_length());
        let seen = [-5.0, 0.0, 5.0].map(|x| image.pixel((160.5 + x * scale) as u32, 60).unwrap());
        assert!(seen.iter().all(|p| !white(*p)), "{colour:?}");
        let apart = |a: [u8; 3], b: [u8; 3]| a.iter().zip(b).map(|(a, b)| a.abs_diff(b)).max().unwrap();
        let distances = [apart(seen[0], seen[1]), apart(seen[1], seen[2]), apart(seen[0], seen[2])];
        if colour == Colour::Plain {
            assert!(distances.iter().all(|d| *d < 20), "{seen:?}");
        } else {
            assert!(distances.iter().all(|d| *d > 25), "{colour:?}: {seen:?}");
        }
    }
}
