"""Results: tables, answers, histories, the state of a study."""

from __future__ import annotations

import json
import os
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Union, overload

from ._program import PathLike, call, call_json

if TYPE_CHECKING:
    import pandas
    import polars
    import pyarrow

    Frame = Union["polars.DataFrame", "pandas.DataFrame"]

Library = Literal["polars", "pandas"]


@dataclass(frozen=True)
class Column:
    """Unit and meaning of a column; ``unit`` is empty for words, counts and pure numbers."""

    unit: str
    meaning: str


@dataclass(frozen=True)
class Result:
    """The result directory of a study, and the exit code of its last run."""

    directory: Path
    exit_code: int = 0

    def __fspath__(self) -> str:
        return os.fspath(self.directory)

    @overload
    def read(self, library: Literal["polars"] = "polars") -> "polars.DataFrame": ...

    @overload
    def read(self, library: Literal["pandas"]) -> "pandas.DataFrame": ...

    def read(self, library: Library = "polars") -> "Frame":
        """As :func:`read`."""
        return read(self, library)

    def answers(self) -> dict[str, Any]:
        """As :func:`answers`."""
        return answers(self)

    @overload
    def history(self, sample: int, library: Literal["polars"] = "polars") -> "polars.DataFrame": ...

    @overload
    def history(self, sample: int, library: Literal["pandas"]) -> "pandas.DataFrame": ...

    def history(self, sample: int, library: Library = "polars") -> "Frame":
        """As :func:`history`."""
        return history(self, sample, library)

    def status(self) -> dict[str, Any]:
        """As :func:`status`."""
        return status(self)


@overload
def read(directory: PathLike, library: Literal["polars"] = "polars") -> "polars.DataFrame": ...


@overload
def read(directory: PathLike, library: Literal["pandas"]) -> "pandas.DataFrame": ...


def read(directory: PathLike, library: Library = "polars") -> "Frame":
    """Returns the rows of a study, also of one in progress, sorted by sample.

    Names of columns end in their unit (``max_bearing_load_N``). :func:`columns` has the units and meanings. A pandas frame has
    them in ``attrs["units"]`` as well.
    """
    return _frame(_table(directory), library, sort="sample")


def columns(directory: PathLike) -> dict[str, Column]:
    """Unit and meaning of each column of a study."""
    return _columns(_table(directory, rows=False).schema)


def answers(directory: PathLike) -> dict[str, Any]:
    """Answers to the questions of a study, with the layout of ``answers.json``."""
    return call_json("answer", directory)


def status(directory: PathLike) -> dict[str, Any]:
    """Progress and state of a study."""
    return call_json("status", directory)


@overload
def history(directory: PathLike, sample: int, library: Literal["polars"] = "polars") -> "polars.DataFrame": ...


@overload
def history(directory: PathLike, sample: int, library: Literal["pandas"]) -> "pandas.DataFrame": ...


def history(directory: PathLike, sample: int, library: Library = "polars") -> "Frame":
    """Computes a sample of a study again and returns its time history, one row per recorded instant."""
    from pyarrow import parquet

    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "history.parquet")
        call("replay", directory, "--sample", str(sample), "--history", file, allowed=(0,))
        return _frame(parquet.read_table(file), library)


def _table(directory: PathLike, rows: bool = True) -> "pyarrow.Table":
    import pyarrow
    from pyarrow import parquet

    folder = Path(directory)
    files = [folder / "results.parquet"]
    if not files[0].exists():
        files = sorted(folder.glob("parts/part-*.parquet"))
    if not files:
        raise FileNotFoundError(f"{folder} has no table: neither results.parquet nor finished rows in parts/")
    if not rows:
        return parquet.read_schema(files[0]).empty_table()
    return pyarrow.concat_tables([parquet.read_table(file) for file in files])


def _columns(schema: "pyarrow.Schema") -> dict[str, Column]:
    def text(metadata: Any, key: bytes) -> str:
        return str((metadata or {}).get(key, b""), "utf-8")

    return {field.name: Column(text(field.metadata, b"unit"), text(field.metadata, b"description")) for field in schema}


def _frame(table: "pyarrow.Table", library: Library, sort: str = "") -> "Frame":
    if sort:
        table = table.sort_by(sort)
    if library == "polars":
        import polars

        frame = polars.from_arrow(table)
        assert isinstance(frame, polars.DataFrame)
        return frame
    if library == "pandas":
        found = table.to_pandas()
        found.attrs["units"] = {name: column.unit for name, column in _columns(table.schema).items()}
        return found
    raise ValueError(f"library is {library!r}; allowed: 'polars', 'pandas'")
