//! Pairs computed in extended precision.

use crate::reference_pairs::reference_pairs;
use glam::DVec3;
use relcp::separation::separation;

#[test]
fn reference_pairs_agree() {
    let (mut worst, mut worst_normal, mut worst_point) = (0.0_f64, 0.0_f64, 0.0_f64);
    for p in reference_pairs() {
        let (a, b) = (p.a.placed(), p.b.placed());
        let size = a.shape.bounding_radius().max(b.shape.bounding_radius());
        for warm in [None, Some(DVec3::from_array(p.normal))] {
            let s = separation(&a, &b, warm).unwrap();
            let error = (s.separation - p.separation).abs() / (1.0 + size);
            let turned = (s.normal - DVec3::from_array(p.normal)).length();
            worst = worst.max(error);
            worst_normal = worst_normal.max(turned);
            assert!(error < 1e-9, "{}: {} against {}", p.kind, s.separation, p.separation);
            assert!(turned < 1e-6, "{}: normal off by {turned:e}", p.kind);
            if let (Some(point_a), Some(point_b)) = (p.point_a, p.point_b) {
                let off = (a.position + s.lever_a - DVec3::from_array(point_a)).length();
                let off = off.max((b.position + s.lever_b - DVec3::from_array(point_b)).length());
                worst_point = worst_point.max(off);
                assert!(off < 1e-6 * (1.0 + size), "{}: point off by {off:e}", p.kind);
            }
        }
    }
    println!("worst error {worst:e}, normal {worst_normal:e}, point {worst_point:e}");
}
