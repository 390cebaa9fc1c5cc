//! Tables of kernels. A line of a table contains a field's name, its function (`functions!`) and its source. So no
//! kernel can use the source of another, and a kernel without a source does not compile.

#[cfg(test)]
use super::Source;
use super::{Gpu, GpuError};

/// The type of a field of a table: a kernel, several kernels, an optional kernel, or another table.
pub(crate) trait Made: Sized {
    /// The type that it is made from.
    type From<'a>;

    /// Compiles it.
    fn make(gpu: &Gpu, from: Self::From<'_>) -> Result<Self, GpuError>;

    /// Its sources, for tests that need no device.
    #[cfg(test)]
    fn sources(from: Self::From<'_>) -> Vec<Source>;
}

impl<T: Made> Made for Option<T> {
    type From<'a> = Option<T::From<'a>>;

    fn make(gpu: &Gpu, from: Self::From<'_>) -> Result<Self, GpuError> {
        from.map(|from| T::make(gpu, from)).transpose()
    }

    #[cfg(test)]
    fn sources(from: Self::From<'_>) -> Vec<Source> {
        from.into_iter().flat_map(T::sources).collect()
    }
}

impl<T: Made> Made for Vec<T> {
    type From<'a> = Vec<T::From<'a>>;

    fn make(gpu: &Gpu, from: Self::From<'_>) -> Result<Self, GpuError> {
        from.into_iter().map(|from| T::make(gpu, from)).collect()
    }

    #[cfg(test)]
    fn sources(from: Self::From<'_>) -> Vec<Source> {
        from.into_iter().flat_map(T::sources).collect()
    }
}

/// Declares a struct of kernels, each with its source. Sources may refer to the value that all are made from:
///
/// ```ignore
/// kernels! {
///     /// The kernels of a list.
///     pub(super) struct Kernels for setup: &Setup {
///         sort: Sort = sort(setup),
///         /// Where the scene has walls.
///         find: Option<Find> = (!setup.walls.is_empty()).then(|| find(setup)),
///     }
/// }
/// ```
macro_rules! kernels {
    (
        $(#[$about:meta])*
        $visible:vis struct $Table:ident for $setup:ident: &$Setup:ty {
            $($(#[$doc:meta])* $name:ident: $Kernel:ty = $source:expr,)*
        }
    ) => {
        $(#[$about])*
        $visible struct $Table {
            $($(#[$doc])* pub $name: $Kernel,)*
        }

        impl $crate::gpu::Made for $Table {
            type From<'a> = &'a $Setup;

            fn make(gpu: &$crate::gpu::Gpu, $setup: &$Setup) -> Result<Self, $crate::gpu::GpuError> {
                Ok($Table { $($name: <$Kernel as $crate::gpu::Made>::make(gpu, $source)?,)* })
            }

            #[cfg(test)]
            fn sources($setup: &$Setup) -> Vec<$crate::gpu::Source> {
                [$(<$Kernel as $crate::gpu::Made>::sources($source),)*].concat()
            }
        }
    };
}
pub(crate) use kernels;
