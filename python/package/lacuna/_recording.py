"""Recordings: what a machine's log holds."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _lacuna
from ._lacuna import LacunaError


class Recording:
    """One recording: measured channels and inputs against time.

    Parameters
    ----------
    data : path, pandas.DataFrame, polars.DataFrame, pyarrow.Table or mapping of arrays
        The columns. A path names a CSV file or a part of one (``run.csv#rows=100..4000``,
        ``run.csv#t=1.5..20``), which is read when it is used. Columns of a table that are not numbers are left
        out; NaN marks a missing sample.
    time : str, optional
        Column of time, in seconds; that of the model where it is not said.
    units : mapping of str to str, optional
        Units of columns that are not in the unit that the model says: ``{"q1": "deg"}``, ``{"t": "ms"}``.
    name : str, optional
        What results call it: the name of the file, or ``recording 1`` and so on.

    Raises
    ------
    LacunaError
        Data of another kind.
    """

    def __init__(
        self,
        data: Any,
        time: str | None = None,
        units: Mapping[str, str] | None = None,
        name: str | None = None,
    ) -> None:
        units = dict(units or {})
        self._path: str | None = None
        if isinstance(data, (str, os.PathLike)):
            self._path = os.fspath(data)
            self._own = _lacuna.Recording.of_file(self._path, time, units, name)
        else:
            columns = [(str(n), _as_floats(n, values)) for n, values in _columns_of(data)]
            self._own = _lacuna.Recording.of_columns(columns, time, units, name)

    @property
    def name(self) -> str | None:
        """What results call it; None where it has no name yet."""
        return self._own.name

    def __reduce__(self) -> tuple[Any, ...]:
        columns, time, units, name = self._own.parts()
        # A file is meant wherever it is unpickled, and stays where it is.
        data = os.path.abspath(self._path) if self._path is not None else dict(columns or ())
        return Recording, (data, time, units, name)

    def __repr__(self) -> str:
        if self._path is not None:
            return f"lacuna.Recording({self._path!r})"
        columns = ", ".join(self._own.columns or [])
        return f"<Recording {self.name or 'without a name'}: {columns}>"


def as_recordings(recordings: Any) -> list[Recording]:
    """All that may stand for recordings: one or several, each a `Recording` or what one is made of."""
    several = isinstance(recordings, Iterable) and not _is_one(recordings)
    each = list(recordings) if several else [recordings]
    return [r if isinstance(r, Recording) else Recording(r) for r in each]


def _is_one(data: Any) -> bool:
    return isinstance(data, (str, os.PathLike, Mapping, Recording)) or hasattr(data, "columns")


def _columns_of(data: Any) -> Iterator[tuple[Any, Any]]:
    """Names and values of the columns that are numbers."""
    if isinstance(data, Mapping):
        yield from data.items()
    elif hasattr(data, "iloc"):
        yield from _of_pandas(data)
    elif hasattr(data, "get_columns"):
        yield from ((s.name, s.to_numpy()) for s in data.get_columns() if s.dtype.is_numeric())
    elif hasattr(data, "column_names"):
        for name, column in zip(data.column_names, data.columns):
            values = column.to_numpy()
            if values.dtype.kind in "biuf":
                yield name, values
    else:
        raise LacunaError(
            "a recording is a path, a data frame (pandas, polars), a pyarrow table or a mapping of arrays by "
            f"name; found {type(data).__name__}"
        )


def _of_pandas(frame: Any) -> Iterator[tuple[Any, Any]]:
    for k, name in enumerate(frame.columns):
        column = frame.iloc[:, k]
        if isinstance(column.dtype, np.dtype):
            if column.dtype.kind in "biuf":
                yield name, column.to_numpy()
        elif getattr(column.dtype, "kind", "O") in "biuf":
            yield name, column.to_numpy(dtype=float, na_value=np.nan)


def _as_floats(name: Any, values: Any) -> npt.NDArray[np.float64]:
    try:
        # Aligned, as fields of packed records and what came through a network need not be.
        floats = np.require(values, np.float64, ["A", "E"])
    except (TypeError, ValueError) as error:
        raise LacunaError(f"column '{name}': expected numbers; {error}") from None
    if floats.ndim != 1:
        raise LacunaError(f"column '{name}': expected one value a row, found shape {floats.shape}")
    return floats
