#!/usr/bin/env python3
"""pages_test.py SOURCE BUILD PART: what pages ask a reader to type does what they say.

first_steps  the commands of README.md's "Quick start", with shorter runs; its scene runs without a warning
gallery      pictures and commands of scenes/gallery/README.md; scenes of the paper are only checked
tutorial     each scene of docs/tutorial loads without a warning and runs; the YAML that the pages show stands in the scenes
walk         the commands of docs/tutorial in their order, until there is a picture of a garment with a scene of its own.
             Runs end at the times of ENDS, with coarser liquid; pictures are small; scenes that the reader types are those of
             docs/tutorial/scenes; set-up, tests, Cycles and speed_error are left out: they have tests of their own.
             Exit code 77, skipped, without what draws"""

import os
import re
import shlex
import shutil
import sys
import tempfile
from pathlib import Path

from support import BUILD, SOURCE, call, drench, environment, expect, skip, stats

sys.path.insert(0, str(SOURCE / "tools/export"))
import picture_options  # noqa: E402
from png_pixels import share  # noqa: E402

TUTORIAL, GALLERY = SOURCE / "docs/tutorial", SOURCE / "scenes/gallery"
STEPS = 6


def commands(text, language="(?:sh)?"):
    """The lines of code blocks, lines that go on joined."""
    for block in re.findall(rf"```{language}\n(.*?)```", text, re.S):
        joined = ""
        for line in block.replace("\\\n", " ").splitlines():
            joined += line + "\n"
            if joined.count("'") % 2 == 0:  # a program for awk takes two lines
                yield joined.strip()
                joined = ""


def run_some_steps(here, scene, out, *options):
    """The scene loads without a warning, runs, and keeps its liquid."""
    said = drench("check", scene, *options, cwd=here)
    expect("warning" not in said.stdout + said.stderr, f"drench check warns of {scene}:\n{said.stdout}{said.stderr}")
    drench("run", scene, "-o", out, "--steps", STEPS, "--quiet", *options, cwd=here)
    rows = stats(here / out)
    expect(len(rows) == STEPS and all(float(row["mass_error"]) == 0 for row in rows), f"{scene} loses liquid")
    return rows


# --- README.md

def first_steps(here):
    text = (SOURCE / "README.md").read_text()
    (here / "scenes").symlink_to(SOURCE / "scenes")
    block, = re.findall(r"```yaml\n(.*?)```", text, re.S)
    (here / "scene.yaml").write_text(block)
    expect(int(run_some_steps(here, "scene.yaml", "shown")[-1]["particles"]) > 0, "the scene of README.md has no water")
    done, shorter = [], ["--quiet", "--set", "output.checkpoint_every=0.02"]
    for line in commands(text[text.index("## Quick start"):text.index("## A scene")]):
        name, *rest = shlex.split(line, comments=True)
        if name == "tools/test":
            continue
        expect((SOURCE / name).exists() or name == "build/openmp-float/drench", f"there is no {name}")
        if name == "tools/render":  # needs a display
            expect((here / rest[0] / "fluid.pvd").exists(), f"{rest[0]} is drawn before it is run")
            done.append("picture")
        elif name == "tools/run" and "--resume" in rest:
            folder = here / rest[rest.index("--resume") + 1]
            before = [row["time"] for row in stats(folder)]
            expect(float(rest[rest.index("--until") + 1]) > 1.5, "goes on behind time.end")
            drench("run", *rest[:rest.index("--until")], *shorter, "--set", "time.end=0.1", cwd=here)
            after = [row["time"] for row in stats(folder)]
            expect(after[:len(before)] == before and float(after[-1]) > 0.0999, "does not go on")
            done.append("restart")
        elif name == "tools/run":
            expect(rest[0] == "scenes/water_on_cloth.yaml", f"runs {rest[0]}")
            done.append("change" if "--set" in rest else "run")
            drench("run", *rest, *shorter, "--set", "time.end=0.06", cwd=here)
        else:
            done.append(rest[0])
            drench(*rest, cwd=here)
    expect(done == ["run", "picture", "report", "change", "restart", "compare"], str(done))


# --- scenes/gallery

