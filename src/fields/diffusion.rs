//! Diffusion by implicit Euler steps along one axis after the other (G. I. Marchuk, *Splitting and alternating
//! direction methods*, Handbook of Numerical Analysis 1 (1990)): stable at any step, of first order in it and of second
//! order in the spacing; no concentration becomes negative, and within closed borders the amount stays.

use super::grid::Grid;
use super::settings::Border;
use rayon::prelude::*;

/// Fewer lines than this run on one thread.
const LEAST_LINES_A_TASK: usize = 64;

/// The ends of the lines along an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Ends {
    /// Each line is a ring.
    Periodic,
    /// Its low and its high border.
    Borders([Border; 2]),
}

/// A step along one axis: `strength` is the diffusion coefficient times the step over the squared spacing. `held` are
/// the cells that are held, none where it is empty.
pub(super) fn diffuse(
    (grid, held): (&Grid, &[Option<f64>]),
    values: &mut [f64],
    axis: usize,
    strength: f64,
    ends: Ends,
) {
    let count = grid.cells[axis] as usize;
    let has_value = matches!(ends, Ends::Borders(both) if both.iter().any(|end| matches!(end, Border::Value(_))));
    if strength == 0.0 || (count == 1 && !has_value) {
        return;
    }
    let stride = grid.strides()[axis];
    let solver = Tridiagonal::new(count, strength, ends);
    // The first cells of all lines: those whose index along the axis is zero.
    let lines: Vec<usize> = (0..grid.len()).filter(|cell| (cell / stride).is_multiple_of(count)).collect();
    let solved: Vec<Vec<f64>> = lines
        .par_iter()
        .with_min_len(LEAST_LINES_A_TASK)
        .map(|first| {
            let mut line: Vec<f64> = (0..count).map(|i| values[first + i * stride]).collect();
            let held = || held.iter().skip(*first).step_by(stride).take(count).copied();
            if held().flatten().next().is_some() {
                solve_held(&mut line, &held().collect::<Vec<_>>(), strength, ends);
            } else {
                solver.solve(&mut line);
            }
            line
        })
        .collect();
    for (first, line) in lines.into_iter().zip(solved) {
        for (i, value) in line.into_iter().enumerate() {
            values[first + i * stride] = value;
        }
    }
}

/// `(1 + 2 s) c_i - s c_(i-1) - s c_(i+1) = b_i`, with what the ends make of the first and last equation, eliminated
/// once for all lines (L. H. Thomas, 1949). A ring is a matrix of this kind and one of rank one (J. Sherman, W. J.
/// Morrison, Ann. Math. Stat. 21, 124 (1950)).
struct Tridiagonal {
    strength: f64,
    /// The factor of the next unknown, and the inverse of the pivot, of each equation.
    next: Vec<f64>,
    inverse: Vec<f64>,
    /// What values at the borders add to the right side of the first and last equation.
    added: [f64; 2],
    /// The solution for the matrix of rank one of a ring, and the factors of its first and last unknown.
    ring: Option<(Vec<f64>, [f64; 2])>,
}

impl Tridiagonal {
    fn new(count: usize, strength: f64, ends: Ends) -> Self {
        let mut diagonal = vec![1.0 + 2.0 * strength; count];
        let mut added = [0.0; 2];
        let mut of_ring = None;
        match ends {
            Ends::Borders(both) => {
                for (end, cell) in [0, count - 1].into_iter().enumerate() {
                    match both[end] {
                        Border::Closed => diagonal[cell] -= strength,
                        // The border is half a cell away.
                        Border::Value(value) => {
                            diagonal[cell] += strength;
                            added[end] = 2.0 * strength * value;
                        }
                    }
                }
            }
            // The neighbour of each of two cells is the other on both sides, that of a single one itself.
            Ends::Periodic if count == 1 => diagonal[0] = 1.0,
            Ends::Periodic => {
                let first = -diagonal[0];
                diagonal[0] -= first;
                diagonal[count - 1] -= strength * strength / first;
                of_ring = Some(first);
            }
        }
        let mut own = Tridiagonal { strength, next: Vec::new(), inverse: Vec::new(), added, ring: None };
        for pivot in diagonal {
            let before = own.next.last().map_or(0.0, |next| strength * next);
            let inverse = 1.0 / (pivot - before);
            own.inverse.push(inverse);
            own.next.push(strength * inverse);
        }
        if let Some(first) = of_ring {
            let mut column = vec![0.0; count];
            column[0] = first;
            column[count - 1] = -strength;
            own.eliminate(&mut column);
            own.ring = Some((column, [1.0, -strength / first]));
        }
        own
    }

