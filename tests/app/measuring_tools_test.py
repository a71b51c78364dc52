#!/usr/bin/env python3
"""measuring_tools_test.py SOURCE BUILD: tools/measure/scaling, speed_error, still_water, paper_tables and paper_figures measure what they say,
on scenes of a few hundred particles, and their reader of frames agrees with stats.csv."""

import importlib.machinery
import importlib.util
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.dont_write_bytecode = True
SOURCE, BINARY = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve() / "drench"
TOOLS = SOURCE / "tools/measure"
sys.path.insert(0, str(TOOLS))
import measure  # noqa: E402
from series import liquid_series  # noqa: E402


def module(name):
    loader = importlib.machinery.SourceFileLoader(name, str(TOOLS / name))
    loaded = importlib.util.module_from_spec(importlib.util.spec_from_loader(name, loader))
    loader.exec_module(loaded)
    return loaded


scaling, speed_error, paper_figures = module("scaling"), module("speed_error"), module("paper_figures")
still_water = module("still_water")


def tool(name, *arguments):
    return subprocess.run([str(TOOLS / name), *map(str, arguments)], capture_output=True, text=True)


class Case(unittest.TestCase):
    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory()
        self.folder = Path(self.scratch.name)
        self.addCleanup(self.scratch.cleanup)

    def scene(self, text):
        path = self.folder / "scene.yaml"
        path.write_text(text)
        return path

    def png(self, name, table):
        """Draws, where a Python with matplotlib is here."""
        plot = self.folder / "plot.png"
        done = tool(name, "--plot", plot, "--table", table)
        if "needs matplotlib" in done.stderr:
            self.assertEqual(done.returncode, 1)
            return
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue(plot.read_bytes().startswith(b"\x89PNG"))


class PaperFigures(Case):
    """tools/measure/paper_figures on a few hundred particles."""

    def test_frames_by_every_sort_are_equal(self):
        done = tool("paper_figures", "--binary", BINARY, "--figure", "sorts", "--spacing", "0.03", "--steps", "40", "--threads", "1")
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = re.findall(r"^\| (\w+) \| [\d,]+ \| [\d.]+ \| [\d.]+ \| (\w+ \(\d+\)) \| (\w+ \(\d+\)) \|$", done.stdout, re.M)
        self.assertEqual([row[0] for row in rows], list(paper_figures.SORTS))
        self.assertEqual(len({row[1:] for row in rows}), 1)
        self.assertNotIn("(0)", rows[0][1])

    def test_frames_that_differ_are_told_apart(self):
        for folder, text in (("one", "a"), ("two", "b")):
            (self.folder / folder / "frames").mkdir(parents=True)
            (self.folder / folder / "frames" / "fluid_000000.vtu").write_text(text)
        one, two = (paper_figures.digest(self.folder / name, "fluid") for name in ("one", "two"))
        self.assertEqual((one[1], two[1]), (1, 1))
        self.assertNotEqual(one[0], two[0])

    def test_the_ball_starts_with_the_energy_that_its_share_is_of(self):
        spacing = 0.04
        scene = self.scene(paper_figures.ball(spacing, paper_figures.TURN, None))
        done = measure.Run(BINARY, scene, self.folder / "out", 1, settings=["output.every=1", "time.end=0.0001", "time.step=0.0001"])
        self.assertEqual(done.problem, "")
        frame = measure.read_frame(measure.frames(self.folder / "out", "fluid")[0][1], ("mass", "velocity"))
        energy = sum(0.5 * m * sum(v * v for v in frame["velocity"][3 * i:3 * i + 3]) for i, m in enumerate(frame["mass"]))
        self.assertAlmostEqual(energy / paper_figures.energy_of_start(spacing), 1, delta=1e-5)
        table = self.folder / "kept.csv"
        done = tool("paper_figures", "--binary", BINARY, "--figure", "turbulence", "--spacing", "0.08", "--steps", "30", "--threads", "1",
                    "--table", table)
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = measure.read_csv(table)
        self.assertEqual({(r["finer"], r["spins"]) for r in rows}, {(f, s) for f in "124" for s in ("none", "0.0005", "0.001")})
        self.assertTrue(all(0 < float(r["kept"]) < 2 for r in rows))
        self.png("paper_figures", table)


