//! The drag of a viscous fluid on rods and rings against a computation of the flow about them: rings of point forces
//! inside the body (the method of fundamental solutions), with the velocities on its surface by least squares. The same
//! gives spheroids their closed forms.

use glam::DVec3;
use relcp::scene::Drag;
use relcp::shape::Shape;
use std::f64::consts::{PI, TAU};

/// A place on the meridian: its distance from the axis, and along it.
type Place = [f64; 2];

/// The flow that one unknown makes at a place. The unknowns of a ring are the amplitudes of forces outwards, about the
/// axis and along it: even about the axis for `mode` 0, with the cosine, the sine and the cosine of the azimuth for 1.
fn flow(mode: u32, [r, z]: Place, [rho, height]: Place, component: usize, points: usize) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for k in 0..points {
        let azimuth = (k as f64 + 0.5) * TAU / points as f64;
        let (sin, cos) = azimuth.sin_cos();
        let across = if mode == 0 { [1.0; 3] } else { [cos, sin, cos] };
        let direction = [DVec3::new(cos, sin, 0.0), DVec3::new(-sin, cos, 0.0), DVec3::Z][component];
        let force = across[component] * direction;
        let source = DVec3::new(rho * cos, rho * sin, height);
        let at = |place: DVec3| {
            let apart = place - source;
            let distance = apart.length();
            (force / distance + apart * (apart.dot(force) / distance.powi(3))) / (8.0 * PI * points as f64)
        };
        // Outwards and along where the cosine is 1, about the axis where the sine is 1 (in mode 0 anywhere).
        let there = at(DVec3::new(r, 0.0, z));
        let aside = if mode == 0 { there.y } else { -at(DVec3::new(0.0, r, z)).x };
        for (sum, part) in sum.iter_mut().zip([there.x, aside, there.z]) {
            *sum += part;
        }
    }
    sum
}

/// The least squares solutions of `a x = b` for several right-hand sides, by Householder's reflections; rows of both.
fn least_squares(mut a: Vec<Vec<f64>>, mut b: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let (rows, columns, sides) = (a.len(), a[0].len(), b[0].len());
    for k in 0..columns {
        let norm = (k..rows).map(|i| a[i][k] * a[i][k]).sum::<f64>().sqrt().copysign(a[k][k]);
        let mut v: Vec<f64> = (k..rows).map(|i| a[i][k]).collect();
        v[0] += norm;
        let square: f64 = v.iter().map(|x| x * x).sum();
        let reflect = |matrix: &mut [Vec<f64>], from: usize, to: usize| {
            for j in from..to {
                let dot: f64 = v.iter().zip(&matrix[k..]).map(|(x, row)| x * row[j]).sum();
                for (x, row) in v.iter().zip(&mut matrix[k..]) {
                    row[j] -= 2.0 * dot / square * x;
                }
            }
        };
        reflect(&mut a, k, columns);
        reflect(&mut b, 0, sides);
    }
    let mut x = vec![vec![0.0; sides]; columns];
    for k in (0..columns).rev() {
        for side in 0..sides {
            let known: f64 = (k + 1..columns).map(|j| a[k][j] * x[j][side]).sum();
            x[k][side] = (b[k][side] - known) / a[k][k];
        }
    }
    x
}

/// Resistances at a viscosity of 1 along and across the axis, to turning across and about it, and Bretherton's constant
/// about y.
#[derive(Debug)]
struct Found {
    linear: [f64; 2],
    turning: [f64; 2],
    bretherton: f64,
}

fn solve(surface: &[Place], sources: &[Place], points: usize) -> Found {
    let solved = |mode: u32, sides: &dyn Fn(Place) -> Vec<[f64; 3]>| {
        let row = |place: &Place, part: usize| -> Vec<f64> {
            sources
                .iter()
                .flat_map(|source| (0..3).map(move |c| flow(mode, *place, *source, c, points)[part]))
                .collect()
        };
        let parts = || surface.iter().flat_map(|place| (0..3).map(move |part| (place, part)));
        let a: Vec<Vec<f64>> = parts().map(|(place, part)| row(place, part)).collect();
        let b: Vec<Vec<f64>> = parts().map(|(place, part)| sides(*place).iter().map(|u| u[part]).collect()).collect();
        least_squares(a, b)
    };
    let along = solved(0, &|[r, _]| vec![[0.0, 0.0, 1.0], [0.0, r, 0.0]]);
    // Motion along x; turning about y; the strain z x + x z.
    let across = solved(1, &|[r, z]| vec![[1.0, -1.0, 0.0], [z, -z, -r], [z, -z, r]]);
    let total = |x: &[Vec<f64>], of: &dyn Fn(Place, [f64; 3]) -> f64, side: usize| -> f64 {
        let ring = |(k, place): (usize, &Place)| of(*place, [0, 1, 2].map(|c| x[3 * k + c][side]));
        sources.iter().enumerate().map(ring).sum()
    };
    let push = |_: Place, [out, about, _]: [f64; 3]| 0.5 * (out - about);
    let torque = |[rho, z]: Place, [out, about, up]: [f64; 3]| 0.5 * (z * (out - about) - rho * up);
    let turning = total(&across, &torque, 1);
    Found {
        linear: [total(&along, &|_, f| f[2], 0), total(&across, &push, 0)],
        turning: [turning, total(&along, &|[rho, _], f| rho * f[1], 1)],
        bretherton: total(&across, &torque, 2) / turning,
    }
}

