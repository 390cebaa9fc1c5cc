//! The number type of the kernels.

/// The type of `real` in the kernels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Precision {
    /// 32 bits, on every adapter.
    #[default]
    F32,
    /// 64 bits, on some adapters (see [`super::Gpu::has_f64`]).
    F64,
}

impl Precision {
    /// Bytes of one number.
    pub fn bytes(self) -> usize {
        match self {
            Precision::F32 => 4,
            Precision::F64 => 8,
        }
    }

    /// The distance from one to the next number.
    pub fn epsilon(self) -> f64 {
        match self {
            Precision::F32 => f64::from(f32::EPSILON),
            Precision::F64 => f64::EPSILON,
        }
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Precision::F32 => "f32",
            Precision::F64 => "f64",
        }
    }

    /// Numbers as a buffer holds them, rounded to this precision.
    pub fn encode(self, numbers: impl IntoIterator<Item = f64>) -> Vec<u8> {
        let numbers = numbers.into_iter();
        match self {
            Precision::F32 => numbers.flat_map(|x| (x as f32).to_le_bytes()).collect(),
            Precision::F64 => numbers.flat_map(f64::to_le_bytes).collect(),
        }
    }

    /// The numbers of a buffer.
    pub fn decode(self, bytes: &[u8]) -> Vec<f64> {
        match self {
            Precision::F32 => bytes.as_chunks().0.iter().map(|b| f64::from(f32::from_le_bytes(*b))).collect(),
            Precision::F64 => bytes.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_come_back_as_rounded() {
        for precision in [Precision::F32, Precision::F64] {
            let bytes = precision.encode([0.5, -3.0, 0.1]);
            assert_eq!(bytes.len(), 3 * precision.bytes());
            let back = precision.decode(&bytes);
            assert_eq!(back[..2], [0.5, -3.0]);
            assert!((back[2] - 0.1).abs() <= 0.1 * precision.epsilon());
        }
    }
}
