//! sphere.
