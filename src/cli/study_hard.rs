//! `relcp study hard`: numerical stability on hard cases.

use super::arguments::{Study as Arguments, StudyName};
use super::exit::CliError;
use super::study::{Found, pretty, value, write_all};
use super::study_paper::{on_the_cpu, say};
use crate::study::hard::{Size, Study, all};
use crate::study::paper::COMPUTED_BY;
use serde_json::{Value, json};

pub(super) fn hard(arguments: &Arguments) -> Result<Found, CliError> {
    if arguments.name != StudyName::All {
        on_the_cpu(arguments)?;
    }
    let size = if arguments.quick { Size::QUICK } else { Size::FULL };
    let mut study = Study::begin(size);
    let mut found = written(&study, arguments)?;
    for case in all() {
        study.run(&case);
        if let Some(row) = study.rows().last() {
            say(arguments, &format!("{}: {}", row.case, row.verdict.name().trim_matches('*')));
        }
        // After each, so that what was run stays when the study is interrupted.
        found = written(&study, arguments)?;
    }
    let (text, numbers) = found;
    Ok(Found { text, numbers, missed: study.missed() })
}

fn written(study: &Study, arguments: &Arguments) -> Result<(String, Value), CliError> {
    let text = study.page();
    let numbers = json!({
        "computed_by": COMPUTED_BY,
        "size": value(&study.size())?,
        "rows": value(&study.rows())?,
    });
    let (json, table) = (pretty(&numbers)?, study.csv()?);
    let files: [(&str, &[u8]); 3] = [("hard.md", text.as_bytes()), ("hard.json", &json), ("hard.csv", &table)];
    write_all(&arguments.out, files)?;
    Ok((text, numbers))
}
