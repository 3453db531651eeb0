"""Monte-Carlo studies: the same function, many random draws."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np

from .._lacuna import LacunaError

Result = TypeVar("Result")

#: Tasks, at most: enough for any cluster, few enough for a scheduler.
_TASKS = 1000


def study(
    function: Callable[[np.random.Generator], Result],
    trials: int,
    *,
    seed: int = 0,
    client: Any = None,
) -> list[Result]:
    """Call a function of a random generator many times.

    The generator of a trial depends on seed and trial alone: results are the same for any number of workers, and
    those of the first trials stay when there are more.

    Parameters
    ----------
    function : callable
        Takes a `numpy.random.Generator`; what it returns is sent back.
    trials : int
        How many times.
    seed : int
        Seed of the study, 0 or more.
    client : dask.distributed.Client, optional
        Who does the work; without, this process does. Where a worker is killed, Dask has its trials done again.

    Returns
    -------
    list
        What the function returned, in the order of the trials.

    Raises
    ------
    LacunaError
        The first trial that failed, with its number.
    """
    if trials < 0 or seed < 0:
        raise LacunaError(f"trials and seed must be 0 or more, found {trials} and {seed}")
    size = max(1, -(-trials // _TASKS))
    parts = [(first, min(trials, first + size)) for first in range(0, trials, size)]
    if client is None:
        done = [_some(part, function, seed) for part in parts]
    else:
        futures = client.map(_some, parts, function=function, seed=seed, pure=False)
        try:
            done = _gathered(client, futures)
        except BaseException:
            client.cancel(futures)
            raise
    return [result for part in done for result in part]


def _gathered(client: Any, futures: list[Any]) -> list[Any]:
    """All results; of several failures the first in order, whichever came first."""
    try:
        return list(client.gather(futures))
    except LacunaError:
        for future in futures:
            future.result()
        raise


def _some(trials: tuple[int, int], function: Callable[[np.random.Generator], Result], seed: int) -> list[Result]:
    return [_one(trial, function, seed) for trial in range(*trials)]


def _one(trial: int, function: Callable[[np.random.Generator], Result], seed: int) -> Result:
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(trial,)))
    try:
        return function(rng)
    except Exception as error:
        raise LacunaError(f"trial {trial} of seed {seed}: {type(error).__name__}: {error}") from error
