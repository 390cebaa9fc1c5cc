//! Faults of bodies within a step, which all processes compare.

/// A fault of one body, before it has a message: the kind of fault within one check, the body, and a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trouble {
    pub(super) kind: u8,
    pub(super) body: usize,
    pub(super) number: f64,
}
