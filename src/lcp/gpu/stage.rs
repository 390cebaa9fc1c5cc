//! The work of one dispatch.

use super::layout::REDUCTIONS;
use super::number::Operation;

/// The kinds of reductions over rows, with their names in kernels.
const SUM: u32 = 0;
const LEAST: u32 = 1;
const WORST: u32 = 2;
pub(super) const REDUCTION_KINDS: [(&str, u32); 3] = [("SUM", SUM), ("LEAST", LEAST), ("WORST", WORST)];

/// An operation on one row, as in `shaders/lcp/instructions.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Hash)]
#[repr(u32)]
pub(super) enum Action {
    Zero,
    Copy,
    CopyIf,
    Combine,
    Proximal,
    Invert,
    Advance,
    AdvanceLow,
    Dot,
    Triple,
    Objective,
    Room,
    Residual,
    Largest,
    // Of contacts with friction alone (`shaders/lcp/friction/instructions.wgsl`).
    Comply,
    Follow,
    Correct,
    ResidualHeld,
    Off,
}

impl Action {
    /// All actions, in order.
    pub const ALL: [Action; 19] = [
        Action::Zero,
        Action::Copy,
        Action::CopyIf,
        Action::Combine,
        Action::Proximal,
        Action::Invert,
        Action::Advance,
        Action::AdvanceLow,
        Action::Dot,
        Action::Triple,
        Action::Objective,
        Action::Room,
        Action::Residual,
        Action::Largest,
        Action::Comply,
        Action::Follow,
        Action::Correct,
        Action::ResidualHeld,
        Action::Off,
    ];

    /// Those of rows alone: the first ones of all.
    pub const OF_ROWS: usize = Action::Largest as usize + 1;

    /// Whether it computes a sum (or least, or worst) instead of a vector.
    pub fn is_sum(self) -> bool {
        self >= Action::Dot && !matches!(self, Action::Comply | Action::Follow | Action::Correct)
    }

    /// How its values are reduced, as in `shaders/lcp/reduce.wgsl`.
    pub fn kind(self) -> u32 {
        match self {
            Action::Room => LEAST,
            Action::Residual | Action::Largest | Action::ResidualHeld | Action::Off => WORST,
            _ => SUM,
        }
    }

    /// Which of its three vectors it reads.
    pub fn reads(self) -> [bool; 3] {
        match self {
            Action::Zero => [false; 3],
            Action::Copy | Action::Largest => [true, false, false],
            Action::CopyIf => [true, false, true],
            Action::Combine | Action::Invert | Action::Advance | Action::Dot | Action::Room => [true, true, false],
            Action::Follow | Action::Correct | Action::ResidualHeld | Action::Off => [true, true, false],
            Action::Comply
            | Action::AdvanceLow
            | Action::Proximal
            | Action::Triple
            | Action::Objective
            | Action::Residual => [true; 3],
        }
    }

    /// The name of its number in kernels.
    pub fn constant(self) -> &'static str {
        match self {
            Action::Zero => "ZERO",
            Action::Copy => "COPY",
            Action::CopyIf => "COPY_IF",
            Action::Combine => "COMBINE",
            Action::Proximal => "PROXIMAL",
            Action::Invert => "INVERT",
            Action::Advance => "ADVANCE",
            Action::AdvanceLow => "ADVANCE_LOW",
            Action::Dot => "DOT",
            Action::Triple => "TRIPLE",
            Action::Objective => "OBJECTIVE",
            Action::Room => "ROOM",
            Action::Residual => "RESIDUAL",
            Action::Largest => "LARGEST",
            Action::Comply => "COMPLY",
            Action::Follow => "FOLLOW",
            Action::Correct => "CORRECT",
            Action::ResidualHeld => "RESIDUAL_HELD",
            Action::Off => "OFF",
        }
    }
}

/// One instruction: the action, the output (for a sum, its index in the stage), three vectors, two scalars.
pub(super) type Words = [u32; 8];

