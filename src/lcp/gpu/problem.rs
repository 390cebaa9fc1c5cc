//! An LCP on the device.

use crate::gpu::{Buffer, Gpu, GpuError, Precision, arrays};
use crate::lcp::Problem;
use crate::lcp::incidence::Incidence;
use crate::lcp::pair_blocks::{self, sorted};

/// One LCP on the device: as [`Problem`], with the rows of each pair together.
///
/// The caller owns the buffers. Each has room for at least the elements given here; kernels ignore the rest.
pub struct DeviceProblem {
    /// The number of bodies.
    pub bodies: u64,
    /// The number of rows.
    pub rows: u64,
    /// The number of slots for pairs, empty slots included.
    pub pairs: u64,
    /// Whether a body has three unknowns (x, y, turn) instead of six.
    pub planar: bool,
    /// The two bodies of each row: two words. A second number of at least `bodies` is a surface without mobility: its
    /// block is zero, and it is in no list.
    pub pair: Buffer,
    /// The two blocks of each row of `J`, in vectors of four numbers: one vector per block in the plane (x, y,
    /// rotation, 0), otherwise two (linear, angular).
    pub jacobian: Buffer,
    /// The offset `q` of each row: `g` at `gamma = 0`.
    pub q: Buffer,
    /// The first row of each slot, and the number of rows at the end: one word per slot plus one. Every row belongs to
    /// a slot, and the rows are in the order of the slots.
    pub block_start: Buffer,
    /// The first entry of each body's list in `incidence`, and the number of entries at the end.
    pub incidence_start: Buffer,
    /// `2 row + side` for each row of a body, ascending; `side` is the body's position in the row's pair. At most two
    /// words per row.
    pub incidence: Buffer,
    /// The multiplier of each row: before the solve the warm start, in which negative and infinite numbers count as
    /// zero; after it the result.
    pub gamma: Buffer,
    /// `J^T gamma` of the result: one vector of four numbers per body in the plane, otherwise two.
    pub velocity: Buffer,
}

arrays! { DeviceProblem {
    pair, row_pairs: pair, jacobian, q, offset: q, block_start, row_start: block_start, incidence_start, incidence,
    gamma, velocity, velocities: velocity,
} }

impl DeviceProblem {
    /// The stride from one vector of rows to the next.
    pub(super) fn stride(&self) -> u64 {
        self.rows.next_multiple_of(64)
    }

    /// Uploads a problem and a warm start, whose missing numbers are zero. Also returns the order of the rows on the
    /// device: for each row its index in `problem`.
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
        // Three or six numbers, with a zero after each three.
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

    /// Reads `gamma` back, in the order of rows of the uploaded problem.
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

    /// Reads `velocity` back: three numbers per body in the plane, otherwise six.
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
