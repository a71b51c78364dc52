"""Meshes and particles that a program has as arrays: written as PLY files, which the loader of scenes reads."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from .state import numbers

#: Keys of a mesh from memory beside those of a mesh file.
MESH_KEYS = ("points", "faces", "uv", "attributes")
#: Names that properties of points in a PLY file have already.
TAKEN = ("x", "y", "z", "s", "t", "u", "v", "texture_u", "texture_v")


def _numbers(where: str, values: Any, columns: int) -> np.ndarray:
    array = numbers(where, values)
    if array.ndim != 2 or array.shape[1] != columns or not len(array):
        raise ValueError(f"{where}: needs numbers of shape (n, {columns}), n above 0; these are of shape {array.shape}")
    return array.astype(float)


def _faces(where: str, faces: Any, points: int) -> tuple[int, bytes]:
    """Number of faces, and their rows of a PLY file."""
    try:
        rows = [np.asarray(face) for face in faces]
    except TypeError:
        raise ValueError(f"{where}: needs a list of faces, this is {type(faces).__name__}") from None
    if not rows:
        raise ValueError(f"{where}: is empty; needed: at least one face")
    for k, face in enumerate(rows):
        if face.ndim != 1 or not 3 <= len(face) <= 255 or not np.issubdtype(face.dtype, np.integer):
            raise ValueError(f"{where}: face {k} is {face.tolist()}; needed: at least three indices of points")
        if face.min() < 0 or face.max() >= points:
            raise ValueError(f"{where}: face {k} is {face.tolist()}; allowed: indices from 0 to {points - 1}")
    return len(rows), b"".join(bytes([len(face)]) + face.astype("<i4").tobytes() for face in rows)


def _equal_faces(faces: np.ndarray) -> tuple[int, bytes]:
    record = np.empty(len(faces), dtype=[("count", "u1"), ("corner", "<i4", (faces.shape[1],))])
    record["count"], record["corner"] = faces.shape[1], faces
    return len(faces), record.tobytes()


def _attributes(where: str, attributes: Any, points: int) -> Iterator[tuple[str, np.ndarray]]:
    if attributes is None:
        return
    if not isinstance(attributes, Mapping):
        raise ValueError(f"{where}.attributes: is {type(attributes).__name__}; needed: a dict of name: one number per point")
    for name, values in attributes.items():
        if not isinstance(name, str) or not name or any(c.isspace() for c in name) or name in TAKEN:
            raise ValueError(f"{where}.attributes: {name!r} is not a name; allowed: a word other than {', '.join(TAKEN)}")
        array = numbers(f"{where}.attributes.{name}", values)
        if array.shape != (points,):
            raise ValueError(f"{where}.attributes.{name}: is of shape {array.shape}; needed: one number per point, {points}")
        yield name, array.astype(float)[:, None]


def write_mesh(path: Path, where: str, points: Any, faces: Any, uv: Any = None, attributes: Any = None) -> None:
    """Write points (n, 3), faces (indices of points, 3 or more each), texture coordinates (n, 2) and attributes, a dict
    of a number per point for each name, as binary PLY."""
    x = _numbers(f"{where}.points", points, 3)
    table = [x]
    names = ["x", "y", "z"]
    if uv is not None:
        texture = _numbers(f"{where}.uv", uv, 2)
        if len(texture) != len(x):
            raise ValueError(f"{where}.uv: {len(texture)} rows; needed: one per point, {len(x)}")
        table.append(texture)
        names += ["s", "t"]
    for name, values in _attributes(where, attributes, len(x)):
        table.append(values)
        names.append(name)
    array = faces if isinstance(faces, np.ndarray) else None
    if array is not None and array.ndim == 2 and array.dtype.kind in "iu" and 3 <= array.shape[1] <= 255 and \
            array.size and array.min() >= 0 and array.max() < len(x):
        count, rows = _equal_faces(array)
    else:
        count, rows = _faces(f"{where}.faces", faces, len(x))
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(x)}", *(f"property double {n}" for n in names),
              f"element face {count}", "property list uchar int vertex_indices", "end_header", ""]
    path.write_bytes("\n".join(header).encode() + np.hstack(table).astype("<f8").tobytes() + rows)


def write_particles(path: Path, where: str, positions: Any, velocities: Any = None) -> None:
    """Write positions (n, 3), m, and velocities (n, 3), m/s, as binary PLY."""
    table = [_numbers(where, positions, 3)]
    names = ["x", "y", "z"]
    if velocities is not None:
        table.append(_numbers(f"{where}.velocities", velocities, 3))
        names += ["vx", "vy", "vz"]
        if len(table[1]) != len(table[0]):
            raise ValueError(f"{where}.velocities: {len(table[1])} rows; needed: one per particle, {len(table[0])}")
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(table[0])}",
              *(f"property double {n}" for n in names), "end_header", ""]
    path.write_bytes("\n".join(header).encode() + np.hstack(table).astype("<f8").tobytes())


class ArrayFiles:
    """The files of a scene's arrays, in a folder of their own that goes when the scene does."""

    def __init__(self) -> None:
        self._folder: tempfile.TemporaryDirectory[str] | None = None

    @property
    def folder(self) -> Path | None:
        """Where they are; None without arrays."""
        return Path(self._folder.name) if self._folder else None

    def path(self, name: str) -> Path:
        """A path for a new file."""
        if self._folder is None:
            self._folder = tempfile.TemporaryDirectory(prefix="drench_arrays_")
        return Path(self._folder.name) / name

    def contents(self) -> dict[str, bytes]:
        """name: bytes of each file."""
        return {file.name: file.read_bytes() for file in sorted(self.folder.iterdir())} if self.folder else {}

    def written_in(self, scene: Mapping[str, Any]) -> dict[str, Any]:
        """The scene with files for its arrays: meshes of cloths and bodies, particles of sources. Raises ValueError."""
        scene = dict(scene)
        for section in ("cloth", "bodies"):
            if isinstance(scene.get(section), (list, tuple)):
                scene[section] = [self._with_mesh(entry, f"{section}.{k}") for k, entry in enumerate(scene[section])]
        fluid = scene.get("fluid")
        if isinstance(fluid, Mapping) and isinstance(fluid.get("sources"), (list, tuple)):
            sources = [self._with_particles(entry, f"fluid.sources.{k}") for k, entry in enumerate(fluid["sources"])]
            scene["fluid"] = {**fluid, "sources": sources}
        return scene

    def _with_mesh(self, entry: Any, where: str) -> Any:
        mesh = entry.get("mesh") if isinstance(entry, Mapping) else None
        if not isinstance(mesh, Mapping) or "points" not in mesh:
            return entry
        if "faces" not in mesh:
            raise ValueError(f"{where}.mesh.faces: is missing beside points; needed: indices of the points of each face")
        if "file" in mesh:
            raise ValueError(f"{where}.mesh: contains file and points; allowed: one of them")
        file = self.path(where.replace(".", "_") + ".ply")
        write_mesh(file, f"{where}.mesh", mesh["points"], mesh["faces"], mesh.get("uv"), mesh.get("attributes"))
        rest = {key: value for key, value in mesh.items() if key not in MESH_KEYS}
        return {**entry, "mesh": {"file": file, **rest}}

    def _with_particles(self, entry: Any, where: str) -> Any:
        if not isinstance(entry, Mapping) or "particles" not in entry or isinstance(entry["particles"], Mapping):
            return entry
        file = self.path(where.replace(".", "_") + ".ply")
        write_particles(file, f"{where}.particles", entry["particles"], entry.get("velocities"))
        rest = {key: value for key, value in entry.items() if key not in ("particles", "velocities")}
        return {**rest, "particles": {"file": file}}
