//! Tables for programs.

use std::io::{self, Write};

use serde::Serialize;
use toml::Value;

/// A record of a table, with the names of its parts. Unlike JSON, it holds infinite numbers.
pub(super) type Record = Result<Value, toml::ser::Error>;

/// Makes a record of a structure.
pub(super) fn record(structure: &impl Serialize) -> Record {
    Value::try_from(structure)
}

/// Writes records as CSV. Each word of `columns` is a column: the path of its value in a record, as in `errors/rmse`,
/// behind `name=` unless the column has the path's own name, with `_` for `/`. A value that a record lacks is empty.
/// Without a record there is no head, either.
pub(super) fn csv(file: impl Write, columns: &str, records: impl IntoIterator<Item = Record>) -> io::Result<()> {
    let columns = || columns.split_whitespace().map(|column| column.split_once('=').unwrap_or((column, column)));
    let mut writer = csv::Writer::from_writer(file);
    for (index, record) in records.into_iter().enumerate() {
        if index == 0 {
            writer.write_record(columns().map(|(name, _)| name.replace('/', "_")))?;
        }
        let record = record.map_err(io::Error::other)?;
        let value = |(_, path): (_, &str)| {
            path.split('/').try_fold(&record, |value, part| match part.parse::<usize>() {
                Ok(index) => value.get(index),
                Err(_) => value.get(part),
            })
        };
        writer.serialize(columns().map(value).collect::<Vec<_>>()).map_err(io::Error::other)?;
    }
    writer.flush()
}
