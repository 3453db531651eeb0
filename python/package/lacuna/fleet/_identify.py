"""One model of more trajectories than fit into memory."""

from __future__ import annotations

import os
import uuid
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

from .. import _lacuna
from .._identifier import Identifier
from .._lacuna import LacunaError

Part = TypeVar("Part")


def identify(
    files: str | os.PathLike[str],
    *,
    coordinates: Sequence[str],
    inputs: Sequence[str] = (),
    rates: Sequence[str] | None = None,
    time: str = "t",
    trajectory: str | None = None,
    order: int = 1,
    client: Any = None,
    input_hold: str = "zero-order",
    kernel: str | None = None,
    widths: Sequence[float] | None = None,
    regularisation: float | None = None,
    window: float | None = None,
    most_landmarks: int = 400,
) -> Identifier:
    """Learn x^(s) = f(x) + g(x) u from trajectories in Parquet files.

    Kernels, widths and landmarks are chosen on a sample of the trajectories that is spread evenly over the files.
    Each trajectory is then a few linear equations of f and g, of which only inner products are kept, and these add up:
    over chunks of whole row groups, in a tree that the files alone determine. Neither the number of workers nor who does
    what changes a bit of the result, on processors of one kind. A worker holds a row group and a few sums at a time.

    Unlike `Identifier.fit` it does not go on along the model's own trajectories: what smoothing leaves of the samples'
    noise in the states stays, however many trajectories there are.

    Parameters
    ----------
    files : str or path
        A pattern of Parquet files, such as ``"data/*.parquet"``, which every worker can read.
    coordinates, inputs : sequence of str
        Columns of the coordinates and of the inputs. No other column is read, but for the following.
    rates : sequence of str, optional
        Order 2: columns of the coordinates' rates, where these are measured.
    time : str
        Column of time, in seconds.
    trajectory : str, optional
        Column of whole numbers that tell trajectories apart: a run of rows of a file with the same number is one, in
        however many row groups it stands. Without it, every file is a trajectory.
    client : dask.distributed.Client, optional
        Who does the work; without, this process does. Where a worker is killed, Dask has its part done again.
    order, input_hold, kernel, widths, regularisation, window, most_landmarks
        As of `Identifier`. ``window`` is about twice the width of the test functions, too.

    Returns
    -------
    Identifier
        Fitted; ``noise_sd`` of its ``report_`` is what the equations leave.

    Raises
    ------
    LacunaError
        Files that are missing, cut or lack a column, numbers that are not finite, trajectories that are too short; with
        file and row group.
    """
    chosen = {
        "input_hold": input_hold,
        "kernel": kernel,
        "widths": widths,
        "regularisation": regularisation,
        "window": window,
        "most_landmarks": most_landmarks,
    }
    identifier = Identifier(order, rates=rates is not None, **chosen)
    if rates is not None and order != 2:
        raise LacunaError(f"rates are of dynamics of order 2; found order {order}")
    columns = [*coordinates, *(rates or ())]
    settings = identifier._settings(columns, list(inputs))
    names = (time, trajectory, list(coordinates), None if rates is None else list(rates), list(inputs))
    data = _lacuna.Trajectories.find(os.fspath(files), names)
    if client is None:
        stream = data.choose(settings)
        sums = _fold(0, data.chunks, lambda chunk: stream.sums(data, chunk), lambda a, b: a.plus(b))
        found = stream.solve(settings, data, sums)
    else:
        found = _spread(client, data, settings)
    return identifier._of(found, columns, list(inputs), named=True)


def _fold(first: int, end: int, part: Callable[[int], Part], plus: Callable[[Part, Part], Part]) -> Part:
    """The sum of parts as a balanced tree, whoever adds: left before right, so that few sums wait at a time."""
    count = end - first
    if count == 1:
        return part(first)
    middle = first + (1 << ((count - 1).bit_length() - 1))
    left = _fold(first, middle, part, plus)
    return plus(left, _fold(middle, end, part, plus))


def _spread(client: Any, data: _lacuna.Trajectories, settings: dict[str, Any]) -> _lacuna.Identified:
    """All of it as one graph, so that Dask knows how to make anew what a worker took with it."""
    from dask import delayed

    where = delayed(data, name=f"trajectories-{uuid.uuid4()}", traverse=False)
    stream = delayed(_choose, pure=False)(where, settings)
    sums = _fold(
        0,
        data.chunks,
        lambda chunk: delayed(_sums, pure=False)(stream, where, chunk),
        delayed(_plus, pure=False),
    )
    future = client.compute(delayed(_solve, pure=False)(stream, settings, where, sums))
    try:
        found: _lacuna.Identified = future.result()
        return found
    except BaseException:
        future.cancel()
        raise


def _choose(data: _lacuna.Trajectories, settings: dict[str, Any]) -> _lacuna.Stream:
    return data.choose(settings)


def _sums(stream: _lacuna.Stream, data: _lacuna.Trajectories, chunk: int) -> _lacuna.Sums:
    return stream.sums(data, chunk)


def _plus(left: _lacuna.Sums, right: _lacuna.Sums) -> _lacuna.Sums:
    return left.plus(right)


def _solve(
    stream: _lacuna.Stream, settings: dict[str, Any], data: _lacuna.Trajectories, sums: _lacuna.Sums
) -> _lacuna.Identified:
    return stream.solve(settings, data, sums)
