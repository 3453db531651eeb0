"""Many machines, trajectories or trials, on one machine or on a cluster.

`diagnose` has many machines with one model, `identify` more trajectories of one machine than fit into memory, `study` many
trials of one experiment.

>>> from dask.distributed import Client, LocalCluster                                     # doctest: +SKIP
>>> client = Client(LocalCluster(n_workers=4, threads_per_worker=1))                      # doctest: +SKIP
>>> fleet = lacuna.fleet.diagnose("fleet.toml", client=client, out="results")             # doctest: +SKIP
>>> fleet.unlike                                                                          # doctest: +SKIP

The same from a shell, with a Dask scheduler that is running:
``python -m lacuna.fleet fleet.toml --scheduler tcp://node1:8786 --out results``.

Folders of results are those of the command ``lacuna fleet``, and both go on from what the other has done.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Mapping
from itertools import count
from pathlib import Path
from typing import Any, NamedTuple

from .. import _lacuna
from .._lacuna import LacunaError
from .._model import Model
from .._page import framed
from .._progress import Progress, Teller
from .._recording import Recording, as_recordings
from ._identify import identify
from ._study import study

__all__ = ["Fleet", "diagnose", "identify", "study"]


class Fleet:
    """What `diagnose` found of all machines.

    Shown in a notebook it is the page of the command, as text its summary.

    Attributes
    ----------
    folder : pathlib.Path
        Where the results are: a folder a machine, fleet.json and fleet.html.
    """

    def __init__(self, folder: Path, data: str, text: str, page: str) -> None:
        self.folder = folder
        self._json = data
        self._text = text
        self._page = page
        self._data: dict[str, Any] = json.loads(data)

    @property
    def unlike(self) -> dict[str, list[str]]:
        """The machines that are unlike the others, the clearest first, and in what: of those at most 1 % are not, on
        average."""
        return {u["machine"]: [reason["says"] for reason in u["because"]] for u in self._data["unlike"]}

    @property
    def failed(self) -> dict[str, str]:
        """The machines that could not be diagnosed, and why."""
        return {f["name"]: f["error"] for f in self._data["failed"]}

    @property
    def verdicts(self) -> dict[str, str]:
        """The verdict of each machine that was diagnosed."""
        return {m["name"]: m["verdict"] for m in self._data["machines"]}

    def to_dict(self) -> dict[str, Any]:
        """What fleet.json holds."""
        data: dict[str, Any] = json.loads(self._json)
        return data

    def __repr__(self) -> str:
        return self._text

    def _repr_html_(self) -> str:
        return framed(self._page, "A fleet")


class _Task(NamedTuple):
    """One machine, as it goes to a worker: nothing but text, numbers and arrays."""

    model: str
    folder: str
    name: str
    recordings: list[Recording]
    held_out: list[Recording]
    asked: dict[str, Any]
    command: str


def diagnose(
    machines: str | os.PathLike[str] | Mapping[str, Any],
    model: Model | str | os.PathLike[str] | None = None,
    held_out: Mapping[str, Any] | None = None,
    *,
    client: Any = None,
    out: str | os.PathLike[str] = "fleet",
    exclude: Iterable[str] = (),
    only: Iterable[str] = (),
    exact: Iterable[str] = (),
    learn_remainder: bool = False,
    time_budget: float | None = None,
    progress: Progress = None,
) -> Fleet:
    """Diagnose each machine of a fleet once, compare them, and write ``fleet.json`` and ``fleet.html``.

    Each machine is a task of one thread. Its results are written whole to ``out/NAME``, where every worker must be
    able to write; a machine whose results are there and are of the same inputs is not diagnosed again, whoever did
    it. Where a worker is killed, Dask gives its machines to another.

    Parameters
    ----------
    machines : path, or mapping of name to recordings
        The file of the fleet, or of every machine its recordings: a path or data frame (what a `Recording` is made
        of), or a list of them.
    model : Model or path, optional
        The model of all of them, which the file of a fleet names itself. It must be of a file that every worker can
        read.
    held_out : mapping of name to recordings, optional
        Of machines that have some, their recordings for proof alone.
    client : dask.distributed.Client, optional
        Who does the work; without, this process does, one machine after the other.
    out : path
        Folder of the results.
    exclude, only, exact, learn_remainder, time_budget
        As of `lacuna.diagnose`, where `machines` is a mapping; the file of a fleet has them as its ``[options]``.
    progress : bool or callable, optional
        Whether to say how many machines are done, or whom to tell; by default on terminals and in notebooks.

    Raises
    ------
    LacunaError
        What is wrong with the fleet's file, the model or the options. A machine that cannot be diagnosed is told in
        `Fleet.failed`, and stops no other.
    """
    asked = {
        "exclude": _names(exclude),
        "only": _names(only),
        "exact": _names(exact),
        "learn_remainder": learn_remainder,
        "time_budget": time_budget,
    }
    folder = Path(out).absolute()
    if isinstance(machines, Mapping):
        tasks = _of_mapping(machines, model, held_out or {}, (str(folder), asked))
    elif model is not None or held_out is not None or any(asked.values()):
        raise LacunaError("the file of a fleet says model, held_out and options itself")
    else:
        tasks = _of_file(machines, str(folder))
    with Teller(progress) as tell:
        done = _counter(len(tasks), tell)
        if client is None:
            for task in tasks:
                _work(task)
                done()
        else:
            _spread(tasks, client, done)
    return Fleet(folder, *_lacuna.fleet_collect(str(folder), [task.name for task in tasks]))


def _names(names: Iterable[str]) -> list[str]:
    return [names] if isinstance(names, str) else list(names)


def _of_file(file: str | os.PathLike[str], folder: str) -> list[_Task]:
    path = os.path.abspath(file)
    model, planned, asked = _lacuna.fleet_plan(path)
    command = f"lacuna.fleet.diagnose({os.fspath(file)!r})"
    options = json.loads(asked)
    return [
        _Task(os.fspath(model), folder, name, as_recordings(runs), as_recordings(proofs), options, command)
        for name, runs, proofs in planned
    ]


def _of_mapping(
    machines: Mapping[str, Any],
    model: Model | str | os.PathLike[str] | None,
    held_out: Mapping[str, Any],
    said: tuple[str, dict[str, Any]],
) -> list[_Task]:
    folder, asked = said
    file = model._own.file if isinstance(model, Model) else model
    if file is None:
        raise LacunaError("a fleet needs a model of a file, which every worker reads; found none")
    if strange := sorted(set(held_out) - set(machines)):
        raise LacunaError(f"held_out: no machine is called {', '.join(map(repr, strange))}")
    for name in machines:
        results = ("", "fleet.json", "fleet.html")
        if name != os.path.basename(name) or name.startswith(".") or name in results:
            raise LacunaError(f"{name!r} cannot be the name of a machine: it is that of the folder of its results")
    model_path = os.path.abspath(file)
    command = f"lacuna.fleet.diagnose(..., {model_path!r})"
    rest = (asked, command)
    return [
        _Task(model_path, folder, name, as_recordings(runs), as_recordings(held_out.get(name, ())), *rest)
        for name, runs in sorted(machines.items())
    ]


def _work(task: _Task) -> tuple[str, str, str | None]:
    """Diagnose a machine, or find that this was done."""
    machine = (task.name, [r._own for r in task.recordings], [r._own for r in task.held_out])
    state, error = _lacuna.fleet_diagnose((task.model, task.folder), machine, task.asked, task.command)
    return task.name, state, error


def _counter(of: int, tell: Callable[[str], Any] | None) -> Callable[[], None]:
    """To be called whenever a machine is done: it says how many are."""
    counted = count(1)

    def done() -> None:
        if tell is not None:
            tell(f"machines that are done: {next(counted)} of {of}")

    return done


def _spread(tasks: list[_Task], client: Any, done: Callable[[], None]) -> None:
    """Each machine as a task of its own; what is wrong with the whole fleet is raised and calls off the rest."""
    from dask.distributed import as_completed

    # Not pure: what was done before, the files say and not the scheduler.
    futures = client.map(_work, tasks, pure=False)
    try:
        for future in as_completed(futures, loop=client.loop):
            future.result()
            done()
    except BaseException:
        client.cancel(futures)
        raise
