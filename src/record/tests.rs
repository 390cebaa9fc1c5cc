//! State files round trip bit for bit, and are refused if anything in them is wrong; a resumed run writes the files of
//! an uninterrupted run.

use super::npz::{Block, Data, write};
use super::*;
use crate::bodies::{Bodies, Columns, HeldBond, Lineage, NO_GROUP};
use crate::fields::Concentration;
use crate::periodic::Periods;
use crate::shape::Shape;
use crate::step::{State, Unrounded, UnroundedBody};
use crate::warm::Warm;
use glam::{DQuat, DVec3};

const HASH: &str = "0123456789abcdef";

/// Two bonds, with forces.
fn bonds() -> Vec<HeldBond> {
    let bond = |number: u32, bodies: [u32; 2]| HeldBond {
        number,
        bodies,
        at: [DVec3::new(0.1, -0.0, 1e-300), DVec3::new(0.0, 0.3, 0.7)],
        length: 0.1 + 0.2,
        force: DVec3::new(-1.0 / 3.0, 0.0, 2.0),
        torque: DVec3::new(0.7, -0.1, 0.0),
        bending_energy: 1.0 / 7.0,
        contact: number > 1,
    };
    vec![bond(1, [0, 3]), bond(5, [2, 1])]
}

/// One body of every shape, with numbers that a decimal or narrower form would lose.
fn state() -> State {
    let awkward = [0.1 + 0.2, -0.0, f64::MIN_POSITIVE / 3.0, 0.9e60, 1.0 / 3.0, -1e-300, std::f64::consts::PI];
    let at = |i: usize| awkward[i % awkward.len()];
    let vector = |i: usize| DVec3::new(at(i), at(i + 1), at(i + 2));
    let shape = vec![
        Shape::Sphere { radius: 0.1 },
        Shape::Spherocylinder { diameter: 1.0 / 3.0, length: 2.7 },
        Shape::Ellipsoid { radii: [1.0, 1.0 + f64::EPSILON, 2.0] },
        Shape::Torus { major_radius: 3.0, minor_radius: 0.7 },
    ];
    let mut columns = Columns::default();
    columns.growth_mut(1, 4).rate = Some(0.1 + 0.2);
    columns.growth_mut(2, 4).division_length = Some(f64::INFINITY);
    columns.named_mut("age", 4).copy_from_slice(&[0.5, -0.25, 1e300, 0.1]);
    columns.named_mut("a name", 4);
    let bodies = Bodies {
        columns,
        broken_bonds: vec![0, 3, 4],
        bonds: bonds(),
        walls: vec![crate::bodies::WallState { shift: 0.3, velocity: -1e-300 }, Default::default()],
        periods: Periods::NONE,
        planar: false,
        position: (0..4).map(vector).collect(),
        orientation: (0..4).map(|i| DQuat::from_xyzw(at(i), at(i + 1), at(i + 2), at(i + 3)).normalize()).collect(),
        velocity: (0..4).map(|i| vector(i + 1)).collect(),
        angular_velocity: (0..4).map(|i| vector(i + 2)).collect(),
        group: vec![0, NO_GROUP, 1, 2],
        lineage: (0..4)
            .map(|i| Lineage {
                id: u64::MAX - 9 + i,
                parent: i.checked_sub(1),
                birth: at(i as usize),
                generation: i as u32,
                birth_length: (i == 2).then_some(0.75),
            })
            .collect(),
        shape,
    };
    let warm = vec![
        Warm { pair: [0, 2], feature: 7, gamma: 0.1 + 0.7, normal: vector(3), tangent: DVec3::ZERO },
        Warm { pair: [1, 3], feature: u32::MAX, gamma: 0.0, normal: DVec3::NEG_X, tangent: DVec3::ZERO },
        Warm { pair: [2, crate::walls::number_of(5)], feature: 1, gamma: 0.3, normal: DVec3::Y, tangent: DVec3::ZERO },
    ];
    let cells = [[i32::MIN, -1, 0], [1, 2, 3], [0; 3], [i32::MAX, 5, -6]];
    let of_device = |(i, cell)| UnroundedBody::from_numbers(cell, std::array::from_fn(|k| at(i + k)));
    let unrounded = Unrounded { kind: [4.0, 1.0 / 1024.0, 0.0], bodies: (0..).zip(cells).map(of_device).collect() };
    let grid = crate::fields::Grid { cells: [2, 3, 1], spacing: 0.25, center: [0.1, -1.0, 0.0] };
    let concentration = |name: &str| Concentration { name: name.into(), grid, values: (0..6).map(at).collect() };
    let fields = vec![concentration("food"), concentration("waste")];
    let (removed, unrounded) = (vec![3, 0], Some(unrounded));
    State { step: 41, next_id: 99, bodies, warm, removed, changed: true, fields, unrounded }
}

