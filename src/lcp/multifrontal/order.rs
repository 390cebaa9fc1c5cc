//! An order of elimination with little fill in which each subtree of the elimination tree is contiguous.

use crate::lcp::sparse_cholesky::{Pattern, minimum_degree};

/// No body.
const NONE: u32 = u32::MAX;

/// The place of each body in an order of approximate minimum degree, in postorder of its elimination tree. The graph
/// has an edge for each link, from its smaller body to its larger one. None if there is no memory.
pub(in crate::lcp) fn elimination_order(graph: Pattern<'_>) -> Option<Vec<u32>> {
    let place = minimum_degree(graph)?;
    let post = postorder(&parents(graph, &place));
    Some(place.iter().map(|place| post[*place as usize]).collect())
}

/// The parent of each place in the elimination tree (Liu, A compact row storage scheme for Cholesky factors using
/// elimination trees, 1986).
fn parents(graph: Pattern<'_>, place: &[u32]) -> Vec<u32> {
    let mut links: Vec<[u32; 2]> = Vec::with_capacity(graph.entry.len());
    for (body, bounds) in graph.column.windows(2).enumerate() {
        for other in &graph.entry[bounds[0] as usize..bounds[1] as usize] {
            let (a, b) = (place[body], place[*other as usize]);
            links.push([a.max(b), a.min(b)]);
        }
    }
    links.sort_unstable();
    let (mut parent, mut ancestor) = (vec![NONE; place.len()], vec![NONE; place.len()]);
    for [later, earlier] in links {
        // Climbs from the earlier one to the root of its tree so far, and shortens the way for the next.
        let mut at = earlier as usize;
        while ancestor[at] != NONE && ancestor[at] != later {
            at = std::mem::replace(&mut ancestor[at], later) as usize;
        }
        if ancestor[at] == NONE {
            (ancestor[at], parent[at]) = (later, later);
        }
    }
    parent
}

/// The place of each node in a postorder of a forest.
fn postorder(parent: &[u32]) -> Vec<u32> {
    let root = parent.len();
    let (mut first, mut next) = (vec![NONE; root + 1], vec![NONE; root]);
    for node in (0..root).rev() {
        let above = if parent[node] == NONE { root } else { parent[node] as usize };
        next[node] = std::mem::replace(&mut first[above], node as u32);
    }
    let (mut place, mut count, mut path) = (vec![0; root], 0, vec![root as u32]);
    while let Some(top) = path.last().map(|top| *top as usize) {
        if first[top] == NONE {
            if top < root {
                place[top] = count;
                count += 1;
            }
            path.pop();
        } else {
            let child = first[top];
            first[top] = next[child as usize];
            path.push(child);
        }
    }
    place
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn children_come_before_their_parents_and_subtrees_are_contiguous() {
        let parent = [3, 4, 3, 5, 5, NONE, 7, NONE];
        let place = postorder(&parent);
        assert_eq!(place, [0, 3, 1, 2, 4, 5, 6, 7]);
        assert!(postorder(&[]).is_empty());
    }

    #[test]
    fn a_ring_of_bodies_is_a_path_of_parents_and_ends_at_one_root() {
        let (column, entry) = ([0, 2, 3, 4, 4], [1, 3, 2, 3]);
        let parent = parents(Pattern { column: &column, entry: &entry }, &[0, 1, 2, 3]);
        assert_eq!(parent, [1, 2, 3, NONE]);
    }
}
