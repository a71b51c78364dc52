"""python -m drench.demo: run the scene of the README, and write its frames, a report and a picture.

    python -m drench.demo                       # the whole scene, into ./drench_demo
    python -m drench.demo --until 0.5 -o half   # the first half second, into ./half

No display, compiler or further package is needed. The exit code is 2 for invalid options, and 1 for a run that failed.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Sequence
from typing import NoReturn

import drench

SCENE = "water_on_cloth.yaml"
PICTURE = "picture.png"
EXIT_FAILED, EXIT_USAGE = 1, 2  # as those of the command `drench`


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        print(f"drench.demo: {message}", file=sys.stderr)
        sys.exit(EXIT_USAGE)


def _count(text: str) -> int:
    value = int(text) if text.isdecimal() else 0
    if not 1 <= value <= 1_000_000_000:
        raise argparse.ArgumentTypeError(f"'{text}' is not a whole number above 0")
    return value


def _seconds(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0 < value <= 1000:
        raise argparse.ArgumentTypeError(f"'{text}' is not a time above 0 and up to 1000 s")
    return value


def _options(words: Sequence[str] | None) -> argparse.Namespace:
    parser = _Parser(prog="python -m drench.demo", allow_abbrev=False,
                     description="Run a jet of water on a pinned cloth, and write frames, a report and a picture.")
    parser.add_argument("-o", "--output", default="drench_demo", metavar="FOLDER", help="where to write (default: drench_demo)")
    parser.add_argument("--overwrite", action="store_true", help="replace the files of an earlier run in that folder")
    parser.add_argument("--until", type=_seconds, metavar="TIME", help="end of the simulated time, s (default: 1.5)")
    parser.add_argument("--steps", type=_count, metavar="N", help="at most so many steps")
    parser.add_argument("--threads", type=_count, metavar="N", help="number of threads (default: OMP_NUM_THREADS, or all cores)")
    return parser.parse_args(words)


def _print(text: str) -> None:
    print(text, flush=True)


def _run(run: drench.Simulation, steps: int | None) -> None:
    """Runs to the end, and prints ten lines on the way."""
    printed = 0
    while not run.finished and (steps is None or run.steps < steps):
        step = run.step()
        part = max(run.time / run.scene.end, run.steps / steps if steps else 0.0)
        if int(10 * part + 1e-9) > printed:
            printed = int(10 * part + 1e-9)
            _print(f"t = {run.time:.3f} of {run.scene.end:g} s, step {run.steps}, {step.particles:,} particles, "
                   f"{step.mass_cloth * run.quantum * 1000:.1f} g of water in the cloth")


def main(words: Sequence[str] | None = None) -> int:
    """Returns the exit code."""
    options = _options(words)
    begin = time.monotonic()
    try:
        if options.threads is not None:
            drench.set_threads(options.threads)
        info = drench.info()
        _print(f"drench {drench.__version__} ({info['commit']}), {drench.precision} precision")
        _print(", ".join(f"{key} {value}" for key, value in info.items() if key not in ("version", "commit", "precision")))
        run = drench.Simulation(drench.scenes / SCENE, {} if options.until is None else {"time.end": options.until})
        with run.record(options.output, overwrite=options.overwrite) as recording:
            _print(f"{SCENE}: {run.scene.end:g} s, {len(run.fields['node_position']):,} cloth nodes")
            _run(run, options.steps)
        picture = drench.write_picture(recording.folder, recording.folder / PICTURE)
    except drench.RunFailure as error:
        print(f"drench.demo: the run failed: {error}", file=sys.stderr)
        return EXIT_FAILED
    except (drench.Error, OSError, RuntimeError, ValueError) as error:
        print(f"drench.demo: {error}", file=sys.stderr)
        return EXIT_USAGE
    _print(f"{run.steps} steps to t = {run.time:g} s in {time.monotonic() - begin:.0f} s")
    _print(f"picture in {picture}")
    _print(f"report in {recording.folder / 'report.html'}; open it in a browser")
    _print(f"frames for ParaView in {recording.folder}: fluid.pvd, cloth.pvd")
    return 0


if __name__ == "__main__":
    if "OMP_WAIT_POLICY" not in os.environ:  # threads that spin are slow beside other programs; read only at the start
        os.environ["OMP_WAIT_POLICY"] = "passive"
        os.execv(sys.executable, [sys.executable, "-m", "drench.demo", *sys.argv[1:]])
    sys.exit(main())
