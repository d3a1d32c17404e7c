"""Computing: a study, or one transient."""

from __future__ import annotations

import os
import sysconfig
import tomllib
from pathlib import Path
from typing import Any, Mapping, Optional, Union

from ._program import PathLike, call, call_json
from ._results import Result

Value = Union[str, int, float]


def run(
    study: PathLike,
    out: Optional[PathLike] = None,
    *,
    workers: Optional[int] = None,
    scale: Optional[float] = None,
    limit: Optional[int] = None,
    show: bool = False,
) -> Result:
    """Computes a study and returns its result; a finished or interrupted one is continued.

    ``out`` is the result directory, by default ``runs/NAME`` in the current directory. ``scale`` keeps this fraction of each axis,
    ``limit`` this number of samples. ``show`` prints the progress on standard error. ``Result.exit_code`` is 4 if more samples
    failed than the study allows. Raises BladeoffError for an invalid study and for failures of the system.
    """
    words: list[PathLike] = ["run", study]
    for option, value in (("--workers", workers), ("--scale", scale), ("--limit", limit)):
        if value is not None:
            words += [option, str(value)]
    directory = Path(out) if out is not None else Path("runs", _name(study))
    done = call(*words, "--out", directory, show=show)
    return Result(directory, done.returncode)


def _name(study: PathLike) -> str:
    """Name of a study, by which its default directory is called: its key ``name``, or the name of the file."""
    try:
        name = tomllib.loads(Path(study).read_text(encoding="utf-8")).get("name")
    except (OSError, ValueError):
        name = None  # the program reports what is wrong with the file
    return name if isinstance(name, str) else Path(study).stem


def simulate(machine: PathLike, set: Optional[Mapping[str, Value]] = None, **parameters: Value) -> dict[str, Any]:
    """Computes one transient and returns its columns: status, causes, and the quantities with their units in the names.

    ``set`` changes parameters by their paths: ``simulate("rig.toml", {"contact.gap": "0.5 mm"})``. As keywords, two underscores
    are the dot: ``simulate("rig.toml", contact__gap="0.5 mm")``. Numbers are SI. A run that failed is returned with its status.
    """
    changes = dict(set or {}) | {name.replace("__", "."): value for name, value in parameters.items()}
    words: list[PathLike] = ["simulate", machine]
    for path, value in changes.items():
        # a float of NumPy is a float, too, with another repr
        words += ["--set", f"{path}={float(value)!r}" if isinstance(value, float) else f"{path}={value}"]
    return call_json(*words)


def studies() -> Path:
    """Directory of the shipped studies and machines."""
    folder = Path(sysconfig.get_path("data"), "share", "bladeoff", "studies")
    source = Path(__file__).resolve().parents[2] / "studies"
    for found in (folder, source):
        if (found / "first-look.toml").is_file():
            return found
    raise FileNotFoundError(f"the shipped studies are not in {os.fspath(folder)}")
