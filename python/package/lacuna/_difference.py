"""Two sets of recordings, one of a simulator, and no model."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from . import _lacuna
from ._page import framed
from ._recording import as_recordings


class Difference:
    """What the recordings of a machine and those of its simulator differ in.

    Shown in a notebook it is the page of the command, as text its summary.
    """

    def __init__(self, own: _lacuna.Difference) -> None:
        self._own = own

    @property
    def verdict(self) -> str:
        """``no_mismatch``, ``missing_physics``, ``not_separable`` or ``unexplained``."""
        return str(self.to_dict()["verdict"])

    @property
    def findings(self) -> list[dict[str, Any]]:
        """The laws that tell the difference: class, channel, parameters (value and standard deviation), rivals."""
        return list(self.to_dict()["findings"])

    def to_dict(self) -> dict[str, Any]:
        """What difference.json holds."""
        data: dict[str, Any] = json.loads(self._own.json())
        return data

    def report(self, path: str | os.PathLike[str]) -> None:
        """Write the page to a file."""
        Path(path).write_text(self._own.page(), encoding="utf-8")

    def save(self, folder: str | os.PathLike[str]) -> None:
        """Write difference.json and difference.html to a folder."""
        self._own.save(folder)

    def __repr__(self) -> str:
        return self._own.text()

    def _repr_html_(self) -> str:
        return framed(self._own.page(), "Two sets of recordings, compared")


def compare_runs(
    sim: Any,
    real: Any,
    *,
    channels: Sequence[str] = (),
    inputs: Sequence[str] = (),
    order: int | None = None,
    time: str = "t",
    input_hold: str = "zero-order",
) -> Difference:
    """Compare a machine with its simulator by recordings of both alone.

    Both are identified, and their forces and inertia (where the control effectiveness has an inverse that is a mass
    matrix; else drift and control effectiveness) compared with their uncertainty. Differences of forces are named by
    the laws of the catalogue that depend on the channel's own motion. Without a model calibration and physics cannot
    always be separated: a law that the simulator lacks and one that it has with another size look the same.

    Parameters
    ----------
    sim, real : Recording or list of Recording
        With the same columns in the same units, moving through the same range.
    channels : list of str, optional
        Columns of the coordinates; without, all but time and inputs.
    inputs : list of str, optional
        Columns of the inputs; without, those that are named like one (``u``, ``tau1``, ``force`` ...).
    order : {1, 2}, optional
        Order of the dynamics; without, 2, or 1 where every channel's velocity is a column too.
    time : str
        Column of time, where a recording does not say it.
    input_hold : {"zero-order", "linear", "smooth"}
        What inputs do between samples.

    Raises
    ------
    LacunaError
        Columns that are missing, recordings that cannot be identified, or that visit other states.
    """
    said = {
        "time": time,
        "channels": list(channels),
        "inputs": list(inputs),
        "order": order,
        "input_hold": input_hold,
    }
    sides = ([r._own for r in as_recordings(one)] for one in (sim, real))
    return Difference(_lacuna.compare_runs(*sides, said))
