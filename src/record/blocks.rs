//! Conversion of a state to named arrays, and back.

use super::error::StateError;
use super::held::bond_blocks;
use super::npz::{Archive, Block, Data};
use crate::bodies::{Bodies, Columns, Lineage};
use crate::periodic::Periods;
use crate::scene::LARGEST_NUMBER;
use crate::shape::Shape;
use crate::step::{State, Unrounded, UnroundedBody};
use crate::walls::{WallState, surface_of};
use crate::warm::Warm;
use glam::{DQuat, DVec3};

/// The lengths of bodies at birth; NaN if a body's division rule does not need it.
const BIRTH_LENGTH: &str = "birth_length";

/// The exponents of superellipsoids, zero of other bodies: written where there are any.
const EXPONENTS: &str = "exponents";

/// The arrays of rates and division lengths of single cells. A cell without a value of its own has NaN.
const OWN_GROWTH: [&str; 2] = ["own_rate", "own_division_length"];

/// The named columns of bodies, one after the other, in the order of their names in the header.
const COLUMNS: &str = "columns";

/// The concentrations of all fields, one after the other, in the order of the header.
const FIELDS: &str = "fields";

/// The friction forces of near pairs, where there are any.
const TANGENT: &str = "warm_tangent";

/// The parent of a body that has none.
const NO_PARENT: u64 = u64::MAX;

/// The largest deviation of an orientation's norm from one: far above the rounding of 32-bit floats.
const NORM_TOLERANCE: f64 = 1e-4;

/// Refuses the first row with a number that no scene allows: not finite, or too large.
pub(super) fn sane<const N: usize>(name: &'static str, rows: Vec<[f64; N]>) -> Result<Vec<[f64; N]>, StateError> {
    // NaN fails the comparison too.
    let wild = rows.iter().position(|row| !row.iter().all(|x| x.abs() <= LARGEST_NUMBER));
    wild.map_or(Ok(rows), |row| Err(StateError::row(name, row)))
}

pub(super) fn f64s<const N: usize>(name: &'static str, rows: impl Iterator<Item = [f64; N]>) -> Block {
    Block { name, columns: N, data: Data::F64(rows.flatten().collect()) }
}

fn u64s(name: &'static str, rows: impl Iterator<Item = u64>) -> Block {
    Block { name, columns: 1, data: Data::U64(rows.collect()) }
}

pub(super) fn u32s<const N: usize>(name: &'static str, rows: impl Iterator<Item = [u32; N]>) -> Block {
    Block { name, columns: N, data: Data::U32(rows.flatten().collect()) }
}

/// The bodies, one row each, and their broken bonds. Lengths at birth are included if any body has one.
pub(super) fn body_blocks(bodies: &Bodies) -> Vec<Block> {
    let born = || bodies.lineage.iter().map(|l| l.birth_length);
    let birth_length = f64s(BIRTH_LENGTH, born().map(|length| [length.unwrap_or(f64::NAN)]));
    let mut blocks = vec![
        f64s("position", bodies.position.iter().map(DVec3::to_array)),
        f64s("orientation", bodies.orientation.iter().map(|q| [q.w, q.x, q.y, q.z])),
        f64s("velocity", bodies.velocity.iter().map(DVec3::to_array)),
        f64s("angular_velocity", bodies.angular_velocity.iter().map(DVec3::to_array)),
        u32s("shape", bodies.shape.iter().map(|s| [s.code().0])),
        f64s("size", bodies.shape.iter().map(|s| s.code().1)),
        u32s("group", bodies.group.iter().map(|g| [*g])),
        u64s("id", bodies.lineage.iter().map(|l| l.id)),
        u64s("parent", bodies.lineage.iter().map(|l| l.parent.unwrap_or(NO_PARENT))),
        f64s("birth", bodies.lineage.iter().map(|l| [l.birth])),
        u32s("generation", bodies.lineage.iter().map(|l| [l.generation])),
    ];
    if bodies.shape.iter().any(|shape| shape.exponents().is_some()) {
        blocks.push(f64s(EXPONENTS, bodies.shape.iter().map(|shape| shape.exponents().unwrap_or([0.0; 2]))));
    }
    if !bodies.broken_bonds.is_empty() {
        blocks.push(u32s("broken_bonds", bodies.broken_bonds.iter().map(|bond| [*bond])));
    }
    if !bodies.walls.is_empty() {
        blocks.push(f64s("walls", bodies.walls.iter().map(|wall| [wall.shift, wall.velocity])));
    }
    blocks.extend(born().any(|length| length.is_some()).then_some(birth_length));
    blocks.extend(column_blocks(&bodies.columns, bodies.len()));
    blocks
}

/// The values that bodies have of their own, if any has some.
fn column_blocks(columns: &Columns, bodies: usize) -> Vec<Block> {
    let mut blocks = Vec::new();
    if columns.has_growth() {
        let own = |i: usize| columns.growth(i);
        let [rate, length] = OWN_GROWTH;
        blocks.push(f64s(rate, (0..bodies).map(|i| [own(i).rate.unwrap_or(f64::NAN)])));
        blocks.push(f64s(length, (0..bodies).map(|i| [own(i).division_length.unwrap_or(f64::NAN)])));
    }
    if columns.named().next().is_some() {
        blocks.push(f64s(COLUMNS, columns.named().flat_map(|(_, values)| values).map(|value| [*value])));
    }
    blocks
}

