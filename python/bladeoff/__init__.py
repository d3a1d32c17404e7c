"""Studies of blade-off transients: runs the program ``bladeoff`` and reads its results.

The module needs nothing but Python. ``read`` and ``history`` need ``pyarrow`` and a package for tables:
``pip install 'bladeoff[polars]'`` or ``'bladeoff[pandas]'``.

>>> import bladeoff
>>> result = bladeoff.run("studies/first-look.toml")
>>> table = result.read()
>>> bladeoff.columns(result)["max_bearing_load_N"].unit
'N'
"""

from ._program import BladeoffError, program
from ._results import Column, Result, answers, columns, history, read, status
from ._studies import run, simulate, studies

__all__ = [
    "BladeoffError",
    "Column",
    "Result",
    "answers",
    "columns",
    "history",
    "program",
    "read",
    "run",
    "simulate",
    "status",
    "studies",
]
