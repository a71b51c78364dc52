"""The files of a run: frames and tables in a folder, its report, and a picture."""

from __future__ import annotations

import os
from pathlib import Path
from types import TracebackType

from . import _core


class Recording:
    """A run whose steps are written to a folder until close(), or until the `with` block ends. Simulation.record makes it."""

    def __init__(self, run: _core.Run, folder: str | os.PathLike[str], overwrite: bool):
        run.record(os.fspath(folder), overwrite)
        self._run = run
        self._open = True
        #: The folder, as `drench report`, `drench view` and `drench export` read it.
        self.folder = Path(folder)

    def close(self) -> None:
        """Add the last frame and write report.html. Does nothing the second time."""
        if self._open:
            self._open = False
            self._run.end_record()

    def __enter__(self) -> Recording:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<drench.Recording {self.folder}{'' if self._open else ', closed'}>"


def write_report(folder: str | os.PathLike[str], file: str | os.PathLike[str] | None = None, *,
                 other: str | os.PathLike[str] | None = None) -> Path:
    """Write a run as one HTML page, as `drench report` does, and return its path.

    folder: the output of a run, by Simulation.record or `drench run`.
    file: the page; by default report.html in that folder.
    other: a second run to compare with.

    Raises Error for a folder without a run.
    """
    path = Path(folder) / "report.html" if file is None else Path(file)
    _core.write_report(os.fspath(folder), os.fspath(path), None if other is None else os.fspath(other))
    return path


def write_picture(folder: str | os.PathLike[str], file: str | os.PathLike[str], *, size: tuple[int, int] = (1200, 960)) -> Path:
    """Paint the last frame of a run as a PNG, without a display, and return its path.

    folder: the output of a run, by Simulation.record or `drench run`.
    size: width and height in pixels, from 16 to 4096.

    Raises Error for a folder without a run.
    """
    width, height = size
    if not (16 <= width <= 4096 and 16 <= height <= 4096):
        raise ValueError(f"size: width and height from 16 to 4096 pixels are allowed, these are {width} and {height}")
    _core.write_picture(os.fspath(folder), os.fspath(file), int(width), int(height))
    return Path(file)
