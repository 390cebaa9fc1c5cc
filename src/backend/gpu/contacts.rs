//! The contacts of a state on a device, computed afresh, as [`crate::step::contacts`] and [`Walls::contacts`] do on the
//! CPU: it shares only the separation functions with the steps.
//!
//! The host lists the candidates from boxes, with their images. The device computes their separations, normals and
//! levers in its precision.

use super::unrounded::coarse_and_fine;
use crate::bodies::Bodies;
use crate::gpu::{Buffer, Gpu, GpuError, Lattice, Made, Precision, Recorder, Source, arrays, fragment, functions};
use crate::separation::Separation;
use crate::separation::gpu::{PairFamilies, add_bodies_to, add_places_to, surface_numbers, unsupported};
use crate::shape::gpu::Exponents;
use crate::step::{Candidate, Contact, candidates};
use crate::walls::{AtSurface, WallContact, Walls};
use glam::{DVec3, I64Vec3};
use std::collections::HashMap;

functions! {
    OfPairs = struct OfPairsArgs<'a> { count: u64, pairs: &'a Buffer, placed: &'a Placed, contacts: &'a Buffer }
    OfPlaces = struct OfPlacesArgs<'a> {
        count: u64, pairs: &'a Buffer, placed: &'a Placed, surfaces: &'a Buffer, contacts: &'a Buffer,
    }
}

/// Pairs per call of the device: their contacts take 96 MiB in 64-bit numbers.
const PAIRS_AT_ONCE: usize = 1 << 20;

/// Numbers per contact: three vectors.
const NUMBERS: usize = 12;

/// Every pair of bodies whose separation is at most `cutoff`, in the order of [`crate::step::contacts`].
///
/// # Errors
/// [`GpuError::Unsupported`] for shapes and pairs that only the CPU has, and for bodies beyond the lattice; or what the
/// device refuses.
pub fn contacts(gpu: &Gpu, precision: Precision, bodies: &Bodies, cutoff: f64) -> Result<Vec<Contact>, GpuError> {
    let lattice = lattice(gpu, precision, bodies)?;
    let (cutoff, found) = candidates(bodies, cutoff);
    let families = PairFamilies::needed(bodies.shape.iter().copied());
    let kernel = |families: &PairFamilies| {
        let source = families.add_to(base(&lattice, precision, bodies, families.name()), bodies.planar);
        OfPairs::make(gpu, source.include(fragment!("separation/contacts.wgsl")))
    };
    let kernels = if found.is_empty() { Vec::new() } else { families.iter().map(kernel).collect::<Result<_, _>>()? };
    let mut contacts = Vec::new();
    for part in found.chunks(PAIRS_AT_ONCE) {
        let (places, pairs) = places(bodies, part);
        let placed = Placed::new(gpu, precision, &lattice, bodies, &places)?;
        let placed = &placed;
        let separations = separate(gpu, precision, &pairs, |record, count, pairs, contacts| {
            for kernel in &kernels {
                kernel.call(record, count, OfPairsArgs { count, pairs, placed, contacts });
            }
        })?;
        let near = part.iter().zip(separations).filter(|(_, found)| found.separation <= cutoff);
        contacts.extend(near.map(|(candidate, found)| Contact::new(*candidate, found)));
    }
    Ok(contacts)
}

/// Every body and surface whose separation is at most `cutoff`, in the order of [`Walls::contacts`].
///
/// As [`contacts`], and for walls beyond the lattice.
pub fn wall_contacts(
    gpu: &Gpu,
    precision: Precision,
    (bodies, walls): (&Bodies, &Walls),
    cutoff: f64,
) -> Result<Vec<WallContact>, GpuError> {
    let lattice = lattice(gpu, precision, bodies)?;
    let found = walls.candidates(bodies, cutoff);
    if found.is_empty() {
        return Ok(Vec::new());
    }
    let mut numbers = Vec::new();
    for surface in walls.surfaces() {
        numbers.extend(surface_numbers(surface, &lattice)?);
    }
    let surfaces = Buffer::reals(gpu, "surfaces", precision, 4, numbers)?;
    let source = add_places_to(base(&lattice, precision, bodies, "surfaces"), &lattice, &bodies.shape);
    let source = source.integer("PLACES", AtSurface::PLACES).include(fragment!("walls/contacts.wgsl"));
    let kernel = OfPlaces::make(gpu, source)?;
    let mut contacts = Vec::new();
    for part in found.chunks(PAIRS_AT_ONCE) {
        let places: Vec<_> = part.iter().map(|[body, _]| (*body, I64Vec3::ZERO)).collect();
        let placed = Placed::new(gpu, precision, &lattice, bodies, &places)?;
        let pairs: Vec<[u32; 2]> = part.iter().enumerate().map(|(i, [_, at])| [i as u32, *at as u32]).collect();
        let (placed, surfaces) = (&placed, &surfaces);
        let separations = separate(gpu, precision, &pairs, |record, count, pairs, contacts| {
            kernel.call(record, count, OfPlacesArgs { count, pairs, placed, surfaces, contacts });
        })?;
        let near = part.iter().zip(separations).filter(|(_, found)| found.separation <= cutoff);
        contacts.extend(near.map(|([body, at], found)| WallContact::new(*body, [walls.wall_of(*at), *at], found)));
    }
    Ok(contacts)
}

