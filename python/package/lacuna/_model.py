"""Models: what a simulator believes of a machine."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import _lacuna
from ._equations import Equations
from ._lacuna import LacunaError
from ._points import some_points
from ._recording import Recording, as_recordings

if TYPE_CHECKING:
    from ._robot import Robot
    from ._runs import Simulation

#: A function of states ``(batch, 2 n + s)``, inputs ``(batch, m)``, parameters ``(batch, k)`` and times
#: ``(batch,)``.
Function = Callable[..., Any]


@dataclass(frozen=True)
class Parameter:
    """A parameter of a model, and the standard deviation of what is believed of it."""

    value: float
    std: float
    unit: str


class Model:
    """What is believed of a machine; made by `from_toml`, `from_urdf`, `from_mjcf`, `from_mujoco`,
    `from_function` or `from_json`."""

    def __init__(self, own: _lacuna.Model, robot: Robot | None = None) -> None:
        self._own = own
        self._robot = robot

    def _for(self, recordings: Iterable[Recording]) -> _lacuna.Model:
        """The model that stands for it on recordings."""
        if self._robot is not None and self._robot.moves_freely(recordings):
            return self._robot.model
        return self._own

    @classmethod
    def from_toml(cls, path: str | os.PathLike[str]) -> Model:
        """Read a model file of equations, or one that names a robot's own file.

        Parameters
        ----------
        path : path
            The TOML file.

        Raises
        ------
        LacunaError
            With the file, line and column, and what was expected there.
        """
        return cls(_lacuna.Model.read(path))

    @classmethod
    def from_urdf(cls, path: str | os.PathLike[str]) -> Model:
        """Read a robot from its URDF, all that it does not say as where a model file does not."""
        return cls(_lacuna.Model.read(path))

    @classmethod
    def from_mjcf(cls, path: str | os.PathLike[str], like: Any = None) -> Model:
        """Read a robot from its MJCF, all that it does not say as where a model file does not.

        Parameters
        ----------
        path : path
            The MJCF.
        like : Recording, or what one is made of, optional
            One of the recordings that the model is for: a joint that a ``<position>`` actuator drives follows its command
            where this holds ``JOINT_command`` and no ``JOINT_torque``. Without, torques drive all joints.
        """
        return cls(_lacuna.Model.read(path, None if like is None else as_recordings(like)[0]._own))

    @classmethod
    def from_fmu(cls, path: str | os.PathLike[str]) -> Model:
        """Take an FMU for the simulator: FMI 2.0 or 3.0, for model exchange.

        States whose derivative is another state are coordinates, the others first-order states. It gives no mass
        matrix, so effects that are found on coordinates are accelerations. All parameters are known exactly; what may be
        calibrated a model file says that names the FMU (``[fmu] file = "plant.fmu"``, read with `from_toml`).

        An FMU is foreign code: its library runs in processes of their own, with all that you may do. Open none
        that you would not run.

        Raises
        ------
        LacunaError
            An archive that is damaged or is no FMU, one that has events or is for co-simulation alone, no library for
            this platform, or one that does not run.
        """
        return cls(_lacuna.Model.read(path))

    @classmethod
    def from_json(cls, path: str | os.PathLike[str]) -> Model:
        """Read a model that was identified (``lacuna identify``, `Identifier.save`): it can be simulated and
        compared."""
        return cls(_lacuna.Model.read_any(path))

    @classmethod
    def from_function(
        cls,
        rates: Function,
        *,
        coordinates: Mapping[str, tuple[str, str] | tuple[str, str, str]] | None = None,
        states: Mapping[str, str] | None = None,
        inputs: Mapping[str, str] | None = None,
        parameters: Mapping[str, Any] | None = None,
        mass: Function | None = None,
        measurements: Mapping[str, tuple[str, str]] | None = None,
        name: str = "model",
        time: str = "t",
        input_hold: str = "zero-order",
        as_equations: bool = True,
    ) -> Model:
        """Take a function for the equations of motion.

        With n coordinates q, velocities v, s first-order states x, m inputs u and k parameters p it is called as
        ``rates(z, u, p, t)`` with arrays of one row a point: states ``(batch, 2 n + s)`` in the order (q, v, x),
        inputs ``(batch, m)``, parameters ``(batch, k)`` and times ``(batch,)``, each in the order in which they are
        declared. It depends on nothing else. It gives n accelerations and s rates: an array ``(batch, n + s)``, or
        a tuple of n + s arrays ``(batch,)``.

        The function says nothing of inertia, so effects that are found are accelerations; with `mass` they are
        forces.

        A function of nothing but arithmetic and NumPy's elementary functions (``sin``, ``tanh``, ``maximum`` ...) is
        read as equations, by calling it with symbols in the place of numbers, and checked against itself: then a
        diagnosis is that of a model file, with exact derivatives. Any other (it branches on numbers, looks up a
        table, solves, writes into arrays of numbers) is called for every step of every simulation. Its derivatives
        are differences, all those at a point by one call, and a diagnosis says how large their error was; it takes
        tens of times as long.

        Parameters
        ----------
        rates : callable
            Accelerations and rates; with `mass` generalised forces and rates.
        coordinates : mapping, optional
            Of every second-order coordinate the name of its velocity and its unit, and perhaps the unit of its
            force: ``{"theta": ("omega", "rad")}``.
        states : mapping, optional
            Unit of every first-order state.
        inputs : mapping, optional
            Unit of every input.
        parameters : mapping, optional
            Of every parameter its value, or ``{"value": 0.12, "unit": "kg m^2", "tolerance": 0.1}`` with the
            standard deviation of what is believed, relative (`tolerance`) or in the unit (`std`); 0 or absent is
            known exactly.
        mass : callable, optional
            The mass matrix ``(batch, n, n)``, called as `rates` is.
        measurements : mapping, optional
            Of columns that are not called as what they measure, what they measure and their unit:
            ``{"angle_deg": ("theta", "deg")}``.
        name : str
            What results call the model.
        time : str
            Column of time in recordings.
        input_hold : {"zero-order", "linear", "band-limited"}
            What inputs do between samples.
        as_equations : bool
            Whether to read the function as equations where it can be.

        Raises
        ------
        LacunaError
            Names that are none or stand for two things, values out of range, results of another shape.
        """
        second = {key: tuple(value) for key, value in (coordinates or {}).items()}
        first = dict(states or {})
        described = {
            "name": name,
            "coordinates": [(key, *(*value, None)[:3]) for key, value in second.items()],
            "states": list(first.items()),
            "inputs": list((inputs or {}).items()),
            "parameters": [_parameter(key, value) for key, value in (parameters or {}).items()],
            "measurements": [(key, *value) for key, value in (measurements or {}).items()],
            "time": time,
            "input_hold": input_hold,
        }
        n = len(second)
        batched = _batched(rates, "rates", (n + len(first),))
        weighed = None if mass is None else _batched(mass, "mass", (n, n))
        own = _lacuna.Model.from_function(batched, weighed, described)
        return cls((as_equations and _as_equations(own, batched, weighed, described)) or own)

    @classmethod
    def from_mujoco(
        cls,
        model: Any,
        *,
        inputs: str = "joints",
        parameters: Iterable[str] | Mapping[str, Any] = (),
        tolerance: Mapping[str, float] | None = None,
        locked: Iterable[str] | Mapping[str, float] = (),
        measurements: Mapping[str, tuple[str, str]] | None = None,
        name: str = "mujoco",
        time: str = "t",
        input_hold: str = "zero-order",
        as_robot: bool = True,
    ) -> Model:
        """Take MuJoCo itself for the simulator, its contacts, stops and tendons included.

        Where the model is nothing but rigid bodies (its forces are those of such bodies at drawn places, to nine
        digits), and where the recordings go nothing touches, is at its stop or is held by another constraint, it is read
        as the robot that it is, as `from_mjcf` reads a file: the same mechanics with exact derivatives, a hundred
        times as fast, dry friction of joints as a smooth law, and links and the base among what may be missing
        (``payload``, ``base_tilt``). Everything else is asked of MuJoCo.

        Coordinates are called as its joints (hinges and slides), velocities ``JOINT_vel``. Integrated is the continuous
        dynamics of ``mj_forward``, by steps that the recordings ask for; the model's own time step and integrator
        play no part.

        Where MuJoCo is asked, what is found acts as a generalised force beside MuJoCo's own, with MuJoCo's mass matrix,
        and nothing is found of links and the base. The forces of constraints (contacts, stops, dry friction that is
        soft as ``solreffriction`` says) are those that MuJoCo's solver finds without it: what it adds while a contact
        or a dry joint holds the machine still is not held. Derivatives are differences, and MuJoCo is called for
        every step of every simulation: a diagnosis takes minutes in the place of seconds. Keep recordings short then,
        and say what is looked for (``only``).

        Parameters
        ----------
        model : mujoco.MjModel
            It is copied and not changed.
        inputs : {"joints", "actuators"}
            What is recorded: the forces on the joints (``JOINT_torque``, of a slide ``JOINT_force``), applied by
            ``qfrc_applied`` in place of the actuators; or the commands of the actuators by their names (``ctrl``).
        parameters : names, or mapping, optional
            What may be calibrated: ``JOINT.damping``, ``JOINT.friction`` (``frictionloss``), ``JOINT.armature``,
            ``JOINT.stiffness``, ``BODY.mass``, ``BODY.com_x`` to ``BODY.com_z`` (where MuJoCo has the body's
            centre) and ``BODY.inertia_xx`` to ``BODY.inertia_zz`` (about the centre, along the axes of the body's
            frame), with what is believed of it: ``{"forearm.mass": {"tolerance": 0.05}}``; the value is the model's
            where none is given. All others are known exactly.
        tolerance : mapping, optional
            How sure all bodies that move are: the standard deviation of ``"mass"`` and ``"inertia"``, relative, and of
            ``"com"``, in metres: ``{"mass": 0.05, "com": 0.01, "inertia": 0.1}``.
        locked : names, or mapping of name to position, optional
            Joints that are held still, at their place in the model or at this position.
        measurements, name, time, input_hold
            As of `from_function`.
        as_robot : bool
            Whether to read the model as a robot where it is one.

        Raises
        ------
        LacunaError
            No such joint, body or parameter; joints that are neither hinges nor slides and not locked.
        """
        from ._mujoco import Machine, Simulator
        from ._robot import Robot

        machine = Machine(model, inputs, locked)
        given = parameters if isinstance(parameters, Mapping) else {key: {} for key in parameters}
        named = {key: said if isinstance(said, Mapping) else {"value": said} for key, said in given.items()}
        unsure = machine.unsure(tolerance or {})
        places = {key: machine.place(key) for key in {**unsure, **named}}
        believed = {}
        for key, place in places.items():
            said = named.get(key, {})
            of_all = {} if {"tolerance", "std"} & set(said) or key not in unsure else {"std": unsure[key]}
            believed[key] = {"value": place.value, "unit": place.unit, **of_all, **said}
        described = {
            "name": name,
            "coordinates": [(j.name, f"{j.name}_vel", j.units["q"], j.units["force"]) for j in machine.joints],
            "states": [],
            "inputs": list(machine.inputs().items()),
            "parameters": [_parameter(key, value) for key, value in believed.items()],
            "measurements": [(key, *value) for key, value in (measurements or {}).items()],
            "time": time,
            "input_hold": input_hold,
        }
        own = _lacuna.Model.from_simulator(Simulator(machine, list(places.values())), described)
        return cls(own, Robot.of(machine, places, described, own) if as_robot else None)

    @property
    def name(self) -> str:
        """Its name."""
        return self._own.name

    @property
    def parameters(self) -> dict[str, Parameter]:
        """Parameters by name."""
        return {name: Parameter(value, std, unit) for name, value, unit, std in self._own.parameters}

    @property
    def inputs(self) -> dict[str, str]:
        """Unit of every input."""
        return dict(self._own.inputs)

    @property
    def states(self) -> dict[str, str]:
        """Unit of every coordinate, velocity and first-order state, in this order."""
        return dict(self._own.states)

    @property
    def effects(self) -> list[tuple[str, str]]:
        """Effects of the catalogue in it: class and channel."""
        return self._own.effects

    def to_toml(self) -> str:
        """The model as text. The equations of a function are no text: then its parameters and effects."""
        return self._own.text()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write `to_toml` to a file."""
        Path(path).write_text(self.to_toml(), encoding="utf-8")

    def simulate(
        self, recording: Any, horizon: float | None = None, warmup: int = 50
    ) -> Simulation:
        """Run it on a recording's inputs: see `lacuna.simulate`."""
        from ._runs import simulate

        return simulate(self, recording, horizon, warmup)

    def __repr__(self) -> str:
        states, inputs = ", ".join(self.states), ", ".join(self.inputs)
        effects = "".join(f", {of} on {channel}" for of, channel in self.effects)
        return f"<Model {self.name}: {states}; driven by {inputs or 'nothing'}{effects}>"


