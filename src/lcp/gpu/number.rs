//! Scalars that live on the device. Arithmetic with them is recorded in a list of the thread, in order, and executed
//! later.
//!
//! A scalar is an entry of a ring on the device, so old scalars are overwritten. No solver keeps a scalar for longer
//! than two iterations, which fill about a quarter of the ring. A solve that reads a scalar older than half the ring
//! ends with a fault: the other half is for stages that are executed in another order than they were recorded.

use crate::lcp::verbs::Scalar;
use std::cell::RefCell;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Scalars in the ring.
pub(super) const RING: u32 = 512;

/// The number of newer scalars after which one counts as overwritten.
const KEPT: u32 = RING / 2;

/// An operation on scalars, as in `shaders/lcp/numbers.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u32)]
pub(super) enum Operation {
    /// Takes the sum (or least, or worst) number `a` of the last reductions.
    Take,
    Add,
    Sub,
    Mul,
    Div,
    Neg,
    Min,
    Max,
    IfPositive,
    Look,
}

impl Operation {
    /// All operations, in order.
    pub const ALL: [Operation; 10] = [
        Operation::Take,
        Operation::Add,
        Operation::Sub,
        Operation::Mul,
        Operation::Div,
        Operation::Neg,
        Operation::Min,
        Operation::Max,
        Operation::IfPositive,
        Operation::Look,
    ];

    /// The name of its number in kernels.
    pub fn constant(self) -> &'static str {
        match self {
            Operation::Take => "TAKE",
            Operation::Add => "ADD",
            Operation::Sub => "SUB",
            Operation::Mul => "MUL",
            Operation::Div => "DIV",
            Operation::Neg => "NEG",
            Operation::Min => "MIN",
            Operation::Max => "MAX",
            Operation::IfPositive => "IF_POSITIVE",
            Operation::Look => "LOOK",
        }
    }
}

/// A scalar that is known on the host, or the nth one on the device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Number {
    Known(f64),
    At(u32),
    /// The tolerance of a problem with friction.
    Tolerance,
}

/// A recorded operation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Noted {
    pub operation: Operation,
    pub out: u32,
    pub operands: [Number; 3],
}

#[derive(Default)]
struct Notes {
    noted: Vec<Noted>,
    next: u32,
    misuse: Option<&'static str>,
}

thread_local! {
    static NOTES: RefCell<Notes> = RefCell::default();
}

/// The operations recorded since the last call.
pub(super) fn drain(to: &mut Vec<Noted>) {
    NOTES.with_borrow_mut(|notes| to.append(&mut notes.noted));
}

/// A new scalar: its number is that of the scalars before it.
pub(super) fn new() -> u32 {
    NOTES.with_borrow_mut(|notes| {
        let nth = notes.next;
        notes.next = nth.wrapping_add(1);
        nth
    })
}

/// The offset of the nth scalar in the ring.
pub(super) fn place(nth: u32) -> u32 {
    if NOTES.with_borrow(|notes| notes.next.wrapping_sub(nth)) > KEPT {
        report("a solver kept a number for longer than the device does");
    }
    nth % RING
}

/// Reports that a solver does something that a device does not support: its solve ends with this fault.
pub(super) fn report(misuse: &'static str) {
    NOTES.with_borrow_mut(|notes| notes.misuse = Some(misuse));
}

/// The fault that was reported since the last call.
pub(super) fn take_misuse() -> Option<&'static str> {
    NOTES.with_borrow_mut(|notes| notes.misuse.take())
}

fn note(operation: Operation, a: Number, b: Number, c: Number) -> Number {
    let out = new();
    NOTES.with_borrow_mut(|notes| notes.noted.push(Noted { operation, out, operands: [a, b, c] }));
    Number::At(out)
}

/// A scalar on the device with the value `x`.
pub(super) fn made(x: f64) -> Number {
    note(Operation::Add, Number::Known(x), Number::Known(0.0), Number::Known(0.0))
}

fn binary(operation: Operation, a: Number, b: Number, known: impl Fn(f64, f64) -> f64) -> Number {
    match (a, b) {
        (Number::Known(a), Number::Known(b)) => Number::Known(known(a, b)),
        _ => note(operation, a, b, Number::Known(0.0)),
    }
}

impl From<f64> for Number {
    fn from(x: f64) -> Self {
        Number::Known(x)
    }
}

impl Add for Number {
    type Output = Number;
    fn add(self, other: Number) -> Number {
        binary(Operation::Add, self, other, |a, b| a + b)
    }
}

impl Sub for Number {
    type Output = Number;
    fn sub(self, other: Number) -> Number {
        binary(Operation::Sub, self, other, |a, b| a - b)
    }
}

impl Mul for Number {
    type Output = Number;
    fn mul(self, other: Number) -> Number {
        binary(Operation::Mul, self, other, |a, b| a * b)
    }
}

impl Div for Number {
    type Output = Number;
    fn div(self, other: Number) -> Number {
        binary(Operation::Div, self, other, |a, b| a / b)
    }
}

impl Neg for Number {
    type Output = Number;
    fn neg(self) -> Number {
        match self {
            Number::Known(a) => Number::Known(-a),
            Number::At(_) | Number::Tolerance => note(Operation::Neg, self, self, self),
        }
    }
}

impl Scalar for Number {
    fn min(self, other: Number) -> Number {
        binary(Operation::Min, self, other, f64::min)
    }
    fn max(self, other: Number) -> Number {
        binary(Operation::Max, self, other, f64::max)
    }
    fn if_positive(self, yes: Number, no: Number) -> Number {
        match self {
            Number::Known(a) => {
                if a > 0.0 {
                    yes
                } else {
                    no
                }
            }
            Number::At(_) | Number::Tolerance => note(Operation::IfPositive, self, yes, no),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_that_was_overwritten_is_a_fault() {
        let Number::At(kept) = made(1.0) else { panic!() };
        for _ in 1..KEPT {
            new();
        }
        place(kept);
        assert_eq!(take_misuse(), None);
        new();
        place(kept);
        assert!(take_misuse().is_some());
        assert_eq!(take_misuse(), None);
        drain(&mut Vec::new());
    }
}
