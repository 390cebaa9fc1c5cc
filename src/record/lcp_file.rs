//! One LCP as a file that numpy opens as `.npz`, for tests of a solver outside a run.
//!
//! Arrays, little-endian: `bodies` (their number), `a`, `b` (the bodies of each row), `row_a`, `row_b` (rows x
//! unknowns: the two blocks of each row of `J`, scaled so that `A = J J^T`; 3 unknowns per body in the plane, 6 in
//! space), `q` (`g` at `gamma = 0`, a length), `gamma0` (the start), `gamma` (the solver's result), `v` (`J^T
//! gamma`, bodies x unknowns).
//!
//! Files of this program also have a `header` and a seal, like states. Files of other programs need neither, may be
//! deflated, and may have numbers of 4 or 8 bytes.

use super::durable;
use super::error::{LcpFileError, RecordError};
use super::npz::{Block, Data, EARLIER_HEADER, HEADER, MAGIC, header_json, header_text, seal_holds, write};
use crate::freedom::{PLANAR, SPATIAL};
use crate::lcp::Stored;
use crate::simulation::Simulation;
use crate::step::SavedLcp;
use serde::{Deserialize, Serialize};
use std::fmt::Display;
use std::io::{Cursor, Read};
use std::path::Path;
use zip::{CompressionMethod, ZipArchive};

/// The name of the format, in a file's header.
pub const LCP_FORMAT: &str = "relcp-lcp";
/// The version that this program writes; it reads versions up to it.
pub const LCP_VERSION: u64 = 1;

/// The largest compression ratio of deflate (RFC 1951: 258 bytes from two bits, without the block's header).
const TIGHTEST: u64 = 1_032;
/// An array may always unpack to this many bytes.
const LOOSE_BYTES: u64 = 64 << 20;
/// Beyond that, the largest compression ratio of an array. Arrays of LCPs of colonies have ratios of 1 to 9; only a
/// start of zeros has 175, which up to eight million rows is below the limit above.
const LOOSEST: u64 = 100;

/// The header of an LCP's file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LcpHeader {
    /// [`LCP_FORMAT`].
    pub format: String,
    /// Version of the format.
    pub version: u64,
    /// Version of the program that wrote it.
    pub program: String,
    /// Name of the scene.
    pub scene: String,
    /// The step, from 1.
    pub step: u64,
    /// Solves of the step before this one.
    pub recursion: u32,
    /// The solver, by its name in scenes.
    pub solver: String,
    /// The solver's tolerance, a length.
    pub tolerance: f64,
    /// The precision: `f32` or `f64`.
    pub precision: String,
    /// The status of the solve.
    pub status: String,
    /// Applications of `A`.
    pub products: u64,
}

impl LcpHeader {
    pub(crate) fn new(simulation: &Simulation, kept: &SavedLcp) -> Self {
        let scene = simulation.scene();
        let name = |value: serde_json::Result<serde_json::Value>| match value {
            Ok(serde_json::Value::String(name)) => name,
            _ => String::new(),
        };
        LcpHeader {
            format: LCP_FORMAT.into(),
            version: LCP_VERSION,
            program: env!("CARGO_PKG_VERSION").into(),
            scene: scene.name.clone(),
            step: kept.step,
            recursion: kept.recursion,
            solver: name(serde_json::to_value(scene.solver.kind)),
            tolerance: kept.tolerance,
            precision: simulation.precision().name().into(),
            status: kept.outcome.status.name().into(),
            products: kept.outcome.products,
        }
    }
}

fn damaged(place: &str, what: impl Display) -> LcpFileError {
    LcpFileError::Damaged { place: place.into(), what: what.to_string() }
}

