//! Read-backs of the rows, for stored LCPs, diagnosis and tests.

use super::Device;
use super::hosted::HostedRows;
use crate::constraint::FEATURE_OF_SURFACES;
use crate::freedom::{PLANAR, SPATIAL};
use crate::gpu::{Buffer, GpuError};
use crate::lcp::Problem;
use crate::separation::branches::branch_in_place;

impl Device {
    /// The present LCP and its multipliers, read back for diagnosis and tests. The rows are sorted by pair in the
    /// device's order.
    ///
    /// # Errors
    /// An error of the device.
    ///
    /// # Panics
    /// If `D` is not the scene's number of unknowns.
    pub fn lcp<const D: usize>(&self) -> Result<(Problem<D>, Vec<f64>), GpuError> {
        assert_eq!(self.setup.planar, D == PLANAR, "the scene has another number of unknowns");
        let problem = &self.rows.problem;
        let whole = |buffer: &Buffer| 0..problem.rows * buffer.element() as u64;
        let read = self.gpu.record().read(&[
            (&problem.pair, whole(&problem.pair)),
            (&problem.jacobian, whole(&problem.jacobian)),
            (&problem.q, whole(&problem.q)),
            (&problem.gamma, whole(&problem.gamma)),
        ])?;
        let [blocks, q, gamma] = [1, 2, 3].map(|i| self.setup.precision.decode(&read[i]));
        // A block is one vector of four in the plane, and two in space, the last number of each unused.
        let width = if D == PLANAR { 4 } else { 8 };
        let block = |row: usize, side: usize| -> [f64; D] {
            std::array::from_fn(|k| blocks[(2 * row + side) * width + k / 3 * 4 + k % 3])
        };
        let jacobian = (0..problem.rows as usize).map(|row| [block(row, 0), block(row, 1)]).collect();
        let pair = bytemuck::pod_collect_to_vec(&read[0]);
        // Surfaces come after all bodies.
        let bodies = self.start.bodies as usize + self.setup.walls.len();
        Ok((Problem { bodies, pair, jacobian, q, ..Problem::default() }, gamma))
    }

    /// The present problem with the rows of friction, which the host has, and its multipliers; `None` without friction
    /// and restitution. In the plane the blocks of `J` have three numbers.
    pub fn lcp_on_host(&self) -> Option<(Problem<SPATIAL>, Vec<f64>)> {
        self.hosted.as_ref().map(HostedRows::lcp)
    }

    /// The contact of its pair to which each row belongs, read back for tests; zero for places at surfaces and for rows
    /// that are not by branches.
    ///
    /// # Errors
    /// An error of the device.
    pub fn features(&self) -> Result<Vec<u32>, GpuError> {
        match &self.rows.branches {
            Some(branches) => {
                let places = branches.read(&self.gpu, self.rows.problem.rows)?;
                Ok(places.into_iter().map(branch_in_place).collect())
            }
            None => Ok(vec![FEATURE_OF_SURFACES; self.rows.problem.rows as usize]),
        }
    }

    /// Each body's rows, `2 row + side`, read back for tests.
    ///
    /// # Errors
    /// An error of the device.
    pub fn incidence(&self) -> Result<Vec<Vec<u32>>, GpuError> {
        let problem = &self.rows.problem;
        let read = self.gpu.record().read(&[
            (&problem.incidence_start, 0..4 * (self.start.bodies + 1)),
            (&problem.incidence, 0..8 * problem.rows),
        ])?;
        let [start, entries]: [Vec<u32>; 2] = [0, 1].map(|i| bytemuck::pod_collect_to_vec(&read[i]));
        Ok(start.windows(2).map(|w| entries[w[0] as usize..w[1] as usize].to_vec()).collect())
    }
}