/// A rod of radius 1, its surface at the distance `radius` from its segment.
fn rod(aspect: f64, radius: f64, places: usize) -> Vec<Place> {
    let (half, cap) = (aspect - 1.0, 0.5 * PI * radius);
    let length = 2.0 * (half + cap);
    let place = |k: usize| {
        let way = (k as f64 + 0.5) / places as f64 * length;
        if way < cap {
            let angle = way / radius;
            [radius * angle.sin(), half + radius * angle.cos()]
        } else if way <= cap + 2.0 * half {
            [radius, half - (way - cap)]
        } else {
            let angle = (way - cap - 2.0 * half) / radius;
            [radius * angle.cos(), -half - radius * angle.sin()]
        }
    };
    (0..places).map(place).collect()
}

fn tube(major: f64, radius: f64, places: usize) -> Vec<Place> {
    let place = |k: usize| {
        let (sin, cos) = (TAU * (k as f64 + 0.5) / places as f64).sin_cos();
        [major + radius * cos, radius * sin]
    };
    (0..places).map(place).collect()
}

fn compare(name: &str, shape: Shape, found: &Found, bound: f64) {
    let drag = Drag::Viscosity(1.0);
    let ours = drag.resistance(&shape);
    let (linear, turning) = (ours.linear.axes(), ours.turning.axes());
    let constant = drag.bretherton(&shape).unwrap().y;
    // A body turns over at speeds with the part 1 - B^2 of the fluid's.
    let slow = |b: f64| 1.0 - b * b;
    let ratios = [
        ("along", linear.z / found.linear[0]),
        ("across", linear.x / found.linear[1]),
        ("turning across", turning.x / found.turning[0]),
        ("turning about", turning.z / found.turning[1]),
        ("1 - B^2", slow(constant) / slow(found.bretherton)),
    ];
    for (what, ratio) in ratios {
        println!("{name}, {what}: {:+.1e}", ratio - 1.0);
        assert!((ratio - 1.0).abs() < bound, "{name}, {what}: {ratio}");
    }
    assert!(constant * found.bretherton >= 0.0, "{name}: {constant} {}", found.bretherton);
}

/// The computation itself, on what has closed forms.
#[test]
fn the_flow_about_a_spheroid_gives_its_closed_forms() {
    for aspect in [1.5, 2.2] {
        let focus = f64::sqrt(aspect * aspect - 1.0);
        let confocal = |squeezed: f64, places: usize| -> Vec<Place> {
            let mu = squeezed * f64::atanh(1.0 / aspect);
            let angle = |k: usize| PI * (k as f64 + 0.5) / places as f64;
            (0..places).map(|k| [focus * mu.sinh() * angle(k).sin(), focus * mu.cosh() * angle(k).cos()]).collect()
        };
        let found = solve(&confocal(1.0, 48), &confocal(0.5, 20), 48);
        compare(&format!("spheroid of {aspect}"), Shape::Ellipsoid { radii: [1.0, 1.0, aspect] }, &found, 1e-5);
    }
}

#[test]
fn rods_have_the_drag_of_the_flow_about_them() {
    for (aspect, places) in [(1.2, 20), (2.0, 26), (3.5, 36), (8.0, 68)] {
        let found = solve(&rod(aspect, 1.0, 2 * places), &rod(aspect, 0.6, places), 48);
        let shape = Shape::Spherocylinder { diameter: 2.0, length: 2.0 * aspect };
        compare(&format!("rod of {aspect}"), shape, &found, BOUND);
    }
}

#[test]
fn rings_have_the_drag_of_the_flow_about_them() {
    for minor in [0.8, 0.4, 0.1, 0.01] {
        let points = 4 * ((6.0 / minor) as usize + 16);
        let found = solve(&tube(1.0, minor, 32), &tube(1.0, 0.5 * minor, 16), points);
        let shape = Shape::Torus { major_radius: 1.0, minor_radius: minor };
        compare(&format!("ring of {minor}"), shape, &found, BOUND);
    }
}

/// What the fits are off by at most, and half as much for the computation.
const BOUND: f64 = 1.2e-3;
