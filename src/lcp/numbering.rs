//! An order of bodies in which those that share rows are near each other: the breadth-first order of Cuthill and McKee
//! (Reducing the bandwidth of sparse symmetric matrices, 1969), started at a body far from the others. Rows sorted by
//! this order find their velocities near each other, in memory and in the share of one thread.

use super::incidence::Incidence;

/// Computes the position of every body. A row with a zero block connects no bodies.
pub(super) fn rebuild<const D: usize>(
    bodies: usize,
    pair: &[[u32; 2]],
    jacobian: &[[[f64; D]; 2]],
    place: &mut Vec<u32>,
) {
    let joins = |blocks: &[[f64; D]; 2]| blocks.iter().all(|block| *block != [0.0; D]);
    let joined: Vec<[u32; 2]> =
        pair.iter().zip(jacobian).filter(|(_, blocks)| joins(blocks)).map(|(pair, _)| *pair).collect();
    of_joined(bodies, &joined, place);
}

/// The same from connected pairs, which may be repeated.
pub(super) fn of_joined(bodies: usize, joined: &[[u32; 2]], place: &mut Vec<u32>) {
    let mut incidence = Incidence::default();
    incidence.rebuild(bodies, joined);
    let mut order: Vec<u32> = Vec::with_capacity(bodies);
    place.clear();
    place.resize(bodies, u32::MAX);
    for body in 0..bodies as u32 {
        if place[body as usize] != u32::MAX {
            continue;
        }
        // The last body in breadth-first order is far from the others.
        let first = order.len();
        let visit = |start: u32, order: &mut Vec<u32>, place: &mut Vec<u32>| {
            order.push(start);
            place[start as usize] = first as u32;
            let mut next = first;
            while let Some(&body) = order.get(next) {
                next += 1;
                for entry in incidence.of(body as usize) {
                    let other = joined[(entry / 2) as usize][1 - (entry % 2) as usize];
                    if place[other as usize] == u32::MAX {
                        place[other as usize] = order.len() as u32;
                        order.push(other);
                    }
                }
            }
        };
        visit(body, &mut order, place);
        let far = order[order.len() - 1];
        order.drain(first..).for_each(|body| place[body as usize] = u32::MAX);
        visit(far, &mut order, place);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_have_near_numbers_and_walls_join_nobody() {
        // A chain of bodies with scattered indices; each also touches a wall, the last body.
        let body = |link: u32| link * 7 % 50;
        let mut pair: Vec<[u32; 2]> = (0..49).map(|link| [body(link), body(link + 1)]).collect();
        let mut jacobian = vec![[[1.0, 0.0, 0.0]; 2]; 49];
        pair.extend((0..50).map(|link| [link, 50]));
        jacobian.extend([[[1.0, 0.0, 0.0], [0.0; 3]]; 50]);
        let mut place = Vec::new();
        rebuild(51, &pair, &jacobian, &mut place);
        assert!(pair[..49].iter().all(|[a, b]| place[*a as usize].abs_diff(place[*b as usize]) == 1));
        let mut all = place.clone();
        all.sort_unstable();
        assert!(all.into_iter().eq(0..51));
    }
}
