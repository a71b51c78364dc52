#!/usr/bin/env python3
"""sweep_test.py SOURCE BUILD: tools/sweep runs every point once, takes its numbers from stats.csv, goes on where it was ended,
and refuses what it does not understand in a line."""

import csv
import os
import signal
import subprocess
import time

from support import BINARY, SOURCE, Case, call, main, stats

SCENE = """drench: 1
time: {step: 0.02, end: 1}
output: {every: 0}
cloth:
  - mesh: {grid: {size: [0.05, 0.1], nodes: [3, 6]}}
    place: {position: [0, 0.05, 0], rotate: {axis: [1, 0, 0], degrees: 90}}
    dynamics: false
    hold_saturation: [{box: {min: [-1, -0.001, -1], max: [1, 0.011, 1]}, value: 1}]
    porous: {diffusivity: 1.0e-3, capillary_height: 0.1}
"""
KEY = "cloth.0.porous.diffusivity"
SWEEP = f"""scene: scene.yaml
vary:
  {KEY}: {{from: 5e-4, to: 2.0e-3, count: 3, spacing: log}}
  cloth.0.porous.capillary_height: [0.05, 0.1]
numbers:
  held: {{of: mass_cloth, take: last}}
  most: {{of: saturation_max, take: max}}
  soon: {{of: mass_cloth, take: time above, value: 1.0e-4}}
  never: {{of: mass_cloth, take: time above, value: 1}}
"""


