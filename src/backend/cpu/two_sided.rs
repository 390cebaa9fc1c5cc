//! Rebuilding rows: those that push bodies that no longer touch, at the trial; contradictory ones, at a configuration
//! drawn near the start. `step/two_sided.rs` describes when and why.

use super::Cpu;
use super::friction::Making;
use super::narrow_phase::Near;
use super::row_set::{Contact, Push};
use super::start::Start;
use super::team::Team;
use super::trial::Trial;
use crate::dynamics::{self, Twist, draw};
use crate::freedom::{PLANAR, SPATIAL, unpack};
use crate::separation::{Placed, branch};
use crate::step::{Effect, Loosened, TORN, TwoSided, Wedge};
use crate::walls::surface_of;
use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet};

/// A row is of the wedge if its own multiplier moves it by at least this part of what moves the row of the wedge that
/// is moved most.
const OF_THE_WEDGE: f64 = 0.1;

/// A contact throws its bodies if it moves them against each other by more than this part of the thinner one's
/// thickness beyond their free motions and the slack between them: a link of a chain is pulled through its neighbour.
pub(crate) const THROWN: f64 = 0.5;

/// A push is looked at if contact may have parted its bodies by more than this part of the thinner one's thickness: a
/// quarter of what a push may end apart at least. A sheet of rings, whose separations cost most, took 2.6 times as long
/// without it.
const LEAST_GAP: f64 = 0.005;

/// What rounding makes of the work of contact, in parts of that on the bodies.
const ROUNDING_OF_WORK: f64 = 1e-9;

/// The bodies of a step and their trial, which threads share.
#[derive(Clone, Copy)]
struct AtTrial<'a, const D: usize> {
    start: &'a Start,
    trial: &'a Trial<D>,
}

impl<const D: usize> AtTrial<'_, D> {
    /// The thickness of the thinner body of a pair.
    fn thickness(self, [a, b]: [u32; 2]) -> f64 {
        let of = |number: u32| match surface_of(number) {
            Some(_) => f64::INFINITY,
            None => self.start.bodies.shape[number as usize].thickness(),
        };
        of(a).min(of(b))
    }

    /// How far the centre of one body comes against the other's.
    fn relative_way(self, pair: [u32; 2]) -> f64 {
        let way = |number: u32| match surface_of(number) {
            Some(_) => DVec3::ZERO,
            None => self.start.interval * self.trial.twist[number as usize].linear,
        };
        let [a, b] = pair.map(way);
        (b - a).length()
    }

    /// How far apart a push may end at most: the two points of a contact that pushes meet by its rows, and come apart
    /// by what they move. Rows may be made elsewhere, for which there is twice as much.
    ///
    /// Two bodies are no farther apart than two balls inside of them that touch where the rows were made. These part by
    /// the square of how far they slide past each other.
    fn may_part(self, pair: [u32; 2]) -> f64 {
        let dt = self.start.interval;
        let part = |number: u32| match surface_of(number) {
            Some(_) => (DVec3::ZERO, 0.0, 0.0),
            None => {
                let Twist { linear, angular } = self.trial.twist[number as usize];
                let shape = &self.start.bodies.shape[number as usize];
                (dt * linear, dt * angular.length() * shape.bounding_radius(), shape.inner_ball_radius())
            }
        };
        let [(a, turned_a, ball_a), (b, turned_b, ball_b)] = pair.map(part);
        let slide = 2.0 * ((b - a).length() + turned_a + turned_b);
        // At a wall, which may be curved by more than the body: the slide.
        let ball = ball_a.min(ball_b);
        if slide < ball { slide * slide / ball } else { slide }
    }
}

impl<const D: usize, T: Team> Cpu<D, T> {
    /// The branch of a push with the bodies `placed`; none where a body has no such place at a wall.
    fn branch_of(&self, push: &Push, placed: impl Fn(usize) -> Placed) -> Option<Near> {
        let (pair, feature) = (push.pair, push.feature);
        let a = placed(pair[0] as usize);
        let found = match surface_of(pair[1]) {
            Some(surface) => {
                let mut found = None;
                self.start.walls(&self.setup).surfaces()[surface].places(&a, |place, there| {
                    if place == feature {
                        found = Some(there);
                    }
                });
                found?
            }
            None => {
                let [a, b] = self.start.periods.pair(a, placed(pair[1] as usize));
                branch(&a, &b, &Self::SEPARATE(&a, &b, None)?, feature)
            }
        };
        Some(Near { pair, feature, found })
    }

