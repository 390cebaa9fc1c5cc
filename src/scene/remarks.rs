//! Warnings about a valid scene before it runs.

use super::{Generate, Scene, generate};
use crate::digits::{few, short, significant};
use glam::DVec3;

/// An overlap tolerance above this part of the thinnest body's thickness gives a warning: overlaps would be visible.
const LARGE_TOLERANCE: f64 = 0.1;
/// A body that moves by more than this in a step, in thicknesses, gives a warning. In the built-in scenes, forces reach
/// at most a fifth of it, and heat half of it (`sedimentation`).
pub(crate) const FARTHEST: f64 = 1.0;
/// The proposed time step moves bodies by this part of their thickness.
pub(crate) const PROPOSED: f64 = 0.1;
/// Growth or strain above this in a step gives a warning. A colony of 200 cells takes 400 products per step at 0.01 and
/// 140,000 at 0.1, where its contact forces are wrong by 7 % of the load. Built-in scenes stay below it.
const LARGEST_STRAIN: f64 = 0.05;
/// Two rules with boxes about one centre whose sides differ by more than this part give a warning: their bodies are not
/// mixed.
const UNMIXED: f64 = 0.1;
/// A bond in heat whose stretch has a variance that differs from `kT / k` by more than this part gives a warning. It is
/// 0.11 in `filament`.
const WRONG_VARIANCE: f64 = 0.2;
/// The proposed time step leaves this part.
const RIGHT_VARIANCE: f64 = 0.02;

impl Scene {
    /// Warnings about settings that are allowed but seldom intended.
    ///
    /// ```
    /// use relcp::scene::{Body, Time};
    /// use relcp::{Scene, Shape};
    /// let mut scene = Scene::new("bacteria in metres", Time::new(0.1, 1.0));
    /// scene.bodies.push(Body::new(Shape::Sphere { radius: 6e-6 }, [0.0; 3]));
    /// assert!(scene.warnings()[0].starts_with("contact.overlap_tolerance, 1e-5 by default, is 83 % of"));
    /// scene.contact.overlap_tolerance = 1e-11;
    /// assert!(scene.warnings().is_empty());
    /// ```
    pub fn warnings(&self) -> Vec<String> {
        let remarks = [
            self.large_tolerance(),
            self.long_step(),
            self.hot_step(),
            self.large_strain(),
            self.cold_crowd(),
            self.stiff_hot_bond(),
            self.unmixed(),
        ];
        remarks.into_iter().flatten().collect()
    }

    /// A warning if a force, a bond, a wall or an initial velocity moves a body in a step by more than its thickness.
    pub(crate) fn long_step(&self) -> Option<String> {
        let forces = self.farthest_drive().map(|(force, way)| (format!("forces.{force} moves"), way));
        let bodies = self.bodies.iter().enumerate().filter(|_| self.dynamics.has_inertia());
        let starts = bodies.map(|(i, body)| {
            let way = self.time.dt * DVec3::from(body.velocity.unwrap_or_default()).length() / body.shape.thickness();
            (format!("bodies.{i}.velocity carries"), way)
        });
        let walls = self.farthest_wall().map(|(wall, way)| (format!("walls.{wall}.motion moves"), way));
        let bonds = self.farthest_bond().map(|(bond, way)| (format!("bonds.{bond} moves"), way));
        let all = forces.into_iter().chain(bonds).chain(walls).chain(starts);
        let (what, way) = all.max_by(|a, b| a.1.total_cmp(&b.1))?;
        (way > FARTHEST && way.is_finite()).then(|| {
            format!(
                "time.dt is too long: {what} a body by {} of its thicknesses in a step; with {} it is a tenth",
                few(way),
                significant(self.time.dt * PROPOSED / way, 1)
            )
        })
    }

    /// A warning if heat moves bodies in a step by more than their thickness.
    fn hot_step(&self) -> Option<String> {
        let way = self.farthest_heat().filter(|way| *way > FARTHEST && way.is_finite())?;
        // Brownian displacements grow with the square root of time, those with inertia linearly.
        let power = if self.dynamics.has_inertia() { 1 } else { 2 };
        Some(format!(
            "time.dt is too long: heat moves a body by {} of its thicknesses in a step; with {} it is a tenth",
            few(way),
            significant(self.time.dt * (PROPOSED / way).powi(power), 1)
        ))
    }

