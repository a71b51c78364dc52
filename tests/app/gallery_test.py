#!/usr/bin/env python3
"""gallery_test.py SOURCE BUILD: scenes/gallery/README.md keeps what it promises. Its pictures and scenes are there. Its commands, in
their order, are ones that the tools take: scenes load without a warning and run for a few steps, what is drawn was run before, and
views and sizes are read. Scenes of full size are only checked."""

import csv
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

sys.dont_write_bytecode = True
SOURCE, BINARY = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve() / "drench"
GALLERY = SOURCE / "scenes/gallery"
PAGE = (GALLERY / "README.md").read_text()
STEPS = 6
RENDER_OPTIONS = {"--frames", "--size", "--samples", "--camera", "--animation", "--fps", "--backdrop", "-o"}
sys.path.insert(0, str(SOURCE / "tools/export"))
import picture_options  # noqa: E402


def expect(good, message):
    if not good:
        sys.exit(f"gallery_test: {message}")


def commands():
    for block in re.findall(r"```(?:sh)?\n(.*?)```", PAGE, re.S):
        for line in block.replace("\\\n", " ").splitlines():
            yield shlex.split(line, comments=True)


def drench(here, *words):
    ran = subprocess.run([str(BINARY), *map(str, words)], capture_output=True, text=True, cwd=here)
    expect(ran.returncode == 0, f"{words} ended with {ran.returncode}:\n{ran.stdout}{ran.stderr}")
    return ran.stdout + ran.stderr


def run(here, words):
    """Checks the scene; runs the beginning of it where it is none of the paper's. Returns its output folder."""
    scene, options = words[0], words[1:]
    expect(len(options) % 2 == 0, f"not pairs of option and value: {options}")
    pairs = list(zip(options[::2], options[1::2]))
    expect(all(name in ("--until", "--set", "-o") for name, _ in pairs), f"options of tools/run: {options}")
    sets = [word for name, value in pairs if name == "--set" for word in ("--set", value)]
    out = dict(pairs).get("-o", f"out/{Path(scene).stem}")
    said = drench(here, "check", scene, *sets)
    if scene.startswith("scenes/paper/"):  # of full size, with the paper's long steps
        return out
    expect("warning" not in said, f"drench check warns of {scene}:\n{said}")
    drench(here, "run", scene, "-o", out, "--steps", STEPS, "--quiet", *sets)
    with (here / out / "stats.csv").open() as file:
        rows = list(csv.DictReader(file))
    expect(len(rows) == STEPS and all(float(row["mass_error"]) == 0 for row in rows), f"{scene} loses liquid")
    return out


def read_render(words, runs):
    """A command that draws: of a run of this page, with options that there are."""
    expect(words[0] in runs, f"{words[0]} is drawn before it is run")
    rest = [word for word in words[1:] if word != "--cycles"]
    expect(len(rest) % 2 == 0 and set(rest[::2]) <= RENDER_OPTIONS, f"options of tools/render: {rest}")
    options = dict(zip(rest[::2], rest[1::2]))
    expect("--cycles" in words or not {"--samples", "--backdrop"} & set(options), f"options of Cycles without it: {rest}")
    picture_options.picture_size(options.get("--size", "900x600"))
    picture_options.camera(options.get("--camera", "auto"))


def check_table():
    rows = re.findall(r"^\| (.*?) \| !\[\]\((.*?)\) \|$", PAGE, re.M)
    expect(len(rows) > 20, f"{len(rows)} rows")
    pictures = [picture for _, picture in rows]
    there = sorted(path.name for path in GALLERY.iterdir() if path.suffix in (".png", ".jpg", ".gif", ".webp"))
    expect(sorted(pictures) == there, f"pictures in the page and in the folder: {set(pictures) ^ set(there)}")
    for text, _ in rows:
        for scene in re.findall(r"`([\w/]+\.yaml)`", text):
            expect((SOURCE / "scenes" / scene).is_file(), f"there is no scenes/{scene}")
    for scene in GALLERY.glob("*.yaml"):
        expect(f"`gallery/{scene.name}`" in PAGE, f"{scene.name} has no picture")
        expect(f"tools/run scenes/gallery/{scene.name}" in PAGE, f"{scene.name} has no command")
    small = sum((GALLERY / name).stat().st_size for name in there)
    expect(small < 16e6, f"the pictures take {small / 1e6:.1f} MB")


def check_shirt():
    """The mesh of the gallery is the one that its scene says it is."""
    with tempfile.TemporaryDirectory() as scratch:
        subprocess.run([sys.executable, SOURCE / "docs/tutorial/make_shirt.py", scratch, "40"], check=True, stdout=subprocess.DEVNULL)
        expect((Path(scratch) / "shirt.obj").read_bytes() == (GALLERY / "shirt.obj").read_bytes(), "shirt.obj is another one")


def main():
    check_table()
    check_shirt()
    runs, done = set(), 0
    with tempfile.TemporaryDirectory() as scratch:
        here = Path(scratch)
        for folder in ("scenes", "docs"):
            shutil.copytree(SOURCE / folder, here / folder)
        for name, *words in commands():
            done += 1
            if name == "tools/run":
                runs.add(run(here, words))
            elif name == "tools/render":
                read_render(words, runs)
            else:
                expect(name == "tools/setup" and words in (["blender"], ["export"]), f"a command that is not known: {name}")
    expect(done > 6, f"only {done} commands")
    print(f"{done} commands, {len(runs)} scenes")


main()
