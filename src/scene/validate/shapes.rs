//! The rules of shapes, and the rules of contact that depend on them.

use super::super::error::{FaultKind, SceneError};
use super::super::generate::{copies, farthest_copy, spread};
use super::super::key::Key;
use super::super::{Generate, Growth, Method, Scene};
use super::{number, positive};
use crate::digits::{at_most, short};
use crate::shape::{ProxyError, Shape};

/// Most sub-spheres of a scene: 32 bytes each make two gigabytes.
const MAX_SUB_SPHERES: u64 = 1 << 26;
/// The rules of one shape's sizes; `key` holds the sizes.
pub(super) fn check_shape(key: &Key, shape: &Shape) -> Result<(), SceneError> {
    shape.validate().map_err(|error| SceneError::bad(key.field(error.field()), error.to_string()))
}

impl Generate {
    /// The bodies that this rule makes, in order: how many of which shape and group.
    pub fn components(&self) -> impl Iterator<Item = (u64, Shape, Option<&str>)> {
        let (own, mixture, group) = match self {
            Generate::Isotropic { count, shape, lengths, mixture, group, .. } => {
                (spread(*count, *shape, lengths.as_ref()), &mixture[..], group)
            }
            &Generate::Chainmail { columns, rows, major_radius, minor_radius, ref group } => {
                let ring = Shape::Torus { major_radius, minor_radius };
                (vec![(columns.saturating_mul(rows), ring)], &[][..], group)
            }
            &Generate::Founder { diameter, length, count, ref repeat, ref group, .. } => {
                let cell = Shape::Spherocylinder { diameter, length };
                (vec![(count.saturating_mul(copies(repeat)), cell)], &[][..], group)
            }
            Generate::Lattice(lattice) => (vec![(lattice.count(), lattice.shape)], &[][..], &lattice.group),
            Generate::Fence(fence) => (fence.components(), &[][..], &fence.group),
            Generate::Chain(chain) => {
                (vec![(chain.count.saturating_mul(copies(&chain.repeat)), chain.shape)], &[][..], &chain.group)
            }
        };
        let further = mixture.iter().flat_map(|of| {
            let spread = spread(of.count, of.shape, of.lengths.as_ref());
            spread.into_iter().map(|(count, shape)| (count, shape, of.group.as_deref()))
        });
        own.into_iter().map(|(count, shape)| (count, shape, group.as_deref())).chain(further)
    }

    /// Whether its bodies are obstacles that do not move, whatever their group.
    pub fn is_fixed(&self) -> bool {
        matches!(self, Generate::Fence(_))
    }

    /// The farthest coordinate of a body that the rule's settings place, not its draws.
    fn farthest(&self) -> f64 {
        match self {
            Generate::Founder { position, repeat, .. } => {
                position.iter().fold(0.0_f64, |most, x| most.max(x.abs())) + farthest_copy(repeat)
            }
            Generate::Lattice(lattice) => lattice.farthest(),
            Generate::Fence(fence) => fence.farthest(),
            Generate::Isotropic { .. } | Generate::Chainmail { .. } | Generate::Chain(_) => 0.0,
        }
    }

    /// How many bodies the rule makes, at most `u64::MAX`.
    pub fn count(&self) -> u64 {
        // Without a list of all lengths, which may be too long to make.
        if let Generate::Isotropic { count, mixture, .. } = self {
            return mixture.iter().fold(*count, |sum, of| sum.saturating_add(of.count));
        }
        self.components().fold(0, |sum, (count, ..)| sum.saturating_add(count))
    }

    /// The rule's name, which is its key.
    pub(in super::super) fn name(&self) -> &'static str {
        match self {
            Generate::Isotropic { .. } => "isotropic",
            Generate::Chainmail { .. } => "chainmail",
            Generate::Founder { .. } => "founder",
            Generate::Lattice(_) => "lattice",
            Generate::Fence(_) => "fence",
            Generate::Chain(_) => "chain",
        }
    }
}

