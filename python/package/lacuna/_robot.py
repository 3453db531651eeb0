"""A MuJoCo model as the robot that it is, where it is one: rigid bodies, and what their joints state.

Contacts, stops and all else that MuJoCo's solver finds are no part of that. They are none of the machine either where
the recordings do not go. The dry friction of a joint (``frictionloss``), a soft constraint there, is the smooth law
that it is in a robot's file.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np

from . import _lacuna
from ._mujoco import OF_DOF, Joint, Machine, Place, Simulator
from ._points import some_points
from ._recording import Recording
from ._toml import parameter, quoted, recordings

#: Greatest difference between the two, of the largest of a place's masses and forces.
ALIKE = 1e-9


class Robot:
    """A MuJoCo model that is a robot, where nothing touches."""

    def __init__(self, model: _lacuna.Model, machine: Machine) -> None:
        self.model = model
        self._machine = machine
        self._holds = _holds(machine.model)

    @classmethod
    def of(
        cls, machine: Machine, places: dict[str, Place], described: dict[str, Any], own: _lacuna.Model
    ) -> Robot | None:
        """The robot that a model is; none where it is more than that."""
        if machine.by_actuators:
            # What drives it is MuJoCo's.
            return None
        try:
            text = _text(machine, places, described)
            model = _lacuna.Model.of_text(text, described["name"])
            alike = _are_alike(model, machine, list(places.values()), described)
        except Exception:
            # Whatever there is in it that no robot's file says: it stays MuJoCo's.
            return None
        return cls(model, machine) if alike and model.states == own.states and model.inputs == own.inputs else None

    def moves_freely(self, runs: Iterable[Recording]) -> bool:
        """Whether no constraint acts wherever recordings go."""
        return not self._holds or all(self._is_free(run) for run in runs)

    def _is_free(self, run: Recording) -> bool:
        import mujoco

        model, joints = self._machine.model, self._machine.joints
        measured = dict(self.model.positions(run._own))
        if len(measured) < len(joints):
            # Nobody knows where it goes.
            return False
        friction = int(mujoco.mjtConstraint.mjCNSTR_FRICTION_DOF)
        data = mujoco.MjData(model)
        data.qpos[:] = self._machine.home
        paths = np.stack([measured[c] for c in range(len(joints))], axis=1)
        places = [joint.position for joint in joints]
        for q in paths[np.isfinite(paths).all(axis=1)]:
            data.qpos[places] = q
            mujoco.mj_fwdPosition(model, data)
            if (data.efc_type[: data.nefc] != friction).any():
                return False
        return True


def _holds(model: Any) -> bool:
    """Whether anything may hold the machine beside its joints."""
    types, affinities = (np.bitwise_or.reduce(of, initial=0) for of in (model.geom_contype, model.geom_conaffinity))
    touches = bool(types & affinities) or model.npair > 0
    ends = bool(model.jnt_limited.any())
    return touches or ends or model.neq > 0 or model.ntendon > 0 or model.nflex > 0


def _text(machine: Machine, places: dict[str, Place], described: dict[str, Any]) -> str:
    """A model file that holds the robot's own."""
    lines = [f"name = {quoted(described['name'])}", "[robot]", f"text = {_block(_mjcf(machine))}"]
    still = machine.standing_still()
    # What stands still has no numbers in a robot.
    told = {name for name, place in places.items() if _body(machine, place) not in still}
    lines += ["[parameters]", *(parameter(*p) for p in described["parameters"] if p[0] in told)]
    if any(place.is_of_body for place in places.values()):
        # MuJoCo's numbers are those of one body, whatever is fixed to it.
        lines += [
            parameter(f"{name}.mass", float(machine.model.body_mass[body]), "kg", None, None)
            for body, name in _fixed(machine, still)
            if f"{name}.mass" not in told
        ]
    return "\n".join([*lines, *recordings(described)]) + "\n"


def _block(text: str) -> str:
    return f"'''\n{text}'''" if "'''" not in text else quoted(text)


def _body(machine: Machine, place: Place) -> int:
    """The body that a parameter is of: that which a joint moves, where it is one of a joint."""
    if place.is_of_body:
        return place.first
    of_joint = machine.model.dof_bodyid if place.array in OF_DOF.values() else machine.model.jnt_bodyid
    return int(of_joint[place.first])


