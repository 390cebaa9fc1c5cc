//! The positions of a problem's bodies in the order of its rows.

/// Positions of bodies, in blocks of near bodies. Rows are ordered by their smaller position, and the rows of a block
/// form one chunk of a sum.
#[derive(Clone, Debug, Default)]
pub(crate) struct Places {
    /// The position of each body; surfaces of walls come last, in no block.
    pub place: Vec<u32>,
    /// The first position of each block, and the end. The number of blocks is a power of two.
    pub blocks: Vec<u32>,
}
