"""tools/bench's peers, other programs on its block: where they come from, their runs in turns with drench's, one table."""

import array
import json
import math
import os
import random
import statistics
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import measure

WARM_UP = 10  # steps that count for nothing
SAMPLES = 6  # of the liquid, evenly over a run
DRIVERS = measure.ROOT / "tools" / "measure" / "peers"


@dataclass(frozen=True)
class Peer:
    program: str  # its driver is drive_PROGRAM.py
    packages: tuple  # for pip
    imports: str  # what has to be there
    repository: str = ""  # of a program that is no package, and its commit
    commit: str = ""
    walls: str = ""  # where its driver knows more than one kind


SPLISHSPLASH = ("splishsplash", ("pysplishsplash==2.19.0", "numpy"), "numpy")  # not itself: drive_splishsplash.load
PEERS = {
    "splishsplash": Peer(*SPLISHSPLASH, walls="volume maps"),
    "splishsplash_akinci": Peer(*SPLISHSPLASH, walls="Akinci"),
    "genesis": Peer("genesis", ("genesis-world==1.4.5", "torch"), "genesis"),
    "sph_taichi": Peer("sph_taichi", ("taichi==1.7.4", "numpy", "trimesh", "matplotlib"), "taichi, trimesh, matplotlib",
                       "https://github.com/erizmr/SPH_Taichi", "4a701fdbabd8d88f17a8146b6e4d0a6cb55ae7ab")}


class Unavailable(Exception):
    """A peer that cannot run here, and why, in one line."""


# --- Where a peer comes from

def ran(command, **options):
    """Its output; Unavailable with the last line that it said where it fails."""
    try:
        done = subprocess.run([str(word) for word in command], capture_output=True, text=True, **options)
    except OSError as error:
        raise Unavailable(f"{command[0]}: {error.strerror}") from None
    if done.returncode != 0:
        raise Unavailable(measure.last_line(done.stderr + done.stdout, f"exit code {done.returncode}"))
    return done.stdout


def interpreter(peer, given, home):
    """The Python that has the peer's packages: the one given, or that of a virtual environment in `home`."""
    if given:
        python = os.path.abspath(given)  # a link into a virtual environment stays one
        ran([python, "-c", f"import {peer.imports}"])
        return python
    python = home / "venv" / "bin" / "python"
    ready = home / "venv" / "ready"
    wanted = "\n".join(peer.packages)
    if not ready.exists() or ready.read_text() != wanted:
        print(f"{peer.program}: pip installs {' '.join(peer.packages)} in {home / 'venv'} ...", file=sys.stderr, flush=True)
        ran([sys.executable, "-m", "venv", home / "venv"])
        ran([python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *peer.packages])
        ran([python, "-c", f"import {peer.imports}"])
        ready.write_text(wanted)
    return python


def source(peer, given, home):
    """The checkout of a peer that is no package: the one given, or a clone in `home`."""
    if not peer.repository:
        return ""
    folder = Path(given) if given else home / "source"
    if not given and not folder.exists():
        ran(["git", "clone", "--quiet", peer.repository, folder])
        ran(["git", "-C", folder, "checkout", "--quiet", peer.commit])
    if not folder.is_dir():
        raise Unavailable(f"{folder}: no such folder")
    return str(folder.resolve())


# --- Runs

class PeerProgram:
    def __init__(self, name, python=None, checkout=None):
        self.name, self.peer = name, PEERS[name]
        home = measure.ROOT / "build" / "peers" / self.peer.program
        try:
            self.python = interpreter(self.peer, python, home)
            self.source = source(self.peer, checkout, home)
        except Unavailable as reason:
            raise Unavailable(f"peer {name}: {reason}") from None

    def run(self, block, steps, threads, gpu, folder, sample_every):
        """Steps, and samples where sample_every is not 0."""
        folder.mkdir()
        description = {**block.description(), "steps": steps, "sample_every": sample_every, "threads": threads,
                       "device": "gpu" if gpu else "cpu", "source": self.source, "walls": self.peer.walls}
        (folder / "block.json").write_text(json.dumps(description))
        try:
            ran([self.python, DRIVERS / f"drive_{self.peer.program}.py", folder / "block.json", folder], cwd=folder,
                env={**os.environ, "OMP_NUM_THREADS": str(threads), "PYTHONDONTWRITEBYTECODE": "1"})
            result = json.loads((folder / "result.json").read_text())
        except (Unavailable, OSError, ValueError) as reason:
            raise Unavailable(f"peer {self.name}: {reason}") from None
        for sample in result["samples"]:
            sample["positions"] = array.array("f", (folder / f"positions_{sample['step']}").read_bytes())
        return result


class Drench:
    def __init__(self, binary, settings=()):
        self.binary, self.settings = binary, list(settings)

    def run(self, block, steps, threads, gpu, folder, sample_every):
        """As PeerProgram's. Frames take time: a run with samples is not one to time."""
        scene = folder.with_suffix(".yaml")
        scene.write_text(block.scene())
        frames = [f"output.every={sample_every * block.step!r}"] if sample_every else []
        done = measure.Run(self.binary, scene, folder, threads, steps, self.settings + frames)
        if done.problem:
            raise Unavailable(f"drench: {done.problem}")
        rows = [{"ms": float(row["ms_step"]), "density_iterations": int(row["density_iterations"]),
                 "divergence_iterations": int(row["divergence_iterations"])} for row in done.rows]
        samples = []
        for time, path in measure.frames(folder, "fluid")[1:] if sample_every else []:
            frame = measure.read_frame(path, ("density",))
            over = [max(0.0, density / 1000 - 1) for density in frame["density"]]
            samples.append({"step": round(time / block.step), "compression": statistics.fmean(over),
                            "positions": frame["points"]})
        return {"steps": rows, "samples": samples, "program": "drench", "particles": int(float(done.rows[-1]["particles"])),
                "volume": block.spacing**3}


