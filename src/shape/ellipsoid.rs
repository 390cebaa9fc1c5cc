//! ellipsoid.
