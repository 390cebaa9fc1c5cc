//! constraint.
