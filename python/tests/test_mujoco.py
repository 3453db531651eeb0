"""MuJoCo as the simulator, beside the same file read as a robot."""

import numpy as np
import pytest

import lacuna

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed")

ARM = """<mujoco model="arm">
  <option timestep="0.0005" integrator="RK4"/>
  <worldbody>
    <body name="upper" pos="0 0 1">
      <joint name="shoulder" type="hinge" axis="0 1 0" damping="0.05" armature="0.01"/>
      <inertial pos="0.02 0 -0.15" mass="1.2" diaginertia="0.012 0.012 0.002"/>
      <body name="lower" pos="0 0 -0.3">
        <joint name="slider" type="slide" axis="0 0 1" damping="2.0" stiffness="60" range="-0.2 0.2" {limited}/>
        <inertial pos="0 0 -0.1" mass="0.5" diaginertia="0.003 0.003 0.001"/>
        <geom name="tip" type="sphere" size="0.03" pos="0 0 -0.15"/>
      </body>
    </body>
    <geom name="floor" type="plane" size="2 2 0.1" pos="0 0 0.45"/>
  </worldbody>
  <actuator>
    <motor name="turn" joint="shoulder" gear="3"/>
  </actuator>
</mujoco>"""
FREE = ARM.format(limited='limited="false"').replace('pos="0 0 0.45"', 'pos="0 0 -5"')
TOUCHING = ARM.format(limited='limited="true"')

PENDULUM = """<mujoco model="pendulum">
  <option timestep="0.0005" integrator="RK4"/>
  <worldbody>
    <body name="rod">
      <joint name="pivot" type="hinge" axis="0 1 0" damping="0.02"/>
      <inertial pos="0 0 -0.2" mass="0.6" diaginertia="0.004 0.004 0.001"/>
    </body>
  </worldbody>
</mujoco>"""
#: Concealed: dry friction (N m), and its law's speed (rad/s).
FRICTION, SMOOTHING = 0.08, 0.05
STEP, SAMPLES, NOISE = 0.01, 200, 2e-4


def points(model, count):
    rng = np.random.default_rng(7)
    return (
        0.3 * rng.standard_normal((count, len(model.states))),
        rng.standard_normal((count, len(model.inputs))),
        np.tile([p.value for p in model.parameters.values()], (count, 1)).reshape(count, -1),
        np.zeros(count),
    )


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("mujoco") / "arm.xml"
    path.write_text(FREE)
    return path


def test_it_is_the_file_read_as_a_robot(file):
    own, read = lacuna.Model.from_mujoco(mujoco.MjModel.from_xml_path(str(file))), lacuna.Model.from_mjcf(file)
    assert (own.states, own.inputs) == (read.states, read.inputs)
    one, other = own._own.rates(*points(own, 50)), read._own.rates(*points(read, 50))
    assert np.allclose(one, other, rtol=1e-12, atol=1e-12)


def test_contacts_and_stops_are_mujocos(file):
    loose, touching = (mujoco.MjModel.from_xml_string(text) for text in (FREE, TOUCHING))
    model = lacuna.Model.from_mujoco(touching)
    z, u, p, t = points(model, 40)
    # The tip is in the floor, or the slider beyond its range.
    z[:20, :2], z[20:, 1] = (0.0, -0.12), 0.25
    rates = model._own.rates(z, u, p, t)
    data = mujoco.MjData(touching)
    for k, row in enumerate(rates):
        data.qpos[:], data.qvel[:], data.qfrc_applied[:] = z[k, :2], z[k, 2:], u[k]
        mujoco.mj_forward(touching, data)
        assert data.nefc > 0
        acceleration = np.linalg.solve(row[:4].reshape(2, 2), row[4:])
        assert np.allclose(acceleration, data.qacc, rtol=1e-6, atol=1e-6)
    without = lacuna.Model.from_mujoco(loose)._own.rates(z, u, p, t)
    assert (np.abs(rates - without).max(axis=1) > 1.0).all()


