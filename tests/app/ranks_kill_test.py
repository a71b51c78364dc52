#!/usr/bin/env python3
"""ranks_kill_test.py SOURCE BUILD [--kills N] [--ranks N] [--seed N]: SIGKILL of one rank of `mpirun -n 2 drench run` at random
moments. All ranks end, the newest checkpoint is whole, and what goes on from it ends with the bytes of a run that nobody
disturbed."""

import argparse
import os
import random
import shutil
import signal
import subprocess
import tempfile
import time
from pathlib import Path

from support import BINARY, call, skip, stats

LONGEST = 30  # s, until all ranks have ended

SCENE = """drench: 1
time: {step: 0.003, end: 0.09}
domain: {min: [-0.4, -0.1, -0.4], max: [0.4, 0.5, 0.4]}
output: {every: 0.01, checkpoint_every: 0.006}
fluid:
  spacing: 0.02
  viscosity: 1.0e-4
  sources:
    - block: {min: [-0.08, 0.21, -0.04], max: [0.08, 0.25, 0.04], velocity: [0, -1.5, 0]}
    - jet: {center: [0.02, 0.3, 0], radius: 0.03, velocity: [0, -2, 0], end: 0.08}
cloth:
  - mesh: {grid: {size: [0.2, 0.2], nodes: [9, 9]}}
    place: {position: [0, 0.2, 0]}
    thickness: 0.002
    pin: [{corners: true}]
    initial_saturation: [{box: {min: [-1, -1, -1], max: [0, 1, 1]}, value: 1.1}]
    porous: {diffusivity: 1.0e-3, emission_velocity: 2}
bodies:
  - sphere: {center: [0, 0.13, 0], radius: 0.05, dynamic: true, density: 600}
  - plane: {point: [0, 0, 0], normal: [0, 1, 0]}
"""


def set_up_mpi():
    """As root, more ranks than cores, and ranks that wait give way: in the words of Open MPI 4 and 5."""
    for name in ("OMPI_ALLOW_RUN_AS_ROOT", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "PRTE_ALLOW_RUN_AS_ROOT",
                 "PRTE_ALLOW_RUN_AS_ROOT_CONFIRM", "OMPI_MCA_rmaps_base_oversubscribe", "OMPI_MCA_mpi_yield_when_idle"):
        os.environ.setdefault(name, "1")
    os.environ.setdefault("OMPI_MCA_hwloc_base_binding_policy", "none")
    os.environ.setdefault("PRTE_MCA_hwloc_default_binding_policy", "none")
    os.environ.setdefault("PRTE_MCA_rmaps_default_mapping_policy", ":oversubscribe")


def results_in(folder):
    """{file: what was computed}: frames, collections and checkpoints in bytes, stats.csv without its wall times."""
    results = {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*"))
               if path.is_file() and path.name not in ("run.log", "scene.yaml", "stats.csv")}
    results["stats.csv"] = [[text for name, text in row.items() if not name.startswith("ms_") and name != "imbalance"]
                            for row in stats(folder)]
    return results


def difference(folder, other):
    """The files that differ; none if both have computed the same."""
    one, two = results_in(folder), results_in(other)
    return [name for name in sorted(one.keys() | two.keys()) if one.get(name) != two.get(name)]


def rows(folder):
    try:
        return max(0, (folder / "stats.csv").read_bytes().count(b"\n") - 1)
    except FileNotFoundError:
        return 0


def checkpoints(folder):
    return sorted(folder.glob("checkpoint_*.drench"), reverse=True)


def started_by(launcher, program):
    """The ranks: processes of `program` below the launcher. One that has only been forked is still the launcher's program."""
    parents = {}
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            parents[int(entry.name)] = int((entry / "stat").read_text().rsplit(")", 1)[1].split()[1])
        except (OSError, ValueError):
            continue
    found = []
    for pid in parents:
        above = pid
        while above in parents and above != launcher:
            above = parents[above]
        try:
            if pid != launcher and above == launcher and Path(f"/proc/{pid}/exe").resolve() == program:
                found.append(pid)
        except OSError:
            continue
    return sorted(found)


def has_ended(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] in "ZX"
    except OSError:
        return True


