//! The front of a supernode: its columns of the factor, and the update of the rows below.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{LltRegularization, cholesky_in_place};
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, MatMut, MatRef, Par, Spec};

/// The blocks of a matrix.
#[derive(Clone, Copy)]
pub(in crate::lcp) struct Blocks<'a, const D: usize> {
    /// The block of each body with itself.
    pub own: &'a [[[f64; D]; D]],
    /// The offset of the links of each body with later ones, and the end.
    pub first_link: &'a [u32],
    /// The columns of each link's block: the unknowns of the smaller body are its columns.
    pub linked: &'a [[[f64; D]; D]],
}

/// A child's update: where it lies, and the places of its bodies in the parent's front.
pub(super) struct Child {
    /// The task before the parent's that has it; none if it is the parent's own.
    pub task: Option<usize>,
    /// Its offset in the updates of that task.
    pub start: usize,
    pub place: Vec<u32>,
}

/// A front. Columns and rows are counted in bodies; the first rows are those of the columns.
pub(super) struct Front {
    /// The first body, and its place among those of the task.
    pub body: usize,
    pub first: usize,
    pub columns: usize,
    /// The places, among the bodies of the task, of the rows below.
    pub rows: Vec<u32>,
    /// The place in the front of the larger body of each link of the columns.
    pub links: Vec<u32>,
    pub children: Vec<Child>,
    /// Where its columns begin in the factor of the task.
    pub panel: usize,
    /// Where its update is computed, and where it is moved when those of the children are not needed any more.
    pub computed: usize,
    pub update: usize,
}

impl Front {
    /// The numbers of its columns and of its rows below, in unknowns.
    pub fn shape<const D: usize>(&self) -> [usize; 2] {
        [D * self.columns, D * self.rows.len()]
    }

    /// Fills the columns: the matrix and the children's updates.
    pub fn assemble<'a, const D: usize>(
        &self,
        panel: &mut [f64],
        blocks: Blocks<'_, D>,
        update_of: &impl Fn(&Child) -> &'a [f64],
    ) {
        let height = D * (self.columns + self.rows.len());
        panel.fill(0.0);
        let mut links = self.links.iter();
        for column in 0..self.columns {
            let body = self.body + column;
            let mut put = |place: usize, block: &[[f64; D]; D]| {
                for (k, numbers) in block.iter().enumerate() {
                    let start = (D * column + k) * height + D * place;
                    panel[start..start + D].copy_from_slice(numbers);
                }
            };
            put(column, &blocks.own[body]);
            let linked = &blocks.linked[blocks.first_link[body] as usize..blocks.first_link[body + 1] as usize];
            for (block, place) in linked.iter().zip(&mut links) {
                put(*place as usize, block);
            }
        }
        for child in &self.children {
            let own = child.place.partition_point(|place| (*place as usize) < self.columns);
            add::<D>(update_of(child), &child.place, 0..own, panel, 0, height);
        }
    }

    /// Factorizes the columns; says whether all pivots are positive.
    pub fn factorize<const D: usize>(&self, panel: &mut [f64], memory: &mut MemBuffer) -> bool {
        let [columns, below] = self.shape::<D>();
        let panel = MatMut::from_column_major_slice_mut(panel, columns + below, columns);
        let (mut own, mut rest) = panel.split_at_row_mut(columns);
        let regularization = LltRegularization::default();
        let stack = MemStack::new(memory);
        if cholesky_in_place(own.rb_mut(), regularization, Par::Seq, stack, Spec::default()).is_err() {
            return false;
        }
        if below > 0 {
            solve_lower_triangular_in_place(own.rb(), rest.rb_mut().transpose_mut(), Par::Seq);
        }
        true
    }

    /// Computes the update of the rows below: the children's, less what the columns contribute.
    pub fn update<'a, const D: usize>(
        &self,
        panel: &[f64],
        update: &mut [f64],
        update_of: &impl Fn(&Child) -> &'a [f64],
    ) {
        let [columns, below] = self.shape::<D>();
        if below == 0 {
            return;
        }
        let (_, rest) = MatRef::from_column_major_slice(panel, columns + below, columns).split_at_row(columns);
        let whole = BlockStructure::Rectangular;
        triangular::matmul(
            MatMut::from_column_major_slice_mut(update, below, below),
            BlockStructure::TriangularLower,
            Accum::Replace,
            rest,
            whole,
            rest.transpose(),
            whole,
            -1.0,
            Par::Seq,
        );
        for child in &self.children {
            let own = child.place.partition_point(|place| (*place as usize) < self.columns);
            add::<D>(update_of(child), &child.place, own..child.place.len(), update, self.columns, below);
        }
    }
}

/// Adds some columns of a child's update to a matrix of `height` rows whose first row and column is that of the body at
/// the place `from`. Only entries on and below the diagonal count.
fn add<const D: usize>(
    update: &[f64],
    place: &[u32],
    columns: std::ops::Range<usize>,
    out: &mut [f64],
    from: usize,
    height: usize,
) {
    for column in columns {
        let to = place[column] as usize - from;
        for k in 0..D {
            let source = update[(D * column + k) * D * place.len()..][..D * place.len()].as_chunks::<D>().0;
            let out = out[(D * to + k) * height..][..height].as_chunks_mut::<D>().0;
            for (numbers, place) in source[column..].iter().zip(&place[column..]) {
                for (out, number) in out[*place as usize - from].iter_mut().zip(numbers) {
                    *out += number;
                }
            }
        }
    }
}
