//! Periodic space: searches, images, scenes, steps and outputs.

mod broad_phase;
