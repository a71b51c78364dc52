"""A run of a scene, step by step."""

from __future__ import annotations

import math
import operator
import os
import warnings as _warnings
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from . import _core
from . import state as _state
from .bodies import Bodies, Body, Vector, _vector
from .fields import Fields
from .recording import Recording
from .scene import Scene, SceneLike

_BAR = "{percentage:3.0f}% |{bar}| {n:.3f} of {total:g} s [{elapsed} < {remaining}]"


class _Process:
    """Whether this process was forked from one in which drench had started threads or a GPU, which a fork does not copy."""

    #: None before the first run.
    can_fork: bool | None = None
    forked = False

    @classmethod
    def start(cls) -> None:
        cls.check()
        if cls.can_fork is None:
            info = _core.info()
            cls.can_fork = info["backend"] == "Serial" or (info["backend"] == "OpenMP" and info["threads"] == "1")

    @classmethod
    def in_child(cls) -> None:
        cls.forked = cls.can_fork is False

    @classmethod
    def check(cls) -> None:
        if cls.forked:
            raise RuntimeError("this process was forked after drench had started threads or a GPU, and cannot use them; start "
                               "processes by multiprocessing's method \"spawn\", or set OMP_NUM_THREADS=1 before Python starts")


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_Process.in_child)


def _indices(name: str, values: Any) -> list[int]:
    array = np.atleast_1d(np.asarray(values))
    if array.ndim != 1 or (array.size and not np.issubdtype(array.dtype, np.integer)):
        raise ValueError(f"{name}: needs a list of indices, these are {array.dtype} of shape {array.shape}")
    return [_index(name, k) for k in array]


def _index(name: str, value: Any) -> int:
    try:
        number = operator.index(value)
    except TypeError:
        raise ValueError(f"{name}: needs a whole number, this is {value!r}") from None
    if not -2**31 <= number < 2**31:
        raise ValueError(f"{name}: there is no {number}")
    return number


def _callable(name: str, call: Callable[..., Any]) -> Callable[..., Any]:
    if not callable(call):
        raise TypeError(f"{name}: needs a function, this is {call!r}")
    return call


