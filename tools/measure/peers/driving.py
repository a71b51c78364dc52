"""What the drivers of tools/bench's peers share. A driver is called

    PYTHON driver.py BLOCK.json FOLDER

by the interpreter that has the peer's packages. BLOCK.json holds tools/measure/block.py's description and how to run it: `steps`,
`sample_every`, `threads`, `device` (cpu or gpu), the `source` of a peer that is no package, and the kind of `walls` of one
that has several. The driver writes FOLDER/result.json and, of every step that is sampled, the liquid's positions as float32:
FOLDER/positions_STEP."""

import json
import os
import sys
from pathlib import Path


class Recorder:
    def __init__(self, description, folder):
        for key, value in description.items():
            setattr(self, key, value)
        self.folder = Path(folder)
        self.result = {"steps": [], "samples": []}

    def record_step(self, ms, density_iterations, divergence_iterations):
        """After each step: its wall time without what the driver adds. The first one may hold the peer's set-up."""
        self.result["steps"].append({"ms": ms, "density_iterations": density_iterations,
                                     "divergence_iterations": divergence_iterations})

    def is_sampled(self):
        """Whether the step that was just made wants a sample."""
        return self.sample_every and len(self.result["steps"]) % self.sample_every == 0

    def record_sample(self, positions, density_ratio):
        """After a step that is sampled: numpy arrays of shape (n, 3), y up, and (n,), of the liquid alone."""
        step = len(self.result["steps"])
        positions.astype("<f4").tofile(self.folder / f"positions_{step}")
        self.result["samples"].append({"step": step, "compression": float((density_ratio - 1).clip(0).mean())})

    def finish(self, program, particles, volume):
        """`volume` of a particle in m³."""
        self.result.update(program=program, particles=int(particles), volume=float(volume))
        (self.folder / "result.json").write_text(json.dumps(self.result))


def recorder():
    """Of the command line."""
    description, folder = json.loads(Path(sys.argv[1]).read_text()), sys.argv[2]
    os.environ["OMP_NUM_THREADS"] = str(description["threads"])
    return Recorder(description, folder)


def counted(solver, name):
    """Counts the calls of one of the solver's methods: its iterations."""
    count, method = [0], getattr(solver, name)

    def call(*arguments):
        count[0] += 1
        return method(*arguments)

    setattr(solver, name, call)
    return count
