"""Changes of a run's state between steps: checked values, particles added and removed."""

from __future__ import annotations

from typing import Any, Union

import numpy as np

#: Fields that a program may set. Positions and orientations of bodies that a scene or a program moves are not among them.
WRITABLE = ("fluid_position", "fluid_velocity", "fluid_mass", "fluid_spin", "fluid_solute", "node_position", "node_velocity",
            "node_liquid", "node_solute", "body_position", "body_orientation", "body_velocity", "body_angular_velocity")
#: What HostState::origin calls a particle that a program added.
ORIGIN_PROGRAM = 3

Rows = Union[slice, Any]


def rows_of_ids(state: dict[str, Any], ids: Any) -> np.ndarray:
    """The rows of a state, which is in the order of the ids, that contain these particles. Raises ValueError."""
    wanted = np.asarray(ids)
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


def as_values(name: str, values: Any, like: np.ndarray, count: int) -> np.ndarray:
    """Values for `count` rows of a field with the type of `like`; one row stands for all. Raises ValueError."""
    given = np.asarray(values)
    if given.dtype == object or not np.issubdtype(given.dtype, np.number) or np.iscomplexobj(given):
        raise ValueError(f"{name}: needs numbers, these are {given.dtype}")
    if np.issubdtype(like.dtype, np.integer) and not np.array_equal(given, np.rint(given)):
        raise ValueError(f"{name}: masses are integer numbers of run.quantum")
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
    else:
        rows = np.arange(len(field))[slice(None) if at is None else at]
        rows = np.atleast_1d(rows)
    if len(field) == 0 and len(rows) == 0:
        raise ValueError(f"{name}: this scene has no such field")
    field[rows] = as_values(name, values, field, len(rows))
    if name == "node_liquid":
        np.minimum(state["node_buffered"], state["node_liquid"], out=state["node_buffered"])


def add_particles(state: dict[str, Any], position: Any, velocity: Any, mass: Any, full: int) -> np.ndarray:
    """Append particles to a state. Returns their ids. Raises ValueError."""
    position = np.asarray(position, dtype=float)
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
    for name, values in state.items():
        if not name.startswith("fluid_") or (len(values) == 0 and len(state["fluid_id"]) > 0):
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
