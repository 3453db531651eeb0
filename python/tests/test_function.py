"""A function as the model: a hanging arm turned by a motor, whose dry friction nobody knows of."""

import numpy as np
import pytest

import lacuna

INERTIA, DAMPING, WEIGHT = 0.05, 0.03, 0.4
#: Concealed: dry friction (N m), and the speed within which it turns (rad/s).
FRICTION, SMOOTHING = 0.06, 0.2
STEP, SAMPLES, NOISE = 0.01, 1000, 1e-3


def believed(z, u, p, t):
    theta, omega = z.T
    inertia, damping, weight = p.T
    return ((u[:, 0] - damping * omega - weight * np.sin(theta)) / inertia,)


def torque(z, u, p, t):
    theta, omega = z.T
    return (u[:, 0] - p[:, 1] * omega - p[:, 2] * np.sin(theta),)


def described(**more):
    return {
        "coordinates": {"theta": ("omega", "rad")},
        "inputs": {"tau": "N m"},
        "parameters": {
            "J": {"value": INERTIA, "unit": "kg m^2", "tolerance": 0.1},
            "b": {"value": DAMPING, "unit": "N m s/rad", "tolerance": 0.1},
            "k": {"value": WEIGHT, "unit": "N m", "tolerance": 0.1},
        },
        "name": "arm",
        **more,
    }


def recording(rng):
    """Runge-Kutta steps of the true arm, its torque held between samples."""
    t = STEP * np.arange(SAMPLES)
    tau = sum(rng.uniform(0.1, 0.3) * np.sin(rng.uniform(0.5, 6.0) * t + rng.uniform(0.0, 6.3)) for _ in range(4))

    def slope(state, torque):
        theta, omega = state
        friction = FRICTION * np.tanh(omega / SMOOTHING)
        return np.array([omega, (torque - DAMPING * omega - WEIGHT * np.sin(theta) - friction) / INERTIA])

    state, theta, h = np.array([0.2, 0.0]), [], STEP / 4
    for torque in tau:
        theta.append(state[0])
        for _ in range(4):
            k1 = slope(state, torque)
            k2 = slope(state + 0.5 * h * k1, torque)
            k3 = slope(state + 0.5 * h * k2, torque)
            k4 = slope(state + h * k3, torque)
            state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return {"t": t, "tau": tau, "theta": np.array(theta) + NOISE * rng.standard_normal(SAMPLES)}


@pytest.fixture(scope="module")
def runs():
    rng = np.random.default_rng(212)
    return [recording(rng) for _ in range(3)]


def test_a_concealed_friction_is_named_as_an_acceleration(runs):
    model = lacuna.Model.from_function(believed, **described())
    found = lacuna.diagnose(model, runs)
    # It is read as equations.
    assert "sin(theta)" in model.to_toml() and not any("differences" in note for note in found.notes)
    (finding,) = found.findings
    assert (finding.effect, finding.channel) == ("coulomb_friction", "theta")
    magnitude = finding.parameters["magnitude"]
    assert magnitude.unit == "rad/s^2"
    assert abs(magnitude.value - FRICTION / INERTIA) < 4 * magnitude.std + 0.1 * FRICTION / INERTIA
    # What was found acts on the function.
    before, after = (m.simulate(runs[0]).channels["theta"]["rmse"] for m in (model, found.augmented))
    assert after < 0.2 * before


def test_with_a_mass_it_is_a_force(runs):
    model = lacuna.Model.from_function(
        torque, mass=lambda z, u, p, t: p[:, :1, None], **described()
    )
    (finding,) = lacuna.diagnose(model, runs, only="coulomb_friction").findings
    magnitude = finding.parameters["magnitude"]
    assert magnitude.unit == "N m" and abs(magnitude.value - FRICTION) < 4 * magnitude.std


def test_a_function_and_the_same_text_agree(runs, tmp_path):
    text = tmp_path / "arm.toml"
    text.write_text(
        """name = "arm"
[parameters]
J = { value = 0.05, unit = "kg m^2", tolerance = 0.1 }
b = { value = 0.03, unit = "N m s/rad", tolerance = 0.1 }
k = { value = 0.4, unit = "N m", tolerance = 0.1 }
[[input]]
name = "tau"
unit = "N m"
[[coordinate]]
name = "theta"
velocity = "omega"
unit = "rad"
[mechanics]
mass = [["J"]]
force = ["tau - b*omega - k*sin(theta)"]
"""
    )
    model = lacuna.Model.from_function(believed, **described())
    one, other = model.simulate(runs[0]).series["theta"], lacuna.simulate(text, runs[0]).series["theta"]
    assert np.allclose(one, other, rtol=0.0, atol=1e-9)
    called = lacuna.Model.from_function(believed, **described(as_equations=False))
    assert "the equations of 'arm' are code" in called.to_toml().lower()
    # The state at the beginning is fitted, with derivatives by differences here.
    assert np.allclose(called.simulate(runs[0]).series["theta"], other, rtol=0.0, atol=1e-6)