    /// The thickness of the thinner body of a pair.
    fn thickness(&self, pair: [u32; 2]) -> f64 {
        self.at_trial().thickness(pair)
    }

    fn at_trial(&self) -> AtTrial<'_, D> {
        AtTrial { start: &self.start, trial: &self.trial }
    }

    /// How far apart a push may end: the part `gap` of the thickness, and what a slide past each other explains that
    /// free motions alone may make of it.
    fn allowed_gap(&self, pair: [u32; 2], gap: f64) -> f64 {
        let thickness = self.thickness(pair);
        let free = |number: u32| match surface_of(number) {
            Some(_) => (DVec3::ZERO, 0.0),
            None => {
                let Twist { linear, angular } = self.driven(number as usize);
                (linear, angular.length() * self.start.bodies.shape[number as usize].bounding_radius())
            }
        };
        let [(a, turned_a), (b, turned_b)] = pair.map(free);
        let slide = self.start.interval * ((b - a).length() + turned_a + turned_b);
        gap * thickness + slide * slide / thickness
    }

    /// How far apart a push ends, beyond what restitution wants.
    fn apart(&self, near: &Near) -> f64 {
        near.found.separation - self.rows.bounced(near)
    }

    /// The branches that push and may end farther apart than the part `least` of their pair's thickness, where they are
    /// at the trial.
    fn pushing_at_trial(&self, least: impl Fn([u32; 2]) -> f64 + Sync) -> Vec<(Push, Near)> {
        let placed = |i: usize| self.trial.placed(&self.start, i);
        // Images of a cell that is sheared or changes move too.
        let images_move = self.setup.strain.is_some();
        let at_trial = self.at_trial();
        let may_be_apart = |pair| images_move || at_trial.may_part(pair) > least(pair) * at_trial.thickness(pair);
        let pushing = self.rows.pushing_of(self.solve.tolerance(), may_be_apart);
        pushing.into_iter().filter_map(|push| Some((push, self.branch_of(&push, placed)?))).collect()
    }

    pub(super) fn find_effect(&self, gap: f64) -> Effect {
        let bounded = self.setup.has_inertia && !self.does_work() && !self.start.parting;
        let mut effect = Effect { energy_allowed: if bounded { 0.0 } else { f64::INFINITY }, ..Effect::default() };
        if self.start.proxies.is_empty() {
            for (push, near) in self.pushing_at_trial(|_| LEAST_GAP.min(gap)) {
                self.add_push(&mut effect, &push, &near, gap);
            }
            if bounded {
                effect.energy_allowed += self.energy_of_what_is_undone();
            }
        }
        for (i, twist) in self.trial.twist.iter().enumerate() {
            if self.start.is_idle(i) {
                continue;
            }
            let dt = self.start.interval;
            let moved = self.moved(i).length();
            if moved > effect.largest_move {
                (effect.largest_move, effect.moved) = (moved, Some(i));
            }
            // Friction may spin a body of revolution about its axis.
            if D == SPATIAL
                && self.stick.is_none()
                && let Some(axis) = self.start.axis_of_revolution(i)
            {
                let spun = dt * axis.dot(twist.angular - self.driven(i).angular).abs();
                effect.axial_spin = effect.axial_spin.max(spun);
            }
            if self.setup.has_inertia {
                let work = self.work(i, twist);
                effect.energy += work;
                effect.energy_allowed += ROUNDING_OF_WORK * work.abs();
            }
        }
        effect.friction = self.find_friction();
        if self.setup.has_inertia {
            effect.energy += self.rows.spring_energy();
        }
        effect
    }

    /// What pushes may do by what the step may leave undone: an overlap, and the residual.
    fn energy_of_what_is_undone(&self) -> f64 {
        let undone = self.setup.overlap_tolerance.max(self.first.overlap) + self.solve.residual();
        let own = self.rows.pushing_rows().filter(|(pair, _)| !self.start.is_foreign(pair[0] as usize));
        let pushing: f64 = own.map(|(_, gamma)| gamma * undone).sum();
        let slips = |row: usize| self.rows.gamma[row].abs() * self.solve.residual();
        pushing + self.rows.cones().flat_map(|cone| cone.tangents).map(slips).sum::<f64>()
    }

    /// The gap at which a push begins; zero if it overlaps.
    fn slack(&self, push: &Push) -> f64 {
        let start = |i: usize| self.start.placed_at(i, self.start.pose(i));
        self.branch_of(push, start).map_or(0.0, |near| near.found.separation.max(0.0))
    }

    /// How far contact moves a body's centre, beside its free motion and bonds.
    fn moved(&self, i: usize) -> DVec3 {
        self.start.interval * (self.trial.twist[i].linear - self.driven(i).linear)
    }

    fn add_push(&self, effect: &mut Effect, push: &Push, near: &Near, gap: f64) {
        let apart = self.apart(near);
        if self.start.is_foreign(push.pair[0] as usize) {
            return;
        }
        if apart > effect.push_gap {
            (effect.push_gap, effect.push_pair) = (apart, Some(push.pair));
        }
        effect.apart += usize::from(apart > self.allowed_gap(near.pair, gap));
        effect.torn += usize::from(apart > self.allowed_gap(near.pair, TORN));
        let far = self.too_far(push.pair) - self.rows.bounced(near);
        effect.thrown += usize::from(far > 0.0 && far > self.slack(push));
    }

    /// How much farther contact moves the bodies of a pair against each other than it may, beside slack and bounces.
    fn too_far(&self, pair: [u32; 2]) -> f64 {
        let bodies = pair.map(|number| surface_of(number).is_none().then_some(number as usize));
        let [a, b] = bodies.map(|body| body.map_or(DVec3::ZERO, |i| self.moved(i)));
        let free = |i: usize| self.start.interval * self.driven(i).linear.length();
        let explained = bodies.iter().flatten().map(|i| free(*i)).sum::<f64>() + self.first.overlap;
        (b - a).length() - self.may_move(pair, self.thickness(pair)) - explained
    }

    /// How far contact may move the bodies of a pair against each other. With inertia the velocities of a piece of a
    /// step outlast it: at these, the bodies may move in the whole step by the longer one's length. A bound of energy
    /// is stricter where there is one.
    fn may_move(&self, pair: [u32; 2], thickness: f64) -> f64 {
        let outlasts = self.setup.has_inertia && self.does_work();
        let length = |number: u32| match surface_of(number) {
            Some(_) => 0.0,
            None => self.start.bodies.shape[number as usize].major_axis(),
        };
        let length = pair.map(length).into_iter().fold(0.0, f64::max);
        let most =
            if outlasts { length * self.start.interval / self.start.step_length(&self.setup) } else { f64::INFINITY };
        most.min(THROWN * thickness)
    }

    /// Whether walls, growth or a changing cell do work: energy has no bound here.
    fn does_work(&self) -> bool {
        let setup = &self.setup;
        setup.growth.is_some() || setup.strain.is_some() || setup.walls.move_in_time()
    }

    /// The work of contact on a body in the step: its impulse along the mean of the velocities with contact and
    /// without.
    pub(super) fn work(&self, i: usize, twist: &Twist) -> f64 {
        let (motion, driven) = (&self.motions.motion[i], self.driven(i));
        let mut scaled = self.trial.scaled[i];
        if let Some(bonded) = self.trial.bonded.get(i) {
            scaled.iter_mut().zip(bonded).for_each(|(all, of_bonds)| *all -= of_bonds);
        }
        let (linear, angular) = unpack::<D>(&scaled);
        let mean_linear = 0.5 * (twist.linear + driven.linear);
        let mean_angular = 0.5 * (twist.angular + driven.angular);
        let root = self.start.interval.sqrt();
        let of_turning = motion.factor.rotation.inverse() * mean_angular;
        let turning = if of_turning.is_finite() { of_turning.dot(angular) } else { 0.0 };
        root * (motion.factor.translation.between(linear, mean_linear) + turning)
    }

    /// The branches that contradict each other: those whose own multipliers move them most. They grow without bounds
    /// along the proof that there is no solution, and in the least overlap they are in proportion to the violations.
    fn wedge_rows(&self) -> Vec<Push> {
        let mut pushing = self.rows.pushing(0.0);
        // Two rows that are exactly opposed, as of a rod across a channel: no multiplier lessens the residual.
        if pushing.is_empty() {
            pushing = self.rows.overlapping();
        }
        let most = pushing.iter().fold(0.0_f64, |most, push| most.max(push.moved));
        pushing.retain(|push| push.moved >= OF_THE_WEDGE * most);
        pushing
    }

    /// The bodies of these branches, and the walls that they are pressed against.
    pub(super) fn find_wedge(&self) -> Wedge {
        let rows = self.wedge_rows();
        let numbers: BTreeSet<u32> = rows.iter().flat_map(|push| push.pair).collect();
        let wall = |number: &u32| Some(self.setup.walls.wall_of(surface_of(*number)?));
        let walls: BTreeSet<usize> = numbers.iter().filter_map(wall).collect();
        let bodies = numbers.iter().filter(|number| surface_of(**number).is_none());
        Wedge { bodies: bodies.map(|body| *body as usize).collect(), walls: walls.into_iter().collect() }
    }

    /// The rows of a branch that is made again.
    fn contact_again(&self, near: &Near, reached: &[Twist]) -> Contact<D> {
        let Cpu { setup, start, motions, stick, .. } = self;
        let making = Making { setup, start, motions, stick: *stick };
        making.contact(near, reached, self.rows.held(&self.pairs, near))
    }

    /// Rebuilds the rows of these branches where the velocities `reached` lead, with zero multipliers; returns their
    /// number.
    fn rebuild_rows_at(&mut self, pushing: &[Push], reached: &[Twist]) -> usize {
        let there = |i: usize| {
            let pose = dynamics::advance(self.start.pose(i), reached[i], self.start.interval);
            self.start.placed_at(i, pose)
        };
        let contact = |push: &Push| {
            let near = self.branch_of(push, there)?;
            Some((near, self.contact_again(&near, reached), 0.0))
        };
        let rebuilt: Vec<_> = pushing.iter().filter_map(contact).collect();
        self.rows.replace_branches(&rebuilt);
        let bodies = rebuilt.iter().flat_map(|(near, ..)| near.pair);
        self.rebuilt.extend(bodies.filter(|number| surface_of(*number).is_none()));
        rebuilt.len()
    }

    /// Where bodies come on their way to the trial, by at most the part `size` of half of their thickness, as the
    /// velocities that lead there from the start.
    fn towards_trial(&self, size: f64) -> Vec<Twist> {
        let short = |i: usize| {
            let (shape, Twist { linear, angular }) = (&self.start.bodies.shape[i], self.trial.twist[i]);
            let most = size * 0.5 * shape.thickness() / self.start.interval;
            let shorten = |v: DVec3, most: f64| v.clamp_length_max(most.max(f64::MIN_POSITIVE));
            Twist { linear: shorten(linear, most), angular: shorten(angular, most / shape.bounding_radius()) }
        };
        (0..self.start.bodies.len()).map(short).collect()
    }

    /// Where a body of a wedge is drawn to, as the velocity that leads there from the start: sideways of `line`, by a
    /// part of its thickness, and turned by as much at its ends.
    fn drawn(&self, seed: u64, i: usize, line: DVec3, size: &dyn Fn(f64) -> f64) -> Twist {
        let bodies = &self.start.bodies;
        let shape = &bodies.shape[i];
        let [x, y, z, u, v, w] = draw::normals(seed, bodies.lineage[i].id, self.state.step + 1);
        let (shift, turn) = (DVec3::new(x, y, z), DVec3::new(u, v, w));
        let (shift, turn) = if D == PLANAR { (DVec3::new(x, y, 0.0), DVec3::new(0.0, 0.0, w)) } else { (shift, turn) };
        let aside = shift.reject_from(line).normalize_or_zero();
        let radius = 0.5 * shape.thickness();
        // From a half of it on: where two are drawn to the same side, they still differ.
        let length = size(radius) * radius * (0.5 + 0.5 * (x * x / (x * x + y * y)).max(0.0));
        let angle = length / shape.bounding_radius();
        Twist {
            linear: aside * (length / self.start.interval),
            angular: turn.normalize_or_zero() * (angle / self.start.interval),
        }
    }
}

