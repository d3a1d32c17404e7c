"""The program: where it is, how it is called, its errors."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sysconfig
from pathlib import Path
from typing import Any, Sequence, Union

PathLike = Union[str, "os.PathLike[str]"]

#: Exit codes of commands that computed what was asked: done, limits exceeded, incomplete.
FINISHED = (0, 4, 5)


class BladeoffError(RuntimeError):
    """A command that failed, with the message of the program.

    ``exit_code`` has the meaning of the table in the documentation: 2 an invalid command line, 3 an invalid file, 6 a failure
    of the system, 130 an interruption. ``command`` is the command line.
    """

    def __init__(self, command: Sequence[str], exit_code: int, message: str) -> None:
        super().__init__(message.strip() or f"exit code {exit_code}")
        self.command = list(command)
        self.exit_code = exit_code


def program() -> str:
    """Path of the program: the variable ``BLADEOFF``, that of this installation, or the one in ``PATH``."""
    given = os.environ.get("BLADEOFF")
    if given:
        return given
    schemes = [sysconfig.get_default_scheme(), "posix_user"]
    for folder in (sysconfig.get_path("scripts", scheme) for scheme in schemes):
        path = Path(folder, "bladeoff")
        if os.access(path, os.X_OK):
            return str(path)
    found = shutil.which("bladeoff")
    if found is None:
        raise FileNotFoundError("the program `bladeoff` is neither beside this Python, nor in PATH; set BLADEOFF to its path")
    return found


def call(*words: PathLike, show: bool = False, allowed: Sequence[int] = FINISHED) -> subprocess.CompletedProcess[str]:
    """Runs a command to its end. ``show``: its messages appear on standard error while it runs."""
    command = [program(), *(os.fspath(word) for word in words)]
    messages = None if show else subprocess.PIPE
    running = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=messages, text=True)
    try:
        out, told = running.communicate()
    except BaseException:
        # Ctrl-C: a run ends in order, so that no finished sample is lost and no shared memory stays behind
        running.send_signal(signal.SIGINT)
        running.communicate()
        raise
    if running.returncode not in allowed:
        raise BladeoffError(command, running.returncode, told or "")
    return subprocess.CompletedProcess(command, running.returncode, out, told)


def call_json(*words: PathLike, allowed: Sequence[int] = FINISHED) -> dict[str, Any]:
    """The JSON object that a command prints."""
    found: dict[str, Any] = json.loads(call(*words, "--json", allowed=allowed).stdout)
    return found