#[test]
fn the_numbers_of_a_device_keep_their_order_in_files() {
    let numbers: [f64; UnroundedBody::NUMBERS] = std::array::from_fn(|k| k as f64);
    let body = UnroundedBody::from_numbers([-1, 0, 7], numbers);
    let expected = UnroundedBody {
        cell: [-1, 0, 7],
        remainder: [0.0, 1.0, 2.0],
        orientation: [[3.0, 4.0, 5.0, 6.0], [7.0, 8.0, 9.0, 10.0]],
        velocity: [11.0, 12.0, 13.0],
        turning: [14.0, 15.0, 16.0],
        length: [17.0, 18.0],
        prescribed: 19.0,
    };
    assert_eq!(body, expected);
    assert_eq!(body.to_numbers(), numbers);
}

/// Bits, since `-0.0 == 0.0`.
fn bits(state: &State) -> Vec<u64> {
    let b = &state.bodies;
    let vectors =
        b.position.iter().chain(&b.velocity).chain(&b.angular_velocity).chain(state.warm.iter().map(|w| &w.normal));
    let mut bits: Vec<u64> = vectors.flat_map(|v| v.to_array()).map(f64::to_bits).collect();
    bits.extend(b.orientation.iter().flat_map(|q| q.to_array()).map(f64::to_bits));
    bits.extend(b.lineage.iter().map(|l| l.birth.to_bits()));
    bits.extend(state.warm.iter().map(|w| w.gamma.to_bits()));
    bits
}

#[test]
fn a_checkpoint_round_trips_bit_for_bit() {
    let state = state();
    let totals = Totals { steps: 41, max_overlap: 0.1 + 0.2, worst_residual: f64::INFINITY, ..Totals::default() };
    let bytes = encode(&state, HASH, 0.1 + 0.2, Some(&totals)).unwrap();
    let (header, read) = decode(&bytes).unwrap();
    assert_eq!(read, state);
    assert_eq!(bits(&read), bits(&state));
    assert_eq!(header.totals.unwrap(), totals);
    assert_eq!((header.scene.as_str(), header.time.to_bits()), (HASH, (0.1_f64 + 0.2).to_bits()));
    assert_eq!(encode(&state, HASH, 0.1 + 0.2, Some(&totals)).unwrap(), bytes);
}

#[test]
fn a_state_leaves_the_near_pairs_out_and_may_be_empty() {
    let (header, mut read) = decode(&encode(&state(), HASH, 1.0, None).unwrap()).unwrap();
    for (read, known) in read.bodies.bonds.iter_mut().zip(bonds()) {
        assert!(read.force.is_nan() && read.torque.is_nan());
        (read.force, read.torque) = (known.force, known.torque);
    }
    assert_eq!((header.warm, header.device, header.totals), (None, None, None));
    assert_eq!(read.unrounded, None);
    assert_eq!((&read.bodies, read.warm.len()), (&state().bodies, 0));
    let empty = encode(&State::default(), HASH, 0.0, Some(&Totals::default())).unwrap();
    assert_eq!(decode(&empty).unwrap().1, State::default());
}

#[test]
fn every_damaged_byte_is_found() {
    let bytes = encode(&state(), HASH, 1.0, Some(&Totals::default())).unwrap();
    for at in 0..bytes.len() {
        for flip in [0x01, 0x20, 0xff] {
            let mut damaged = bytes.clone();
            damaged[at] ^= flip;
            assert!(decode(&damaged).is_err(), "byte {at} of {}", bytes.len());
        }
    }
}

#[test]
fn damage_in_an_array_is_told_by_its_name() {
    let mut bytes = encode(&state(), HASH, 1.0, None).unwrap();
    let value = 2.7_f64.to_le_bytes();
    let at = bytes.windows(8).position(|window| window == value).unwrap();
    bytes[at] ^= 1;
    match decode(&bytes).unwrap_err() {
        StateError::Damaged { place, .. } => assert_eq!(place, "size.npy"),
        other => panic!("{other}"),
    }
}

