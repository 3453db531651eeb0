"""MuJoCo as the simulator: mass matrix and forces of its forward dynamics, a row a point.

With positions q, velocities v and inputs u of the joints that move

``M(q) v' = passive(q, v) - bias(q, v) + u + constraint(q, v, u)``

each term MuJoCo's own: M of ``mj_fullM``, the forces of ``mj_forward``.
"""

from __future__ import annotations

import copy
import math
import threading
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ._lacuna import LacunaError

Array = npt.NDArray[np.float64]

#: Units of a coordinate, of its force, and of what a file states of its joint.
HINGE = {
    "q": "rad",
    "force": "N m",
    "damping": "N m s/rad",
    "friction": "N m",
    "armature": "kg m^2",
    "stiffness": "N m/rad",
}
SLIDE = {
    "q": "m",
    "force": "N",
    "damping": "N s/m",
    "friction": "N",
    "armature": "kg",
    "stiffness": "N/m",
}
#: What MuJoCo calls a joint's numbers, those of its degree of freedom and those of itself.
OF_DOF = {"damping": "dof_damping", "friction": "dof_frictionloss", "armature": "dof_armature"}
OF_JOINT = {"stiffness": "jnt_stiffness"}
CENTRE = {"com_x": 0, "com_y": 1, "com_z": 2}
#: Inertia about a body's centre along the axes of its frame. MuJoCo has it along its own.
INERTIA = {
    "inertia_xx": (0, 0),
    "inertia_xy": (0, 1),
    "inertia_xz": (0, 2),
    "inertia_yy": (1, 1),
    "inertia_yz": (1, 2),
    "inertia_zz": (2, 2),
}
#: What stands for these in the place of an array of MuJoCo's.
TENSOR = "tensor"
#: Rotor inertia of a joint that is held still: no force moves it.
IMMOBILE = 1e12
#: The solver of constraints goes on until nothing is left to win, so that differences of its forces
#: are not those of where it stopped.
TOLERANCE = 1e-15


@dataclass(frozen=True)
class Joint:
    """A joint that moves: its name and where it stands."""

    name: str
    position: int
    dof: int
    units: Mapping[str, str]

    @property
    def force(self) -> str:
        """Name of the input that acts on it."""
        return f"{self.name}_{'torque' if self.units is HINGE else 'force'}"


@dataclass(frozen=True)
class Place:
    """Where a parameter stands in the model."""

    array: str
    index: int | tuple[int, ...]
    value: float
    unit: str

    @property
    def is_inertial(self) -> bool:
        """Whether constants that MuJoCo derives from the inertia at home change with it."""
        return self.is_of_body or self.array == "dof_armature"

    @property
    def is_of_body(self) -> bool:
        """Whether it is of the inertia of a body."""
        return self.array in ("body_mass", "body_ipos", TENSOR)

    @property
    def first(self) -> int:
        """The number of the body or joint that it is of."""
        return self.index if isinstance(self.index, int) else self.index[0]