impl<const D: usize, T: Team> TwoSided for Cpu<D, T> {
    fn objective(&self) -> f64 {
        0.5 * self.trial.scaled.iter().flatten().map(|v| v * v).sum::<f64>()
    }

    fn throws(&self, gap: f64) -> bool {
        let at_trial = self.at_trial();
        self.rows.any_pushes(|pair| at_trial.may_part(pair) > gap * at_trial.thickness(pair))
    }

    fn moves_too_far(&self) -> bool {
        let at_trial = self.at_trial();
        // Their free motions are part of the way, and allowed in addition.
        let far = |pair| at_trial.relative_way(pair) > THROWN * at_trial.thickness(pair);
        let pushing = self.rows.pushing_of(self.solve.tolerance(), far);
        pushing.iter().any(|push| self.too_far(push.pair) > self.slack(push))
    }

    fn catch(&mut self, gap: f64, size: f64) -> usize {
        let thrown = self.pushing_at_trial(|_| gap);
        let thrown = thrown.iter().filter(|(_, near)| self.apart(near) > self.allowed_gap(near.pair, gap));
        let thrown: Vec<Push> = thrown.map(|(push, _)| *push).collect();
        if thrown.is_empty() {
            return 0;
        }
        self.rebuild_rows_at(&thrown, &self.towards_trial(size))
    }