def _fixed(machine: Machine, still: set[int]) -> list[tuple[int, str]]:
    """The bodies that are a part of another that moves."""
    bodies = range(1, machine.model.nbody)
    return [(b, machine.model.body(b).name) for b in bodies if b not in still and not machine.joints_of(b)]


def _mjcf(machine: Machine) -> str:
    """The bodies and the joints that move as an MJCF, held joints being where they are held."""
    import mujoco

    model = machine.model
    data = mujoco.MjData(model)
    data.qpos[:] = machine.home
    mujoco.mj_kinematics(model, data)
    still = machine.standing_still()
    inside = [""] * model.nbody
    # Those that hang from a body come after it.
    for body in range(model.nbody - 1, 0, -1):
        own = [_joint(model, data, body, joint) for joint in machine.joints_of(body)]
        own += [] if body in still else [_inertial(model, body)]
        parent = int(model.body_parentid[body])
        back = data.xmat[parent].reshape(3, 3).T
        place, turn, away = back @ (data.xpos[body] - data.xpos[parent]), np.zeros(4), np.zeros(4)
        mujoco.mju_negQuat(away, data.xquat[parent])
        mujoco.mju_mulQuat(turn, away, data.xquat[body])
        head = _element("body", name=model.body(body).name, pos=place, quat=turn)
        inside[parent] = f"{head}>\n{''.join(own)}{inside[body]}</body>\n{inside[parent]}"
    falls = not model.opt.disableflags & int(mujoco.mjtDisableBit.mjDSBL_GRAVITY)
    gravity = _element("option", gravity=model.opt.gravity if falls else np.zeros(3))
    compiler = _element("compiler", angle="radian")
    return f"<mujoco>\n{compiler}/>\n{gravity}/>\n<worldbody>\n{inside[0]}</worldbody>\n</mujoco>\n"


def _joint(model: Any, data: Any, body: int, joint: Joint) -> str:
    number, back = model.joint(joint.name).id, data.xmat[body].reshape(3, 3).T
    kinds = {"rad": "hinge", "m": "slide"}
    said = _element(
        "joint",
        name=joint.name,
        type=kinds[joint.units["q"]],
        axis=back @ data.xaxis[number],
        pos=back @ (data.xanchor[number] - data.xpos[body]),
        ref=model.qpos0[joint.position],
        damping=model.dof_damping[joint.dof],
        frictionloss=model.dof_frictionloss[joint.dof],
        armature=model.dof_armature[joint.dof],
        stiffness=model.jnt_stiffness[number],
        springref=model.qpos_spring[joint.position],
    )
    return f"{said}/>\n"


def _inertial(model: Any, body: int) -> str:
    said = _element(
        "inertial",
        pos=model.body_ipos[body],
        quat=model.body_iquat[body],
        mass=model.body_mass[body],
        diaginertia=model.body_inertia[body],
    )
    return f"{said}/>\n"


def _element(tag: str, **attributes: Any) -> str:
    """The beginning of an element."""
    texts = {key: value if isinstance(value, str) else _numbers(value) for key, value in attributes.items()}
    return f"<{tag}" + "".join(f" {key}={quoteattr(text)}" for key, text in texts.items() if text)


def _numbers(values: Any) -> str:
    return " ".join(repr(float(x)) for x in np.ravel(values))


def _are_alike(model: _lacuna.Model, machine: Machine, places: list[Place], described: dict[str, Any]) -> bool:
    """Whether masses and forces are MuJoCo's, its constraints apart, at some places."""
    # Masses and moments stay such as bodies can have.
    z, u, p, t = some_points(described, 0.05)
    centres = [place.array == "body_ipos" for place in places]
    p[:, centres] += 0.01 * np.random.default_rng(1).standard_normal((len(p), sum(centres)))
    theirs = Simulator(machine.without_constraints(), places)(z, u, p, t)
    all_of_it = np.tile([value for _, value, _, _ in model.parameters], (len(p), 1))
    numbers = {name: k for k, (name, _, _, _) in enumerate(model.parameters)}
    for column, (name, *_) in zip(p.T, described["parameters"]):
        if name in numbers:
            all_of_it[:, numbers[name]] = column
    for joint in machine.joints:
        all_of_it[:, numbers[f"{joint.name}.friction"]] = 0.0
    off = np.abs(model.rates(z, u, all_of_it, t) - theirs).max(axis=1)
    return bool((off <= ALIKE * np.abs(theirs).max(axis=1)).all())