class Frames(Case):
    FALL = """drench: 1
time: {step: 0.004, end: 0.016}
domain: {min: [-1, -1, -1], max: [1, 1, 1]}
output: {every: 0.008}
fluid:
  spacing: 0.02
  sources: [{block: {min: [0, 0, 0], max: [0.1, 0.1, 0.1], velocity: [0.5, 0, 0]}}]
"""

    def test_free_fall(self):
        done = measure.Run(BINARY, self.scene(self.FALL), self.folder / "out", 1)
        self.assertEqual(done.problem, "")
        series, axis = liquid_series(self.folder / "out")
        self.assertEqual([round(t, 6) for t, _ in series["centre"]], [0, 0.008, 0.016])
        for k, x in enumerate((0.05, 0.05, 0.05)):
            self.assertAlmostEqual(axis[k], x, delta=1e-6)
        steps = 4  # y falls by g Δt² n (n + 1)/2
        centre = series["centre"][-1][1]
        self.assertAlmostEqual(centre[0], 0.05 + 0.016 * 0.5, delta=1e-4)
        self.assertAlmostEqual(centre[1], 0.05 - 9.81 * 0.004**2 * steps * (steps + 1) / 2, delta=1e-4)
        # Five columns of particles each way; the axis has stayed behind.
        at = [0.02 * k - 0.04 for k in range(5)]
        mean = sum(math.hypot(x + 0.008, z) for x in at for z in at) / 25
        self.assertAlmostEqual(series["spread"][-1][1][0], mean, delta=1e-4)
        energy = float(done.rows[-1]["kinetic_energy"])
        self.assertAlmostEqual(series["energy"][-1][1][0], energy, delta=1e-5 * energy)
        mass = sum(measure.read_frame(measure.frames(self.folder / "out", "fluid")[-1][1], ("mass",))["mass"])
        self.assertAlmostEqual(mass, float(done.rows[-1]["mass_fluid"]), delta=1e-5)

    def test_no_particles_yet(self):
        jet = self.FALL.replace("block: {min: [0, 0, 0], max: [0.1, 0.1, 0.1], velocity: [0.5, 0, 0]}",
                                "jet: {center: [0, 0, 0], radius: 0.05, velocity: [0, -1, 0], start: 0.009}")
        done = measure.Run(BINARY, self.scene(jet), self.folder / "out", 1)
        self.assertEqual(done.problem, "")
        series, _ = liquid_series(self.folder / "out")
        self.assertIsNone(series["centre"][0][1])
        self.assertEqual(series["energy"][0][1], (0.0,))

    def test_error(self):
        exact = [(0, (0.0,)), (1, (2.0,))]
        self.assertEqual(speed_error.error_of(exact, exact), 0)
        self.assertAlmostEqual(speed_error.error_of([(0, (0.2,)), (1, (1.8,))], exact), 0.1)
        self.assertIsNone(speed_error.error_of(exact, [(0, (3.0,)), (1, (3.0,))]))
        with self.assertRaises(ValueError):
            speed_error.error_of([(0, (0.0,)), (1.1, (2.0,))], exact)

    def test_pareto(self):
        rows = [{"time": t, "error": e, "reference": r} for t, e, r in
                ((9, 0, 1), (1, 0.5, 0), (2, 0.1, 0), (3, 0.2, 0), (4, 0.05, 0), (4, 0.06, 0))]
        speed_error.mark_pareto(rows[1:])
        self.assertEqual([r["pareto"] for r in rows[1:]], [1, 1, 0, 1, 0])


