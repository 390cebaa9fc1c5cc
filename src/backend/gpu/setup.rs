//! The properties of a scene that determine its kernels and the buffers of a run.

use crate::dynamics::{Bonds, Cells, Dynamics, Force, Heat, Strain, Stream};
use crate::gpu::{GpuError, Lattice, LatticePeriods, Precision};
use crate::periodic::{CellShear, Periods};
use crate::separation::branches::gpu::Branched;
use crate::separation::gpu::unsupported;
use crate::shape::Shape;
use crate::shape::gpu::Exponents;
use crate::step::{Model, Rows, State, Stepping, Time};
use crate::walls::Walls;

/// The resolution of growing lengths: the coarse part of a length is a multiple of the longest length over this, which
/// a float holds exactly.
const LENGTHS: f64 = 1_048_576.0;

/// By how many factors of two a pitch that is kept may differ from a scene's own.
const MOST_PITCHES_APART: f64 = 2.0;

/// The properties of a scene that its kernels need.
pub(crate) struct Setup {
    pub precision: Precision,
    pub planar: bool,
    pub lattice: Lattice,
    /// The periods at the start.
    pub periods: Periods,
    pub lattice_periods: LatticePeriods,
    pub dt: f64,
    pub time: Time,
    /// Whether steps are midpoint steps.
    pub midpoint: bool,
    /// The number of branches of a pair that may get a row; zero with the paper's rows.
    pub branches: u32,
    pub cutoff: f64,
    pub dynamics: Dynamics,
    /// Without pulls of single bodies, which the host computes.
    pub forces: Vec<Force>,
    pub groups: Vec<String>,
    pub bonds: Bonds,
    pub heat: Option<Heat>,
    pub stream: Option<Stream>,
    pub strain: Option<Strain>,
    pub growth: Option<Cells>,
    pub length_pitch: f64,
    pub shapes: Vec<Shape>,
    /// Those of the superellipsoids among the shapes.
    pub exponents: Exponents,
    /// The smallest thickness of a body.
    pub thinnest: f64,
    pub walls: Walls,
    /// The error assumed for overlaps: violations begin at an overlap smaller by this, and reported overlaps are larger
    /// by this, so that the tolerance holds in exact arithmetic.
    pub rounding: f64,
}

/// The error of overlaps in 32 bits, as a fraction of the longest body's length, and its largest fraction of the
/// tolerance. In a colony of 4,096 rods up to 4 long, overlaps of up to 1e-5 had errors of 2.7e-8, half of this.
const ROUNDING_OF_OVERLAPS: f64 = 1.0 / (1 << 26) as f64;
const MOST_ROUNDING: f64 = 0.05;

/// The same with superellipsoids, whose separations near contact had errors of up to 1.4e-7 of both radii and the
/// distance of the centres, in 12,000 pairs.
const ROUNDING_WITH_POWERS: f64 = 1.0 / (1 << 21) as f64;

/// The largest length of a growing body, now or at its division.
fn longest(model: &Model, shapes: &[Shape]) -> f64 {
    let species = model.cells.as_ref().map_or(&[][..], Cells::species);
    let grow = |shape: &&Shape| shape.rod_length().is_some() || species.iter().any(|of| of.length_of(shape).is_some());
    let growing = || shapes.iter().filter(grow).filter_map(Shape::growing_length);
    let shortest = |shape: &Shape| if grow(&shape) { shape.shortest_length() } else { shape.thickness() };
    let (start, thickest) = (growing().fold(0.0, f64::max), shapes.iter().map(shortest).fold(0.0, f64::max));
    let span = (model.time.dt, model.time.end - model.time.start);
    species.iter().map(|growth| growth.longest_division(start, thickest, span)).fold(start, f64::max)
}

