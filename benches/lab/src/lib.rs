//! The laboratory of `relcp`: measured studies, which tables of the documentation are made from.

/// A value of `relcp` with some of its fields set. Its structs may get more fields, so that a literal of one is for
/// `relcp` alone. As in a literal the fields come first, in their order, and then what the others are from.
macro_rules! with {
    (@ [$($set:tt)*] $field:ident: $value:expr, $($rest:tt)*) => {{
        let value = $value;
        with!(@ [$($set)* ($field value)] $($rest)*)
    }};
    (@ [$($set:tt)*] $field:ident, $($rest:tt)*) => { with!(@ [$($set)* ($field $field)] $($rest)*) };
    (@ [$(($field:ident $value:ident))*] ..$base:expr) => {{
        let mut made = $base;
        $(made.$field = $value;)*
        made
    }};
    ($($rest:tt)*) => { with!(@ [] $($rest)*) };
}

mod bandwidth;
pub mod device;
pub mod hard;
pub mod inertia;
mod machine;
pub mod paper;
mod plot;
pub mod solvers;
mod state;
mod table;
pub mod throughput;
pub mod work_precision;

pub use bandwidth::copy_bandwidth;
pub use machine::machine;
pub use state::{StudyError, tiled};
