"""Draws the frames of a drench output folder as PNG files: water as its surface where the run wrote one (output.surface),
else as balls. Started by tools/render; needs only VTK's Python modules."""

import argparse
import math
import os
import re
import sys
import xml.etree.ElementTree as ElementTree

from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from render_output import check_animation, fail, save_picture, write_animation  # noqa: E402
from render_picture import Picture  # noqa: E402

NAMED_VIEWS = {"auto": (32, 24), "below": (32, -22), "front": (0, 8), "top": (0, 80)}  # azimuth, elevation, degrees


def parse_arguments():
    parser = argparse.ArgumentParser(prog="tools/render", description=__doc__)
    parser.add_argument("outdir", metavar="OUTDIR")
    parser.add_argument("-o", dest="pngdir", metavar="PNGDIR", help="default: OUTDIR/pictures")
    parser.add_argument("--frames", type=int, metavar="N", help="N frames, evenly spread (default: all)")
    parser.add_argument("--size", default="1280x960", metavar="WxH")
    parser.add_argument("--animation", metavar="FILE",
                        help="also all pictures as FILE.ogv, .gif (needs python3-pil) or .mp4 (needs ffmpeg)")
    parser.add_argument("--fps", type=float, metavar="F", help="pictures a second of it (default: as time went, at most 50)")
    parser.add_argument("--camera", default="auto",
                        help="auto, below, front, top, or px,py,pz,fx,fy,fz: position and focal point in m")
    passed = os.environ.get("DRENCH_RENDER_ARGS")
    options = parser.parse_args(passed.split("\n") if passed else [] if passed == "" else None)
    size = re.fullmatch(r"(\d+)x(\d+)", options.size)
    if not size or min(int(size[1]), int(size[2])) < 16:
        fail("--size %s: must be like 1280x960" % options.size)
    options.size = int(size[1]), int(size[2])
    if options.frames is not None and options.frames < 1:
        fail("--frames must be at least 1")
    if options.fps is not None and not 0.1 <= options.fps <= 100:
        fail("--fps must be in [0.1, 100]")
    if options.animation:
        check_animation(options.animation)
    if options.camera not in NAMED_VIEWS:
        try:
            options.camera = [float(x) for x in options.camera.split(",")]
        except ValueError:
            options.camera = []
        if len(options.camera) != 6:
            fail("--camera: must be one of %s, or six numbers" % ", ".join(NAMED_VIEWS))
    if not os.path.isdir(options.outdir):
        fail("%s: no such folder" % options.outdir)
    return options


def read_collection(folder, name):
    """{time: [files]} of a .pvd, {} when the run has none."""
    path = os.path.join(folder, name + ".pvd")
    frames = {}
    if os.path.exists(path):
        for entry in ElementTree.parse(path).iter("DataSet"):
            frames.setdefault(float(entry.get("timestep")), []).append(os.path.join(folder, entry.get("file")))
    return frames


def read_grid(path):
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutput()


def upward(folder):
    """The axis against gravity, from the resolved scene."""
    try:
        with open(os.path.join(folder, "scene.yaml"), encoding="utf-8") as scene:
            found = re.search(r"^gravity: *\[([^]]*)\]", scene.read(), re.M)
        g = [float(x) for x in found[1].split(",")]
    except (OSError, TypeError, ValueError):
        return 0, 1, 0
    length = math.sqrt(sum(c * c for c in g))
    return tuple(-c / length for c in g) if length > 0 else (0, 1, 0)