/// The bytes of an LCP.
///
/// ```
/// use relcp::lcp::{Problem, Stored};
/// use relcp::record::{LCP_FORMAT, LCP_VERSION, LcpHeader, decode_lcp, encode_lcp};
/// let jacobian = vec![[[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]];
/// let problem = Problem { bodies: 2, pair: vec![[0, 1]], jacobian, q: vec![-0.1], ..Problem::default() };
/// let lcp = Stored::new(&problem, vec![0.0], &[0.05]);
/// let header = LcpHeader {
///     format: LCP_FORMAT.into(), version: LCP_VERSION, program: "mine".into(), scene: "two".into(), step: 1, recursion: 0,
///     solver: "apgd".into(), tolerance: 1e-6, precision: "f64".into(), status: "solved".into(), products: 3,
/// };
/// assert_eq!(decode_lcp(&encode_lcp(&lcp, &header)?)?, (lcp, Some(header)));
/// # Ok::<(), relcp::record::LcpFileError>(())
/// ```
///
/// # Errors
/// [`LcpFileError::Unwritable`].
pub fn encode_lcp(lcp: &Stored, header: &LcpHeader) -> Result<Vec<u8>, LcpFileError> {
    let unwritable = |what: String| LcpFileError::Unwritable(what);
    let json = serde_json::to_vec_pretty(header).map_err(|e| unwritable(e.to_string()))?;
    let side = |side: usize| Data::I32(lcp.pair.iter().map(|pair| pair[side] as i32).collect());
    let reals = |name, columns, values: &[f64]| Block { name, columns, data: Data::F64(values.to_vec()) };
    let blocks = [
        Block { name: "bodies", columns: 0, data: Data::I64(vec![lcp.bodies as i64]) },
        Block { name: "a", columns: 1, data: side(0) },
        Block { name: "b", columns: 1, data: side(1) },
        reals("row_a", lcp.unknowns, &lcp.rows[0]),
        reals("row_b", lcp.unknowns, &lcp.rows[1]),
        reals("q", 1, &lcp.q),
        reals("gamma0", 1, &lcp.start),
        reals("gamma", 1, &lcp.gamma),
        reals("v", lcp.unknowns, &lcp.velocity),
    ];
    write(&json, &blocks).map_err(|e| unwritable(e.to_string()))
}

/// Reads the bytes of an LCP, and its header if it has one. Non-finite numbers are read unchanged, because they may be
/// the subject of interest.
///
/// # Errors
/// [`LcpFileError`] for bytes that have another format, are damaged or truncated, or are not valid for an LCP.
pub fn decode_lcp(bytes: &[u8]) -> Result<(Stored, Option<LcpHeader>), LcpFileError> {
    let mut arrays = Arrays::open(bytes)?;
    let header = arrays.header()?;
    // A file of this program has both, even if damaged.
    let sealed = seal_holds(bytes);
    if sealed == Some(false) || (header.is_some() && sealed.is_none()) {
        return Err(arrays.find_damage());
    }
    let (bodies, shape) = arrays.integers("bodies")?;
    let bodies = match (shape.as_slice(), bodies.as_slice()) {
        ([] | [1], [n]) if u32::try_from(*n).is_ok() => *n as usize,
        _ => return Err(damaged("bodies", "it is not one number of bodies")),
    };
    let (q, shape) = arrays.reals("q")?;
    let [rows] = shape[..] else { return Err(damaged("q", "it is not one number a row")) };
    let (row_a, shape) = arrays.reals("row_a")?;
    let unknowns = match shape[..] {
        [of, unknowns @ (PLANAR | SPATIAL)] if of == rows => unknowns,
        _ => return Err(damaged("row_a", format!("it is not {rows} rows of {PLANAR} or {SPATIAL} numbers"))),
    };
    let [a, b] = [arrays.bodies("a", rows, bodies)?, arrays.bodies("b", rows, bodies)?];
    let pair: Vec<[u32; 2]> = a.into_iter().zip(b).map(|(a, b)| [a, b]).collect();
    if let Some(row) = pair.iter().position(|[a, b]| a == b) {
        return Err(damaged("b", format!("row {row} has the same body twice")));
    }
    let lcp = Stored {
        unknowns,
        bodies,
        pair,
        rows: [row_a, arrays.shaped("row_b", &[rows, unknowns])?],
        q,
        start: arrays.shaped("gamma0", &[rows])?,
        gamma: arrays.shaped("gamma", &[rows])?,
        velocity: arrays.shaped("v", &[bodies, unknowns])?,
    };
    Ok((lcp, header))
}

