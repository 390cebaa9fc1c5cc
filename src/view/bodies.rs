//! What all states share of each body that is ever recorded: a row a body, in the order in which they are first met.

use super::columns::Block;
use super::places::half_segment;
use crate::bodies::Bodies;
use crate::shape::{Centreline, EXPONENTS, Geometry, Shape};
use glam::DVec3;
use std::collections::HashMap;

/// How far a rod's half segment may be from that of its row, relative to it, and still count as the same.
const SAME_LENGTH: f64 = 1e-7;

/// The rows.
#[derive(Default)]
pub(super) struct Table {
    rows: HashMap<u64, u32>,
    id: Vec<u64>,
    parent: Vec<Option<u64>>,
    birth: Vec<f64>,
    generation: Vec<u32>,
    group: Vec<u32>,
    kind: Vec<u32>,
    sizes: [Vec<f64>; 3],
    last: Vec<u32>,
}

impl Table {
    /// How many rows there are.
    pub fn len(&self) -> usize {
        self.id.len()
    }

    /// The rows of a state's bodies, new ones among them; adds them where they are not those of the last state.
    pub fn rows(&mut self, bodies: &Bodies, block: &mut Block) -> Vec<u32> {
        let rows: Vec<u32> = (0..bodies.len()).map(|i| self.row(bodies, i)).collect();
        if rows != self.last {
            let before = std::iter::once(0).chain(rows.iter().copied());
            let differences: Vec<i32> =
                rows.iter().zip(before).map(|(row, last)| row.wrapping_sub(last) as i32).collect();
            block.add_signed("row", &differences);
            self.last.clone_from(&rows);
        }
        rows
    }

    fn row(&mut self, bodies: &Bodies, i: usize) -> u32 {
        let line = bodies.lineage[i];
        if let Some(row) = self.rows.get(&line.id) {
            return *row;
        }
        let row = self.len() as u32;
        self.rows.insert(line.id, row);
        self.id.push(line.id);
        self.parent.push(line.parent);
        self.birth.push(line.birth);
        self.generation.push(line.generation);
        self.group.push(bodies.group[i]);
        let (kind, sizes) = drawn(&bodies.shape[i]);
        self.kind.push(kind);
        for (column, size) in self.sizes.iter_mut().zip(sizes) {
            column.push(size);
        }
        row
    }

    /// Whether a rod or an ellipsoid is no longer as long as when it was first met.
    pub fn grown(&self, bodies: &Bodies, rows: &[u32]) -> bool {
        bodies.shape.iter().zip(rows).any(|(shape, row)| {
            let row = *row as usize;
            // An ellipsoid's semi-axis along z is its last size.
            let first = self.sizes[if self.kind[row] == 3 { 2 } else { 0 }][row];
            let now = half_segment(shape);
            (now - first).abs() > SAME_LENGTH * first
        })
    }

    /// All rows as columns.
    pub fn block(&self) -> Block {
        let mut block = Block::default();
        let halves = |ids: &mut dyn Iterator<Item = u64>| ids.map(|id| (id as u32, (id >> 32) as u32)).unzip();
        let (low, high): (Vec<_>, Vec<_>) = halves(&mut self.id.iter().copied());
        block.add("id", &low);
        block.add("id_high", &high);
        let (low, high): (Vec<_>, Vec<_>) = halves(&mut self.parent.iter().map(|parent| parent.unwrap_or(0)));
        block.add("parent", &low);
        block.add("parent_high", &high);
        block.add("has_parent", &self.parent.iter().map(|parent| u32::from(parent.is_some())).collect::<Vec<_>>());
        block.add_floats("birth", self.birth.iter().copied());
        block.add("generation", &self.generation);
        block.add("group", &self.group);
        block.add("kind", &self.kind);
        for (name, sizes) in ["size_1", "size_2", "size_3"].into_iter().zip(&self.sizes) {
            block.add_floats(name, sizes.iter().copied());
        }
        block
    }
}

/// How the shaders know a shape: 0 a point, 1 a segment, 2 a circle, thickened, with half the length or the radius
/// and the thickening radius; 3 an ellipsoid with its semi-axes, 4 a superellipsoid.
fn drawn(shape: &Shape) -> (u32, [f64; 3]) {
    match shape.geometry() {
        Geometry::Centreline { curve, radius } => match curve {
            Centreline::Point => (0, [0.0, radius, 0.0]),
            Centreline::Segment { half } => (1, [half, radius, 0.0]),
            Centreline::Circle { radius: major } => (2, [major, radius, 0.0]),
        },
        Geometry::Ellipsoid { radii } => (3, radii.to_array()),
        Geometry::Convex(custom) => match shape.exponents() {
            Some(exponents) => (superellipsoid(exponents), shape.code().1),
            None => (3, DVec3::AXES.map(|axis| custom.reach(axis).max(custom.reach(-axis)))),
        },
    }
}

/// The kind of a superellipsoid: 4, and above its three bits the exponents, ten bits each.
fn superellipsoid(exponents: [f64; 2]) -> u32 {
    let [low, high] = EXPONENTS;
    let [n1, n2] = exponents.map(|n| ((n - low) / (high - low) * 1023.0).round() as u32);
    4 | n1 << 3 | n2 << 13
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::Superellipsoid;

    /// As `exponentsOf` in `assets/view/data.js`, to two decimals.
    #[test]
    fn a_page_has_the_exponents_of_superellipsoids() {
        for exponents in [[2.0, 10.0], [2.5, 4.0], [8.0, 3.33], [9.99, 2.01]] {
            let (kind, sizes) = drawn(&Shape::Superellipsoid(Superellipsoid::new([0.3, 0.4, 0.5], exponents)));
            assert_eq!((kind & 7, sizes), (4, [0.3, 0.4, 0.5]));
            // The shaders have the bits above the kind behind the point of a 32-bit float.
            let behind = 4.0 + (kind >> 3) as f32 / 1_048_576.0;
            let code = (f64::from(behind - 4.0) * 1_048_576.0).round() as u32;
            let read = [code & 1023, code >> 10].map(|part| 2.0 + f64::from(part) * 8.0 / 1023.0);
            for (read, given) in read.into_iter().zip(exponents) {
                assert_eq!((read * 100.0).round(), (given * 100.0).round(), "{exponents:?}");
            }
        }
    }
}