def test_actuators_are_driven_by_their_commands(file):
    arm = mujoco.MjModel.from_xml_string(FREE)
    driven, forced = lacuna.Model.from_mujoco(arm, inputs="actuators"), lacuna.Model.from_mujoco(arm)
    assert list(driven.inputs) == ["turn"]
    z, u, p, t = points(driven, 10)
    forces = np.hstack([3.0 * u, 0.0 * u])
    assert np.allclose(driven._own.rates(z, u, p, t), forced._own.rates(z, forces, p, t), rtol=1e-12, atol=1e-12)


def test_parameters_are_the_named_ones(file):
    arm = mujoco.MjModel.from_xml_string(FREE)
    named = {
        "lower.mass": {"tolerance": 0.1},
        "shoulder.damping": {"std": 0.01},
        "shoulder.armature": 0.02,
        "upper.com_x": {},
    }
    model = lacuna.Model.from_mujoco(arm, parameters=named)
    believed = {name: (p.value, round(p.std, 12), p.unit) for name, p in model.parameters.items()}
    assert believed == {
        "lower.mass": (0.5, 0.05, "kg"),
        "shoulder.damping": (0.05, 0.01, "N m s/rad"),
        "shoulder.armature": (0.02, 0.0, "kg m^2"),
        "upper.com_x": (0.02, 0.0, "m"),
    }
    changed = mujoco.MjModel.from_xml_string(FREE)
    changed.body_mass[2], changed.dof_damping[0] = 0.7, 0.3
    changed.dof_armature[0], changed.body_ipos[1, 0] = 0.05, -0.04
    mujoco.mj_setConst(changed, mujoco.MjData(changed))
    z, u, p, t = points(model, 10)
    p[:] = 0.7, 0.3, 0.05, -0.04
    other = lacuna.Model.from_mujoco(changed)
    assert np.allclose(model._own.rates(z, u, p, t), other._own.rates(z, u, p[:, :0], t), rtol=1e-12, atol=1e-12)
    # What was given is not changed.
    assert arm.body_mass[2] == 0.5
    assert '"lower.mass"' in model.to_toml()


def test_locked_joints_stay(file):
    arm = mujoco.MjModel.from_xml_string(FREE)
    model = lacuna.Model.from_mujoco(arm, locked={"slider": 0.1})
    assert list(model.states) == ["shoulder", "shoulder_vel"]
    z, u, p, t = points(model, 10)
    whole = lacuna.Model.from_mujoco(arm)._own.rates(
        np.stack([z[:, 0], 0.1 + 0 * t, z[:, 1], 0 * t], axis=1), np.hstack([u, 0 * u]), p, t
    )
    # Of the mass matrix its first entry, of the forces the first.
    assert np.allclose(model._own.rates(z, u, p, t), whole[:, [0, 4]], rtol=1e-9, atol=1e-12)


def test_what_is_no_such_thing_is_refused():
    arm = mujoco.MjModel.from_xml_string(FREE)
    with pytest.raises(lacuna.LacunaError, match="expected a mujoco.MjModel; found str"):
        lacuna.Model.from_mujoco("arm.xml")
    with pytest.raises(lacuna.LacunaError, match="'lower.density': expected JOINT.damping"):
        lacuna.Model.from_mujoco(arm, parameters=["lower.density"])
    with pytest.raises(lacuna.LacunaError, match="no joint 'wrist'; the joints are shoulder, slider"):
        lacuna.Model.from_mujoco(arm, locked=["wrist"])
    with pytest.raises(lacuna.LacunaError, match="'joints' or 'actuators'"):
        lacuna.Model.from_mujoco(arm, inputs="motors")
    ball = mujoco.MjModel.from_xml_string(FREE.replace('type="hinge" axis="0 1 0"', 'type="ball"'))
    with pytest.raises(lacuna.LacunaError, match=r"locked=\['shoulder'\]"):
        lacuna.Model.from_mujoco(ball)
    assert list(lacuna.Model.from_mujoco(ball, locked=["shoulder"]).inputs) == ["slider_force"]


