"""The solid bodies of a run, as a program sees and moves them."""

from __future__ import annotations

import operator
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, Union

import numpy as np

if TYPE_CHECKING:
    from .simulation import Simulation

Vector = Union[Sequence[float], np.ndarray]


def _vector(name: str, value: Vector, parts: str = "x y z") -> list[float]:
    try:
        numbers = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        raise ValueError(f"{name}: needs numbers, this is {value!r}") from None
    count = {3: "three", 4: "four"}[len(parts.split())]
    if numbers.shape != (len(parts.split()),):
        raise ValueError(f"{name}: {count} numbers {parts} are needed, these are of shape {numbers.shape}")
    return [float(x) for x in numbers]


class Wrench(NamedTuple):
    """A force and the torque about a body's centre. Each of shape (3,)."""

    force: np.ndarray  # N
    torque: np.ndarray  # N m


class Body:
    """A solid body of a run. Its state is that of now; each access reads it anew."""

    def __init__(self, run: Simulation, index: int, name: str):
        self._simulation = run
        #: Its index in the scene's `bodies`, from 0.
        self.index = index
        #: The value of `bodies.N.name`; "" without one.
        self.name = name

    @property
    def position(self) -> np.ndarray:
        """Position of its centre, m. Shape (3,)."""
        return np.array(self._simulation._run.body_motion(self.index)[0][0])

    @property
    def orientation(self) -> np.ndarray:
        """How it is turned since the start: a unit quaternion w x y z. Shape (4,)."""
        return np.array(self._simulation._run.body_motion(self.index)[1])

    @property
    def velocity(self) -> np.ndarray:
        """Velocity of its centre, m/s. Shape (3,)."""
        return np.array(self._simulation._run.body_motion(self.index)[0][1])

    @property
    def angular_velocity(self) -> np.ndarray:
        """Angular velocity, rad/s. Shape (3,)."""
        return np.array(self._simulation._run.body_motion(self.index)[0][2])

    def set_velocity(self, linear: Vector, angular: Vector = (0.0, 0.0, 0.0)) -> None:
        """Move at `linear`, m/s, and turn about the centre at `angular`, rad/s, until the next command.

        Raises ValueError unless the scene has `commanded: true` for this body.
        """
        self._simulation._run.set_body_velocity(self.index, _vector("linear", linear), _vector("angular", angular))

    def set_pose(self, position: Vector, orientation: Vector | None = None, duration: float | None = None) -> None:
        """Move and turn steadily to a pose, and stay there.

        position: of the centre, m; orientation: a quaternion w x y z, how it is turned since the start (default: as it is now);
        duration: after which it is there, s (default: the scene's time.step).
        Raises ValueError unless the scene has `commanded: true` for this body.
        """
        self._simulation._run.set_body_pose(
            self.index, _vector("position", position),
            _vector("orientation", self.orientation if orientation is None else orientation, "w x y z"),
            self._simulation.scene.time_step if duration is None else float(duration))

    def apply_wrench(self, force: Vector, torque: Vector = (0.0, 0.0, 0.0)) -> None:
        """Let a force, N, and a torque about the centre, N m, act on a dynamic body until the next call.

        Raises ValueError unless the body is dynamic.
        """
        self._simulation._run.apply_wrench(self.index, _vector("force", force), _vector("torque", torque))

    def _loads(self) -> tuple[Wrench, Wrench, Wrench, Wrench]:
        """Of the liquid, of cloth in contact, of attached nodes, and of other bodies."""
        parts = [np.array(part) for part in self._simulation._run.body_load(self.index)]
        return Wrench(*parts[0:2]), Wrench(*parts[2:4]), Wrench(*parts[4:6]), Wrench(*parts[6:8])

    @property
    def attached_nodes(self) -> np.ndarray:
        """The nodes that are attached to it, as rows of the node fields."""
        return self._simulation._run.attached(self.index)

    @property
    def liquid_wrench(self) -> Wrench:
        """What pressure and viscosity of the liquid did to it in the last step, as means over the step."""
        return self._loads()[0]

    @property
    def cloth_wrench(self) -> Wrench:
        """What contact, friction and wet adhesion of cloth did to it in the last step, as means over the step."""
        return self._loads()[1]

    @property
    def attached_wrench(self) -> Wrench:
        """What nodes that are attached to it did to it in the last step: the opposite of what holds them."""
        return self._loads()[2]

    @property
    def contact_wrench(self) -> Wrench:
        """What other bodies and hinges did to it in the last step: contact and friction of dynamic bodies, forces of hinges."""
        return self._loads()[3]

    @property
    def wrench(self) -> Wrench:
        """What liquid, cloth and other bodies and hinges did to it in the last step, without gravity and apply_wrench().

        Raises ValueError unless the body is dynamic or has `commanded: true`.
        """
        loads = self._loads()
        return Wrench(np.sum([load.force for load in loads], axis=0), np.sum([load.torque for load in loads], axis=0))

    def __repr__(self) -> str:
        return f"<drench.Body {self.index}{f' {self.name!r}' if self.name else ''}>"


class Bodies(Mapping[Union[int, str], Body]):
    """The bodies of a run by index; those with a name also by name."""

    def __init__(self, run: Simulation):
        self._all = [Body(run, k, name) for k, name in enumerate(run._run.body_names)]

    def __getitem__(self, key: int | str) -> Body:
        if isinstance(key, str):
            for body in self._all:
                if key and body.name == key:
                    return body
            names = ", ".join(repr(body.name) for body in self._all if body.name)
            raise KeyError(f"there is no body {key!r}; the names are {names or 'none: bodies.N.name is not set'}")
        try:
            number = operator.index(key)
        except TypeError:
            raise KeyError(f"bodies are given by name or number, not by {key!r}") from None
        if not 0 <= number < len(self._all):
            raise KeyError(f"there is no body {key}; the scene has {len(self._all)}")
        return self._all[number]

    def __iter__(self) -> Iterator[Any]:
        return iter(range(len(self._all)))

    def __len__(self) -> int:
        return len(self._all)
