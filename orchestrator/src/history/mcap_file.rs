//! MCAP: one topic per group of channels, protobuf messages, simulated time as log time.

use super::channels::Channel;
use super::staging::StagedFile;
use super::{HistoryError, Sink, proto};
use bladeoff_answers::history::About;
use bladeoff_system::files::FileError;
use mcap::records::{MessageHeader, Metadata};
use mcap::{Compression, WriteOptions, Writer};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Uncompressed bytes of a chunk: few, because a killed writer loses the contents of its unfinished chunk.
const CHUNK: u64 = 64 << 10;
/// Names of the metadata records about the run, the units, and the outcome.
pub(super) const ABOUT: &str = "bladeoff";
pub(super) const UNITS: &str = "units";
pub(super) const OUTCOME: &str = "outcome";
/// Key in a channel's metadata that names its group.
pub(super) const GROUP: &str = "bladeoff.group";

/// Writes `FILE.mcap.tmp`, which is renamed to `FILE.mcap` when it is complete.
pub(super) struct McapSink {
    path: PathBuf,
    writer: Writer<BufWriter<File>>,
    topics: Vec<(u16, Range<usize>)>,
    sequence: u32,
    message: Vec<u8>,
    /// Dropped after the writer, because dropping the writer writes.
    staged: StagedFile,
}

pub(super) fn options() -> WriteOptions {
    WriteOptions::new()
        .compression(Some(Compression::Zstd))
        .chunk_size(Some(CHUNK))
        .library(concat!("bladeoff ", env!("CARGO_PKG_VERSION")))
}

impl McapSink {
    pub fn create(path: &Path, channels: &[Channel], about: &About) -> Result<Self, HistoryError> {
        let (file, staged) = StagedFile::create(path)?;
        let failed = || HistoryError::mcap("write", path);
        let mut writer = options().create(BufWriter::new(file)).map_err(failed())?;
        writer.write_metadata(&Metadata { name: ABOUT.to_owned(), metadata: about.clone() }).map_err(failed())?;
        let units = channels.iter().map(|channel| (channel.name(), channel.unit.to_owned())).collect();
        writer.write_metadata(&Metadata { name: UNITS.to_owned(), metadata: units }).map_err(failed())?;
        let mut topics = Vec::new();
        let mut from = 0;
        while from < channels.len() {
            let group = &channels[from].group;
            let to = from + channels[from..].iter().take_while(|channel| channel.group == *group).count();
            let fields: Vec<String> = channels[from..to].iter().map(|channel| channel.field.clone()).collect();
            let kind = group.split('.').map(capital).collect::<String>();
            let descriptor = proto::descriptor(&kind, &fields);
            let name = format!("{}.{kind}", proto::PACKAGE);
            let schema = writer.add_schema(&name, "protobuf", &descriptor).map_err(failed())?;
            let mut metadata: BTreeMap<String, String> = BTreeMap::from([(GROUP.to_owned(), group.clone())]);
            for channel in &channels[from..to] {
                metadata.insert(format!("unit.{}", channel.field), channel.unit.to_owned());
                metadata.insert(format!("meaning.{}", channel.field), channel.meaning.clone());
            }
            let topic = format!("/{}", group.replace('.', "/"));
            topics.push((writer.add_channel(schema, &topic, "protobuf", &metadata).map_err(failed())?, from..to));
            from = to;
        }
        Ok(Self { path: path.to_path_buf(), writer, topics, sequence: 0, message: Vec::new(), staged })
    }
}

fn capital(word: &str) -> String {
    let mut letters = word.chars();
    letters.next().map(|first| first.to_ascii_uppercase().to_string() + letters.as_str()).unwrap_or_default()
}

/// Simulated time in nanoseconds.
fn nanoseconds(time: f64) -> u64 {
    (time * 1e9).round() as u64
}

impl Sink for McapSink {
    fn record(&mut self, time: f64, values: &[f64]) -> Result<(), HistoryError> {
        let time = nanoseconds(time);
        for (topic, range) in &self.topics {
            self.message.clear();
            proto::message(&values[range.clone()], &mut self.message);
            let header =
                MessageHeader { channel_id: *topic, sequence: self.sequence, log_time: time, publish_time: time };
            self.writer
                .write_to_known_channel(&header, &self.message)
                .map_err(HistoryError::mcap("write", &self.path))?;
        }
        self.sequence = self.sequence.wrapping_add(1);
        Ok(())
    }

    fn finish(mut self: Box<Self>, outcome: &About) -> Result<(), HistoryError> {
        let failed = || HistoryError::mcap("write", &self.path);
        let outcome = Metadata { name: OUTCOME.to_owned(), metadata: outcome.clone() };
        self.writer.write_metadata(&outcome).map_err(failed())?;
        self.writer.finish().map_err(failed())?;
        let file = self
            .writer
            .into_inner()
            .into_inner()
            .map_err(|error| FileError::at("write", &self.path)(error.into_error()))?;
        Ok(self.staged.publish(file)?)
    }

    fn temporary(&self) -> Option<&Path> {
        Some(self.staged.temporary())
    }
}
