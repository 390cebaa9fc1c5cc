//! What a valid scene's user should know before it runs.

use super::Scene;
use crate::digits::short;

/// An overlap tolerance of more than this part of the thinnest body's thickness is remarked on: bodies are then seen to
/// overlap.
const LARGE_TOLERANCE: f64 = 0.1;

impl Scene {
    /// Warnings, in words: what is allowed, and is seldom meant.
    ///
    /// ```
    /// use relcp::scene::{Body, Time};
    /// use relcp::{Scene, Shape};
    /// let mut scene = Scene::new("bacteria in metres", Time::new(0.1, 1.0));
    /// scene.bodies.push(Body::new(Shape::Sphere { radius: 6e-6 }, [0.0; 3]));
    /// assert!(scene.warnings()[0].starts_with("contact.overlap_tolerance, 1e-5 by default, is 83 % of"));
    /// scene.contact.overlap_tolerance = 1e-11;
    /// assert!(scene.warnings().is_empty());
    /// ```
    pub fn warnings(&self) -> Vec<String> {
        self.large_tolerance().into_iter().collect()
    }

    fn large_tolerance(&self) -> Option<String> {
        let (tolerance, thinnest) = (self.contact.overlap_tolerance, self.thinnest());
        let part = tolerance / thinnest;
        (part > LARGE_TOLERANCE).then(|| {
            let is_default = tolerance == Scene::new("", self.time).contact.overlap_tolerance;
            let given = if is_default { " by default," } else { "," };
            let (percent, thickness) = ((100.0 * part).round(), short(thinnest));
            format!(
                "contact.overlap_tolerance, {}{given} is {percent} % of the thinnest body's thickness, {thickness}: bodies may overlap by so much; set it to {} or less",
                short(tolerance),
                short(1e-5 * 10_f64.powi(thinnest.log10().floor() as i32)),
            )
        })
    }
}