    /// A warning if the growth or the strain in a step is large.
    fn large_strain(&self) -> Option<String> {
        let ways =
            [("cells grow by", self.largest_growth()), ("the flow or the cell strains by", self.largest_strain())];
        let (what, part) = ways.into_iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
        (part > LARGEST_STRAIN && part.is_finite()).then(|| {
            format!(
                "time.dt is too long: {what} {} % in a step; with {} it is 1 %",
                few(100.0 * part),
                significant(0.01 * self.time.dt / part, 1)
            )
        })
    }

    /// A warning for crowds with inertia and heat.
    fn cold_crowd(&self) -> Option<String> {
        let is_elastic = self.contact.restitution.bodies == 1.0;
        let is_crowd = self.thermal.is_some() && self.dynamics.has_inertia() && self.body_count() > 1 && !is_elastic;
        is_crowd.then(|| {
            "thermal with inertia: contact takes energy, so that bodies that meet are colder than thermal.temperature \
             (docs/motion.md)"
                .into()
        })
    }

    /// A warning if a bond's stretch in heat has the wrong variance, under the overdamped law. A step that takes back
    /// the part `a` of the stretch `s` leaves `s (1 - a)` and heat where the bond is explicit, `(s + heat) / (1 + a)`
    /// where it is implicit, so that the variance is `kT / k` over `1 - a / 2` or `1 + a / 2` (of two bodies alone).
    fn stiff_hot_bond(&self) -> Option<String> {
        if self.thermal.is_none() || self.dynamics.has_inertia() {
            return None;
        }
        let bond = self.stiffest_bond().filter(|bond| bond.part.is_finite())?;
        let over = if bond.is_implicit { 1.0 + 0.5 * bond.part } else { 1.0 - 0.5 * bond.part };
        let is_right = over > 0.0 && (1.0 / over - 1.0).abs() <= WRONG_VARIANCE;
        (!is_right).then(|| {
            let (kind, variance) = match bond.is_implicit {
                true => ("implicit", few(1.0 / over)),
                false if over > 0.0 => ("explicit", few(1.0 / over)),
                false => ("explicit", "many".into()),
            };
            format!(
                "thermal with stiff bonds: in steps of time.dt the stretch of {}, which is {kind}, has {variance} times its variance kT / k in heat; with a time.dt of {} it is right to {} %",
                bond.key,
                significant(2.0 * RIGHT_VARIANCE * self.time.dt / bond.part, 1),
                few(100.0 * RIGHT_VARIANCE)
            )
        })
    }

    /// A warning if several rules place bodies in different boxes about one centre.
    fn unmixed(&self) -> Option<String> {
        let boxes = (0..self.generate.len()).filter_map(|i| Some((i, generate::open_side(self, i)?)));
        // A second box elsewhere is intended.
        let boxes =
            boxes.filter(|(i, _)| matches!(self.generate[*i], Generate::Isotropic { center: [0.0, 0.0, 0.0], .. }));
        let least = boxes.clone().min_by(|a, b| a.1.total_cmp(&b.1))?;
        let largest = boxes.max_by(|a, b| a.1.total_cmp(&b.1))?;
        (largest.1 > (1.0 + UNMIXED) * least.1).then(|| {
            format!(
                "generate.{} and generate.{} place bodies about the origin in boxes {} and {} wide, by their \
                 volume_fraction: they are not mixed over the larger one; `mixture` of one rule mixes them",
                least.0,
                largest.0,
                few(least.1),
                few(largest.1)
            )
        })
    }

