//! Bonds and the chains that they make: tensions, energies, lengths, and how stiff chains are against bends.
//!
//! A chain is bodies that bonds join one after the other, each to at most two others; it is open, or a ring. Its
//! contour goes from end to end of its bonds and, inside of each body, from one bond to the next. The first and the
//! last body of an open chain go on to the other side of their centre. Its directions `u` are those of the contour
//! inside bodies, or of bonds where these are at the centres of bodies.
//!
//! The persistence length is `-b / ln <u . u'>` of neighbours, with the mean contour `b` from one to the next: that of
//! the worm-like chain, whose directions `s` apart have the mean cosine `exp(-s / p)` (O. Kratky, G. Porod, Rec. Trav.
//! Chim. 68, 1106 (1949)).

use super::clusters::components;
use super::{About, Cell, Column, Found, LeftOut, Marks, Measure, Profile, View, cell, count};
use crate::bodies::{Bodies, HeldBond};
use glam::DVec3;

const COLUMNS: [Column; 11] = [
    Column { name: "bonds", what: "bonds and joints that hold" },
    Column { name: "bonds_broken", what: "bonds of the scene that have broken" },
    Column { name: "bond_tension_mean", what: "mean tension of bonds; negative where they push" },
    Column { name: "bond_tension_most", what: "the largest tension" },
    Column { name: "bond_torque_most", what: "the largest torque of a bond or a joint" },
    Column { name: "bending_energy", what: "energy of all bends and turns that bonds resist" },
    Column { name: "bond_chains", what: "chains and rings of bonded bodies" },
    Column { name: "chain_bodies", what: "mean number of bodies of a chain" },
    Column { name: "contour_length", what: "mean contour length of a chain" },
    Column { name: "end_to_end", what: "root of the mean squared distance between both ends of open chains" },
    Column { name: "persistence_length", what: "the length over which chains keep their direction" },
];

const PROFILE: [Column; 4] = [
    Column { name: "links", what: "how many bodies along a chain two directions are apart" },
    Column { name: "contour", what: "mean contour length between them" },
    Column { name: "cosine", what: "mean cosine of the angle between them" },
    Column { name: "pairs", what: "pairs of directions" },
];

/// Bonds and their chains.
pub(super) struct OfBonds;

impl Measure for OfBonds {
    fn about(&self) -> &'static About {
        &About {
            name: "bonds",
            line: "bonds: tension, bending energy, and the lengths of chains",
            columns: &COLUMNS,
            profile: Some(Profile { columns: &PROFILE, drawn: 2, counts: None, marks: Marks::Curves }),
            plots: &[
                &["bond_tension_mean", "bond_tension_most"],
                &["bending_energy"],
                &["contour_length", "end_to_end", "persistence_length"],
            ],
        }
    }

    fn of(&self, view: &View<'_>) -> Result<Found, LeftOut> {
        let bodies = view.bodies();
        let bonds = &bodies.bonds;
        if bonds.is_empty() && bodies.broken_bonds.is_empty() {
            return Err("there are no bonds, or the state is of an earlier program".into());
        }
        let known = bonds.iter().all(|bond| bond.force.is_finite());
        let tensions: Vec<f64> = bonds.iter().filter(|_| known).map(|bond| bond.tension(bodies)).collect();
        let most = |values: &mut dyn Iterator<Item = f64>| values.filter(|_| known).reduce(f64::max);
        let mean = |sum: f64, count: usize| (count > 0).then(|| sum / count as f64);
        let chains = chains_of(bodies);
        let open: Vec<f64> = chains.iter().filter_map(|chain| chain.span).map(DVec3::length_squared).collect();
        let rows = correlation(&chains);
        let values = vec![
            count(bonds.len()),
            count(bodies.broken_bonds.len()),
            mean(tensions.iter().sum(), tensions.len()),
            most(&mut tensions.iter().copied()),
            most(&mut bonds.iter().map(|bond| bond.torque.length())),
            cell(bonds.iter().map(|bond| bond.bending_energy).sum()),
            count(chains.len()),
            mean(chains.iter().map(|chain| chain.bodies as f64).sum(), chains.len()),
            mean(chains.iter().map(|chain| chain.contour).sum(), chains.len()),
            mean(open.iter().sum(), open.len()).map(f64::sqrt),
            persistence(&rows),
        ];
        let unknown = "bond forces are not known: only checkpoints have them, and states of a run with output.forces";
        Ok(Found { values, rows, remark: (!known).then(|| unknown.into()) })
    }
}

