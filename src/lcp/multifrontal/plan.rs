//! The supernodes of a factor, their tree, and which of them make a task.

use crate::lcp::sparse_cholesky::{Pattern, supernodes};

/// A task has at most this part of all work, so that eight threads find several each.
const SHARES: f64 = 32.0;

/// The work of a supernode beside its multiplications.
const WORK_OF_A_NODE: f64 = 3e3;

/// A supernode: bodies that are eliminated together, since they have the same rows below.
pub(super) struct Node {
    /// The first body and the number of bodies.
    pub first: usize,
    pub columns: usize,
    /// The bodies of the rows below, ascending.
    pub rows: Vec<u32>,
    /// The supernode of the first row below.
    pub parent: Option<usize>,
    /// Ascending.
    pub children: Vec<usize>,
    /// The number of supernodes in its subtree, and the work of these.
    size: usize,
    subtree_work: f64,
}

/// The supernodes of one task, ascending.
pub(super) struct Group {
    pub nodes: Vec<usize>,
    /// The first supernode in the subtrees of these.
    first: usize,
    /// The number of groups in the subtree of this one, with itself.
    pub subtree: usize,
    /// Its work, unless it has nodes above smaller subtrees.
    open: Option<f64>,
}

/// The supernodes in postorder, and the groups in postorder.
pub(super) struct Plan {
    pub nodes: Vec<Node>,
    pub groups: Vec<Group>,
    /// The unknowns of a body.
    block: usize,
}

impl Plan {
    /// Analyses a graph of bodies with `block` unknowns each, for tasks that have at least this much work if they can;
    /// none if there is no memory.
    pub fn new(graph: Pattern<'_>, block: usize, least_work: f64) -> Option<Self> {
        let bodies = graph.column.len().saturating_sub(1);
        let found = if bodies > 0 { supernodes(graph)? } else { Vec::new() };
        let mut nodes: Vec<Node> = found
            .into_iter()
            .map(|(columns, rows)| Node {
                first: columns.start,
                columns: columns.len(),
                rows,
                parent: None,
                children: Vec::new(),
                size: 1,
                subtree_work: 0.0,
            })
            .collect();
        let mut node_of = vec![0; bodies];
        for (k, node) in nodes.iter().enumerate() {
            node_of[node.first..node.first + node.columns].fill(k);
        }
        for k in 0..nodes.len() {
            nodes[k].subtree_work += WORK_OF_A_NODE + work(&nodes[k], block);
            nodes[k].parent = nodes[k].rows.first().map(|row| node_of[*row as usize]);
            if let Some(parent) = nodes[k].parent {
                let (size, work) = (nodes[k].size, nodes[k].subtree_work);
                nodes[parent].children.push(k);
                nodes[parent].size += size;
                nodes[parent].subtree_work += work;
            }
        }
        let groups = groups(&nodes, least_work);
        Some(Plan { nodes, groups, block })
    }

    /// The number of entries of the factor.
    pub fn entries(&self) -> usize {
        let of_node = |node: &Node| node.columns * (node.columns + node.rows.len()) * self.block * self.block;
        self.nodes.iter().map(of_node).sum()
    }

    /// The squares of the lengths of the factor's columns.
    pub fn work(&self) -> f64 {
        self.nodes.iter().map(|node| work(node, self.block)).sum()
    }
}

fn work(node: &Node, block: usize) -> f64 {
    let (columns, below) = (node.columns * block, node.rows.len() * block);
    (1..=columns).map(|column| ((below + column) as f64).powi(2)).sum()
}

/// Groups the supernodes: subtrees of little work, adjacent ones with the same parent together, and above these the
/// paths to the next branch.
fn groups(nodes: &[Node], least_work: f64) -> Vec<Group> {
    let total: f64 = nodes.iter().filter(|node| node.parent.is_none()).map(|node| node.subtree_work).sum();
    let most = (total / SHARES).max(least_work);
    let is_top = |k: usize| nodes[k].subtree_work > most;
    let mut groups: Vec<Group> = Vec::new();
    for (k, node) in nodes.iter().enumerate() {
        let first = k + 1 - node.size;
        if is_top(k) {
            let mut tops = node.children.iter().filter(|child| is_top(**child));
            let mut path = match (tops.next(), tops.next()) {
                // The path of the only branch goes on.
                (Some(below), None) => {
                    let at = groups.iter().position(|group| group.nodes.last() == Some(below));
                    at.map_or_else(Vec::new, |at| groups.remove(at).nodes)
                }
                _ => Vec::new(),
            };
            path.push(k);
            let subtree = 1 + groups.iter().rev().take_while(|group| group.first >= first).count();
            groups.push(Group { nodes: path, first, subtree, open: None });
        } else if node.parent.is_none_or(is_top) {
            let last = groups.last_mut();
            let joins = |group: &&mut Group| {
                let end = group.nodes.last().copied();
                let has_room = group.open.is_some_and(|work| work + node.subtree_work <= most);
                has_room && end.is_some_and(|end| end + 1 == first && nodes[end].parent == node.parent)
            };
            match last.filter(joins) {
                Some(group) => {
                    group.nodes.extend(first..=k);
                    group.open = group.open.map(|work| work + node.subtree_work);
                }
                None => {
                    let open = Some(node.subtree_work);
                    groups.push(Group { nodes: (first..=k).collect(), first, subtree: 1, open });
                }
            }
        }
    }
    groups
}
