"""Drift and control effectiveness from arrays, as scikit-learn's estimators are used."""

import pickle

import numpy as np
import pandas as pd
import pytest

import lacuna

STEP = 0.02


def pendulum(seed, samples=400, noise=1e-3):
    """theta'' = u - 0.3 theta' - 4 sin theta, u held: theta, omega, u, t."""
    rng = np.random.default_rng(seed)
    t = STEP * np.arange(samples)
    u = sum(rng.uniform(0.5, 1.5) * np.sin(rng.uniform(0.5, 5.0) * t + rng.uniform(0.0, 6.3)) for _ in range(3))
    states = simulated(lambda z, v: np.array([z[1], v - 0.3 * z[1] - 4.0 * np.sin(z[0])]), rng.uniform(-1, 1, 2), u)
    return states + noise * rng.standard_normal(states.shape), u, t


def simulated(slope, state, inputs):
    states = []
    for u in inputs:
        states.append(state)
        for _ in range(2):
            h = STEP / 2
            k1 = slope(state, u)
            k2 = slope(state + 0.5 * h * k1, u)
            k3 = slope(state + 0.5 * h * k2, u)
            state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + slope(state + h * k3, u))
    return np.array(states)


@pytest.fixture(scope="module")
def fitted():
    motions = [pendulum(seed) for seed in range(4)]
    return lacuna.Identifier(order=2).fit(
        [x[:, :1] for x, _, _ in motions], [u for _, u, _ in motions], [t for _, _, t in motions]
    )


def grid():
    q, v = np.meshgrid(np.linspace(-0.8, 0.8, 9), np.linspace(-1.0, 1.0, 9))
    return np.stack([q.ravel(), v.ravel()], axis=1)


def test_drift_and_effectiveness_are_found(fitted):
    states = grid()
    truth = (-0.3 * states[:, 1] - 4.0 * np.sin(states[:, 0]))[:, None]
    drift, drift_std = fitted.drift(states, return_std=True)
    assert np.abs(drift - truth).max() < 0.1 and np.all(drift_std >= 0.0)
    effectiveness = fitted.effectiveness(states)
    assert effectiveness.shape == (81, 1, 1) and np.abs(effectiveness - 1.0).max() < 0.05
    u = np.linspace(-1.0, 1.0, 81)
    assert np.allclose(fitted.predict(states, u), drift + u[:, None] * effectiveness[:, :, 0])
    assert np.array_equal(fitted.predict(states), drift)
    assert np.isnan(fitted.predict([[np.nan, 0.0], [0.0, 0.0]])[:, 0]).tolist() == [True, False]
    assert [len(one) for one in fitted.predict([states, states[:3]], [u, u[:3]])] == [81, 3]


def test_it_simulates_and_scores(fitted):
    x, u, t = pendulum(9, noise=0.0)
    run = fitted.simulate(x[0], u, t)
    # Eight seconds, partly beyond the speeds that were seen.
    assert run.shape == x.shape and np.abs(run - x).max() < 0.1
    assert fitted.score(x[:, :1], u, t) > 0.999
    assert fitted.score([x[:, :1]] * 2, [u] * 2, [t] * 2) == pytest.approx(fitted.score(x[:, :1], u, t))
    assert fitted.n_features_in_ == 1 and fitted.report_["window_seconds"] > 0.0


def test_measured_rates_and_names_of_frames_are_used():
    x, u, t = pendulum(1)
    frame = pd.DataFrame(x, columns=["theta", "omega"])
    fitted = lacuna.Identifier(order=2, rates=True).fit(frame, pd.DataFrame({"tau": u}), STEP)
    assert list(fitted.feature_names_in_) == ["theta", "omega"]
    assert '"inputs":["tau"]' in fitted.to_json() and "omega" in fitted.to_json()
    assert fitted.predict(frame, u).shape == (400, 1)
    with pytest.raises(lacuna.LacunaError, match="order 2"):
        lacuna.Identifier(order=1, rates=True).fit(frame, u, t)


