//! The tables of a run's folder, read column by column, also while the run writes them: a row that is not whole yet is
//! left out.

use super::error::RecordError;
use super::steps::TYPES;
use std::fs::File;
use std::path::Path;

/// The columns of `measures.csv` that are whole numbers.
const COUNTS: [&str; 2] = ["step", "bodies"];
/// The columns of `lineage.csv` that are whole numbers in each row.
const IDENTITIES: [&str; 3] = ["step", "id", "generation"];
/// Its columns of text.
const WORDS: [&str; 2] = ["group", "cause"];

/// The values of a column.
#[derive(Clone, Debug, PartialEq)]
pub enum TableColumn {
    /// Whole numbers, in each row.
    Integers(Vec<i64>),
    /// Numbers; NaN where a row has none.
    Numbers(Vec<f64>),
    /// Text; empty where a row has none.
    Words(Vec<String>),
}

/// A table: its columns by name, in their order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// The columns, all of one length.
    pub columns: Vec<(String, TableColumn)>,
}

impl TableColumn {
    fn empty(name: &str, kind: Kind) -> TableColumn {
        match kind(name) {
            Of::Integers => TableColumn::Integers(Vec::new()),
            Of::Numbers => TableColumn::Numbers(Vec::new()),
            Of::Words => TableColumn::Words(Vec::new()),
        }
    }

    /// Adds a cell; or says what it is not.
    fn push(&mut self, cell: &str) -> Result<(), &'static str> {
        match self {
            TableColumn::Integers(values) => values.push(cell.parse().map_err(|_| "a whole number")?),
            TableColumn::Numbers(values) if cell.is_empty() => values.push(f64::NAN),
            TableColumn::Numbers(values) => values.push(cell.parse().map_err(|_| "a number")?),
            TableColumn::Words(values) => values.push(cell.into()),
        }
        Ok(())
    }
}

/// What a column holds.
enum Of {
    Integers,
    Numbers,
    Words,
}

/// What the column of a name holds.
type Kind = fn(&str) -> Of;

impl Table {
    /// Reads `steps.csv`. Columns that files of earlier versions lack are absent.
    ///
    /// ```
    /// use relcp::record::{Table, TableColumn};
    /// let folder = tempfile::tempdir()?;
    /// let path = folder.path().join("steps.csv");
    /// std::fs::write(&path, "step,time,bodies\n1,0.5,2\n2,1.0,2\n3,1.")?;
    /// let table = Table::steps(&path)?;
    /// assert_eq!(table.column("time"), Some(&TableColumn::Numbers(vec![0.5, 1.0])));
    /// # Ok::<(), relcp::Error>(())
    /// ```
    ///
    /// # Errors
    /// A file that cannot be read; [`RecordError::Mangled`] with the line and the column of a cell that is no number.
    pub fn steps(path: &Path) -> Result<Table, RecordError> {
        read(path, |name| match TYPES.iter().find(|(own, _)| *own == name) {
            Some((_, "u32" | "u64" | "usize")) => Of::Integers,
            _ => Of::Numbers,
        })
    }

    /// Reads `measures.csv`: a value that is not defined is NaN.
    ///
    /// # Errors
    /// As [`Table::steps`].
    pub fn measures(path: &Path) -> Result<Table, RecordError> {
        read(path, |name| if COUNTS.contains(&name) { Of::Integers } else { Of::Numbers })
    }

    /// Reads `lineage.csv`: the parent of a founder, and the rule of a division, are NaN.
    ///
    /// # Errors
    /// As [`Table::steps`].
    pub fn lineage(path: &Path) -> Result<Table, RecordError> {
        read(path, |name| match name {
            name if IDENTITIES.contains(&name) => Of::Integers,
            name if WORDS.contains(&name) => Of::Words,
            _ => Of::Numbers,
        })
    }

    /// The column of a name.
    pub fn column(&self, name: &str) -> Option<&TableColumn> {
        self.columns.iter().find(|(own, _)| own == name).map(|(_, column)| column)
    }
}

fn read(path: &Path, kind: Kind) -> Result<Table, RecordError> {
    let mangled = |what: String| RecordError::Mangled { path: path.into(), what };
    let file = File::open(path).map_err(RecordError::io(path, "open it"))?;
    // A device may have no end.
    if !file.metadata().map_err(RecordError::io(path, "open it"))?.is_file() {
        return Err(mangled("it is not a file".into()));
    }
    let bytes = std::fs::read(path).map_err(RecordError::io(path, "read it"))?;
    // What follows the last end of a line is being written.
    let whole = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
    let mut reader = csv::ReaderBuilder::new().from_reader(&bytes[..whole]);
    let headings = reader.headers().map_err(|fault| mangled(fault.to_string()))?.clone();
    let mut columns: Vec<(String, TableColumn)> =
        headings.iter().map(|name| (name.to_owned(), TableColumn::empty(name, kind))).collect();
    let mut row = csv::StringRecord::new();
    while reader.read_record(&mut row).map_err(|fault| mangled(fault.to_string()))? {
        for ((name, column), cell) in columns.iter_mut().zip(&row) {
            column.push(cell).map_err(|expected| {
                let line = row.position().map_or(0, csv::Position::line);
                mangled(format!("line {line}: {name}: {cell:?} is not {expected}"))
            })?;
        }
    }
    Ok(Table { columns })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(text: &str) -> (tempfile::TempDir, std::path::PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.csv");
        std::fs::write(&path, text).unwrap();
        (folder, path)
    }

    #[test]
    fn missing_cells_are_nan_and_rows_that_are_being_written_are_left_out() {
        let text = "step,time,id,parent,birth,generation,group,cause,rule\n\
                    7,0.25,3,,0.0,0,\"a,b\",division,\n9,0.5,18014398509481985,3,0.25,1,,rate,0\n10,0.";
        let (_folder, path) = written(text);
        let table = Table::lineage(&path).unwrap();
        assert_eq!(table.column("step"), Some(&TableColumn::Integers(vec![7, 9])));
        assert_eq!(table.column("id"), Some(&TableColumn::Integers(vec![3, 18_014_398_509_481_985])));
        assert_eq!(table.column("group"), Some(&TableColumn::Words(vec!["a,b".into(), String::new()])));
        let Some(TableColumn::Numbers(parent)) = table.column("parent") else { panic!("{table:?}") };
        assert!(parent[0].is_nan() && parent[1] == 3.0);
        assert_eq!(table.column("other"), None);
    }

    #[test]
    fn wrong_cells_are_told_by_line_and_column() {
        let (_folder, path) = written("step,time,bodies\n1,0.5,2\n2,soon,2\n");
        let fault = Table::measures(&path).unwrap_err().to_string();
        assert!(fault.contains("line 3: time: \"soon\" is not a number"), "{fault}");
        let (_folder, path) = written("step,time\n1,0.5,2\n");
        assert!(matches!(Table::steps(&path), Err(RecordError::Mangled { .. })));
        let (folder, _) = written("");
        assert!(matches!(Table::steps(folder.path()), Err(RecordError::Mangled { .. } | RecordError::Io { .. })));
        let (_folder, path) = written("");
        assert_eq!(Table::steps(&path).unwrap(), Table::default());
    }
}