def as_model(model: Any) -> Model:
    """All that may stand for a model: one, or the path of its file."""
    return model if isinstance(model, Model) else Model.from_json(model)


def _parameter(name: str, said: Any) -> tuple[str, float, str, float | None, float | None]:
    if not isinstance(said, Mapping):
        return name, float(said), "", None, None
    unknown = set(said) - {"value", "unit", "tolerance", "std"}
    if unknown or "value" not in said:
        raise LacunaError(
            f"parameter '{name}': expected value, unit, tolerance or std; found {', '.join(map(str, said))}"
        )
    return name, said["value"], said.get("unit", ""), said.get("tolerance"), said.get("std")


def _batched(function: Function, what: str, shape: tuple[int, ...]) -> Function:
    """The function, what it gives brought into the shape that is expected, or refused."""

    def call(
        z: npt.NDArray[np.float64],
        u: npt.NDArray[np.float64],
        p: npt.NDArray[np.float64],
        t: npt.NDArray[np.float64],
    ) -> npt.NDArray[np.float64]:
        given = function(z, u, p, t)
        expected = (len(t), *shape)
        if isinstance(given, tuple):
            given = np.stack([np.broadcast_to(one, len(t)) for one in given], axis=-1)
        # Symbols stay what they are.
        values = np.require(given, object if z.dtype == object else np.float64, ["C", "A", "E"])
        if values.shape != expected:
            raise LacunaError(
                f"{what} must give an array of shape {expected}, a row for each of {len(t)} points; found "
                f"{values.shape}"
            )
        return values

    return call


def _as_equations(
    own: _lacuna.Model, rates: Function, mass: Function | None, described: dict[str, Any]
) -> _lacuna.Model | None:
    """The same model as equations; none where the functions are no such, or these are not the same."""
    points = some_points(described, 0.2)
    try:
        text = Equations(described).text(rates, mass, own.force_units)
        equations = _lacuna.Model.of_text(text, described["name"])
        with np.errstate(all="ignore"):
            one, other = own.rates(*points), equations.rates(*points)
    except Exception:
        # Whatever a function makes of symbols, or of the points: it stays a function.
        return None
    return equations if np.allclose(one, other, rtol=1e-9, atol=1e-12, equal_nan=True) else None
