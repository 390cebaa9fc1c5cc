//! Copies of what a rule places.

use super::Repeat;
use glam::DVec3;

/// The number of copies that these entries make, at most `u64::MAX`.
pub(in super::super) fn copies(repeat: &[Repeat]) -> u64 {
    repeat.iter().fold(1, |product, of| product.saturating_mul(of.count))
}

/// The offset of every copy, those of the first entry together.
pub(super) fn offsets(repeat: &[Repeat]) -> Vec<DVec3> {
    repeat.iter().fold(vec![DVec3::ZERO], |all, of| {
        let by = DVec3::from(of.offset);
        (0..of.count).flat_map(|k| all.iter().map(move |x| *x + k as f64 * by)).collect()
    })
}

/// The largest way of a copy along an axis.
pub(in super::super) fn farthest(repeat: &[Repeat]) -> f64 {
    let way = |of: &Repeat| DVec3::from(of.offset).abs().max_element() * of.count.saturating_sub(1) as f64;
    repeat.iter().map(way).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_entries_make_a_table() {
        let repeat = [Repeat::new(3, [2.0, 0.0, 0.0]), Repeat::new(2, [0.0, 5.0, 0.0])];
        let found: Vec<[f64; 2]> = offsets(&repeat).iter().map(|x| [x.x, x.y]).collect();
        assert_eq!(found, [[0.0, 0.0], [2.0, 0.0], [4.0, 0.0], [0.0, 5.0], [2.0, 5.0], [4.0, 5.0]]);
        assert_eq!((copies(&repeat), copies(&[])), (6, 1));
        assert_eq!(copies(&[Repeat::new(u64::MAX, [0.0; 3]); 2]), u64::MAX);
    }
}
