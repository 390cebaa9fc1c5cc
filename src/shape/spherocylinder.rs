//! spherocylinder.
