"""A run of a scene, step by step."""

from __future__ import annotations

import os
import warnings as _warnings
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from . import _core
from .bodies import Bodies, Vector, _vector
from .fields import Fields
from .recording import Recording
from .scene import Scene, SceneLike


class Step(dict):
    """The report of one step, readable as a dict and by attributes: step["density_iterations"] is step.density_iterations.

    The names are those of the members of StepReport in the C++ library. Masses are in quanta; Simulation.quantum is the mass of
    one quantum in kg.
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
    """A frame: a moment at which `drench run` would write its files."""

    number: int  # from 0
    time: float  # s


class Simulation:
    """A run of a scene on the backend of this build.

    scene: a path, a dict with the keys of a scene file, or a Scene.
    overrides: values that replace the scene's, as in {"fluid.spacing": 0.02}.
    resume: a checkpoint of the same scene to continue from, or a folder; the newest checkpoint in it is used.
    threads: number of threads; only the first run in a process can choose it.

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
        #: The solid bodies by name or index: where they are, what acts on them, and how a program moves them.
        self.bodies = Bodies(self)
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
        """Simulated time since the start, s."""
        return self._run.time

    @property
    def steps(self) -> int:
        """Number of steps since the start."""
        return self._run.steps

    @property
    def finished(self) -> bool:
        """True if the run has reached the scene's time.end."""
        return self.time >= self.scene.end - self._rounding

    @property
    def _rounding(self) -> float:
        return 1e-6 * self.scene.time_step

    def step(self, longest: float | None = None) -> Step:
        """Advance by one step of at most `longest` s and return its report. Raises RunFailure.

        A step never passes the next frame or time.end. `drench run` has the same rule, so both give the same bits.
        Other Python threads run in the meantime.
        """
        if self._calling:
            raise RuntimeError("a callback cannot make a step of its own run")
        self._first_frame()
        self.last = Step(self._run.step(self._bounded(longest)))
        self._call(self._on_step, self.last)
        self._frame_if_due()
        return self.last

    def run_until(self, time: float) -> Step | None:
        """Advance until the simulated time is `time`, s. Returns the report of the last step."""
        while self.time < time - self._rounding:
            self.step(time - self.time)
        return self.last

    def __iter__(self) -> Iterator[Step]:
        """Iterate over the reports of all steps until the scene's time.end."""
        while not self.finished:
            yield self.step()

    def on_step(self, call: Callable[[Simulation, Step], Any]) -> Callable[[Simulation, Step], Any]:
        """Call `call(run, step)` after each step. Can be used as a decorator."""
        self._on_step.append(call)
        return call

    def on_frame(self, call: Callable[[Simulation, Frame], Any]) -> Callable[[Simulation, Frame], Any]:
        """Call `call(run, frame)` at the start and at each multiple of output.every. Can be used as a decorator."""
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

    # ---- state ----

    def state(self) -> dict[str, Any]:
        """A copy of the whole state: a dict of arrays in double precision by field name; particles are sorted by id."""
        return self._run.state()

    def saturation(self) -> np.ndarray:
        """Saturation of each cloth node, 1: the mass of its liquid divided by its capacity. Shape (nodes,)."""
        return self._run.saturation()

    @property
    def triangles(self) -> np.ndarray:
        """Triangles of all cloths as node indices. Shape (triangles, 3)."""
        return self._run.triangles()

    @property
    def quantum(self) -> float:
        """Mass of one quantum, kg. Masses in fields, states and reports are integer multiples of it."""
        return self._run.quantum

    @property
    def solute_quantum(self) -> float:
        """Mass of one quantum of solute, kg; 0 in a scene without a solute."""
        return self._run.solute_quantum

    @property
    def warnings(self) -> list[str]:
        """The warnings that `drench check` prints."""
        return self._run.warnings

    def stage_milliseconds(self) -> dict[str, float]:
        """Run time of each stage in the last step, ms."""
        return self._run.stage_milliseconds()

    def pin_nodes(self, cloth: int | str, pin: int = 0) -> np.ndarray:
        """Indices, in the node fields, of the nodes that entry `pin` of the cloth's `pin` list holds."""
        return self._run.pin_nodes(self._cloth(cloth), pin)

    def cloth_nodes(self, cloth: int | str) -> slice:
        """The slice of the node fields that belongs to a cloth."""
        first, count = self._run.cloth_nodes(self._cloth(cloth))
        return slice(first, first + count)

    def pin_force(self, cloth: int | str, pin: int = 0) -> np.ndarray:
        """Total force of entry `pin` of the cloth's `pin` list on the cloth, N. Shape (3,)."""
        return self.fields["node_pin_force"].copy()[self.pin_nodes(cloth, pin)].sum(axis=0, dtype=float)

    # ---- commands ----

    def set_pin_velocity(self, cloth: int | str, pin: int, velocity: Vector) -> None:
        """Move the pins of an entry at `velocity`, m/s, from their current positions.

        cloth: its name, or its index from 0; pin: the index of the entry in `cloth.N.pin`, from 0.
        """
        self._run.set_pin_velocity(self._cloth(cloth), pin, _vector("velocity", velocity))

    def set_jet(self, jet: int, velocity: Vector, center: Vector | None = None) -> None:
        """Set the velocity, m/s, of a jet and optionally its centre, m. A velocity of 0 closes the jet."""
        self._run.set_jet(jet, _vector("velocity", velocity), None if center is None else _vector("center", center))

    def set_wind(self, velocity: Vector) -> None:
        """Set the velocity of the air, m/s, and switch gusts off."""
        self._run.set_wind(_vector("velocity", velocity))

    def save_checkpoint(self, path: str | os.PathLike[str]) -> None:
        """Save a checkpoint from which the run continues bit for bit, including changed bodies, pins, jets and wind."""
        self._run.save_checkpoint(os.fspath(path))

    def record(self, folder: str | os.PathLike[str], *, overwrite: bool = False) -> Recording:
        """Start writing the files of `drench run` to a folder: frames, stats.csv, run.log, and at the end a report.

            with run.record("out/mine"):
                for step in run: ...

        The folder must be new or empty; with `overwrite` it may also contain a run, whose files are removed. Checkpoints are
        not written. Raises Error.
        """
        return Recording(self._run, folder, overwrite)

    def resume(self, path: str | os.PathLike[str]) -> None:
        """Continue from a checkpoint of the same scene, or from the newest one in a folder. Raises CheckpointError."""
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
        """The current state as a pyvista.MultiBlock with those of `fluid`, `cloth` and `boundary` that the scene has."""
        from .pictures import to_pyvista
        return to_pyvista(self)

    def _repr_html_(self) -> str:
        from .pictures import to_html
        return to_html(self)

    def __repr__(self) -> str:
        return f"<drench.Simulation {self.scene.path}: t = {self.time:.6g} of {self.scene.end:g} s, {self.steps} steps>"
