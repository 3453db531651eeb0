"""Two recordings and no model, as the command does it."""

import json

import numpy as np
import pytest

import lacuna
from test_function import FRICTION, recording


@pytest.fixture(scope="module")
def both():
    rng = np.random.default_rng(31)
    real = [recording(rng) for _ in range(2)]
    simulated = [without_friction(run) for run in real]
    return simulated, real


def without_friction(run):
    """What the simulator makes of the same torques."""
    inertia, damping, weight, step = 0.05, 0.03, 0.4, 0.01 / 4
    state, theta = np.array([0.2, 0.0]), []

    def slope(state, torque):
        return np.array([state[1], (torque - damping * state[1] - weight * np.sin(state[0])) / inertia])

    for torque in run["tau"]:
        theta.append(state[0])
        for _ in range(4):
            k1 = slope(state, torque)
            k2 = slope(state + 0.5 * step * k1, torque)
            k3 = slope(state + 0.5 * step * k2, torque)
            k4 = slope(state + step * k3, torque)
            state = state + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return {**run, "theta": np.array(theta)}


def test_a_concealed_friction_is_named_as_the_command_names_it(both, command, tmp_path):
    found = lacuna.compare_runs(sim=both[0], real=both[1])
    assert found.verdict == "missing_physics"
    (finding,) = found.findings
    assert (finding["class"], finding["channel"]) == ("coulomb_friction", "theta")
    value, std = finding["parameters"]["magnitude"]
    assert abs(value - FRICTION) < 4 * std + 0.1 * FRICTION
    files = []
    for kind, runs in zip(("sim", "run"), both):
        for k, run in enumerate(runs):
            files.append(tmp_path / f"{kind}{k}.csv")
            rows = np.stack([run[name] for name in ("t", "tau", "theta")], axis=1)
            np.savetxt(files[-1], rows, fmt="%.17g", delimiter=",", header="t,tau,theta", comments="")
    simulated = ("--simulated", files[0], "--simulated", files[1])
    said = json.loads(command("diagnose", *simulated, *files[2:], "--json").stdout)
    assert said["findings"] == found.findings and said["functions"] == found.to_dict()["functions"]
    found.save(tmp_path)
    assert json.loads((tmp_path / "difference.json").read_text()) == found.to_dict()
    found.report(tmp_path / "page.html")
    assert found._repr_html_().startswith("<iframe srcdoc=")
    assert (tmp_path / "page.html").read_text() == (tmp_path / "difference.html").read_text()


def test_units_must_agree(both):
    one, other = lacuna.Recording(both[0][0], units={"theta": "deg"}), lacuna.Recording(both[1][0], units={"theta": "rad"})
    with pytest.raises(lacuna.LacunaError, match="'theta' is in deg in one recording and in rad"):
        lacuna.compare_runs(one, other)
    with pytest.raises(lacuna.LacunaError, match="tau9"):
        lacuna.compare_runs(both[0], both[1], inputs=["tau9"])