#: Bodies that are fixed to others and turned, two joints of one body, a reference, a spring, and what is held still.
LIMB = """<mujoco model="limb">
  <compiler angle="radian"/>
  <option gravity="0.4 0 -9.7"/>
  <worldbody>
    <body name="stand" pos="0 0.1 0.4" euler="0.1 0 0.3">
      <inertial pos="0 0 0" mass="5" diaginertia="0.1 0.1 0.1"/>
      <body name="upper" pos="0.1 0 0.2" euler="0.2 -0.4 0.1">
        <joint name="lift" type="slide" axis="0.1 0 1" ref="0.05" damping="3"/>
        <joint name="turn" type="hinge" axis="0 1 0.2" pos="0.01 0 0.03" armature="0.01" range="-1 1" limited="true"/>
        <inertial pos="0.02 0.01 -0.15" mass="1.2" fullinertia="0.012 0.011 0.003 0.001 -0.0005 0.0002"/>
        <body name="plate" pos="0 0.03 -0.1" euler="0.5 0.2 -0.3">
          <inertial pos="0.01 0 0.02" mass="0.3" fullinertia="0.002 0.003 0.002 0.0002 0 0.0001"/>
        </body>
        <body name="lower" pos="0 0 -0.3">
          <joint name="bend" type="hinge" axis="1 0 0" stiffness="2" springref="0.2" frictionloss="0.3"/>
          <inertial pos="0 0 -0.1" mass="0.5" diaginertia="0.003 0.003 0.001"/>
          <body name="hand" pos="0 0 -0.2">
            <joint name="grip" type="hinge" axis="0 1 0" pos="0 0 0.02"/>
            <inertial pos="0 0.02 -0.03" mass="0.1" diaginertia="0.0003 0.0002 0.0001"/>
            <geom name="palm" type="sphere" size="0.02"/>
          </body>
        </body>
      </body>
    </body>
    <geom name="floor" type="plane" size="2 2 0.1" pos="0 0 -0.4"/>
  </worldbody>
</mujoco>"""
LOOSE = {
    "upper.mass": {"tolerance": 0.1},
    "plate.com_x": {"std": 0.01},
    "plate.inertia_xy": {"std": 1e-4},
    "hand.mass": {"tolerance": 0.1},
    "stand.mass": {"tolerance": 0.1},
    "bend.stiffness": {"std": 0.5},
    "lift.damping": {"std": 0.5},
}


def limb(**said):
    return lacuna.Model.from_mujoco(mujoco.MjModel.from_xml_string(LIMB), locked={"grip": 0.4}, **said)


def test_what_is_a_robot_is_read_as_one():
    model = limb(parameters=LOOSE)
    robot = model._robot.model
    assert (robot.states, robot.inputs) == (model._own.states, model._own.inputs)
    stated = {name: (value, unit, std) for name, value, unit, std in robot.parameters}
    for name, parameter in model.parameters.items():
        if name != "stand.mass":
            assert stated[name] == (parameter.value, parameter.unit, parameter.std)
    assert "stand.mass" not in stated
    # MuJoCo's own, at other numbers than the file's, but for its dry friction, its stop and its floor.
    z, u, _, t = points(model, 30)
    scale = np.random.default_rng(3).uniform(0.9, 1.1, (30, len(LOOSE)))
    p = scale * [parameter.value for parameter in model.parameters.values()]
    numbers = np.tile([value for _, value, _, _ in robot.parameters], (30, 1))
    for k, (name, *_) in enumerate(robot.parameters):
        if name in model.parameters:
            numbers[:, k] = p[:, list(model.parameters).index(name)]
        elif name.endswith(".friction"):
            numbers[:, k] = 0.0
    loose = LIMB.replace('frictionloss="0.3"', "").replace('limited="true"', 'limited="false"')
    loose = loose.replace("<geom ", '<geom contype="0" ')
    theirs = lacuna.Model.from_mujoco(
        mujoco.MjModel.from_xml_string(loose), parameters=LOOSE, locked={"grip": 0.4}, as_robot=False
    )
    assert theirs._robot is None
    one, other = robot.rates(z, u, numbers, t), theirs._own.rates(z, u, p, t)
    assert np.allclose(one, other, rtol=1e-9, atol=1e-9)


