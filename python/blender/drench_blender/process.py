"""A bake as a process: start, progress, stop, and what is left of an earlier session. Does not need Blender."""

import os
import re
import signal
import subprocess
import time
from pathlib import Path

from .problem import Problem, with_names
from .program import HIDDEN

SECONDS_TO_STOP = 20  # the program ends its step and writes a checkpoint; then it is killed
SECONDS_TO_CLOSE = 5
INTERRUPTED = 130  # exit code of the program after SIGTERM


class Bake:
    """A running bake. Call poll() regularly until it returns false; `status` is then finished, stopped or failed.

    `phase`: what it does while it computes no frames."""

    def __init__(self, cache, resume):
        self.cache = cache
        self.status, self.error, self.phase = "running", "", ""
        self.began, self.stop_after = time.monotonic(), None
        self.frames_before = cache.frames_done() if resume else 0
        cache.remove_unfinished_files()

    def frames(self):
        """(frames that are complete, frames in all)"""
        return self.cache.frames_done(), self.cache.record()["frames"]

    def seconds_left(self):
        """Estimated from the frames of this session, or None before there are two."""
        done, total = self.frames()
        computed = done - self.frames_before
        if computed < 2:
            return None
        return (time.monotonic() - self.began) * (total - done) / computed

    def end(self, code, stopped_by=(INTERRUPTED, -signal.SIGTERM)):
        """Sets the status by the exit code of the program."""
        self.cache.remove_unfinished_files()
        if code == 0:
            self.status = "finished"
        elif self.stop_after is not None or code in stopped_by:
            self.status = "stopped"
        else:
            self.status, self.error = "failed", self._last_error(code)
        self.cache.set_status(self.status, pid=None)

    def _last_error(self, code):
        lines = [line for line in messages(self.cache) if not line.startswith("warning: ")]
        return lines[-1] if lines else f"the program ended with exit code {code}: see {self.cache.log}"


class LocalBake(Bake):
    """A bake by a program of this computer."""

    def __init__(self, program, cache, threads=0, resume=False):
        super().__init__(cache, resume)
        words = [program, "run", "scene.yaml"]
        words += ["--resume", "run"] if resume and cache.has_checkpoint() else ["-o", "run", "--overwrite"]
        words += ["--threads", str(threads)] if threads > 0 else []
        try:
            with open(cache.log, "ab" if resume else "wb") as log:
                self.process = subprocess.Popen(words, cwd=cache.folder, stdin=subprocess.DEVNULL, stdout=log,
                                                stderr=subprocess.STDOUT, **HIDDEN)
        except OSError as error:
            raise Problem(f"{program} cannot be started: {error.strerror}: check the path in the preferences") from None
        cache.set_status("running", pid=self.process.pid)

    def poll(self):
        """Whether the process still runs."""
        if self.status != "running":
            return False
        code = self.process.poll()
        if code is None:
            if self.stop_after is not None and time.monotonic() > self.stop_after:
                self.process.kill()
            return True
        self.end(code)
        return False

    def ask_to_stop(self):
        """Returns at once. On Windows the process is ended by force and continues from its last regular checkpoint."""
        if self.stop_after is None and self.process.poll() is None:
            self.stop_after = time.monotonic() + SECONDS_TO_STOP
            self.process.terminate()

    def stop(self, seconds=SECONDS_TO_STOP):
        """Returns when the process has ended, which takes at most about `seconds`."""
        self.ask_to_stop()
        try:
            self.process.wait(seconds)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self.poll()

    def close(self):
        """For the end of Blender or of its file, after which nobody could stop the process."""
        self.stop(SECONDS_TO_CLOSE)


def messages(cache):
    """Warnings and errors that the program has printed, with the names of objects."""
    try:
        lines = cache.log.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return []
    return chosen_messages(lines, cache.names())


def chosen_messages(lines, names):
    found = [line for line in lines
             if line.startswith(("warning: ", "error: ", "drench: ", "scene.yaml:")) or ".yaml:" in line[:200]]
    return list(dict.fromkeys(with_names(re.sub(r"^drench: (?=warning: )", "", line), names) for line in found))


def _command_line(pid):
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes().replace(b"\0", b" ").decode("utf-8", "replace")
    except OSError:
        pass
    if os.name == "posix" and not Path("/proc/self").exists():
        return subprocess.run(["ps", "-p", str(pid), "-o", "command="], capture_output=True, text=True,
                              check=False).stdout
    return ""


def left_over(cache):
    """The id of a process that still bakes into this cache after its Blender crashed, or None."""
    try:
        record = cache.record()
    except Problem:
        return None  # a damaged record must not keep the user from deleting the cache
    pid = record.get("pid") if record else None
    if not pid or record.get("status") != "running":
        return None
    words = _command_line(pid)
    if " run scene.yaml" not in words:
        return None
    try:  # another program may have the same id and words: compare the folder where the system shows it
        if not os.path.samefile(os.readlink(f"/proc/{pid}/cwd"), cache.folder):
            return None
    except OSError:
        pass
    return pid


def end_left_over(cache):
    """Stops such a process, which would write to the same frames."""
    pid = left_over(cache)
    if pid is None:
        return
    try:
        os.kill(pid, signal.SIGTERM)
        deadline = time.monotonic() + SECONDS_TO_STOP
        while _still_runs(cache, pid) and time.monotonic() < deadline:
            time.sleep(0.05)
        if _still_runs(cache, pid):
            os.kill(pid, signal.SIGKILL if hasattr(signal, "SIGKILL") else signal.SIGTERM)
    except ProcessLookupError:
        pass  # it ended by itself
    except PermissionError:
        raise Problem(f"process {pid} of another user bakes into {cache.folder}: choose another folder") from None
    cache.set_status("stopped", pid=None)


def _still_runs(cache, pid):
    return left_over(cache) is not None and _state(pid) != "Z"


def _state(pid):
    """The letter of the state of a process, where the system shows it."""
    try:
        return Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rsplit(")", 1)[1].split()[0]
    except (OSError, IndexError):
        return ""
