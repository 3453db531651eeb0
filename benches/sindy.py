"""PySINDy's feature overview through `lacuna.Identifier`, beside PySINDy, in one run.

The data are those of PySINDy's own notebook (examples/1_feature_overview): the Lorenz system from one start, from 20 drawn
ones, and with its two inputs, every 2 ms for 10 s. To each channel comes white noise of a share of its standard deviation.
Every method gets the same samples. What is printed, of the notebook's test trajectory (15 s from another start, without noise):

    error    |x'_found - x'_true| / |x'_true|        over all its states
    ahead    |x_found(t + 0.5 s) - x(t + 0.5 s)| / sd  simulated from its true states, rms

each as the mean of the draws of noise ± their standard deviation; and the seconds of a fit, the mean of all noises.

    pip install pysindy ./python
    python benches/sindy.py
"""

from __future__ import annotations

import argparse
import time
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import pysindy
from pysindy.utils import lorenz, lorenz_control
from scipy.integrate import solve_ivp

import lacuna

STEP = 0.002
AHEAD = 0.5  # seconds
WINDOW_EVERY = 100  # samples of the test between starts

Array = np.ndarray
Rates = Callable[[Array, "Array | None"], Array]


@dataclass
class Exercise:
    """Trajectories without noise, their inputs, and the test."""

    name: str
    x: list[Array]
    u: list[Array] | None
    x_test: Array
    u_test: Array | None

    @property
    def t(self) -> Array:
        return STEP * np.arange(len(self.x[0]))


# What is fitted to an exercise, its channels with noise, as a function for the rates at states and inputs.
Method = Callable[[Exercise, "list[Array]"], Rates]


def inputs(t: Array) -> Array:
    return np.column_stack([np.sin(2 * t), t**2])


def simulated(start: Array, seconds: float, driven: bool) -> Array:
    t = np.arange(0, seconds, STEP)
    system, args = (lorenz_control, (inputs,)) if driven else (lorenz, ())
    done = solve_ivp(system, (t[0], t[-1]), start, t_eval=t, args=args, method="LSODA", rtol=1e-12, atol=1e-12)
    return done.y.T


def exercises(seed: int) -> Iterator[Exercise]:
    start, other = np.array([-8.0, 8.0, 27.0]), np.array([8.0, 7.0, 15.0])
    test = simulated(other, 15, False)
    yield Exercise("one trajectory", [simulated(start, 10, False)], None, test, None)
    drawn = np.random.default_rng(seed).random((20, 3)) - 0.5
    starts = np.array([36, 48, 41]) * drawn + np.array([0, 0, 25])
    yield Exercise("20 trajectories", [simulated(s, 10, False) for s in starts], None, test, None)
    u = inputs(np.arange(0, 10, STEP))
    u_test = inputs(np.arange(0, 15, STEP))
    yield Exercise("with control", [simulated(start, 10, True)], [u], simulated(other, 15, True), u_test)


def true_rates(x: Array, u: Array | None) -> Array:
    free = np.asarray(lorenz(0.0, x.T)).T
    return free if u is None else free + np.column_stack([u[:, 0], np.zeros(len(u)), -u[:, 1]])


def sindy(method: pysindy.FiniteDifference) -> Method:
    def fit(exercise: Exercise, x: list[Array]) -> Rates:
        model = pysindy.SINDy(differentiation_method=method)
        model.fit(x, t=STEP, u=exercise.u)
        return lambda states, u: np.asarray(model.predict(states, u=u))

    return fit


def weak_sindy(exercise: Exercise, x: list[Array]) -> Rates:
    np.random.seed(0)  # it draws its windows
    functions = pysindy.PolynomialLibrary(degree=2, include_bias=False)
    library = pysindy.WeakPDELibrary(functions, spatiotemporal_grid=exercise.t, K=500)
    model = pysindy.SINDy(feature_library=library)
    model.fit(x, t=STEP, u=exercise.u)
    found = model.coefficients()

    def rates(states: Array, u: Array | None) -> Array:
        columns = states if u is None else np.hstack([states, u])
        return np.asarray(functions.fit_transform(columns)) @ found.T

    return rates