class Scaling(Case):
    def test_scenes_have_the_size_asked_for(self):
        for particles in (100000, 1000000, 4000000):
            d, _, _ = scaling.block_scene(particles)
            self.assertLess(abs(0.25 / d**3 / particles - 1), 0.05)
            d, nodes, text = scaling.cloth_scene(particles)
            across = round(nodes**0.5)
            self.assertLess(abs(2 / (across - 1) / d / 2.85 - 1), 0.02)
            self.assertIn(f"nodes: [{across}, {across}]", text)

    def test_measures(self):
        table = self.folder / "table.csv"
        done = tool("scaling", "--binary", BINARY, "--threads", 1, "--sizes", "500,1.5k", "--steps", 5, "--largest",
                    "--most", 2000, "--table", table)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        rows = measure.read_csv(table)
        self.assertEqual([r["family"] for r in rows], ["block"] * 2 + ["cloth"] * 2)
        for r in rows:
            self.assertGreater(float(r["ms_step"]), 0)
            self.assertGreater(float(r["bytes_particle"]), 200)
            self.assertEqual(r["cut"], "0")
        for first, second in (rows[:2], rows[2:]):
            self.assertEqual(first["steps"], "5")
            self.assertGreater(int(second["particles"]), int(first["particles"]))
            # The same time goes by.
            spans = [int(r["steps"]) * float(r["dt"]) for r in (first, second)]
            self.assertAlmostEqual(spans[0], spans[1], delta=float(second["dt"]))
        self.assertGreater(int(rows[2]["samples"]), 0)
        self.assertRegex(done.stdout, r"Time per particle from 432 to 1,458 particles: within [\d.]+× of its best")
        self.assertRegex(done.stdout, r"The largest block that fits: 2,000 particles.*told to end there")
        self.png("scaling", table)

    # Stands for a drench on a device: an array of its runs fails beyond `true`, its estimate refuses beyond `free`.
    DEVICE = """#!/usr/bin/env python3
import re, sys
from pathlib import Path
text = Path(sys.argv[2]).read_text() if len(sys.argv) > 2 else ""
d = float(re.search(r"spacing: (\\S+)", text).group(1)) if text else 1
count = 2 * round(0.5 / d) ** 3
need = 900 * count + 500 * count ** (2 / 3)
if sys.argv[1] == "info":
    print("device: fake")
elif need > {free}:
    sys.exit("scene.yaml: the scene does not fit in the device's memory")
elif sys.argv[1] == "check":
    print(f"fluid: {{count}} particles of {{d}} m, 1 kg, 0 jets")
    print(f"memory: about {{need / 2**20:.1f}} MiB: liquid 1.0 MiB; plus 278.0 MiB for set-up and frames; "
          f"Fake H1 has {{{free} / 2**20:.1f}} MiB free")
else:
    if need > {true}:
        sys.exit("drench: failed to allocate")
    out = Path(sys.argv[sys.argv.index("-o") + 1])
    out.mkdir()
    out.joinpath("run.log").write_text("peak memory of the backend's arrays 1.0 MiB, 1.0 MiB estimated at the start")
    head = "step,dt,particles,density_iterations,divergence_iterations,density_error,ms_step"
    out.joinpath("stats.csv").write_text(head + "".join(f"\\n{{k}},1,{{count}},2,2,0,1" for k in range(1, 6)) + "\\n")
"""

    def test_search_for_the_largest(self):
        for free, true in ((1.4e11, 2e11), (1.4e11, 9e10), (1.4e11, 1e10), (3e6, 3e6)):
            fake = self.folder / "drench"
            fake.write_text(self.DEVICE.format(free=free, true=true))
            fake.chmod(0o755)
            done = tool("scaling", "--backend", "cuda", "--binary", fake, "--sizes", "none", "--largest",
                        "--threads", 1)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            found = re.search(r"fits: ([\d,]+) particles.*Not ([\d,]+): (.*)\.", done.stdout)
            self.assertIsNotNone(found, done.stdout)
            fits, over = (int(found.group(k).replace(",", "")) for k in (1, 2))
            need = lambda count: 900 * count + 500 * count ** (2 / 3)
            self.assertLessEqual(need(fits), min(free, true))
            columns = round((fits / 2) ** (1 / 3))
            if columns > 40:  # a coarser block's next size is more than 5 % larger
                self.assertGreater(need(1.07 * fits), min(free, true))
                self.assertLess(done.stderr.count("5 steps"), 4 if true > free else 14)
                self.assertIn("does not fit" if true > free else "failed to allocate", found.group(3))
            self.assertGreater(need(over * 1.05), min(free, true))

    @unittest.skipUnless(shutil.which("mpirun"), "there is no mpirun")
    def test_ranks(self):
        if "ranks: none" in measure.info(BINARY):
            self.skipTest("the program knows no MPI")
        table = self.folder / "table.csv"
        done = tool("scaling", "--binary", BINARY, "--ranks", "1,2", "--sizes", "1k", "--steps", 5, "--runs", 2, "--table", table)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        rows = measure.read_csv(table)
        self.assertEqual([(r["scaling"], r["ranks"]) for r in rows],
                         [("strong", "1"), ("strong", "2"), ("weak", "1"), ("weak", "2")])
        particles = [int(r["particles"]) for r in rows]
        self.assertEqual(particles[:2], [1024, 1024])
        self.assertEqual(particles[2:], [1024, 2000])
        for r in rows:
            self.assertGreater(float(r["ms_step"]), 0)
            self.assertLessEqual(float(r["ms_best"]), float(r["ms_step"]))
            self.assertGreater(float(r["iterations"]), 0)
        # the same steps, so the same iterations: the bits do not depend on ranks
        self.assertEqual(rows[0]["iterations"], rows[1]["iterations"])
        best = [float(r["ms_best"]) for r in rows]
        self.assertAlmostEqual(float(rows[1]["efficiency"]), best[0] / best[1] / 2)
        self.assertAlmostEqual(float(rows[3]["efficiency"]), best[2] / best[3] * 2000 / 2048)
        self.assertEqual(done.stderr.count("2 ranks"), 4)
        for title in ("strong scaling", "weak scaling"):
            self.assertIn(title, done.stdout)
        self.png("scaling", table)
        self.assertEqual(tool("scaling", "--binary", BINARY, "--ranks", "0").returncode, 2)
        self.assertEqual(tool("scaling", "--binary", BINARY, "--ranks", "1", "--largest").returncode, 2)

    def test_failures(self):
        done = tool("scaling", "--binary", BINARY, "--sizes", "500", "--family", "block", "--set", "fluid.bogus=1")
        self.assertEqual(done.returncode, 1)
        self.assertIn("unknown key 'bogus'", done.stdout)
        done = tool("scaling", "--binary", BINARY, "--sizes", "500", "--family", "block", "--steps", 1000000,
                    "--max-seconds", 3)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("cut short", done.stdout)
        self.assertEqual(tool("scaling", "--binary", BINARY, "--sizes", "few").returncode, 2)


