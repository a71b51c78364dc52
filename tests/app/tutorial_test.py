#!/usr/bin/env python3
"""tutorial_test.py SOURCE BUILD: each scene of docs/tutorial loads without a warning and runs for a few steps, with water
from the first one on; and the YAML that the pages show stands in the scenes."""

import csv
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

TUTORIAL, BINARY = Path(sys.argv[1]).resolve() / "docs/tutorial", Path(sys.argv[2]).resolve() / "drench"
STEPS = 6
PAGES = {"2_cloth.md": "towel.yaml", "3_water.md": "towel_water.yaml", "4_wetting.md": "towel_wet.yaml",
         "5_garment.md": "shirt.yaml"}


def expect(good, message):
    if not good:
        sys.exit(f"tutorial_test: {message}")


def drench(*words):
    ran = subprocess.run([str(BINARY), *map(str, words)], capture_output=True, text=True)
    expect(ran.returncode == 0, f"{words} ended with {ran.returncode}:\n{ran.stdout}{ran.stderr}")
    return ran.stdout + ran.stderr


def settings(text):
    """The lines of a scene without comments, one space for many."""
    lines = (" ".join(line.split("#")[0].split()) for line in text.splitlines())
    return [line for line in lines if line]


def check_scene(scene, folder):
    said = drench("check", scene)
    expect("warning" not in said, f"drench check warns of {scene.name}:\n{said}")
    wet = "fluid:" in scene.read_text()
    more = ["--set", "fluid.sources.0.jet.start=0"] if wet else []
    drench("run", scene, "-o", folder, "--steps", STEPS, "--quiet", *more)
    with (folder / "stats.csv").open() as file:
        rows = list(csv.DictReader(file))
    expect(len(rows) == STEPS, f"{scene.name} did {len(rows)} steps")
    expect(all(float(row["mass_error"]) == 0 for row in rows), f"{scene.name} loses liquid")
    expect(not wet or int(rows[-1]["particles"]) > 0, f"{scene.name} has no water")


def main():
    with tempfile.TemporaryDirectory() as scratch:
        mine = Path(scratch)
        made = subprocess.run([sys.executable, TUTORIAL / "make_shirt.py", mine], capture_output=True, text=True)
        expect(made.returncode == 0, made.stderr)
        scenes = sorted((TUTORIAL / "scenes").glob("*.yaml"))
        expect([scene.name for scene in scenes] == sorted(PAGES.values()), f"other scenes: {scenes}")
        for scene in scenes:
            check_scene(Path(shutil.copy(scene, mine)), mine / scene.stem)
    for page, scene in PAGES.items():
        there = settings((TUTORIAL / "scenes" / scene).read_text())
        blocks = re.findall(r"```yaml\n(.*?)```", (TUTORIAL / page).read_text(), re.S)
        expect(blocks, f"{page} shows no YAML")
        for line in settings("".join(blocks)):
            expect(line in there, f"{page} shows what is not in {scene}: {line}")
    print(f"{len(scenes)} scenes")


main()
