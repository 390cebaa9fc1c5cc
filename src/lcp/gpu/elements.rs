//! The elements of vectors in kernels.

use super::shape::Line;

/// What vectors have elements of: rows alone, or contacts with friction, whose numbers are four.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Elements {
    Rows,
    Contacts,
}

impl Elements {
    pub fn name(self) -> &'static str {
        match self {
            Elements::Rows => "real",
            Elements::Contacts => "vec4r",
        }
    }

    pub fn zero(self) -> &'static str {
        match self {
            Elements::Rows => "real(0.0)",
            Elements::Contacts => "vec4r()",
        }
    }

    /// The value of line number `k` from these vectors.
    pub fn value(self, line: &Line, k: usize, vectors: &str) -> String {
        let action = line.action.constant();
        match self {
            Elements::Rows => format!("row_value({action}, {vectors}, s{k}, t{k})"),
            Elements::Contacts => {
                let reduced = if line.action.is_sum() { ".x" } else { "" };
                format!("unit_value({action}, {vectors}, s{k}, t{k}, friction){reduced}")
            }
        }
    }
}