def identifier(kernel: str | None) -> Method:
    def fit(exercise: Exercise, x: list[Array]) -> Rates:
        # The inputs are samples of smooth functions, not held.
        model = lacuna.Identifier(order=1, kernel=kernel, input_hold="linear")
        model.fit(x, exercise.u, [exercise.t] * len(x))
        return lambda states, u: np.asarray(model.predict(states, u))

    return fit


METHODS: dict[str, Method] = {
    "PySINDy": sindy(pysindy.FiniteDifference()),
    "PySINDy, smoothed differences": sindy(pysindy.SmoothedFiniteDifference()),
    "PySINDy, weak form": weak_sindy,
    "Identifier": identifier(None),
    'Identifier, kernel="polynomial"': identifier("polynomial"),
}


def error(exercise: Exercise, rates: Rates) -> float:
    truth = true_rates(exercise.x_test, exercise.u_test)
    found = rates(exercise.x_test, exercise.u_test)
    return float(np.linalg.norm(found - truth) / np.linalg.norm(truth))


def ahead(exercise: Exercise, rates: Rates) -> float:
    """Classical Runge-Kutta steps of two samples from many states at once."""
    steps = round(AHEAD / STEP)
    x, u = exercise.x_test, exercise.u_test
    begin = np.arange(0, len(x) - steps, WINDOW_EVERY)
    state, h = x[begin], 2 * STEP
    for k in range(0, steps, 2):
        first, middle, last = (None if u is None else u[begin + k + j] for j in range(3))
        k1 = rates(state, first)
        k2 = rates(state + h / 2 * k1, middle)
        k3 = rates(state + h / 2 * k2, middle)
        k4 = rates(state + h * k3, last)
        state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    off = (state - x[begin + steps]) / x.std(axis=0)
    return float(np.sqrt(np.mean(off**2)))


def said(values: list[float]) -> str:
    if not np.isfinite(values).all():
        return "diverges"
    spread = f" ± {np.std(values, ddof=1):.1g}" if len(values) > 1 else ""
    return f"{np.mean(values):.2g}{spread}"


def measured(exercise: Exercise, draws: list[list[Array]], method: Method) -> tuple[str, float]:
    """Error and what is ahead of all draws, and the seconds of a fit."""
    errors, aheads, seconds = [], [], []
    for x in draws:
        start = time.perf_counter()
        rates = method(exercise, x)
        seconds.append(time.perf_counter() - start)
        with np.errstate(all="ignore"):
            errors.append(error(exercise, rates))
            aheads.append(ahead(exercise, rates))
    return f"{said(errors)}; {said(aheads)}", float(np.mean(seconds))


def row(cells: list[str]) -> None:
    print(f"| {' | '.join(cells)} |", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--draws", type=int, default=3, help="draws of noise")
    parser.add_argument("--noise", default="0,0.01,0.05,0.1", help="shares of the standard deviation")
    parser.add_argument("--methods", default="", help="those whose names contain this")
    parser.add_argument("--data", default="", help="exercises whose names contain this")
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args()
    warnings.filterwarnings("ignore")
    methods = {name: method for name, method in METHODS.items() if chosen.methods in name}
    row(["data", "noise", *methods])
    row(["---"] * (2 + len(methods)))
    for exercise in exercises(chosen.seed):
        if chosen.data not in exercise.name:
            continue
        spread = np.concatenate(exercise.x).std(axis=0)
        seconds = []
        for noise in (float(n) for n in chosen.noise.split(",")):
            rng = np.random.default_rng(chosen.seed)
            draws = [
                [x + noise * spread * rng.standard_normal(x.shape) for x in exercise.x]
                for _ in range(chosen.draws if noise else 1)
            ]
            found = [measured(exercise, draws, method) for method in methods.values()]
            row([exercise.name, f"{noise:.0%}", *(cell for cell, _ in found)])
            seconds.append([taken for _, taken in found])
        row([exercise.name, "seconds a fit", *(f"{taken:.2g}" for taken in np.mean(seconds, axis=0))])


if __name__ == "__main__":
    main()
