//! Closed chains of rods in heat never pass through themselves and each other: a trefoil stays one, and two linked
//! rings stay linked.
//!
//! The determinant of a knot, its Alexander polynomial at -1, is 3 for a trefoil and 1 for a ring without a knot (C.
//! Livingston, *Knot Theory*, 1993, chapter 3). Two rings that are linked once have the linking number 1 or -1, half
//! the signed crossings of a projection. `RELCP_KNOT_STEPS=N` takes more steps.

use crate::scenes::parse;
use glam::{DMat3, DQuat, DVec2, DVec3};
use relcp::bodies::Bodies;
use relcp::simulation::Simulation;
use serde_json::{Value, json};
use std::f64::consts::TAU;

const EDGE: f64 = 1.0;
const GAP: f64 = 0.1;
const DIAMETER: f64 = 0.3;

/// Steps in each `cargo test`.
const STEPS: u64 = 300;

/// The corners of a closed polygon along a curve of a full turn, whose edges are `EDGE` long on average.
fn polygon(count: usize, curve: impl Fn(f64) -> DVec3) -> Vec<DVec3> {
    let fine: Vec<DVec3> = (0..=20_000).map(|i| curve(TAU * f64::from(i) / 20_000.0)).collect();
    let mut way = vec![0.0];
    for pair in fine.windows(2) {
        way.push(way[way.len() - 1] + pair[0].distance(pair[1]));
    }
    let scale = EDGE * count as f64 / way[way.len() - 1];
    let corner = |i: usize| {
        let at = way.partition_point(|way| scale * way < EDGE * i as f64);
        scale * fine[at]
    };
    (0..count).map(corner).collect()
}

fn trefoil(count: usize) -> Vec<DVec3> {
    polygon(count, |t| {
        let (a, b) = (t.sin() + 2.0 * (2.0 * t).sin(), t.cos() - 2.0 * (2.0 * t).cos());
        DVec3::new(a, b, -(3.0 * t).sin())
    })
}

fn circle(count: usize, u: DVec3, v: DVec3) -> Vec<DVec3> {
    polygon(count, |t| t.cos() * u + t.sin() * v)
}

/// Rods on the edges of closed polygons, bonded from tip to tip.
fn rings(rings: &[Vec<DVec3>], seed: u64, steps: u64) -> Value {
    let (mut bodies, mut bonds) = (Vec::new(), Vec::new());
    for ring in rings {
        let (first, count) = (bodies.len(), ring.len());
        for (i, corner) in ring.iter().enumerate() {
            let next = ring[(i + 1) % count];
            let length = corner.distance(next) - GAP;
            let half = 0.5 * length;
            bodies.push(json!({"shape": {"spherocylinder": {"diameter": DIAMETER, "length": length}},
                "position": (0.5 * (*corner + next)).to_array(), "axis": (next - *corner).to_array()}));
            let other = 0.5 * (next.distance(ring[(i + 2) % count]) - GAP);
            bonds.push(json!({"bodies": [first + i, first + (i + 1) % count], "at": [[0, 0, half], [0, 0, -other]],
                "stiffness": 500, "length": GAP, "implicit": true}));
        }
    }
    let dt = 0.01;
    json!({"name": "knot", "seed": seed, "time": {"dt": dt, "end": dt * steps as f64},
        "dynamics": {"overdamped": {"drag": 1.0}}, "thermal": {"temperature": 0.1}, "bodies": bodies, "bonds": bonds})
}

/// The closed polygon through the tips of some rods.
fn tips(bodies: &Bodies, rods: std::ops::Range<usize>) -> Vec<DVec3> {
    let tips = |i: usize| {
        let half = 0.5 * bodies.shape[i].major_axis() * (bodies.orientation[i] * DVec3::Z);
        [bodies.position[i] - half, bodies.position[i] + half]
    };
    rods.flat_map(tips).collect()
}

/// Projected so that no two edges are parallel and no corner is on an edge, but for a polygon made for that.
fn projected(polygon: &[DVec3]) -> Vec<DVec3> {
    let view = DMat3::from_quat(DQuat::from_euler(glam::EulerRot::XYZ, 0.7312, 0.4217, 0.1193));
    polygon.iter().map(|corner| view * *corner).collect()
}

/// Where edge `i` of one polygon and edge `j` of another cross in projection: the parts along both, whether the first
/// one is over, and the sign.
fn crossing(a: &[DVec3], i: usize, b: &[DVec3], j: usize) -> Option<(f64, f64, bool, f64)> {
    let [p, q] = [a[i], a[(i + 1) % a.len()]];
    let [r, s] = [b[j], b[(j + 1) % b.len()]];
    let (u, v): (DVec2, DVec2) = ((q - p).truncate(), (s - r).truncate());
    let (across, from) = (u.perp_dot(v), (r - p).truncate());
    let (along_a, along_b) = (from.perp_dot(v) / across, from.perp_dot(u) / across);
    let inside = |part: f64| (0.0..1.0).contains(&part);
    let height = |from: DVec3, to: DVec3, part: f64| from.z + part * (to.z - from.z);
    let over = height(p, q, along_a) > height(r, s, along_b);
    (inside(along_a) && inside(along_b)).then_some((along_a, along_b, over, across.signum()))
}

fn linking_number(a: &[DVec3], b: &[DVec3]) -> f64 {
    let (a, b) = (projected(a), projected(b));
    let pairs = (0..a.len()).flat_map(|i| (0..b.len()).map(move |j| (i, j)));
    let crossings = pairs.filter_map(|(i, j)| crossing(&a, i, &b, j));
    crossings.filter(|(.., over, _)| *over).map(|(.., sign)| sign).sum()
}

