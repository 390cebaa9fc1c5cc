//! Checks before placement that walls leave room for a rule's bodies.

use super::super::error::{FaultKind, SceneError};
use super::isotropic::{Inside, Order, reachable_fraction};
use crate::digits::few;
use crate::separation::Placed;
use crate::shape::Shape;
use crate::walls::Walls;
use glam::{DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Sample points for the part of a box inside the walls: a tenth is found to about 2 % of itself.
const POINTS: usize = 20_000;
/// The radius of a sample point over that of a body.
const POINT: f64 = 1e-9;
/// The largest fractions that discs and spheres fill by random sequential placement (0.5471 and 0.3841; Y. Feder,
/// "Random sequential adsorption", 1980, and later simulations), plus two hundredths for the sampling.
const DISCS: f64 = 0.57;
const SPHERES: f64 = 0.40;
/// For other shapes: this many times the fraction that is accepted.
const OF_REACHED: f64 = 2.0;

/// The box in which a rule's centres are drawn.
pub(super) struct Room<'a> {
    pub order: &'a Order,
    pub sides: DVec3,
    /// Which axes are periodic: there bodies do not extend beyond the box.
    pub periodic: [bool; 3],
    pub walls: &'a Walls,
}

impl Room<'_> {
    /// Refuses bodies that would fill more of the part inside the walls than random placement can, before any is drawn.
    pub fn check(&self) -> Result<(), SceneError> {
        if self.walls.is_empty() {
            return Ok(());
        }
        let filled = self.filled();
        if filled <= self.most() {
            return Ok(());
        }
        let count = self.order.count();
        let why = if filled.is_finite() {
            format!(
                "they would fill {} of that part; random placement reaches at most {}",
                few(filled),
                few(self.most())
            )
        } else {
            "no body fits there".into()
        };
        Err(self.fault(format!("{count} bodies do not fit: {}; {why}", self.described())))
    }

    /// The error if no free position was found for a body after `done`.
    pub fn full(&self, done: u64) -> SceneError {
        let count = self.order.count();
        let place = if self.walls.is_empty() { self.region() } else { self.described() };
        self.fault(format!("{done} of {count} bodies were placed; no free place was found for the next: {place}"))
    }

    fn fault(&self, message: String) -> SceneError {
        let name = if self.order.volume_fraction.is_some() { "volume_fraction" } else { "count" };
        let key = format!("generate.{}.isotropic.{name}", self.order.rule);
        let fault = SceneError::new(FaultKind::Placement, key, message);
        if let Some(inside) = self.order.inside {
            let larger = if inside.is_own { "make `region` larger" } else { "make the space inside the walls larger" };
            return fault.with_help(format!("place fewer bodies, or {larger}"));
        }
        fault.with_help(match (self.walls.is_empty(), name) {
            (true, "count") => "place fewer bodies, or make the cell larger",
            (true, _) => "choose a smaller volume_fraction",
            (false, "count") => "place fewer bodies, make the cell larger, or set `center` to the middle of the walls",
            (false, _) => {
                "set `center` to the middle of the walls, choose a smaller volume_fraction, which makes the region larger, or place fewer bodies"
            }
        })
    }

    /// The region, in words.
    fn region(&self) -> String {
        match self.order.inside {
            Some(Inside { is_own: true, .. }) => return "bodies are placed inside of `region` and the walls".into(),
            Some(Inside { is_own: false, .. }) => return "bodies are placed inside of the walls".into(),
            None => {}
        }
        let [x, y, z] = self.sides.to_array().map(few);
        let sides = if self.order.planar { vec![x, y] } else { vec![x, y, z] };
        let name = match (self.order.planar, sides.iter().all(|side| *side == sides[0])) {
            (true, true) => format!("the square of side {}", sides[0]),
            (true, false) => format!("the rectangle of sides {}", sides.join(" and ")),
            (false, true) => format!("the cube of side {}", sides[0]),
            (false, false) => format!("the box of sides {}", sides.join(", ")),
        };
        match self.order.center.to_array() {
            [0.0, 0.0, 0.0] => format!("centres are drawn in {name} about the origin"),
            center => format!("centres are drawn in {name} about [{}]", center.map(few).join(", ")),
        }
    }

    /// The region, and which part of it is inside the walls.
    fn described(&self) -> String {
        if self.order.inside.is_some() {
            let measure = if self.order.planar { "area" } else { "volume" };
            let size = self.size(self.sides) * self.inside(self.sides);
            return format!("{}, which have the {measure} {}", self.region(), few(size));
        }
        match self.inside(self.sides) {
            0.0 => format!("{}, no part of which is inside the walls", self.region()),
            1.0 => self.region(),
            part => format!("{}, of which {} % is inside the walls", self.region(), few(100.0 * part)),
        }
    }

    /// The volume fraction of the bodies in the part that is inside the walls and within their reach.
    fn filled(&self) -> f64 {
        let Order { components, planar, .. } = self.order;
        let reach = 2.0 * components.iter().map(|(_, shape)| shape.bounding_radius()).fold(0.0, f64::max);
        let sides = DVec3::from_array([0, 1, 2].map(|axis| {
            let ends = self.periodic[axis] || (*planar && axis == 2) || self.order.inside.is_some();
            self.sides[axis] + if ends { 0.0 } else { reach }
        }));
        self.order.volume() / (self.size(sides) * self.inside(sides))
    }

    /// The volume of a box, in a planar scene the area.
    fn size(&self, sides: DVec3) -> f64 {
        if self.order.planar { sides.x * sides.y } else { sides.element_product() }
    }

    /// The part of a box about the centre that is inside the walls.
    fn inside(&self, sides: DVec3) -> f64 {
        let mut random = ChaCha8Rng::seed_from_u64(0);
        let thinnest = self.order.components.iter().map(|(_, shape)| shape.bounding_radius()).fold(f64::MAX, f64::min);
        let point = Shape::Sphere { radius: POINT * thinnest };
        let is_inside = |_: &usize| {
            let mut position = self.order.center + sides * (DVec3::from_array(random.random::<[f64; 3]>()) - 0.5);
            if self.order.planar {
                position.z = 0.0;
            }
            self.walls.deepest(&Placed { shape: point, position, orientation: DQuat::IDENTITY }).is_none()
        };
        (0..POINTS).filter(is_inside).count() as f64 / POINTS as f64
    }

    /// The largest fraction that random placement fills; in a mixture, each component fills what the others leave.
    fn most(&self) -> f64 {
        let Order { components, planar, .. } = self.order;
        let of = |shape: &Shape| match (shape, planar) {
            (Shape::Sphere { .. }, true) => DISCS,
            (Shape::Sphere { .. }, false) => SPHERES,
            _ => OF_REACHED * reachable_fraction(shape, *planar),
        };
        match &components[..] {
            [(_, shape)] => of(shape),
            _ => 1.0 - components.iter().map(|(_, shape)| (1.0 - of(shape)).max(0.0)).product::<f64>(),
        }
    }
}
