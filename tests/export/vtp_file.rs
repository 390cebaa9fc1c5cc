//! A small reader of VTK's XML files with raw appended data, and of collections.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A file's arrays, by section and name, as 64-bit floats (all numbers of these tests fit them), and the bodies'
/// counts.
pub struct Vtp {
    pub counts: BTreeMap<String, usize>,
    arrays: BTreeMap<(String, String), (usize, Vec<f64>)>,
}

fn attribute<'a>(tag: &'a str, name: &str) -> Option<&'a str> {
    let (_, rest) = tag.split_once(&format!(" {name}=\""))?;
    rest.split_once('"').map(|(value, _)| value)
}

impl Vtp {
    pub fn read(path: &Path) -> Vtp {
        let bytes = std::fs::read(path).unwrap();
        let mark = b"<AppendedData encoding=\"raw\">\n_";
        let at = bytes.windows(mark.len()).position(|window| window == mark).unwrap() + mark.len();
        let text = std::str::from_utf8(&bytes[..at]).unwrap();
        assert!(text.contains("Data\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\""));
        assert!(bytes.ends_with(b"\n</AppendedData>\n</VTKFile>\n"));
        let mut vtp = Vtp { counts: BTreeMap::new(), arrays: BTreeMap::new() };
        let (mut section, mut end) = (String::new(), 0);
        for line in text.lines() {
            if line.starts_with("<DataArray") {
                let [kind, name, columns, offset] =
                    ["type", "Name", "NumberOfComponents", "offset"].map(|name| attribute(line, name).unwrap());
                let offset: usize = offset.parse().unwrap();
                assert_eq!(offset, end, "arrays follow each other");
                let data = &bytes[at + offset..];
                let size = u64::from_le_bytes(data[..8].try_into().unwrap()) as usize;
                end += 8 + size;
                let numbers = numbers(kind, &data[8..8 + size]);
                vtp.arrays.insert((section.clone(), name.into()), (columns.parse().unwrap(), numbers));
            } else if line.starts_with("<Piece NumberOfPoints") {
                let count = |name: &str| (name.to_owned(), attribute(line, name).unwrap().parse().unwrap());
                vtp.counts = ["NumberOfPoints", "NumberOfVerts", "NumberOfLines", "NumberOfPolys"].map(count).into();
            } else {
                section = line.trim_matches(['<', '>', '/']).split(' ').next().unwrap().into();
            }
        }
        assert_eq!(bytes.len(), at + end + b"\n</AppendedData>\n</VTKFile>\n".len());
        vtp
    }

    pub fn points(&self) -> usize {
        self.counts["NumberOfPoints"]
    }

    /// An array in `section`, a row at a time.
    pub fn rows(&self, section: &str, name: &str) -> Vec<Vec<f64>> {
        let (columns, numbers) = &self.arrays[&(section.to_owned(), name.to_owned())];
        numbers.chunks_exact(*columns).map(<[f64]>::to_vec).collect()
    }

    /// An array of the points with a number a row.
    pub fn column(&self, name: &str) -> Vec<f64> {
        let rows = self.rows("PointData", name);
        assert_eq!(rows.len(), self.points());
        rows.concat()
    }

    /// The points of each cell.
    pub fn cells(&self, section: &str) -> Vec<Vec<usize>> {
        let [points, ends] = ["connectivity", "offsets"].map(|name| self.rows(section, name).concat());
        let mut from = 0;
        let cell = |end: &f64| {
            let cell = points[from..*end as usize].iter().map(|point| *point as usize).collect();
            from = *end as usize;
            cell
        };
        ends.iter().map(cell).collect()
    }

    pub fn time(&self) -> f64 {
        self.rows("FieldData", "TimeValue")[0][0]
    }
}

fn numbers(kind: &str, bytes: &[u8]) -> Vec<f64> {
    match kind {
        "Float64" => bytes.chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect(),
        "Float32" => bytes.chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().unwrap()).into()).collect(),
        "Int64" => bytes.chunks_exact(8).map(|b| i64::from_le_bytes(b.try_into().unwrap()) as f64).collect(),
        "Int32" => bytes.chunks_exact(4).map(|b| i32::from_le_bytes(b.try_into().unwrap()).into()).collect(),
        "UInt32" => bytes.chunks_exact(4).map(|b| u32::from_le_bytes(b.try_into().unwrap()).into()).collect(),
        "UInt8" => bytes.iter().map(|b| f64::from(*b)).collect(),
        kind => panic!("{kind}"),
    }
}

/// The times and files of a collection.
pub fn collection(path: &Path) -> Vec<(f64, PathBuf)> {
    let text = std::fs::read_to_string(path).unwrap();
    let sets = text.lines().filter(|line| line.starts_with("<DataSet"));
    let set = |line: &str| {
        let [time, file] = ["timestep", "file"].map(|name| attribute(line, name).unwrap());
        (time.parse().unwrap(), path.parent().unwrap().join(file))
    };
    sets.map(set).collect()
}
