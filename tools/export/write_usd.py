"""Writes the frames of a run as one USD file. `drench export OUT --to usd` starts it; `tools/setup export` makes the Python
that it needs, with usd-core and numpy."""

import argparse
import os
import re
import sys
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parent))

from refusal import fail, fail_without

ENDINGS = (".usdc", ".usda", ".usd")
SAVE_EVERY = 256e6  # bytes of arrays that wait in memory


try:
    from pxr import Tf, Usd, UsdGeom
    from usd_prims import Bodies, Liquid, Surface, define_cloths
    from vtu_reader import Frame, FrameError, read_collection
    from wet_maps import Particles
    from wet_textures import Texture, write_exr
    import numpy as np
except ImportError as error:
    fail_without(error.name)


def parse_arguments():
    parser = argparse.ArgumentParser(prog="write_usd.py", description=__doc__)
    parser.add_argument("folder", type=Path, help="of the run")
    parser.add_argument("file", type=Path, help="ends in .usdc, .usda or .usd")
    parser.add_argument("--rate", type=float, required=True, help="time codes per second")
    parser.add_argument("--up", choices=("Y", "Z"), default="Y")
    parser.add_argument("--cloth", action="append", default=[], metavar="NAME", help="names, in the frames' order")
    parser.add_argument("--texture", action="append", default=[], metavar="CLOTH:DESCRIPTOR",
                        help="an open file of floats: u and v of each corner of the cloth's triangles")
    parser.add_argument("--wet-maps", action="store_true", help="contact time and film on the points of bodies")
    parser.add_argument("--body-texture", action="append", default=[], metavar="BODY:DESCRIPTOR", help="as --texture")
    parser.add_argument("--wet-textures", type=int, metavar="PIXELS", help="with --wet-maps: the edge of images of them")
    options = parser.parse_args()
    if options.file.suffix not in ENDINGS:
        fail(f"{options.file}: must end in {', '.join(ENDINGS)}")
    return options


def new_stage(path, options):
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, options.up)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    stage.SetTimeCodesPerSecond(options.rate)
    stage.SetFramesPerSecond(options.rate)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/World").GetPrim())
    UsdGeom.Scope.Define(stage, "/World/materials")
    stage.GetRootLayer().comment = "A run of drench: SI units; velocities in m/s, saturation 1 where the pores are full"
    return stage


def read_textures(arguments):
    """{number of a cloth or body: rows of u and v}"""
    textures = {}
    for argument in arguments:
        cloth, descriptor = map(int, argument.split(":"))
        os.lseek(descriptor, 0, os.SEEK_SET)
        with open(descriptor, "rb") as file:
            textures[cloth] = np.frombuffer(file.read(), np.float32).reshape(-1, 2)
    return textures


class Scene:
    """The prims of a run, made when their first frame comes."""

    def __init__(self, stage, has_surface, cloth_names, textures, body_textures, wet_maps=False, images=None):
        """Textures: texture coordinates by number; `images`: of wet maps, None for none."""
        self.stage, self.has_surface, self.cloth_names, self.textures = stage, has_surface, cloth_names, textures
        self.body_textures, self.images = body_textures, images
        self.liquid = self.surface = self.cloths = self.bodies = None
        self.wet_maps, self.particles, self.wet_at = wet_maps, None, None

    def write(self, series, code, path):
        """Returns about how many bytes of arrays it wrote."""
        with Frame(path) as frame:
            if series == "fluid":
                self.liquid = self.liquid or Liquid(self.stage, self.has_surface)
                if self.wet_maps:
                    points, radius = frame.read("Points"), frame.read("radius")
                    self.particles = Particles(points.astype(float), radius) if len(points) else None
                return self.liquid.write(code, frame)
            if series == "surface":
                self.surface = self.surface or Surface(self.stage)
                return self.surface.write(code, frame)
            if series == "cloth":
                self.cloths = self.cloths or define_cloths(self.stage, frame, self.cloth_names, self.textures)
                return sum(cloth.write(code, frame) for cloth in self.cloths)
            self.bodies = self.bodies or Bodies(self.stage, self.body_textures)
            self.bodies.write(code, path, frame)
            return 0

    def write_wetness(self, code, time):
        """After the series of a time that has particles. Returns about how many bytes of arrays it wrote."""
        if not self.wet_maps or not self.bodies:
            return 0
        since = time - self.wet_at if self.wet_at is not None else 0.0
        self.wet_at = time
        for index, body in self.bodies.bodies.items():
            body.write_wetness(code, self.particles, since)
            if self.images:
                self.images.write(index, body, code)
        return sum(8 * len(body.rest) for body in self.bodies.bodies.values())

    def summary(self):
        parts = []
        if self.liquid:
            parts.append(f"{self.liquid.count} particles in the last")
        if self.surface:
            parts.append("their surface")
        if self.cloths:
            parts.append("cloth " + ", ".join(cloth.prim.GetPrim().GetName() for cloth in self.cloths))
        if self.bodies:
            parts.append(f"{len(self.bodies.bodies)} bodies")
        return ", ".join(parts)