#[test]
fn every_cut_is_found() {
    let bytes = encode(&state(), HASH, 1.0, Some(&Totals::default())).unwrap();
    for length in 0..bytes.len() {
        assert!(decode(&bytes[..length]).is_err(), "cut at {length}");
    }
    assert_eq!(decode(&bytes[..bytes.len() - 1]).unwrap_err(), StateError::Truncated);
    assert_eq!(decode(&bytes[..bytes.len() / 2]).unwrap_err(), StateError::Truncated);
    assert_eq!(decode(b"a text").unwrap_err(), StateError::NotAState);
}

/// A forged, sealed file with this header and arrays.
fn forged(change: impl FnOnce(&mut serde_json::Value), arrays: &[Block]) -> StateError {
    let (header, _) = decode(&encode(&state(), HASH, 1.0, None).unwrap()).unwrap();
    let mut header = serde_json::to_value(header).unwrap();
    change(&mut header);
    decode(&write(&serde_json::to_vec(&header).unwrap(), arrays).unwrap()).unwrap_err()
}

#[test]
fn a_newer_version_is_told() {
    let newer = forged(|header| header["version"] = (VERSION + 1).into(), &[]);
    assert_eq!(newer, StateError::Newer { found: VERSION + 1, known: VERSION });
    let other = forged(|header| header["format"] = "else".into(), &[]);
    assert_eq!(other, StateError::NotAState);
}

#[test]
fn counts_that_cannot_be_are_refused_before_anything_is_allocated() {
    for rows in [1_000_000_000_000_000_u64, u64::MAX, 5] {
        let refused = forged(|header| header["bodies"] = rows.into(), &blocks::body_blocks(&state().bodies));
        assert!(matches!(refused, StateError::Damaged { .. }), "{refused}");
    }
}

#[test]
fn arrays_of_another_type_shape_or_meaning_are_refused() {
    let good = blocks::body_blocks(&state().bodies);
    let wrong = [
        (Block { name: "shape", columns: 1, data: Data::U32(vec![0, 1, 2, 9]) }, "shape"),
        (Block { name: "shape", columns: 2, data: Data::U32(vec![0, 1, 2, 3]) }, "shape"),
        (Block { name: "size", columns: 3, data: Data::F64(vec![-1.0; 12]) }, "shape"),
        (Block { name: "position", columns: 3, data: Data::U64(vec![0; 12]) }, "position"),
        (Block { name: "id", columns: 1, data: Data::U64(vec![1; 3]) }, "id"),
    ];
    for (block, expected) in wrong {
        let mut arrays = good.clone();
        let place = arrays.iter().position(|b| b.name == block.name).unwrap();
        arrays[place] = block;
        match forged(|_| {}, &arrays) {
            StateError::Damaged { place, .. } => assert_eq!(place, expected),
            other => panic!("{other}"),
        }
    }
    let missing: Vec<Block> = good.into_iter().filter(|block| block.name != "group").collect();
    assert!(matches!(forged(|_| {}, &missing), StateError::Damaged { place, .. } if place == "group.npy"));
}

#[test]
fn numbers_that_no_body_can_have_are_refused_with_their_row() {
    type Case = (&'static str, fn(&mut State));
    let cases: [Case; 6] = [
        ("position", |s| s.bodies.position[2].y = f64::NAN),
        ("position", |s| s.bodies.position[2].x = f64::MAX),
        ("velocity", |s| s.bodies.velocity[2].z = f64::INFINITY),
        ("orientation", |s| s.bodies.orientation[2] = DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0)),
        ("orientation", |s| s.bodies.orientation[2].w = f64::NAN),
        ("size", |s| s.bodies.shape[2] = Shape::Sphere { radius: 1e200 }),
    ];
    for (place, change) in cases {
        let mut state = state();
        change(&mut state);
        let refused = decode(&encode(&state, HASH, 0.0, None).unwrap()).unwrap_err();
        assert_eq!(refused, StateError::row(place, 2));
    }
}

#[test]
fn the_hash_of_a_state_sees_every_field() {
    let base = state_hash(&state());
    let changes: [fn(&mut State); 7] = [
        |s| s.step += 1,
        |s| s.next_id += 1,
        |s| s.bodies.position[1].y = -s.bodies.position[1].y,
        |s| s.bodies.orientation[3].w += 1e-9,
        |s| s.bodies.group[0] = NO_GROUP,
        |s| s.bodies.lineage[2].parent = None,
        |s| s.bodies.shape[0] = Shape::Sphere { radius: 0.1 + f64::EPSILON },
    ];
    for change in changes {
        let mut state = state();
        change(&mut state);
        assert_ne!(state_hash(&state), base);
    }
}