class Machine:
    """A MuJoCo model with its joints and inputs by name."""

    def __init__(self, model: Any, inputs: str, locked: Iterable[str] | Mapping[str, float]) -> None:
        import mujoco

        if not isinstance(model, mujoco.MjModel):
            raise LacunaError(f"expected a mujoco.MjModel; found {type(model).__name__}")
        if inputs not in ("joints", "actuators"):
            raise LacunaError(f"inputs is 'joints' or 'actuators'; found {inputs!r}")
        self.model = copy.copy(model)
        self.by_actuators = inputs == "actuators"
        held = dict(locked) if isinstance(locked, Mapping) else dict.fromkeys(locked)
        self.joints = self._joints(mujoco, held)
        self.home = self.model.qpos0.copy()
        self._hold(mujoco, held)
        self.actuators = [self.model.actuator(k).name for k in range(self.model.nu)]
        if self.by_actuators and self.model.na > 0:
            raise LacunaError(
                "the model has actuators with a state of their own (activation); with inputs=\"joints\" the "
                "recorded forces of the joints drive it"
            )
        if not self.by_actuators:
            # Recorded are the forces that act, whatever makes them.
            self.model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_ACTUATION)
        # A point's forces depend on nothing but the point.
        self.model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_WARMSTART)
        self.model.opt.tolerance = TOLERANCE
        mujoco.mj_setConst(self.model, mujoco.MjData(self.model))

    def _joints(self, mujoco: Any, held: Mapping[str, Any]) -> list[Joint]:
        kinds = {mujoco.mjtJoint.mjJNT_HINGE: HINGE, mujoco.mjtJoint.mjJNT_SLIDE: SLIDE}
        all_joints = [self.model.joint(k) for k in range(self.model.njnt)]
        known = [joint.name for joint in all_joints]
        for name in held:
            if name not in known:
                raise LacunaError(f"locked: no joint '{name}'; the joints are {', '.join(known)}")
        moving = []
        for joint in all_joints:
            if joint.name in held:
                continue
            kind = int(joint.type[0])
            if kind not in kinds:
                raise LacunaError(
                    f"joint '{joint.name}' is neither a hinge nor a slide; hold it still by locked=['{joint.name}']"
                )
            moving.append(Joint(joint.name, int(joint.qposadr[0]), int(joint.dofadr[0]), kinds[kind]))
        if not moving:
            raise LacunaError("the model has no joint that moves")
        return moving

    def _hold(self, mujoco: Any, held: Mapping[str, float | None]) -> None:
        for name, at in held.items():
            joint = self.model.joint(name)
            if at is not None:
                if len(joint.qpos0) != 1:
                    raise LacunaError(f"locked: joint '{name}' stays where the model has it; give its name alone")
                self.home[int(joint.qposadr[0])] = at
            first = int(joint.dofadr[0])
            kind = int(joint.type[0])
            dofs = {mujoco.mjtJoint.mjJNT_FREE: 6, mujoco.mjtJoint.mjJNT_BALL: 3}.get(kind, 1)
            self.model.dof_armature[first : first + dofs] = IMMOBILE

    def place(self, name: str) -> Place:
        """Where the parameter of this name stands."""
        of, _, part = name.partition(".")
        joints = {joint.name: joint for joint in self.joints}
        if of in joints and part in OF_DOF:
            return self._place(OF_DOF[part], joints[of].dof, joints[of].units[part])
        if of in joints and part in OF_JOINT:
            return self._place(OF_JOINT[part], self.model.joint(of).id, joints[of].units[part])
        bodies = [self.model.body(k).name for k in range(1, self.model.nbody)]
        if of in bodies and part == "mass":
            return self._place("body_mass", self.model.body(of).id, "kg")
        if of in bodies and part in CENTRE:
            return self._place("body_ipos", (self.model.body(of).id, CENTRE[part]), "m")
        if of in bodies and part in INERTIA:
            body = self.model.body(of).id
            return Place(TENSOR, (body, *INERTIA[part]), float(tensor(self.model, body)[INERTIA[part]]), "kg m^2")
        raise LacunaError(
            f"parameter '{name}': expected JOINT.{', JOINT.'.join({**OF_DOF, **OF_JOINT})}, BODY.mass, "
            f"BODY.{', BODY.'.join({**CENTRE, **INERTIA})}; the joints are {', '.join(joints)}, the bodies "
            f"{', '.join(bodies)}"
        )

    def joints_of(self, body: int) -> list[Joint]:
        """The joints that move a body against its parent."""
        return [joint for joint in self.joints if self.model.dof_bodyid[joint.dof] == body]

    def standing_still(self) -> set[int]:
        """The bodies that no joint moves."""
        still = {0}
        for body in range(1, self.model.nbody):
            if int(self.model.body_parentid[body]) in still and not self.joints_of(body):
                still.add(body)
        return still

    def unsure(self, tolerance: Mapping[str, float]) -> dict[str, float]:
        """Standard deviations of what is believed of all bodies that move; these are relative of mass and inertia, in
        metres of a centre."""
        known: tuple[str, ...] = ("mass", "com", "inertia")
        for of, std in tolerance.items():
            if of not in known:
                raise LacunaError(f"tolerance: expected {', '.join(known)}; found {of}")
            if not (std >= 0.0 and math.isfinite(std)):
                raise LacunaError(f"tolerance: a standard deviation is 0 or more; found {of} = {std}")
        mass, com, inertia = (tolerance.get(of, 0.0) for of in known)
        still, believed = self.standing_still(), dict[str, float]()
        for body in range(1, self.model.nbody):
            if body in still or self.model.body_mass[body] <= 0.0:
                continue
            name, own = self.model.body(body).name, tensor(self.model, body)
            believed[f"{name}.mass"] = mass * float(self.model.body_mass[body])
            believed |= {f"{name}.{part}": com for part in CENTRE}
            of_its_kind = {part: math.sqrt(own[i, i] * own[j, j]) for part, (i, j) in INERTIA.items()}
            believed |= {f"{name}.{part}": inertia * size for part, size in of_its_kind.items()}
        return {name: std for name, std in believed.items() if std > 0.0 and self._matters(name, 0.01 * std)}

    def _matters(self, name: str, by: float) -> bool:
        """Whether it changes anything, wherever the machine is, that a parameter is larger by this: a body that only
        turns about one axis has inertia about that axis alone."""
        place, n = self.place(name), len(self.joints)
        z = np.tile(np.random.default_rng(0).standard_normal(2 * n), (2, 1))
        u, p, t = np.zeros((2, len(self.inputs()))), place.value + np.array([[0.0], [by]]), np.zeros(2)
        one, other = Simulator(self.without_constraints(), [place])(z, u, p, t)
        return bool(np.abs(other - one).max() > 1e-12 * np.abs(one).max())

    def without_constraints(self) -> Machine:
        """The machine where nothing touches, is at its stop or rubs."""
        import mujoco

        loose = copy.copy(self)
        loose.model = copy.copy(self.model)
        loose.model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
        return loose

    def _place(self, array: str, index: int | tuple[int, ...], unit: str) -> Place:
        values = getattr(self.model, array)
        if np.ndim(values[index]) != 0:
            raise LacunaError(f"{array} of this MuJoCo is no single number")
        return Place(array, index, float(values[index]), unit)

    def inputs(self) -> dict[str, str]:
        """Name and unit of every input."""
        if self.by_actuators:
            return dict.fromkeys(self.actuators, "")
        return {joint.force: joint.units["force"] for joint in self.joints}


