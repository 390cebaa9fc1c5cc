//! An LCP on the device.

use crate::gpu::{Buffer, Gpu, GpuError, Precision};
use crate::lcp::Problem;
use crate::lcp::incidence::Incidence;
use crate::lcp::pair_blocks::{self, sorted};

/// One LCP on the device: as [`Problem`], with the rows of a pair together.
///
/// All buffers belong to the caller and have room for at least what is said; what is beyond is not looked at.
pub struct DeviceProblem {
    /// How many bodies there are.
    pub bodies: u64,
    /// How many rows.
    pub rows: u64,
    /// How many slots for pairs, empty ones too.
    pub pairs: u64,
    /// Three unknowns a body (x, y, turn) rather than six.
    pub planar: bool,
    /// The two bodies of each row: two words. A second one from `bodies` on has no mobility: its block is zero, and it
    /// is in no list.
    pub pair: Buffer,
    /// The two blocks of each row of `J`: vectors of four numbers, planar one a block (x, y, turn, 0), else two
    /// (linear, angular).
    pub jacobian: Buffer,
    /// `g` at `gamma = 0`, a number a row.
    pub q: Buffer,
    /// Where the rows of each slot begin, and their end: one word a slot and one more. The slots' rows follow each
    /// other and are all.
    pub block_start: Buffer,
    /// Where the list of each body begins in `incidence`, and their end.
    pub incidence_start: Buffer,
    /// `2 row + side` for each row of a body, ascending; `side` is the body's place in the row's pair. Two words a row
    /// at most.
    pub incidence: Buffer,
    /// The multipliers, a number a row: the start (what is not finite or negative counts as zero), then the result.
    pub gamma: Buffer,
    /// `J^T gamma` of the result: a vector of four numbers a body, planar, else two.
    pub velocity: Buffer,
}

impl DeviceProblem {
    /// Brings a problem to the device, and a start, of which missing numbers are zero. Returns also the order of rows
    /// there: the place in `problem` of each row.
    ///
    /// # Errors
    /// [`GpuError::Limit`], [`GpuError::OutOfMemory`], [`GpuError::NoF64`].
    pub fn upload<const D: usize>(
        gpu: &Gpu,
        precision: Precision,
        problem: &Problem<D>,
        gamma: &[f64],
    ) -> Result<(Self, Vec<u32>), GpuError> {
        gpu.check(precision)?;
        let planar = D == 3;
        let mut order = Vec::new();
        pair_blocks::order(&problem.pair, &mut order);
        let pair: Vec<[u32; 2]> = order.iter().map(|row| problem.pair[*row as usize]).collect();
        let mut block_start = vec![0];
        for block in pair.chunk_by(|p, q| sorted(*p) == sorted(*q)) {
            block_start.push(block_start.last().map_or(0, |start| start + block.len() as u32));
        }
        let mut incidence = Incidence::default();
        incidence.rebuild(problem.bodies, &pair);
        let blocks = order.iter().flat_map(|row| &problem.jacobian[*row as usize]);
        // Three or six numbers, each three with a zero after them.
        let padded = blocks.flat_map(|block| block.chunks(3).flat_map(|part| [part[0], part[1], part[2], 0.0]));
        let width = if planar { 1 } else { 2 };
        let words =
            |label, element: usize, words: &[u32]| Buffer::with(gpu, label, 4 * element, bytemuck::cast_slice(words));
        let reals =
            |label, width, numbers: &mut dyn Iterator<Item = f64>| Buffer::reals(gpu, label, precision, width, numbers);
        let start = |row: &u32| gamma.get(*row as usize).copied().unwrap_or(0.0);
        let device = DeviceProblem {
            bodies: problem.bodies as u64,
            rows: order.len() as u64,
            pairs: block_start.len() as u64 - 1,
            planar,
            pair: words("pair", 2, pair.as_flattened())?,
            jacobian: reals("jacobian", 4, &mut padded.into_iter())?,
            q: reals("q", 1, &mut order.iter().map(|row| problem.q[*row as usize]))?,
            block_start: words("block-start", 1, &block_start)?,
            incidence_start: words("incidence-start", 1, &incidence.start)?,
            incidence: words("incidence", 1, &incidence.entries)?,
            gamma: reals("gamma", 1, &mut order.iter().map(start))?,
            velocity: Buffer::new(gpu, "velocity", 4 * precision.bytes(), (width * problem.bodies) as u64)?,
        };
        Ok((device, order))
    }

    /// Reads `gamma` back, into the order of rows that the problem was uploaded from.
    ///
    /// # Errors
    /// The fault that the device reported.
    pub fn download_gamma(&self, gpu: &Gpu, precision: Precision, order: &[u32]) -> Result<Vec<f64>, GpuError> {
        let bytes = self.rows * precision.bytes() as u64;
        let read = gpu.record().read(&[(&self.gamma, 0..bytes)])?;
        let mut gamma = vec![0.0; order.len()];
        for (row, x) in order.iter().zip(precision.decode(&read[0])) {
            gamma[*row as usize] = x;
        }
        Ok(gamma)
    }

    /// Reads `velocity` back: three numbers a body, planar, else six.
    ///
    /// # Errors
    /// The fault that the device reported.
    pub fn download_velocity<const D: usize>(
        &self,
        gpu: &Gpu,
        precision: Precision,
    ) -> Result<Vec<[f64; D]>, GpuError> {
        let width = if self.planar { 4 } else { 8 };
        let bytes = self.bodies * width * precision.bytes() as u64;
        let read = gpu.record().read(&[(&self.velocity, 0..bytes)])?;
        let numbers = precision.decode(&read[0]);
        let body = |block: &[f64]| std::array::from_fn(|k| block[k / 3 * 4 + k % 3]);
        Ok(numbers.chunks(width as usize).map(body).collect())
    }
}