def test_inertia_is_told_along_the_axes_of_the_body():
    model = limb(parameters=["upper.inertia_xx", "upper.inertia_yz"], as_robot=False)
    values = [p.value for p in model.parameters.values()]
    assert np.allclose(values, [0.012, 0.0002], rtol=1e-12)
    z, u, p, t = points(model, 10)
    p[:] = 0.0125, 0.0011
    turned = LIMB.replace(
        'fullinertia="0.012 0.011 0.003 0.001 -0.0005 0.0002"', 'fullinertia="0.0125 0.011 0.003 0.001 -0.0005 0.0011"'
    )
    other = lacuna.Model.from_mujoco(mujoco.MjModel.from_xml_string(turned), locked={"grip": 0.4}, as_robot=False)
    assert np.allclose(model._own.rates(z, u, p, t), other._own.rates(z, u, p[:, :0], t), rtol=1e-9, atol=1e-9)


def test_all_bodies_that_move_may_be_unsure():
    model = limb(tolerance={"mass": 0.05, "com": 0.01, "inertia": 0.1}, parameters={"hand.mass": {"std": 0.03}})
    unsure = {name: p.std for name, p in model.parameters.items()}
    assert not any(name.startswith("stand") for name in unsure)
    assert np.isclose(unsure["upper.mass"], 0.06) and unsure["plate.com_y"] == 0.01 and unsure["hand.mass"] == 0.03
    assert np.isclose(unsure["upper.inertia_yz"], 0.1 * np.sqrt(0.011 * 0.003))
    # It turns about one axis, which stands in its y-z plane.
    assert "upper.inertia_xx" not in unsure and "upper.inertia_xy" not in unsure
    # The pendulum turns about y.
    pendulum = lacuna.Model.from_mujoco(
        mujoco.MjModel.from_xml_string(PENDULUM), tolerance={"mass": 0.05, "inertia": 0.1}
    )
    assert set(pendulum.parameters) == {"rod.mass", "rod.inertia_yy"}
    with pytest.raises(lacuna.LacunaError, match="expected mass, com, inertia; found weight"):
        limb(tolerance={"weight": 0.1})
    with pytest.raises(lacuna.LacunaError, match="0 or more"):
        limb(tolerance={"mass": -0.1})


def test_where_something_touches_mujoco_is_asked():
    model = limb()
    swing = np.sin(np.linspace(0.0, 6.0, 200))
    free = {"t": 0.01 * np.arange(200), "lift": 0.05 * swing, "turn": 0.5 * swing, "bend": 0.3 * swing}
    free |= {name: 0.0 * swing for name in model.inputs}

    def stands_for_it(columns):
        return model._for([lacuna.Recording(columns)]) is model._robot.model

    assert stands_for_it(free)
    # Beyond a stop, on the floor, and where nobody knows.
    assert not stands_for_it({**free, "turn": 1.5 * swing})
    assert not stands_for_it({**free, "lift": swing})
    assert not stands_for_it({name: values for name, values in free.items() if name != "bend"})
    degrees = lacuna.Recording({**free, "turn": 1.5 * swing}, units={"turn": "deg"})
    assert model._for([degrees]) is model._robot.model
    assert model._for([lacuna.Recording(free), lacuna.Recording({**free, "lift": swing})]) is model._own