/// Writes an LCP, atomically.
///
/// # Errors
/// [`RecordError`] with the file.
pub fn write_lcp(path: &Path, lcp: &Stored, header: &LcpHeader) -> Result<(), RecordError> {
    let fault = |fault| RecordError::Lcp { path: path.into(), fault };
    durable::write(path, &encode_lcp(lcp, header).map_err(fault)?)
}

/// Reads the file of an LCP; of a file that is not a zip, only the start.
///
/// # Errors
/// [`RecordError`] with the file.
pub fn read_lcp(path: &Path) -> Result<(Stored, Option<LcpHeader>), RecordError> {
    let fault = || RecordError::io(path, "read it");
    let mut file = std::fs::File::open(path).map_err(fault())?;
    let mut bytes = Vec::new();
    file.by_ref().take(MAGIC.len() as u64).read_to_end(&mut bytes).map_err(fault())?;
    if bytes == MAGIC {
        file.read_to_end(&mut bytes).map_err(fault())?;
    }
    decode_lcp(&bytes).map_err(|fault| RecordError::Lcp { path: path.into(), fault })
}

/// The arrays of any program's `.npz`.
struct Arrays<'a>(ZipArchive<Cursor<&'a [u8]>>);

impl<'a> Arrays<'a> {
    fn open(bytes: &'a [u8]) -> Result<Self, LcpFileError> {
        if !bytes.starts_with(MAGIC) {
            return Err(LcpFileError::NotAnLcp("it is no zip".into()));
        }
        // The directory of a zip is at its end.
        ZipArchive::new(Cursor::new(bytes)).map(Arrays).map_err(|e| damaged("the end of the file", e))
    }

    fn header(&mut self) -> Result<Option<LcpHeader>, LcpFileError> {
        #[derive(Deserialize)]
        struct Kind {
            format: String,
            version: u64,
        }
        let json = if self.0.index_for_name(HEADER).is_some() {
            header_json(self.entry(HEADER)?).ok_or_else(|| damaged(HEADER, "it is no array"))?
        } else if self.0.index_for_name(EARLIER_HEADER).is_some() {
            self.entry(EARLIER_HEADER)?
        } else {
            return Ok(None);
        };
        let kind: Kind = serde_json::from_slice(&json).map_err(|e| damaged(HEADER, e))?;
        if kind.format != LCP_FORMAT {
            return Err(LcpFileError::NotAnLcp(format!("it is a `{}`", kind.format)));
        }
        if kind.version > LCP_VERSION {
            return Err(LcpFileError::Newer { found: kind.version, known: LCP_VERSION });
        }
        serde_json::from_slice(&json).map(Some).map_err(|e| damaged(HEADER, e))
    }

    /// If the seal does not hold, the first entry with a wrong CRC.
    fn find_damage(&mut self) -> LcpFileError {
        // Overlapping entries would multiply the bytes to read.
        if !matches!(self.0.has_overlapping_entries(), Ok(false)) {
            return damaged("the directory", "its entries overlap");
        }
        let names: Vec<String> = self.0.file_names().filter_map(|n| n.ok().map(|n| n.into_owned())).collect();
        let broken = names.iter().find_map(|name| self.entry(name).err());
        broken.unwrap_or_else(|| damaged("the seal", "the bytes are not those that were written"))
    }

    /// A whole entry, with its CRC checked. Allocations are limited by its packed size.
    fn entry(&mut self, name: &str) -> Result<Vec<u8>, LcpFileError> {
        let entry = self.0.by_name(name).map_err(|e| match e {
            zip::result::ZipError::FileNotFound => LcpFileError::NotAnLcp(format!("it has no {name}")),
            e => damaged(name, e),
        })?;
        let most = match entry.compression() {
            CompressionMethod::Stored => entry.compressed_size(),
            CompressionMethod::Deflated => entry.compressed_size().saturating_mul(TIGHTEST),
            other => return Err(damaged(name, format!("it is packed by {other}, which is not read"))),
        };
        let size = entry.size();
        if size > most {
            return Err(damaged(name, "its size cannot be"));
        }
        if size > LOOSE_BYTES && size > entry.compressed_size().saturating_mul(LOOSEST) {
            let message =
                format!("would unpack to {size} bytes, over {LOOSEST} times what it has here; save it without packing");
            return Err(damaged(name, message));
        }
        let mut bytes = Vec::new();
        entry.take(size + 1).read_to_end(&mut bytes).map_err(|e| damaged(name, e))?;
        if bytes.len() as u64 != size {
            return Err(damaged(name, "its size is not what the directory says"));
        }
        Ok(bytes)
    }

