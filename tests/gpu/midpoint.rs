//! Midpoint steps on the device: each verb against the CPU's, and whole runs.

mod runs;
mod verbs;