    fn eliminate(&self, line: &mut [f64]) {
        let mut before = 0.0;
        for (value, inverse) in line.iter_mut().zip(&self.inverse) {
            *value = (*value + self.strength * before) * inverse;
            before = *value;
        }
        let mut after = 0.0;
        for (value, next) in line.iter_mut().zip(&self.next).rev() {
            *value += next * after;
            after = *value;
        }
    }

    fn solve(&self, line: &mut [f64]) {
        let last = line.len() - 1;
        line[0] += self.added[0];
        line[last] += self.added[1];
        self.eliminate(line);
        if let Some((column, [low, high])) = &self.ring {
            let of = |line: &[f64]| low * line[0] + high * line[last];
            let part = of(line) / (1.0 + of(column));
            line.iter_mut().zip(column).for_each(|(value, column)| *value -= part * column);
        }
    }
}

/// The same equations where those of held cells are `c_i` = the value that they are held at. A ring is cut at a held
/// cell.
fn solve_held(line: &mut [f64], held: &[Option<f64>], strength: f64, ends: Ends) {
    let count = line.len();
    let Some(first) = held.iter().position(Option::is_some) else { return };
    let start = if ends == Ends::Periodic { first } else { 0 };
    let cell = |i: usize| (start + i) % count;
    // A border's part of the diagonal and of the right side.
    let at_border = |low: bool| match ends {
        Ends::Periodic => (0.0, strength * held[first].unwrap_or_default()),
        Ends::Borders(both) => match both[usize::from(!low)] {
            Border::Closed => (-strength, 0.0),
            Border::Value(value) => (strength, 2.0 * strength * value),
        },
    };
    let (mut next, mut before) = (Vec::with_capacity(count), 0.0);
    for i in 0..count {
        let at = cell(i);
        if let Some(value) = held[at] {
            (line[at], before) = (value, value);
            next.push(0.0);
            continue;
        }
        let (mut diagonal, mut right) = (1.0 + 2.0 * strength, line[at]);
        for low in [true, false] {
            if i == if low { 0 } else { count - 1 } {
                let (more, added) = at_border(low);
                (diagonal, right) = (diagonal + more, right + added);
            }
        }
        let inverse = 1.0 / (diagonal - strength * next.last().copied().unwrap_or(0.0));
        line[at] = (right + strength * before) * inverse;
        before = line[at];
        next.push(strength * inverse);
    }
    let mut after = 0.0;
    for i in (0..count).rev() {
        // What is beyond the last cell is in its right side.
        line[cell(i)] += if i + 1 < count { next[i] * after } else { 0.0 };
        after = line[cell(i)];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    /// The equations are met, for all kinds of ends.
    #[test]
    fn a_solved_line_meets_its_equations() {
        let ends = [
            Ends::Periodic,
            Ends::Borders([Border::Closed; 2]),
            Ends::Borders([Border::Value(2.0), Border::Closed]),
            Ends::Borders([Border::Value(0.5), Border::Value(3.0)]),
        ];
        for end in ends {
            for count in [1, 2, 3, 17] {
                let (s, right) = (1.7, (0..count).map(|i| (1.0 + i as f64).sqrt()).collect::<Vec<_>>());
                let mut line = right.clone();
                Tridiagonal::new(count, s, end).solve(&mut line);
                let neighbour = |i: usize, side: usize| match (end, i + side) {
                    (Ends::Periodic, at) => line[(at + count - 1) % count],
                    (Ends::Borders(both), 0) => at_border(both[0], line[i]),
                    (Ends::Borders(both), at) if at == count + 1 => at_border(both[1], line[i]),
                    (_, at) => line[at - 1],
                };
                for i in 0..count {
                    let left = line[i] + s * (2.0 * line[i] - neighbour(i, 0) - neighbour(i, 2));
                    assert!((left - right[i]).abs() < 1e-12, "{end:?} {count} {i}: {left} {}", right[i]);
                }
            }
        }
    }

    /// The same beside cells that are held.
    #[test]
    fn a_line_with_held_cells_meets_its_equations() {
        let ends = [Ends::Periodic, Ends::Borders([Border::Closed, Border::Value(2.0)])];
        for end in ends {
            for (count, at) in [(1, 0), (2, 1), (3, 0), (17, 0), (17, 5), (17, 16)] {
                let (s, right) = (1.7, (0..count).map(|i| (1.0 + i as f64).sqrt()).collect::<Vec<_>>());
                let mut held = vec![None; count];
                (held[at], held[(at + 2) % count]) = (Some(7.0), Some(7.0));
                let mut line = right.clone();
                solve_held(&mut line, &held, s, end);
                for i in 0..count {
                    let neighbour = |side: usize| match (end, i + side) {
                        (Ends::Periodic, at) => line[(at + count - 1) % count],
                        (Ends::Borders(both), 0) => at_border(both[0], line[i]),
                        (Ends::Borders(both), at) if at == count + 1 => at_border(both[1], line[i]),
                        (_, at) => line[at - 1],
                    };
                    let left = line[i] + s * (2.0 * line[i] - neighbour(0) - neighbour(2));
                    let (left, right) = if held[i].is_some() { (line[i], 7.0) } else { (left, right[i]) };
                    assert!((left - right).abs() < 1e-12, "{end:?} {count} {i}: {left} {right}");
                }
            }
        }
    }

    /// The value in a cell beyond a border.
    fn at_border(border: Border, value: f64) -> f64 {
        match border {
            Border::Closed => value,
            Border::Value(at) => 2.0 * at - value,
        }
    }

    /// How far a wave on a grid is from `exp(-D k^2 t)` at `t` = 0.1.
    fn error(count: u32, steps: u32, ends: Ends) -> f64 {
        let (spacing, dt) = (1.0 / f64::from(count), 0.1 / f64::from(steps));
        let grid = Grid { cells: [1, count, 1], spacing, center: [0.0; 3] };
        let (wave, rate): (Box<dyn Fn(f64) -> f64>, f64) = match ends {
            Ends::Periodic => (Box::new(|y: f64| (TAU * y).cos()), TAU * TAU),
            Ends::Borders([Border::Closed, _]) => (Box::new(|y: f64| (PI * (y + 0.5)).cos()), PI * PI),
            Ends::Borders(_) => (Box::new(|y: f64| (PI * (y + 0.5)).sin()), PI * PI),
        };
        let at = |cell: usize| wave(grid.center_of(cell)[1]);
        let mut values: Vec<f64> = (0..grid.len()).map(at).collect();
        for _ in 0..steps {
            diffuse((&grid, &[]), &mut values, 1, dt / (spacing * spacing), ends);
        }
        let left = (-rate * 0.1).exp();
        (0..grid.len()).map(|cell| (values[cell] - left * at(cell)).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn waves_decay_as_they_do_to_first_order_in_time_and_second_in_space() {
        let closed = Ends::Borders([Border::Closed; 2]);
        for ends in [Ends::Periodic, closed, Ends::Borders([Border::Value(0.0); 2])] {
            let of_time = error(400, 20, ends) / error(400, 40, ends);
            let of_space = error(8, 100_000, ends) / error(16, 100_000, ends);
            println!("{ends:?}: half of the step {of_time:.3}, half of the spacing {of_space:.3}");
            assert!((of_time - 2.0).abs() < 0.15 && (of_space - 4.0).abs() < 0.3, "{ends:?} {of_time} {of_space}");
        }
    }
}
