//! The rays of a picture on a device, in f32: the same lists of bodies by tile as on the CPU, one workgroup per tile.
//!
//! Lengths are in units of each body's own size, and a ray's position is the difference of whole samples plus a
//! remainder, so 32 bits suffice for bodies of any size and distance.

use super::raster::{Drawn, NOTHING, Sample, TILE};
use crate::gpu::{Buffer, Gpu, GpuError, Made, Precision, Size, Source, fragment, functions};
use crate::shape::{self, Centreline, Geometry, Tag};
use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use std::sync::{Arc, Mutex};

/// Tiles per dispatch: 32 MiB of samples, within every adapter's limits.
const BAND: usize = 512;
/// The largest number of bodies in a tile on a device: some drivers end loops after this many iterations.
const MOST_OF_A_TILE: usize = 65_535;
const WORKGROUP: u32 = 128;

functions! {
    CastTiles = struct CastArgs<'a> {
        first_tile: usize, columns: usize, tiles: usize, first: &'a Buffer, members: &'a Buffer, drawn: &'a Buffer,
        samples: &'a Buffer,
    }
}

/// Casts rays on a device.
pub struct Rays {
    gpu: Arc<Gpu>,
    /// Several threads may draw pictures, but the kernel serves one at a time.
    kernel: Mutex<CastTiles>,
}

/// The layout of `Drawn` in `shaders/render/cast.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Cast {
    right: [f32; 4],
    up: [f32; 4],
    toward: [f32; 4],
    sizes: [f32; 4],
    rest: [f32; 2],
    kind: u32,
    body: u32,
    place: [i32; 2],
    columns: [u32; 2],
    rows: [u32; 2],
    unused: [u32; 2],
}

fn source() -> Source {
    shape::gpu::add_tags_to(Source::with_workgroup("cast", Precision::F32, WORKGROUP))
        .integer("TILE", TILE as u32)
        .integer("NOTHING", NOTHING)
        .include(fragment!("render/intersect.wgsl"))
        .include(fragment!("render/cast.wgsl"))
}

/// The tag of the shape of a geometry, and its parameters in the shader; `None` if the shader does not support it.
fn numbers(geometry: &Geometry) -> Option<(Tag, DVec3)> {
    match *geometry {
        Geometry::Centreline { curve: Centreline::Point, radius } => Some((Tag::Sphere, DVec3::new(0.0, radius, 0.0))),
        Geometry::Centreline { curve: Centreline::Segment { half }, radius } => {
            Some((Tag::Spherocylinder, DVec3::new(half, radius, 0.0)))
        }
        Geometry::Centreline { curve: Centreline::Circle { radius: ring }, radius } => {
            Some((Tag::Torus, DVec3::new(ring, radius, 0.0)))
        }
        Geometry::Ellipsoid { radii } => Some((Tag::Ellipsoid, radii)),
        Geometry::Convex(_) => None,
    }
}

impl Cast {
    /// A body in the device's layout; `scale` is samples per length.
    fn new(drawn: &Drawn, scale: f64) -> Option<Cast> {
        let bounds = &drawn.bounds;
        let (kind, sizes) = numbers(&bounds.geometry)?;
        let size = sizes.max_element();
        let axis = |axis: DVec3, last: f64| axis.extend(last).as_vec4().to_array();
        let [right, up, toward] = bounds.axes;
        let place = [drawn.x.floor(), drawn.y.floor()];
        Some(Cast {
            right: axis(right, size),
            up: axis(up, 1.0 / (scale * size)),
            toward: axis(toward, bounds.centre.z + bounds.reach.z),
            sizes: axis(sizes / size, bounds.centre.z),
            rest: [(drawn.x - place[0]) as f32, (drawn.y - place[1]) as f32],
            kind: kind as u32,
            body: drawn.body,
            place: place.map(|samples| samples as i32),
            columns: drawn.columns.map(|column| column as u32),
            rows: drawn.rows.map(|row| row as u32),
            unused: [0; 2],
        })
    }
}