class Images:
    """Wet maps in the texture coordinates of bodies, a file for each body and frame."""

    def __init__(self, folder, size, coordinates):
        self.folder, self.size, self.coordinates, self.textures, self.written = folder, size, coordinates, {}, set()

    def write(self, index, body, code):
        if index not in self.coordinates or body.map is None:
            return
        if index not in self.textures:
            self.textures[index] = self._texture(index, body)
        texture = self.textures[index]
        if texture is None:
            return
        self.folder.mkdir(parents=True, exist_ok=True)
        path = self.folder / f"body_{index}.{round(code):04}.exr"  # of two frames at one picture, the later one
        write_exr(path,
                  {"R": texture.image(body.map.contact), "G": texture.image(body.map.film),
                   "B": (texture.source >= 0).astype(np.float32)})
        self.written.add(path)

    def _texture(self, index, body):
        coordinates = self.coordinates[index]
        if len(coordinates) > len(body.corners):
            print(f"warning: body {index}: its mesh file is not the one of the run: no images", file=sys.stderr)
            return None
        texture = Texture(coordinates, body.corners[:len(coordinates)], self.size)  # triangles that close holes come last
        if texture.outside > 0:
            print(f"warning: body {index}: {texture.outside} triangles have texture coordinates outside 0 to 1 and are not in the "
                  "images", file=sys.stderr)
        return texture

    def summary(self):
        return f"; {len(self.written)} images of {self.size} × {self.size} pixels in {self.folder}"


def time_code(time, rate):
    """Rounded, so that a frame of the run is met where a picture asks for it."""
    return round(time * rate, 5)


def export(options, temporary):
    series = {name: read_collection(options.folder, name) for name in ("fluid", "surface", "cloth", "bodies")}
    stage = new_stage(temporary, options)
    images, body_textures = None, read_textures(options.body_texture)
    if options.wet_textures:
        folder = options.file.with_name(options.file.stem + "_wet")
        images = Images(folder, options.wet_textures, body_textures)
    scene, waiting, codes = Scene(stage, bool(series["surface"]), options.cloth, read_textures(options.texture),
                                 body_textures, options.wet_maps, images), 0, []
    for time in sorted({time for frames in series.values() for time in frames}):
        code = time_code(time, options.rate)
        for name, frames in series.items():
            for path in frames.get(time, []):
                waiting += scene.write(name, code, path)
        if time in series["fluid"]:
            waiting += scene.write_wetness(code, time)
        codes.append(code)
        if waiting > SAVE_EVERY:
            stage.GetRootLayer().Save()
            waiting = 0
    stage.SetStartTimeCode(codes[0])
    stage.SetEndTimeCode(codes[-1])
    stage.GetRootLayer().Save()
    return len(codes), scene.summary(), images.summary() if images else ""


def reason_of(error):
    """USD's errors name its own files and lines; the reason is what stands in quotes."""
    found = re.search(r" : '(.*?)'(?: Error in |\s*$)", " ".join(str(error).split()))
    return found[1] if found else getattr(error, "strerror", None) or str(error)


def main():
    options = parse_arguments()
    temporary = options.file.with_name(f".{options.file.stem}.part{options.file.suffix}")
    try:
        options.file.parent.mkdir(parents=True, exist_ok=True)
        temporary.unlink(missing_ok=True)
        frames, summary, images = export(options, temporary)
        os.replace(temporary, options.file)
    except FrameError as error:
        fail(str(error))
    except (OSError, Tf.ErrorException) as error:
        fail(f"{options.file}: cannot be written: {reason_of(error)}")
    finally:
        temporary.unlink(missing_ok=True)
    size = options.file.stat().st_size / 2**20
    print(f"{options.file}: {frames} frames at {options.rate:.6g} per second, {summary}; {size:.1f} MiB{images}")


if __name__ == "__main__":
    main()