    /// An array: its number type, its shape, its bytes.
    fn array(&mut self, name: &str) -> Result<(String, Vec<usize>, Vec<u8>), LcpFileError> {
        let mut bytes = self.entry(&format!("{name}.npy"))?;
        let wrong = || damaged(name, "it is no array of numbers by rows");
        let (text, data) = header_text(&bytes).ok_or_else(wrong)?;
        let (kind, shape) = description(&text).ok_or_else(wrong)?;
        let width: usize = kind[2..].parse().map_err(|_| wrong())?;
        let wanted = shape.iter().try_fold(width, |bytes, n| bytes.checked_mul(*n));
        if wanted != Some(data) {
            return Err(damaged(name, "its shape is not that of its numbers"));
        }
        bytes.drain(..bytes.len() - data);
        Ok((kind, shape, bytes))
    }

    fn reals(&mut self, name: &str) -> Result<(Vec<f64>, Vec<usize>), LcpFileError> {
        let (kind, shape, bytes) = self.array(name)?;
        let numbers = match kind.as_str() {
            "<f8" => bytes.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)).collect(),
            "<f4" => bytes.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b).into()).collect(),
            _ => return Err(damaged(name, format!("its numbers are {kind}, not reals"))),
        };
        Ok((numbers, shape))
    }

    fn integers(&mut self, name: &str) -> Result<(Vec<i64>, Vec<usize>), LcpFileError> {
        let (kind, shape, bytes) = self.array(name)?;
        let numbers = match kind.as_str() {
            "<i8" => bytes.as_chunks().0.iter().map(|b| i64::from_le_bytes(*b)).collect(),
            "<i4" => bytes.as_chunks().0.iter().map(|b| i32::from_le_bytes(*b).into()).collect(),
            "<u4" => bytes.as_chunks().0.iter().map(|b| u32::from_le_bytes(*b).into()).collect(),
            _ => return Err(damaged(name, format!("its numbers are {kind}, not whole"))),
        };
        Ok((numbers, shape))
    }

    fn shaped(&mut self, name: &str, shape: &[usize]) -> Result<Vec<f64>, LcpFileError> {
        match self.reals(name)? {
            (numbers, found) if found == shape => Ok(numbers),
            (_, found) => Err(damaged(name, format!("its shape is {found:?}, not {shape:?}"))),
        }
    }

    /// The bodies of one side of the rows.
    fn bodies(&mut self, name: &str, rows: usize, bodies: usize) -> Result<Vec<u32>, LcpFileError> {
        let (numbers, shape) = self.integers(name)?;
        if shape != [rows] {
            return Err(damaged(name, format!("its shape is {shape:?}, not [{rows}]")));
        }
        let body = |(row, n): (usize, &i64)| match u32::try_from(*n) {
            Ok(body) if (body as usize) < bodies => Ok(body),
            _ => Err(damaged(name, format!("row {row} has body {n} of {bodies}"))),
        };
        numbers.iter().enumerate().map(body).collect()
    }
}

/// The type and the shape in numpy's description of an array.
fn description(text: &str) -> Option<(String, Vec<usize>)> {
    let rest = text.strip_prefix("{'descr':'")?;
    let (kind, rest) = rest.split_once("','fortran_order':False,'shape':(")?;
    let shape = rest.strip_suffix(")}")?;
    let known = ["<f4", "<f8", "<i4", "<i8", "<u4"].contains(&kind);
    let sides = shape.split(',').filter(|_| !shape.is_empty());
    let sides: Option<Vec<usize>> = sides.map(|n| n.parse().ok()).collect();
    Some((kind.to_owned(), sides?)).filter(|_| known)
}