class ScalingModel(Case):
    def rows(self, *arguments):
        table = self.folder / "model.csv"
        done = tool("scaling_model", "--table", table, *arguments)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return {kind: [r for r in measure.read_csv(table) if r["scaling"] == kind] for kind in ("weak", "strong")}

    def test_parts_add_up_and_one_rank_sends_nothing(self):
        rows = self.rows("--ranks", "1,2,64")
        for r in rows["weak"] + rows["strong"]:
            parts = [float(r[part]) for part in ("compute", "halos", "sums", "other ranks", "cuts", "replicated")]
            self.assertAlmostEqual(sum(parts), float(r["ms_step"]))
            self.assertEqual(float(r["ghosts"]) > 0, r["ranks"] != "1")
        for kind in rows:
            self.assertEqual(float(rows[kind][0]["efficiency"]), 1)
            self.assertTrue(1 > float(rows[kind][1]["efficiency"]) > float(rows[kind][2]["efficiency"]))

    def test_halos_by_hand(self):
        """Bytes at a bandwidth that outlasts all else: 20 a ghost in four iterations, 24 in the lean ones, 60 once a step."""
        r = self.rows("--ranks", "8", "--particles", "1e6", "--iterations", "10", "--bandwidth", "1e6", "--latency", "0", "--message", "0",
                      "--staging", "0", "--lean-bytes", "24")["weak"][0]
        ghosts = (100 + 2.5) ** 3 - 1e6  # three of a cube's faces are cuts
        self.assertAlmostEqual(float(r["ghosts"]), ghosts, delta=1e-3)
        self.assertAlmostEqual(float(r["halos"]), 1000 * ghosts * (4 * 20 + 6 * 24 + 60) / 1e6, delta=1e-3)
        self.assertEqual(float(r["cuts"]) > 0, True)

    def test_replicated_work_bounds_the_gain(self):
        rows = self.rows("--ranks", "1,1000", "--strong", "1e6", "--replicated", "0.01")["strong"]
        self.assertLess(float(rows[0]["ms_step"]) / float(rows[1]["ms_step"]), float(rows[0]["ms_step"]) / 10)

    @unittest.skipUnless(shutil.which("mpicc") and shutil.which("mpirun"), "there is no MPI to measure")
    def test_measures_this_machine(self):
        done = tool("scaling_model", "--measure")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        found = dict(re.findall(r"^\| (\w[\w-]*).*? \| \S+ \| ([\d.e+]+) \|", done.stdout, re.M))
        self.assertEqual(set(found), {"latency", "bandwidth", "all-reduce"})
        self.assertTrue(all(float(value) > 0 for value in found.values()))

    def test_refuses(self):
        self.assertEqual(tool("scaling_model", "--bandwidth", "-1").returncode, 2)
        self.assertIn("--staging", tool("scaling_model", "--help").stdout)


