//! The state of a simulation between two steps.

use crate::bodies::Bodies;
use crate::fields::Concentration;
use crate::walls::surface_of;
use crate::warm::Warm;

/// Everything that a run needs, beside its scene, to continue to the same bits.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    /// Steps taken.
    pub step: u64,
    /// The id that the next body born will get.
    pub next_id: u64,
    /// The bodies.
    pub bodies: Bodies,
    /// The warm start of near pairs from the last step, sorted by pair and feature.
    pub warm: Vec<Warm>,
    /// How many bodies each rule of the scene's `removal` has removed; empty before the first.
    pub removed: Vec<u64>,
    /// Whether bodies were placed, turned or lengthened since the last step, so that they may overlap.
    pub changed: bool,
    /// The concentrations of the scene's fields, in the order of their names.
    pub fields: Vec<Concentration>,
    /// The bodies in the device's own number format. Without them, or if they do not match `bodies`, a device starts
    /// from `bodies`.
    pub unrounded: Option<Unrounded>,
}

/// Bodies in a device's own number format. [`Bodies`] are rounded from these; with them a device continues to the same
/// bits.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Unrounded {
    /// Bytes of a number, the pitch of positions, and the pitch of growing lengths. A device with a different format
    /// cannot use these numbers.
    pub kind: [f64; 3],
    /// The numbers of each body.
    pub bodies: Vec<UnroundedBody>,
}

/// A body's numbers as a device holds them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct UnroundedBody {
    /// Where it is, in pitches.
    pub cell: [i32; 3],
    /// What is left of its position.
    pub remainder: [f64; 3],
    /// The coarse and the fine part of its orientation.
    pub orientation: [[f64; 4]; 2],
    /// Its velocity.
    pub velocity: [f64; 3],
    /// Its angular velocity or momentum.
    pub turning: [f64; 3],
    /// The coarse and the fine part of a growing length; else zero.
    pub length: [f64; 2],
    /// The length that it is to have, where it grows; else zero.
    pub prescribed: f64,
}

impl UnroundedBody {
    /// How many numbers a body has beside its cell.
    pub const NUMBERS: usize = 20;

    /// Its numbers in the order in which files have them: all but its cell.
    pub fn to_numbers(&self) -> [f64; UnroundedBody::NUMBERS] {
        let UnroundedBody { cell: _, remainder: [x, y, z], orientation: [coarse, fine], .. } = *self;
        let ([c0, c1, c2, c3], [f0, f1, f2, f3]) = (coarse, fine);
        let ([vx, vy, vz], [wx, wy, wz], [long, rest]) = (self.velocity, self.turning, self.length);
        [x, y, z, c0, c1, c2, c3, f0, f1, f2, f3, vx, vy, vz, wx, wy, wz, long, rest, self.prescribed]
    }

    /// The body that has this cell and [these numbers](UnroundedBody::to_numbers).
    pub fn from_numbers(cell: [i32; 3], numbers: [f64; UnroundedBody::NUMBERS]) -> UnroundedBody {
        let [x, y, z, c0, c1, c2, c3, f0, f1, f2, f3, vx, vy, vz, wx, wy, wz, long, rest, prescribed] = numbers;
        UnroundedBody {
            cell,
            remainder: [x, y, z],
            orientation: [[c0, c1, c2, c3], [f0, f1, f2, f3]],
            velocity: [vx, vy, vz],
            turning: [wx, wy, wz],
            length: [long, rest],
            prescribed,
        }
    }
}

impl State {
    /// The state that a simulation of these bodies starts from: no steps and no warm start.
    pub fn new(bodies: Bodies) -> State {
        // A parent's id stays reserved after the parent has gone.
        let taken = bodies.lineage.iter().map(|l| l.id.max(l.parent.unwrap_or(0)));
        let next_id = taken.max().map_or(0, |id| id + 1);
        State {
            step: 0,
            next_id,
            bodies,
            warm: Vec::new(),
            removed: Vec::new(),
            changed: false,
            fields: Vec::new(),
            unrounded: None,
        }
    }

    /// Keeps the flagged bodies and the warm start of their pairs, in order. `removed` is added to the counts.
    pub fn remove(&mut self, keep: &[bool], removed: &[u64]) {
        let mut next = 0_u32;
        let number = |kept: &bool| {
            let own = next;
            next += u32::from(*kept);
            kept.then_some(own)
        };
        let numbers: Vec<Option<u32>> = keep.iter().map(number).collect();
        let renumbered = |body: u32| match surface_of(body) {
            Some(_) => Some(body),
            None => numbers.get(body as usize).copied().flatten(),
        };
        self.warm.retain_mut(|warm| match warm.pair.map(renumbered) {
            [Some(a), Some(b)] => {
                warm.pair = [a, b];
                true
            }
            _ => false,
        });
        self.bodies.retain(keep);
        self.count_removed(removed);
    }

    /// Adds to the counts of removed bodies, one for each rule.
    pub(crate) fn count_removed(&mut self, removed: &[u64]) {
        self.unrounded = None;
        self.removed.resize(self.removed.len().max(removed.len()), 0);
        self.removed.iter_mut().zip(removed).for_each(|(sum, count)| *sum += count);
    }
}
