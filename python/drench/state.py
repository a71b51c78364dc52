"""Changes of a run's state between steps: checked values, particles added and removed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Union

import numpy as np

from ._core import precision

#: Fields that a program may set. Positions and orientations of bodies that a scene or a program moves are not among them.
WRITABLE = ("fluid_position", "fluid_velocity", "fluid_mass", "fluid_spin", "fluid_solute", "node_position", "node_velocity",
            "node_liquid", "node_solute", "body_position", "body_orientation", "body_velocity", "body_angular_velocity")
#: What HostState::origin calls a particle that a program added.
ORIGIN_PROGRAM = 3

Rows = Union[slice, Any]


def numbers(name: str, values: Any) -> np.ndarray:
    """Values as an array of finite real numbers. Raises ValueError."""
    try:
        given = np.asarray(values)
    except ValueError:
        raise ValueError(f"{name}: needs numbers in rows of the same length") from None
    if not np.issubdtype(given.dtype, np.number) or np.iscomplexobj(given):
        raise ValueError(f"{name}: needs numbers, these are {given.dtype}")
    if not np.isfinite(given).all():
        raise ValueError(f"{name}: not a finite number: {given[~np.isfinite(given)][0]}")
    return given


def _integers(values: Any) -> np.ndarray:
    """An array; without entries one of integers, because NumPy makes [] an array of floats."""
    given = np.asarray(values)
    return given.astype(np.int64) if given.size == 0 and given.dtype == float else given


def rows_of_ids(state: dict[str, Any], ids: Any) -> np.ndarray:
    """The rows of a state, which is in the order of the ids, that contain these particles. Raises ValueError."""
    wanted = _integers(ids)
    if wanted.ndim != 1 or not np.issubdtype(wanted.dtype, np.integer):
        raise ValueError(f"ids of particles are a list of integers, these are {wanted.dtype} of shape {wanted.shape}")
    known = state["fluid_id"]
    rows = np.searchsorted(known, wanted)
    found = (rows < len(known)) & (known[np.minimum(rows, len(known) - 1)] == wanted) if len(known) else np.zeros(len(wanted), bool)
    if not found.all():
        raise ValueError(f"there is no particle with id {wanted[~found][0]}; {len(known)} particles exist (run.fields['fluid_id'])")
    if len(np.unique(wanted)) != len(wanted):
        raise ValueError("an id is listed twice")
    return rows


def rows_of(name: str, at: Any, count: int) -> np.ndarray:
    """The rows that an index, a list of indices, a slice or a mask selects of `count`; None selects all. Raises ValueError."""
    if at is None or isinstance(at, slice):
        return np.arange(count)[slice(None) if at is None else at]
    chosen = np.atleast_1d(_integers(at))
    if chosen.ndim != 1 or not (chosen.dtype == bool or np.issubdtype(chosen.dtype, np.integer)):
        raise ValueError(f"{name}: at needs an index, a list of indices or a slice, "
                         f"this is {chosen.dtype} of shape {np.shape(at)}")
    try:
        rows = np.arange(count)[chosen]
    except IndexError:
        if chosen.dtype == bool:
            raise ValueError(f"{name}: {len(chosen)} entries in a mask; there are {count} rows") from None
        outside = chosen[(chosen < -count) | (chosen >= count)][0]
        raise ValueError(f"{name}: there is no row {outside}; there are {count} rows") from None
    if len(np.unique(rows)) != len(rows):
        raise ValueError(f"{name}: a row is listed twice")
    return rows


def as_values(name: str, values: Any, like: np.ndarray, count: int) -> np.ndarray:
    """Values for `count` rows of a field with the type of `like`; one row stands for all. Raises ValueError."""
    given = numbers(name, values)
    if np.issubdtype(like.dtype, np.integer):
        if not np.array_equal(given, np.rint(given)):
            raise ValueError(f"{name}: masses are integer numbers of run.quantum")
        most = np.iinfo(like.dtype).max
        if (np.abs(given.astype(float)) >= most).any():
            raise ValueError(f"{name}: masses above {most} mass units are not possible")
    elif precision == "float" and (np.abs(given.astype(float)) > np.finfo(np.float32).max).any():
        raise ValueError(f"{name}: larger than a single-precision number can be")
    shape = (count, *like.shape[1:])
    try:
        whole = np.broadcast_to(given, shape)
    except ValueError:
        raise ValueError(f"{name}: shape {given.shape}; needed: {shape}, or one row for all") from None
    return whole.astype(like.dtype)


def set_field(state: dict[str, Any], name: str, values: Any, at: Any) -> None:
    """Set rows of a field in a state. Raises ValueError and KeyError."""
    if name not in WRITABLE:
        raise KeyError(f"{name} cannot be set; these can: {', '.join(('saturation', *WRITABLE))}")
    field = state[name]
    if name.startswith("fluid_"):
        if at is None:
            raise ValueError(f"{name}: say of which particles: at=run.fields['fluid_id'] for all in the order of run.fields, or a "
                             "list of ids")
        rows = rows_of_ids(state, at)
        missing = len(field) == 0 and len(rows) > 0
    else:
        missing = len(field) == 0
        rows = np.empty(0, int) if missing else rows_of(name, at, len(field))
    if missing:
        raise ValueError(f"{name}: this scene has no such field")
    field[rows] = as_values(name, values, field, len(rows))
    if name == "node_liquid":
        np.minimum(state["node_buffered"], state["node_liquid"], out=state["node_buffered"])
        for history in ("node_scanning", "node_extreme"):  # of fabric with hysteresis: it begins anew
            if len(state.get(history, ())):
                state[history][rows] = 0


def set_saturation(state: dict[str, Any], values: Any, at: Any, full: np.ndarray) -> None:
    """Set the liquid in cloth nodes that hold `full` mass units at saturation 1; nodes that are not porous stay dry.

    Raises ValueError.
    """
    rows = rows_of("saturation", at, len(full))
    given = numbers("saturation", values).astype(float)
    if (given < 0).any():
        raise ValueError(f"saturation: {given[given < 0][0]:g}; allowed: at least 0")
    if not full[rows].any() and given.any() and len(rows):
        raise ValueError("saturation: the cloth is not porous here; allowed: 0")
    if given.shape not in ((), (1,), rows.shape):
        raise ValueError(f"saturation: shape {given.shape}; needed: {rows.shape}, or one number for all")
    if len(state["node_liquid"]):
        set_field(state, "node_liquid", np.rint(given * full[rows]), rows)


def add_particles(state: dict[str, Any], position: Any, velocity: Any, mass: Any, full: int) -> np.ndarray:
    """Append particles to a state. Returns their ids. Raises ValueError."""
    position = numbers("position", position).astype(float)
    if position.ndim != 2 or position.shape[1] != 3:
        raise ValueError(f"position: shape {position.shape}; needed: (number of particles, 3)")
    count, first = len(position), state["next_id"]
    ids = np.arange(first, first + count, dtype=np.int64)
    given = {
        "fluid_position": position,
        "fluid_velocity": as_values("velocity", velocity, np.empty((0, 3)), count),
        "fluid_mass": np.full(count, full, np.int64) if mass is None else as_values("mass", mass, np.empty(0, np.int64), count),
        "fluid_id": ids,
        "fluid_origin": np.full(count, ORIGIN_PROGRAM, np.uint8),
    }
    any_before = len(state["fluid_id"]) > 0
    for name, values in state.items():
        if not name.startswith("fluid_") or (len(values) == 0 and any_before):
            continue  # arrays that the scene does not need stay empty
        more = given.get(name)
        state[name] = np.concatenate([values, np.zeros((count, *values.shape[1:]), values.dtype) if more is None else more])
    state["next_id"] = first + count
    return ids


def remove_particles(state: dict[str, Any], ids: Any) -> None:
    """Remove particles from a state. Raises ValueError."""
    rows = rows_of_ids(state, ids)
    for name, values in state.items():
        if name.startswith("fluid_") and len(values) > 0:
            state[name] = np.delete(values, rows, axis=0)


def continued_from(given: Mapping[str, Any], like: dict[str, Any]) -> tuple[dict[str, Any], list[float]]:
    """A state with the types of `like`, and what commands changed, from a state_dict(), which a file may have kept.

    Raises ValueError.
    """
    if not isinstance(given, Mapping):
        raise ValueError(f"a state is a dict as of state_dict(), this is {type(given).__name__}")
    state: dict[str, Any] = {}
    for name, now in {**like, "changes": np.empty(0)}.items():
        if name not in given:
            raise ValueError(f"{name}: is missing in the state")
        kind = now.dtype if isinstance(now, np.ndarray) else np.asarray(now).dtype
        values = np.asarray(given[name])
        same = np.can_cast(values.dtype, kind, "same_kind") and values.ndim == np.ndim(now)
        if values.size and not same:
            raise ValueError(f"{name}: needs {kind} of {np.ndim(now)} dimensions, "
                             f"this is {values.dtype} of shape {values.shape}")
        if isinstance(now, np.ndarray):
            state[name] = np.ascontiguousarray(values.reshape(values.shape if same else (0, *now.shape[1:])), kind)
        else:
            state[name] = type(now)(values)
    changes = state.pop("changes")
    if np.isnan(changes).any():
        raise ValueError("changes: not a finite number: nan")
    return state, [float(number) for number in changes]