class SpeedError(Case):
    def sweep(self, *arguments):
        self.table = self.folder / "table.csv"
        # The same binary for both: what the two precisions give has to be the same in every bit.
        return tool("speed_error", "--binary-float", BINARY, "--binary-double", BINARY, "--threads", 1,
                    "--seconds", 0.16, "--table", self.table, *arguments)

    def test_sweep(self):
        done = self.sweep("--spacing", 0.02, "--steps", "0.008,0.004", "--tolerances", "1e-2,1e-3")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        rows = measure.read_csv(self.table)
        self.assertEqual(len(rows), 8)
        self.assertEqual([r["reference"] for r in rows], ["1"] + ["0"] * 7)
        finest = ("0.004", "0.001")
        at = {(r["step"], r["tolerance"], r["precision"]): float(r["error"]) for r in rows}
        self.assertEqual(at[(*finest, "float")], 0)
        for point, error in at.items():
            self.assertEqual(error, at[(*point[:2], "double")])
            if point[:2] != finest:
                self.assertGreater(error, 0)
                self.assertLess(error, 1)
        # Twice the step is worse than ten times the tolerance, while the block falls and lands.
        self.assertGreater(at[("0.008", "0.001", "double")], at[("0.004", "0.01", "double")])
        for r in rows:
            self.assertEqual(int(r["steps"]), round(0.16 / float(r["step"])))
            self.assertGreater(float(r["time"]), 0)
        self.assertTrue(any(r["pareto"] == "1" for r in rows))
        self.assertEqual(rows[0]["pareto"], "0")
        for quantity in ("centre", "energy", "spread", "sag", "absorbed", "wet", "front"):
            self.assertIn(f"| {quantity} ", done.stdout)
        self.png("speed_error", self.table)

    def test_other_scene_key_and_reference(self):
        scene = self.scene(Frames.FALL.replace("velocity: [0.5, 0, 0]", "velocity: [0, -1, 0]") +
                           "bodies: [{plane: {point: [0, -0.01, 0], normal: [0, 1, 0]}}]\n")
        done = self.sweep("--scene", scene, "--steps", "0.004", "--tolerances", "1e-2", "--precisions", "double",
                          "--sweep", "fluid.kernel=poly6,cubic", "--reference", "0.002:1e-4")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        rows = measure.read_csv(self.table)
        self.assertEqual([(r["fluid.kernel"], r["step"]) for r in rows],
                         [("cubic", "0.002"), ("poly6", "0.004"), ("cubic", "0.004")])
        self.assertTrue(all(float(r["error"]) > 0 for r in rows[1:]))
        self.assertTrue(all(r["sag"] == "" for r in rows))
        self.png("speed_error", self.table)

    def test_study(self):
        done = self.sweep("--study", "wick")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        error = {r["changed"]: float(r["error"]) for r in measure.read_csv(self.table)}
        self.assertEqual(error["as it is"], error["precision double"])  # the same binary
        # Nodes twice as near are three times as near to erfc, whose slope begins infinite.
        self.assertLess(error["nodes 81"], error["as it is"] / 2.5)
        self.assertGreater(error["nodes 21"], 2.5 * error["as it is"])
        self.assertIn("| nodes 161 |", done.stdout)
        self.assertNotIn("density", done.stdout)
        self.png("speed_error", self.table)

    def test_failure(self):
        done = self.sweep("--steps", "0.004", "--tolerances", "1e-2", "--precisions", "float", "--max-seconds", 0.01)
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stdout, "no step was done|not done in")
        self.assertEqual(self.sweep("--reference", "fine").returncode, 2)