/// The work of one dispatch.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Stage {
    /// Operations on scalars, executed first. They may take the sums of the stage before.
    pub operations: Vec<[u32; 4]>,
    pub work: Work,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Work {
    /// Only operations on scalars.
    Numbers,
    Rows(Rows),
    /// The local LCPs of the clusters.
    Clusters(Clusters),
    /// `J^T x`.
    Bodies(Bodies),
    /// Reads the problem.
    PrepareRows,
    /// Computes the blocks of pairs.
    PreparePairs,
    /// Copies a vector to `gamma`.
    Export {
        x: u32,
    },
}

/// The half of a product that sums over the rows of each body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Bodies {
    pub x: u32,
    /// The rounding error of the vector.
    pub low: Option<u32>,
    /// If this scalar is positive, this vector is used instead.
    pub instead: Option<[u32; 2]>,
    /// Whether the velocities are computed in two parts.
    pub exact: bool,
}

/// Local LCPs, executed if a scalar is positive; each is skipped if it is already solved well within a tolerance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Clusters {
    pub condition: u32,
    pub tolerance: u32,
    pub x: u32,
    pub g: u32,
}

/// The sum of the displacements of the clusters before, if a scalar is positive; otherwise, and for rows in no cluster,
/// another vector.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Gather {
    pub condition: u32,
    pub instead: u32,
    pub out: u32,
}

/// Work on rows.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Rows {
    /// The rows of a product, or the sum of displacements, computed first.
    pub product: Option<Product>,
    pub gather: Option<Gather>,
    pub before: Vec<Words>,
    /// The instruction on whole pairs.
    pub block: Option<Block>,
    pub after: Vec<Words>,
    /// The kinds of the sums that it computes.
    pub kinds: Vec<u32>,
}

/// The row half of a product.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Product {
    pub out: u32,
    pub add_q: bool,
    /// Whether the velocities are in two parts.
    pub exact: bool,
}

/// `out = argmin over x + out >= 0 of g . out + 1/2 (out - w) . B (out - w)`, for the vectors `x`, `w` and `g`. One of
/// the last two is missing and counts as zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Block {
    pub x: u32,
    pub w: Option<u32>,
    pub g: Option<u32>,
    pub out: u32,
}

impl Stage {
    /// Its name, for timing.
    pub fn name(&self) -> &'static str {
        match &self.work {
            Work::Rows(Rows { product: Some(_), .. }) => "lcp-product",
            Work::Rows(Rows { block: Some(_), .. }) => "lcp-pairs",
            Work::Rows(_) => "lcp-rows",
            Work::Clusters(_) => "lcp-clusters",
            Work::Bodies(_) => "lcp-bodies",
            Work::Numbers => "lcp-numbers",
            Work::PrepareRows | Work::PreparePairs | Work::Export { .. } => "lcp-prepare",
        }
    }

    /// The number of checks among its operations.
    pub fn looks(&self) -> u32 {
        self.operations.iter().filter(|words| words[0] & 0xff == Operation::Look as u32).count() as u32
    }

    /// The kinds of the sums that it computes.
    pub fn kinds(&self) -> Vec<u32> {
        match &self.work {
            Work::Rows(rows) => rows.kinds.clone(),
            _ => Vec::new(),
        }
    }
}

/// Stages that are run one after the other.
#[derive(Debug)]
pub(super) struct Segment {
    pub stages: Vec<Stage>,
    /// The kinds of the sums of the stage before the first one.
    pub carried: Vec<u32>,
    /// The number of stages that were run before.
    pub run: u32,
    /// The number of checks before, over the solve, and the number of checks in it.
    pub looks_before: u32,
    pub looks: u32,
}

/// Kinds of sums in one word, two bits each.
pub(super) fn packed(kinds: &[u32]) -> u32 {
    debug_assert!(kinds.len() <= REDUCTIONS as usize);
    kinds.iter().enumerate().fold(0, |word, (nth, kind)| word | kind << (2 * nth))
}