def in_turns(programs, block, steps, runs, threads, gpu, folder):
    """Of each program the results of its runs, one program after the other in every round, and of one more, sampled."""
    results = [[] for _ in programs]
    every = max(1, steps // SAMPLES)
    for turn in range(runs + 1):
        sampled = turn == runs
        for number, (program, of_program) in enumerate(zip(programs, results)):
            of_program.append(program.run(block, steps, threads, gpu, folder / f"{number}_{turn}", every if sampled else 0))
            done = of_program[-1]
            if not sampled:
                print(f"{done['program']}: {least_ms([done]):.4g} ms per step", file=sys.stderr, flush=True)
    return results


# --- One judge for all

def cubic(r, h):
    """The cubic kernel, 1/m³."""
    xi = r / h
    shape = 6 * (xi - 1) * xi * xi + 1 if xi < 0.5 else 2 * (1 - xi)**3
    return 8 / math.pi / h**3 * shape


def judge(positions, volume, h, box, most=8192):
    """Of positions (x, y, z, x, …): liquid neighbours of a particle within h, mean compression of those that are farther
    than h from the box's walls, and mean height. It looks at `most` particles, by the same draw each time."""
    points = list(zip(*[iter(positions)] * 3))
    cells = {}
    for point in points:
        cells.setdefault(tuple(math.floor(x / h) for x in point), []).append(point)
    pairs, over, inside, looked = 0, 0.0, 0, 0
    around = [(i, j, k) for i in (-1, 0, 1) for j in (-1, 0, 1) for k in (-1, 0, 1)]
    for point in random.Random(0).sample(points, min(most, len(points))):
        x, y, z = point
        cell = tuple(math.floor(c / h) for c in point)
        near = []
        for i, j, k in around:
            for a, b, c in cells.get((cell[0] + i, cell[1] + j, cell[2] + k), ()):
                r2 = (a - x)**2 + (b - y)**2 + (c - z)**2
                if r2 < h * h:
                    near.append(r2)
        looked += 1
        pairs += len(near) - 1  # itself
        if all(h <= c <= side - h for c, side in zip(point, box)):
            inside += 1
            over += max(0.0, volume * sum(cubic(math.sqrt(r2), h) for r2 in near) - 1)
    return pairs / looked, over / inside if inside else math.nan, statistics.fmean(point[1] for point in points)


def least_ms(results):
    """Of the runs' medians: other work on the machine makes them longer, never shorter."""
    return min(statistics.median(step["ms"] for step in result["steps"][WARM_UP:]) for result in results)


def row(results, block):
    """A row of the table: a program's timed runs, and the last one for what the liquid does."""
    *timed, sampled = results
    steps = [step for result in timed for step in result["steps"][WARM_UP:]]
    judged = [judge(sample["positions"], sampled["volume"], block.support, block.description()["box"])
              for sample in sampled["samples"]]
    mean = lambda key: statistics.fmean(step[key] for step in steps)
    return {"program": sampled["program"], "particles": sampled["particles"], "ms": least_ms(timed),
            "density_iterations": mean("density_iterations"), "divergence_iterations": mean("divergence_iterations"),
            "own_error": statistics.fmean(sample["compression"] for sample in sampled["samples"]),
            "error": statistics.fmean(one[1] for one in judged), "neighbors": statistics.fmean(one[0] for one in judged),
            "height": judged[-1][2]}


# --- The table

def ns_particle(r):
    return 1e6 * r["ms"] / r["particles"]


def print_rows(rows):
    cells = [[r["program"], f"{r['particles']:,}", f"{r['neighbors']:.1f}", f"{r['ms']:.4g}", f"{ns_particle(r):.0f}",
              f"{1e-3 * r['particles'] / r['ms']:.3g}", f"{1e-6 * r['particles'] * r['neighbors'] / r['ms']:.3g}",
              f"{r['density_iterations']:.2f}", f"{r['divergence_iterations']:.2f}", f"{r['error']:.1e}",
              f"{r['own_error']:.1e}", f"{r['height']:.3f}"] for r in rows]
    measure.table(["program", "particles", "neighbours per particle", "ms per step", "ns per particle and step",
                   "million particle-steps per second", "GPIPS", "density iterations", "divergence iterations",
                   "density error", "density error, its own", "height of the centre at the end (m)"], cells)


def wins(ours, theirs):
    """In which respects a peer is better, as text, and by how much."""
    named = (("time per particle", ns_particle, "{:.0f} ns"), ("density iterations", lambda r: r["density_iterations"], "{:.2f}"),
             ("divergence iterations", lambda r: r["divergence_iterations"], "{:.2f}"),
             ("density error", lambda r: r["error"], "{:.1e}"))
    return [f"{name} ({form.format(of(theirs))} against {form.format(of(ours))})"
            for name, of, form in named if form.format(of(theirs)) != form.format(of(ours)) and of(theirs) < of(ours)]


def print_verdicts(rows):
    """A line a peer: the first row is drench's."""
    ours = rows[0]
    for theirs in rows[1:]:
        factor = ns_particle(theirs) / ns_particle(ours)
        fast = f"drench is {factor:.2f} times as fast" if factor >= 1 else f"drench is {1 / factor:.2f} times as **slow**"
        better = wins(ours, theirs)
        print(f"- {theirs['program']}: {fast} per particle. "
              f"{theirs['program']} wins in: {', '.join(better) or 'nothing of this table'}.")
