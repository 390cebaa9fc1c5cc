//! VTK's XML files of points, lines and data on them (`.vtp`), and of data on a grid (`.vti`), raw data appended.
//!
//! Written from the file formats' description (<https://docs.vtk.org>, "VTK XML formats"): each array is a count of
//! bytes (64 bits), then its little-endian numbers, at an offset from the underscore that starts the appended data.

use std::fmt::Write;

/// The name of the array that programs take for the surface's normals.
pub(super) const NORMALS: &str = "Normals";

/// An array's numbers.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Numbers {
    F64(Vec<f64>),
    F32(Vec<f32>),
    I64(Vec<i64>),
    I32(Vec<i32>),
    U32(Vec<u32>),
    U8(Vec<u8>),
}

/// A named array of `columns` numbers per row.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Array {
    pub(super) name: &'static str,
    pub(super) columns: usize,
    pub(super) numbers: Numbers,
}

impl Array {
    pub(super) fn new(name: &'static str, columns: usize, numbers: Numbers) -> Self {
        Array { name, columns, numbers }
    }

    /// Rows of 64-bit floats.
    pub(super) fn rows<const N: usize>(name: &'static str, rows: impl Iterator<Item = [f64; N]>) -> Self {
        Array::new(name, N, Numbers::F64(rows.flatten().collect()))
    }
}

/// Cells: the points of each, consecutively.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Cells {
    points: Vec<i64>,
    ends: Vec<i64>,
}

impl Cells {
    /// One cell per point.
    pub(super) fn each(points: usize) -> Self {
        Cells { points: (0..points as i64).collect(), ends: (1..=points as i64).collect() }
    }

    /// Adds a cell of these points.
    pub(super) fn push(&mut self, points: impl Iterator<Item = usize>) {
        self.points.extend(points.map(|point| point as i64));
        self.ends.push(self.points.len() as i64);
    }
}

/// The contents of a `.vtp` file.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct PolyData {
    /// Three coordinates per point.
    pub(super) points: Vec<f64>,
    pub(super) vertices: Cells,
    pub(super) lines: Cells,
    pub(super) polygons: Cells,
    /// One row per point; an array of the name [`NORMALS`] is that of the surface.
    pub(super) point_data: Vec<Array>,
    /// One row per cell, those of `vertices` first.
    pub(super) cell_data: Vec<Array>,
    /// The time.
    pub(super) time: f64,
}

impl PolyData {
    /// The file's bytes.
    pub(super) fn into_bytes(self) -> Vec<u8> {
        let mut file = File::default();
        let [points, vertices, lines] = [self.points.len() / 3, self.vertices.ends.len(), self.lines.ends.len()];
        let polygons = self.polygons.ends.len();
        file.line("<?xml version=\"1.0\"?>");
        file.line("<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">");
        file.line("<PolyData>\n<FieldData>");
        file.array(&Array::new("TimeValue", 1, Numbers::F64(vec![self.time])), Some(1));
        file.line("</FieldData>");
        file.line(&format!(
            "<Piece NumberOfPoints=\"{points}\" NumberOfVerts=\"{vertices}\" NumberOfLines=\"{lines}\" NumberOfStrips=\"0\" NumberOfPolys=\"{polygons}\">"
        ));
        file.section("PointData", self.point_data);
        file.section("CellData", self.cell_data);
        file.section("Points", vec![Array::new("Points", 3, Numbers::F64(self.points))]);
        let cells = [("Verts", self.vertices), ("Lines", self.lines), ("Polys", self.polygons)];
        for (name, cells) in cells.into_iter().filter(|(name, _)| *name != "Polys" || polygons > 0) {
            let points = Array::new("connectivity", 1, Numbers::I64(cells.points));
            file.section(name, vec![points, Array::new("offsets", 1, Numbers::I64(cells.ends))]);
        }
        file.line("</Piece>\n</PolyData>");
        file.into_bytes()
    }
}

/// The contents of a `.vti` file: numbers in the cells of a grid.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ImageData {
    /// The numbers of cells along the axes.
    pub(super) cells: [u32; 3],
    /// The edge of a cell.
    pub(super) spacing: f64,
    /// The corner of the grid with the least coordinates.
    pub(super) origin: [f64; 3],
    /// One row per cell, x fastest.
    pub(super) cell_data: Vec<Array>,
    /// The time.
    pub(super) time: f64,
}