/// A chain or a ring.
struct OneChain {
    bodies: usize,
    /// The length of its contour.
    contour: f64,
    /// The mean contour from one body to the next.
    link: f64,
    /// From its first end to its last; none of a ring.
    span: Option<DVec3>,
    /// Its directions in order, unit vectors.
    directions: Vec<DVec3>,
}

/// The bonds of each body: the bond, and which end of it the body is at.
fn bonds_by_body(bodies: &Bodies) -> Vec<Vec<(usize, usize)>> {
    let mut of_body = vec![Vec::new(); bodies.len()];
    for (number, bond) in bodies.bonds.iter().enumerate() {
        for (end, body) in bond.bodies.into_iter().enumerate() {
            of_body[body as usize].push((number, end));
        }
    }
    of_body
}

/// The chains of a state, in the order of their first bodies; open ones begin at the end with the lower index. Bodies
/// with three bonds and more, and all that are connected to them, are of no chain.
fn chains_of(bodies: &Bodies) -> Vec<OneChain> {
    let of_body = bonds_by_body(bodies);
    let pairs = bodies.bonds.iter().map(|bond| bond.bodies.map(|body| body as usize));
    let roots = components(bodies.len(), pairs);
    let mut branched = vec![false; bodies.len()];
    (0..bodies.len()).filter(|i| of_body[*i].len() > 2).for_each(|i| branched[roots[i]] = true);
    let mut seen: Vec<bool> = roots.iter().map(|root| branched[*root]).collect();
    let mut chains = Vec::new();
    // Rings are what is left after all open chains.
    for ends in [1, 2] {
        for first in 0..bodies.len() {
            if !seen[first] && of_body[first].len() == ends {
                let walk = walk(bodies, &of_body, first, &mut seen);
                chains.extend(chain(bodies, &walk, ends == 2));
            }
        }
    }
    chains
}

/// The bonds from `first` on, each with the end at which the walk comes to it.
fn walk(bodies: &Bodies, of_body: &[Vec<(usize, usize)>], first: usize, seen: &mut [bool]) -> Vec<(usize, usize)> {
    let (mut walk, mut at) = (Vec::new(), first);
    seen[first] = true;
    while let Some(&(bond, end)) = of_body[at].iter().find(|(bond, _)| walk.last().is_none_or(|(last, _)| last != bond))
    {
        walk.push((bond, end));
        at = bodies.bonds[bond].bodies[1 - end] as usize;
        if seen[at] {
            break;
        }
        seen[at] = true;
    }
    walk
}

