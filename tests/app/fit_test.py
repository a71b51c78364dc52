#!/usr/bin/env python3
"""fit_test.py SOURCE BUILD: `drench fit` finds the values with which a test gave a dense curve with 2 % of noise, warns
where a curve does not determine them, leaves out what a test does not cover, and refuses what it cannot read in a line.
Exit code 77, skipped, without SciPy."""

import csv
import json
import os
import random
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from support import SOURCE, Case, call, drench, environment, main, rejects, skip  # noqa: E402

NAMES = [os.environ.get("DRENCH_PYTHON"), SOURCE / ".deps/fit-venv/bin/python", SOURCE / ".deps/python-venv/bin/python", sys.executable]
PYTHON = next((p for p in NAMES if p and Path(p).exists() and call(p, "-c", "import numpy, scipy.optimize").returncode == 0), None)
STRIP = ["--fabric", "none", "--set", "cloth.0.porous.diffusion_exponent=2"]


class Fit(Case):
    def setUp(self):
        super().setUp()
        self.environment = environment(DRENCH_PYTHON=PYTHON, OMP_PROC_BIND="false", OMP_WAIT_POLICY="passive")
        self.random = random.Random(3)

    def measured(self, test, words, name, header, columns, specimen):
        """A file with the curve of a simulated specimen and random errors."""
        folder = self.folder / f"{name}-run"
        drench("test", test, *words, "--repeats", "1", "--threads", "1", "--quiet", "-o", folder, env=self.environment)
        lines = [f"{float(row[columns[0]])},{float(row[columns[1]]) * (1 + 0.02 * self.random.gauss(0, 1)):.6g}"
                 for row in self.rows(folder, specimen)[2:]]
        return self.write(f"{name}.csv", "\n".join([f"# made by {test}", header, *lines]) + "\n")

    def rows(self, folder, specimen):
        with (self.folder / folder / "curve.csv").open(newline="") as file:
            return [row for row in csv.DictReader(file) if row["specimen"] == specimen]

    def fit(self, *words, code=0, folder="out", **options):
        done = drench("fit", *words, "-o", self.folder / folder, "-j", "2", "--quiet", code=code,
                      **{"env": self.environment, **options})
        return done, json.loads((self.folder / folder / "fit.json").read_text())

    def values(self, found):
        return {p["key"].removeprefix("cloth.0."): p["value"] for p in found["parameters"]}

    def near(self, found, **wanted):
        for p in found["parameters"]:
            true = wanted[p["key"].rsplit(".", 1)[-1]]
            self.assertLess(abs(p["value"] / true - 1), 0.05, p)
            self.assertLess(p["low"], p["value"])
            self.assertGreater(p["high"], p["value"])
            self.assertLess(p["high"] / p["low"], 1.25)

    def test_finds_wicking_values_and_predicts_the_mass(self):
        true = [*STRIP, "--set", "cloth.0.porous.diffusivity=2e-5", "--set", "cloth.0.porous.capillary_height=0.06", "--set", "time.end=400"]
        heights = self.measured("aatcc197", true, "heights", "time (s),wicking height (mm)", ["time (s)", "wicking height (mm)"], "warp 1")
        rows = self.rows("heights-run", "warp 1")
        mass = self.write("mass.csv", "time (min);absorbed water (mg)\n" + "".join(
            f"{float(row['time (s)']) / 60};{1e3 * float(row['absorbed water (g)'])}\n" for row in rows))
        words = [heights, "--test", "aatcc197", "--parameters", "diffusivity,capillary_height", *STRIP, "--start", "diffusivity=5e-5",
                 "--start", "porous.capillary_height=0.1", "--hold-out", mass, "--name", "felt"]
        done, found = self.fit(*words)
        self.near(found, diffusivity=2e-5, capillary_height=0.06)
        self.assertIn("95 % interval", done.stdout)
        self.assertLess(found["equation_against_simulation"], 0.01)
        self.assertLess(abs(found["residual_deviation"] - 0.02), 0.01)
        self.assertLess(found["held_out"][0]["relative_error"], 0.03)
        self.assertEqual(found["held_out"][0]["unit"], "mg")
        self.assertGreater((self.folder / "out/fit.png").stat().st_size if (self.folder / "out/fit.png").exists() else
                           (self.folder / "out/fit.svg").stat().st_size, 1000)
        fabric = (self.folder / "out/fabric.yaml").read_text()
        for part in ("name: felt", "derived: fitted to heights.csv by aatcc197, 95 % interval", "made by aatcc197", "given"):
            self.assertIn(part, fabric)
        drench("check", self.folder / "out/fabric.yaml")
        _, again = self.fit(*words)  # all its runs are there
        self.assertEqual((again["simulated_runs"], self.values(again)), (0, self.values(found)))

    def test_finds_the_stiffness_of_two_curves_together(self):
        true = ["--set", "cloth.0.membrane.warp=150", "--set", "cloth.0.membrane.weft=60", "--set", "time.end=2.4"]
        columns = ["strain (%)", "force (N)"]
        warp = self.measured("tensile", true, "a", "strain (%),force (N)", columns, "warp 1")
        weft = self.measured("tensile", true, "b", "elongation (%),weft force (N)", columns, "weft 1")
        _, found = self.fit(warp, weft, "--test", "tensile", "--parameters", "membrane.warp,membrane.weft",
                            env={**self.environment, "PYTHONPATH": str(self.without_matplotlib())})
        self.near(found, warp=150, weft=60)
        self.assertEqual(found["warnings"], [])
        self.assertIn("<polyline", (self.folder / "out/fit.svg").read_text())

    def without_matplotlib(self):
        self.write("without/matplotlib.py", "raise ImportError('none')\n")
        return self.folder / "without"

    def test_warns_of_what_a_curve_does_not_determine(self):
        lengths = self.write("lengths.csv", "bending length (cm)\n1.46\n1.48\n1.465\n")
        done, found = self.fit(lengths, "--test", "cantilever", "--parameters", "bending.warp,areal_density,thickness", "--max-steps", "1")
        self.assertIn("bending.warp and areal_density are correlated", done.stderr)
        self.assertIn("thickness has no effect on these curves", done.stderr)
        self.assertIn("no confidence intervals", done.stderr)
        self.assertIn("assumed: fitted to lengths.csv", (self.folder / "out/fabric.yaml").read_text())
        self.assertEqual(found["curves"][0]["points"], 3)

    def test_judges_specimens_by_their_scatter(self):
        lengths = self.write("lengths.csv", "bending length (mm)\n14.2\n14.4\n14.7\n14.9\n15.1\n15.2\n")
        other = self.write("other.csv", "weft bending length (mm)\n20\n20.2\n")
        stiff = ["--test", "cantilever", "--set", "cloth.0.areal_density=0.2"]
        done, found = self.fit(lengths, *stiff, "--parameters", "bending.warp")
        self.assertNotIn("failed", done.stdout)
        self.assertNotIn("systematic", done.stderr)  # the order of specimens has no meaning
        self.assertIn("standard deviation 0.3937", done.stdout)
        self.assertIsNone(found["curves"][0]["r_squared"])
        # the weft is too stiff for the bounds
        done, _ = self.fit(lengths, other, *stiff, "--parameters", "bending.warp,bending.weft",
                           "--bounds", "bending.weft=1e-6:2e-6", folder="bounded")
        self.assertRegex(done.stdout, r"warning: other.csv: the simulated value is \d\S* mm from the mean .*failed")
        self.assertEqual(done.stdout.count("failed"), 1)
        self.assertIn("at its bound, so without an interval", done.stdout)
        # The bending length depends only on the ratio.
        done, found = self.fit(lengths, "--test", "cantilever", "--parameters", "bending.warp,areal_density",
                               folder="ratio")
        self.assertEqual(done.stdout.count("not determined by these curves"), 2)
        for p in found["parameters"]:
            self.assertEqual((p["low"], p["high"], p["identified"]), (None, None, False))

    def test_leaves_out_points_after_the_end_of_a_test(self):
        drench("test", "aatcc79", "--set", "cloth.0.porous.uptake_velocity=0.01", "--repeats", "1", "--threads", "1",
               "--quiet", "-o", self.folder / "drop-run", env=self.environment)
        rows = self.rows("drop-run", "1")
        end = float(rows[-1]["time (s)"])
        lines = [f"{row['time (s)']},{row['absorbed water (mg)']}" for row in rows
                 if 0.2 * end < float(row["time (s)"]) < 0.9 * end]
        later = [f"{1.5 * end},51", f"{30 * end},51"]
        curve = self.write("drop.csv", "\n".join(["time (s),mass (mg)", *lines, *later]) + "\n")
        held = self.write("later.csv", "\n".join(["time (s),mass (mg)", *later]) + "\n")
        fit = ["--test", "aatcc79", "--parameters", "uptake_velocity", "--start", "uptake_velocity=0.013"]
        done, found = self.fit(curve, *fit, "--hold-out", held)
        self.assertRegex(done.stderr, rf"drop.csv:{len(lines) + 2}: aatcc79 ends at \S+ s .*"
                                      "so 2 points from this line on are left out")
        self.assertIn("later.csv:2: aatcc79 ends at", done.stderr)
        self.assertEqual(found["curves"][0]["left_out"], [len(lines) + 2, len(lines) + 3])
        self.assertEqual((found["curves"][0]["points"], found["held_out"]), (len(lines), []))
        self.near(found, uptake_velocity=0.01)
        rejects("no point with a value above 0 remains", "fit", held, *fit, "--quiet", "--max-steps", "1",
                "-o", self.folder / "none", env=self.environment)

    def test_runs_a_test_to_the_end_of_its_numbers(self):
        curve = self.write("curve.csv", "strain (%),force (N)\n0.025,0.0019\n0.05,0.0038\n")
        number = self.write("number.csv", "tensile stiffness (N/m)\n152\n149\n")
        _, found = self.fit(curve, number, "--test", "tensile", "--parameters", "membrane.warp")
        self.near(found, warp=151)

    def test_ends_at_a_curve_without_change(self):
        rows = "".join(f"{t},30,,\n" for t in (60, 90, 120, 180, 240))  # as spreadsheets write them
        rest = self.write("rest.csv", "time (s),height (mm),,\n" + rows)
        done, found = self.fit(rest, "--test", "aatcc197", "--parameters", "diffusivity,capillary_height", *STRIP,
                               "--start", "diffusivity=1e-4", "--start", "capillary_height=0.1")
        self.assertIn("height changes by less than 2 %", done.stderr)
        self.assertIn("porous.diffusivity", done.stderr)
        self.assertIn("not determined", done.stdout)
        self.assertLess(found["steps"], 15)
        self.assertLess(abs(self.values(found)["porous.capillary_height"] / 0.0333 - 1), 0.01)

    def test_rejects_what_it_cannot_read(self):
        good = self.write("good.csv", "time (s),height (mm)\n10,5\n20,7\n")
        self.write("full/other.txt", "")
        fit = ["--test", "aatcc197", "--parameters", "diffusivity"]
        for text, line in (
                ("", "bad.csv: no header"),
                ("# only\ntime (s),height (mm)\n", "bad.csv:2: no values"),
                ("time (s),height\n1,2\n", "bad.csv:1: height: the unit is missing"),
                ("time (s),height (inch)\n1,2\n", "bad.csv:1: height (inch): inch is not a unit; allowed: mm"),
                ("time (s),height (g)\n1,2\n", "bad.csv:1: height (g): g is not a unit of this quantity; allowed: mm"),
                ("time (s),force (N)\n1,2\n", "bad.csv:1: force (N): is no quantity of this test; aatcc197 reports over time: height, mass"),
                ("time (s),height (mm)\n1,2\n2,x\n", "bad.csv:3: x: is not a number"),
                ("time (s),height (mm)\n1,2\n2\n", "bad.csv:3: 1 values; the header has 2 columns"),
                ("time (s),height (mm)\n2,2\n1,3\n", "bad.csv:3: time must not decrease"),
                ("time (s),height (mm)\n0,0\n60,-20\n", "bad.csv:3: height: -20 mm is not possible; allowed: 0 or more"),
                ("time (h),height (mm)\n3,2\n4,2\n", "bad.csv:2: time: 3 h is not allowed; allowed: 0 to 2 h"),
                ("time (s),height (mm)\n1,0\n2,0\n", "bad.csv:2: height: no value is above 0"),
                ("time (s),height (cm)\n1,14\n2,24\n", "bad.csv:3: height: 24 cm is not possible in aatcc197; "
                 "allowed: at most 16.1 cm, the end of the strip above the water; is the unit mm?"),
                ("time (s),height (mm)\n1,140\n2,165\n", "bad.csv:3: height: 165 mm is not possible in aatcc197"),
                ("time (s);height (mm)\n10;24,291\n",
                 "bad.csv:2: 24,291: is not a number; write a decimal point: 24.291"),
                ("time (s),height (mm)\n10,24,291\n",
                 "bad.csv:2: 3 values; the header has 2 columns; write decimal points"),
                ("  # of strips\ntime (s),height (mm)\n10,x\n", "bad.csv:3: x: is not a number"),
                ("time (s),height (mm)\n10,5 # wet\n",
                 "bad.csv:2: 5 # wet: is not a number; write comments in lines of their own"),
                ("10,5\n20,7\n", "bad.csv:1: no header above the values"),
        ):
            with self.subTest(line):
                rejects(line, "fit", self.write("bad.csv", text), *fit, "-o", self.folder / "out", env=self.environment)
        for words, line in (
                ([good, "--test", "aatcc1", "--parameters", "diffusivity"], "aatcc1 is not a test"),
                ([good, "--test", "aatcc197", "--parameters", "diffusivty"], "did you mean diffusivity?"),
                ([good, "--test", "aatcc197", "--parameters", "warp"], "write one of membrane.warp, bending.warp"),
                ([good, *fit, "--fabric", "tweed"], "tweed"),
                ([good, *fit, "--bounds", "diffusivity=3:1"], "allowed: LOW below HIGH"),
                ([good, *fit, "--set", "cloth.0.porous.diffusivity=1"], "diffusivity is fixed by --set"),
                ([good, *fit, "-o", self.folder / "full"], "is not empty and has no earlier fit"),
                ([self.folder / "none.csv", *fit], "none.csv: cannot be read"),
                ([good, "--test", "aatcc197", "--parameters", "diffusivity,capillary_height,thickness"],
                 "2 points for 3 parameters"),
                ([good, *fit, "--hold-out-test", "foo"], "--hold-out-test: names the test of a file of --hold-out"),
                ([good, *fit, "--hold-out", good], "good.csv is fitted too"),
                ([good, good, *fit], "good.csv: is given twice"),
                ([good, *fit[:2], "--parameters", ""], "--parameters: names no key of the fabric"),
                ([self.write("drape.csv", "drape coefficient (1)\n55\n"), "--test", "iso9073-9", *fit[2:]],
                 "drape.csv:2: drape coefficient: 55 is not possible in iso9073-9; allowed: at most 1, a flat "
                 "specimen; is the unit %?"),
                ([self.write("bend.csv", "specimen,bending length (cm)\n1,2\n"), "--test", "iso9073-7", *fit[2:]],
                 "bend.csv:1: specimen: is no quantity of this test; remove this column"),
                ([good, *fit, "--set", "time.end=15"],
                 "good.csv:3: time: 20 s is not allowed; allowed: 0 to 15 s, where --set time.end"),
                ([good, *fit, "--set", "time.end=soon"], "--set: time.end=soon is not allowed"),
                ([self.write("spot.csv", "time (min),area (cm2)\n1,5\n6,7\n"), "--test", "aatcc198", *fit[2:]],
                 "spot.csv:3: time: 6 min is not allowed; allowed: 0 to 5 min, where the test ends; --set time.end="),
                ([self.write("drop.csv", "time (s),mass (g)\n1,5\n2,45\n"), "--test", "aatcc79", *fit[2:]],
                 "drop.csv:2: mass: 5 g is not possible in aatcc79; allowed: at most 0.0525 g, the drop and 5 % of "
                 "scatter; is the unit mg?"),
        ):
            with self.subTest(line):
                rejects(line, "fit", *words, *([] if "-o" in words else ["-o", self.folder / "out"]), env=self.environment)

    def test_needs_scipy(self):
        self.write("bare/scipy.py", "raise ImportError('none', name='scipy')\n")
        good = self.write("good.csv", "time (s),height (mm)\n10,5\n")
        rejects("fit needs Python's scipy: run tools/setup fit", "fit", good, "--test", "aatcc197", "--parameters", "diffusivity",
                env={**self.environment, "PYTHONPATH": str(self.folder / "bare")})


if __name__ == "__main__":
    if not PYTHON:
        skip("no Python with numpy and scipy: tools/setup fit")
    main()