def test_the_command_knows_the_model(fitted, command, tmp_path):
    fitted.save(tmp_path / "model.json")
    x, u, t = pendulum(5)
    pd.DataFrame({"t": t, "x0": x[:, 0], "u0": u}).to_csv(tmp_path / "run.csv", index=False)
    said = command("simulate", tmp_path / "model.json", "--like", tmp_path / "run.csv", "--json")
    assert said.returncode == 0, said.stderr
    model = lacuna.Model.from_json(tmp_path / "model.json")
    assert list(model.states) == ["x0", "dx0"] and list(model.inputs) == ["u0"]
    assert model.simulate(tmp_path / "run.csv").channels["x0"]["fit_percent"] > 90.0
    with pytest.raises(lacuna.LacunaError, match="expected a model of equations"):
        lacuna.diagnose(model, tmp_path / "run.csv")


def test_autonomous_systems_have_no_inputs():
    states = simulated(lambda z, _: np.array([-z[0], -2.0 * z[1] + z[0]]), np.array([1.0, 0.5]), np.zeros(300))
    fitted = lacuna.Identifier().fit(states + 1e-4 * np.random.default_rng(0).standard_normal(states.shape), t=STEP)
    assert fitted.n_inputs_ == 0
    first, second = states[:100].T
    truth = np.stack([-first, first - 2.0 * second], axis=1)
    assert np.abs(fitted.predict(states[:100]) - truth).max() < 0.05


def test_data_without_noise_are_enough():
    """Gaussian kernels follow a simulator's numbers so far that no noise is left to weigh them by."""

    def lorenz(x):
        return np.array([10 * (x[1] - x[0]), x[0] * (28 - x[2]) - x[1], x[0] * x[1] - 8 / 3 * x[2]]) / 8

    states = simulated(lambda x, _: lorenz(x), np.array([-8.0, 8.0, 27.0]), np.zeros(2000))[::2]
    fitted = lacuna.Identifier().fit(states, t=2 * STEP)
    truth = np.array([lorenz(x) for x in states])
    assert np.abs(fitted.predict(states) - truth).max() < 1e-4 * np.abs(truth).max()


def test_parameters_are_got_set_and_cloned():
    from sklearn.base import clone

    one = lacuna.Identifier(order=2, kernel="gaussian")
    assert one.get_params()["kernel"] == "gaussian" and repr(one) == "Identifier(order=2, kernel='gaussian')"
    assert clone(one).get_params() == one.get_params()
    assert one.set_params(order=1).order == 1
    with pytest.raises(ValueError, match="Invalid parameter 'odrer'"):
        one.set_params(odrer=1)
    for params, words in [
        ({"kernel": "square"}, "kernel is"),
        ({"input_hold": "cubic"}, "input_hold is"),
        ({"order": 3}, "order of the dynamics must be 1 or 2"),
    ]:
        with pytest.raises(lacuna.LacunaError, match=words):
            lacuna.Identifier(**params).fit(np.random.default_rng(0).standard_normal((50, 1)))


def test_it_pickles(fitted):
    again = pickle.loads(pickle.dumps(fitted))
    states = grid()
    assert np.array_equal(again.predict(states), fitted.predict(states))
    assert np.allclose(again.drift(states, return_std=True)[1], fitted.drift(states, return_std=True)[1])
    assert again.report_ == fitted.report_ and again.get_params() == fitted.get_params()


def test_what_is_no_trajectory_is_refused(fitted):
    x, u, t = pendulum(1)
    for call, words in [
        (lambda: fitted.predict(x[:, :1]), "expecting 2 features"),
        (lambda: fitted.predict(x, u[:-1]), r"U: expected shape \(400, 1\)"),
        (lambda: fitted.score(x, u, t), "expecting 1 features"),
        (lambda: fitted.score(x[:50, :1], u[:50], t[:50]), "50 samples are too few"),
        (lambda: lacuna.Identifier().fit(x, u[:-1], t), "inconsistent numbers of samples"),
        (lambda: lacuna.Identifier().fit(x, u, t[::-1]), "increas"),
        (lambda: fitted.simulate(x[0], u), "needs the times"),
    ]:
        with pytest.raises(lacuna.LacunaError, match=words):
            call()
