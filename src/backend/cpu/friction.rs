//! Friction in a step: which contacts have it, what moves their surfaces beside bodies, and what it did.

use super::Cpu;
use super::motions::Motions;
use super::narrow_phase::Near;
use super::row_set::{Contact, FrictionCone, RowSet};
use super::setup::Setup;
use super::start::Start;
use super::team::Team;
use crate::bodies::Bodies;
use crate::constraint::friction::{ElasticSlip, Sliding};
use crate::constraint::{Mover, Row};
use crate::dynamics::{self, Twist};
use crate::lcp::Cone;
use crate::step::FrictionReport;
use crate::walls::surface_of;
use crate::warm::Warm;
use glam::DVec3;

impl Setup {
    /// The compliance of stick in a step that follows one with these forces: a mean contact at its limit has slipped by
    /// the scene's elastic slip. Zero where nothing pushed.
    fn compliance(&self, bodies: &Bodies, last: &[Warm]) -> f64 {
        let limits =
            last.iter().filter(|w| w.gamma > 0.0).map(|w| w.gamma * self.friction.of_pair(w.pair, &bodies.group));
        let (sum, count) =
            limits.filter(|limit| *limit > 0.0).fold((0.0, 0u32), |(sum, n), limit| (sum + limit, n + 1));
        if count == 0 { 0.0 } else { self.friction.elastic_slip * f64::from(count) / sum }
    }
}

/// How contacts of a step with friction stick; none in a step without.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Stick {
    compliance: f64,
    /// The largest normal force at the end of the last step.
    most: f64,
}

impl Stick {
    /// That of the step that `start` begins, after the step with the warm start `last`.
    pub(super) fn of(setup: &Setup, start: &Start, last: &[Warm]) -> Option<Stick> {
        let acts = !setup.friction.is_none() && !start.parting;
        let most = || last.iter().fold(0.0, |most: f64, warm| most.max(warm.gamma));
        acts.then(|| Stick { compliance: setup.compliance(&start.bodies, last), most: most() })
    }
}

/// The stages that the rows of a contact are made from.
#[derive(Clone, Copy)]
pub(super) struct Making<'a> {
    pub(super) setup: &'a Setup,
    pub(super) start: &'a Start,
    pub(super) motions: &'a Motions,
    pub(super) stick: Option<Stick>,
}

impl Making<'_> {
    /// The rows of `near`, which was found where the velocities `reached` lead in the present part. `held` is the
    /// friction force that it ended the last step with.
    pub(super) fn contact<const D: usize>(&self, near: &Near, reached: &[Twist], held: DVec3) -> Contact<D> {
        let Making { start, motions, .. } = *self;
        self.contact_of(motions.row(start, near, reached), near, reached, held)
    }

    /// The same with this normal row.
    pub(super) fn contact_of<const D: usize>(
        &self,
        normal: Row<D>,
        near: &Near,
        reached: &[Twist],
        held: DVec3,
    ) -> Contact<D> {
        let movers = near.pair.map(|number| self.motions.mover(self.start, number, reached));
        Contact { normal, sliding: self.sliding(near, movers, held) }
    }

    fn sliding<const D: usize>(&self, near: &Near, movers: [Mover<'_>; 2], held: DVec3) -> Option<Sliding<D>> {
        let Stick { compliance, .. } = self.stick?;
        let mu = self.setup.friction.of_pair(near.pair, &self.start.bodies.group);
        let slip = ElasticSlip { compliance, held };
        (mu > 0.0)
            .then(|| Sliding::new(mu, &near.found, movers, self.surface_velocity(near), slip, self.start.interval))
    }

    /// The velocity of the second body's surface against the first one's, beside those of the bodies: of a wall, of an
    /// image in a cell that changes, and by growth.
    fn surface_velocity(&self, near: &Near) -> DVec3 {
        let Making { setup, start, .. } = *self;
        let [a, b] = near.pair;
        let (found, grows) =
            (&near.found, |body: u32, lever, normal| start.growth_velocity(body as usize, lever, normal));
        let of_a = grows(a, found.lever_a, found.normal);
        let of_b = match surface_of(b) {
            Some(surface) => {
                let point = start.bodies.position[a as usize] + found.lever_a + found.separation * found.normal;
                start.walls(setup).velocity(surface, point, start.span())
            }
            None => start.image_velocity(setup, a as usize, b as usize) + grows(b, found.lever_b, -found.normal),
        };
        of_b - of_a
    }
}

impl Start {
    /// How fast growth moves the surface of a body where `lever` touches it with the outward normal `normal`, along its
    /// axis.
    fn growth_velocity(&self, body: usize, lever: DVec3, normal: DVec3) -> DVec3 {
        let Some(longer) = self.lengthened.get(body).copied().filter(|longer| *longer != 0.0) else {
            return DVec3::ZERO;
        };
        let placed = self.placed_at(body, self.pose(body));
        // The body has the length at the end of the part already; how a place moves is linear in the length added.
        let Some(to) = placed.shape.growing_length().and_then(|length| placed.shape.grown(length + longer)) else {
            return DVec3::ZERO;
        };
        dynamics::stretch(&placed, &to, lever, normal) / self.interval
    }
}

