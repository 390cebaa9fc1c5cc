//! Reads `--backend`, with a hint for names that other programs use for a GPU.

use super::run::Backend;
use clap::builder::{EnumValueParser, PossibleValue, TypedValueParser};
use clap::error::{ContextKind, ContextValue};
use clap::{Arg, Command, Error};
use std::ffi::OsStr;

/// Other programs' names for a GPU backend.
const NAMES_OF_GPU: [&str; 14] = [
    "cuda", "rocm", "hip", "opencl", "metal", "vulkan", "dx12", "directx", "wgpu", "webgpu", "device", "nvidia", "amd",
    "cuda:0",
];

/// Parses the values of [`Backend`].
#[derive(Clone)]
pub(super) struct BackendParser;

impl TypedValueParser for BackendParser {
    type Value = Backend;

    fn parse_ref(&self, command: &Command, arg: Option<&Arg>, value: &OsStr) -> Result<Backend, Error> {
        EnumValueParser::<Backend>::new().parse_ref(command, arg, value).map_err(|mut error| {
            if value.to_str().is_some_and(|name| NAMES_OF_GPU.contains(&name.to_lowercase().as_str())) {
                error.insert(ContextKind::SuggestedValue, ContextValue::String("gpu".into()));
            }
            error
        })
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        use clap::ValueEnum;
        Some(Box::new(Backend::value_variants().iter().filter_map(Backend::to_possible_value)))
    }
}