def branches(z, u, p, t):
    """The same arm, in a way that no equations are read from."""
    given = np.zeros((len(t), 1))
    given[:, 0] = believed(z, u, p, t)[0]
    return given


def test_a_function_that_is_no_equations_is_called(runs):
    model = lacuna.Model.from_function(branches, **described())
    short = [{name: values[:200] for name, values in run.items()} for run in runs[:1]]
    found = lacuna.diagnose(model, short, only="coulomb_friction", time_budget=1.0)
    assert any("differences" in note for note in found.notes)
    assert found.augmented.name == "arm"


def test_first_order_states_and_measurements_are_described():
    def tank(z, u, p, t):
        return np.stack([u[:, 0] - p[:, 0] * np.sqrt(np.maximum(z[:, 0], 0.0))], axis=1)

    model = lacuna.Model.from_function(
        tank,
        states={"h": "m"},
        inputs={"q": "m/s"},
        parameters={"k": 0.3},
        measurements={"level_mm": ("h", "mm")},
    )
    t = 0.1 * np.arange(400)
    run = model.simulate({"t": t, "q": 0.1 + 0 * t, "level_mm": 1e3 * np.full(400, (0.1 / 0.3) ** 2)})
    assert run.channels["h"]["rmse"] < 1e-9


def test_what_a_function_raises_is_raised(runs):
    calls = []

    def fails(z, u, p, t):
        calls.append(len(t))
        if len(calls) > 50:
            raise ArithmeticError("no more")
        return branches(z, u, p, t)

    model = lacuna.Model.from_function(fails, **described())
    with pytest.raises(ArithmeticError, match="no more"):
        lacuna.diagnose(model, runs)
    # Derivatives at a point are asked for together.
    assert max(calls) > 4


def test_results_of_another_shape_are_refused():
    with pytest.raises(lacuna.LacunaError, match=r"rates must give an array of shape \(1, 1\)"):
        lacuna.Model.from_function(lambda z, u, p, t: z, **described())
    with pytest.raises(lacuna.LacunaError, match="'tau'"):
        lacuna.Model.from_function(believed, **described(states={"tau": "m"}))
    with pytest.raises(lacuna.LacunaError, match="tolerance or its std"):
        both = {"J": {"value": 1.0, "tolerance": 0.1, "std": 0.1}}
        lacuna.Model.from_function(believed, **described(parameters=both))


def test_what_numpy_computes_is_read_as_equations():
    def much(z, u, p, t):
        q, v, x = z.T
        with_time = np.hypot(q, v) * np.exp(-np.abs(v)) + np.arctan2(u[:, 0], 1.0 + q**2) - np.cos(t)
        clipped = np.clip(v, -0.5, p[:, 0]) + np.sign(q) * np.sqrt(np.maximum(x, 0.0)) + np.tanh(q / 0.1) ** 3
        return np.stack([with_time + clipped, -x * 2e-7], axis=-1)

    same = {
        "coordinates": {"q": ("v", "m")},
        "states": {"x": "m"},
        "inputs": {"u": "N"},
        "parameters": {"top": 0.7},
    }
    model = lacuna.Model.from_function(much, **same)
    assert "atan2" in model.to_toml() and "clip" not in model.to_toml()
    called = lacuna.Model.from_function(much, **same, as_equations=False)
    t = 0.01 * np.arange(300)
    run = {"t": t, "u": np.sin(3 * t), "q": 0.1 * np.cos(t), "x": np.exp(-t)}
    one, other = model.simulate(run).series, called.simulate(run).series
    assert all(np.allclose(one[name], other[name], atol=1e-6) for name in one)


def test_what_depends_on_other_points_is_no_equation():
    def mean(z, u, p, t):
        return (u[:, 0] - z[:, 0].mean(),)

    model = lacuna.Model.from_function(mean, **described())
    assert "are code" in model.to_toml()


def test_a_function_that_refuses_some_points_stays_a_function():
    def refuses(z, u, p, t):
        if z.dtype != object and np.any(np.abs(z) > 5.0):
            raise ValueError("too far")
        return believed(z, u, p, t)

    assert "are code" in lacuna.Model.from_function(refuses, **described()).to_toml()
