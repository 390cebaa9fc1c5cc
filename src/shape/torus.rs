//! torus.
