//! Overlapping domains of rows: clusters of bodies that share rows, each grown by a layer of neighbours.
//!
//! A cluster starts at the first body without a cluster in the order of [`super::numbering`]. It grows by the body with
//! the most rows to it. Its domain has all rows of its bodies and of their neighbours, so a pair has all its rows in
//! the domain. The partition and the size of clusters hardly matter; the layer does.
//!
//! Degenerate cases: a body that with its layer exceeds the limits has a domain with only its own rows, and none if
//! these are too many. A side without mobility (a wall) connects no bodies.

mod growth;
mod on_cpu;

use super::incidence::Incidence;
use super::numbering;
use growth::Growth;
pub(crate) use on_cpu::Clusters;

/// The largest number of bodies in a cluster, without the layer. On a colony of 4,096 cells 8, 16 and 64 take 364, 312
/// and 252 iterations; the work of an iteration grows with it if a domain has many rows.
const MOST_MEMBERS: usize = 16;

/// Steps of conjugate gradients in each local LCP: 5, 10 and 20 take 493, 266 and 239 iterations on that colony, and
/// 5.0, 5.3 and 9.1 thousand local steps in total.
pub(crate) const LOCAL_STEPS: usize = 10;

/// The part of its diagonal that is added to the matrix of a local LCP, so that multipliers that balance each other
/// within a cluster do not grow without bounds. With exact local solves 1e-6, 1e-4 and 1e-3 take 312, 297 and 437
/// iterations.
pub(crate) const COMPLIANCE: f64 = 1e-4;

/// A domain is skipped if the residuals of its rows are at most this part of the tolerance. Without this, later LCPs of
/// a step, which are solved nearly everywhere, take twice the iterations.
pub(crate) const QUIET: f64 = 0.3;

/// The body index of a side without mobility.
pub(crate) const NOBODY: u32 = u32::MAX;

/// The largest number of rows in a domain, for the memory of a workgroup on a device. The domains are the same on all
/// backends.
pub(crate) const MOST_ROWS: usize = 256;
/// The largest number of bodies of its rows, including those that only neighbours touch.
pub(crate) const MOST_BODIES: usize = 96;

/// The rows of every domain, ascending, from the bodies of each row, [`NOBODY`] for sides without mobility.
pub(crate) fn domains(bodies: usize, sides: &[[u32; 2]]) -> Vec<Vec<u32>> {
    let joined: Vec<[u32; 2]> = sides.iter().filter(|sides| !sides.contains(&NOBODY)).copied().collect();
    let mut place = Vec::new();
    numbering::of_joined(bodies, &joined, &mut place);
    let body = |side: u32| if side == NOBODY { bodies as u32 } else { place[side as usize] };
    let sides: Vec<[u32; 2]> = sides.iter().map(|sides| sides.map(body)).collect();
    // Walls have the list after all others, which is never read.
    let mut incidence = Incidence::default();
    incidence.rebuild(bodies + 1, &sides);
    let mut growth = Growth::new(bodies, &sides, &incidence);
    (0..bodies as u32).filter_map(|first| growth.domain(first)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    /// A lattice with one to three rows a pair, and a wall along one of its sides.
    fn lattice(side: u32) -> (usize, Vec<[u32; 2]>) {
        let mut sides = Vec::new();
        for i in 0..side {
            for j in 0..side {
                let body = i * side + j;
                for (inside, other) in [(j + 1 < side, body + 1), (i + 1 < side, body + side)] {
                    for _ in 0..=(body * other) % 3 {
                        if inside {
                            sides.push(if body.is_multiple_of(2) { [body, other] } else { [other, body] });
                        }
                    }
                }
                if i == 0 {
                    sides.push([body, NOBODY]);
                }
            }
        }
        ((side * side) as usize, sides)
    }

    #[test]
    fn domains_are_all_rows_of_clusters_and_their_neighbours() {
        let (bodies, sides) = lattice(12);
        let domains = domains(bodies, &sides);
        let mut times = vec![0; sides.len()];
        for rows in &domains {
            assert!(rows.is_sorted() && rows.len() <= MOST_ROWS);
            rows.iter().for_each(|row| times[*row as usize] += 1);
            // Whole pairs.
            let pairs: Vec<[u32; 2]> = rows.iter().map(|row| sides[*row as usize]).collect();
            let all = sides.iter().filter(|sides| pairs.contains(sides)).count();
            assert_eq!(all, rows.len());
        }
        assert!(times.iter().all(|times| (1..=8).contains(times)), "{times:?}");
        let overlap = domains.iter().map(Vec::len).sum::<usize>() as f64 / sides.len() as f64;
        println!("{} domains, each row in {overlap:.2}", domains.len());
        assert!(domains.len() >= bodies / MOST_MEMBERS && domains.len() < bodies / 4);
    }

    #[test]
    fn a_body_with_many_neighbours_has_a_domain_of_its_own_rows_or_none() {
        // Bodies around a large one, with another body behind each of them.
        for (others, whole) in [(20, true), (60, false), (200, false)] {
            let mut sides: Vec<[u32; 2]> = (1..=others).map(|other| [0, other]).collect();
            sides.extend((1..=others).map(|other| [other, others + other]));
            let domains = domains(2 * others as usize + 1, &sides);
            let with_all = |rows: &Vec<u32>| (0..others).all(|row| rows.contains(&row));
            let of_hub = domains.iter().find(|rows| with_all(rows));
            assert_eq!(of_hub.is_some(), others < MOST_BODIES as u32, "{others}");
            assert_eq!(of_hub.is_some_and(|rows| rows.len() == 2 * others as usize), whole, "{others}");
        }
    }

    #[test]
    fn domains_do_not_depend_on_the_order_of_rows_within_the_limits() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        let (bodies, mut sides) = lattice(9);
        let first = domains(bodies, &sides);
        let kept = sides.clone();
        for row in (1..sides.len()).rev() {
            sides.swap(row, rng.random_range(0..=row));
        }
        assert_eq!(domains(bodies, &kept), first);
        assert!(domains(bodies, &sides).iter().all(|rows| !rows.is_empty()));
        assert!(domains(0, &[]).is_empty() && domains(3, &[]).is_empty());
    }
}
