//! The section `periodic` of a scene.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Periods of space along its axes. A body, with the cutoff, is at most half as long as the shortest period. Positions are not wrapped: a body that
/// leaves the cell goes on, and is seen at all its images.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Periodic {
    /// The period along x, y and z; null where space is open. In a planar scene along z it is null.
    pub lengths: [Option<f64>; 3],
}
