//! What is made of a run, by rules: what a person who trusts the program would be hurt by is a failure.

use super::run::{End, Figures, exceeds};
use serde::Serialize;

/// What a case measures beside contact, and the most that it may be.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Measure {
    /// What.
    pub what: &'static str,
    /// How much.
    pub value: f64,
    /// The most that it may be.
    pub bound: f64,
    /// Whether bodies that go through each other explain a larger value: the program tells of them.
    pub by_passing: bool,
}

/// The verdict on a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Every step is within tolerance and so is every solve.
    Holds,
    /// Not all are, and the program itself says so.
    Reported,
    /// Something is wrong that the program does not tell.
    Fails,
}

impl Verdict {
    /// As tables say it.
    pub fn name(self) -> &'static str {
        match self {
            Verdict::Holds => "holds",
            Verdict::Reported => "reported",
            Verdict::Fails => "**fails**",
        }
    }
}

/// The verdict, and what speaks against the case: first what fails, else what is reported.
///
/// ```
/// use relcp::study::hard::{Figures, Verdict, judge};
/// let mut figures = Figures { steps: 1, ..Figures::new(1e-5, 1e-6) };
/// assert_eq!(judge(&figures, None).0, Verdict::Holds);
/// figures.states_not_finite = 1;
/// assert_eq!(judge(&figures, None).0, Verdict::Fails);
/// ```
pub fn judge(figures: &Figures, measure: Option<&Measure>) -> (Verdict, Vec<String>) {
    let fails = failures(figures, measure);
    if !fails.is_empty() {
        return (Verdict::Fails, fails);
    }
    let told = told(figures, measure);
    (if told.is_empty() { Verdict::Holds } else { Verdict::Reported }, told)
}

fn failures(figures: &Figures, measure: Option<&Measure>) -> Vec<String> {
    let mut out = Vec::new();
    if let End::Panic(words) = &figures.end {
        out.push(format!("it panicked: {words}"));
    }
    if figures.states_not_finite > 0 {
        out.push(format!("{} accepted states are not finite", figures.states_not_finite));
    }
    if figures.steps_misreported > 0 {
        out.push(format!("{} steps report another overlap than they left", figures.steps_misreported));
    }
    if figures.false_claims > 0 {
        out.push(format!(
            "{} steps say that they are solved with residuals to {:.1e}",
            figures.false_claims, figures.worst_residual
        ));
    }
    if figures.end == End::Done && figures.steps == 0 {
        out.push("no step was taken".into());
    }
    let told = |measure: &&Measure| measure.by_passing && figures.steps_passed > 0;
    out.extend(measure.filter(|measure| !told(measure)).and_then(over));
    out
}

/// Says that a measure is over its bound, where it is.
fn over(measure: &Measure) -> Option<String> {
    let Measure { what, value, bound, .. } = measure;
    exceeds(*value, *bound).then(|| format!("{what} is {value:.1e}, over {bound:.0e}"))
}

fn told(figures: &Figures, measure: Option<&Measure>) -> Vec<String> {
    let mut out = Vec::new();
    if let Some([a, b]) = figures.passed {
        let steps = figures.steps_passed;
        out.push(format!("bodies went through each other in {steps} steps, {a} and {b} first"));
    }
    out.extend(measure.and_then(over));
    match &figures.end {
        End::Refused(why) => out.push(format!("refused: {why}")),
        End::Fault(why) => out.push(format!("stopped: {why}")),
        End::Done | End::Panic(_) => {}
    }
    if figures.steps_over > 0 {
        let (over, of) = (figures.steps_over, figures.steps);
        out.push(format!("{over} of {of} steps over the tolerance, to {:.1e}", figures.max_overlap));
    }
    if figures.unconverged > 0 {
        out.push(format!("{} unconverged solves, {}", figures.unconverged, figures.status));
    }
    out
}
