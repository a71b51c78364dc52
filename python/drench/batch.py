"""Independent runs that step together."""

from __future__ import annotations

import operator
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from . import _core
from .scene import SceneLike
from .simulation import Simulation, Step, _time


class BatchError(_core.Error):
    """Worlds of a batch that could not go on, or whose callbacks raised; the others have made their step.

    errors: the exceptions by the index of the world. Such a world can be reset, or given another state.
    """

    def __init__(self, errors: Mapping[int, Exception]):
        self.errors = dict(errors)
        first = min(self.errors)
        more = f" (and {len(self.errors) - 1} more)" if len(self.errors) > 1 else ""
        super().__init__(f"world {first}: {self.errors[first]}{more}")

    def __reduce__(self) -> tuple[Any, ...]:
        return BatchError, (self.errors,)


class Batch(Sequence[Simulation]):
    """n independent worlds that step with one call. `batch[k]` is a Simulation, and each has the bits that it has alone.

    scene: one scene for all worlds, or a list with a scene for each.
    n: the number of worlds, for one scene.
    overrides: values that replace the scene's, as in {"fluid.spacing": 0.02}: for all worlds, or a list with one per world.
    threads: number of threads; only the first run in a process can choose it.

    Worlds compute at the same time; with at least as many worlds as threads, each on one thread.
    Raises what Simulation raises.
    """

    def __init__(self, scene: SceneLike | Sequence[SceneLike], n: int | None = None,
                 overrides: Mapping[str, Any] | Sequence[Mapping[str, Any]] | None = None, *, threads: int | None = None):
        scenes: list[Any] = list(scene) if isinstance(scene, (list, tuple)) else []
        if scenes and n is not None and n != len(scenes):
            raise ValueError(f"Batch: n is {n}, and there are {len(scenes)} scenes")
        if not scenes:
            count = len(overrides) if n is None and isinstance(overrides, (list, tuple)) else n
            if count is None:
                raise ValueError("Batch: needs n, the number of worlds, or a list of scenes or of overrides")
            scenes = [scene] * operator.index(count)
        if not scenes:
            raise ValueError("Batch: allowed: 1 or more worlds")
        each = list(overrides) if isinstance(overrides, (list, tuple)) else [overrides] * len(scenes)
        if len(each) != len(scenes):
            raise ValueError(f"Batch: there are {len(scenes)} worlds and {len(each)} overrides")
        self._worlds = [Simulation(s, o, threads=threads) for s, o in zip(scenes, each)]

    def __len__(self) -> int:
        return len(self._worlds)

    def __getitem__(self, k: Any) -> Any:
        return self._worlds[k]

    def __iter__(self) -> Iterator[Simulation]:
        return iter(self._worlds)

    @property
    def time(self) -> np.ndarray:
        """Simulated time of each world, s. Shape (n,)."""
        return np.array([world.time for world in self._worlds])

    def step(self, longest: float | Sequence[float] | None = None, worlds: Iterable[int] | None = None) -> list[Step | None]:
        """Advance each world by one step of its own length, and return the reports.

        longest: no step is longer than this, s; one number, or one per world.
        worlds: the indices of those that step (default: all); the others' reports are None.
        Raises BatchError after all others have made their step.
        """
        limits = [longest] * len(self) if longest is None or np.ndim(longest) == 0 else list(longest)  # type: ignore[arg-type]
        if len(limits) != len(self):
            raise ValueError(f"step: there are {len(self)} worlds, and {len(limits)} longest steps")
        chosen = range(len(self)) if worlds is None else sorted({self._index(k) for k in worlds})
        runs = [self._worlds[k] for k in chosen]
        bounds = [run._before_step(limits[k]) for k, run in zip(chosen, runs)]  # type: ignore[arg-type]
        results = _core.step_together([run._run for run in runs], bounds)
        reports: list[Step | None] = [None] * len(self)
        errors: dict[int, Exception] = {}
        for k, run, result in zip(chosen, runs, results):
            if isinstance(result, Exception):
                errors[k] = result
                continue
            try:
                reports[k] = run._after_step(result)
            except Exception as error:  # of a callback: the other worlds have stepped too
                errors[k] = error
        if errors:
            raise BatchError(errors)
        return reports

    def run_until(self, time: float) -> None:
        """Advance all worlds until the simulated time of each is `time`, s.

        Raises BatchError once all worlds that can go on are there.
        """
        time = _time("run_until", time)
        errors: dict[int, Exception] = {}
        while waiting := [k for k, world in enumerate(self._worlds)
                          if k not in errors and world.time < time - world._rounding]:
            left = [max(time - world.time, world._rounding) for world in self._worlds]
            try:
                self.step(left, waiting)
            except BatchError as error:
                errors.update(error.errors)
        if errors:
            raise BatchError(errors)

    def reset(self, worlds: Iterable[int] | None = None) -> None:
        """Return these worlds (default: all) to the start of their scenes. Commands are dropped, callbacks stay."""
        for k in range(len(self)) if worlds is None else worlds:
            self._worlds[self._index(k)].reset()

    def stack(self, name: str) -> np.ndarray:
        """A copy of a field of all worlds, shape (n, rows, …). ValueError if the worlds have different numbers of rows.

        `batch[k].fields[name]` is one world's without a copy.
        """
        fields = [np.asarray(world.fields[name].numpy()) for world in self._worlds]
        rows = {len(field) for field in fields}
        if len(rows) > 1:
            raise ValueError(f"stack: the worlds have between {min(rows)} and {max(rows)} rows of {name}")
        return np.stack(fields)

    def _index(self, k: Any) -> int:
        if isinstance(k, (bool, np.bool_)):
            raise TypeError("worlds: needs indices; of a mask, numpy.flatnonzero(mask)")
        index = operator.index(k)
        if not 0 <= index < len(self):
            raise IndexError(f"there is no world {index}; allowed: 0 to {len(self) - 1}")
        return index

    def __repr__(self) -> str:
        return f"<drench.Batch: {len(self)} worlds>"