class Test:
    def __init__(self, folder, program, ranks, seed):
        self.folder, self.program, self.ranks = folder, program, ranks
        self.random = random.Random(seed)
        self.kills = self.ended = self.from_scratch = self.before_all_ranks = 0
        self.longest = 0
        (folder / "scene.yaml").write_text(SCENE)
        self.out = folder / "o"

    def command(self, *arguments, ranks):
        words = ["mpirun", "-n", str(ranks)] if ranks > 1 else []
        return [*words, str(self.program), "run", "scene.yaml", "--threads", "1", *arguments]

    def start(self):
        kept = checkpoints(self.out)
        if not kept:
            shutil.rmtree(self.out, ignore_errors=True)
            self.from_scratch += 1
        where = ["--resume", "o"] if kept else ["-o", "o"]
        self.said = open(self.folder / "said", "w+")
        return subprocess.Popen(self.command(*where, ranks=self.ranks), cwd=self.folder, stdin=subprocess.DEVNULL,
                                stdout=self.said, stderr=subprocess.STDOUT)

    def what_was_said(self):
        self.said.seek(0)
        text = self.said.read()
        self.said.close()
        return text

    def wait(self, launcher, ranks):
        """Until the launcher and the ranks have ended."""
        begin = time.monotonic()
        while launcher.poll() is None or not all(map(has_ended, ranks)):
            if time.monotonic() - begin > LONGEST:
                left = [pid for pid in ranks if not has_ended(pid)]
                for pid in [launcher.pid] * (launcher.poll() is None) + left:
                    os.kill(pid, signal.SIGKILL)
                launcher.wait()
                raise AssertionError(f"ranks {left} still run {LONGEST} s after the kill:\n{self.what_was_said()}")
            time.sleep(0.01)
        self.longest = max(self.longest, time.monotonic() - begin)

    def kill_once(self):
        """A run from the newest checkpoint, killed some steps and a moment later."""
        from_row = rows(self.out) if checkpoints(self.out) else 0
        wanted = from_row + self.random.randint(0, 12)
        launcher = self.start()
        moment = None
        while launcher.poll() is None:
            now = time.monotonic()
            if moment is None and (wanted == from_row or rows(self.out) >= wanted):
                moment = now + self.random.uniform(0, 0.3)
            ranks = started_by(launcher.pid, self.program)
            if moment is not None and now >= moment and ranks:
                self.before_all_ranks += len(ranks) < self.ranks
                try:
                    os.kill(self.random.choice(ranks), signal.SIGKILL)
                except ProcessLookupError:
                    continue  # it has just ended
                self.wait(launcher, ranks)
                # A rank that had done all and was about to leave takes nothing along.
                self.kills += 1
                break
            time.sleep(0.002)
        code, said = launcher.wait(), self.what_was_said()
        assert "is damaged" not in said and "is not a checkpoint" not in said, said
        if code == 0:
            self.compare()

    def compare(self):
        self.ended += 1
        lines = difference(self.folder / "whole", self.out)
        assert not lines, f"after {self.kills} kills: {lines}"
        shutil.rmtree(self.out)

    def run(self, kills):
        subprocess.run(self.command("-o", "whole", "--quiet", ranks=1), cwd=self.folder, check=True)
        while self.kills < kills:
            self.kill_once()
        if self.out.exists():
            launcher = self.start()
            code = launcher.wait(timeout=300)
            assert code == 0, self.what_was_said()
            self.compare()
        print(f"{self.kills} kills, {self.ended} runs to the end, {self.from_scratch} starts without a checkpoint, "
              f"{self.before_all_ranks} kills before all ranks were there, all ended within {self.longest:.1f} s")

    def interrupt(self):
        """Ctrl-C at one rank is an orderly end of all, with a checkpoint."""
        shutil.rmtree(self.out, ignore_errors=True)
        launcher = self.start()
        while rows(self.out) < 5:
            assert launcher.poll() is None, self.what_was_said()
            time.sleep(0.002)
        ranks = started_by(launcher.pid, self.program)
        os.kill(ranks[-1], signal.SIGINT)
        self.wait(launcher, ranks)
        said = self.what_was_said()
        assert launcher.returncode == 130, (launcher.returncode, said)
        assert said.count("to continue: drench run scene.yaml --resume o\n") == 1, said
        assert int(checkpoints(self.out)[0].stem.split("_")[1]) == rows(self.out), (checkpoints(self.out), rows(self.out))
        launcher = self.start()
        assert launcher.wait(timeout=300) == 0, self.what_was_said()
        self.compare()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs=2, metavar="SOURCE BUILD")
    parser.add_argument("--kills", type=int, default=3)
    parser.add_argument("--ranks", type=int, default=2)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    set_up_mpi()
    if shutil.which("mpirun") is None:
        skip("no mpirun")
    if "ranks: none" in call(BINARY, "info").stdout:
        skip("the program knows no MPI")
    with tempfile.TemporaryDirectory() as folder:
        test = Test(Path(folder), BINARY, options.ranks, options.seed)
        test.run(options.kills)
        test.interrupt()


main()