/// The chain of the bonds of a walk.
fn chain(bodies: &Bodies, walk: &[(usize, usize)], is_ring: bool) -> Option<OneChain> {
    let turn = |body: u32| bodies.orientation[body as usize];
    // The ends of a bond from the centres of both bodies, in the direction of the walk.
    let ends = |(bond, end): &(usize, usize)| {
        let of: &HeldBond = &bodies.bonds[*bond];
        [*end, 1 - *end].map(|end| turn(of.bodies[end]) * of.at[end])
    };
    let ways: Vec<DVec3> = walk
        .iter()
        .map(|(bond, end)| {
            let way = bodies.bonds[*bond].way(bodies).0;
            if *end == 0 { way } else { -way }
        })
        .collect();
    let arms: Vec<[DVec3; 2]> = walk.iter().map(ends).collect();
    let (first, last) = (arms.first()?, arms.last()?);
    let mut inside: Vec<DVec3> = arms.windows(2).map(|pair| pair[1][0] - pair[0][1]).collect();
    if is_ring {
        inside.push(first[0] - last[1]);
    } else {
        // An end body goes on to the other side of its centre.
        inside.insert(0, 2.0 * first[0]);
        inside.push(-2.0 * last[1]);
    }
    let of_bodies = inside.iter().all(|way| way.length() > 0.0);
    let directions = if of_bodies { &inside } else { &ways }.iter().map(|way| way.normalize_or_zero()).collect();
    let mean = |of: &[DVec3]| of.iter().map(|way| way.length()).sum::<f64>() / of.len() as f64;
    let all = || inside.iter().chain(&ways);
    Some(OneChain {
        bodies: inside.len(),
        contour: all().map(|way| way.length()).sum(),
        link: mean(&inside) + mean(&ways),
        span: (!is_ring).then(|| all().sum()),
        directions,
    })
}

/// The mean cosines between directions that are some links apart, up to half of the longest chain.
fn correlation(chains: &[OneChain]) -> Vec<Vec<Cell>> {
    let longest = chains.iter().map(|chain| chain.directions.len()).max().unwrap_or(0);
    let row = |lag: usize| {
        let (mut sum, mut contour, mut pairs) = (0.0, 0.0, 0);
        for chain in chains {
            let all = &chain.directions;
            let apart = if chain.span.is_some() { all.len().saturating_sub(lag) } else { all.len() };
            for i in (0..apart).filter(|_| lag < all.len()) {
                sum += all[i].dot(all[(i + lag) % all.len()]);
                contour += lag as f64 * chain.link;
                pairs += 1;
            }
        }
        (pairs > 0).then(|| vec![count(lag), cell(contour / pairs as f64), cell(sum / pairs as f64), count(pairs)])
    };
    (1..=longest / 2).filter_map(row).collect()
}