def seen_points(grids):
    """Points that the camera must show: all but the farthest 2 % of each grid, so that a stray drop does not count."""
    seen = []
    for grid in grids:
        n = grid.GetNumberOfPoints()
        if n == 0:
            continue
        points = [grid.GetPoint(i) for i in range(0, n, max(1, n // 5000))]
        ranges = [sorted(p[k] for p in points) for k in range(3)]
        low, high = ([r[i] for r in ranges] for i in (len(points) // 50, len(points) - 1 - len(points) // 50))
        seen += [p for p in points if all(a <= x <= b for a, x, b in zip(low, p, high))]
    return seen


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def unit(a):
    length = math.sqrt(dot(a, a))
    return tuple(x / length for x in a)


def place_camera(renderer, view, up, points, aspect):
    """Points the camera so that `points` fill the picture but for a margin."""
    camera = renderer.GetActiveCamera()
    if not isinstance(view, str):
        camera.SetPosition(*view[:3])
        camera.SetFocalPoint(*view[3:])
        camera.SetViewUp(*up)
        return
    azimuth, elevation = (math.radians(x) for x in NAMED_VIEWS[view])
    side = unit(cross(up, (0, 0, 1) if abs(up[2]) < 0.9 else (0, 1, 0)))
    front = cross(side, up)
    toward = tuple(math.cos(elevation) * (math.sin(azimuth) * s + math.cos(azimuth) * f) + math.sin(elevation) * u
                   for s, f, u in zip(side, front, up))
    right = unit(cross(up, toward))
    above = cross(toward, right)
    spans = []
    for axis in (right, above, toward):
        along = [dot(p, axis) for p in points]
        spans.append((min(along) + max(along)) / 2)
    centre = [sum(m * axis[k] for m, axis in zip(spans, (right, above, toward))) for k in range(3)]
    half_angle = 15.0
    tangent = math.tan(math.radians(half_angle)) * 0.9  # the margin
    distance = 1e-3
    for point in points:
        p = [x - c for x, c in zip(point, centre)]
        reach = max(abs(dot(p, above)), abs(dot(p, right)) / aspect)
        distance = max(distance, dot(p, toward) + reach / tangent)
    camera.SetViewAngle(2 * half_angle)
    camera.SetFocalPoint(*centre)
    camera.SetPosition(*[c + distance * t for c, t in zip(centre, toward)])
    camera.SetViewUp(*above)


def main():
    options = parse_arguments()
    series = {name: read_collection(options.outdir, name) for name in ("fluid", "surface", "cloth", "bodies")}
    times = sorted(series["fluid"] or series["cloth"] or series["bodies"])
    if not times:
        fail("%s: holds no fluid.pvd, cloth.pvd or bodies.pvd with frames" % options.outdir)
    spread = [times[round(i * (len(times) - 1) / 8)] for i in range(9)]  # the camera sees what they show
    if options.frames and options.frames < len(times):
        picked = [round(i * (len(times) - 1) / max(1, options.frames - 1)) for i in range(options.frames)]
        times = [times[-1]] if options.frames == 1 else [times[i] for i in picked]

    ends = [read_grid(path) for name in ("fluid", "cloth") for t in sorted(set(spread))
            for path in series[name].get(t, [])]
    points = seen_points(ends) or seen_points([read_grid(p) for p in next(iter(series["bodies"].values()), [])])
    if not points:
        fail("%s: nothing to see" % options.outdir)
    picture = Picture(options.size)
    if series["cloth"]:
        picture.add_legend()
    place_camera(picture.renderer, options.camera, upward(options.outdir), points, options.size[0] / options.size[1])

    pngdir = options.pngdir or os.path.join(options.outdir, "pictures")
    os.makedirs(pngdir, exist_ok=True)
    pictures = []
    for i, time in enumerate(times):
        picture.clear()
        for path in series["bodies"].get(time, next(iter(series["bodies"].values()), [])):
            picture.add_bodies(read_grid(path))
        for path in series["cloth"].get(time, []):
            picture.add_cloth(read_grid(path))
        for path in series["surface"].get(time, []):
            picture.add_surface(read_grid(path))
        for path in series["fluid"].get(time, []) if time not in series["surface"] else []:
            picture.add_fluid(read_grid(path))
        picture.label.SetInput("t = %.3f s" % time)
        pictures.append(os.path.join(pngdir, "frame_%04d.png" % i))
        save_picture(picture.image(), pictures[-1])
    print("%d pictures in %s" % (len(times), pngdir))
    if options.animation:
        interval = (times[-1] - times[0]) / max(1, len(times) - 1)
        write_animation(options.animation, pictures, options.fps or min(50.0, 1 / interval if interval > 0 else 1.0))
        print("animation: %s" % options.animation)


main()
