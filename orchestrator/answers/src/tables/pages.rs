//! Check of the page headers of a Parquet file before any page is decoded.
//!
//! Polars allocates memory by the lengths in these headers. In a damaged header a length may be any number, up to 2^61 bytes, and a failed
//! allocation ends the program. Therefore every header is compared with the footer and with the length of the file.

use super::TableError;
use bladeoff_system::files::FileError;
use bladeoff_system::guarded::guarded;
use polars_parquet::read::{ColumnChunkMetadata, read_metadata};
use polars_parquet_format::PageHeader;
use polars_parquet_format::thrift::protocol::TCompactInputProtocol;
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

/// Longest header \[bytes\]: statistics of a text may be long.
const MOST_HEADER: usize = 1 << 20;
/// Bytes read at a time: a header has about a hundred.
const BUFFER: usize = 1 << 10;

/// Checks the headers of all pages.
///
/// # Errors
/// [`TableError::Damaged`]; the file cannot be read.
pub(super) fn check(path: &Path, mut file: File) -> Result<(), TableError> {
    let damaged = || TableError::Damaged { path: path.to_path_buf() };
    let length = file.metadata().map_err(FileError::at("read", path))?.len();
    let metadata = guarded(|| read_metadata(&mut file).ok()).flatten().ok_or_else(damaged)?;
    let mut reader = BufReader::with_capacity(BUFFER, file);
    for group in &metadata.row_groups {
        for column in group.parquet_columns() {
            let is_of_rows = usize::try_from(column.num_values()) == Ok(group.num_rows());
            let mut is_sound = || guarded(|| are_sound(column, &mut reader, length)).flatten().is_some();
            if !is_of_rows || !is_sound() {
                return Err(damaged());
            }
        }
    }
    Ok(())
}

/// `Some` if the pages of a column contain as many values as the column, within the bytes given by the footer.
fn are_sound(column: &ColumnChunkMetadata, file: &mut BufReader<File>, length: u64) -> Option<()> {
    let range = column.byte_range();
    if range.start > range.end || range.end > length {
        return None;
    }
    file.seek(SeekFrom::Start(range.start)).ok()?;
    let (mut at, mut left) = (range.start, column.num_values());
    while left > 0 {
        let rest = range.end.checked_sub(at)?;
        let mut pages = file.by_ref().take(rest);
        let header =
            PageHeader::read_from_in_protocol(&mut TCompactInputProtocol::new(&mut pages, MOST_HEADER)).ok()?;
        at += rest - pages.limit();
        let count = match (header.dictionary_page_header, header.data_page_header, header.data_page_header_v2) {
            (Some(dictionary), None, None) => {
                (0..=column.num_values()).contains(&dictionary.num_values.into()).then_some(0)?
            }
            (None, Some(page), None) => i64::from(page.num_values),
            (None, None, Some(page)) => i64::from(page.num_values),
            _ => return None,
        };
        let is_bounded = (0..=left).contains(&count)
            && header.uncompressed_page_size >= 0
            && i64::from(header.uncompressed_page_size) <= column.uncompressed_size();
        if !is_bounded {
            return None;
        }
        left -= count;
        at = at.checked_add(u64::try_from(header.compressed_page_size).ok()?).filter(|at| *at <= range.end)?;
        file.seek_relative(header.compressed_page_size.into()).ok()?;
    }
    Some(())
}
