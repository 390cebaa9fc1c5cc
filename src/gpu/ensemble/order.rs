//! The order of the work of several members. The work of each member keeps its order, and dispatches that several
//! members share are merged.
//!
//! Members at the same point of their scenes request the same sequence of kernels, except for the kernels that only
//! some of them need. The next dispatch is that of the member with the most work left, merged with all members whose
//! next dispatch uses the same kernel. So a member with additional work catches up with the others.

/// The work of one dispatch or one set of copies: the members that take part, each with the index of its piece of work.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Together {
    /// Whether it is a dispatch; otherwise copies, which need no order among members.
    pub dispatches: bool,
    /// Members, each with the index of the work in its list.
    pub parts: Vec<(usize, usize)>,
}

/// Orders lists of work. `kernel` returns the kernel that a piece dispatches, `None` for a copy. At most `most` members
/// share a dispatch.
pub(super) fn ordered<T>(lists: &[Vec<T>], kernel: impl Fn(&T) -> Option<u64>, most: usize) -> Vec<Together> {
    let mut next = vec![0; lists.len()];
    let mut left: Vec<usize> =
        lists.iter().map(|list| list.iter().filter(|work| kernel(work).is_some()).count()).collect();
    let mut out = Vec::new();
    loop {
        let copies = copies(lists, &kernel, &mut next);
        if !copies.is_empty() {
            out.push(Together { dispatches: false, parts: copies });
        }
        // On a tie the first member, so that the order is deterministic.
        let busiest = (0..lists.len()).filter(|member| left[*member] > 0).max_by_key(|m| (left[*m], usize::MAX - *m));
        let Some(busiest) = busiest else { return out };
        let chosen = kernel(&lists[busiest][next[busiest]]);
        let same = |member: &usize| left[*member] > 0 && kernel(&lists[*member][next[*member]]) == chosen;
        let parts: Vec<_> = (0..lists.len()).filter(same).map(|member| (member, next[member])).collect();
        for (member, _) in &parts {
            next[*member] += 1;
            left[*member] -= 1;
        }
        out.extend(parts.chunks(most).map(|parts| Together { dispatches: true, parts: parts.to_vec() }));
    }
}

/// The copies that precede every member's next dispatch.
fn copies<T>(lists: &[Vec<T>], kernel: &impl Fn(&T) -> Option<u64>, next: &mut [usize]) -> Vec<(usize, usize)> {
    let mut parts = Vec::new();
    for (member, list) in lists.iter().enumerate() {
        while list.get(next[member]).is_some_and(|work| kernel(work).is_none()) {
            parts.push((member, next[member]));
            next[member] += 1;
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Zero stands for a copy.
    fn order(lists: &[Vec<u64>], most: usize) -> Vec<Together> {
        ordered(lists, |kernel| Some(*kernel).filter(|kernel| *kernel > 0), most)
    }

    #[test]
    fn members_at_the_same_point_share_every_dispatch() {
        let order = order(&vec![vec![1, 2, 0, 3]; 4], 8);
        let sizes: Vec<_> = order.iter().map(|together| (together.dispatches, together.parts.len())).collect();
        assert_eq!(sizes, [(true, 4), (true, 4), (false, 4), (true, 4)]);
    }

    #[test]
    fn one_that_has_more_to_do_comes_first_to_where_the_others_are() {
        let order = order(&[vec![1, 2, 3], vec![7, 8, 1, 2, 3], vec![1, 2, 3]], 8);
        let sizes: Vec<_> = order.iter().map(|together| together.parts.len()).collect();
        assert_eq!(sizes, [1, 1, 3, 3, 3]);
    }

    #[test]
    fn every_members_work_is_done_once_and_in_its_order_and_no_dispatch_has_too_many() {
        let lists: Vec<Vec<u64>> = (0..7).map(|m| (0..20).map(|k| (m * k * k + k) % 4).collect()).collect();
        let order = order(&lists, 3);
        for member in 0..lists.len() {
            let done: Vec<usize> = order
                .iter()
                .flat_map(|together| together.parts.iter().filter(|(m, _)| *m == member).map(|(_, place)| *place))
                .collect();
            assert_eq!(done, (0..20).collect::<Vec<_>>());
        }
        assert!(order.iter().all(|together| !together.dispatches || together.parts.len() <= 3));
    }
}