impl<const D: usize, T: Team> Cpu<D, T> {
    /// What friction does on the way to the trial; none in a step without.
    pub(super) fn find_friction(&self) -> Option<FrictionReport> {
        let report = self.rows.find_friction(&self.trial.scaled)?;
        Some(FrictionReport { locked: self.locks(), ..report })
    }

    /// Whether bodies lock: the largest normal force of a contact with friction grows in the step, and is more than
    /// [`MOST_LEVERAGE`] times what moves all bodies.
    fn locks(&self) -> bool {
        let normal = |cone: FrictionCone| self.rows.gamma[cone.normal];
        let most = self.rows.cones().map(normal).fold(0.0, f64::max);
        self.stick.is_some_and(|stick| most > stick.most) && most > MOST_LEVERAGE * self.load()
    }

    /// The force that moves all bodies: the sum of what each alone would need to move as it does freely, to the trial,
    /// by its growth, and by the overlap tolerance in a step.
    fn load(&self) -> f64 {
        let least = self.setup.overlap_tolerance / self.start.step_length(&self.setup);
        let of_body = |i: usize| {
            let factor = &self.motions.motion[i].factor;
            let growth = self.start.lengthened.get(i).map_or(0.0, |longer| longer / self.start.interval);
            let [free, there] = [self.driven(i), self.trial.twist[i]];
            let linear = free.linear.length() + there.linear.length() + growth + least;
            let inverse = factor.rotation.inverse();
            let torque = inverse * (inverse * (free.angular.abs() + there.angular.abs()));
            let turning = torque.length() / self.start.bodies.shape[i].bounding_radius();
            linear / factor.translation.mean_square() + if turning.is_finite() { turning } else { 0.0 }
        };
        (0..self.trial.twist.len()).filter(|i| !self.start.is_held(*i)).map(of_body).sum()
    }
}

impl<const D: usize> RowSet<D> {
    /// What friction does on the way to the trial with these scaled contact velocities; none in a step without.
    fn find_friction(&self, scaled: &[[f64; D]]) -> Option<FrictionReport> {
        let mut report = self.is_frictional().then(FrictionReport::default)?;
        for cone in self.cones() {
            let [force, slid, work] = cone.tangents.clone().fold([0.0, 0.0, 0.0], |[force, slid, work], row| {
                let (gamma, slip) = (self.gamma[row], self.slip(row, scaled));
                [force + gamma * gamma, slid + slip * slip, work - gamma * slip]
            });
            report.work += work;
            if self.gamma[cone.normal] > 0.0 {
                // A contact that slides has the multiplier of its cone's surface, which is projected on it.
                let left = cone.mu * self.gamma[cone.normal] * (1.0 - AT_THE_LIMIT) - force.sqrt();
                report.sliding += usize::from(left <= 0.0);
                report.sticking += usize::from(left > 0.0);
                // What sticks has no slip, or no friction left.
                let scale: f64 = self.problem.jacobian[cone.normal].as_flattened().iter().map(|j| j * j).sum();
                let creeps = slid.sqrt().min(scale * left.max(0.0));
                // A push that moves nothing may be apart.
                let gap = self.problem.value(cone.normal, scaled);
                let apart = gap.min(scale * self.gamma[cone.normal]);
                report.gap = report.gap.max(apart).max(-gap).max(creeps);
            }
        }
        Some(report)
    }

    /// The friction force that the spring of a contact has after the step. A contact that sticks has slipped by what
    /// the solve left of its slip: its spring takes that up too. Otherwise such slips add up over thousands of steps,
    /// which wears out what holds a pile.
    pub(super) fn kept_friction(&self, normal: usize, scaled: &[[f64; D]]) -> DVec3 {
        let force = self.friction_force(normal);
        let Some(Cone::Friction(mu)) = self.problem.cones.get(normal) else { return force };
        let most = mu * self.gamma[normal];
        if force.length() >= most * (1.0 - AT_THE_LIMIT) {
            return force;
        }
        let taken = |row: usize| {
            let compliance = self.problem.compliance[row];
            if compliance > 0.0 { self.slip(row, scaled) / compliance } else { 0.0 }
        };
        let tangents = self.tangents_of(normal);
        let spring = force - tangents.map(|row| taken(row) * self.tangent(row)).sum::<DVec3>();
        spring.clamp_length_max(most)
    }

    /// The slip of a tangent row, with what its spring gave way.
    fn slip(&self, row: usize, scaled: &[[f64; D]]) -> f64 {
        self.problem.value(row, scaled) + self.problem.compliance[row] * self.gamma[row]
    }

    /// The change of the energy in the springs of stick.
    pub(super) fn spring_energy(&self) -> f64 {
        let of = |row: usize| {
            let (now, before) = (self.gamma[row], self.held_at(row));
            0.5 * self.problem.compliance[row] * (now * now - before * before)
        };
        self.cones().flat_map(|cone| cone.tangents).map(of).sum()
    }
}

/// A friction force that is less than its limit by this part of it, which is made of rounding, is at its limit.
const AT_THE_LIMIT: f64 = 1e-9;

/// Bodies lock where a contact pushes with this many times the force that moves all bodies. Rods between walls push
/// with up to 1e3 times it at the angles at which they still slip. Forces of bodies that lock grow tenfold in a step,
/// so the number matters little.
const MOST_LEVERAGE: f64 = 1e7;