impl ImageData {
    /// The file's bytes.
    pub(super) fn into_bytes(self) -> Vec<u8> {
        let mut file = File::default();
        let ([nx, ny, nz], [x, y, z], h) = (self.cells, self.origin, self.spacing);
        file.line("<?xml version=\"1.0\"?>");
        file.line("<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">");
        let extent = format!("0 {nx} 0 {ny} 0 {nz}");
        file.line(&format!(
            "<ImageData WholeExtent=\"{extent}\" Origin=\"{x:?} {y:?} {z:?}\" Spacing=\"{h:?} {h:?} {h:?}\">\n<FieldData>"
        ));
        file.array(&Array::new("TimeValue", 1, Numbers::F64(vec![self.time])), Some(1));
        file.line(&format!("</FieldData>\n<Piece Extent=\"{extent}\">"));
        file.section("CellData", self.cell_data);
        file.line("</Piece>\n</ImageData>");
        file.into_bytes()
    }
}

#[derive(Default)]
struct File {
    text: String,
    data: Vec<u8>,
}

impl File {
    /// The bytes of a file whose text is all there.
    fn into_bytes(mut self) -> Vec<u8> {
        self.line("<AppendedData encoding=\"raw\">");
        let mut bytes = self.text.into_bytes();
        bytes.push(b'_');
        bytes.extend(self.data);
        bytes.extend_from_slice(b"\n</AppendedData>\n</VTKFile>\n");
        bytes
    }

    fn line(&mut self, line: &str) {
        self.text.push_str(line);
        self.text.push('\n');
    }

    fn section(&mut self, name: &str, arrays: Vec<Array>) {
        let normals = if arrays.iter().any(|array| array.name == NORMALS) { " Normals=\"Normals\"" } else { "" };
        self.line(&format!("<{name}{normals}>"));
        arrays.iter().for_each(|array| self.array(array, None));
        self.line(&format!("</{name}>"));
    }

    fn array(&mut self, array: &Array, rows: Option<usize>) {
        let (name, columns) = (array.name, array.columns);
        let rows = rows.map_or(String::new(), |rows| format!(" NumberOfTuples=\"{rows}\""));
        let offset = self.data.len();
        let kind = self.numbers(&array.numbers);
        // Writing to a string does not fail.
        let _ = writeln!(
            self.text,
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{columns}\"{rows} format=\"appended\" offset=\"{offset}\"/>"
        );
    }

    /// Adds an array's data, and returns its type.
    fn numbers(&mut self, numbers: &Numbers) -> &'static str {
        match numbers {
            Numbers::F64(v) => self.data("Float64", v, |x| x.to_le_bytes()),
            Numbers::F32(v) => self.data("Float32", v, |x| x.to_le_bytes()),
            Numbers::I64(v) => self.data("Int64", v, |x| x.to_le_bytes()),
            Numbers::I32(v) => self.data("Int32", v, |x| x.to_le_bytes()),
            Numbers::U32(v) => self.data("UInt32", v, |x| x.to_le_bytes()),
            Numbers::U8(v) => self.data("UInt8", v, |x| [x]),
        }
    }

    fn data<T: Copy, const N: usize>(
        &mut self,
        kind: &'static str,
        values: &[T],
        bytes: fn(T) -> [u8; N],
    ) -> &'static str {
        self.data.extend_from_slice(&((values.len() * N) as u64).to_le_bytes());
        self.data.reserve(values.len() * N);
        values.iter().for_each(|value| self.data.extend_from_slice(&bytes(*value)));
        kind
    }
}
