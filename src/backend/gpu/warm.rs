//! The values that pairs store from step to step, on the host. The host passes them to the first list that the device
//! makes, and reads them back.

use super::Setup;
use super::candidates::Candidates;
use super::source::ONLY_DIRECTION;
use super::walls::device_pair;
use crate::constraint::FEATURE_OF_SURFACES;
use crate::gpu::{Gpu, GpuError};
use crate::separation::branches::{branch_in_place, place_of_branch};
use crate::walls::{AtSurface, number_of, surface_of};
use crate::warm::Warm;
use glam::DVec3;
use std::collections::HashMap;

/// The index of the multiplier in a pair's contact, with the paper's rows.
const MULTIPLIER: usize = 7;

/// The index of the separation.
const SEPARATION: usize = 3;

impl Candidates {
    /// Writes the values stored by an earlier run into the pairs of the first list.
    pub(super) fn recall(&mut self, gpu: &Gpu, setup: &Setup) -> Result<(), GpuError> {
        let lists = &self.lists;
        let pairs = lists.pairs_count as usize;
        let mut numbers = vec![0.0; 12 * pairs];
        let width = setup.branches as usize;
        let mut remembered = vec![0.0; width * pairs];
        if !self.warm.is_empty() {
            let mut known: HashMap<[u32; 2], Vec<&Warm>> = HashMap::new();
            for w in &self.warm {
                if let Some(pair) = device_pair(w, &setup.walls) {
                    known.entry(pair).or_default().push(w);
                }
            }
            let read = gpu.record().read(&[(&lists.pairs, 0..8 * lists.pairs_count)])?;
            let pairs: Vec<[u32; 2]> = bytemuck::pod_collect_to_vec(&read[0]);
            for (p, (pair, contact)) in pairs.iter().zip(numbers.as_chunks_mut::<12>().0).enumerate() {
                for w in known.get(pair).into_iter().flatten() {
                    [contact[0], contact[1], contact[2]] = w.normal.to_array();
                    if width == 0 {
                        contact[MULTIPLIER] += w.gamma;
                    } else {
                        remembered[width * p + place_of(w, width)] += w.gamma;
                    }
                }
            }
            self.warm = Vec::new();
        }
        lists.contacts.write(gpu, 0, &setup.precision.encode(numbers));
        if width > 0 {
            lists.remembered.write(gpu, 0, &setup.precision.encode(remembered));
        }
        Ok(())
    }

    /// The stored values of every near pair.
    pub(super) fn remembered(&self, gpu: &Gpu, setup: &Setup) -> Result<Vec<Warm>, GpuError> {
        let (lists, count) = (&self.lists, self.lists.pairs_count);
        if self.first {
            return Ok(self.warm.clone());
        }
        let width = setup.branches as usize;
        let remembered = if width > 0 { 0..count * lists.remembered.element() as u64 } else { 0..0 };
        let read = gpu.record().read(&[
            (&lists.pairs, 0..8 * count),
            (&lists.contacts, 0..count * lists.contacts.element() as u64),
            (&lists.remembered, remembered),
        ])?;
        let pairs: Vec<[u32; 2]> = bytemuck::pod_collect_to_vec(&read[0]);
        let [contacts, remembered] = [1, 2].map(|i| setup.precision.decode(&read[i]));
        let mut warm = Vec::new();
        for (p, (pair, contact)) in pairs.iter().zip(contacts.as_chunks::<12>().0).enumerate() {
            let normal = match contact[SEPARATION] < ONLY_DIRECTION {
                true => DVec3::new(contact[0], contact[1], contact[2]),
                false => DVec3::ZERO,
            };
            let gammas = match width {
                0 => std::slice::from_ref(&contact[MULTIPLIER]),
                _ => &remembered[width * p..width * (p + 1)],
            };
            warm.extend(of_pair(*pair, normal, gammas));
        }
        warm.sort_by_key(|w| (w.pair, w.feature));
        Ok(warm)
    }
}

/// The index of a stored value in the list of a pair's branches. At a surface, and for pairs with one branch, there is
/// only one.
fn place_of(warm: &Warm, width: usize) -> usize {
    let place = if surface_of(warm.pair[1]).is_some() { None } else { place_of_branch(warm.feature) };
    place.map_or(0, |place| place as usize).min(width - 1)
}

/// The stored values of a pair with these multipliers of its branches: one entry for each branch that pushes, or one
/// with the normal alone.
fn of_pair(pair: [u32; 2], normal: DVec3, gammas: &[f64]) -> Vec<Warm> {
    let pushes = gammas.iter().any(|gamma| *gamma > 0.0);
    let at_surface = AtSurface::of_number(pair[1]);
    let (second, own) = match at_surface {
        Some(AtSurface { surface, place }) => (number_of(surface), place),
        None => (pair[1], FEATURE_OF_SURFACES),
    };
    // Places at surfaces always have a normal, however far they are.
    let known = normal != DVec3::ZERO && (at_surface.is_none() || pushes);
    let entry = |(place, gamma): (usize, &f64)| {
        let feature = if at_surface.is_none() { branch_in_place(place as u32) } else { own };
        (known && (*gamma > 0.0 || (place == 0 && !pushes))).then_some(Warm {
            pair: [pair[0], second],
            feature,
            gamma: *gamma,
            normal,
            tangent: DVec3::ZERO,
        })
    };
    gammas.iter().enumerate().filter_map(entry).collect()
}