/// The lattice for these bodies.
fn lattice(gpu: &Gpu, precision: Precision, bodies: &Bodies) -> Result<Lattice, GpuError> {
    gpu.check(precision)?;
    if let Some(what) = unsupported(bodies.shape.iter().copied(), bodies.planar) {
        return Err(GpuError::Unsupported { what });
    }
    let thickness = bodies.shape.iter().map(|shape| shape.thickness()).fold(f64::INFINITY, f64::min);
    Lattice::for_thickness(if thickness.is_finite() { thickness } else { 1.0 })
}

fn base(lattice: &Lattice, precision: Precision, bodies: &Bodies, name: &str) -> Source {
    let source = lattice.define(Source::new(format!("contacts: {name}"), precision));
    let source = Exponents::of(&bodies.shape).add_to(source);
    add_bodies_to(source.include(fragment!("common/quaternion.wgsl")).include(fragment!("common/orientation.wgsl")))
        .include(fragment!("separation/placed.wgsl"))
}

/// The bodies of these candidates, with one entry for each image that occurs, and the pairs of indices into that list.
fn places(bodies: &Bodies, candidates: &[Candidate]) -> (Vec<(usize, I64Vec3)>, Vec<[u32; 2]>) {
    let mut places: Vec<_> = (0..bodies.len()).map(|i| (i, I64Vec3::ZERO)).collect();
    let mut images: HashMap<(usize, [i64; 3]), u32> = HashMap::new();
    let pair = |Candidate { bodies: [a, b], image }: &Candidate| {
        let place = if *image == I64Vec3::ZERO {
            *b as u32
        } else {
            *images.entry((*b, image.to_array())).or_insert_with(|| {
                places.push((*b, *image));
                places.len() as u32 - 1
            })
        };
        [*a as u32, place]
    };
    let pairs = candidates.iter().map(pair).collect();
    (places, pairs)
}

/// Bodies with positions and orientations on the device.
struct Placed {
    cells: Buffer,
    remainders: Buffer,
    orientations: Buffer,
    shapes: Buffer,
}

arrays! { Placed { cells, remainders, orientations, shapes } }

impl Placed {
    fn new(
        gpu: &Gpu,
        precision: Precision,
        lattice: &Lattice,
        bodies: &Bodies,
        places: &[(usize, I64Vec3)],
    ) -> Result<Self, GpuError> {
        let (mut cells, mut remainders) = (Vec::<i32>::new(), Vec::new());
        for (body, image) in places {
            for x in (bodies.position[*body] + bodies.periods.shift(*image)).to_array() {
                let (cell, remainder) = lattice.split(x)?;
                cells.push(cell);
                remainders.push(remainder);
            }
            cells.push(0);
            remainders.push(0.0);
        }
        let orientations = places.iter().flat_map(|(body, _)| coarse_and_fine(&bodies.orientation[*body])).flatten();
        let exponents = Exponents::of(&bodies.shape);
        let shapes = places.iter().flat_map(|(body, _)| exponents.numbers(&bodies.shape[*body]));
        Ok(Placed {
            cells: Buffer::with(gpu, "cells", 16, bytemuck::cast_slice(&cells))?,
            remainders: Buffer::reals(gpu, "remainders", precision, 4, remainders)?,
            orientations: Buffer::reals(gpu, "orientations", precision, 8, orientations)?,
            shapes: Buffer::reals(gpu, "shapes", precision, 4, shapes)?,
        })
    }
}

/// The separations of pairs; `call` computes them for a number of pairs in a list.
fn separate(
    gpu: &Gpu,
    precision: Precision,
    pairs: &[[u32; 2]],
    call: impl Fn(&mut Recorder<'_>, u64, &Buffer, &Buffer),
) -> Result<Vec<Separation>, GpuError> {
    let count = pairs.len() as u64;
    let list = Buffer::with(gpu, "pairs", 8, bytemuck::cast_slice(pairs))?;
    let out = Buffer::new(gpu, "contacts", NUMBERS * precision.bytes(), count)?;
    let mut record = gpu.record();
    record.stage("contacts");
    call(&mut record, count, &list, &out);
    let read = record.read(&[(&out, 0..count * (NUMBERS * precision.bytes()) as u64)])?;
    let numbers = precision.decode(&read[0]);
    let separation = |v: &[f64; NUMBERS]| {
        let vector = |k: usize| DVec3::from_slice(&v[4 * k..]);
        Separation { separation: v[3], normal: vector(0), lever_a: vector(1), lever_b: vector(2) }
    };
    Ok(numbers.as_chunks::<NUMBERS>().0.iter().map(separation).collect())
}
