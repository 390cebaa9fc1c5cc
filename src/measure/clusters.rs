//! Connected components of a graph of bodies: union-find with path halving (R. E. Tarjan, J. van Leeuwen, "Worst-case
//! analysis of set union algorithms", 1984).

use super::{Cell, Column, count};
use std::collections::BTreeMap;

/// The columns of a profile of sizes.
pub(super) const SIZE_COLUMNS: [Column; 2] =
    [Column { name: "size", what: "bodies of a component" }, Column { name: "count", what: "components of this size" }];

/// For each of `bodies` bodies the least index in its component.
pub(super) fn components(bodies: usize, links: impl Iterator<Item = [usize; 2]>) -> Vec<usize> {
    let mut parent: Vec<usize> = (0..bodies).collect();
    for link in links {
        let [a, b] = link.map(|body| root(&mut parent, body));
        // The smaller index is the root, so that the result does not depend on the order of the links.
        parent[a.max(b)] = a.min(b);
    }
    (0..bodies).map(|body| root(&mut parent, body)).collect()
}

fn root(parent: &mut [usize], mut body: usize) -> usize {
    while parent[body] != body {
        parent[body] = parent[parent[body]];
        body = parent[body];
    }
    body
}

/// The sizes of components, with the number of components of each size; a component is omitted if `counts` of its root
/// is false.
pub(super) fn sizes(roots: &[usize], counts: impl Fn(usize) -> bool) -> BTreeMap<usize, usize> {
    let mut size = vec![0; roots.len()];
    for &root in roots {
        size[root] += 1;
    }
    let mut sizes = BTreeMap::new();
    for (_, &size) in size.iter().enumerate().filter(|(root, size)| **size > 0 && counts(*root)) {
        *sizes.entry(size).or_default() += 1;
    }
    sizes
}

/// The number of components, their mean size and the largest size.
pub(super) fn summary(sizes: &BTreeMap<usize, usize>) -> [Cell; 3] {
    let number: usize = sizes.values().sum();
    let members: usize = sizes.iter().map(|(size, count)| size * count).sum();
    let mean = (number > 0).then(|| members as f64 / number as f64);
    [count(number), mean, sizes.keys().next_back().map(|largest| *largest as f64)]
}

/// One row per size.
pub(super) fn rows(sizes: &BTreeMap<usize, usize>) -> Vec<Vec<Cell>> {
    sizes.iter().map(|(size, number)| vec![count(*size), count(*number)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chains_and_loners() {
        let roots = components(7, [[5, 6], [0, 1], [6, 1], [3, 4], [4, 3]].into_iter());
        assert_eq!(roots, [0, 0, 2, 3, 3, 0, 0]);
        let all = sizes(&roots, |_| true);
        assert_eq!(all.into_iter().collect::<Vec<_>>(), [(1, 1), (2, 1), (4, 1)]);
        let some = sizes(&roots, |root| root != 2);
        assert_eq!(summary(&some), [Some(2.0), Some(3.0), Some(4.0)]);
        assert_eq!(summary(&BTreeMap::new()), [Some(0.0), None, None]);
    }
}
