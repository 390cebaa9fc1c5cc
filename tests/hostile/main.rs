//! Inputs that nobody means well with: mutated scenes, states, LCPs and sweeps are read or refused, without a panic, in
//! bounded time and memory.
//!
//! Each mutant has a random stream of its own, so that its number alone makes it again. `RELCP_MUTATIONS` is how many
//! there are, over the four readers together (10,000 without it): `RELCP_MUTATIONS=1000000 cargo test --test hostile
//! mutated`. A failure prints its mutant.
#![allow(clippy::unwrap_used)]

mod archives;
mod bombs;
mod lcps;
mod mutants;
mod names;
mod scenes;
mod states;
mod sweeps;
mod text;
