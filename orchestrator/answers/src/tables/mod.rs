//! Tables of a study: schema, Parquet, reading, CSV. The only module that uses Polars.
//!
//! `results.parquet` contains nothing about time, host or worker: the same study gives the same bytes. Row groups are
//! cut by row number, never by arrival; the writer, its settings and their order are fixed here.

mod curve;
mod error;
mod export;
mod grouped;
mod heads;
mod pages;
mod parquet;
mod read;
mod schema;
mod series;
mod stream;
mod threads;
mod timings;

pub use curve::{QUESTION_KEY, write_curve};
pub use error::TableError;
pub use export::{CsvStyle, export_csv};
pub use heads::{ColumnHead, HeadKind, column_heads};
pub use parquet::{Provenance, ResultsWriter, Row};
pub use read::{Cells, Table, count_sound_rows};
pub use schema::{
    DETECTION, END_CAUSE, END_SPEED, END_TIME, ENGINE, Field, FieldKind, NOTES, SCHEMA_VERSION, TableSchema,
    verdict_fields,
};
pub use series::{NumberColumn, read_metadata, read_numbers, write_numbers};
pub use stream::Checksum;
pub use threads::start_threads;
pub use timings::{Timing, TimingsWriter};

/// Rows per row group. One group is in memory while a table is written: near 70 MB for the widest one (256 numbers a row).
const ROW_GROUP: usize = 16_384;
