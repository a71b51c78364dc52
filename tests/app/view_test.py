#!/usr/bin/env python3
"""view_test.py SOURCE BUILD view|render: `drench view` and `drench run --view` as a user sees them, and the pictures of tools/render. On
a virtual display keys are pressed and the screen is looked at. Exit code 77, skipped, without what draws."""

import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from support import BINARY, BUILD, SOURCE, call, drench, expect, skip, stats

sys.path.insert(0, str(SOURCE / "tools/export"))
import picture_options  # noqa: E402
import x_display  # noqa: E402
from png_pixels import read_png, share  # noqa: E402

# A block of water over a sheet of which a part is wet.
SCENE = """drench: 1
time: {step: 0.004, end: 0.08}
output: {every: 0.01, surface: true}
fluid: {spacing: 0.02, sources: [{block: {min: [-0.06, 0.03, -0.06], max: [0.06, 0.15, 0.06]}}]}
cloth:
  - mesh: {grid: {size: [0.4, 0.4], nodes: [11, 11]}}
    dynamics: false
    initial_saturation: [{box: {min: [-1, -1, -1], max: [-0.1, 1, 1]}, value: 1.0}]
    porous: {}
"""
LAST = 8  # frame


def is_water(red, green, blue):
    return blue > red + 60 and blue > green + 25 and blue > 120


def is_dark(red, green, blue):
    return max(red, green, blue) < 110 and blue < red + 60


class Viewer:
    """The program without a display of its own, and the folder that it works in."""

    def __init__(self, folder):
        self.drench, self.folder = str(BINARY), str(folder)
        self.run = self.path("run")
        with open(self.path("scene.yaml"), "w", encoding="utf-8") as file:
            file.write(SCENE)
        self.call("run", self.path("scene.yaml"), "-o", self.run, "--quiet", code=0)

    def path(self, name):
        return os.path.join(self.folder, name)

    def call(self, *arguments, code, environment=None):
        bare = {name: value for name, value in os.environ.items() if name != "DISPLAY"}
        done = subprocess.run([self.drench, *arguments], capture_output=True, text=True, env=environment or bare, timeout=120,
                              check=False)
        expect(done.returncode == code, "%s: exit code %d: %s" % (arguments, done.returncode, done.stdout + done.stderr))
        if code:
            expect(done.stderr.count("\n") == 1, "%s: not one line: %s" % (arguments, done.stderr))
        return done.stderr if code else done.stdout

    def picture(self, name, *options):
        self.call("view", self.run, "--screenshot", self.path(name), "--size", "240x180", *options, code=0)
        return self.path(name)


def test_screenshots(viewer):
    last = viewer.picture("last.png")
    expect(read_png(last)[:2] == (240, 180), "the size is not that which was asked for")
    expect(share(last, is_water) > 0.02, "no water: %.4f" % share(last, is_water))
    expect(share(last, is_dark) > 0.02, "wet cloth is not dark: %.4f" % share(last, is_dark))
    expect(share(last, lambda *c: min(c) > 250) > 0.3, "no background")
    expect(Path(last).read_bytes() == Path(viewer.picture("again.png", "--frame", str(LAST))).read_bytes(), "the last frame has two pictures")
    different = [last] + [viewer.picture(name + ".png", *options) for name, options in (
        ("first", ["--frame", "0"]), ("particles", ["--liquid", "particles"]), ("speed", ["--color", "velocity"]),
        ("density", ["--color", "density"]), ("top", ["--camera", "top"]), ("own", ["--camera", "0,1,1,0,0,0"]))]
    expect(len({Path(name).read_bytes() for name in different}) == len(different), "two of the pictures are the same")
    expect(share(viewer.path("speed.png"), is_water) < 0.005, "coloured water is blue")
    viewer.call("view", viewer.run, "--pictures", viewer.path("many"), "--frames", "3", "--size", "240x180", code=0)
    expect(sorted(os.listdir(viewer.path("many"))) == ["frame_000%d.png" % i for i in range(3)], "not three pictures")
    expect(Path(viewer.path("many/frame_0002.png")).read_bytes() == Path(last).read_bytes(), "a picture of many is another one")


