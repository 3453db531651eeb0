"""Points at which two models are compared."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

#: How many.
COUNT = 64


def some_points(described: dict[str, Any], spread: float) -> tuple[Array, Array, Array, Array]:
    """States, inputs, parameters and times, a row a point: near and far, each parameter within this share of its value."""
    rng = np.random.default_rng(0)
    width = 2 * len(described["coordinates"]) + len(described["states"])
    nominal = np.array([p[1] for p in described["parameters"]], dtype=np.float64)
    scale = 10.0 ** rng.uniform(-2.0, 1.0, (COUNT, 1))
    return (
        scale * rng.standard_normal((COUNT, width)),
        scale * rng.standard_normal((COUNT, len(described["inputs"]))),
        nominal * rng.uniform(1.0 - spread, 1.0 + spread, (COUNT, len(nominal))),
        10.0 * rng.uniform(size=COUNT),
    )