impl Rays {
    /// Compiles the kernel.
    ///
    /// # Errors
    /// [`GpuError::Kernel`], [`GpuError::OutOfMemory`].
    pub fn new(gpu: Arc<Gpu>) -> Result<Self, GpuError> {
        let kernel = Mutex::new(CastTiles::make(&gpu, source())?);
        Ok(Rays { gpu, kernel })
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// The samples of all tiles, tile after tile; none if only the CPU supports some body.
    pub(super) fn cast(
        &self,
        drawn: &[Drawn],
        (first, members): (&[usize], &[u32]),
        columns: usize,
        scale: f64,
    ) -> Result<Option<Vec<Sample>>, GpuError> {
        let Some(bodies) = drawn.iter().map(|drawn| Cast::new(drawn, scale)).collect::<Option<Vec<_>>>() else {
            return Ok(None);
        };
        let crowded = first.windows(2).any(|tile| tile[1] - tile[0] > MOST_OF_A_TILE);
        let starts: Option<Vec<u32>> = first.iter().map(|start| u32::try_from(*start).ok()).collect();
        let Some(starts) = starts.filter(|_| !crowded) else { return Ok(None) };
        let kernel = self.kernel.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        let gpu = &*self.gpu;
        let starts = Buffer::with(gpu, "tiles", 4, bytemuck::cast_slice(&starts))?;
        let members = Buffer::with(gpu, "bodies of tiles", 4, bytemuck::cast_slice(members))?;
        let bodies = Buffer::with(gpu, "drawn bodies", size_of::<Cast>(), bytemuck::cast_slice(&bodies))?;
        let cast = Buffer::new(gpu, "samples", size_of::<Sample>(), (BAND * TILE * TILE) as u64)?;
        let tiles = first.len() - 1;
        let mut samples: Vec<Sample> = Vec::with_capacity(tiles * TILE * TILE);
        for band in (0..tiles).step_by(BAND) {
            let count = BAND.min(tiles - band);
            let (first, members, drawn) = (&starts, &members, &bodies);
            let arguments = CastArgs { first_tile: band, columns, tiles: count, first, members, drawn, samples: &cast };
            let mut record = gpu.record();
            record.stage("cast");
            kernel.call(&mut record, Size::Groups(count as u64), arguments);
            let bytes = (count * TILE * TILE * size_of::<Sample>()) as u64;
            let read = record.read(&[(&cast, 0..bytes)])?;
            samples.extend(read.iter().flat_map(|bytes| bytemuck::pod_collect_to_vec::<u8, Sample>(bytes)));
        }
        Ok(Some(samples))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::validate;
    use std::mem::offset_of;

    #[test]
    fn the_kernel_is_valid_and_its_bodies_and_samples_are_laid_out_as_here() {
        let module = validate(&CastTiles::sources(source())[0]).unwrap();
        let mut layouter = naga::proc::Layouter::default();
        layouter.update(module.to_ctx()).unwrap();
        let members = |of: &str| {
            let (handle, found) = module.types.iter().find(|(_, t)| t.name.as_deref() == Some(of)).unwrap();
            let naga::TypeInner::Struct { members, .. } = &found.inner else { panic!("not a struct") };
            let members: Vec<_> = members.iter().map(|m| (m.name.clone().unwrap(), m.offset as usize)).collect();
            (layouter[handle].size as usize, members)
        };
        let named = |(name, offset): (&str, usize)| (name.to_owned(), offset);
        let cast = [
            ("right", offset_of!(Cast, right)),
            ("up", offset_of!(Cast, up)),
            ("toward", offset_of!(Cast, toward)),
            ("sizes", offset_of!(Cast, sizes)),
            ("rest", offset_of!(Cast, rest)),
            ("kind", offset_of!(Cast, kind)),
            ("body", offset_of!(Cast, body)),
            ("place", offset_of!(Cast, place)),
            ("columns", offset_of!(Cast, columns)),
            ("rows", offset_of!(Cast, rows)),
            ("unused", offset_of!(Cast, unused)),
        ];
        assert_eq!(members("Drawn"), (size_of::<Cast>(), cast.map(named).to_vec()));
        let sample = [
            ("body", offset_of!(Sample, body)),
            ("height", offset_of!(Sample, height)),
            ("normal", offset_of!(Sample, normal)),
        ];
        assert_eq!(members("Sample"), (size_of::<Sample>(), sample.map(named).to_vec()));
    }
}
