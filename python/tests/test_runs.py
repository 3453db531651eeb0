"""Simulations, comparisons and checks are the command's."""

import json

import numpy as np
import pytest

import lacuna


@pytest.mark.parametrize("horizon", [None, 1.0])
def test_a_simulation_is_the_commands(case, command, tmp_path, horizon):
    more = [] if horizon is None else ["--horizon", horizon]
    out = tmp_path / "out.csv"
    said = command("simulate", case.model, "--like", case.runs[0], *more, "--out", out, "--json")
    run = lacuna.Model.from_toml(case.model).simulate(case.runs[0], horizon)
    assert run.to_dict() == json.loads(said.stdout)
    written = np.genfromtxt(out, delimiter=",", names=True)
    for name, values in run.series.items():
        assert np.array_equal(values, written[name], equal_nan=True)
    assert repr(run) == command("simulate", case.model, "--like", case.runs[0], *more).stdout


def test_a_comparison_is_the_commands(case, command, tmp_path):
    augmented = case.found / "augmented.toml"
    arguments = ("compare", case.model, augmented, *case.runs[:2])
    said = command(*arguments, "--out", tmp_path / "a", "--json")
    compared = lacuna.compare(case.model, augmented, case.runs[:2])
    assert compared.to_dict() == json.loads(said.stdout)
    assert repr(compared) == command(*arguments).stdout
    assert compared._repr_html_().startswith("<iframe srcdoc=")
    compared.save(tmp_path / "b")
    for name in ("compare.json", "compare.html"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


def test_a_check_is_the_commands(case, command):
    said = command("check", case.model, *case.runs, "--json")
    checked = lacuna.check(case.model, case.runs)
    assert checked.to_dict() == json.loads(said.stdout)
    assert repr(checked) == command("check", case.model, *case.runs).stdout
    assert checked.warnings == checked.to_dict()["warnings"]


def test_times_are_in_the_models_unit_or_their_own(case, tmp_path):
    table = np.genfromtxt(case.runs[0], delimiter=",", names=True)
    run = {name: table[name] for name in table.dtype.names}
    text = case.model.read_text(encoding="utf-8")
    in_ms = tmp_path / "model.toml"
    in_ms.write_text(text.replace("[recordings]\n", '[recordings]\ntime_unit = "ms"\n'), encoding="utf-8")
    late = {**run, "t": 1e3 * run["t"]}
    for model, given in (
        (in_ms, late),
        (in_ms, lacuna.Recording(run, units={"t": "s"})),
        (case.model, lacuna.Recording(late, units={"t": "ms"})),
    ):
        rows = lacuna.check(model, [given]).to_dict()["recordings"][0]
        assert rows["to_s"] == pytest.approx(run["t"][-1]) and rows["step_s"] == pytest.approx(run["t"][1] - run["t"][0])
    simulated = lacuna.Model.from_toml(in_ms).simulate(late)
    assert np.allclose(simulated.series["t"], late["t"], rtol=1e-12, atol=0)


def test_models_tell_what_they_are(case):
    model = lacuna.Model.from_toml(case.model)
    assert list(model.states) == ["theta", "omega"] and model.states["omega"] == "rad/s"
    assert list(model.inputs) == ["tau"]
    parameter = next(iter(model.parameters.values()))
    assert parameter.unit and parameter.std >= 0.0
    assert model.to_toml() == case.model.read_text(encoding="utf-8")


ROBOT = """<robot name="pendulum">
  <link name="base"/>
  <link name="rod"><inertial><origin xyz="0 0 -0.5"/><mass value="1"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="hinge" type="continuous"><parent link="base"/><child link="rod"/><axis xyz="0 1 0"/></joint>
</robot>"""


def test_robots_are_models(tmp_path):
    urdf = tmp_path / "pendulum.urdf"
    urdf.write_text(ROBOT)
    model = lacuna.Model.from_urdf(urdf)
    assert list(model.inputs) == ["hinge_torque"] and "rod.mass" in model.parameters
    mjcf = tmp_path / "pendulum.xml"
    mjcf.write_text(
        '<mujoco><worldbody><body name="rod"><joint name="hinge" type="hinge" axis="0 1 0"/>'
        '<geom type="capsule" fromto="0 0 0 0 0 -1" size="0.05" mass="1"/></body></worldbody></mujoco>'
    )
    assert list(lacuna.Model.from_mjcf(mjcf).states) == ["hinge", "hinge_vel"]


def test_a_recording_says_whether_a_servo_is_told_where_to_be(tmp_path):
    mjcf = tmp_path / "servo.xml"
    mjcf.write_text(
        '<mujoco><worldbody><body name="rod"><joint name="hinge" type="hinge" axis="0 1 0"/>'
        '<geom type="capsule" fromto="0 0 0 0 0 -1" size="0.05" mass="1"/></body></worldbody>'
        '<actuator><position joint="hinge" kp="30" kv="2"/></actuator></mujoco>'
    )
    commanded = {"t": np.arange(5.0), "hinge": np.zeros(5), "hinge_command": np.zeros(5)}
    model = lacuna.Model.from_mjcf(mjcf, like=commanded)
    assert list(model.inputs) == ["hinge_command"]
    assert (model.parameters["hinge.kp"].value, model.parameters["hinge.kd"].value) == (30.0, 2.0)
    for like in (None, {**commanded, "hinge_torque": np.zeros(5)}):
        assert list(lacuna.Model.from_mjcf(mjcf, like=like).inputs) == ["hinge_torque"]
