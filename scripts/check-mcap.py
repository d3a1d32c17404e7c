#!/usr/bin/env python3
"""Reads a history with Python's mcap package, which knows nothing of bladeoff, and compares it with the CSV of the same run.

    python3 -m venv venv && venv/bin/pip install mcap mcap-protobuf-support
    bladeoff simulate studies/machines/lab_rig.toml --history run.mcap
    bladeoff simulate studies/machines/lab_rig.toml --history run.csv
    venv/bin/python scripts/check-mcap.py run.mcap run.csv

Checked: every message decodes by the schema in the file; every channel of the CSV is there with its unit, at every instant,
with the same value bit for bit; log time is simulated time, rounded to ns, and never falls; the index counts every message;
chunks are compressed; the metadata names the machine, the units and the outcome. Ends with 1 at the first difference.
"""

import csv
import sys

from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory


def fail(text):
    sys.exit(f"check-mcap: {text}")


def columns_of_csv(path):
    with open(path, newline="") as file:
        rows = csv.reader(file)
        names = next(rows)
        columns = [[] for _ in names]
        for row in rows:
            for column, cell in zip(columns, row):
                column.append(float(cell))
    return dict(zip(names, columns))


def main(mcap_path, csv_path):
    expected = columns_of_csv(csv_path)
    times = expected.pop("time_s")
    found, log_times, counts = {}, {}, {}
    with open(mcap_path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        summary = reader.get_summary()
        metadata = {record.name: record.metadata for record in reader.iter_metadata()}
        for schema, channel, message, decoded in reader.iter_decoded_messages():
            group = channel.metadata["bladeoff.group"]
            log_times.setdefault(group, []).append(message.log_time)
            counts[channel.id] = counts.get(channel.id, 0) + 1
            for field in decoded.DESCRIPTOR.fields:
                found.setdefault(f"{group}.{field.name}", []).append(getattr(decoded, field.name))
                unit = channel.metadata[f"unit.{field.name}"]
                if metadata["units"][f"{group}.{field.name}"] != unit:
                    fail(f"two units of {group}.{field.name}")

    if set(found) != set(expected):
        fail(f"channels differ: {sorted(set(found) ^ set(expected))}")
    for name, values in expected.items():
        if found[name] != values:
            at = next(k for k, pair in enumerate(zip(found[name], values)) if pair[0] != pair[1])
            fail(f"{name} at {times[at]} s: {found[name][at]!r} in the MCAP, {values[at]!r} in the CSV")
    for group, logged in log_times.items():
        if logged != sorted(logged):
            fail(f"log times of {group} fall")
        if any(abs(ns - time * 1e9) > 0.500001 for ns, time in zip(logged, times)):
            fail(f"log times of {group} are not the simulated times")
    if counts != dict(summary.statistics.channel_message_counts):
        fail(f"{counts} messages, the index counts {summary.statistics.channel_message_counts}")
    if not summary.chunk_indexes or any(chunk.compression != "zstd" for chunk in summary.chunk_indexes):
        fail("not every chunk is compressed with zstd")
    for name, key in [("bladeoff", "machine"), ("bladeoff", "step_s"), ("outcome", "status")]:
        if key not in metadata.get(name, {}):
            fail(f"no {key} in the metadata {name}")
    print(
        f"{mcap_path}: {sum(counts.values())} messages of {len(counts)} topics in {len(summary.chunk_indexes)} chunks, "
        f"{len(found)} channels at {len(times)} instants, equal to {csv_path}"
    )


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(sys.argv[1], sys.argv[2])
