//! The number of rows of states as a function of the distance within which rows are made, for ReLCP and for
//! sub-spheres. From it and the paper's numbers of rows follows a distance that the paper does not give.
//!
//! The rows are counted in states that ReLCP reached: one row for each pair of surfaces, or of sub-spheres, that is
//! nearer than the distance. Further rows of a recursion and rows for the free motion do not count.

use super::target::{Target, WITHIN, is_near};
use relcp::bodies::Bodies;
use relcp::internals::constraint::{RowSource, RowSourceError, sub_sphere_separations};
use relcp::step::contacts;
use serde::Serialize;
use std::fmt::Write as _;

/// The distances that are counted for the table, in thicknesses of a body.
const SHOWN: [f64; 7] = [0.1, 0.2, 0.5, 1.0, 1.5, 2.0, 2.5];

/// The distance that fits the paper best is one of the multiples of this, to the last of those shown.
const PITCH: f64 = 0.05;

/// A line of the table.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Count {
    /// The distance within which rows are made, in thicknesses.
    pub cutoff: f64,
    /// Sub-spheres of a body.
    pub spheres: u32,
    /// Rows of ReLCP a body.
    pub relcp_a_body: f64,
    /// Rows of sub-spheres over those.
    pub relative: f64,
    /// The same in the paper.
    pub paper: f64,
}

/// Separations in states, each method's in ascending order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Census {
    bodies: usize,
    thickness: f64,
    surfaces: Vec<f64>,
    /// By the number of sub-spheres.
    spheres: Vec<(u32, Vec<f64>)>,
}

impl Census {
    /// Adds a state, with these numbers of sub-spheres, the same at every call.
    ///
    /// # Errors
    /// [`RowSourceError`] for bodies that have no such sub-spheres.
    pub fn add(&mut self, bodies: &Bodies, counts: &[u32]) -> Result<(), RowSourceError> {
        self.thickness = bodies.shape.iter().map(|shape| shape.thickness()).fold(f64::INFINITY, f64::min);
        let farthest = self.thickness * SHOWN.into_iter().fold(0.0, f64::max);
        self.bodies += bodies.len();
        let near = contacts(bodies, farthest);
        self.surfaces.extend(near.iter().map(|contact| contact.separation));
        self.surfaces.sort_by(f64::total_cmp);
        self.spheres.resize(counts.len(), (0, Vec::new()));
        for (count, (own, found)) in counts.iter().zip(&mut self.spheres) {
            *own = *count;
            let proxies = RowSource::SubSpheres { count: *count }.proxies(&bodies.shape)?;
            for [a, b] in near.iter().map(|contact| contact.bodies) {
                let placed = bodies.pair(a, b);
                let (placed, of) = ([&placed[0], &placed[1]], [&*proxies[a], &*proxies[b]]);
                sub_sphere_separations(placed, of, farthest, |_, near| found.push(near.separation));
            }
            found.sort_by(f64::total_cmp);
        }
        Ok(())
    }

    /// What rows within `cutoff` thicknesses are, by each of the paper's ratios of rows.
    fn at(&self, cutoff: f64, paper: &[(u32, f64)]) -> Vec<Count> {
        let within = |sorted: &[f64]| sorted.partition_point(|separation| *separation <= cutoff * self.thickness);
        let relcp = within(&self.surfaces) as f64;
        let of = |(spheres, paper): &(u32, f64)| {
            let found = &self.spheres.iter().find(|(count, _)| count == spheres)?.1;
            let relative = within(found) as f64 / relcp;
            let relcp_a_body = relcp / self.bodies as f64;
            relative.is_finite().then_some(Count { cutoff, spheres: *spheres, relcp_a_body, relative, paper: *paper })
        };
        paper.iter().filter_map(of).collect()
    }

    /// The table.
    pub fn counts(&self, paper: &[(u32, f64)]) -> Vec<Count> {
        SHOWN.iter().flat_map(|cutoff| self.at(*cutoff, paper)).collect()
    }

