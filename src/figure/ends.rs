//! The names of curves at their ends, beside the curves and not on them.

use super::drawing::{POINT, TEXT};
use crate::page::width_of;
use plotters_backend::BackendCoord;

/// Room between a curve's end and its name.
pub const GAP: i32 = 4 * POINT as i32;
/// The height that a name takes.
const HEIGHT: i32 = TEXT as i32;
/// A name beside an end may be so many halves of its height above or below it.
const SHIFTS: i32 = 12;
/// Points of curves are looked at in steps of this length.
const STEP: f64 = 2.0 * POINT as f64;
/// Where a name may stand beside its curve, as parts of the curve from its start; at its end first.
const PARTS: [f64; 6] = [1.0, 0.9, 0.8, 0.65, 0.5, 0.35];
/// What a name costs on another name, outside of the place for names, and away from the end. A point of a curve that
/// it hides costs one.
const ON_NAME: f64 = 1e4;
const OUTSIDE: f64 = 1e6;
const AWAY: f64 = 0.02;

/// A rectangle: left, top, right, bottom.
type Place = [i32; 4];

/// How wide a name is.
pub fn width(name: &str) -> u32 {
    width_of(name, TEXT as f32).ceil() as u32
}

/// Where the name of each curve stands: the left end of its middle line. `curves` are their points on the page in
/// order; names stay inside of `room`. A curve without a name or without points gets none.
pub fn places(names: &[&str], curves: &[Vec<BackendCoord>], room: Place) -> Vec<Option<BackendCoord>> {
    let seen: Vec<BackendCoord> = curves.iter().flat_map(|curve| dense(curve)).collect();
    let mut taken: Vec<Place> = Vec::new();
    let place = |(name, curve): (&&str, &Vec<BackendCoord>)| {
        let wide = width(name) as i32;
        let best = candidates(curve, wide)
            .map(|(x, y, shift)| {
                let own = [x, y - HEIGHT / 2, x + wide, y + HEIGHT / 2];
                let names = taken.iter().filter(|other| overlap(own, **other)).count() as f64;
                let points = seen.iter().filter(|(px, py)| overlap(own, [*px, *py, *px, *py])).count() as f64;
                let out = own[0] < room[0] || own[1] < room[1] || own[2] > room[2] || own[3] > room[3];
                let cost = points + ON_NAME * names + if out { OUTSIDE } else { 0.0 } + AWAY * shift;
                (cost, own)
            })
            .reduce(|a, b| if b.0 < a.0 { b } else { a });
        let own = best.filter(|_| !name.is_empty())?.1;
        taken.push(own);
        Some((own[0], own[1] + HEIGHT / 2))
    };
    names.iter().zip(curves).map(place).collect()
}

/// Places for a name, with how far each is from the best one.
fn candidates(curve: &[BackendCoord], wide: i32) -> impl Iterator<Item = (i32, i32, f64)> + '_ {
    let end = curve.last().copied();
    let beside = end
        .into_iter()
        .flat_map(|(x, y)| (-SHIFTS..=SHIFTS).map(move |k| (x + GAP, y + k * HEIGHT / 2, f64::from(k.abs()))));
    let along = PARTS.iter().enumerate().flat_map(move |(n, part)| {
        let at = (curve.len().saturating_sub(1) as f64 * part).round() as usize;
        let far = f64::from(SHIFTS) + n as f64;
        curve
            .get(at)
            .into_iter()
            .flat_map(move |(x, y)| [-1, 1, -2, 2].map(|k| (x - wide / 2, y + k * HEIGHT, far + f64::from(k.abs()))))
    });
    beside.chain(along)
}

fn overlap(a: Place, b: Place) -> bool {
    a[0] < b[2].max(b[0] + 1) && b[0] < a[2] && a[1] < b[3].max(b[1] + 1) && b[1] < a[3]
}

/// The points of a curve, and more between them.
fn dense(curve: &[BackendCoord]) -> Vec<BackendCoord> {
    let between = |pair: &[BackendCoord]| {
        let ((x, y), (to_x, to_y)) = (pair[0], pair[1]);
        let (far_x, far_y) = (f64::from(to_x - x), f64::from(to_y - y));
        let steps = (far_x.hypot(far_y) / STEP).ceil().clamp(1.0, 1e4) as i32;
        let at = move |k: i32| {
            let part = f64::from(k) / f64::from(steps);
            (x + (far_x * part) as i32, y + (far_y * part) as i32)
        };
        (0..steps).map(at).collect::<Vec<_>>()
    };
    curve.windows(2).flat_map(between).chain(curve.last().copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROOM: Place = [0, 0, 2000, 1000];

    fn boxes(names: &[&str], curves: &[Vec<BackendCoord>]) -> Vec<Place> {
        let of = |(place, name): (Option<BackendCoord>, &&str)| {
            let (x, y) = place.unwrap();
            [x, y - HEIGHT / 2, x + width(name) as i32, y + HEIGHT / 2]
        };
        places(names, curves, ROOM).into_iter().zip(names).map(of).collect()
    }

    #[test]
    fn a_curve_alone_has_its_name_at_its_end() {
        let curve = vec![(100, 500), (900, 300)];
        assert_eq!(places(&["one"], std::slice::from_ref(&curve), ROOM), [Some((900 + GAP, 300))]);
        assert_eq!(places(&["", "two"], &[curve, vec![]], ROOM), [None, None]);
    }

    #[test]
    fn names_of_curves_that_end_together_are_apart_and_not_on_curves() {
        let curves: Vec<Vec<BackendCoord>> = (0..5).map(|k| vec![(100, 100 * k), (1000, 500 + k)]).collect();
        let found = boxes(&["first", "second", "third", "fourth", "fifth"], &curves);
        for (k, a) in found.iter().enumerate() {
            assert!(found[..k].iter().all(|b| !overlap(*a, *b)) && a[0] == 1000 + GAP, "{found:?}");
        }
    }

    #[test]
    fn a_curve_that_ends_before_another_has_its_name_beside_both() {
        // The second one goes through where the first one's name would stand.
        let curves = [vec![(100, 500), (500, 500)], vec![(100, 600), (500, 510), (1500, 490)]];
        let found = boxes(&["early", "late"], &curves);
        let hidden = |place: Place| {
            curves.iter().flat_map(|curve| dense(curve)).filter(|(x, y)| overlap(place, [*x, *y, *x, *y])).count()
        };
        assert_eq!(found.iter().map(|place| hidden(*place)).sum::<usize>(), 0, "{found:?}");
    }
}