/// Reads the arrays of [`column_blocks`]; `names` are those of the columns, ascending.
pub(super) fn read_columns(source: &mut Archive, rows: usize, names: &[String]) -> Result<Columns, StateError> {
    let mut columns = Columns::default();
    if source.has(OWN_GROWTH[0]) {
        for (nth, name) in OWN_GROWTH.into_iter().enumerate() {
            for (row, [value]) in source.f64s::<1>(name, rows)?.into_iter().enumerate() {
                let own = columns.growth_mut(row, rows);
                let of = if nth == 0 { &mut own.rate } else { &mut own.division_length };
                *of = (!value.is_nan()).then_some(value);
                if value < 0.0 {
                    return Err(StateError::row(name, row));
                }
            }
        }
    }
    if !names.is_empty() {
        let values = source.f64s::<1>(COLUMNS, names.len().saturating_mul(rows))?;
        for (nth, name) in names.iter().enumerate() {
            let own = columns.named_mut(name, rows);
            own.iter_mut().zip(&values[nth * rows..]).for_each(|(own, [value])| *own = *value);
        }
    }
    Ok(columns)
}

/// Reads the broken bonds, whose indices must ascend.
pub(super) fn read_broken_bonds(source: &mut Archive, rows: usize) -> Result<Vec<u32>, StateError> {
    let bonds: Vec<u32> = source.u32s::<1>("broken_bonds", rows)?.into_iter().map(|[bond]| bond).collect();
    match bonds.windows(2).position(|pair| pair[0] >= pair[1]) {
        Some(row) => Err(StateError::row("broken_bonds", row + 1)),
        None => Ok(bonds),
    }
}

/// Reads where walls under a load are.
pub(super) fn read_walls(source: &mut Archive, rows: usize) -> Result<Vec<WallState>, StateError> {
    let walls = source.f64s::<2>("walls", rows)?;
    match walls.iter().position(|wall| !wall.iter().all(|number| number.is_finite())) {
        Some(row) => Err(StateError::row("walls", row)),
        None => Ok(walls.into_iter().map(|[shift, velocity]| WallState { shift, velocity }).collect()),
    }
}

/// The warm start of the near pairs, one row each.
pub(super) fn warm_blocks(warm: &[Warm]) -> Vec<Block> {
    let mut blocks = vec![
        u32s("warm_pair", warm.iter().map(|w| w.pair)),
        u32s("warm_feature", warm.iter().map(|w| [w.feature])),
        f64s("warm_gamma", warm.iter().map(|w| [w.gamma])),
        f64s("warm_normal", warm.iter().map(|w| w.normal.to_array())),
    ];
    if has_friction(warm) {
        blocks.push(f64s(TANGENT, warm.iter().map(|w| w.tangent.to_array())));
    }
    blocks
}

/// Whether a pair has a friction force.
pub(super) fn has_friction(warm: &[Warm]) -> bool {
    warm.iter().any(|w| w.tangent != DVec3::ZERO)
}

/// Whether a file has friction forces.
pub(super) fn has_tangents(source: &Archive) -> bool {
    source.has(TANGENT)
}

fn shapes(source: &mut Archive, rows: usize) -> Result<Vec<Shape>, StateError> {
    let sizes = sane("size", source.f64s::<3>("size", rows)?)?;
    let tags = source.u32s::<1>("shape", rows)?;
    let exponents = match source.has(EXPONENTS) {
        true => sane(EXPONENTS, source.f64s::<2>(EXPONENTS, rows)?)?.into_iter().map(Some).collect(),
        false => vec![None; rows],
    };
    // A rod shorter than thick is not valid.
    let real = |shape: &Shape| shape.validate().is_ok();
    let shape = |row: usize| {
        let shape = Shape::from_numbers(tags[row][0], sizes[row], exponents[row]);
        shape.filter(real).ok_or_else(|| StateError::row("shape", row))
    };
    (0..rows).map(shape).collect()
}

/// The lengths at birth, if the state has them.
fn birth_lengths(source: &mut Archive, rows: usize) -> Result<Vec<Option<f64>>, StateError> {
    if !source.has(BIRTH_LENGTH) {
        return Ok(vec![None; rows]);
    }
    let lengths = source.f64s::<1>(BIRTH_LENGTH, rows)?.into_iter().map(|[l]| (!l.is_nan()).then_some(l));
    let lengths: Vec<Option<f64>> = lengths.collect();
    let sane = |length: &Option<f64>| length.is_none_or(|l| l > 0.0 && l <= LARGEST_NUMBER);
    match lengths.iter().position(|length| !sane(length)) {
        Some(row) => Err(StateError::row(BIRTH_LENGTH, row)),
        None => Ok(lengths),
    }
}

