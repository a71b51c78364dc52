"""Scenes from files, YAML text and dicts, all through the loader of scene files."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Union

from . import _core
from .arrays import ArrayFiles

SceneLike = Union[str, "os.PathLike[str]", Mapping[str, Any], "Scene"]


def _key(value: Any) -> str:
    text = str(value)
    return text if text.isidentifier() else json.dumps(text, ensure_ascii=False)


def _scalar(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        if math.isfinite(value):
            return repr(value)
        return ".nan" if math.isnan(value) else ".inf" if value > 0 else "-.inf"
    if isinstance(value, (str, os.PathLike)):
        return json.dumps(os.fspath(value), ensure_ascii=False)
    raise TypeError(f"a scene holds numbers, words, lists and dicts, no {type(value).__name__}")


def _plain(value: Any) -> Any:
    """NumPy's numbers and arrays as Python's."""
    return value.tolist() if hasattr(value, "tolist") else value


def _flow(value: Any) -> str:
    value = _plain(value)
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_key(key)}: {_flow(entry)}" for key, entry in value.items()) + "}"
    if isinstance(value, Sequence) and not isinstance(value, str):
        return "[" + ", ".join(map(_flow, value)) + "]"
    return _scalar(value)


def _block(value: Any, indent: str) -> list[str]:
    """Lines of YAML with one key per line, so that line numbers in errors identify keys."""
    value = _plain(value)
    if isinstance(value, Mapping) and value:
        lines = []
        for key, entry in value.items():
            entry, name = _plain(entry), _key(key)
            nested = isinstance(entry, Mapping) or (isinstance(entry, Sequence) and not isinstance(entry, str)
                                                    and any(isinstance(item, Mapping) for item in entry))
            if nested and entry:
                lines += [f"{indent}{name}:", *_block(entry, indent + "  ")]
            else:
                lines.append(f"{indent}{name}: {_flow(entry)}")
        return lines
    if isinstance(value, Sequence) and not isinstance(value, str) and value:
        lines = []
        for entry in value:
            first, *rest = _block(entry, indent + "  ") if isinstance(entry, Mapping) and entry else [indent + "  " + _flow(entry)]
            lines += [f"{indent}- {first[len(indent) + 2:]}", *rest]
        return lines
    return [indent + _flow(value)]


def to_text(scene: Mapping[str, Any]) -> str:
    """A dict as the YAML that the loader reads."""
    return "\n".join(_block(scene, "")) + "\n"


class Scene:
    """A scene that has been read and checked.

    `source` is a path, a dict with the keys of a scene file, or a Scene. The key `drench: 1` of a dict may be left out.
    Each keyword in `overrides` is `key.path: value`, as in {"fluid.spacing": 0.02}. Raises SceneError.

    A dict may contain arrays instead of files: `{"mesh": {"points": (n, 3), "faces": (m, 3 or more), "uv": (n, 2)}}` for a
    cloth or a body, with `"attributes": {name: (n,)}` for painted regions, and the source
    `{"particles": (n, 3), "velocities": (n, 3)}`, in m and m/s.
    """

    def __init__(self, source: SceneLike, overrides: Mapping[str, Any] | None = None, *, name: str = "scene"):
        self._loaded: _core.Scene
        self._arrays = ArrayFiles()
        changes = [f"{key}={_flow(value)}" for key, value in (overrides or {}).items()]
        if isinstance(source, Scene):
            self._arrays = source._arrays
            self._loaded = source._loaded if not changes else _core.Scene.from_text(source.to_yaml(), source.path, changes)
        elif isinstance(source, Mapping):
            whole = self._arrays.written_in(source if "drench" in source else {"drench": 1, **source})
            self._loaded = _core.Scene.from_text(to_text(whole), name, changes)
        else:
            self._loaded = _core.Scene.from_file(os.fspath(source), changes)

    @classmethod
    def from_yaml(cls, text: str, name: str = "scene") -> Scene:
        """A scene from the text of a scene file. Errors refer to it as `name`; relative mesh files are searched in the folder of that path."""
        scene = cls.__new__(cls)
        scene._arrays = ArrayFiles()
        scene._loaded = _core.Scene.from_text(text, name, [])
        return scene

    def to_yaml(self) -> str:
        """The scene as YAML with all default values."""
        return self._loaded.to_yaml()

    @property
    def path(self) -> str:
        """The file of the scene, or the name that errors use for it."""
        return self._loaded.path

    @property
    def time_step(self) -> float:
        """Value of time.step, s."""
        return self._loaded.step

    @property
    def particle_diameter(self) -> float:
        """Value of fluid.spacing, m."""
        return self._loaded.particle_diameter

    @property
    def end(self) -> float:
        """Value of time.end, s."""
        return self._loaded.end

    @property
    def output_every(self) -> float:
        """Value of output.every, s; 0 for no frames."""
        return self._loaded.output_every

    @property
    def cloth_names(self) -> list[str]:
        """The names of the cloths, in order."""
        return self._loaded.cloth_names

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the scene file, and its arrays as PLY files to the folder `NAME_arrays` beside it."""
        file = Path(path)
        text = self.to_yaml()
        if self._arrays.folder:
            folder = file.with_name(file.stem + "_arrays")
            folder.mkdir(parents=True, exist_ok=True)
            for name, content in self._arrays.contents().items():
                (folder / name).write_bytes(content)
            text = text.replace(str(self._arrays.folder), folder.name)
        file.write_text(text, encoding="utf-8")

    def __reduce__(self) -> tuple[Any, ...]:
        folder = self._arrays.folder
        return _loaded_again, (self.to_yaml(), self.path, str(folder) if folder else "", self._arrays.contents())

    def __deepcopy__(self, memo: dict[int, Any]) -> Scene:
        return self  # a scene does not change

    def __repr__(self) -> str:
        return f"<drench.Scene {self.path}: {self.end:g} s>"


def _loaded_again(text: str, path: str, folder: str, files: dict[str, bytes]) -> Scene:
    """A scene from what __reduce__ gives, with files of its own for the arrays."""
    arrays = ArrayFiles()
    for name, content in files.items():
        arrays.path(name).write_bytes(content)
    scene = Scene.from_yaml(text.replace(folder, str(arrays.folder)) if folder else text, path)
    scene._arrays = arrays
    return scene
