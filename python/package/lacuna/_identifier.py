"""No model: drift and control effectiveness from trajectories, with scikit-learn's conventions."""

from __future__ import annotations

import inspect
import json
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _lacuna
from ._lacuna import LacunaError

Array = npt.NDArray[np.float64]
#: Times, measured channels and inputs of one trajectory.
Trajectory = tuple[Array, Array, Array]


class Identifier:
    """Learn x^(s) = f(x) + g(x) u from whole trajectories.

    Drift f and control effectiveness g are found by control occupation kernel regression: trajectories are
    integrated, never differentiated. Kernels, widths, regularisation and noise are chosen by what makes the data
    most likely, where they are not given.

    With order s = 1 the state is the n coordinates themselves. With s = 2 it is coordinates and their rates,
    ``(N, 2 n)``: `predict` and `simulate` speak of states; `fit` and `score` of what was measured, coordinates
    alone or, with `rates`, the whole state.

    Parameters
    ----------
    order : {1, 2}
        Order s of the dynamics.
    rates : bool
        Order 2: whether rates were measured too; they stand behind the coordinates.
    input_hold : {"zero-order", "linear", "smooth"}
        What inputs do between samples.
    kernel : {"gaussian", "matern", "polynomial", "exponential"}, optional
        Kernel of all functions; of polynomials the data choose the degree, 3 at most. By default the family that
        makes the data most likely, for each function; exponential is never chosen unasked.
    widths : sequence of float, optional
        Kernel widths, one for each entry of the state.
    regularisation : float, optional
        Noise variance over prior variance.
    window : float, optional
        Length of the windows with free initial values, in seconds.
    most_landmarks : int
        Most landmarks of a function.

    Attributes
    ----------
    n_features_in_ : int
        Columns of what was fitted.
    feature_names_in_ : ndarray of str
        Their names, where a data frame was fitted.
    n_inputs_ : int
        Number m of inputs.
    report_ : dict
        What was chosen, and what the data cannot tell.
    """

    def __init__(
        self,
        order: int = 1,
        *,
        rates: bool = False,
        input_hold: str = "zero-order",
        kernel: str | None = None,
        widths: Sequence[float] | None = None,
        regularisation: float | None = None,
        window: float | None = None,
        most_landmarks: int = 400,
    ) -> None:
        self.order = order
        self.rates = rates
        self.input_hold = input_hold
        self.kernel = kernel
        self.widths = widths
        self.regularisation = regularisation
        self.window = window
        self.most_landmarks = most_landmarks

    def fit(self, X: Any, U: Any = None, t: Any = 1.0) -> Identifier:
        """Identify f and g.

        Parameters
        ----------
        X : array or data frame (N, n), or list of them
            Measured coordinates of one trajectory, or of several; with `rates` ``(N, 2 n)``. NaN marks a missing
            sample.
        U : array (N, m) or (N,), or list of them, optional
            Inputs; without any nothing drives the machine.
        t : array (N,), float, or list of them
            Times, or the step from sample to sample, in seconds.

        Returns
        -------
        Identifier
            Itself.

        Raises
        ------
        LacunaError
            Data from which no model can be made.
        """
        names = _names_of(X[0] if _is_several(X) else X)
        trajectories = _trajectories(X, U, t)
        columns, inputs = trajectories[0][1].shape[1], trajectories[0][2].shape[1]
        n = columns // 2 if self.rates else columns
        if self.rates and (self.order != 2 or columns != 2 * n):
            raise LacunaError(
                f"rates stand behind as many coordinates, and are of dynamics of order 2; found {columns} columns and "
                f"order {self.order}"
            )
        called = names or [f"x{i}" for i in range(n)] + [f"dx{i}" for i in range(columns - n)]
        driven = _names_of(U[0] if _is_several(U) else U) or [f"u{j}" for j in range(inputs)]
        identified = _lacuna.identify(self._settings(called, driven), trajectories)
        return self._of(identified, called, driven, named=names is not None)

    def _settings(self, columns: list[str], inputs: list[str]) -> dict[str, Any]:
        """How to identify from columns of these names: coordinates, with `rates` their rates behind them, and inputs."""
        n = len(columns) // 2 if self.rates else len(columns)
        return {
            "order": self.order,
            "input_path": self.input_hold,
            "kernel": self.kernel,
            "widths": None if self.widths is None else list(self.widths),
            "lambda": self.regularisation,
            "window": self.window,
            "most_landmarks": self.most_landmarks,
            "coordinates": columns[:n],
            "rates": columns[n:] if self.rates else None,
            "inputs": inputs,
        }

    def _of(self, identified: _lacuna.Identified, columns: list[str], inputs: list[str], named: bool) -> Identifier:
        """Fitted: with a model that was identified from columns of these names, which are the data's own if `named`."""
        self._identified = identified
        self.n_features_in_ = len(columns)
        self.n_inputs_ = len(inputs)
        if named:
            self.feature_names_in_ = np.asarray(columns, dtype=object)
        elif hasattr(self, "feature_names_in_"):
            del self.feature_names_in_
        return self

    @property
    def report_(self) -> dict[str, Any]:
        """What was chosen, and what the data cannot tell."""
        report: dict[str, Any] = json.loads(self._fitted().report)
        return report

    def predict(self, X: Any, U: Any = None) -> Any:
        """Highest derivatives x^(s) = f(x) + g(x) u.

        Parameters
        ----------
        X : array (N, s n), or list of them
            States.
        U : array (N, m) or (N,), or list of them, optional
            Inputs; without any they are 0, and this is the drift.

        Returns
        -------
        ndarray (N, n), or list of them
        """
        if _is_several(X):
            return [self.predict(x, u) for x, u in zip(X, _each(U, len(X)), strict=True)]
        drift, effectiveness = self._function(0, X, False), self._function(1, X, False)
        return drift + np.einsum("kij,kj->ki", effectiveness, self._inputs(U, len(drift)))

    def drift(self, X: Any, return_std: bool = False) -> Any:
        """Drift f ``(N, n)`` at states, with `return_std` its standard deviation too."""
        return self._function(0, X, return_std)

    def effectiveness(self, X: Any, return_std: bool = False) -> Any:
        """Control effectiveness g ``(N, n, m)`` at states, with `return_std` its standard deviation too."""
        return self._function(1, X, return_std)

    def simulate(self, x0: Any, u: Any = None, t: Any = None) -> Array:
        """Run the model from a state.

        Parameters
        ----------
        x0 : array (s n,)
            The state at the first time.
        u : array (N, m) or (N,), optional
            Inputs at the times; without any they are 0.
        t : array (N,)
            Times, in seconds.

        Returns
        -------
        ndarray (N, s n)
            States at the times.

        Raises
        ------
        LacunaError
            A model that diverges.
        """
        fitted = self._fitted()
        if t is None:
            raise LacunaError("simulate needs the times t, an array")
        times = _aligned(t)
        start = self._states(np.reshape(np.asarray(x0, dtype=np.float64), (1, -1)))[0]
        return fitted.simulate(start, times, self._inputs(u, len(times)))

    def score(self, X: Any, U: Any = None, t: Any = 1.0) -> float:
        """Share of the measured channels' variance that the model explains.

        The model runs in windows as long as those of the fit, the state at the beginning of each fitted to it (the
        state alone); R^2 of what was measured, the mean over the channels.

        Parameters
        ----------
        X, U, t
            As in `fit`, of at least 100 samples each.

        Returns
        -------
        float
            1 at best.
        """
        fitted = self._fitted()
        horizon = self.report_["window_seconds"]
        each = [fitted.squares(self._measured(one), horizon) for one in _trajectories(X, U, t)]
        left, about_mean = np.moveaxis(np.asarray(each).sum(axis=0), -1, 0)
        return float(np.mean(1.0 - left / about_mean))

    def to_json(self) -> str:
        """The model as ``lacuna identify`` writes it: for ``lacuna simulate``, ``compile``, ``export``."""
        return self._fitted().json()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write `to_json` to a file."""
        Path(path).write_text(self.to_json(), encoding="utf-8")

    def get_params(self, deep: bool = True) -> dict[str, Any]:
        """Parameters by name."""
        return {name: getattr(self, name) for name in _parameters()}

    def set_params(self, **params: Any) -> Identifier:
        """Set parameters by name."""
        known = _parameters()
        for name, value in params.items():
            if name not in known:
                raise LacunaError(
                    f"Invalid parameter {name!r} for estimator Identifier; valid are {', '.join(known)}"
                )
            setattr(self, name, value)
        return self

    def __repr__(self) -> str:
        defaults = inspect.signature(Identifier.__init__).parameters
        said = (f"{n}={v!r}" for n, v in self.get_params().items() if v is not defaults[n].default)
        return f"Identifier({', '.join(said)})"

    def __sklearn_is_fitted__(self) -> bool:
        return hasattr(self, "_identified")

    def __sklearn_tags__(self) -> Any:
        # Asked by scikit-learn alone: the package does not depend on it.
        from sklearn.utils import InputTags, Tags, TargetTags  # type: ignore

        return Tags(
            estimator_type=None,
            target_tags=TargetTags(required=False, multi_output=True, single_output=True),
            input_tags=InputTags(allow_nan=True),
        )

    def _fitted(self) -> _lacuna.Identified:
        if hasattr(self, "_identified"):
            return self._identified
        scikit = sys.modules.get("sklearn.exceptions")
        kind = LacunaError if scikit is None else scikit.NotFittedError
        raise kind("This Identifier is not fitted yet; call fit first")

    def _function(self, which: int, X: Any, return_std: bool) -> Any:
        fitted = self._fitted()
        states = self._states(X)
        value = _where_known(states, fitted.functions(states)[which])
        if not return_std:
            return value
        return value, _where_known(states, fitted.deviations(states)[which])

    def _states(self, X: Any) -> Array:
        states = _matrix(X, "X")
        n = self.n_features_in_ // 2 if self.rates else self.n_features_in_
        if states.shape[1] != n * self.order:
            raise LacunaError(_other_features(states, n * self.order) + ": the whole state")
        return states

    def _measured(self, trajectory: Trajectory) -> Trajectory:
        """A trajectory of what was fitted; without inputs they are 0."""
        times, measured, inputs = trajectory
        if measured.shape[1] != self.n_features_in_:
            raise LacunaError(_other_features(measured, self.n_features_in_))
        return times, measured, self._inputs(inputs if inputs.shape[1] else None, len(times))

    def _inputs(self, U: Any, samples: int) -> Array:
        if U is None:
            return np.zeros((samples, self.n_inputs_))
        inputs = _columns(U, "U")
        if inputs.shape != (samples, self.n_inputs_):
            raise LacunaError(f"U: expected shape {(samples, self.n_inputs_)}, found {inputs.shape}")
        return inputs


def _parameters() -> list[str]:
    return [name for name in inspect.signature(Identifier.__init__).parameters if name != "self"]


def _other_features(found: Array, expected: int) -> str:
    return f"X has {found.shape[1]} features, but Identifier is expecting {expected} features as input"


def _where_known(states: Array, values: Array) -> Array:
    """Nothing is known of a function where the state is not."""
    values[~np.isfinite(states).all(axis=1)] = np.nan
    return values


def _is_several(data: Any) -> bool:
    """Whether these are several trajectories: a list of arrays, not one of rows or numbers."""
    if not isinstance(data, (list, tuple)) or len(data) == 0:
        return False
    dimensions = np.ndim(data[0])
    is_row = dimensions == 1 and isinstance(data[0], (list, tuple))
    return dimensions > 0 and not is_row


def _each(data: Any, count: int) -> Sequence[Any]:
    """Something for each of so many trajectories."""
    return data if _is_several(data) else [data] * count


def _trajectories(X: Any, U: Any, t: Any) -> list[Trajectory]:
    if not _is_several(X):
        return [_trajectory(X, U, t)]
    times = t if isinstance(t, (list, tuple)) else [t] * len(X)
    inputs = _each(U, len(X))
    if not len(X) == len(inputs) == len(times):
        raise LacunaError(f"{len(X)} trajectories, inputs of {len(inputs)}, times of {len(times)}")
    return [_trajectory(*one) for one in zip(X, inputs, times)]


def _trajectory(X: Any, U: Any, t: Any) -> Trajectory:
    measured = _matrix(X, "X")
    samples = len(measured)
    inputs = np.zeros((samples, 0)) if U is None else _columns(U, "U")
    times = np.asarray(t, dtype=np.float64)
    if times.ndim == 0:
        times = times * np.arange(samples)
    if len(inputs) != samples or times.shape != (samples,):
        raise LacunaError(
            f"inconsistent numbers of samples: X has {samples}, U {len(inputs)}, t shape {times.shape}"
        )
    return _aligned(times), measured, inputs


def _matrix(data: Any, what: str) -> Array:
    """A table of numbers with at least a row and a column."""
    values = _numbers(data, what)
    if values.ndim != 2:
        raise LacunaError(
            f"{what}: expected a 2D array, a row a sample, found shape {values.shape}. Reshape your data: one channel "
            "is X.reshape(-1, 1)"
        )
    for count, axis in zip(values.shape, ("sample", "feature")):
        if count == 0:
            raise LacunaError(
                f"{what}: 0 {axis}(s) (shape={values.shape}) while a minimum of 1 is required."
            )
    return values


def _columns(data: Any, what: str) -> Array:
    """The same, where one column may be a plain list."""
    values = _numbers(data, what)
    return values.reshape(-1, 1) if values.ndim == 1 else _matrix(values, what)


def _aligned(data: Any) -> Array:
    """Numbers one after the other, where a processor reads them: fields of packed records are elsewhere."""
    return np.require(data, np.float64, ["C", "A", "E"])


def _numbers(data: Any, what: str) -> Array:
    if hasattr(data, "tocsr"):
        raise LacunaError(f"{what}: sparse data are not supported; expected an array")
    values = np.asarray(data)
    if values.dtype.kind == "c":
        raise LacunaError(f"{what}: Complex data not supported; expected real numbers")
    try:
        return _aligned(values)
    except ValueError as error:
        raise LacunaError(f"{what}: expected numbers; {error}") from None


def _names_of(data: Any) -> list[str] | None:
    """Names of the columns of a data frame."""
    columns = getattr(data, "columns", None)
    return None if columns is None else [str(name) for name in columns]
