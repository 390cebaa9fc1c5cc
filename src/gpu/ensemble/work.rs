//! The work that a member requests from the device: a list of dispatches and copies, and bytes to read afterwards.

use super::pipeline::Pipeline;
use std::ops::Range;
use std::sync::Arc;

/// A piece of work; offsets are bytes in the arena.
pub(in crate::gpu) enum Work {
    Dispatch(Dispatch),
    Copy {
        from: u64,
        to: u64,
        bytes: u64,
    },
    Clear(Range<u64>),
    Write {
        to: u64,
        bytes: Vec<u8>,
    },
    /// Frees a range of the arena: no later work uses it.
    Leave(Range<u64>),
}

/// One member's part of a dispatch.
pub(in crate::gpu) struct Dispatch {
    pub pipeline: Arc<Pipeline>,
    pub parameters: Vec<u8>,
    /// The beginnings of its arrays, in elements.
    pub begins: Vec<u32>,
    /// Workgroups along x and y; upper limits if words of the arena contain the numbers.
    pub groups: [u32; 2],
    /// The word of the arena that contains the numbers of workgroups.
    pub said_at: Option<u32>,
    pub invocations: u64,
}

impl Work {
    /// The kernel that it dispatches.
    pub fn kernel(&self) -> Option<u64> {
        match self {
            Work::Dispatch(dispatch) => Some(dispatch.pipeline.id),
            _ => None,
        }
    }
}

/// Work, and the ranges to read after it.
pub(super) struct Request {
    pub work: Vec<Work>,
    pub read: Vec<Range<u64>>,
    /// Whether this is the first request of a step.
    pub begins_step: bool,
}