/// The persistence length by the cosine between neighbours; none where they are straight, or across each other.
fn persistence(rows: &[Vec<Cell>]) -> Cell {
    let [_, contour, cosine, _] = rows.first()?.as_slice() else { return None };
    let (contour, cosine) = ((*contour)?, (*cosine)?);
    (cosine > 0.0 && cosine < 1.0).then(|| -contour / cosine.ln())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bodies::NO_GROUP;
    use crate::measure::{Frame, Settings};
    use crate::record::Snapshot;
    use crate::scene::{Scene, Time};
    use crate::separation::Placed;
    use crate::shape::Shape;
    use glam::DQuat;

    fn bond(number: u32, bodies: [u32; 2], at: [DVec3; 2], force: DVec3) -> HeldBond {
        HeldBond { number, bodies, at, length: 0.5, force, torque: DVec3::X, bending_energy: 0.25, contact: true }
    }

    fn found(bodies: Bodies) -> Found {
        let state = Snapshot { step: 1, time: 0.0, bodies, warm: None, removed: Vec::new(), fields: Vec::new() };
        let frame = Frame::of_scene(&Scene::new("chain", Time::new(0.1, 1.0)), "a test".into());
        OfBonds.of(&View::new(&state, &frame, &Settings::default())).unwrap()
    }

    fn column(found: &Found, name: &str) -> Cell {
        found.values[COLUMNS.iter().position(|column| column.name == name).unwrap()]
    }

    /// Rods of axes of 2 whose ends are 0.5 apart along the last one's direction, each turned by the same angle.
    fn arc(count: usize, turn: f64) -> Bodies {
        let mut bodies = Bodies::default();
        let mut start = DVec3::ZERO;
        for i in 0..count {
            let angle = turn * i as f64;
            let direction = DVec3::new(angle.cos(), angle.sin(), 0.0);
            let orientation = DQuat::from_rotation_arc(DVec3::Z, direction);
            let shape = Shape::Spherocylinder { diameter: 0.3, length: 2.0 };
            bodies.push(Placed { shape, position: start + direction, orientation }, NO_GROUP);
            start += 2.5 * direction;
        }
        // Every other bond the other way round, and the bodies of the last one in another order.
        bodies.bonds = (1..count as u32)
            .map(|i| match i % 2 {
                0 => bond(i, [i - 1, i], [DVec3::Z, -DVec3::Z], DVec3::ZERO),
                _ => bond(i, [i, i - 1], [-DVec3::Z, DVec3::Z], DVec3::ZERO),
            })
            .collect();
        bodies
    }

    #[test]
    fn an_arc_has_the_lengths_and_the_cosines_of_one() {
        let (count, turn) = (7, 0.3);
        let found = found(arc(count, turn));
        let near = |name: &str, expected: f64| {
            let value = column(&found, name).unwrap();
            assert!((value - expected).abs() < 1e-9, "{name}: {value}, not {expected}");
        };
        near("bonds", 6.0);
        near("bond_chains", 1.0);
        near("chain_bodies", 7.0);
        near("contour_length", 7.0 * 2.0 + 6.0 * 0.5);
        near("bending_energy", 1.5);
        near("bond_torque_most", 1.0);
        let ends: DVec3 = (0..count)
            .map(|i| {
                let angle = turn * i as f64;
                (if i + 1 < count { 2.5 } else { 2.0 }) * DVec3::new(angle.cos(), angle.sin(), 0.0)
            })
            .sum();
        near("end_to_end", ends.length());
        for row in &found.rows {
            assert!((row[2].unwrap() - (turn * row[0].unwrap()).cos()).abs() < 1e-12);
        }
        assert_eq!(found.rows[1][3], Some(5.0));
        near("persistence_length", -2.5 / turn.cos().ln());
    }

    #[test]
    fn a_ring_has_no_ends_and_a_branching_is_no_chain() {
        let mut ring = Bodies::default();
        for i in 0..6 {
            let angle = f64::from(i) * std::f64::consts::PI / 3.0;
            let position = 2.0 * DVec3::new(angle.cos(), angle.sin(), 0.0);
            ring.push(
                Placed { shape: Shape::Sphere { radius: 0.5 }, position, orientation: DQuat::IDENTITY },
                NO_GROUP,
            );
        }
        let centre = [DVec3::ZERO; 2];
        ring.bonds = (0..6).map(|i| bond(i, [i, (i + 1) % 6], centre, DVec3::ZERO)).collect();
        let of_ring = found(ring.clone());
        assert!((column(&of_ring, "contour_length").unwrap() - 12.0).abs() < 1e-12);
        assert_eq!((column(&of_ring, "bond_chains"), column(&of_ring, "end_to_end")), (Some(1.0), None));
        assert!((of_ring.rows[0][2].unwrap() - 0.5).abs() < 1e-12 && of_ring.rows[0][3] == Some(6.0));
        ring.bonds.push(bond(6, [0, 3], centre, DVec3::ZERO));
        let branched = found(ring);
        assert_eq!((column(&branched, "bonds"), column(&branched, "bond_chains")), (Some(7.0), Some(0.0)));
    }

    #[test]
    fn tensions_are_those_along_bonds_and_left_out_where_not_known() {
        let mut bodies = arc(2, 0.0);
        bodies.bonds[0].force = DVec3::new(3.0, 1.0, 0.0);
        // The second body of this bond is the first rod.
        assert_eq!(column(&found(bodies.clone()), "bond_tension_most"), Some(3.0));
        bodies.bonds[0].force = DVec3::NAN;
        let unknown = found(bodies);
        assert_eq!(column(&unknown, "bond_tension_mean"), None);
        assert!(unknown.remark.is_some());
    }
}
