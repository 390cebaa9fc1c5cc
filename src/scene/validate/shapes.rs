//! The rules of shapes, and the rules of contact that depend on them.

use super::super::error::{FaultKind, SceneError};
use super::super::key::Key;
use super::super::{Generate, Method, Scene};
use super::{number, positive};
use crate::shape::Shape;

/// Most sub-spheres of a scene: 32 bytes each make two gigabytes.
const MAX_SUB_SPHERES: u64 = 1 << 26;
/// Largest ratio of an ellipsoid's radii.
const MAX_ASPECT: f64 = 100.0;

/// The rules of one shape's sizes; `key` holds the sizes.
pub(super) fn check_shape(key: &Key, shape: &Shape) -> Result<(), SceneError> {
    match *shape {
        Shape::Sphere { radius } => positive(&key.field("radius"), radius),
        Shape::Spherocylinder { diameter, length } => {
            positive(&key.field("diameter"), diameter)?;
            positive(&key.field("length"), length)?;
            if length < diameter {
                let message = format!("is tip to tip, so it must not be less than the diameter, {diameter:?}");
                return Err(SceneError::bad(key.field("length"), message));
            }
            Ok(())
        }
        Shape::Ellipsoid { radii } => {
            let key = key.field("radii");
            radii.iter().enumerate().try_for_each(|(i, &r)| positive(&key.index(i), r))?;
            let [least, _, most] = sorted(radii);
            if most > MAX_ASPECT * least {
                let message = format!("the longest is {:.4} times the shortest; at most {MAX_ASPECT}", most / least);
                return Err(SceneError::bad(key, message));
            }
            Ok(())
        }
        Shape::Torus { major_radius, minor_radius } => {
            positive(&key.field("major_radius"), major_radius)?;
            positive(&key.field("minor_radius"), minor_radius)?;
            if minor_radius >= major_radius {
                let message = format!("must be less than the major radius, {major_radius:?}");
                return Err(SceneError::bad(key.field("minor_radius"), message));
            }
            Ok(())
        }
    }
}

fn sorted(mut radii: [f64; 3]) -> [f64; 3] {
    radii.sort_by(f64::total_cmp);
    radii
}

/// A shape's thickness: the diameter of its thinnest part.
pub(in super::super) fn thickness(shape: &Shape) -> f64 {
    match *shape {
        Shape::Sphere { radius } => 2.0 * radius,
        Shape::Spherocylinder { diameter, .. } => diameter,
        Shape::Ellipsoid { radii } => 2.0 * sorted(radii)[0],
        Shape::Torus { minor_radius, .. } => 2.0 * minor_radius,
    }
}

pub(super) fn shape_name(shape: &Shape) -> &'static str {
    match shape {
        Shape::Sphere { .. } => "sphere",
        Shape::Spherocylinder { .. } => "spherocylinder",
        Shape::Ellipsoid { .. } => "ellipsoid",
        Shape::Torus { .. } => "torus",
    }
}

impl Generate {
    /// The shape of the bodies that this rule makes.
    pub fn shape(&self) -> Shape {
        match *self {
            Generate::Isotropic { shape, .. } => shape,
            Generate::Chainmail { major_radius, minor_radius, .. } => Shape::Torus { major_radius, minor_radius },
            Generate::Founder { diameter, length, .. } => Shape::Spherocylinder { diameter, length },
        }
    }

    /// The rule's name, which is its key.
    pub(in super::super) fn name(&self) -> &'static str {
        match self {
            Generate::Isotropic { .. } => "isotropic",
            Generate::Chainmail { .. } => "chainmail",
            Generate::Founder { .. } => "founder",
        }
    }
}

