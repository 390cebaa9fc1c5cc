//! Orientations of a scene file: `[w, x, y, z]`, normalized on reading.

#[cfg(feature = "files")]
use super::Scene;
use glam::DQuat;

/// How far a squared norm may be from one to count as normalized: rounding of a normalized quaternion stays below four epsilons.
/// Leaving such a quaternion alone makes a written state come back to the same bits.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// The norm, without overflow or underflow.
pub(super) fn norm(q: [f64; 4]) -> f64 {
    let scale = q.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    if scale == 0.0 {
        return 0.0;
    }
    scale * q.iter().map(|x| (x / scale).powi(2)).sum::<f64>().sqrt()
}

fn normalized(q: [f64; 4]) -> [f64; 4] {
    let square: f64 = q.iter().map(|x| x * x).sum();
    if (square - 1.0).abs() <= ROUNDING {
        return q;
    }
    let norm = norm(q);
    q.map(|x| x / norm)
}

/// The rotation, normalized.
pub(super) fn unit(q: [f64; 4]) -> DQuat {
    let [w, x, y, z] = normalized(q);
    DQuat::from_xyzw(x, y, z, w)
}

/// As it stands in a scene file.
pub(super) fn written(q: DQuat) -> [f64; 4] {
    [q.w, q.x, q.y, q.z]
}

#[cfg(feature = "files")]
impl Scene {
    pub(super) fn normalize_orientations(&mut self) {
        for body in &mut self.bodies {
            body.orientation = normalized(body.orientation);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normalizing_is_idempotent_and_survives_extremes() {
        for q in [[2.0, 0.0, 0.0, 0.0], [1e-5, 2e-5, -3e-5, 1e-6], [1e60, 1e60, 0.0, 1.0], [0.3, -0.4, 0.5, 0.6]] {
            let once = normalized(q);
            assert_eq!(normalized(once), once);
            assert!((norm(once) - 1.0).abs() < 1e-15, "{q:?}");
        }
        assert_eq!(norm([0.0; 4]), 0.0);
    }
}