def _time(name: str, value: Any) -> float:
    number = float(value)
    if not math.isfinite(number):
        raise ValueError(f"{name}: needs a finite time, this is {number}")
    return number


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
        _Process.start()
        self._core = _core.Run(self.scene._loaded)
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

    @property
    def _run(self) -> _core.Run:
        _Process.check()
        return self._core

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
        return self._after_step(self._run.step(self._before_step(longest)))

    def _before_step(self, longest: float | None) -> float:
        """The bound of the next step."""
        if self._calling:
            raise RuntimeError("a callback cannot make a step of its own run")
        self._first_frame()
        return self._bounded(longest)

    def _after_step(self, report: dict[str, Any]) -> Step:
        self.last = Step(report)
        self._call(self._on_step, self.last)
        self._frame_if_due()
        return self.last

    def run_until(self, time: float) -> Step | None:
        """Advance until the simulated time is `time`, s. Returns the report of the last step."""
        time = _time("run_until", time)
        while self.time < time - self._rounding:
            self.step(time - self.time)
        return self.last

    def __iter__(self) -> Iterator[Step]:
        """Iterate over the reports of all steps until the scene's time.end."""
        while not self.finished:
            yield self.step()

    def on_step(self, call: Callable[[Simulation, Step], Any]) -> Callable[[Simulation, Step], Any]:
        """Call `call(run, step)` after each step. Can be used as a decorator."""
        self._on_step.append(_callable("on_step", call))
        return call

    def on_frame(self, call: Callable[[Simulation, Frame], Any]) -> Callable[[Simulation, Frame], Any]:
        """Call `call(run, frame)` at the start and at each multiple of output.every. Can be used as a decorator."""
        self._on_frame.append(_callable("on_frame", call))
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

    def capacity(self) -> np.ndarray:
        """Mass of liquid that each cloth node's pores hold at saturation 1, kg; 0 where cloth is not porous. Shape (nodes,)."""
        return self._run.node_capacity()

    def mass(self, name: str) -> np.ndarray:
        """A field of masses in kg, as float64: `fluid_mass`, `node_liquid`, `fluid_solute`, …, in the order of `run.fields`."""
        field = self.fields[name]
        if field.unit != "quanta":
            raise ValueError(f"{name} has the unit {field.unit}; fields of masses have the unit quanta")
        return field.copy() * (self.solute_quantum if name.endswith("_solute") else self.quantum)

    # ---- changes of the state ----

    def set(self, name: str | Mapping[str, Any], values: Any = None, at: Any = None) -> None:
        """Set a field, or several: `set("node_velocity", v)`, `set({"node_position": x, "node_velocity": v})`.

        values: one row per node, body or particle, or one row for all, in the unit of the field.
        at: of nodes and bodies, the rows, as an index or a slice (default: all). Of particles, their ids, because their order
        changes: `at=run.fields["fluid_id"]` for all of them in the order of `run.fields`.
        `saturation` (1) sets the liquid in cloth nodes. Liquid that a change adds or removes is entered in the mass budget
        as supplied or drained. Poses of bodies that the scene or a command moves follow these, whatever is set.
        Raises KeyError for a field that cannot be set, and ValueError for values that are not allowed.
        """
        if isinstance(name, Mapping) and values is not None:
            raise ValueError("set: a dict of fields contains the values; there is no second argument beside it")
        changes = dict(name) if isinstance(name, Mapping) else {name: values}
        state = self.state()
        for field, new in changes.items():
            if field == "saturation":
                _state.set_saturation(state, new, at, self.capacity() / self.quantum)
            else:
                _state.set_field(state, field, new, at)
        self._run.set_state(state)

    def add_particles(self, position: Any, velocity: Any = (0.0, 0.0, 0.0), mass: Any = None) -> np.ndarray:
        """Add particles of liquid and return their ids.

        position: m, shape (n, 3); velocity: m/s, one row or n; mass: kg, one number or n (default: a full particle's).
        They are entered in the mass budget as supplied liquid. Keep them one spacing apart: closer ones push each other away.
        Raises ValueError, also for positions outside the domain.
        """
        state = self.state()
        units = None if mass is None else np.rint(_state.numbers("mass", mass) / self.quantum)
        ids = _state.add_particles(state, position, velocity, units, self.full_particle)
        self._run.set_state(state)
        return ids

    def remove_particles(self, ids: Any) -> None:
        """Remove particles by their ids (`fluid_id`). They are entered in the mass budget as drained. Raises ValueError."""
        state = self.state()
        _state.remove_particles(state, ids)
        self._run.set_state(state)

    def state_dict(self) -> dict[str, Any]:
        """All that a run of the same scene needs to continue bit for bit: state(), and what commands changed."""
        return {**self.state(), "changes": self._run.changes()}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from the `state_dict()` of a run of the same scene. Raises ValueError."""
        given, changes = _state.continued_from(state, self.state())
        self._run.restore(given, changes)
        self._restarted()

    def reset(self) -> None:
        """Return to the start of the scene and drop all commands. Callbacks stay."""
        self._run.reset()
        self._restarted()

    def clone(self) -> Simulation:
        """A second run of the same scene in the same state, without the callbacks. Both continue with the same bits."""
        other = Simulation(self.scene)
        other.load_state_dict(self.state_dict())
        return other

    def __deepcopy__(self, memo: dict[int, Any]) -> Simulation:
        return self.clone()

    def __reduce__(self) -> tuple[Any, ...]:
        return _continued, (self.scene, self.state_dict())

    @property
    def triangles(self) -> np.ndarray:
        """Triangles of all cloths as node indices. Shape (triangles, 3)."""
        return self._run.triangles()

    @property
    def full_particle(self) -> int:
        """Mass of a full particle, in quanta."""
        return _core.quanta_per_particle

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
        return self._run.pin_nodes(self._cloth(cloth), _index("pin", pin))

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
        self._run.set_pin_velocity(self._cloth(cloth), _index("pin", pin), _vector("velocity", velocity))

    def attach(self, cloth: int | str, nodes: Any, body: int | str | Body) -> None:
        """Let nodes of a cloth move and turn with a body, from where they are now.

        cloth: its name or index; nodes: indices within the cloth, from 0; body: one that the scene or commands move, by its name
        or index or as an entry of `bodies`. What the nodes pull with is part of the body's wrench. Takes as long as setting up
        the cloth; the results of later steps are those of the same pins in a scene. Raises ValueError, and KeyError for a body
        that does not exist.
        """
        chosen = _indices("nodes", nodes)
        if not chosen:
            raise ValueError("nodes: the list is empty; needed: at least one node of the cloth")
        self._run.attach(self._cloth(cloth), chosen, body.index if isinstance(body, Body) else self.bodies[body].index)

    def detach(self, cloth: int | str, nodes: Any = None) -> None:
        """Free nodes of a cloth that are attached to a body; by default all of them. Raises ValueError."""
        number = self._cloth(cloth)
        if nodes is None:
            first, count = self._run.cloth_nodes(number)
            held = [n - first for body in self.bodies.values() for n in body.attached_nodes if first <= n < first + count]
            nodes = sorted(held)
        chosen = _indices("nodes", nodes)
        if chosen:
            self._run.detach(number, chosen)

    def set_jet(self, jet: int, velocity: Vector, center: Vector | None = None) -> None:
        """Set the velocity, m/s, of a jet and optionally its centre, m. A velocity of 0 closes the jet.

        A jet with the key `motion` can be closed, but not changed otherwise."""
        self._run.set_jet(_index("jet", jet), _vector("velocity", velocity),
                          None if center is None else _vector("center", center))

    def set_motor(self, joint: int, speed: float) -> None:
        """Set the speed, rad/s, that the motor of a hinge (`joints`, from 0) holds with at most its torque."""
        self._run.set_motor(_index("joint", joint), float(speed))

    def set_wind(self, velocity: Vector) -> None:
        """Set the velocity of the air, m/s, and switch gusts off."""
        self._run.set_wind(_vector("velocity", velocity))

    def save_checkpoint(self, path: str | os.PathLike[str]) -> None:
        """Save a checkpoint from which the run continues bit for bit, including changed bodies, pins, jets, motors and wind."""
        self._run.save_checkpoint(os.fspath(path))

    def record(self, folder: str | os.PathLike[str], *, overwrite: bool = False) -> Recording:
        """Start writing the files of `drench run` to a folder: frames, stats.csv, run.log, and at the end a report.

            with run.record("out/mine"):
                for step in run: ...

        The folder must be new or empty; with `overwrite` it may also contain a run, whose files are removed. Checkpoints are
        not written. Raises Error.
        """
        return Recording(self._run, folder, overwrite)

    def write(self, folder: str | os.PathLike[str], *, overwrite: bool = False, progress: bool = False) -> Path:
        """Compute the rest of the scene and write it as `drench run` does. Returns the path of the report.

        progress: show a bar in the terminal or the notebook; needs the package tqdm. Otherwise as record().
        """
        if progress:  # before a file is written
            from tqdm.auto import tqdm
        with self.record(folder, overwrite=overwrite) as recording:
            if progress:
                with tqdm(total=self.scene.end, initial=self.time, unit="s", bar_format=_BAR) as bar:
                    for step in self:
                        bar.update(step.time - bar.n)
            else:
                for _ in self:
                    pass
        return recording.folder / "report.html"

    def resume(self, path: str | os.PathLike[str]) -> None:
        """Continue from a checkpoint of the same scene, or from the newest one in a folder. Raises CheckpointError."""
        for text in self._run.resume(os.fspath(path)):
            _warnings.warn(text, stacklevel=2)
        self._restarted()

    def _restarted(self) -> None:
        self.last = None
        every = self.scene.output_every
        past = every > 0 and self.steps > 0  # the first step reports the frame of the start
        self._frames = int((self.time + self._rounding) // every) + 1 if past else 0

    def _cloth(self, cloth: int | str) -> int:
        if not isinstance(cloth, str):
            return _index("cloth", cloth)
        names = self.scene.cloth_names
        if cloth not in names:
            known = ", ".join(map(repr, names)) or "none: the scene has no cloth"
            raise ValueError(f"there is no cloth {cloth!r}; the names are {known}")
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


def _continued(scene: Scene, state: dict[str, Any]) -> Simulation:
    run = Simulation(scene)
    run.load_state_dict(state)
    return run