impl Scene {
    /// Every distinct source of a shape, in order: `bodies`, then `generate`, with the key of the body or the rule.
    pub(in super::super) fn shapes(&self) -> impl Iterator<Item = (&'static str, usize, Shape)> + '_ {
        let bodies = self.bodies.iter().enumerate().map(|(i, b)| ("bodies", i, b.shape));
        bodies.chain(self.generate.iter().enumerate().map(|(i, g)| ("generate", i, g.shape())))
    }

    pub(super) fn check_contact(&self, key: &Key) -> Result<(), SceneError> {
        let contact = &self.contact;
        let tolerance_key = key.field("overlap_tolerance");
        positive(&tolerance_key, contact.overlap_tolerance)?;
        let thinnest = self.shapes().map(|(_, _, s)| thickness(&s)).fold(f64::INFINITY, f64::min);
        if contact.overlap_tolerance >= thinnest {
            let message = format!("must be less than the thinnest body's thickness, {thinnest:?}; it is a length");
            return Err(SceneError::bad(tolerance_key, message));
        }
        let farthest = self.bodies.iter().flat_map(|b| b.position).fold(0.0_f64, |m, x| m.max(x.abs()));
        if farthest * f64::EPSILON > contact.overlap_tolerance {
            let message = format!("is finer than 64-bit floats are at the farthest body's coordinate, {farthest:e}");
            return Err(SceneError::bad(tolerance_key, message));
        }
        if contact.max_recursions == 0 {
            let message = "must be at least 1; a step without recursion is contact.method \"snsd\"";
            return Err(SceneError::bad(key.field("max_recursions"), message));
        }
        if let Some(cutoff) = contact.cutoff {
            number(&key.field("cutoff"), cutoff)?;
            if cutoff < 0.0 {
                return Err(SceneError::bad(key.field("cutoff"), format!("must not be negative, not {cutoff:?}")));
            }
        }
        self.check_pairs()?;
        match contact.method {
            Method::Multisphere { count } => {
                self.check_multisphere(&key.field("method").field("multisphere").field("count"), count)
            }
            Method::Relcp | Method::Snsd => Ok(()),
        }
    }

    /// A ring and an ellipsoid in one scene: no separation is defined for that pair.
    fn check_pairs(&self) -> Result<(), SceneError> {
        let first = |wanted: &'static str| self.shapes().find(move |(_, _, s)| shape_name(s) == wanted);
        if let (Some(ring), Some(ellipsoid)) = (first("torus"), first("ellipsoid")) {
            let order = |(list, index, _): &(&'static str, usize, Shape)| (*list == "generate", *index);
            let (list, index, _) = if order(&ring) > order(&ellipsoid) { ring } else { ellipsoid };
            let message = "a torus and an ellipsoid cannot be in one scene: no separation is defined for that pair";
            return Err(SceneError::bad(Key::ROOT.field(list).index(index), message));
        }
        Ok(())
    }

    fn check_multisphere(&self, key: &Key, count: u32) -> Result<(), SceneError> {
        if count == 0 {
            return Err(SceneError::bad(key, "must be at least 1"));
        }
        for (list, index, shape) in self.shapes() {
            match shape {
                Shape::Sphere { .. } => {}
                Shape::Torus { major_radius, minor_radius } => {
                    let least = gap_free_count(major_radius, minor_radius);
                    if f64::from(count) < least {
                        let message =
                            format!("must be at least {least}: fewer leave gaps on the ring of {list}.{index}");
                        return Err(SceneError::bad(key, message));
                    }
                }
                Shape::Spherocylinder { .. } | Shape::Ellipsoid { .. } if count % 2 == 0 => {
                    let message =
                        format!("must be odd, not {count}: one sub-sphere is at the centre of {list}.{index}");
                    return Err(SceneError::bad(key, message));
                }
                Shape::Ellipsoid { radii } if sorted(radii)[0] < sorted(radii)[1] => {
                    let message =
                        "sub-spheres on the longest axis stand for an ellipsoid whose two shorter radii are equal";
                    return Err(SceneError::bad(Key::ROOT.field(list).index(index), message));
                }
                Shape::Spherocylinder { .. } | Shape::Ellipsoid { .. } => {}
            }
        }
        let spheres = u64::from(count).saturating_mul(self.body_count());
        if spheres > MAX_SUB_SPHERES {
            let message = format!("the scene would have {spheres} sub-spheres; at most {MAX_SUB_SPHERES}");
            return Err(SceneError::new(FaultKind::TooLarge, key, message));
        }
        Ok(())
    }
}

/// Fewest spheres on a ring's centreline whose neighbours touch: `R sin(pi / n) <= r`.
fn gap_free_count(major_radius: f64, minor_radius: f64) -> f64 {
    (std::f64::consts::PI / (minor_radius / major_radius).asin() - 1e-9).ceil()
}
