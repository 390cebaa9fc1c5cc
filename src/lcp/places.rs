//! Where the bodies of a problem stand, for the order of its rows.

/// Places of bodies that are near each other, in blocks. Rows stand in the order of their smaller places, and what the
/// rows of a block come to is one part of a sum.
#[derive(Clone, Debug, Default)]
pub(crate) struct Places {
    /// The place of each body; surfaces of walls come last, in no block.
    pub place: Vec<u32>,
    /// The place at which each block begins, and where the last one ends: as many as a power of two.
    pub blocks: Vec<u32>,
}
