//! The rules of a verdict. A failure is a result that would mislead a user who trusts the program.

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

/// A finding against a run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// What kind of thing: runs are counted by it.
    pub kind: &'static str,
    /// Sentence for the page, with the numbers.
    pub words: String,
}

impl Finding {
    fn new(kind: &'static str, words: impl Into<String>) -> Finding {
        Finding { kind, words: words.into() }
    }
}

/// Returns the verdict and the findings: the failures if there are any, otherwise the reported ones.
///
/// ```
/// use relcp_lab::hard::{Figures, Verdict, judge};
/// let mut figures = Figures { steps: 1, ..Figures::new(1e-5, 1e-6) };
/// assert_eq!(judge(&figures, None).0, Verdict::Holds);
/// figures.states_not_finite = 1;
/// assert_eq!(judge(&figures, None).0, Verdict::Fails);
/// ```
pub fn judge(figures: &Figures, measure: Option<&Measure>) -> (Verdict, Vec<String>) {
    let (verdict, against) = weigh(figures, measure.map(std::slice::from_ref).unwrap_or_default());
    (verdict, against.into_iter().map(|against| against.words).collect())
}

/// As [`judge`], by any number of measures, with the kind of each thing.
pub fn weigh(figures: &Figures, measures: &[Measure]) -> (Verdict, Vec<Finding>) {
    let fails = failures(figures, measures);
    if !fails.is_empty() {
        return (Verdict::Fails, fails);
    }
    let told = told(figures, measures);
    (if told.is_empty() { Verdict::Holds } else { Verdict::Reported }, told)
}

fn failures(figures: &Figures, measures: &[Measure]) -> Vec<Finding> {
    let mut out = Vec::new();
    if let End::Panic(words) = &figures.end {
        out.push(Finding::new("panic", format!("it panicked: {words}")));
    }
    if figures.states_not_finite > 0 {
        let count = figures.states_not_finite;
        out.push(Finding::new("not finite", format!("{count} accepted states are not finite")));
    }
    if figures.binding && figures.steps_over > 0 {
        out.push(over_tolerance(figures));
    }
    if figures.steps_misreported > 0 {
        let count = figures.steps_misreported;
        out.push(Finding::new("misreported", format!("{count} steps report another overlap than they left")));
    }
    if figures.false_claims > 0 {
        let (count, worst) = (figures.false_claims, figures.worst_residual);
        let words = format!("{count} steps say that they are solved with residuals to {worst:.1e}");
        out.push(Finding::new("false claim", words));
    }
    if figures.end == End::Done && figures.steps == 0 {
        out.push(Finding::new("no step", "no step was taken"));
    }
    let told = |measure: &&Measure| measure.by_passing && figures.steps_passed > 0;
    out.extend(measures.iter().filter(|measure| !told(measure)).filter_map(over));
    out
}

/// Says that a measure is over its bound, where it is.
fn over(measure: &Measure) -> Option<Finding> {
    let Measure { what, value, bound, .. } = measure;
    exceeds(*value, *bound).then(|| Finding::new(what, format!("{what} is {value:.1e}, over {bound:.0e}")))
}

fn over_tolerance(figures: &Figures) -> Finding {
    let (over, of) = (figures.steps_over, figures.steps);
    let words = format!("{over} of {of} steps over the tolerance, to {:.1e}", figures.max_overlap);
    Finding::new("over the tolerance", words)
}

fn told(figures: &Figures, measures: &[Measure]) -> Vec<Finding> {
    let mut out = Vec::new();
    if let Some([a, b]) = figures.passed {
        let steps = figures.steps_passed;
        let words = format!("bodies went through each other in {steps} steps, {a} and {b} first");
        out.push(Finding::new("passed", words));
    }
    out.extend(measures.iter().filter_map(over));
    match &figures.end {
        End::Refused(why) => out.push(Finding::new("refused", format!("refused: {why}"))),
        End::Fault(why) => out.push(Finding::new(figures.stopped.unwrap_or("stopped"), format!("stopped: {why}"))),
        End::Done | End::Panic(_) => {}
    }
    if figures.steps_over > 0 {
        out.push(over_tolerance(figures));
    }
    // A solve that ended early in a step within the tolerance is a note.
    if figures.steps_unsettled > 0 {
        let (steps, status) = (figures.steps_unsettled, &figures.status);
        out.push(Finding::new("residual", format!("{steps} steps with velocities that are off, {status}")));
    }
    out
}
