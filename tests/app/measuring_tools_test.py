#!/usr/bin/env python3
"""measuring_tools_test.py SOURCE BUILD: the tools that measure print and keep what they say, on scenes of a few hundred particles;
their reader of frames agrees with stats.csv, and tools/bench judges other programs as drench. A script stands for a peer's
interpreter, so that nothing is fetched."""

import importlib.machinery
import importlib.util
import math
import os
import re
import shutil
import sys
import unittest

from support import BINARY, SOURCE, Case, call, main

TOOLS = SOURCE / "tools/measure"
sys.path.insert(0, str(TOOLS))
import measure  # noqa: E402
import peer_programs  # noqa: E402
from block import block_of  # noqa: E402
from series import error_of, liquid_series, mark_pareto  # noqa: E402


def module(name):
    loader = importlib.machinery.SourceFileLoader(name, str(TOOLS / name))
    loaded = importlib.util.module_from_spec(importlib.util.spec_from_loader(name, loader))
    loader.exec_module(loaded)
    return loaded


class Tool(Case):
    def tool(self, name, *arguments, code=0):
        done = call(TOOLS / name, *arguments)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done

    def plot(self, name, table):
        """Draws, where a Python with matplotlib is here."""
        plot = self.folder / "plot.png"
        done = call(TOOLS / name, "--plot", plot, "--table", table)
        if "needs matplotlib" not in done.stderr:
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertTrue(plot.read_bytes().startswith(b"\x89PNG"))


class Series(Case):
    FALL = """drench: 1
time: {step: 0.004, end: 0.016}
domain: {min: [-1, -1, -1], max: [1, 1, 1]}
output: {every: 0.008}
fluid:
  spacing: 0.02
  sources: [{block: {min: [0, 0, 0], max: [0.1, 0.1, 0.1], velocity: [0.5, 0, 0]}}]
"""

    def test_free_fall(self):
        done = measure.Run(BINARY, self.write("scene.yaml", self.FALL), self.folder / "out", 1)
        self.assertEqual(done.problem, "")
        series, _ = liquid_series(self.folder / "out")
        self.assertEqual([round(t, 6) for t, _ in series["centre"]], [0, 0.008, 0.016])
        centre = series["centre"][-1][1]
        self.assertAlmostEqual(centre[0], 0.05 + 0.016 * 0.5, delta=1e-4)
        self.assertAlmostEqual(centre[1], 0.05 - 9.81 * 0.004**2 * 4 * 5 / 2, delta=1e-4)  # y falls by g Δt² n (n + 1)/2
        # Five columns of particles each way; the axis has stayed behind.
        at = [0.02 * k - 0.04 for k in range(5)]
        mean = sum(math.hypot(x + 0.008, z) for x in at for z in at) / 25
        self.assertAlmostEqual(series["spread"][-1][1][0], mean, delta=1e-4)
        energy = float(done.rows[-1]["kinetic_energy"])
        self.assertAlmostEqual(series["energy"][-1][1][0], energy, delta=1e-5 * energy)

    def test_errors(self):
        exact = [(0, (0.0,)), (1, (2.0,))]
        self.assertEqual(error_of(exact, exact), 0)
        self.assertAlmostEqual(error_of([(0, (0.2,)), (1, (1.8,))], exact), 0.1)
        self.assertIsNone(error_of(exact, [(0, (3.0,)), (1, (3.0,))]))
        rows = [{"time": t, "error": e, "reference": 0} for t, e in ((1, 0.5), (2, 0.1), (3, 0.2), (4, 0.05), (4, 0.06))]
        mark_pareto(rows)
        self.assertEqual([r["pareto"] for r in rows], [1, 1, 0, 1, 0])