    fn follow(&mut self, size: f64) -> usize {
        self.rebuild_rows_at(&self.wedge_rows(), &self.towards_trial(size))
    }

    fn loosen(&mut self, gap: f64, of_rebuilt: f64) -> Loosened {
        let mut of = BTreeMap::new();
        let mut rebuilt = Vec::new();
        let is_rebuilt = |pair: [u32; 2]| pair.iter().any(|number| self.rebuilt.contains(number));
        let gap = |pair: [u32; 2]| if is_rebuilt(pair) { of_rebuilt } else { gap };
        for (push, near) in self.pushing_at_trial(gap) {
            if self.apart(&near) > self.allowed_gap(near.pair, gap(near.pair)) {
                for body in push.pair.into_iter().filter(|number| surface_of(*number).is_none()) {
                    of.insert(body, self.trial.scaled[body as usize]);
                }
                rebuilt.push((near, self.contact_again(&near, &self.trial.twist), push.gamma));
            }
        }
        let share = 0.5 * of.values().flatten().map(|v| v * v).sum::<f64>();
        let rows = rebuilt.len();
        if rows > 0 {
            self.rows.replace_branches(&rebuilt);
        }
        Loosened { rows, share }
    }

    fn thinnest(&self) -> f64 {
        self.setup.thinnest
    }

    fn tilt(&mut self, draw: u32, size: &dyn Fn(f64) -> f64) -> usize {
        let pushing = self.wedge_rows();
        let start = |i: usize| self.start.placed_at(i, self.start.pose(i));
        let mut twists: BTreeMap<usize, Twist> = BTreeMap::new();
        let seed = self.setup.seed ^ (u64::from(draw) << 40) ^ self.start.piece.start.to_bits().rotate_left(17);
        for push in &pushing {
            let Some(near) = self.branch_of(push, start) else { continue };
            for body in push.pair.into_iter().filter(|number| surface_of(*number).is_none()) {
                let body = body as usize;
                if !self.start.is_held(body) {
                    twists.entry(body).or_insert_with(|| self.drawn(seed, body, near.found.normal, size));
                }
            }
        }
        let mut reached = vec![Twist::default(); self.start.bodies.len()];
        for (body, twist) in &twists {
            reached[*body] = *twist;
        }
        self.rebuild_rows_at(&pushing, &reached)
    }

    fn keep_rows(&mut self) {
        self.kept = Some(self.rows.clone());
    }

    fn go_back(&mut self) {
        if let Some(kept) = self.kept.take() {
            self.rows = kept;
            self.rows.change_gamma();
        }
    }
}