def test_what_is_more_than_a_robot_is_none():
    tied = LIMB.replace(
        "</mujoco>", '<tendon><fixed name="tie" stiffness="30"><joint joint="turn" coef="1"/></fixed></tendon></mujoco>'
    )
    wet = LIMB.replace("<option ", '<option density="1000" ')
    for text in (tied, wet):
        assert lacuna.Model.from_mujoco(mujoco.MjModel.from_xml_string(text))._robot is None
    driven = ARM.format(limited="")
    assert lacuna.Model.from_mujoco(mujoco.MjModel.from_xml_string(driven), inputs="actuators")._robot is None


def recording(rng):
    """The true pendulum in MuJoCo, its torque held between samples."""
    machine = mujoco.MjModel.from_xml_string(PENDULUM)
    data = mujoco.MjData(machine)
    data.qpos[0] = 0.3
    t = STEP * np.arange(SAMPLES)
    waves = [rng.uniform(0.1, 0.3) * np.sin(rng.uniform(0.5, 6.0) * t + rng.uniform(0.0, 6.3)) for _ in range(4)]
    torque, pivot = sum(waves), []
    for applied in torque:
        pivot.append(data.qpos[0])
        for _ in range(round(STEP / machine.opt.timestep)):
            data.qfrc_applied[0] = applied - FRICTION * np.tanh(data.qvel[0] / SMOOTHING)
            mujoco.mj_step(machine, data)
    return {"t": t, "pivot_torque": torque, "pivot": np.array(pivot) + NOISE * rng.standard_normal(SAMPLES)}


@pytest.fixture
def pendulum(tmp_path):
    """What is believed of it, as MuJoCo has it and as a file, and what was recorded."""
    rng = np.random.default_rng(17)
    file = tmp_path / "pendulum.xml"
    file.write_text(PENDULUM)
    return mujoco.MjModel.from_xml_string(PENDULUM), file, [recording(rng) for _ in range(2)]


def test_the_same_is_named_as_with_the_file(pendulum):
    believed, file, runs = pendulum
    looked_for = ["coulomb_friction", "viscous_friction", "constant_force"]
    models = [lacuna.Model.from_mujoco(believed, as_robot=False), lacuna.Model.from_mjcf(file)]
    found = [lacuna.diagnose(model, runs, only=looked_for) for model in models]
    for diagnosis in found:
        (finding,) = diagnosis.findings
        assert (finding.effect, finding.channel) == ("coulomb_friction", "pivot")
        magnitude = finding.parameters["magnitude"]
        assert magnitude.unit == "N m"
        assert abs(magnitude.value - FRICTION) < 4 * magnitude.std + 0.05 * FRICTION
    assert any("differences" in note for note in found[0].notes)


def test_a_robot_is_diagnosed_as_its_file_is(pendulum, tmp_path):
    believed, file, runs = pendulum
    own, read = (lacuna.diagnose(m, runs) for m in (lacuna.Model.from_mujoco(believed), lacuna.Model.from_mjcf(file)))
    assert [(f.effect, f.channel) for f in own.findings] == [("coulomb_friction", "pivot")]
    for one, other in zip(own.findings, read.findings, strict=True):
        assert (one.effect, one.channel) == (other.effect, other.channel)
        magnitudes = [f.parameters["magnitude"].value for f in (one, other)]
        assert np.isclose(*magnitudes, rtol=1e-6)
    # What was found stands in a model that says all of it, and in a robot's file that MuJoCo reads.
    own.save(tmp_path / "found")
    augmented = lacuna.Model.from_toml(tmp_path / "found" / "augmented.toml")
    assert augmented.effects == [("coulomb_friction", "pivot")]
    written = mujoco.MjModel.from_xml_path(str(tmp_path / "found" / "augmented.xml"))
    assert np.isclose(written.dof_frictionloss[0], FRICTION, rtol=0.1)