def test_errors(viewer):
    shot = ["--screenshot", viewer.path("no.png")]
    for arguments, part in ((["--frame", str(LAST + 1)], "has frames 0 to %d" % LAST), (["--color", "wetness"], "allowed: look, velocity"),
                            (["--camera", "left"], "allowed: auto"), (["--size", "9x9"], "allowed: WIDTHxHEIGHT"),
                            (["--frame", "-1"], "a number from 0")):
        expect(part in viewer.call("view", viewer.run, *shot, *arguments, code=2), "%s: no '%s'" % (arguments, part))
    expect("no such folder" in viewer.call("view", viewer.path("nowhere"), *shot, code=2), "a folder that is not there")
    expect("holds no frames" in viewer.call("view", viewer.folder, *shot, code=2), "a folder without frames")
    expect("no display" in viewer.call("view", viewer.run, code=2), "a window without a display")
    unseen = ["run", viewer.path("scene.yaml"), "-o", viewer.path("unseen"), "--view"]
    expect("no display" in viewer.call(*unseen, code=2), "a run with a window without a display")
    expect(not os.path.exists(viewer.path("unseen")), "it ran all the same")
    expect("--no-output" in viewer.call(*unseen[:2], "--view", "--no-output", code=2), "a view of no frames")
    broken = viewer.path("run/frames/fluid_000004.vtu")
    whole = Path(broken).read_bytes()
    Path(broken).write_bytes(whole[:200])
    expect("is not a complete frame" in viewer.call("view", viewer.run, *shot, code=2), "half a frame")
    Path(broken).write_bytes(whole)


def test_options_of_cycles(viewer):
    """tools/render --cycles takes and rejects the sizes and views that drench view does, with the same words."""
    sizes = ("240x180", "16x16", "15x16", "8193x16", "0240x180", "240x", "240X180", "240x180x3", "-240x180", " 240x180")
    views = ("below", "left", "Top", "0.5,-1e-1,+2,.5,0,1.", "0, 1 , 1,0,0,0", "0,1,1,0,0", "0,1,1,0,0,0,0", "1,1,1,1,1,1",
             "0,1,1,0,0,nan", "0,1,1,0,0,1e999", "0,1,1,0,0,0x1", "0;1;1;0;0;0", "1_0,1,1,0,0,0", "0,1,1,0,0,")
    for option, read, texts in (("--size", picture_options.picture_size, sizes), ("--camera", picture_options.camera, views)):
        for text in texts:
            said = None
            try:
                read(text)
            except picture_options.OptionError as wrong:
                said = str(wrong)
            words = ["view", viewer.run, "--screenshot", viewer.path("option.png"), "%s=%s" % (option, text)]
            if option == "--camera":
                words += ["--size", "32x32"]
            answer = viewer.call(*words, code=2 if said else 0)
            expect(not said or said in answer, "%s %r: '%s', and in Cycles '%s'" % (option, text, answer, said))


def wakes(process, seconds):
    """How often the process's main thread wakes up in that time."""
    def so_far():
        with open("/proc/%d/status" % process, encoding="utf-8") as file:
            return next(int(line.split()[1]) for line in file if line.startswith("voluntary_ctxt_switches"))
    before = so_far()
    time.sleep(seconds)
    return so_far() - before


def comes_to_rest(process, seconds, most):
    """Whether there comes a time of so many seconds in which it wakes up at most so often; drawing may go on for a while."""
    return any(wakes(process, seconds) <= most for _ in range(10))


def test_window(viewer, display):
    window = subprocess.Popen([viewer.drench, "view", viewer.run, "--size", "480x360"], env=display.environment())
    try:
        first = display.wait_until(lambda screen: screen.count(b"\xff\xff\xff\x00") + screen.count(b"\xff\xff\xff\xff") > 20000)
        expect(first, "no window")
        seen = [first]
        for keys in (["Left"], ["Home"], ["c"], ["l"], ["h"], ["3"]):
            display.press(*keys)
            changed = display.wait_until(lambda screen: screen not in seen)
            expect(changed, "nothing new to see after %s" % keys)
            seen.append(changed)
        display.drag((240, 150), (300, 120))  # turns the camera
        expect(display.wait_until(lambda screen: screen not in seen), "the mouse turns nothing")
        display.press("End", "s")
        saved = viewer.path("run/pictures/view_%06d.png" % LAST)
        display.wait_until(lambda screen: os.path.exists(saved))
        expect(os.path.exists(saved) and read_png(saved)[:2] == (480, 360), "no picture saved")
        before = display.screen()
        display.press("Home", "space")
        display.wait_until(lambda screen: screen != before)
        display.press("s")
        expect(display.wait_until(lambda screen: len(os.listdir(viewer.path("run/pictures"))) == 1), "it does not play to the end")
        expect(comes_to_rest(window.pid, 2, 10), "it goes on looking whether there is something to play")
        display.press("q")
        expect(window.wait(timeout=30) == 0, "it ends with an error: %s" % window.returncode)
    finally:
        window.kill()


