//! Problems of spheres by hand: contacts of spheres and planes, one step of the law with inertia.

use crate::lcp::friction::Cone;
use crate::lcp::{Outcome, Problem, Solver, velocity};
use glam::DVec3;
use std::collections::HashMap;

/// A step, and its constants.
#[derive(Clone, Copy)]
pub struct Step {
    pub dt: f64,
    pub friction: f64,
    pub gravity: DVec3,
    /// Elastic slip of a mean contact at its limit, a length.
    pub slip: f64,
    /// Gaps up to this have rows.
    pub near: f64,
}

/// Spheres of radius and mass 1 within planes, each a point and a normal to the inside.
pub struct Spheres {
    pub position: Vec<DVec3>,
    pub velocity: Vec<DVec3>,
    pub spin: Vec<DVec3>,
    pub planes: Vec<(DVec3, DVec3)>,
    /// The inverse moment of inertia, zero for spheres that do not turn.
    pub turning: f64,
    /// Forces of contacts at the end of the last step: normal ones, and friction in space.
    pub forces: HashMap<(u32, u32), (f64, DVec3)>,
}

/// A contact of `a` and `b`, a sphere or after all spheres a plane, with the normal from `a` to `b`.
#[derive(Clone, Copy, Debug)]
pub struct Contact {
    pub pair: [u32; 2],
    pub gap: f64,
    pub normal: DVec3,
}

pub fn tangents(n: DVec3) -> [DVec3; 2] {
    let h = if n.x.abs() < 0.7 { DVec3::X } else { DVec3::Y };
    let t = n.cross(h).normalize();
    [t, n.cross(t)]
}

impl Spheres {
    pub fn new(position: Vec<DVec3>, planes: Vec<(DVec3, DVec3)>) -> Self {
        let rest = vec![DVec3::ZERO; position.len()];
        Spheres { position, velocity: rest.clone(), spin: rest, planes, turning: 2.5, forces: HashMap::new() }
    }

    /// The contacts up to a gap.
    pub fn contacts(&self, near: f64) -> Vec<Contact> {
        let mut contacts = Vec::new();
        for (a, p) in (0..).zip(&self.position) {
            for (b, q) in (0..).zip(&self.position).skip(a as usize + 1) {
                let apart = *q - *p;
                if apart.length_squared() < (2.0 + near) * (2.0 + near) {
                    let gap = apart.length() - 2.0;
                    contacts.push(Contact { pair: [a, b], gap, normal: apart.normalize() });
                }
            }
            for (wall, (point, inside)) in (self.position.len() as u32..).zip(&self.planes) {
                let gap = (*p - *point).dot(*inside) - 1.0;
                if gap < near {
                    contacts.push(Contact { pair: [a, wall], gap, normal: -*inside });
                }
            }
        }
        contacts
    }

    /// The velocity that a sphere would have without contact.
    fn free(&self, body: usize, step: &Step) -> DVec3 {
        self.velocity[body] + step.dt * step.gravity
    }

