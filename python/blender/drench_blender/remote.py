"""A bake on another machine: uploads the scene, starts the program there, and fetches frames as they are completed.

The run there outlives the connection, the file and Blender. Does not need Blender."""

import os
import re
import secrets
import subprocess
import tempfile
import threading
import time

from . import machine, process
from .problem import Problem

PAUSES = (1, 5, 15, 30)  # seconds before each attempt to connect again
SECONDS_TO_HANG_UP = 5
NO_CODE = -1  # a run that was ended together with the shell that waits for it
FILE = re.compile(r"drench\.log|run/(?:frames/)?\w[\w.]*", re.ASCII)  # what the other machine may write here


class Lost(Exception):
    """The connection ended before the run did."""


def new_name(cache):
    """A folder on the other machine that no other bake uses."""
    return re.sub(r"\W+", "_", f"bake_{cache.folder.name[:40]}_{secrets.token_hex(4)}", flags=re.ASCII)


def left_there(cache):
    """{"host", "name"} of a bake whose files are on another machine, or None."""
    try:
        found = (cache.record() or {}).get("remote")
    except Problem:
        return None  # a damaged record must not keep the user from deleting the cache
    valid = isinstance(found, dict) and isinstance(found.get("name"), str) and machine.NAME.fullmatch(found["name"])
    return found if valid else None


