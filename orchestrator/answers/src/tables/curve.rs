//! Answer curves as Parquet: `answers/NAME.parquet`.

use super::{TableError, start_threads, stream};
use crate::estimate::curve::{Curve, CurveCells};
use bladeoff_system::files::Pending;
use polars::prelude::{
    Column, DataFrame, IntoColumn, KeyValueMetadata, NamedFrom, ParquetCompression, ParquetWriter, Series,
};

/// Metadata key with the name of the question of a curve.
pub const QUESTION_KEY: &str = "bladeoff.question";

/// Writes a curve durably; `question`: name of the question.
///
/// # Errors
/// The disk is full or not writable, or Polars reports an error.
pub fn write_curve(mut pending: Pending, curve: &Curve, question: &str) -> Result<(), TableError> {
    start_threads()?;
    let path = pending.path().to_path_buf();
    let failed = |source| TableError::Table { action: "write", path: path.clone(), source };
    let column = |(name, cells): &(String, CurveCells)| -> Column {
        match cells {
            CurveCells::Numbers(numbers) => Series::new(name.as_str().into(), numbers).into_column(),
            CurveCells::Words(words) => Series::new(name.as_str().into(), words).into_column(),
        }
    };
    let columns: Vec<Column> = curve.columns.iter().map(column).collect();
    let height = columns.first().map_or(0, Column::len);
    let mut frame = DataFrame::new(height, columns).map_err(failed)?;
    let (out, watch) = stream::open(&mut pending)?;
    ParquetWriter::new(out)
        .with_compression(ParquetCompression::Zstd(None))
        .with_key_value_metadata(Some(KeyValueMetadata::from_static(vec![(
            QUESTION_KEY.to_owned(),
            question.to_owned(),
        )])))
        .finish(&mut frame)
        .map_err(|error| watch.failed(error))?;
    Ok(pending.finish()?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::{read_metadata, read_numbers};

    #[test]
    fn a_curve_is_read_back_as_it_was() {
        let folder = tempfile::tempdir().expect("temporary directory");
        let path = folder.path().join("q.parquet");
        let numbers = CurveCells::Numbers(vec![Some(0.1), None, Some(3.0)]);
        let words = CurveCells::Words(vec![Some("hyp1".to_owned()), None, Some("hyp2".to_owned())]);
        let curve = Curve { columns: vec![("detection".to_owned(), words), ("level_N".to_owned(), numbers)] };
        write_curve(Pending::create(&path).expect("created"), &curve, "q").expect("written");
        let (columns, _) = read_numbers(&path).expect("readable");
        assert_eq!((columns.len(), columns[0].name.as_str()), (1, "level_N"), "words are no numbers");
        assert_eq!((columns[0].values[0], columns[0].values[2]), (0.1, 3.0));
        assert!(columns[0].values[1].is_nan());
        let metadata = read_metadata(&path).expect("readable");
        assert!(metadata.contains(&(QUESTION_KEY.to_owned(), "q".to_owned())), "{metadata:?}");
    }
}