def gallery_run(here, scene, *options):
    """The output folder."""
    pairs = list(zip(options[::2], options[1::2]))
    expect(len(options) % 2 == 0 and all(name in ("--until", "--set", "-o") for name, _ in pairs), f"options of tools/run: {options}")
    sets = [word for name, value in pairs if name == "--set" for word in ("--set", value)]
    out = dict(pairs).get("-o", f"out/{Path(scene).stem}")
    if scene.startswith("scenes/paper/"):  # of full size, with the paper's long steps
        drench("check", scene, *sets, cwd=here)
    else:
        run_some_steps(here, scene, out, *sets)
    return out


def gallery_render(words, runs):
    """A command that draws: of a run of this page, with options that there are."""
    expect(words[0] in runs, f"{words[0]} is drawn before it is run")
    rest = [word for word in words[1:] if word != "--cycles"]
    options = dict(zip(rest[::2], rest[1::2]))
    known = {"--frames", "--size", "--samples", "--camera", "--animation", "--fps", "--backdrop", "-o"}
    expect(len(rest) % 2 == 0 and set(options) <= known, f"options of tools/render: {rest}")
    expect("--cycles" in words or not {"--samples", "--backdrop"} & set(options), f"options of Cycles without it: {rest}")
    picture_options.picture_size(options.get("--size", "900x600"))
    picture_options.camera(options.get("--camera", "auto"))


def gallery(here):
    page = (GALLERY / "README.md").read_text()
    rows = re.findall(r"^\| (.*?) \| !\[\]\((.*?)\) \|$", page, re.M)
    there = sorted(path.name for path in GALLERY.iterdir() if path.suffix in (".png", ".jpg", ".gif", ".webp"))
    expect(len(rows) > 20 and sorted(picture for _, picture in rows) == there, "the page and the folder have other pictures")
    for scene in re.findall(r"`([\w/]+\.yaml)`", " ".join(text for text, _ in rows)):
        expect((SOURCE / "scenes" / scene).is_file(), f"there is no scenes/{scene}")
    for scene in GALLERY.glob("*.yaml"):
        expect(f"`gallery/{scene.name}`" in page, f"{scene.name} has no picture")
        expect(f"tools/run scenes/gallery/{scene.name}" in page, f"{scene.name} has no command")
    call(sys.executable, TUTORIAL / "make_shirt.py", here, 40, check=True)
    expect((here / "shirt.obj").read_bytes() == (GALLERY / "shirt.obj").read_bytes(), "shirt.obj is another one")
    runs = set()
    for folder in ("scenes", "docs"):
        shutil.copytree(SOURCE / folder, here / folder)
    for line in commands(page):
        name, *words = shlex.split(line, comments=True)
        if name == "tools/run":
            runs.add(gallery_run(here, *words))
        elif name == "tools/render":
            gallery_render(words, runs)
        else:
            expect(name == "tools/setup" and words in (["blender"], ["export"]), f"a command that is not known: {name}")
    expect(len(runs) > 3, f"only {len(runs)} scenes")


# --- docs/tutorial

PAGES = {"2_cloth.md": "towel.yaml", "3_water.md": "towel_water.yaml", "4_wetting.md": "towel_wet.yaml", "5_garment.md": "shirt.yaml"}
ENDS = {"water_on_cloth": 0.2, "towel": 0.1, "towel_water": 0.2, "towel_wet": 0.3, "shirt": 0.3, "splash": 0.3, "own": 0.4}


def settings(text):
    """The lines of a scene without comments, one space for many."""
    lines = (" ".join(line.split("#")[0].split()) for line in text.splitlines())
    return [line for line in lines if line]


def tutorial(here):
    call(sys.executable, TUTORIAL / "make_shirt.py", here, check=True)
    scenes = sorted((TUTORIAL / "scenes").glob("*.yaml"))
    expect([scene.name for scene in scenes] == sorted(PAGES.values()), f"other scenes: {scenes}")
    for scene in scenes:
        shutil.copy(scene, here)
        wet = "fluid:" in scene.read_text()
        rows = run_some_steps(here, scene.name, scene.stem, *(["--set", "fluid.sources.0.jet.start=0"] if wet else []))
        expect(not wet or int(rows[-1]["particles"]) > 0, f"{scene.name} has no water")
    for page, scene in PAGES.items():
        there = settings((TUTORIAL / "scenes" / scene).read_text())
        shown = settings("".join(re.findall(r"```yaml\n(.*?)```", (TUTORIAL / page).read_text(), re.S)))
        expect(shown and set(shown) <= set(there), f"{page} shows what is not in {scene}: {set(shown) - set(there)}")