class Scaling(Tool):
    def test_measures(self):
        table = self.folder / "table.csv"
        done = self.tool("scaling", "--binary", BINARY, "--threads", 1, "--sizes", "500,1.5k", "--steps", 5, "--largest",
                         "--most", 2000, "--table", table)
        rows = measure.read_csv(table)
        self.assertEqual([r["family"] for r in rows], ["block"] * 2 + ["cloth"] * 2)
        for first, second in (rows[:2], rows[2:]):
            self.assertGreater(int(second["particles"]), int(first["particles"]))
            spans = [int(r["steps"]) * float(r["dt"]) for r in (first, second)]
            self.assertAlmostEqual(spans[0], spans[1], delta=float(second["dt"]))
        self.assertTrue(all(float(r["ms_step"]) > 0 and float(r["bytes_particle"]) > 200 for r in rows))
        self.assertGreater(int(rows[2]["samples"]), 0)
        self.assertRegex(done.stdout, r"Time per particle from 432 to 1,458 particles: within [\d.]+× of its best")
        self.assertRegex(done.stdout, r"The largest block that fits: 2,000 particles.*told to end there")

    @unittest.skipUnless(shutil.which("mpirun"), "there is no mpirun")
    def test_ranks(self):
        if "ranks: none" in measure.info(BINARY):
            self.skipTest("the program knows no MPI")
        table = self.folder / "table.csv"
        self.tool("scaling", "--binary", BINARY, "--ranks", "1,2", "--sizes", "1k", "--steps", 5, "--runs", 2, "--table", table)
        rows = measure.read_csv(table)
        self.assertEqual([(r["scaling"], r["ranks"], r["particles"]) for r in rows],
                         [("strong", "1", "1024"), ("strong", "2", "1024"), ("weak", "1", "1024"), ("weak", "2", "2000")])
        self.assertEqual(rows[0]["iterations"], rows[1]["iterations"])  # the bits do not depend on ranks
        best = [float(r["ms_best"]) for r in rows]
        self.assertAlmostEqual(float(rows[1]["efficiency"]), best[0] / best[1] / 2)
        self.assertAlmostEqual(float(rows[3]["efficiency"]), best[2] / best[3] * 2000 / 2048)

    def test_failures(self):
        block = ("--binary", BINARY, "--sizes", "500", "--family", "block")
        self.assertIn("unknown key 'bogus'", self.tool("scaling", *block, "--set", "fluid.bogus=1", code=1).stdout)
        self.assertIn("cut short", self.tool("scaling", *block, "--steps", 1000000, "--max-seconds", 3).stdout)
        self.tool("scaling", "--binary", BINARY, "--sizes", "few", code=2)
        self.tool("scaling", "--binary", BINARY, "--ranks", "1", "--largest", code=2)
        self.tool("scaling_model", "--bandwidth", "-1", code=2)

    def test_model(self):
        table = self.folder / "model.csv"

        def rows(kind, *arguments):
            self.tool("scaling_model", "--table", table, *arguments)
            return [{key: float(value) for key, value in row.items() if key != "scaling"} for row in measure.read_csv(table)
                    if row["scaling"] == kind]

        for kind in ("weak", "strong"):
            found = rows(kind, "--ranks", "1,2,64")
            for r in found:
                self.assertAlmostEqual(sum(r[part] for part in ("compute", "halos", "sums", "other ranks", "cuts", "replicated")), r["ms_step"])
                self.assertEqual(r["ghosts"] > 0, r["ranks"] != 1)
            efficiencies = [r["efficiency"] for r in found]
            self.assertTrue(1 == efficiencies[0] > efficiencies[1] > efficiencies[2])
        # Bytes at a bandwidth that outlasts all else: 20 a ghost in four iterations, 24 in the lean ones, 60 once a step.
        r = rows("weak", "--ranks", "8", "--particles", "1e6", "--iterations", "10", "--bandwidth", "1e6", "--latency", "0",
                 "--message", "0", "--staging", "0", "--lean-bytes", "24")[0]
        ghosts = (100 + 2.5) ** 3 - 1e6  # three of a cube's faces are cuts
        self.assertAlmostEqual(r["ghosts"], ghosts, delta=1e-3)
        self.assertAlmostEqual(r["halos"], 1000 * ghosts * (4 * 20 + 6 * 24 + 60) / 1e6, delta=1e-3)


class SpeedError(Tool):
    def sweep(self, *arguments, code=0):
        self.table = self.folder / "table.csv"
        # The same binary for both: the two precisions have to give the same bits.
        return self.tool("speed_error", "--binary-float", BINARY, "--binary-double", BINARY, "--threads", 1, "--seconds", 0.16,
                         "--table", self.table, *arguments, code=code)

    def test_sweep(self):
        done = self.sweep("--spacing", 0.02, "--steps", "0.008,0.004", "--tolerances", "1e-2,1e-3")
        rows = measure.read_csv(self.table)
        self.assertEqual([r["reference"] for r in rows], ["1"] + ["0"] * 7)
        at = {(r["step"], r["tolerance"], r["precision"]): float(r["error"]) for r in rows}
        for (step, tolerance, _), error in at.items():
            self.assertEqual(error, at[(step, tolerance, "double")])
            self.assertTrue(error == 0 if (step, tolerance) == ("0.004", "0.001") else 0 < error < 1)
        # Twice the step is worse than ten times the tolerance, while the block falls and lands.
        self.assertGreater(at[("0.008", "0.001", "double")], at[("0.004", "0.01", "double")])
        self.assertTrue(any(r["pareto"] == "1" for r in rows) and rows[0]["pareto"] == "0")
        for quantity in ("centre", "energy", "spread", "sag", "absorbed", "wet", "front"):
            self.assertIn(f"| {quantity} ", done.stdout)
        self.plot("speed_error", self.table)

    def test_other_scene_key_and_reference(self):
        scene = self.write("scene.yaml", Series.FALL.replace("velocity: [0.5, 0, 0]", "velocity: [0, -1, 0]") +
                           "bodies: [{plane: {point: [0, -0.01, 0], normal: [0, 1, 0]}}]\n")
        self.sweep("--scene", scene, "--steps", "0.004", "--tolerances", "1e-2", "--precisions", "double",
                   "--sweep", "fluid.kernel=poly6,cubic", "--reference", "0.002:1e-4")
        rows = measure.read_csv(self.table)
        self.assertEqual([(r["fluid.kernel"], r["step"]) for r in rows], [("cubic", "0.002"), ("poly6", "0.004"), ("cubic", "0.004")])
        self.assertTrue(all(float(r["error"]) > 0 for r in rows[1:]))

    def test_failure(self):
        done = self.sweep("--steps", "0.004", "--tolerances", "1e-2", "--precisions", "float", "--max-seconds", 0.01, code=1)
        self.assertRegex(done.stdout, "no step was done|not done in")

    def test_study(self):
        self.sweep("--study", "wick")
        error = {r["changed"]: float(r["error"]) for r in measure.read_csv(self.table)}
        self.assertEqual(error["as it is"], error["precision double"])  # the same binary
        # Nodes twice as near are three times as near to erfc, whose slope begins infinite.
        self.assertLess(error["nodes 81"], error["as it is"] / 2.5)
        self.plot("speed_error", self.table)


