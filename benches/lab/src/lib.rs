//! The laboratory of `relcp`: measured studies, which produce tables of the documentation.

/// Makes a value of a `relcp` struct with some of its fields set. The structs are non-exhaustive, so only `relcp`
/// itself can write literals of them. As in a literal, the fields come first, in order, followed by the base value for
/// the other fields.
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