class RemoteBake(process.Bake):
    """`place`: a Machine. The record keeps its host and the name of the folder there.

    A thread reads the connection. It sets `code` if the run has ended, or `problem`."""

    def __init__(self, place, cache, threads=0, resume=False):
        super().__init__(cache, resume)
        self.place, self.threads, self.phase = place, threads, f"connecting to {place.host}"
        self.before = cache.record()
        there = left_there(cache)
        self.name = there["name"] if there else new_name(cache)
        (cache.run / "frames").mkdir(parents=True, exist_ok=True)
        cache.set_status("running", remote={"host": place.host, "name": self.name})
        self.started, self.code, self.problem = False, None, None
        self.connection, self.leaving = None, threading.Event()
        self.thread = threading.Thread(target=self._work, args=(not there,), daemon=True)
        self.thread.start()

    def poll(self):
        """Whether the run is followed."""
        if self.status != "running" or self.thread.is_alive():
            return self.status == "running"
        if self.code is not None:
            self.end(self.code, (process.INTERRUPTED, 128 + 15))
            if self.code == NO_CODE:
                self.error = (f"the run on {self.place.host} ended without a result, for example because the machine "
                              "was restarted or its disk is full: press Continue")
            elif self.status == "failed":
                self.error = str(self.place.problem(self.error))
            elif self.status == "finished":
                self._remove_there()
            return False
        self.cache.remove_unfinished_files()
        if self.problem is not None:
            self.status, self.error = "failed", str(self.problem)
        else:
            self.status = "left" if self.stop_after is None else "stopped"
        if not self.started:
            self.cache.set_status("stopped" if self.status == "stopped" else self.before["status"])
        elif self.status == "stopped":
            self.cache.set_status("stopped")
        return False

    def ask_to_stop(self):
        if self.stop_after is None and self.thread.is_alive():
            self.stop_after = time.monotonic() + process.SECONDS_TO_STOP
            threading.Thread(target=self._stop_there, args=(process.SECONDS_TO_STOP,), daemon=True).start()

    def stop(self, seconds=process.SECONDS_TO_STOP):
        self.stop_after = time.monotonic() + seconds
        self._stop_there(seconds)
        self.thread.join(seconds + SECONDS_TO_HANG_UP)
        self.close()

    def close(self):
        """Leaves the run alone, for the end of Blender or of its file."""
        self._hang_up()
        self.thread.join(SECONDS_TO_HANG_UP)
        self.poll()

    def _stop_there(self, seconds):
        if not self.started:
            self._hang_up()
        try:
            self.place.stop(self.name, seconds)
        except Problem as problem:
            if self.started:
                self.problem = Problem(f"{problem}. The bake goes on there: press Continue, then Cancel")
                self._hang_up()

    def _remove_there(self):
        """All has arrived. A folder that cannot be removed now is removed with the cache."""
        try:
            self.place.remove(self.name)
            self.cache.set_status("finished", remote=None)
        except Problem:
            pass

    def _hang_up(self):
        self.leaving.set()
        if self.connection is not None:
            self.connection.kill()

    # In the thread.

    def _work(self, upload):
        pauses, start = iter(PAUSES), True
        while not self.leaving.is_set():
            try:
                done = self.cache.frames_done()
                result = self._connect(upload, start)
                if result != "upload":
                    self.code = result
                    return
                upload = True
                continue
            except Lost as lost:
                problem = lost.args[0]
            except (Problem, OSError) as error:
                self._give_up(error)
                return
            if self.cache.frames_done() > done:
                pauses = iter(PAUSES)
            pause = next(pauses, None)
            if not self.started or pause is None:
                self._give_up(problem)
                return
            upload = start = False  # a run that has ended meanwhile must not start again
            self.phase = f"the connection to {self.place.host} was lost, trying again"
            self.leaving.wait(pause)

    def _give_up(self, error):
        if self.leaving.is_set():
            return
        text = str(error)
        if isinstance(error, OSError):
            text = f"{self.cache.folder}: {error.strerror or error}: check the cache folder and the disk"
        if self.started:
            text += ". The bake goes on there: press Continue to fetch its frames"
        self.problem = Problem(text)

    def _connect(self, upload, start):
        """One connection, until the run ends. Returns its exit code, or "upload" if the scene is not there."""
        values = {f"have_{series}": count for series, count in self.cache.listed().items()}
        values.update(every=self.before["every"], uploaded="yes" if upload else "", start="yes" if start else "",
                      threads=f"--threads {self.threads}" if self.threads > 0 else "")
        script = (machine.UPLOAD if upload else "") + machine.START + machine.FOLLOW
        with tempfile.TemporaryFile() as errors, machine.packed(self.cache.folder, upload) as source:
            if upload:
                self.phase = f"uploading to {self.place.host}"
            with self.place.open(script, self.name, source, errors, **values) as self.connection:
                try:
                    if not self.leaving.is_set():
                        return self._read(self.connection.stdout)
                except EOFError:
                    try:
                        self.connection.wait(SECONDS_TO_HANG_UP)  # for its message
                    except subprocess.TimeoutExpired:
                        pass
                finally:
                    self.connection.kill()
            errors.seek(0)
            raise Lost(self.place.problem(errors.read().decode("utf-8", "replace")))

    def _read(self, out):
        """What `machine.FOLLOW` sends. EOFError: the connection has ended."""
        while (line := out.readline()) != machine.MARK:
            if not line:
                raise EOFError
        while line := out.readline():
            word, *rest = line.decode("ascii", "replace").split() or [""]
            if word == "file" and len(rest) == 2 and rest[0].isdigit():
                self._receive(out, int(rest[0]), rest[1])
            elif word == "exit" and (not rest or rest[0].isdigit()):
                return int(rest[0]) if rest else NO_CODE
            elif word == "upload":
                return word
            elif word == "started":
                self.started, self.phase, self.began = True, "", time.monotonic()
            elif word != "wait":
                raise Lost(Problem(f"{self.place.host} sent unreadable data"))
        raise EOFError

    def _receive(self, out, size, name):
        """A file comes under a temporary name, so that there is never half of one."""
        if not FILE.fullmatch(name):
            raise Problem(f"{self.place.host} sent a file with an unknown name: {name[:100]}")
        part = self.cache.run / f".{os.path.basename(name)}.part"
        try:
            with open(part, "wb") as file:
                while size > 0:
                    data = out.read(min(size, 1 << 20))
                    if not data:
                        raise EOFError
                    file.write(data)
                    size -= len(data)
            os.replace(part, self.cache.folder / name)
        finally:
            part.unlink(missing_ok=True)