impl Setup {
    /// The setup of a scene with bodies of these shapes.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] for shapes and pairs of them that only the CPU has, and for bodies that are too thin
    /// or too thick for 32-bit floats.
    pub fn new(model: &Model, shapes: &[Shape], precision: Precision) -> Result<Self, GpuError> {
        if let Some(what) = unsupported(shapes.iter().copied(), model.planar) {
            return Err(GpuError::Unsupported { what });
        }
        let least = model.thinnest.unwrap_or(f64::INFINITY);
        let thinnest = shapes.iter().map(Shape::thickness).fold(least, f64::min);
        let longest = longest(model, shapes);
        let periods = model.periods;
        // Without bodies, any lattice that can hold the periods is suitable.
        let none = periods.shortest().map_or(1.0, |period| 0.5 * period);
        let lattice = Lattice::for_thickness(if thinnest.is_finite() { thinnest } else { none })?;
        let largest = shapes.iter().map(|shape| 2.0 * shape.bounding_radius()).fold(longest, f64::max);
        let exponents = Exponents::of(shapes);
        let part = if exponents.is_empty() { ROUNDING_OF_OVERLAPS } else { ROUNDING_WITH_POWERS };
        let rounding = match precision {
            Precision::F32 => (part * largest).min(MOST_ROUNDING * model.contact.overlap_tolerance),
            Precision::F64 => 0.0,
        };
        Ok(Setup {
            rounding,
            precision,
            planar: model.planar,
            lattice,
            periods,
            lattice_periods: LatticePeriods::of(lattice, periods.numbers())?,
            dt: model.time.dt,
            time: model.time,
            midpoint: model.time.stepping == Stepping::Midpoint,
            branches: match model.contact.rows_of_method() {
                Rows::Auto => Branched::of(shapes).most(),
                Rows::Paper => 0,
            },
            cutoff: model.contact.cutoff_of(shapes.iter().copied()),
            dynamics: model.dynamics,
            forces: model.forces.iter().filter(|force| !force.is_pull()).cloned().collect(),
            groups: model.groups.clone(),
            bonds: model.bonds.clone(),
            heat: model.heat,
            stream: model.stream,
            growth: model.cells.clone(),
            strain: model.strain,
            length_pitch: (longest / LENGTHS).max(f64::MIN_POSITIVE).log2().ceil().exp2(),
            shapes: shapes.to_vec(),
            exponents,
            thinnest,
            walls: model.walls.clone(),
        })
    }

    /// Continues with the pitch of lengths of a state that such a device left. A scene's own follows from its longest
    /// body, and a cell that is about to divide is longer than any was at the start. Lengths are up to 2^20 of their
    /// own pitch, and a float holds multiples up to 2^24.
    pub fn keep_pitch(&mut self, state: &State) {
        let Some(kept) = state.unrounded.as_ref().map(|had| had.kind[2]) else { return };
        let steps = (kept / self.length_pitch).log2();
        if steps.abs() <= MOST_PITCHES_APART && steps.fract() == 0.0 {
            self.length_pitch = kept;
        }
    }

    /// Vectors per motion of a body. With inertia, the rotational mobility is a matrix, and an angular momentum is
    /// added; with drag and inertia, also the impulse that follows a move. Drag that depends on the direction has both
    /// mobilities as matrices in any law, that of translation in the last two vectors.
    pub fn motion_width(&self) -> u32 {
        match (self.inertia(), self.is_damped(), self.has_axes_of_drag()) {
            (false, _, false) => 4,
            (false, _, true) => 9,
            (true, false, _) => 7,
            (true, true, false) => 8,
            (true, true, true) => 10,
        }
    }

    /// Whether ellipsoids grow.
    pub fn grows_ellipsoids(&self) -> bool {
        self.growth.as_ref().is_some_and(Cells::grow_ellipsoids)
    }

    /// Whether drag depends on the direction.
    pub fn has_axes_of_drag(&self) -> bool {
        self.dynamics.any_drag().is_some_and(|drag| drag.even().is_none())
    }

    /// Whether kernels other than that of the forces make loads.
    pub fn makes_loads(&self) -> bool {
        self.heat.is_some() || !self.bonds.is_empty()
    }

    /// The shear of a sheared cell.
    pub fn shear(&self) -> Option<CellShear> {
        self.strain.and_then(|strain| strain.shear())
    }

    /// The strain of a cell whose lengths change.
    pub fn strained(&self) -> Option<Strain> {
        self.strain.filter(|strain| strain.shear().is_none())
    }

    /// Whether bodies have drag and inertia.
    pub fn is_damped(&self) -> bool {
        self.dynamics.drag_beside_inertia().is_some()
    }

    /// Whether velocity is a part of the state.
    pub fn inertia(&self) -> bool {
        self.dynamics.has_inertia()
    }

    /// Whether states store angular momenta instead of angular velocities: in f32, where rounding would change momenta.
    /// A body that grows keeps its velocity, not its momentum; in the plane the two are equivalent.
    pub fn keeps_momentum(&self) -> bool {
        self.inertia() && !self.planar && self.precision == Precision::F32 && self.growth.is_none()
    }
}
