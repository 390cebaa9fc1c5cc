//! The surfaces of superellipsoids, which no glyph of ParaView draws.

use super::super::surface::Surface;
use super::super::vtp::{Array, Cells, NORMALS, Numbers, PolyData};
use super::flat;
use crate::record::Snapshot;
use std::collections::HashMap;

/// The surfaces of all superellipsoids of a state. `None` for a state without superellipsoids.
pub(super) fn surfaces(state: &Snapshot) -> Option<PolyData> {
    let bodies = &state.bodies;
    let mut units: HashMap<[u64; 2], Surface> = HashMap::new();
    let (mut points, mut normals, mut polygons) = (Vec::new(), Vec::new(), Cells::default());
    let mut body = Vec::new();
    for (i, shape) in bodies.shape.iter().enumerate() {
        let Some(exponents) = shape.exponents() else { continue };
        let unit = units.entry(exponents.map(f64::to_bits)).or_insert_with(|| Surface::unit(exponents));
        let Surface { points: corners, normals: own, faces } = unit.scaled(shape.code().1);
        let (at, turn, first) = (bodies.position[i], bodies.orientation[i], points.len());
        points.extend(corners.into_iter().map(|corner| at + turn * corner));
        normals.extend(own.into_iter().flat_map(|normal| (turn * normal).as_vec3().to_array()));
        faces.into_iter().for_each(|face| polygons.push(face.into_iter().map(|corner| first + corner)));
        body.resize(points.len(), i as u32);
    }
    if body.is_empty() {
        return None;
    }
    let of = |i: &u32| bodies.lineage[*i as usize];
    let point_data = vec![
        Array::new(NORMALS, 3, Numbers::F32(normals)),
        Array::new("shape", 1, Numbers::U8(body.iter().map(|i| bodies.shape[*i as usize].code().0 as u8).collect())),
        Array::new("id", 1, Numbers::I64(body.iter().map(|i| of(i).id as i64).collect())),
        Array::new("generation", 1, Numbers::U32(body.iter().map(|i| of(i).generation).collect())),
        Array::rows("birth", body.iter().map(|i| [of(i).birth])),
        Array::new("body", 1, Numbers::U32(body)),
    ];
    Some(PolyData { points: flat(&points), polygons, point_data, time: state.time, ..PolyData::default() })
}
