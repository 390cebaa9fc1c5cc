//! Periodic space on the device: differences to the nearest image, searches, separations and steps through boundaries.

mod difference;
mod search;
mod steps;
