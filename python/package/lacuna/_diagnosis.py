"""The main job: which physics is missing from a model."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from . import _lacuna
from ._model import Model, as_model
from ._page import framed
from ._progress import Progress, Teller
from ._recording import Recording, as_recordings


@dataclass(frozen=True)
class Estimate:
    """A number with its standard deviation and unit; at a bound it is no estimate."""

    value: float
    std: float
    unit: str
    at_bound: bool = False


@dataclass(frozen=True)
class Rival:
    """What else a finding could be."""

    effect: str
    channel: str
    probability: float


@dataclass(frozen=True)
class Finding:
    """An effect that the evidence supports.

    Attributes
    ----------
    effect : str
        Class of the catalogue.
    law : str
        The law, where it is a variation of the class; otherwise the class.
    channel : str
        Channel, input or sensor that it acts on.
    other : str or None
        The other channel of a coupling, or the input that the law depends on.
    depends_on : tuple of str
        Channels that it depends on.
    region : dict
        Range of those channels in which it acts.
    time : float or None
        When it begins, in seconds, for what begins.
    parameters : dict of str to Estimate
        Its numbers.
    probability : float
        That the class on this channel is right.
    rivals : tuple of Rival
        The most probable first.
    says : str
        The finding in words.
    """

    effect: str
    law: str
    channel: str
    other: str | None
    depends_on: tuple[str, ...]
    region: dict[str, tuple[float, float]]
    time: float | None
    parameters: dict[str, Estimate]
    probability: float
    rivals: tuple[Rival, ...]
    says: str

    def __repr__(self) -> str:
        numbers = ", ".join(
            f"{name} {e.value:.4g} ± {e.std:.2g} {e.unit}".rstrip() for name, e in self.parameters.items()
        )
        return f"<{self.law} on {self.channel}: {numbers}; probability {self.probability:.0%}>"


class Diagnosis:
    """What `diagnose` found.

    Shown in a notebook it is the page of the command, as text its summary.
    """

    def __init__(self, own: _lacuna.Diagnosis, command: str) -> None:
        self._own = own
        self._command = command

    @cached_property
    def _data(self) -> dict[str, Any]:
        return self.to_dict()

    @property
    def verdict(self) -> str:
        """no_mismatch, miscalibrated, missing_physics, sensor_fault or unexplained."""
        return str(self._data["verdict"])

    @cached_property
    def findings(self) -> list[Finding]:
        """The missing physics, the most important first."""
        return [_finding(found) for found in self._data["findings"]]

    @cached_property
    def calibration(self) -> dict[str, Estimate]:
        """Parameters that the recordings move, by name."""
        return {name: _estimate(said) for name, said in self._data["calibration"].items()}

    @property
    def notes(self) -> list[str]:
        """What these data cannot tell, and anything its reader must know."""
        return list(self._data["notes"])

    @cached_property
    def augmented(self) -> Model:
        """The model with its effects and calibrated parameters."""
        return Model(self._own.augmented())

    def report(self, path: str | os.PathLike[str]) -> None:
        """Write the page to a file: HTML that needs nothing else."""
        Path(path).write_text(self._page(), encoding="utf-8")

    def save(self, folder: str | os.PathLike[str], figures: bool = False) -> None:
        """Write what ``lacuna diagnose --out`` does: diagnosis.json, augmented.toml, report.html and of a robot
        its own file, with `figures` the page's pictures as SVG too."""
        self._own.save(folder, self._command, figures)

    def to_dict(self) -> dict[str, Any]:
        """What diagnosis.json holds."""
        data: dict[str, Any] = json.loads(self.to_json())
        return data

    def to_json(self) -> str:
        """The text of diagnosis.json."""
        return self._own.json()

    def _page(self) -> str:
        return self._own.page(self._command)

    def __repr__(self) -> str:
        return self._own.summary()

    def _repr_html_(self) -> str:
        return framed(self._page(), "Lacuna's diagnosis")


def diagnose(
    model: Model | str | os.PathLike[str],
    recordings: Any,
    held_out: Any = (),
    *,
    exclude: Iterable[str] = (),
    only: Iterable[str] = (),
    exact: Iterable[str] = (),
    learn_remainder: bool = False,
    time_budget: float | None = None,
    progress: Progress = None,
) -> Diagnosis:
    """Find the physics that a model leaves out.

    The result is that of ``lacuna diagnose`` on the same numbers, to the last digit. Python's lock is released
    meanwhile, and Ctrl-C calls it off.

    Parameters
    ----------
    model : Model or path
        The model.
    recordings : Recording or list of Recording
        What is fitted. What a `Recording` is made of (a path, a data frame ...) will do as well.
    held_out : list of Recording, optional
        Recordings for proof alone; without any, one in four (or the last quarter of a single one) is kept.
    exclude : iterable of str
        Classes of effects not to look for: ``"dead_zone"``, ``"coulomb_friction@q1"``.
    only : iterable of str
        Look for nothing but these.
    exact : iterable of str
        These recorded inputs are exactly what the machine got: no noise on them is estimated.
    learn_remainder : bool
        Keep what is left after the named effects as learned curves; never instead of a name.
    time_budget : float, optional
        End the search after so many seconds with the best that it has found; the proof of that comes on top.
    progress : bool or callable, optional
        Whether to say what is being done, or whom to tell; by default on terminals and in notebooks.

    Raises
    ------
    LacunaError
        What is wrong with the recordings or the options, in the words of the command.
    KeyboardInterrupt
        Where it was called off.
    """
    model, runs, proofs = as_model(model), as_recordings(recordings), as_recordings(held_out)
    asked = {
        "exclude": _names(exclude),
        "only": _names(only),
        "exact": _names(exact),
        "learn_remainder": learn_remainder,
        "time_budget": time_budget,
    }
    with Teller(progress) as tell:
        equations = model._for([*runs, *proofs])
        own = _lacuna.diagnose(equations, [r._own for r in runs], [r._own for r in proofs], asked, tell)
    return Diagnosis(own, _command(model, runs, proofs, asked))


def _names(names: Iterable[str]) -> list[str]:
    return [names] if isinstance(names, str) else list(names)


def _command(model: Model, runs: list[Recording], proofs: list[Recording], asked: dict[str, Any]) -> str:
    """What repeats a diagnosis."""
    file = model._own.file
    said = repr(model if file is None else str(file))
    options = {"held_out": proofs, **asked}
    given = [f", {name}={value!r}" for name, value in options.items() if value]
    return f"lacuna.diagnose({said}, {runs!r}{''.join(given)})"


def _estimate(said: dict[str, Any]) -> Estimate:
    return Estimate(said["value"], said["std"], said["unit"], said["at_bound"])


def _finding(found: dict[str, Any]) -> Finding:
    rivals = ((r["class"], r["channel"], r["probability"]) for r in found["alternatives"])
    return Finding(
        effect=found["class"],
        law=found.get("law", found["class"]),
        channel=found["channel"],
        other=found.get("other"),
        depends_on=tuple(found["depends_on"]),
        region={name: (low, high) for name, (low, high) in found["region"].items()},
        time=found["time"],
        parameters={name: _estimate(said) for name, said in found["parameters"].items()},
        probability=found["probability"],
        rivals=tuple(Rival(*r) for r in rivals),
        says=found["says"],
    )
