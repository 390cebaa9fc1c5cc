//! A part of the factor that one thread computes: fronts in ascending order, with their updates on a stack.

use super::front::{Blocks, Child, Front};
use super::plan::{Group, Plan};
use crate::lcp::sparse_cholesky::Pattern;
use faer::dyn_stack::MemBuffer;
use faer::linalg::cholesky::llt::factor::cholesky_in_place_scratch;
use faer::{Par, Spec};

/// The fronts of one thread, and their columns of the factor.
pub(super) struct Task<const D: usize> {
    pub fronts: Vec<Front>,
    pub factor: Vec<f64>,
    /// The updates that wait for their parents.
    updates: Vec<f64>,
    memory: MemBuffer,
    /// Its bodies: those that it eliminates, then those of the rows below, each ascending.
    pub bodies: Vec<u32>,
    /// How many of them it eliminates.
    pub own: usize,
    /// The places of the others among the bodies of the parent task.
    pub above: Vec<u32>,
    /// The number of tasks in its subtree, with itself.
    pub subtree: usize,
    /// A vector's part at its bodies, during a solve.
    pub x: Vec<[f64; D]>,
    /// The part at the rows below a front.
    pub below: Vec<[f64; D]>,
}

impl<const D: usize> Task<D> {
    /// Eliminates its bodies. `before` are the other tasks of its subtree. Says whether all pivots are positive.
    pub fn eliminate(&mut self, blocks: Blocks<'_, D>, before: &[Task<D>]) -> bool {
        let Task { fronts, factor, updates, memory, .. } = self;
        for front in fronts {
            let [columns, below] = front.shape::<D>();
            let panel = &mut factor[front.panel..][..columns * (columns + below)];
            let (waiting, rest) = updates.split_at_mut(front.computed);
            let update_of = |child: &Child| match child.task {
                None => &waiting[child.start..],
                Some(task) => &before[task].updates[child.start..],
            };
            front.assemble(panel, blocks, &update_of);
            if !front.factorize::<D>(panel, memory) {
                return false;
            }
            front.update::<D>(panel, &mut rest[..below * below], &update_of);
            if front.update != front.computed {
                updates.copy_within(front.computed..front.computed + below * below, front.update);
            }
        }
        true
    }
}

/// Where a supernode's update lies.
#[derive(Clone, Copy)]
struct Place {
    task: usize,
    start: usize,
}

/// The tasks of a plan, in postorder, with the memory of other ones; none if there is no memory.
pub(super) fn tasks<const D: usize>(plan: &Plan, graph: Pattern<'_>, old: Vec<Task<D>>) -> Option<Vec<Task<D>>> {
    let mut old = old.into_iter();
    let mut placed = vec![Place { task: 0, start: 0 }; plan.nodes.len()];
    let mut tasks: Vec<Task<D>> = Vec::with_capacity(plan.groups.len());
    for (k, group) in plan.groups.iter().enumerate() {
        tasks.push(task(k, group, plan, graph, &mut placed, old.next())?);
    }
    // A task comes after all others of its subtree, so those not yet in another's subtree are its children.
    for parent in 0..tasks.len() {
        let (before, rest) = tasks.split_at_mut(parent);
        let mut child = parent;
        while child > parent + 1 - rest[0].subtree {
            let Task { bodies, own, above, subtree, .. } = &mut before[child - 1];
            above.extend(bodies[*own..].iter().map(|body| place_in(&rest[0].bodies, *body)));
            child -= *subtree;
        }
    }
    Some(tasks)
}

/// The place of a body in an ascending list that has it.
fn place_in(bodies: &[u32], body: u32) -> u32 {
    bodies.partition_point(|other| *other < body) as u32
}

fn task<const D: usize>(
    index: usize,
    group: &Group,
    plan: &Plan,
    graph: Pattern<'_>,
    placed: &mut [Place],
    old: Option<Task<D>>,
) -> Option<Task<D>> {
    let bodies_of = |node: &usize| (plan.nodes[*node].first..).take(plan.nodes[*node].columns).map(|body| body as u32);
    let mut bodies: Vec<u32> = group.nodes.iter().flat_map(bodies_of).collect();
    let own = bodies.len();
    let last = bodies.last().copied()?;
    let mut outside: Vec<u32> = group.nodes.iter().flat_map(|node| &plan.nodes[*node].rows).copied().collect();
    outside.retain(|body| *body > last);
    outside.sort_unstable();
    outside.dedup();
    bodies.extend(outside);
    let (mut factor, mut top, mut most, mut widest, mut longest) = (0, 0, 0, 0, 0);
    let mut fronts = Vec::with_capacity(group.nodes.len());
    for k in &group.nodes {
        let node = &plan.nodes[*k];
        // The place of a body among the columns and the rows below.
        let place = |body: u32| match (body as usize).checked_sub(node.first) {
            Some(column) if column < node.columns => column as u32,
            _ => node.columns as u32 + place_in(&node.rows, body),
        };
        let of_child = |child: &usize| {
            let Place { task, start } = placed[*child];
            let task = (task != index).then(|| task + group.subtree - index - 1);
            Child { task, start, place: plan.nodes[*child].rows.iter().map(|body| place(*body)).collect() }
        };
        let children: Vec<Child> = node.children.iter().map(of_child).collect();
        let own_child = children.iter().find(|child| child.task.is_none());
        let update = own_child.map_or(top, |child| child.start);
        let edges = graph.column[node.first] as usize..graph.column[node.first + node.columns] as usize;
        let front = Front {
            body: node.first,
            first: place_in(&bodies, node.first as u32) as usize,
            columns: node.columns,
            rows: node.rows.iter().map(|body| place_in(&bodies, *body)).collect(),
            links: graph.entry[edges].iter().map(|body| place(*body)).collect(),
            children,
            panel: factor,
            computed: top,
            update,
        };
        let [columns, below] = front.shape::<D>();
        factor += columns * (columns + below);
        (most, widest, longest) = (most.max(top + below * below), widest.max(columns), longest.max(node.rows.len()));
        top = update + below * below;
        placed[*k] = Place { task: index, start: update };
        fronts.push(front);
    }
    let (old_factor, old_updates) = old.map_or_else(Default::default, |old| (old.factor, old.updates));
    let memory = cholesky_in_place_scratch::<f64>(widest, Par::Seq, Spec::default());
    Some(Task {
        fronts,
        factor: sized(old_factor, factor)?,
        updates: sized(old_updates, most)?,
        memory: MemBuffer::try_new(memory).ok()?,
        x: vec![[0.0; D]; bodies.len()],
        below: vec![[0.0; D]; longest],
        bodies,
        own,
        above: Vec::new(),
        subtree: group.subtree,
    })
}

/// A vector of this many numbers, whatever they are; none if there is no memory.
fn sized(mut numbers: Vec<f64>, count: usize) -> Option<Vec<f64>> {
    numbers.try_reserve_exact(count.saturating_sub(numbers.len())).ok()?;
    numbers.resize(count, 0.0);
    Some(numbers)
}