    /// The problem of a step, and the multipliers of the last one.
    pub fn problem(&self, contacts: &[Contact], step: &Step) -> (Problem<6>, Vec<f64>) {
        let spheres = self.position.len();
        let mut problem = Problem { bodies: spheres + self.planes.len(), ..Problem::default() };
        let mut gamma = Vec::new();
        let pushes: Vec<f64> = self.forces.values().map(|(n, _)| *n).filter(|n| *n > 0.0).collect();
        let mean = step.friction * pushes.iter().sum::<f64>() / pushes.len().max(1) as f64;
        let compliance = if mean > 0.0 { step.slip / mean } else { 0.0 };
        for contact in contacts {
            let (n, half) = (contact.normal, contact.gap / 2.0);
            let [t1, t2] = tangents(n);
            let (push, friction) = self.forces.get(&(contact.pair[0], contact.pair[1])).copied().unwrap_or_default();
            for (row, d) in [n, t1, t2].into_iter().enumerate() {
                let mut blocks = [[0.0; 6]; 2];
                let (mut offset, last) = (if row == 0 { contact.gap } else { 0.0 }, friction.dot(d));
                for (side, body) in contact.pair.iter().map(|body| *body as usize).enumerate().filter(|b| b.1 < spheres)
                {
                    let sign = if side == 0 { -1.0 } else { 1.0 };
                    let arm = -sign * (1.0 + half) * n;
                    let turn = arm.cross(d);
                    offset += step.dt * sign * (self.free(body, step).dot(d) + self.spin[body].dot(turn));
                    let (push, turn) = (step.dt * sign * d, step.dt * sign * self.turning.sqrt() * turn);
                    blocks[side] = [push.x, push.y, push.z, turn.x, turn.y, turn.z];
                }
                if row > 0 {
                    offset -= compliance * last;
                }
                problem.pair.push(contact.pair);
                problem.jacobian.push(blocks);
                problem.q.push(offset);
                problem.cones.push(if row == 0 { Cone::Friction(step.friction) } else { Cone::Tangent });
                problem.compliance.push(if row == 0 { 0.0 } else { compliance });
                gamma.push(if row == 0 { push } else { last });
            }
        }
        (problem, gamma)
    }

    /// Moves the spheres by a solution.
    pub fn accept(&mut self, contacts: &[Contact], problem: &Problem<6>, gamma: &[f64], step: &Step) {
        let v = velocity(problem, gamma);
        for (body, [x, y, z, a, b, c]) in v.into_iter().enumerate().take(self.position.len()) {
            self.velocity[body] = self.free(body, step) + DVec3::new(x, y, z);
            self.spin[body] += self.turning.sqrt() * DVec3::new(a, b, c);
            self.position[body] += step.dt * self.velocity[body];
        }
        self.forces.clear();
        for (contact, gamma) in contacts.iter().zip(gamma.as_chunks::<3>().0) {
            let [t1, t2] = tangents(contact.normal);
            self.forces.insert((contact.pair[0], contact.pair[1]), (gamma[0], gamma[1] * t1 + gamma[2] * t2));
        }
    }

    /// Kinetic and potential energy.
    pub fn energy(&self, step: &Step) -> f64 {
        let of = |i: usize| {
            let (v, w) = (self.velocity[i].length_squared(), self.spin[i].length_squared());
            0.5 * (v + w / self.turning) - step.gravity.dot(self.position[i])
        };
        (0..self.position.len()).map(of).sum()
    }

    /// Takes a step.
    pub fn step(&mut self, step: &Step, solver: &mut Solver<6>) -> Outcome {
        let contacts = self.contacts(step.near);
        let (problem, mut gamma) = self.problem(&contacts, step);
        let outcome = solver.solve(&problem, &mut gamma);
        self.accept(&contacts, &problem, &gamma, step);
        outcome
    }
}

/// Spheres in layers of `side` times `side`, out of line, in a box that they fall into.
pub fn heap(side: usize, layers: usize) -> Spheres {
    let mut drawn = 7_u64;
    let mut jitter = || {
        drawn = drawn.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        0.2 * ((drawn >> 40) as f64 / (1_u64 << 24) as f64 - 0.5)
    };
    let place = |i: usize| 1.1 + 2.2 * i as f64;
    let mut position = Vec::new();
    for (z, y, x) in (0..layers).flat_map(|z| (0..side).flat_map(move |y| (0..side).map(move |x| (z, y, x)))) {
        position.push(DVec3::new(place(x) + jitter(), place(y) + jitter(), place(z) + jitter()));
    }
    let wide = 2.2 * side as f64;
    let (low, high) = (DVec3::ZERO, DVec3::new(wide, wide, 0.0));
    Spheres::new(
        position,
        vec![(low, DVec3::Z), (low, DVec3::X), (low, DVec3::Y), (high, -DVec3::X), (high, -DVec3::Y)],
    )
}