impl Scene {
    /// Every distinct source of a shape, in order: `bodies`, then `generate`, with the key of the body or the rule.
    pub(in super::super) fn shapes(&self) -> impl Iterator<Item = (&'static str, usize, Shape)> + '_ {
        let bodies = self.bodies.iter().enumerate().map(|(i, b)| ("bodies", i, b.shape));
        bodies.chain(self.generated().map(|(i, (_, shape, _))| ("generate", i, shape)))
    }

    /// What the rules make, each with the number of its rule.
    pub(in super::super) fn generated(&self) -> impl Iterator<Item = (usize, (u64, Shape, Option<&str>))> {
        self.generate.iter().enumerate().flat_map(|(i, rule)| rule.components().map(move |of| (i, of)))
    }

    /// As [`Scene::shapes`], with the growth of those that grow, and how many bodies there are of each.
    pub(in super::super) fn growing(&self) -> impl Iterator<Item = (&'static str, usize, Shape, &Growth, u64)> + '_ {
        let own = |group: Option<&str>, shape: &Shape| self.growth_of_body(group, shape).map(|(growth, _)| growth);
        let bodies = self.bodies.iter().enumerate();
        let bodies =
            bodies.filter_map(move |(i, b)| Some(("bodies", i, b.shape, own(b.group.as_deref(), &b.shape)?, 1)));
        bodies.chain(
            self.generated()
                .filter_map(move |(i, (count, shape, group))| Some(("generate", i, shape, own(group, &shape)?, count))),
        )
    }

    /// The shapes of all bodies.
    #[cfg(feature = "gpu")]
    pub(crate) fn all_shapes(&self) -> impl Iterator<Item = Shape> + '_ {
        self.shapes().map(|(_, _, shape)| shape)
    }

    pub(super) fn check_contact(&self, key: &Key) -> Result<(), SceneError> {
        let contact = &self.contact;
        let tolerance_key = key.field("overlap_tolerance");
        positive(&tolerance_key, contact.overlap_tolerance)?;
        let thinnest = self.thinnest();
        if contact.overlap_tolerance >= thinnest {
            let message = format!(
                "must be less than the thinnest body's thickness, {thinnest}; it is a length",
                thinnest = at_most(thinnest)
            );
            return Err(SceneError::bad(tolerance_key, message));
        }
        let positions = self.bodies.iter().flat_map(|body| body.position.map(f64::abs));
        let farthest = positions.chain(self.generate.iter().map(Generate::farthest)).fold(0.0_f64, f64::max);
        if farthest * f64::EPSILON > contact.overlap_tolerance {
            let message = format!(
                "is finer than 64-bit floats are at the farthest body's coordinate, {farthest}",
                farthest = short(farthest)
            );
            return Err(SceneError::bad(tolerance_key, message));
        }
        if contact.max_recursions == 0 {
            let message = "must be at least 1; a step without recursion is contact.method \"snsd\"";
            return Err(SceneError::bad(key.field("max_recursions"), message));
        }
        if let Some(cutoff) = contact.cutoff {
            number(&key.field("cutoff"), cutoff)?;
            if cutoff < 0.0 {
                return Err(SceneError::bad(
                    key.field("cutoff"),
                    format!("must not be negative, not {cutoff}", cutoff = short(cutoff)),
                ));
            }
        }
        match contact.method {
            Method::Multisphere { count } => {
                self.check_multisphere(&key.field("method").field("multisphere").field("count"), count)
            }
            Method::Relcp | Method::Snsd => Ok(()),
        }
    }

    fn check_multisphere(&self, key: &Key, count: u32) -> Result<(), SceneError> {
        for (list, index, shape) in self.shapes() {
            if let Err(error) = shape.check_proxy(count as usize) {
                let body = Key::ROOT.field(list);
                let body = body.index(index);
                return Err(match error {
                    ProxyError::NoMajorAxis | ProxyError::Superellipsoid | ProxyError::Custom => {
                        SceneError::bad(body, error.to_string())
                    }
                    ProxyError::Even { .. } | ProxyError::TooFew { .. } => {
                        SceneError::bad(key, format!("{error} (the shape of {body})"))
                    }
                });
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