    fn large_tolerance(&self) -> Option<String> {
        let (tolerance, thinnest) = (self.contact.overlap_tolerance, self.thinnest());
        let part = tolerance / thinnest;
        (part > LARGE_TOLERANCE).then(|| {
            let is_default = tolerance == Scene::new("", self.time).contact.overlap_tolerance;
            let given = if is_default { " by default," } else { "," };
            let (percent, thickness) = ((100.0 * part).round(), short(thinnest));
            format!(
                "contact.overlap_tolerance, {}{given} is {percent} % of the thinnest body's thickness, {thickness}: bodies may overlap by so much; set it to {} or less",
                short(tolerance),
                short(1e-5 * 10_f64.powi((2.0 * thinnest).log10().floor() as i32)),
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::{Bond, Thermal};
    use crate::scene::{Body, Time};
    use crate::shape::Shape;

    fn balls(count: usize) -> Scene {
        let mut scene = Scene::new("balls", Time::new(0.01, 1.0));
        let ball = |i: usize| Body::new(Shape::Sphere { radius: 0.5 }, [2.0 * i as f64, 0.0, 0.0]);
        scene.bodies = (0..count).map(ball).collect();
        scene
    }

    #[test]
    fn heat_and_stretched_bonds_that_move_bodies_by_their_thickness_are_remarked_on() {
        let mut scene = balls(2);
        scene.thermal = Some(Thermal::new(1.0));
        let way = |scene: &Scene| scene.farthest_heat().unwrap();
        // A Brownian ball moves by sqrt(2 kT dt / drag) along an axis; ten times as far at a hundred times the heat.
        let first = way(&scene);
        scene.thermal = Some(Thermal::new(100.0));
        assert!((way(&scene) / first - 10.0).abs() < 1e-12);
        scene.thermal = Some(Thermal::new(4.0 / (first * first)));
        assert!((way(&scene) - 2.0).abs() < 1e-12);
        let warning = &scene.warnings()[0];
        assert!(warning.starts_with("time.dt is too long: heat moves a body by 2 of its thicknesses"), "{warning}");
        scene.time.dt *= 0.0024;
        assert_eq!(scene.warnings(), [""; 0]);
        scene.thermal = None;
        scene.bonds.push(Bond { length: 1e18, ..Bond::new([0, 1], [[0.0; 3]; 2], 1.0) });
        assert!(scene.warnings()[0].starts_with("time.dt is too long: bonds.0 moves a body by"));
        scene.bodies.iter_mut().for_each(|body| body.fixed = true);
        assert_eq!(scene.warnings(), [""; 0]);
    }

    /// Two free balls of the resistance 1 (`drag` of the default law): a stretch of rate `2 k`.
    #[test]
    fn bonds_whose_length_in_heat_is_wrong_are_remarked_on() {
        let mut scene = balls(2);
        scene.bonds.push(Bond { length: 1.5, ..Bond::new([0, 1], [[0.0; 3]; 2], 1.0) });
        let part = |scene: &Scene| scene.stiffest_bond().unwrap().part;
        let first = part(&scene);
        let with = |wanted: f64, implicit: bool| {
            let mut scene = scene.clone();
            scene.thermal = Some(Thermal::new(1e-6));
            scene.bonds[0].stiffness = wanted / first;
            scene.bonds[0].implicit = Some(implicit);
            scene.warnings()
        };
        assert_eq!((with(0.3, false), with(0.45, true)), (Vec::new(), Vec::new()));
        assert!(with(1.0, false)[0].contains("bonds.0, which is explicit, has 2 times"), "{:?}", with(1.0, false));
        assert!(with(2.0, true)[0].contains("bonds.0, which is implicit, has 0.5 times"), "{:?}", with(2.0, true));
        // A fixed body yields nothing.
        scene.bodies[0].fixed = true;
        assert!((part(&scene) / first - 0.5).abs() < 1e-12);
    }

    #[test]
    #[cfg(feature = "files")]
    fn built_in_scenes_have_no_warnings_and_move_by_a_fifth_of_a_thickness_at_most() {
        for built_in in crate::scene::BuiltIn::ALL {
            let scene = Scene::built_in(built_in.name).unwrap();
            let way = scene.farthest_drive().map_or(0.0, |(_, way)| way);
            assert!(scene.warnings().is_empty() && way < 0.2, "{}: {way} {:?}", built_in.name, scene.warnings());
        }
    }
}