class Paper(Tool):
    def test_tables(self):
        done = self.tool("paper_tables", "--binary", BINARY, "--threads", 1, "--scene", "water_falling_low", "--steps", 3,
                         "--profile-steps", 2, "--set", "fluid.spacing=0.03")
        for title in ("Table 8", "Table 9", "Table 7", "peak device memory"):
            self.assertIn(title, done.stdout)

    def test_figures(self):
        figures = module("paper_figures")
        done = self.tool("paper_figures", "--binary", BINARY, "--figure", "sorts", "--spacing", "0.03", "--steps", "40", "--threads", "1")
        rows = re.findall(r"^\| (\w+) \| [\d,]+ \| [\d.]+ \| [\d.]+ \| (\w+ \(\d+\)) \| (\w+ \(\d+\)) \|$", done.stdout, re.M)
        self.assertEqual([row[0] for row in rows], list(figures.SORTS))
        self.assertEqual(len({row[1:] for row in rows}), 1)
        # The ball starts with the energy that shares are of.
        scene = self.write("ball.yaml", figures.ball(0.04, figures.TURN, None))
        measure.Run(BINARY, scene, self.folder / "out", 1, settings=["output.every=1", "time.end=0.0001", "time.step=0.0001"])
        frame = measure.read_frame(measure.frames(self.folder / "out", "fluid")[0][1], ("mass", "velocity"))
        energy = sum(0.5 * m * sum(v * v for v in frame["velocity"][3 * i:3 * i + 3]) for i, m in enumerate(frame["mass"]))
        self.assertAlmostEqual(energy / figures.energy_of_start(0.04), 1, delta=1e-5)

    def test_still_water(self):
        still_water = module("still_water")
        heights = [0.05 * (layer + 0.5) for layer in range(10) for _ in range(4)]
        wrong = [1.1 * 9.81 * (0.5 - y) for y in heights]
        rms = math.sqrt(sum((0.1 * (1 - y / 0.5))**2 for y in heights) / len(heights))
        for error in still_water.errors({"heights": heights, "pressures": wrong}, 0.05):
            self.assertAlmostEqual(error, rms)
        done = self.tool("still_water", "--layers", 4, "--wide", 4, "--tolerance", 1e-4, "--no-peer", "--binary", BINARY)
        self.assertEqual(re.findall(r"^\| drench \| (\w+) \| [\d.]+ % \| [\d.]+ %", done.stdout, re.M), ["mirrored", "extrapolated"])


# Stands for an interpreter with the packages of a peer: asked for them it says yes; given a driver it writes what that one
# would, a lattice that is compressed by 1 %, in twice the particles of the block.
PEER = """#!/usr/bin/env python3
import array, json, sys
from pathlib import Path
if sys.argv[1] == "-c":
    sys.exit()
driver, block, folder = sys.argv[1], json.loads(Path(sys.argv[2]).read_text()), Path(sys.argv[3])
assert driver.endswith("/drive_splishsplash.py") and Path(driver).exists(), driver
d, (nx, ny, nz) = block["spacing"], block["counts"]
assert (block["threads"], block["device"], block["tolerance"], block["support"]) == (1, "cpu", 0.002, 2 * d), block
lattice = [c for i in range(nx) for j in range(ny) for k in range(2 * nz)
           for c in ((i + 0.5) * d, (j + 0.5) * d, (k + 0.5) * d)]
samples = [k for k in range(1, block["steps"] + 1) if block["sample_every"] and k % block["sample_every"] == 0]
for k in samples:
    (folder / f"positions_{k}").write_bytes(array.array("f", lattice).tobytes())
steps = [{"ms": 1e9 if k < 10 else 1000, "density_iterations": 1, "divergence_iterations": 7} for k in range(block["steps"])]
(folder / "result.json").write_text(json.dumps({
    "steps": steps, "samples": [{"step": k, "compression": 0.5} for k in samples], "program": "Fake 1.0",
    "particles": len(lattice) // 3, "volume": 1.01 * d**3}))
"""


