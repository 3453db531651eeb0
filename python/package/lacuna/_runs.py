"""Models run on recordings, compared and checked."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _lacuna
from ._model import Model, as_model
from ._page import framed
from ._recording import as_recordings

#: Samples that estimate the initial state of a free run.
WARMUP = 50


@dataclass(frozen=True, repr=False)
class Simulation:
    """A model's run on a recording.

    Attributes
    ----------
    series : dict of str to ndarray
        The simulated channels by name, time among them.
    channels : dict of str to dict
        Of every measured channel its unit, ``rmse``, ``nrmse`` and ``fit_percent``.
    """

    series: dict[str, npt.NDArray[np.float64]]
    channels: dict[str, dict[str, Any]]
    _said: dict[str, Any] = field(compare=False)
    _text: str = field(compare=False)

    def to_dict(self) -> dict[str, Any]:
        """What ``lacuna simulate --json`` prints."""
        return self._said

    def __repr__(self) -> str:
        return self._text


def simulate(
    model: Model | str | os.PathLike[str],
    recording: Any,
    horizon: float | None = None,
    warmup: int = WARMUP,
) -> Simulation:
    """Run a model on a recording's inputs.

    Parameters
    ----------
    model : Model or path
        The model, of equations or identified.
    recording : Recording, or what one is made of
        Whose inputs drive it.
    horizon : float, optional
        Restart every so many seconds from the state that fits the window best; without it the model runs free
        from the first samples to the end.
    warmup : int
        Samples that estimate the initial state of a free run and do not count for its error.

    Raises
    ------
    LacunaError
        What is wrong with the recording, or a model that diverges on it.
    """
    (like,) = as_recordings(recording)
    said, text, series = _lacuna.simulate(as_model(model)._for([like]), like._own, horizon, warmup)
    data = json.loads(said)
    return Simulation(dict(series), data["channels"], data, text)


class Comparison:
    """Two models against the same recordings.

    Shown in a notebook it is the page of the command, as text its summary.
    """

    def __init__(self, own: _lacuna.Comparison) -> None:
        self._own = own

    def to_dict(self) -> dict[str, Any]:
        """What compare.json holds."""
        data: dict[str, Any] = json.loads(self._own.json())
        return data

    def report(self, path: str | os.PathLike[str]) -> None:
        """Write the page to a file."""
        Path(path).write_text(self._own.page(), encoding="utf-8")

    def save(self, folder: str | os.PathLike[str]) -> None:
        """Write compare.json and compare.html to a folder."""
        self._own.save(folder)

    def __repr__(self) -> str:
        return self._own.text()

    def _repr_html_(self) -> str:
        return framed(self._own.page(), "Two models, compared")


def compare(
    model_a: Model | str | os.PathLike[str],
    model_b: Model | str | os.PathLike[str],
    recordings: Any,
    horizon: float | None = None,
    warmup: int = WARMUP,
) -> Comparison:
    """Run two models on the same recordings: error per channel and which is nearer.

    Parameters
    ----------
    model_a, model_b : Model or path
        The models, of either kind, with the same measured channels.
    recordings : Recording or list of Recording
        Whose inputs drive them.
    horizon, warmup
        As in `simulate`.
    """
    runs = as_recordings(recordings)
    models = as_model(model_a)._for(runs), as_model(model_b)._for(runs)
    return Comparison(_lacuna.compare(models, [r._own for r in runs], horizon, warmup))


@dataclass(frozen=True, repr=False)
class Check:
    """What is in recordings, and whether they fit a model.

    Attributes
    ----------
    warnings : list of str
        What to mind, the gravest first.
    """

    warnings: list[str]
    _said: dict[str, Any] = field(compare=False)
    _text: str = field(compare=False)

    def to_dict(self) -> dict[str, Any]:
        """What ``lacuna check --json`` prints."""
        return self._said

    def __repr__(self) -> str:
        return self._text


def check(model: Model | str | os.PathLike[str], recordings: Any) -> Check:
    """Tell what is in recordings, whether they fit a model, and whether they can move its parameters.

    Parameters
    ----------
    model : Model or path
        The model.
    recordings : Recording or list of Recording
        The recordings.
    """
    runs = as_recordings(recordings)
    said, text = _lacuna.check(as_model(model)._for(runs), [r._own for r in runs])
    data = json.loads(said)
    return Check(data["warnings"], data, text)