/// Reads the arrays of [`body_blocks`].
pub(super) fn read_bodies(source: &mut Archive, rows: usize) -> Result<Bodies, StateError> {
    let parents = source.u64s("parent", rows)?;
    let births = source.f64s::<1>("birth", rows)?;
    let generations = source.u32s::<1>("generation", rows)?;
    let ids = source.u64s("id", rows)?;
    let birth_lengths = birth_lengths(source, rows)?;
    let lineage = (0..rows).map(|i| Lineage {
        id: ids[i],
        parent: (parents[i] != NO_PARENT).then_some(parents[i]),
        birth: births[i][0],
        generation: generations[i][0],
        birth_length: birth_lengths[i],
    });
    let orientation = source.f64s::<4>("orientation", rows)?;
    let orientation: Vec<DQuat> = orientation.into_iter().map(|[w, x, y, z]| DQuat::from_xyzw(x, y, z, w)).collect();
    // NaN fails the comparison too.
    let unit = |q: &DQuat| (q.length() - 1.0).abs() <= NORM_TOLERANCE;
    if let Some(row) = orientation.iter().position(|q| !unit(q)) {
        return Err(StateError::row("orientation", row));
    }
    let mut vectors = |name: &'static str| {
        let rows = sane(name, source.f64s::<3>(name, rows)?)?;
        Ok::<_, StateError>(rows.into_iter().map(DVec3::from_array).collect::<Vec<_>>())
    };
    let [position, velocity, angular_velocity] =
        [vectors("position")?, vectors("velocity")?, vectors("angular_velocity")?];
    Ok(Bodies {
        shape: shapes(source, rows)?,
        position,
        orientation,
        velocity,
        angular_velocity,
        group: source.u32s::<1>("group", rows)?.into_iter().map(|[g]| g).collect(),
        lineage: lineage.collect(),
        columns: Columns::default(),
        broken_bonds: Vec::new(),
        bonds: Vec::new(),
        walls: Vec::new(),
        periods: Periods::NONE,
        planar: false,
    })
}

/// Reads the arrays of [`warm_blocks`]; every pair must be two of the `bodies` bodies, in ascending order, or a body
/// and a surface of a wall.
pub(super) fn read_warm(
    source: &mut Archive,
    [rows, bodies]: [usize; 2],
    with_friction: bool,
) -> Result<Vec<Warm>, StateError> {
    let pairs = source.u32s::<2>("warm_pair", rows)?;
    let features = source.u32s::<1>("warm_feature", rows)?;
    let gammas = source.f64s::<1>("warm_gamma", rows)?;
    let normals = source.f64s::<3>("warm_normal", rows)?;
    let tangents = if with_friction { source.f64s::<3>(TANGENT, rows)? } else { vec![[0.0; 3]; rows] };
    let rows = pairs.into_iter().zip(features).zip(gammas).zip(normals).zip(tangents).enumerate();
    rows.map(|(row, ((((pair, [feature]), [gamma]), normal), tangent))| {
        let known = |number: u32| (number as usize) < bodies;
        if pair[0] >= pair[1] || !known(pair[0]) || !(known(pair[1]) || surface_of(pair[1]).is_some()) {
            return Err(StateError::row("warm_pair", row));
        }
        let [normal, tangent] = [normal, tangent].map(DVec3::from_array);
        Ok(Warm { pair, feature, gamma, normal, tangent })
    })
    .collect()
}

/// A device's numbers of the bodies.
pub(super) fn unrounded_blocks(unrounded: &Unrounded) -> [Block; 2] {
    let cells = unrounded.bodies.iter().map(|body| body.cell.map(i32::cast_unsigned));
    [u32s("device_cells", cells), f64s("device_numbers", unrounded.bodies.iter().map(UnroundedBody::to_numbers))]
}

/// Reads the arrays of [`unrounded_blocks`]. Their use checks whether they match the bodies.
pub(super) fn read_unrounded(source: &mut Archive, kind: [f64; 3], rows: usize) -> Result<Unrounded, StateError> {
    let cells = source.u32s::<3>("device_cells", rows)?.into_iter().map(|cell| cell.map(u32::cast_signed));
    let numbers = source.f64s("device_numbers", rows)?;
    let bodies = cells.zip(numbers).map(|(cell, numbers)| UnroundedBody::from_numbers(cell, numbers)).collect();
    Ok(Unrounded { kind, bodies })
}

/// Reads the concentrations of all fields.
pub(super) fn read_concentrations(source: &mut Archive, rows: usize) -> Result<Vec<f64>, StateError> {
    Ok(sane(FIELDS, source.f64s::<1>(FIELDS, rows)?)?.into_iter().map(|[value]| value).collect())
}

/// All arrays of a state, with those of its near pairs if requested.
pub(super) fn blocks(state: &State, with_warm: bool) -> Vec<Block> {
    let mut blocks = body_blocks(&state.bodies);
    blocks.extend(bond_blocks(&state.bodies.bonds, with_warm));
    if !state.fields.is_empty() {
        blocks.push(f64s(FIELDS, state.fields.iter().flat_map(|of| &of.values).map(|value| [*value])));
    }
    if with_warm {
        blocks.extend(warm_blocks(&state.warm));
    }
    blocks
}