class StillWater(Case):
    def test_errors_of_a_column(self):
        heights = [0.05 * (layer + 0.5) for layer in range(10) for _ in range(4)]
        exact = [9.81 * (0.5 - y) for y in heights]
        self.assertLess(max(still_water.errors({"heights": heights, "pressures": exact}, 0.05)), 1e-12)
        layers, particles = still_water.errors({"heights": heights, "pressures": [1.1 * p for p in exact]}, 0.05)
        rms = math.sqrt(sum((0.1 * (1 - y / 0.5))**2 for y in heights) / len(heights))
        self.assertAlmostEqual(layers, rms)
        self.assertAlmostEqual(particles, rms)
        scattered = [p + (0.3 if i % 2 else -0.3) for i, p in enumerate(exact)]
        layers, particles = still_water.errors({"heights": heights, "pressures": scattered}, 0.05)
        self.assertLess(layers, 1e-12)
        self.assertAlmostEqual(particles, 0.3 / (9.81 * 0.5))

    def test_table(self):
        done = tool("still_water", "--layers", 4, "--wide", 4, "--tolerance", 1e-4, "--no-peer", "--binary", BINARY)
        self.assertEqual(done.returncode, 0, done.stderr)
        errors = re.findall(r"^\| drench \| (\w+) \| ([\d.]+) % \| ([\d.]+) %", done.stdout, re.MULTILINE)
        self.assertEqual([walls for walls, _, _ in errors], ["mirrored", "extrapolated"])
        for _, layers, particles in errors:
            self.assertTrue(0 < float(layers) <= float(particles) < 30, done.stdout)


class Help(Case):
    def test_help(self):
        for name in ("scaling", "speed_error", "paper_tables", "paper_figures"):
            done = tool(name, "--help")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertRegex(done.stdout, rf"tools/measure/{name} .*\[--backend")


class PaperTables(Case):
    def test_tables(self):
        done = tool("paper_tables", "--binary", BINARY, "--threads", 1, "--scene", "water_falling_low", "--steps", 3,
                    "--profile-steps", 2, "--set", "fluid.spacing=0.03")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        for title in ("Table 8", "Table 9", "Table 7", "peak device memory"):
            self.assertIn(title, done.stdout)
        self.assertRegex(done.stdout, r"\| no \| [\d.]+ MiB \|")


if __name__ == "__main__":
    os.environ["OMP_PROC_BIND"], os.environ["OMP_WAIT_POLICY"] = "false", "passive"
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)
