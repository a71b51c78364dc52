"""A run of a scene, step by step."""

from __future__ import annotations

import os
import warnings as _warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple, Union

import numpy as np

from . import _core
from .fields import Fields
from .recording import Recording
from .scene import Scene, SceneLike

Vector = Union[Sequence[float], np.ndarray]


class Step(dict):
    """The numbers of a step, as a dict and as attributes: step["density_iterations"] is step.density_iterations.

    The names are the members of StepReport in the C++ library. Masses are in quanta; Simulation.quantum is one in kg.
    """

    def __getattr__(self, name: str) -> Any:
        try:
            return self[name]
        except KeyError:
            raise AttributeError(f"a step has no {name}; it has {', '.join(self)}") from None

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self]

    def __repr__(self) -> str:
        return f"<drench.Step {self.step}: t = {self.time:.6g} s, {self.particles} particles>"


class Frame(NamedTuple):
    """A frame that the command would write."""

    number: int  # from 0
    time: float  # s


def _vector(name: str, value: Vector) -> list[float]:
    numbers = np.asarray(value, dtype=float)
    if numbers.shape != (3,):
        raise ValueError(f"{name}: three numbers x y z are needed, these are of shape {numbers.shape}")
    return [float(x) for x in numbers]


class Simulation:
    """A run of a scene on the backend of this build.

    scene: a path, a dict with the keys of a scene file, or a Scene.
    overrides: values that replace the scene's, as in {"fluid.spacing": 0.02}.
    resume: a checkpoint of the same scene to continue from, or a folder that contains some.
    threads: how many threads to start; only the first run of a process decides.

    Raises SceneError, SetupError, DeviceError, CheckpointError.
    """

    def __init__(self, scene: SceneLike, overrides: Mapping[str, Any] | None = None, *,
                 resume: str | os.PathLike[str] | None = None, threads: int | None = None):
        self.scene = Scene(scene, overrides)
        if threads is not None:
            _core.set_threads(int(threads))
        self._run = _core.Run(self.scene._loaded)
        #: The fields by name, without a copy. Each access gives the view of now.
        self.fields = Fields(self._run)
        #: The last step, None before the first.
        self.last: Step | None = None
        self._on_step: list[Callable[[Simulation, Step], Any]] = []
        self._on_frame: list[Callable[[Simulation, Frame], Any]] = []
        self._calling = False
        self._frames = 0
        if resume is not None:
            self.resume(resume)

    # ---- time ----

    @property
    def time(self) -> float:
        """s, since the start"""
        return self._run.time

    @property
    def steps(self) -> int:
        """Steps since the start."""
        return self._run.steps

    @property
    def finished(self) -> bool:
        """Has it come to the scene's time.end?"""
        return self.time >= self.scene.end - self._rounding

    @property
    def _rounding(self) -> float:
        return 1e-6 * self.scene.time_step

    def step(self, longest: float | None = None) -> Step:
        """One step, of at most `longest` s. Raises RunFailure.

        It ends at the next frame and at time.end at the latest, as a step of the command does, so it has the same bits.
        Python's other threads run meanwhile.
        """
        if self._calling:
            raise RuntimeError("a callback cannot make a step of its own run")
        self._first_frame()
        self.last = Step(self._run.step(self._bounded(longest)))
        self._call(self._on_step, self.last)
        self._frame_if_due()
        return self.last

    def run_until(self, time: float) -> Step | None:
        """Steps until the run's time is `time`, s. Returns the last step."""
        while self.time < time - self._rounding:
            self.step(time - self.time)
        return self.last

    def __iter__(self) -> Iterator[Step]:
        """Steps until the scene's time.end."""
        while not self.finished:
            yield self.step()

    def on_step(self, call: Callable[[Simulation, Step], Any]) -> Callable[[Simulation, Step], Any]:
        """Calls `call(run, step)` after each step. Also a decorator."""
        self._on_step.append(call)
        return call

    def on_frame(self, call: Callable[[Simulation, Frame], Any]) -> Callable[[Simulation, Frame], Any]:
        """Calls `call(run, frame)` at the start and at each multiple of output.every. Also a decorator."""
        self._on_frame.append(call)
        return call

    def _bounded(self, longest: float | None) -> float:
        bounds = [float("inf") if longest is None else float(longest)]
        if not self.finished:
            bounds.append(self.scene.end - self.time)
        if self.scene.output_every > 0:
            bounds.append(max(self._frames, 1) * self.scene.output_every - self.time)
        return min(bounds)

    def _first_frame(self) -> None:
        if self._frames == 0:
            self._frame_if_due()

    def _frame_if_due(self) -> None:
        """Frames are counted, not summed up, so that a thousand of them do not drift."""
        every = self.scene.output_every
        if every > 0 and self.time >= self._frames * every - self._rounding:
            self._frames += 1
            self._run.record_frame()
            self._call(self._on_frame, Frame(self._frames - 1, self.time))

    def _call(self, calls: list[Callable[..., Any]], argument: Any) -> None:
        self._calling = True
        try:
            for call in calls:
                call(self, argument)
        finally:
            self._calling = False

    # ---- what it knows ----

    def state(self) -> dict[str, Any]:
        """A copy of everything that changes: arrays in double precision by field, particles in the order of their ids."""
        return self._run.state()

    def saturation(self) -> np.ndarray:
        """Of each cloth node, 1: liquid over what its pores hold."""
        return self._run.saturation()

    @property
    def triangles(self) -> np.ndarray:
        """Of all cloths, as indices of their three nodes."""
        return self._run.triangles()

    @property
    def quantum(self) -> float:
        """kg; masses in fields, states and steps are counts of it."""
        return self._run.quantum

    @property
    def solute_quantum(self) -> float:
        """One quantum of solute in kg; 0 in a scene without a solute."""
        return self._run.solute_quantum

    @property
    def warnings(self) -> list[str]:
        """As `drench check` prints them."""
        return self._run.warnings

    def stage_milliseconds(self) -> dict[str, float]:
        """What each stage of the last step took, ms."""
        return self._run.stage_milliseconds()

    def pin_nodes(self, cloth: int | str, pin: int = 0) -> np.ndarray:
        """The nodes that an entry of the cloth's `pin` holds, as rows of the node fields."""
        return self._run.pin_nodes(self._cloth(cloth), pin)

    def cloth_nodes(self, cloth: int | str) -> slice:
        """A cloth's rows of the node fields."""
        first, count = self._run.cloth_nodes(self._cloth(cloth))
        return slice(first, first + count)

    def pin_force(self, cloth: int | str, pin: int = 0) -> np.ndarray:
        """The force with which an entry of the cloth's `pin` holds the cloth, N: the sum over its nodes."""
        return self.fields["node_pin_force"].copy()[self.pin_nodes(cloth, pin)].sum(axis=0, dtype=float)

    # ---- what it can be told ----

    def set_pin_velocity(self, cloth: int | str, pin: int, velocity: Vector) -> None:
        """From now on the pins of an entry move at `velocity`, m/s, from where they are.

        cloth: its name, or its number from 0; pin: the number of the entry in `cloth.N.pin`, from 0.
        """
        self._run.set_pin_velocity(self._cloth(cloth), pin, _vector("velocity", velocity))

    def set_jet(self, jet: int, velocity: Vector, center: Vector | None = None) -> None:
        """From now on a jet flows at `velocity`, m/s, from `center`, m. A velocity of 0 closes it until another opens it."""
        self._run.set_jet(jet, _vector("velocity", velocity), None if center is None else _vector("center", center))

    def set_wind(self, velocity: Vector) -> None:
        """From now on the air moves at `velocity`, m/s, without gusts."""
        self._run.set_wind(_vector("velocity", velocity))

    def save_checkpoint(self, path: str | os.PathLike[str]) -> None:
        """Save a checkpoint from which the run continues bit for bit, including changed pins, jets and wind."""
        self._run.save_checkpoint(os.fspath(path))

    def record(self, folder: str | os.PathLike[str], *, overwrite: bool = False) -> Recording:
        """From now on write the files of `drench run` to a folder: frames, stats.csv, run.log, and at the end a report.

            with run.record("out/mine"):
                for step in run: ...

        The folder must be new or empty; with `overwrite` it may also contain a run, whose files are removed. Checkpoints are
        not written. Raises Error.
        """
        return Recording(self._run, folder, overwrite)

    def resume(self, path: str | os.PathLike[str]) -> None:
        """Goes on from a checkpoint of the same scene, or from the newest in a folder. Raises CheckpointError."""
        for text in self._run.resume(os.fspath(path)):
            _warnings.warn(text, stacklevel=2)
        self.last = None
        every = self.scene.output_every
        self._frames = int((self.time + self._rounding) // every) + 1 if every > 0 else 0

    def _cloth(self, cloth: int | str) -> int:
        if not isinstance(cloth, str):
            return int(cloth)
        names = self.scene.cloth_names
        if cloth not in names:
            raise ValueError(f"there is no cloth {cloth!r}; there are {', '.join(map(repr, names))}")
        return names.index(cloth)

    # ---- pictures ----

    def to_pyvista(self) -> Any:
        """A pyvista.MultiBlock of the run as it is now: `fluid`, `cloth` and `boundary`, as far as the scene has them."""
        from .pictures import to_pyvista
        return to_pyvista(self)

    def _repr_html_(self) -> str:
        from .pictures import to_html
        return to_html(self)

    def __repr__(self) -> str:
        return f"<drench.Simulation {self.scene.path}: t = {self.time:.6g} of {self.scene.end:g} s, {self.steps} steps>"