/// The determinant of a knot, by the colourings of its arcs.
fn determinant(polygon: &[DVec3]) -> f64 {
    let polygon = projected(polygon);
    let count = polygon.len();
    // Where the knot goes under, and where it is over there.
    let mut unders = Vec::new();
    for i in 0..count {
        for j in i + 2..count {
            if i == 0 && j == count - 1 {
                continue;
            }
            if let Some((at_i, at_j, over, _)) = crossing(&polygon, i, &polygon, j) {
                let (i, j) = (i as f64 + at_i, j as f64 + at_j);
                unders.push(if over { (j, i) } else { (i, j) });
            }
        }
    }
    unders.sort_by(|a: &(f64, f64), b| a.0.total_cmp(&b.0));
    let arcs = unders.len();
    let arc_of = |at: f64| unders.partition_point(|(under, _)| *under < at) % arcs.max(1);
    let mut matrix = vec![vec![0.0; arcs]; arcs];
    for (k, (_, over)) in unders.iter().enumerate() {
        matrix[k][arc_of(*over)] += 2.0;
        matrix[k][k] -= 1.0;
        matrix[k][(k + 1) % arcs] -= 1.0;
    }
    minor(&matrix).abs()
}

/// The determinant without the last row and column, by elimination.
fn minor(matrix: &[Vec<f64>]) -> f64 {
    let size = matrix.len().saturating_sub(1);
    let mut rows: Vec<Vec<f64>> = matrix[..size].iter().map(|row| row[..size].to_vec()).collect();
    let mut product = 1.0;
    for k in 0..size {
        let pivot = (k..size).max_by(|a, b| rows[*a][k].abs().total_cmp(&rows[*b][k].abs())).unwrap();
        if rows[pivot][k].abs() < 1e-9 {
            return 0.0;
        }
        if pivot != k {
            rows.swap(pivot, k);
            product = -product;
        }
        product *= rows[k][k];
        let (above, below) = rows.split_at_mut(k + 1);
        let above = &above[k];
        for row in below {
            let part = row[k] / above[k];
            row.iter_mut().zip(above).for_each(|(x, y)| *x -= part * y);
        }
    }
    product
}

#[test]
fn the_invariants_tell_knots_and_links() {
    assert!((determinant(&trefoil(36)) - 3.0).abs() < 1e-9);
    assert!((determinant(&circle(12, DVec3::X, DVec3::Y)) - 1.0).abs() < 1e-9);
    // A figure of eight has 5.
    let eight = polygon(60, |t| {
        let long = 2.0 + (2.0 * t).cos();
        DVec3::new(long * (3.0 * t).cos(), long * (3.0 * t).sin(), (4.0 * t).sin())
    });
    assert!((determinant(&eight) - 5.0).abs() < 1e-9, "{}", determinant(&eight));
    let [one, other] = linked(12);
    assert_eq!(linking_number(&one, &other).abs(), 1.0);
    let far: Vec<DVec3> = other.iter().map(|x| *x + 9.0 * DVec3::X).collect();
    assert_eq!(linking_number(&one, &far), 0.0);
}

/// Two rings, each through the middle of the other.
fn linked(count: usize) -> [Vec<DVec3>; 2] {
    let (one, other) = (circle(count, DVec3::X, DVec3::Y), circle(count, DVec3::X, DVec3::Z));
    let radius = EDGE * count as f64 / TAU;
    [one, other.into_iter().map(|corner| corner + radius * DVec3::X).collect()]
}

/// Takes all steps, and says how many recursions and pieces they took.
fn run(of: &Value, mut see: impl FnMut(&Bodies)) {
    let mut simulation = Simulation::new(parse(of)).unwrap();
    let (mut recursions, mut most, mut in_pieces) = (0_u64, 0, 0_u64);
    while !simulation.done() {
        let report = simulation.step().unwrap_or_else(|fault| panic!("step {}: {fault}", simulation.steps()));
        assert!(report.passed.is_none());
        recursions += u64::from(report.recursions);
        most = most.max(report.recursions);
        in_pieces += u64::from(report.pieces > 1);
        if simulation.steps().is_multiple_of(1000) || simulation.done() {
            see(&simulation.state().unwrap().bodies);
        }
        if simulation.steps().is_multiple_of(10_000) {
            println!("{} steps, {recursions} recursions, at most {most}, {in_pieces} in pieces", simulation.steps());
        }
    }
    println!("{} steps, {recursions} recursions, at most {most}, {in_pieces} in pieces", simulation.steps());
}

fn steps() -> u64 {
    std::env::var("RELCP_KNOT_STEPS").map_or(STEPS, |steps| steps.parse().unwrap())
}

#[test]
fn a_trefoil_in_heat_stays_one() {
    let start = trefoil(36);
    run(&rings(std::slice::from_ref(&start), 1, steps()), |bodies| {
        let knot = determinant(&tips(bodies, 0..36));
        assert!((knot - 3.0).abs() < 1e-6, "{knot}");
    });
}

#[test]
fn two_linked_rings_in_heat_stay_linked() {
    let start = linked(12);
    let number = linking_number(&start[0], &start[1]);
    run(&rings(&start, 1, steps()), |bodies| {
        assert_eq!(linking_number(&tips(bodies, 0..12), &tips(bodies, 12..24)), number);
    });
}
