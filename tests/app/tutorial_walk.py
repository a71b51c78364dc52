#!/usr/bin/env python3
"""tutorial_walk.py SOURCE BUILD: the first hour. The commands of docs/tutorial, the blocks ```sh of its pages, in their order
in an empty folder, until there is a picture of a garment with a scene of its own. Exit code 77, skipped, without what draws.

So that it takes a minute, it changes this, and leaves the rest as the pages have it:
- a run ends at the time that ENDS says, its jet starts at once, its liquid has a spacing of 2 cm;
- a picture has 240 x 180 pixels, and two frames of a run are drawn;
- `drench compare` compares after ten steps;
- scenes that the reader types are the finished ones of docs/tutorial/scenes;
- set-up, tests, Cycles and tools/measure/speed_error are left out: they have tests of their own."""

import csv
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parent))
from png_pixels import share  # noqa: E402

SOURCE, BUILD = (Path(word).resolve() for word in sys.argv[1:3])
TUTORIAL = SOURCE / "docs/tutorial"
ENDS = {"water_on_cloth": 0.2, "towel": 0.1, "towel_water": 0.2, "towel_wet": 0.3, "shirt": 0.3, "splash": 0.3, "own": 0.4}
LEFT_OUT = ("tools/test", "tools/setup", "tools/measure/speed_error")
ran = []


def expect(good, message):
    if not good:
        sys.exit(f"tutorial_walk: {message}")


def commands():
    """(page, line) of every command, lines that go on joined."""
    for page in sorted(TUTORIAL.glob("[0-9]_*.md")):
        for block in re.findall(r"```sh\n(.*?)```", page.read_text(), re.S):
            text = ""
            for line in block.replace("\\\n", " ").splitlines():
                text += line + "\n"
                if text.count("'") % 2 == 0:  # a program for awk takes two lines
                    yield page.name, text.strip()
                    text = ""


def shell(here, line):
    environment = {**os.environ, "PATH": f"{BUILD}:{os.environ['PATH']}"}
    done = subprocess.run(["bash", "-ec", line], cwd=here, env=environment, capture_output=True, text=True)
    expect(done.returncode == 0, f"'{line}' ended with {done.returncode}:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    ran.append(line)
    return done.stdout


def rows(folder):
    with (folder / "stats.csv").open() as file:
        return list(csv.DictReader(file))


def run(here, words):
    scene = here / words[0]
    out = words[words.index("-o") + 1] if "-o" in words else f"out/{scene.stem}"
    end = ENDS[Path(out).name]
    if "--resume" in words:
        end += 0.05
    if "--until" in words:
        words = words[:words.index("--until")] + words[words.index("--until") + 2:]
    changes = {"time.end": end, "output.checkpoint_every": 0.1, "output.every": 0.05}
    if "fluid:" in scene.read_text():
        changes |= {"fluid.spacing": 0.02, "fluid.sources.0.jet.start": 0}
    more = " ".join(f"--set {key}={value}" for key, value in changes.items())
    shell(here, f"drench run {shlex.join(words)} --quiet {more}")
    last = rows(here / out)[-1]
    expect(float(last["time"]) >= end - 1e-3, f"{out} ends at {last['time']} s, not at {end} s")
    expect(float(last["mass_error"]) == 0, f"{out} loses liquid")
    expect("fluid:" not in scene.read_text() or int(last["particles"]) > 0, f"{out} has no water")


def draw(here, words):
    if "--cycles" in words:
        return False
    folder = here / words[0] / "pictures"
    if "--frames" not in words:
        words = [*words, "--frames", "2"]
    expect((here / words[0]).is_dir(), f"{words[0]} is drawn before it is run")
    shell(here, f"{SOURCE}/tools/render {shlex.join(words)} --size 240x180")
    picture = sorted(folder.glob("*.png"))[-1]
    drawn = share(picture, lambda *colour: min(colour) < 245)
    expect(0.04 < drawn < 0.96, f"{picture.name} of {words[0]} shows nothing: {drawn:.3f} of it is drawn")
    return True


def follow(here, line):
    """Runs a command of a page; False when it is left out."""
    words = shlex.split(line, comments=True)
    name, rest = words[0], words[1:]
    for word in rest:
        finished = TUTORIAL / "scenes" / Path(word).name
        if word.startswith("mine/") and word.endswith(".yaml") and not (here / word).exists() and finished.exists():
            shutil.copy(finished, here / word)
    if name in LEFT_OUT:
        return False
    if name == "tools/run":
        run(here, rest)
    elif name == "tools/render":
        return draw(here, rest)
    elif name == "alias":  # bash has no aliases in a script
        expect(rest == ["drench=build/openmp-float/drench"], line)
    else:
        shell(here, re.sub(r"--after \d+", "--after 10", line))
    return True


def main():
    with tempfile.TemporaryDirectory() as scratch:
        here, left_out = Path(scratch), []
        for folder in ("docs", "scenes"):
            shutil.copytree(SOURCE / folder, here / folder)
        for page, line in commands():
            if not follow(here, line):
                left_out.append(line.splitlines()[0])
        expect(len(ran) > 20, f"only {len(ran)} commands")
        expect(ran[-1].startswith(f"{SOURCE}/tools/render out/own"), f"does not end with a picture of one's own: {ran[-1]}")
        picture = sorted((here / "out/own/pictures").glob("*.png"))[-1]
        cloth = share(picture, lambda r, g, b: r > b + 8 and r > 90)  # dry cloth is yellowish
        water = share(picture, lambda r, g, b: b > r + 40)
        expect(cloth > 0.02 and water > 0.002, f"one's own garment is not in it: cloth {cloth:.3f}, water {water:.3f}")
        print(f"{len(ran)} commands; left out: {', '.join(left_out)}")


if not (BUILD / "drench-view").exists():
    print("SKIPPED: drench view is not built")
    sys.exit(77)
if not shutil.which("Xvfb") and not os.environ.get("DISPLAY"):
    print("SKIPPED: no display, and no Xvfb")
    sys.exit(77)
main()
