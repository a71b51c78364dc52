#!/usr/bin/env python3
"""Pictures of a small run by tools/render: render_test.py SOURCE_DIR BUILD_DIR. Exit code 77, skipped, without what draws."""

import os
import shutil
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from drawn_run import SCENE, expect, is_water, read_file  # noqa: E402
from png_pixels import share  # noqa: E402


def render(source, *arguments):
    return subprocess.run([os.path.join(source, "tools/render"), *arguments, "--size", "240x180"],
                          capture_output=True, text=True)


def pictures_of(folder):
    return {name: read_file(os.path.join(folder, name)) for name in sorted(os.listdir(folder))}


def main():
    source, build = sys.argv[1:3]
    with tempfile.TemporaryDirectory() as folder:
        scene, run = os.path.join(folder, "scene.yaml"), os.path.join(folder, "run")
        with open(scene, "w", encoding="utf-8") as file:
            file.write(SCENE)
        subprocess.run([os.path.join(build, "drench"), "run", scene, "-o", run, "--quiet", "--set", "output.every=0.04"], check=True)
        one, again, balls, moving = (os.path.join(folder, name) for name in ("one", "again", "balls", "moving.ogv"))
        first = render(source, run, "-o", one, "--animation", moving)
        expect(first.returncode == 0, first.stdout + first.stderr)
        expect(sorted(os.listdir(one)) == ["frame_0000.png", "frame_0001.png", "frame_0002.png"], str(os.listdir(one)))
        expect(read_file(moving)[:4] == b"OggS", "the animation is no Ogg file")

        second = render(source, run, "-o", again)
        expect(second.returncode == 0 and pictures_of(one) == pictures_of(again), "the same run has other pictures")

        last = os.path.join(one, "frame_0002.png")
        expect(share(last, is_water) > 0.02, "no water: %.4f" % share(last, is_water))
        expect(share(last, lambda *c: min(c) > 250) > 0.3, "no background")

        os.remove(os.path.join(run, "surface.pvd"))  # as without output.surface
        third = render(source, run, "-o", balls)
        expect(third.returncode == 0, third.stderr)
        last_balls = os.path.join(balls, "frame_0002.png")
        expect(share(last_balls, is_water) > 0.02, "no balls: %.4f" % share(last_balls, is_water))
        expect(pictures_of(one) != pictures_of(balls), "the surface is not drawn")

        fluid = os.path.join(run, "fluid.pvd")
        os.rename(fluid, fluid + ".away")
        dry = os.path.join(folder, "dry")
        expect(render(source, run, "-o", dry).returncode == 0, "cloth alone is not drawn")
        expect(share(os.path.join(dry, "frame_0002.png"), is_water) < 0.02, "water without water")

        bad = render(source, run, "--animation", os.path.join(folder, "a.avi"))
        expect(bad.returncode == 2 and bad.stderr.count("\n") == 1 and ".ogv" in bad.stderr, bad.stderr)
        missing = render(source, os.path.join(folder, "nowhere"))
        expect(missing.returncode == 2 and "no such folder" in missing.stderr, missing.stderr)


if not os.path.exists(os.path.join(sys.argv[2], "drench-view")):
    print("skipped: drench view is not built")
    sys.exit(77)
if not shutil.which("Xvfb") and not os.environ.get("DISPLAY"):
    print("skipped: no display, and no Xvfb")
    sys.exit(77)
main()
