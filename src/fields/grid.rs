//! The grid of a field, and which of its cells a body lies in.

use glam::{DQuat, DVec3};

/// Points on the axis of a body are no farther apart than this part of a grid cell.
const POINTS_PER_CELL: f64 = 2.0;

/// Most points on the axis of a body: of a body that is far longer than a grid cell.
const MOST_POINTS: f64 = 64.0;

/// A grid of cubic cells.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "files", derive(serde::Serialize, serde::Deserialize))]
pub struct Grid {
    /// The numbers of cells along x, y and z.
    pub cells: [u32; 3],
    /// The edge of a cell.
    pub spacing: f64,
    /// The middle of the grid.
    pub center: [f64; 3],
}

/// A cell of a grid, by its index, and the part of a body in it.
pub(super) type Share = (usize, f64);

impl Grid {
    /// The number of cells.
    pub fn len(&self) -> usize {
        self.cells.iter().map(|count| *count as usize).product()
    }

    /// Whether it has no cell.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The distances in memory of neighbours along the axes: x is fastest.
    pub(super) fn strides(&self) -> [usize; 3] {
        let [x, y, _] = self.cells.map(|count| count as usize);
        [1, x, x * y]
    }

    /// The centre of a cell.
    pub fn center_of(&self, cell: usize) -> [f64; 3] {
        let strides = self.strides();
        std::array::from_fn(|k| {
            let index = cell / strides[k] % self.cells[k] as usize;
            self.center[k] + self.spacing * (index as f64 + 0.5 - 0.5 * f64::from(self.cells[k]))
        })
    }

    /// The cells about a point, whose parts sum up to one, linear in the distance from the centres of cells. Along a
    /// periodic axis they go on at the other side; along others the cell at the border counts beyond its centre.
    fn about(&self, point: DVec3, periodic: [bool; 3], mut see: impl FnMut(Share)) {
        let strides = self.strides();
        let along: [[Share; 2]; 3] = std::array::from_fn(|k| {
            let count = self.cells[k] as usize;
            let place = (point[k] - self.center[k]) / self.spacing + 0.5 * count as f64 - 0.5;
            let most = count as f64 - 1.0;
            let place = if periodic[k] { place.rem_euclid(count as f64) } else { place.clamp(0.0, most) };
            let low = (place.floor() as usize).min(count - 1);
            let part = place - low as f64;
            let high = if low + 1 < count {
                low + 1
            } else if periodic[k] {
                0
            } else {
                low
            };
            [(strides[k] * low, 1.0 - part), (strides[k] * high, part)]
        });
        for (z, of_z) in along[2] {
            for (y, of_y) in along[1] {
                for (x, of_x) in along[0] {
                    let part = of_x * of_y * of_z;
                    if part > 0.0 {
                        see((x + y + z, part));
                    }
                }
            }
        }
    }

    /// The concentration at a point, linear between the centres of cells.
    #[cfg(feature = "files")]
    pub(crate) fn at(&self, values: &[f64], point: DVec3, periodic: [bool; 3]) -> f64 {
        let mut sum = 0.0;
        self.about(point, periodic, |(cell, part)| sum += part * values[cell]);
        sum
    }

    /// Whether a point is in the grid, along x and y.
    #[cfg(feature = "files")]
    pub(crate) fn holds_in_plane(&self, point: DVec3) -> bool {
        let reach = |k: usize| 0.5 * self.spacing * f64::from(self.cells[k]);
        (0..2).all(|k| (point[k] - self.center[k]).abs() <= reach(k))
    }

    /// The cells that a body is in, with the parts of it, which sum up to one: those about points on this length of its
    /// axis that stand for equal parts of it.
    pub(super) fn shares(
        &self,
        (length, position, orientation): (f64, DVec3, DQuat),
        periodic: [bool; 3],
        mut see: impl FnMut(Share),
    ) {
        let points = (POINTS_PER_CELL * length / self.spacing).ceil().clamp(1.0, MOST_POINTS);
        let axis = orientation * (length * DVec3::Z);
        for i in 0..points as usize {
            let along = (i as f64 + 0.5) / points - 0.5;
            self.about(position + along * axis, periodic, |(cell, part)| see((cell, part / points)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: Grid = Grid { cells: [4, 3, 1], spacing: 0.5, center: [1.0, 0.0, 0.0] };

    fn at(point: DVec3, periodic: [bool; 3]) -> Vec<f64> {
        let mut parts = vec![0.0; GRID.len()];
        GRID.about(point, periodic, |(cell, part)| parts[cell] += part);
        parts
    }

    #[test]
    fn a_point_at_a_cells_centre_is_in_that_cell_alone() {
        for cell in 0..GRID.len() {
            let parts = at(DVec3::from(GRID.center_of(cell)), [false; 3]);
            assert!((parts[cell] - 1.0).abs() < 1e-12, "{cell}: {parts:?}");
        }
    }

    #[test]
    fn parts_sum_up_to_one_inside_and_outside_and_interpolate_linearly() {
        for (x, y, periodic) in [(0.9, 0.2, false), (-7.0, 9.0, false), (2.3, -0.6, true), (17.77, -3.21, true)] {
            let parts = at(DVec3::new(x, y, 0.3), [periodic; 3]);
            assert!((parts.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        }
        // Where all cells' centres are around it, a linear function is met.
        let point = DVec3::new(1.1, -0.2, 0.0);
        let parts = at(point, [false; 3]);
        let place = |k: usize| parts.iter().enumerate().map(|(cell, part)| part * GRID.center_of(cell)[k]).sum::<f64>();
        assert!((place(0) - point.x).abs() < 1e-12 && (place(1) - point.y).abs() < 1e-12);
    }

    #[test]
    fn a_long_rod_is_in_all_cells_along_it() {
        let turned = DQuat::from_rotation_arc(DVec3::Z, DVec3::X);
        let mut parts = vec![0.0; GRID.len()];
        GRID.shares((2.0, DVec3::new(1.0, 0.0, 0.0), turned), [false; 3], |(cell, part)| parts[cell] += part);
        assert!(parts[4..8].iter().all(|part| (part - 0.25).abs() < 0.04), "{parts:?}");
        assert!((parts[4..8].iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }
}
