//! The coefficients of friction of a scene's contacts, by the numbers of groups and of walls' surfaces.

use super::Friction;
use crate::walls::surface_of;
use std::collections::BTreeMap;

/// The coefficient of friction of every contact that a scene may have, and how far stick gives.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Coefficients {
    bodies: f64,
    /// By two groups, the smaller number first.
    groups: BTreeMap<[u32; 2], f64>,
    /// By a wall's surface.
    surfaces: Vec<f64>,
    /// How far a mean contact slips elastically before it slides, a length.
    pub elastic_slip: f64,
}

impl Coefficients {
    /// Those of a scene whose groups have these names; `surfaces` has the wall's own coefficient of each surface,
    /// where it has one.
    pub fn new(friction: &Friction, names: &[String], surfaces: &[Option<f64>], elastic_slip: f64) -> Coefficients {
        let number = |name: &String| names.iter().position(|known| known == name).map(|number| number as u32);
        let of_groups = friction.groups.iter().filter_map(|of| {
            let [a, b] = [number(&of.between[0])?, number(&of.between[1])?];
            Some(([a.min(b), a.max(b)], of.is))
        });
        Coefficients {
            bodies: friction.bodies,
            groups: of_groups.collect(),
            surfaces: surfaces.iter().map(|own| own.unwrap_or(friction.walls)).collect(),
            elastic_slip,
        }
    }

    /// Whether no contact has friction.
    pub fn is_none(&self) -> bool {
        self.bodies == 0.0 && self.groups.values().chain(&self.surfaces).all(|coefficient| *coefficient == 0.0)
    }

    /// Of a pair, where bodies have these groups. The second of a pair may be a surface of a wall.
    pub fn of_pair(&self, [a, b]: [u32; 2], groups: &[u32]) -> f64 {
        match surface_of(b) {
            Some(surface) => self.of_surface(surface),
            None => self.of_bodies([a, b].map(|body| groups[body as usize])),
        }
    }

    /// Between bodies of these groups.
    fn of_bodies(&self, [a, b]: [u32; 2]) -> f64 {
        if self.groups.is_empty() {
            return self.bodies;
        }
        self.groups.get(&[a.min(b), a.max(b)]).copied().unwrap_or(self.bodies)
    }

    /// Between a body and a surface of a wall.
    fn of_surface(&self, surface: usize) -> f64 {
        self.surfaces.get(surface).copied().unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::super::GroupFriction;
    use super::*;

    #[test]
    fn groups_and_walls_have_their_own_coefficients() {
        let mut friction = Friction::of_all(0.5);
        friction.walls = 0.1;
        friction.groups = vec![GroupFriction::new(["b", "a"], 0.2), GroupFriction::new(["a", "a"], 0.0)];
        let names = ["a".to_owned(), "b".to_owned()];
        let all = Coefficients::new(&friction, &names, &[None, Some(0.7), Some(0.0)], 1e-4);
        assert_eq!(
            [[0, 1], [1, 0], [0, 0], [1, 1], [0, 9]].map(|groups| all.of_bodies(groups)),
            [0.2, 0.2, 0.0, 0.5, 0.5]
        );
        assert_eq!([0, 1, 2].map(|surface| all.of_surface(surface)), [0.1, 0.7, 0.0]);
        assert!(!all.is_none());
        assert!(Coefficients::default().is_none());
        let wall = Coefficients::new(&Friction::default(), &[], &[Some(0.3)], 0.0);
        assert!(!wall.is_none() && wall.of_bodies([0, 0]) == 0.0);
    }
}
