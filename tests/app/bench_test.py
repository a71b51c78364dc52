#!/usr/bin/env python3
"""bench_test.py SOURCE BUILD: tools/bench refuses wrong options in a line, times drench's stages, and sets peers beside it;
a script stands for a peer's interpreter, so that nothing is fetched."""

import json
import math
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.dont_write_bytecode = True
SOURCE, BINARY = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve() / "drench"
sys.path.insert(0, str(SOURCE / "tools/measure"))
import measure  # noqa: E402
import peer_programs as peers  # noqa: E402
from block import block_of  # noqa: E402

# Stands for an interpreter with the packages of `peer`: asked for them it says yes; given a driver it writes what that one
# would, a lattice that is compressed by 1 %, in twice the particles of the block.
PEER = """#!/usr/bin/env python3
import array, json, sys
from pathlib import Path
if sys.argv[1] == "-c":
    sys.exit({missing!r})
driver, block, folder = sys.argv[1], json.loads(Path(sys.argv[2]).read_text()), Path(sys.argv[3])
assert driver.endswith("tools/measure/peers/drive_{name}.py") and Path(driver).exists(), driver
d, (nx, ny, nz) = block["spacing"], block["counts"]
assert (block["threads"], block["device"], block["tolerance"], block["support"]) == (1, "cpu", 0.002, 2 * d), block
lattice = [c for i in range(nx) for j in range(ny) for k in range(2 * nz)
           for c in ((i + 0.5) * d, (j + 0.5) * d, (k + 0.5) * d)]
samples = [k for k in range(1, block["steps"] + 1) if block["sample_every"] and k % block["sample_every"] == 0]
for k in samples:
    (folder / f"positions_{{k}}").write_bytes(array.array("f", lattice).tobytes())
steps = [{{"ms": 1e9 if k < 10 else {ms}, "density_iterations": 1, "divergence_iterations": 7}} for k in range(block["steps"])]
(folder / "result.json").write_text(json.dumps({{
    "steps": steps, "samples": [{{"step": k, "compression": 0.5}} for k in samples], "program": "Fake 1.0",
    "particles": len(lattice) // 3, "volume": 1.01 * d**3}}))
"""


def bench(*arguments):
    return subprocess.run([str(SOURCE / "tools" / "bench"), *map(str, arguments)], capture_output=True, text=True)