def process_of(program, folder):
    """The number of the process that runs this program on this folder."""
    for number in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open("/proc/%s/cmdline" % number, "rb") as file:
                words = file.read().decode().split("\0")
        except OSError:  # it ended meanwhile
            continue
        if os.path.basename(words[0]) == program and folder in words:
            return int(number)
    expect(False, "no %s is at work on %s" % (program, folder))
    return None


def outputs(folder):
    """Hashes of all frames, and stats.csv without times."""
    hashes = {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in Path(folder, "frames").iterdir()}
    return hashes, [{key: value for key, value in row.items() if not key.startswith("ms_")} for row in stats(folder)]


def test_follow(viewer, display):
    folder = viewer.path("watched")
    before = display.screen()
    viewer.call("run", viewer.path("scene.yaml"), "-o", folder, "--quiet", "--view", code=0, environment=display.environment())
    expect(outputs(folder) == outputs(viewer.run), "a run that is watched has other results")
    expect(display.wait_until(lambda screen: screen != before, 240), "no window")
    display.press("s")  # of the newest frame
    saved = os.path.join(folder, "pictures", "view_%06d.png" % LAST)
    for _ in range(240):  # a busy machine draws slowly, and looks for frames as seldom as drawing them costs
        if os.path.exists(saved):
            break
        time.sleep(0.5)
        display.press("s")
    expect(os.path.exists(saved), "the window does not come to the last frame")
    watcher = process_of("drench-view", folder)
    expect(comes_to_rest(watcher, 6, 20), "it goes on looking for frames of a run that has ended")
    gone = display.screen()
    display.press("q")
    expect(display.wait_until(lambda screen: screen != gone), "q does not close the window")


def render(*arguments):
    return call(SOURCE / "tools/render", *arguments, "--size", "240x180")


def pictures_of(folder):
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


def test_render(folder):
    (folder / "scene.yaml").write_text(SCENE)
    run = folder / "run"
    drench("run", folder / "scene.yaml", "-o", run, "--quiet", "--set", "output.every=0.04")
    one, again, balls, dry, moving = (folder / name for name in ("one", "again", "balls", "dry", "moving.ogv"))

    def water_in(where, *options):
        done = render(run, "-o", where, *options)
        expect(done.returncode == 0, done.stdout + done.stderr)
        return share(where / "frame_0002.png", is_water)

    expect(water_in(one, "--animation", moving) > 0.02, "no water")
    expect(sorted(pictures_of(one)) == ["frame_0000.png", "frame_0001.png", "frame_0002.png"], str(sorted(pictures_of(one))))
    expect(moving.read_bytes()[:4] == b"OggS", "the animation is no Ogg file")
    expect(share(one / "frame_0002.png", lambda *c: min(c) > 250) > 0.3, "no background")
    water_in(again)
    expect(pictures_of(one) == pictures_of(again), "the same run has other pictures")
    if not subprocess.run(["/usr/bin/python3", "-c", "import PIL.Image"], capture_output=True).returncode:
        water_in(again, "--animation", folder / "moving.webp")
        expect((folder / "moving.webp").read_bytes().count(b"ANMF") == 3, "the film has not three pictures")
    (run / "surface.pvd").unlink()  # as without output.surface
    expect(water_in(balls) > 0.02, "no balls")
    expect(pictures_of(one) != pictures_of(balls), "the surface is not drawn")
    (run / "fluid.pvd").unlink()
    expect(water_in(dry) < 0.02, "water without water")
    bad = render(run, "--animation", folder / "a.avi")
    expect(bad.returncode == 2 and bad.stderr.count("\n") == 1 and ".ogv" in bad.stderr, bad.stderr)
    missing = render(folder / "nowhere")
    expect(missing.returncode == 2 and "no such folder" in missing.stderr, missing.stderr)


def test_view(folder):
    if reason := x_display.missing():
        skip(reason)
    display = x_display.Display(640, 480)
    viewer = Viewer(folder)
    try:
        for test in (test_screenshots, test_errors, test_options_of_cycles):
            test(viewer)
        for test in (test_window, test_follow):
            test(viewer, display)
    finally:
        display.close()


if not (BUILD / "drench-view").exists():
    skip("drench view is not built")
if not shutil.which("Xvfb") and not os.environ.get("DISPLAY"):
    skip("no display, and no Xvfb")
with tempfile.TemporaryDirectory() as scratch:
    {"view": test_view, "render": test_render}[sys.argv[3]](Path(scratch))
print("passed")