class Bench(Tool):
    BLOCK = ("--binary", BINARY, "--particles", 2000, "--steps", 12, "--threads", 1)

    def bench(self, *arguments, code=0):
        return self.tool("../bench", *arguments, code=code)

    def test_wrong_options(self):
        for said, *arguments in (
                ("--peer: invalid choice: 'physx'", "--peer", "physx"),
                ("--steps: '10' is no whole number of 11 or more", "--steps", 10),
                ("--tolerance: '2' is no number from 1e-7 to 0.1", "--tolerance", 2),
                ("need a --peer", "--table", "table.csv"),
                ("of which peer?", "--peer", "splishsplash", "--peer", "genesis", "--peer-python", "python3"),
                ("there is no --peer genesis", "--peer", "splishsplash", "--peer-python", "genesis=python3")):
            done = self.bench(*arguments, code=2)
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
            self.assertIn(said, done.stderr)
        absent = self.folder / "absent"
        done = self.bench(*self.BLOCK, "--peer", "genesis", "--peer-python", absent, code=1)
        self.assertEqual(done.stderr, f"tools/bench: peer genesis: {absent}: No such file or directory\n")
        python = self.write("python", PEER)
        python.chmod(0o755)
        done = self.bench(*self.BLOCK, "--peer", "sph_taichi", "--peer-python", python, "--peer-source", absent, code=1)
        self.assertEqual(done.stderr, f"tools/bench: peer sph_taichi: {absent}: no such folder\n")
        self.assertIn("bogus", self.bench(*self.BLOCK, "--runs", 1, "--set", "fluid.bogus=1", code=1).stderr)

    def test_stages(self):
        done = self.bench(*self.BLOCK, "--runs", 1)
        self.assertIn("Block of 2,000 particles, openmp, float, 1 threads, median of 1 runs of 12 steps:", done.stdout)
        for stage in ("neighbors", "density", "divergence", "forces", "pressure", "advection", "all"):
            self.assertRegex(done.stdout, rf"\| {stage} \| [\d.]+ \|")

    def test_peer_in_turns(self):
        table, python = self.folder / "table.csv", self.write("python", PEER)
        python.chmod(0o755)
        done = self.bench(*self.BLOCK, "--runs", 2, "--tolerance", 2e-3, "--peer", "splishsplash", "--peer-python", python, "--table", table)
        order = re.findall(r"^(drench|Fake 1\.0): [\d.]+ ms per step", done.stderr, re.MULTILINE)
        self.assertEqual(order, ["drench", "Fake 1.0"] * 2)
        ours, theirs = measure.read_csv(table)
        self.assertEqual((theirs["program"], theirs["particles"], float(theirs["ms"])), ("Fake 1.0", "4000", 1000.0))
        self.assertTrue(0 < float(ours["error"]) < 2e-3 and 20 < float(ours["neighbors"]) < 26, ours)
        self.assertAlmostEqual(float(theirs["error"]), 0.01, delta=2e-3)
        self.assertRegex(done.stdout, r"- Fake 1\.0: drench is [\d.]+ times as fast per particle. Fake 1\.0 wins in: density "
                         r"iterations \(1\.00 against [\d.]+\)\.")

    def test_judge(self):
        block = block_of(16000)
        d, n = block.spacing, block.columns
        points = [c for i in range(n) for j in range(2 * n) for k in range(n) for c in ((i + 0.5) * d, (j + 0.5) * d, (k + 0.5) * d)]
        # Within less than two spacings: the 26 of a cube, fewer on the faces.
        exact = (3 * n - 2)**2 * (6 * n - 2) / (2 * n**3) - 1
        neighbors, error, height = peer_programs.judge(points, 1.01 * d**3, 1.9999 * d, (1, 1, 1), most=10**9)
        self.assertAlmostEqual(neighbors, exact, places=9)
        self.assertAlmostEqual(height, 0.5, places=9)
        self.assertTrue(0.008 < error < 0.0101, error)  # inside, a lattice has a density ratio of 1
        self.assertEqual(peer_programs.judge(points, 0.99 * d**3, 2 * d, (1, 1, 1))[1], 0)


if __name__ == "__main__":
    os.environ["OMP_PROC_BIND"], os.environ["OMP_WAIT_POLICY"] = "false", "passive"
    main()