class Case(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = Path(scratch.name)

    def peer(self, name, ms=1000.0, missing=0):
        path = self.folder / f"python_{name}"
        path.write_text(PEER.format(name=name, ms=ms, missing=missing))
        path.chmod(0o755)
        return path


class Options(Case):
    def test_wrong_ones_are_refused_in_a_line(self):
        for said, *arguments in (
                ("--peer: invalid choice: 'physx'", "--peer", "physx"),
                ("--backend: invalid choice: 'opencl'", "--backend", "opencl"),
                ("--steps: '10' is no whole number of 11 or more", "--steps", 10),
                ("--runs: 'many' is no whole number", "--runs", "many"),
                ("--threads: '0' is no whole number of 1", "--threads", 0),
                ("--tolerance: '2' is no number from 1e-7 to 0.1", "--tolerance", 2),
                ("need a --peer", "--peer-python", "python3"),
                ("need a --peer", "--table", "table.csv"),
                ("there is no --peer genesis", "--peer", "splishsplash", "--peer-python", "genesis=python3"),
                ("of which peer?", "--peer", "splishsplash", "--peer", "genesis", "--peer-python", "python3"),
                ("unrecognized arguments: --fast", "--fast")):
            done = bench(*arguments)
            self.assertEqual((done.returncode, done.stdout), (2, ""), arguments)
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
            self.assertIn(said, done.stderr)

    def test_help(self):
        done = bench("--help")
        self.assertEqual(done.returncode, 0)
        self.assertIn("tools/bench [--backend", done.stdout)

    def test_what_cannot_run_says_why_in_a_line(self):
        absent = self.folder / "absent"
        for said, *arguments in (
                (f"tools/bench: peer genesis: {absent}: No such file or directory", "--peer", "genesis", "--peer-python", absent),
                ("tools/bench: peer splishsplash: No module named numpy", "--peer", "splishsplash", "--peer-python",
                 self.peer("splishsplash", missing="No module named numpy")),
                (f"tools/bench: peer sph_taichi: {absent}: no such folder", "--peer", "sph_taichi", "--peer-python",
                 self.peer("sph_taichi"), "--peer-source", absent)):
            done = bench("--binary", BINARY, "--particles", 2000, "--threads", 1, *arguments)
            self.assertEqual((done.returncode, done.stdout), (1, ""), done.stderr)
            self.assertEqual(done.stderr, said + "\n")


class Stages(Case):
    def test_table(self):
        done = bench("--binary", BINARY, "--particles", 2000, "--steps", 12, "--runs", 1, "--threads", 1)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("Block of 2,000 particles, openmp, float, 1 threads, median of 1 runs of 12 steps:", done.stdout)
        for stage in ("neighbors", "density", "divergence", "forces", "pressure", "advection", "all"):
            self.assertRegex(done.stdout, rf"\| {stage} \| [\d.]+ \|")
        self.assertRegex(done.stdout, r"Density iterations: mean [\d.]+, most \d+; error: mean [\d.e-]+, largest")

    def test_a_run_that_fails(self):
        done = bench("--binary", BINARY, "--particles", 2000, "--steps", 12, "--runs", 1, "--set", "fluid.bogus=1")
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        self.assertIn("tools/bench: ", done.stderr)
        self.assertIn("bogus", done.stderr)


class Peers(Case):
    def test_in_turns(self):
        table = self.folder / "table.csv"
        done = bench("--binary", BINARY, "--particles", 2000, "--steps", 12, "--runs", 2, "--threads", 1, "--tolerance", 2e-3,
                     "--peer", "splishsplash", "--peer-python", self.peer("splishsplash"), "--table", table)
        self.assertEqual(done.returncode, 0, done.stderr)
        order = re.findall(r"^(drench|Fake 1\.0): [\d.]+ ms per step", done.stderr, re.MULTILINE)
        self.assertEqual(order, ["drench", "Fake 1.0"] * 2)
        ours, theirs = measure.read_csv(table)
        self.assertEqual((ours["program"], ours["particles"]), ("drench", "2000"))
        self.assertEqual((theirs["program"], theirs["particles"], float(theirs["ms"])), ("Fake 1.0", "4000", 1000.0))
        self.assertTrue(0 < float(ours["error"]) < 2e-3 and 0 < float(ours["own_error"]) < 2e-3, ours)
        self.assertTrue(20 < float(ours["neighbors"]) < 26, ours)
        self.assertAlmostEqual(float(theirs["error"]), 0.01, delta=2e-3)
        self.assertEqual((theirs["density_iterations"], theirs["divergence_iterations"]), ("1.0", "7.0"))
        self.assertAlmostEqual(float(theirs["height"]), 0.5, delta=1e-6)
        self.assertRegex(done.stdout, r"- Fake 1\.0: drench is [\d.]+ times as fast per particle. Fake 1\.0 wins in: density "
                         r"iterations \(1\.00 against [\d.]+\)\.")

    def test_a_faster_peer_wins(self):
        done = bench("--binary", BINARY, "--particles", 2000, "--steps", 12, "--runs", 1, "--threads", 1, "--tolerance", 2e-3,
                     "--peer", "genesis", "--peer-python", self.peer("genesis", ms=1e-3))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r"- Fake 1\.0: drench is [\d.]+ times as \*\*slow\*\* per particle\. Fake 1\.0 wins in: time")


class Judge(unittest.TestCase):
    def test_lattice(self):
        block = block_of(16000)
        d, n = block.spacing, block.columns
        self.assertEqual(block.description()["counts"], [n, 2 * n, n])
        points = [c for i in range(n) for j in range(2 * n) for k in range(n)
                  for c in ((i + 0.5) * d, (j + 0.5) * d, (k + 0.5) * d)]
        # Within less than two spacings: the 26 of a cube, fewer on the faces.
        along = lambda count: 3 * count - 2
        exact = along(n)**2 * along(2 * n) / (2 * n**3) - 1
        neighbors, error, height = peers.judge(points, 1.01 * d**3, 1.9999 * d, (1, 1, 1), most=10**9)
        self.assertAlmostEqual(neighbors, exact, places=9)
        self.assertAlmostEqual(height, 0.5, places=9)
        # Free faces are below the rest density; inside, a lattice has a density ratio of 1.
        self.assertTrue(0.008 < error < 0.0101, error)
        self.assertEqual(peers.judge(points, 0.99 * d**3, 2 * d, (1, 1, 1))[1], 0)
        sampled = peers.judge(points, 1.01 * d**3, 1.9999 * d, (1, 1, 1), most=4000)
        self.assertAlmostEqual(sampled[0], exact, delta=0.3)

    def test_kernel_integrates_to_one(self):
        h, n = 0.3, 3000
        total = sum(4 * math.pi * r * r * peers.cubic(r, h) for r in ((k + 0.5) * h / n for k in range(n))) * h / n
        self.assertAlmostEqual(total, 1, places=6)

    def test_scene_and_description_agree(self):
        block = block_of(65536)
        self.assertEqual((block.particles, block.columns, block.spacing, block.step, block.viscosity),
                         (65536, 32, 1 / 64, 0.001, 0.01))
        self.assertEqual(block_of(810000).particles, 810448)
        self.assertEqual(json.loads(json.dumps(block.description()))["tolerance"], 1e-3)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)