class Walk:
    def __init__(self, here):
        self.here, self.ran = here, []

    def shell(self, line):
        done = call("bash", "-ec", line, cwd=self.here, env=environment(PATH=f"{BUILD}:{os.environ['PATH']}"))
        expect(done.returncode == 0, f"'{line}' ended with {done.returncode}:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
        self.ran.append(line)

    def run(self, words):
        scene = self.here / words[0]
        out = words[words.index("-o") + 1] if "-o" in words else f"out/{scene.stem}"
        end = ENDS[Path(out).name] + (0.05 if "--resume" in words else 0)
        if "--until" in words:
            words = words[:words.index("--until")] + words[words.index("--until") + 2:]
        changes = {"time.end": end, "output.checkpoint_every": 0.1, "output.every": 0.05}
        if "fluid:" in scene.read_text():
            changes |= {"fluid.spacing": 0.02, "fluid.sources.0.jet.start": 0}
        self.shell(f"drench run {shlex.join(words)} --quiet " + " ".join(f"--set {key}={value}" for key, value in changes.items()))
        last = stats(self.here / out)[-1]
        expect(float(last["time"]) >= end - 1e-3, f"{out} ends at {last['time']} s, not at {end} s")
        expect(float(last["mass_error"]) == 0, f"{out} loses liquid")
        expect("fluid:" not in scene.read_text() or int(last["particles"]) > 0, f"{out} has no water")

    def draw(self, words):
        expect((self.here / words[0]).is_dir(), f"{words[0]} is drawn before it is run")
        frames = "" if "--frames" in words else " --frames 2"
        self.shell(f"{SOURCE}/tools/render {shlex.join(words)}{frames} --size 240x180")
        picture = sorted((self.here / words[0] / "pictures").glob("*.png"))[-1]
        drawn = share(picture, lambda *colour: min(colour) < 245)
        expect(0.04 < drawn < 0.96, f"{picture.name} of {words[0]} shows nothing: {drawn:.3f} of it is drawn")

    def follow(self, line):
        name, *rest = shlex.split(line, comments=True)
        for word in rest:
            finished = TUTORIAL / "scenes" / Path(word).name
            if word.startswith("mine/") and word.endswith(".yaml") and not (self.here / word).exists() and finished.exists():
                shutil.copy(finished, self.here / word)
        if name in ("tools/test", "tools/setup", "tools/measure/speed_error") or "--cycles" in rest:
            return
        if name == "tools/run":
            self.run(rest)
        elif name == "tools/render":
            self.draw(rest)
        elif name == "alias":  # bash has no aliases in a script
            expect(rest == ["drench=build/openmp-float/drench"], line)
        else:
            self.shell(re.sub(r"--after \d+", "--after 10", line))


def walk(here):
    if not (BUILD / "drench-view").exists():
        skip("drench view is not built")
    if not shutil.which("Xvfb") and not os.environ.get("DISPLAY"):
        skip("no display, and no Xvfb")
    for folder in ("docs", "scenes"):
        shutil.copytree(SOURCE / folder, here / folder)
    reader = Walk(here)
    for page in sorted(TUTORIAL.glob("[0-9]_*.md")):
        for line in commands(page.read_text(), "sh"):
            reader.follow(line)
    expect(len(reader.ran) > 20, f"only {len(reader.ran)} commands")
    expect(reader.ran[-1].startswith(f"{SOURCE}/tools/render out/own"), f"does not end with a picture of one's own: {reader.ran[-1]}")
    picture = sorted((here / "out/own/pictures").glob("*.png"))[-1]
    cloth = share(picture, lambda r, g, b: r > b + 8 and r > 90)  # dry cloth is yellowish
    water = share(picture, lambda r, g, b: b > r + 40)
    expect(cloth > 0.02 and water > 0.002, f"one's own garment is not in it: cloth {cloth:.3f}, water {water:.3f}")


with tempfile.TemporaryDirectory() as scratch:
    {"first_steps": first_steps, "gallery": gallery, "tutorial": tutorial, "walk": walk}[sys.argv[3]](Path(scratch))
print("passed")
