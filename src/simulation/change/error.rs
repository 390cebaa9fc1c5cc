//! Why a change of the state was refused.

use crate::scene::SceneError;
use crate::step::Fault;

/// A change was refused; the state is as before.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ChangeError {
    /// Another number of values than bodies.
    #[error("{what}: {found} rows; expected {expected}, one for each body")]
    Count {
        /// The quantity.
        what: String,
        /// The rows that were given.
        found: usize,
        /// The bodies that they are for.
        expected: usize,
    },
    /// A value that is not allowed.
    #[error("{what}[{row}] (body {body}, id {id}): {why}")]
    Value {
        /// The quantity.
        what: String,
        /// The row of the values that were given.
        row: usize,
        /// The body's index.
        body: usize,
        /// Its id.
        id: u64,
        /// What is wrong, and what would be right.
        why: String,
    },
    /// Bodies that there are not, or a body that is named twice.
    #[error("{0}")]
    Which(String),
    /// A body cannot be added; keys are those of a list `bodies`.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The backend cannot compute the changed state.
    #[error(transparent)]
    Fault(#[from] Fault),
}

impl ChangeError {
    /// The same with the row of the body among all.
    pub(super) fn by_body(self) -> ChangeError {
        match self {
            ChangeError::Value { what, body, id, why, .. } => ChangeError::Value { what, row: body, body, id, why },
            other => other,
        }
    }
}
