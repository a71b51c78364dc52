"""The cache folder of a scene: the scene file, meshes, frames and a record of the bake. Does not need Blender.

    bake.json      what was baked, and how far; the mark of a cache folder
    scene.yaml     the scene file, with its meshes in meshes/
    run/           the output folder of the program
    drench.log     what the program printed"""

import json
import os
import shutil
from pathlib import Path

from . import frames
from .problem import Names, Problem

FORMAT = 1
OWN = ("bake.json", "scene.yaml", "drench.log", "meshes", "run", "check")


class Cache:
    def __init__(self, folder):
        self.folder = Path(folder)
        self._lists = {}  # of frames: {series: (time of the file, {number: path})}
        self._record = (None, None)

    @property
    def run(self):
        return self.folder / "run"

    @property
    def log(self):
        return self.folder / "drench.log"

    def record(self):
        """The contents of bake.json, or None without a bake."""
        path = self.folder / "bake.json"
        try:
            stamp = path.stat().st_mtime_ns
            if self._record[0] != stamp:
                self._record = stamp, json.loads(path.read_text(encoding="utf-8"))
        except FileNotFoundError:
            return None
        except (OSError, ValueError) as error:
            raise Problem(f"{path}: cannot be read ({error}): delete the cache and bake again") from None
        if not isinstance(self._record[1], dict) or self._record[1].get("drench_cache") != FORMAT:
            raise Problem(f"{path}: was written by another version of the extension: delete the cache and bake again")
        return self._record[1]

    def write_record(self, record):
        """Replaces bake.json in one step, so that a crash leaves the old or the new one."""
        path = self.folder / "bake.json"
        part = path.with_suffix(".part")
        part.write_text(json.dumps({"drench_cache": FORMAT, **record}), encoding="utf-8")
        os.replace(part, path)

    def set_status(self, status, **more):
        self.write_record({**self.record(), "status": status, **more})

    def names(self):
        record = self.record()
        return Names(**record["names"]) if record else Names()

    def frames(self, series):
        """{number: path} of the complete frames of "cloth", "fluid" or "surface"."""
        try:
            stamp = (self.run / f"{series}.pvd").stat().st_mtime_ns
        except OSError:
            return {}
        if self._lists.get(series, (None,))[0] != stamp:
            self._lists[series] = stamp, frames.listed_frames(self.run, series)
        return self._lists[series][1]

    def frames_done(self):
        """How many frames all series have."""
        counts = [len(found) for series in ("cloth", "fluid", "surface") if (found := self.frames(series))]
        return min(counts, default=0)

    def listed(self):
        """How many entries each list of the run has: {series: number}."""
        return {path.stem: path.read_text(encoding="utf-8").count("<DataSet ") for path in self.run.glob("*.pvd")}

    def has_checkpoint(self):
        return any(self.run.glob("checkpoint_*.drench"))

    def prepare(self):
        """Makes the folder; rejects one that holds other files than those of a bake."""
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            others = [path.name for path in self.folder.iterdir() if path.name not in (*OWN, "bake.part")]
        except OSError as error:
            raise Problem(f"the cache folder {self.folder} cannot be used: {error.strerror}: choose another "
                          "one") from None
        if others and not (self.folder / "bake.json").exists():
            raise Problem(f"the cache folder {self.folder} holds other files, such as {sorted(others)[0]}: choose an "
                          "empty or new folder")

    def check_folder(self):
        """An empty folder in this one for the files of an export, which leaves a bake as it is."""
        self.prepare()
        folder = self.folder / "check"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        return folder

    def remove_check_folder(self):
        shutil.rmtree(self.folder / "check", ignore_errors=True)
        self._remove_if_empty()

    def replace_by(self, folder, record):
        """Removes an earlier bake and takes over the files that an export wrote into `folder`."""
        for name in OWN:
            if self.folder / name != folder:
                self._remove(name)
        for path in folder.iterdir():
            path.rename(self.folder / path.name)
        self.write_record(record)
        self._lists.clear()

    def _remove(self, name):
        """Returns whether there was a file or folder of that name."""
        path = self.folder / name
        if path.is_dir():
            shutil.rmtree(path)
        elif path.exists():
            path.unlink()
        else:
            return False
        return True

    def _remove_if_empty(self):
        """Removes the folder, and the folder drench_cache around it, if nothing is left in them."""
        folders = [self.folder, *([self.folder.parent] if self.folder.parent.name == "drench_cache" else [])]
        for folder in folders:
            if folder.is_dir() and not any(folder.iterdir()):
                folder.rmdir()

    def remove_unfinished_files(self):
        """Removes frames that the program was writing when it was ended by force."""
        for path in [*self.run.glob(".*.part"), *(self.run / "frames").glob(".*.part")]:
            path.unlink(missing_ok=True)

    def delete(self):
        """Removes everything that a bake wrote, and nothing else. Returns whether there was something."""
        existed = [self._remove(name) for name in OWN]
        self._remove_if_empty()
        self._lists.clear()
        return any(existed)