class Simulator:
    """The forward dynamics of a machine as a function of points."""

    def __init__(self, machine: Machine, places: list[Place]) -> None:
        self.machine = machine
        self.places = places
        self._room = _Room(machine, places)
        # MuJoCo hands the interpreter on whenever it is called: two threads would hand it to and fro at every row.
        self._turn = threading.Lock()

    def __call__(self, z: Array, u: Array, p: Array, t: Array) -> Array:
        """Mass matrix, row-major, and forces, of rows of points."""
        with self._turn:
            try:
                return self._room.evaluate(z, u, p, t)
            except BaseException:
                # It stands between two points.
                self._room = _Room(self.machine, self.places)
                raise


class _Room:
    """A model whose parameters move, and its data."""

    def __init__(self, machine: Machine, places: list[Place]) -> None:
        import mujoco

        self.mujoco = mujoco
        self.model = copy.copy(machine.model)
        self.data = data = mujoco.MjData(self.model)
        self.scratch = mujoco.MjData(self.model)
        data.qpos[:] = machine.home
        self.positions = _entries([joint.position for joint in machine.joints])
        self.dofs = _entries([joint.dof for joint in machine.joints])
        self.count = len(machine.joints)
        # Views, since to ask for them costs as much as the dynamics.
        self.qpos, self.qvel = data.qpos, data.qvel
        self.smooth, self.constraint = data.qfrc_smooth, data.qfrc_constraint
        self.driven = data.ctrl if machine.by_actuators else data.qfrc_applied
        self.entries = slice(None) if machine.by_actuators else self.dofs
        self.tensors = {p.first: tensor(self.model, p.first) for p in places if p.array == TENSOR}
        self.targets = [self._target(place) for place in places]
        self.turned = [place.first if place.array == TENSOR else None for place in places]
        self.inertial = [place.is_inertial for place in places]
        self.parameters = np.array([place.value for place in places])
        self.mass = np.zeros((self.model.nv, self.model.nv))
        self.block = (self.dofs, self.dofs) if isinstance(self.dofs, slice) else np.ix_(self.dofs, self.dofs)
        # MuJoCo before 4 unpacks what it is given.
        self.packed = getattr(data, "qM", None)

    def _target(self, place: Place) -> tuple[Array, int | tuple[int, ...]]:
        if place.array == TENSOR:
            return self.tensors[place.first], place.index[1:] if isinstance(place.index, tuple) else place.index
        return getattr(self.model, place.array), place.index

    def evaluate(self, z: Array, u: Array, p: Array, t: Array) -> Array:
        """Mass matrix and forces of rows of points."""
        # What is not finite shows in the squares.
        if math.isfinite(np.vdot(z, z) + np.vdot(u, u) + np.vdot(p, p)):
            return self._evaluate(z, u, p, t)
        usable = np.isfinite(z).all(axis=1) & np.isfinite(u).all(axis=1) & np.isfinite(p).all(axis=1)
        which = usable[:, np.newaxis]
        given = self._evaluate(np.where(which, z, 0.0), np.where(which, u, 0.0), np.where(which, p, self.parameters), t)
        given[~usable] = np.nan
        return given

    def _evaluate(self, z: Array, u: Array, p: Array, t: Array) -> Array:
        # What is asked of all rows at once is not asked of each, where it costs as much as the dynamics.
        n, model, data, forward = self.count, self.model, self.data, self.mujoco.mj_forwardSkip
        qpos, qvel, driven, smooth, constraint = self.qpos, self.qvel, self.driven, self.smooth, self.constraint
        positions, dofs, entries, block = self.positions, self.dofs, self.entries, self.block
        whole = self.mujoco.mjtStage.mjSTAGE_NONE.value
        without_positions = self.mujoco.mjtStage.mjSTAGE_POS.value
        given, held = np.empty((len(t), n * n + n)), np.empty((len(t), n))
        masses, forces = given[:, : n * n].reshape(-1, n, n), given[:, n * n :]
        changes = self._changes(p)
        stays = self._stays(z, changes)
        rows = zip(z[:, :n], z[:, n:], u, t.tolist(), masses, forces, held, changes, stays, strict=True)
        for q, v, inputs, now, mass, force, holding, changed, same in rows:
            data.time = now
            qvel[dofs] = v
            driven[entries] = inputs
            if same:
                forward(model, data, without_positions, True)
            else:
                if changed:
                    self._bind(changed)
                qpos[positions] = q
                forward(model, data, whole, True)
                self._unpack()
            mass[...] = self.mass[block]
            force[...] = smooth[dofs]
            holding[...] = constraint[dofs]
        forces += held
        return given

    def _changes(self, p: Array) -> list[list[tuple[int, float]]]:
        """The parameters that change from row to row, and to what."""
        if len(p) == 1 and p.tobytes() == self.parameters.tobytes():
            return [[]]
        changes: list[list[tuple[int, float]]] = [[] for _ in p]
        before = np.vstack([self.parameters, p])
        self.parameters = before[-1]
        rows, entries = np.nonzero(before[:-1] != p)
        for row, entry, value in zip(rows.tolist(), entries.tolist(), p[rows, entries].tolist(), strict=True):
            changes[row].append((entry, value))
        return changes

    def _stays(self, z: Array, changes: list[list[tuple[int, float]]]) -> list[bool]:
        """Where positions and parameters are those of the row before: what depends on them alone is kept."""
        if len(z) == 1:
            return [False]
        moved = (z[1:, : self.count] != z[:-1, : self.count]).any(axis=1)
        return [False, *(not (m or c) for m, c in zip(moved.tolist(), changes[1:], strict=True))]

    def _bind(self, changed: list[tuple[int, float]]) -> None:
        for entry, value in changed:
            array, index = self.targets[entry]
            array[index] = value
        for body in {self.turned[entry] for entry, _ in changed}:
            if body is not None:
                self._turn(body)
        if any(self.inertial[entry] for entry, _ in changed):
            self.mujoco.mj_setConst(self.model, self.scratch)

    def _turn(self, body: int) -> None:
        """Inertia along a body's own axes, of which the upper half is given."""
        values, axes = np.linalg.eigh(self.tensors[body], UPLO="U")
        axes[:, 2] *= np.sign(np.linalg.det(axes))
        self.model.body_inertia[body] = values
        self.mujoco.mju_mat2Quat(self.model.body_iquat[body], axes.ravel())

    def _unpack(self) -> None:
        if self.packed is None:
            self.mujoco.mj_fullM(self.model, self.data, self.mass)
        else:
            self.mujoco.mj_fullM(self.model, self.mass, self.packed)


def _entries(indices: list[int]) -> slice | Array:
    """Entries of an array: a slice where they follow one another, which costs less."""
    first, count = indices[0], len(indices)
    if indices == list(range(first, first + count)):
        return slice(first, first + count)
    return np.array(indices)


def tensor(model: Any, body: int) -> Array:
    """Inertia of a body about its centre, along the axes of its frame."""
    import mujoco

    axes = np.zeros(9)
    mujoco.mju_quat2Mat(axes, model.body_iquat[body])
    turned: Array = axes.reshape(3, 3) * model.body_inertia[body] @ axes.reshape(3, 3).T
    return turned
