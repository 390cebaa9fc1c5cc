//! Figures of the steps for the page's curves, thinned as they grow.

use relcp::step::StepReport;
use serde::Serialize;

/// The most points; then each two become one. A plot has some hundred pixels.
const MOST: usize = 2_400;

/// A point: the last of its steps, with the largest figures of all of them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Point {
    pub step: u64,
    pub time: f64,
    pub bodies: usize,
    pub constraints: usize,
    pub recursions: u32,
    pub max_overlap: f64,
}

/// The figures of a run.
#[derive(Clone, Debug, Default)]
pub(super) struct Curves {
    points: Vec<Point>,
    /// Steps of a point, and of the last one so far.
    each: u64,
    in_last: u64,
}

impl Point {
    fn of(report: &StepReport) -> Point {
        let StepReport { step, time, bodies, constraints, recursions, max_overlap, .. } = *report;
        Point { step, time, bodies, constraints, recursions, max_overlap }
    }

    fn with(self, next: Point) -> Point {
        Point {
            constraints: self.constraints.max(next.constraints),
            recursions: self.recursions.max(next.recursions),
            max_overlap: self.max_overlap.max(next.max_overlap),
            ..next
        }
    }
}

impl Curves {
    /// Adds a step.
    pub fn push(&mut self, report: &StepReport) {
        self.add(Point::of(report));
    }

    fn add(&mut self, point: Point) {
        match self.points.last_mut().filter(|_| self.in_last < self.each) {
            Some(last) => *last = last.with(point),
            None => {
                self.points.push(point);
                self.in_last = 0;
            }
        }
        self.in_last += 1;
        if self.points.len() > MOST {
            // The last of an odd number stands alone.
            let two_as_one = |two: &[Point]| two.iter().copied().reduce(Point::with);
            self.points = self.points.chunks(2).filter_map(two_as_one).collect();
            self.each = 2 * self.each.max(1);
        }
    }

    /// All points.
    pub fn points(&self) -> &[Point] {
        &self.points
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_thinned_and_keep_the_largest_figures_of_all_steps() {
        let mut curves = Curves::default();
        let steps = 20_011;
        for step in 1..=steps {
            let max_overlap = if step == 7_777 { 1.0 } else { 0.1 };
            let (time, recursions) = (step as f64, u32::from(step == 19_000));
            curves.add(Point { step, time, bodies: step as usize, constraints: 3, recursions, max_overlap });
        }
        let points = curves.points();
        assert!((MOST / 2..=MOST).contains(&points.len()), "{}", points.len());
        assert_eq!(points.last().map(|point| point.step), Some(steps));
        assert!(points.windows(2).all(|two| two[0].step < two[1].step));
        let wide = |point: &&Point| point.max_overlap == 1.0;
        let found: Vec<_> = points.iter().filter(wide).collect();
        assert!(found.len() == 1 && (7_777..7_777 + 32).contains(&found[0].step), "{found:?}");
        assert_eq!(points.iter().map(|point| point.recursions).sum::<u32>(), 1);
    }
}