class Sweep(Case):
    def setUp(self):
        super().setUp()
        self.write("scene.yaml", SCENE)
        self.write_sweep(SWEEP)

    def write_sweep(self, text):
        self.write("sweep.yaml", text)

    def words(self):
        return [SOURCE / "tools/sweep", self.folder / "sweep.yaml", "-o", self.folder / "out", "--binary", BINARY, "--threads", "1"]

    def run_it(self, code=0):
        done = call(*self.words())
        if "needs PyYAML" in done.stderr:
            self.skipTest("no PyYAML")
        self.assertEqual(done.returncode, code, done.stderr)
        return done

    def table(self):
        with (self.folder / "out/table.csv").open(newline="") as file:
            return list(csv.DictReader(file))

    def run_folder(self, row):
        return self.folder / "out/runs" / row["run"]

    def test_every_point_has_the_numbers_of_its_run(self):
        said = self.run_it().stdout
        rows = self.table()
        self.assertEqual([(row[KEY], row["cloth.0.porous.capillary_height"]) for row in rows],
                         [(d, h) for d in ("0.0005", "0.001", "0.002") for h in ("0.05", "0.1")])
        self.assertEqual(len(set(row["run"] for row in rows)), 6)
        for row in rows:
            steps = stats(self.run_folder(row))
            self.assertEqual(int(row["steps"]), 50)
            self.assertEqual(row["held"], f"{float(steps[-1]['mass_cloth']):.6g}")
            self.assertEqual(row["most"], f"{max(float(s['saturation_max']) for s in steps):.6g}")
            first = next(s for s in steps if float(s["mass_cloth"]) > 1e-4)
            self.assertEqual(float(row["soon"]), float(first["time"]))
            self.assertEqual((row["never"], row["problem"], row["mass_error"]), ("", "", "0"))
            self.assertIn(f"{KEY}=", self.run_folder(row).with_suffix(".json").read_text())
        self.assertGreater(float(rows[5]["held"]), float(rows[0]["held"]))
        self.assertEqual(said.count("\n| "), 6)

    def test_what_is_done_is_kept_and_what_is_new_is_added(self):
        self.run_it()
        before = {row["run"]: (self.folder / "out" / "runs" / row["run"] / "stats.csv").stat().st_mtime_ns for row in self.table()}
        self.write_sweep(SWEEP.replace("[0.05, 0.1]", "[0.1, 0.2]"))
        self.run_it()
        rows = self.table()
        self.assertEqual(len(rows), 6)
        kept = [row["run"] for row in rows if row["run"] in before]
        self.assertEqual(len(kept), 3)
        for name in kept:
            self.assertEqual((self.folder / "out" / "runs" / name / "stats.csv").stat().st_mtime_ns, before[name])
        (self.folder / "scene.yaml").write_text(SCENE.replace("end: 1}", "end: 0.5}"))  # other runs
        self.run_it()
        self.assertEqual([row["steps"] for row in self.table()], ["25"] * 6)

    def test_rows_in_place_of_a_grid(self):
        self.write_sweep(SWEEP.replace("numbers:", "points: rows\nnumbers:").replace("[0.05, 0.1]", "[0.05, 0.1, 0.2]"))
        self.run_it()
        self.assertEqual([row["cloth.0.porous.capillary_height"] for row in self.table()], ["0.05", "0.1", "0.2"])

    def test_a_run_that_fails_has_its_line(self):
        # at more sub-steps than a million diffusion ends the run
        self.write_sweep(SWEEP.replace("{from: 5e-4, to: 2.0e-3, count: 3, spacing: log}", "[1.0e-6, 1]").replace("scene: scene.yaml",
                   "scene: scene.yaml\nset: {time.step: 1, cloth.0.mesh.grid.size: [0.0005, 0.001]}"))
        self.run_it(code=1)
        rows = self.table()
        self.assertEqual([bool(row["problem"]) for row in rows], [False, False, True, True])
        self.assertIn("diffusion", rows[2]["problem"])

    def test_goes_on_after_ctrl_c(self):
        long = SWEEP.replace("vary:", "set: {time.end: 4000, time.step: 0.002, output.checkpoint_every: 1}\nvary:")
        self.write_sweep(long)
        child = subprocess.Popen([*map(str, self.words()), "--jobs", "2"], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        runs = self.folder / "out" / "runs"
        until = time.monotonic() + 60
        while not list(runs.glob("*/checkpoint_*")) and time.monotonic() < until and child.poll() is None:
            time.sleep(0.02)
        child.send_signal(signal.SIGINT)
        said = child.communicate()[1]
        if "needs PyYAML" in said:
            self.skipTest("no PyYAML")
        self.assertEqual(child.returncode, 130, said)
        self.assertIn("the same command goes on", said)
        halves = [folder for folder in runs.iterdir() if list(folder.glob("checkpoint_*"))]
        self.assertGreaterEqual(len(halves), 1)

    def test_bad_sweeps_are_refused_in_a_line(self):
        for change, line in (
                (("scene: scene.yaml", "scene: none.yaml"), "is no file"),
                (("scene: scene.yaml\n", ""), "the scene's file is missing"),
                (("vary:", "very:"), "there is no key very; allowed: scene,"),
                (("count: 3", "count: 1"), "count: 1 is not allowed; allowed: whole numbers of 2 or more"),
                (("spacing: log", "spacing: root"), "spacing: root is not allowed; allowed: linear, log"),
                (("from: 5e-4", "from: 0"), "from and to have to be numbers above 0"),
                (("take: last", "take: latest"), "take: latest is not allowed; allowed: last, first,"),
                (("take: max}", "take: max, value: 3}"), "a number belongs to `time above`"),
                (("numbers:", "points: rows\nnumbers:"), "rows need as many values of each key"),
                ((KEY, "cloth.0.porous.diffusivty"), "diffusivty"),
                (("[0.05, 0.1]", "[0.05, -0.1]"), "out of range"),
                (("of: mass_cloth, take: last", "of: mass_clothes, take: last"), "stats.csv has no mass_clothes"),
                (("numbers:", "numbers:\n  held: {of: time, take: last}"), "sweep.yaml:7:3: held stands here twice"),
                (("vary:", "vary: ["), "sweep.yaml:"),
        ):
            self.write_sweep(SWEEP.replace(*change))
            done = self.run_it(code=2)
            self.assertIn(line, done.stderr.splitlines()[-1])
            self.assertEqual(len([text for text in done.stderr.splitlines() if not text.startswith("[")]), 1, done.stderr)


if __name__ == "__main__":
    os.environ.update({"OMP_PROC_BIND": "false", "OMP_WAIT_POLICY": "passive"})
    main()