    /// The ratios at the distance where the one that is farthest from the paper's is nearest to it.
    pub fn best(&self, paper: &[(u32, f64)]) -> Vec<Count> {
        let last = SHOWN.into_iter().fold(0.0, f64::max);
        let tried = (1..=(last / PITCH).round() as u32).map(|k| self.at(f64::from(k) * PITCH, paper));
        tried.filter(|counts| !counts.is_empty()).min_by(|a, b| farthest(a).total_cmp(&farthest(b))).unwrap_or_default()
    }

    /// Whether the paper's ratios are those of one distance.
    pub fn target(&self, paper: &[(u32, f64)]) -> Target {
        let best = self.best(paper);
        let ratios: Vec<String> =
            best.iter().map(|of| format!("{:.2} of {:.2} (LCP-MS {})", of.relative, of.paper, of.spheres)).collect();
        let cutoff = best.first().map_or(String::new(), |of| format!("within {:.2} thicknesses: ", of.cutoff));
        Target::new(
            format!(
                "there is a distance within which the pairs of sub-spheres over those of surfaces are as many as the paper's rows, within {:.0}%",
                100.0 * WITHIN
            ),
            format!("{cutoff}{}", ratios.join(", ")),
            (!best.is_empty()).then(|| best.iter().all(|of| is_near(of.relative / of.paper))),
        )
    }

    /// The table in Markdown.
    pub fn page(&self, paper: &[(u32, f64)], states: &str) -> String {
        let mut out = format!(
            "\n## Rows by the distance within which they are made\n\nPairs that are nearer, in {states}: of sub-spheres over those of surfaces, and in parentheses over the paper's.\n\n| within, thicknesses | rows of ReLCP a body |"
        );
        for (spheres, _) in paper {
            let _ = write!(out, " LCP-MS {spheres} |");
        }
        let _ = writeln!(out, "\n| ---: | ---: |{}", " ---: |".repeat(paper.len()));
        let lines = SHOWN.iter().map(|cutoff| self.at(*cutoff, paper));
        for line in lines.chain([self.best(paper)]) {
            let Some(first) = line.first() else { continue };
            let _ = write!(out, "| {:.2} | {:.2} |", first.cutoff, first.relcp_a_body);
            for Count { relative, paper, .. } in &line {
                let _ = write!(out, " {relative:.2} ({:.2}) |", relative / paper);
            }
            out.push('\n');
        }
        out.push_str("\nThe last line is the distance that fits the paper best. Rows that do not touch cost little to a solver: their multipliers stay zero.\n");
        out
    }
}

/// How far the ratio that is farthest from the paper's is from it, as a logarithm.
fn farthest(counts: &[Count]) -> f64 {
    counts.iter().map(|of| (of.relative / of.paper).ln().abs()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DQuat, DVec3};
    use relcp::separation::Placed;
    use relcp::shape::Shape;

    #[test]
    fn two_parallel_rods_have_the_pairs_of_sub_spheres_that_are_near() {
        let mut bodies = Bodies::default();
        for x in [0.0, 1.25] {
            let shape = Shape::Spherocylinder { diameter: 1.0, length: 5.0 };
            bodies.push(Placed { shape, position: x * DVec3::X, orientation: DQuat::IDENTITY }, 0);
        }
        let mut census = Census::default();
        census.add(&bodies, &[3, 5]).unwrap();
        // Spheres of one rod are 2 or 1 apart: beside each other within 0.25, aslant by 1 within 0.601.
        let paper = [(3, 3.0), (5, 13.0)];
        let of = |cutoff: f64| census.at(cutoff, &paper).iter().map(|count| count.relative).collect::<Vec<_>>();
        assert_eq!(of(0.2), [0.0; 0], "nothing is near");
        assert_eq!([of(0.3), of(0.7)], [[3.0, 5.0], [3.0, 13.0]]);
        let best = census.best(&paper);
        assert!((0.601..1.36).contains(&best[0].cutoff) && farthest(&best) == 0.0, "{best:?}");
        assert_eq!(census.target(&paper).met, Some(true));
        assert_eq!(census.target(&[(3, 5.0), (5, 13.0)]).met, Some(false));
        assert_eq!(Census::default().target(&paper).met, None);
        assert!(census.page(&paper, "a state").contains("| 0.50 | 0.50 | 3.00 (1.00) | 5.00 (0.38) |"));
    }
}
