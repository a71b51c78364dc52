#!/usr/bin/env python3
"""first_steps_test.py SOURCE BUILD: the commands of README.md's "Quick start", in their order, do what it says, with the
program that was built and shorter runs. Its scene runs without a warning."""

import csv
import re
import subprocess
import sys
import tempfile
from pathlib import Path

SOURCE, BINARY = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve() / "drench"
SCENE = "scenes/water_on_cloth.yaml"


def commands():
    """[(words, comment)] of the lines in code blocks that run something."""
    text = (SOURCE / "README.md").read_text()
    part = text[text.index("## Quick start"):text.index("## A scene")]
    for block in re.findall(r"```\n(.*?)```", part, re.S):
        for line in block.splitlines():
            words, _, comment = line.partition("#")
            yield words.split(), comment.strip()


def steps(folder):
    with (folder / "stats.csv").open() as file:
        return [float(row["time"]) for row in csv.DictReader(file)]


def check_scene(folder):
    """The scene that README.md shows, with water from the first steps on."""
    block, = re.findall(r"```yaml\n(.*?)```", (SOURCE / "README.md").read_text(), re.S)
    (folder / "scene.yaml").write_text(block)
    checked = subprocess.run([str(BINARY), "check", "scene.yaml"], cwd=folder, capture_output=True, text=True)
    assert checked.returncode == 0 and "warning" not in checked.stdout + checked.stderr, checked.stdout + checked.stderr
    words = [str(BINARY), "run", "scene.yaml", "--steps", "3", "--quiet", "-o", "shown"]
    ran = subprocess.run(words, cwd=folder, capture_output=True, text=True)
    assert ran.returncode == 0, ran.stderr
    with (folder / "shown/stats.csv").open() as file:
        assert int(list(csv.DictReader(file))[-1]["particles"]) > 0


def main():
    done = []
    with tempfile.TemporaryDirectory() as scratch:
        here = Path(scratch)
        (here / "scenes").symlink_to(SOURCE / "scenes")
        check_scene(here)
        shorter = ["--quiet", "--set", "output.checkpoint_every=0.02", "--set", "time.end=0.06"]
        for words, comment in commands():
            name, rest = words[0], words[1:]
            if name == "tools/test":
                continue
            assert (SOURCE / name).exists() or name == "build/openmp-float/drench", name
            if name == "tools/render":  # needs a display; that it can be asked is all that is tried here
                assert (here / rest[0] / "fluid.pvd").exists(), rest
                done.append("picture")
                continue
            if name == "tools/run":
                assert rest[0] == SCENE, rest
                if "--resume" in rest:
                    before = steps(here / rest[rest.index("--resume") + 1])
                    assert float(rest[rest.index("--until") + 1]) > 1.5, "goes on behind time.end"
                    rest = rest[:rest.index("--until")] + ["--quiet", "--set", "output.checkpoint_every=0.02",
                                                           "--set", "time.end=0.1"]
                    kind = "restart"
                else:
                    kind = "change" if "--set" in rest else "run"
                    rest = rest + shorter
                words = [str(BINARY), "run", *rest]
            else:
                kind, words = rest[0], [str(BINARY), *rest]
            ran = subprocess.run(words, cwd=here, capture_output=True, text=True)
            assert ran.returncode == 0, (words, ran.stderr)
            done.append(kind)
            if kind == "restart":
                after = steps(here / "out/water_on_cloth")
                assert after[:len(before)] == before and after[-1] > 0.0999, "does not go on"
    assert done == ["run", "picture", "report", "change", "restart", "compare"], done
    print(", ".join(done))


main()
