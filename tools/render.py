"""Draws the frames of a drench output folder as PNG files: water as its surface where the run wrote one (output.surface),
else as balls. Started by tools/render; needs only VTK's Python modules."""

import argparse
import json
import math
import os
import re
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

import vtkmodules.vtkRenderingFreeType  # noqa: F401  (registers the text renderer)
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  (registers the OpenGL renderer)
from vtkmodules.vtkCommonCore import vtkLookupTable
from vtkmodules.vtkCommonDataModel import vtkDataObject
from vtkmodules.vtkFiltersCore import vtkFeatureEdges, vtkPolyDataNormals, vtkThreshold
from vtkmodules.vtkFiltersGeometry import vtkDataSetSurfaceFilter
from vtkmodules.vtkFiltersSources import vtkSphereSource
from vtkmodules.vtkIOImage import vtkPNGWriter
from vtkmodules.vtkImagingCore import vtkImageAppendComponents, vtkImageBlend, vtkImageExtractComponents, vtkImageMapToColors
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader
from vtkmodules.vtkRenderingAnnotation import vtkScalarBarActor
from vtkmodules.vtkRenderingCore import (vtkActor, vtkColorTransferFunction, vtkGlyph3DMapper, vtkLight,
                                         vtkPolyDataMapper, vtkProperty, vtkRenderer, vtkRenderWindow, vtkTextActor,
                                         vtkWindowToImageFilter)

WATER = (0.13, 0.45, 0.80)
PRESET = os.path.join(os.path.dirname(os.path.abspath(__file__)), "saturation.json")  # ParaView reads it too
INK = (0.15, 0.15, 0.18)
WATER_OPACITY = 0.72, 0.97  # of water seen at right angles, and along its surface
NAMED_VIEWS = {"auto": (32, 24), "below": (32, -22), "front": (0, 8), "top": (0, 80)}  # azimuth, elevation, degrees


def fail(message):
    print("tools/render: " + message, file=sys.stderr)
    sys.exit(2)


def check_animation(path):
    """Fails now, and not after an hour of drawing, if that kind of file cannot be written here."""
    kind = os.path.splitext(path)[1]
    try:
        if kind == ".ogv":
            import vtkmodules.vtkIOOggTheora  # noqa: F401
        elif kind == ".gif":
            import PIL.Image  # noqa: F401
        elif kind != ".mp4":
            fail("--animation %s: must end in .ogv, .gif or .mp4" % path)
        elif not shutil.which("ffmpeg"):
            fail("--animation %s: ffmpeg is not here: apt-get install ffmpeg, or write .ogv" % path)
    except ImportError as missing:
        fail("--animation %s: Python's module %s is not here%s" %
             (path, missing.name, ": apt-get install python3-pil, or write .ogv" if kind == ".gif" else ""))


def write_animation(path, pictures, fps):
    kind = os.path.splitext(path)[1]
    if kind == ".mp4":
        pattern = os.path.join(os.path.dirname(pictures[0]), "frame_%04d.png")
        command = ["ffmpeg", "-y", "-loglevel", "error", "-framerate", "%.6g" % fps, "-i", pattern, "-frames:v",
                   str(len(pictures)), "-pix_fmt", "yuv420p", "-vf", "crop=trunc(iw/2)*2:trunc(ih/2)*2", path]
        if subprocess.run(command).returncode != 0:
            fail("%s: ffmpeg failed" % path)
    elif kind == ".gif":
        from PIL import Image
        images = [Image.open(picture).convert("RGB") for picture in pictures]
        palette = images[len(images) // 2].quantize(128)  # one for all, so that colours do not flicker
        images = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]
        images[0].save(path, save_all=True, append_images=images[1:], duration=max(20, round(1000 / fps)), loop=0,
                       optimize=False)
    else:
        from vtkmodules.vtkIOImage import vtkPNGReader
        from vtkmodules.vtkIOOggTheora import vtkOggTheoraWriter
        writer = vtkOggTheoraWriter()
        writer.SetFileName(path)
        writer.SetRate(max(1, round(fps)))
        writer.SetQuality(2)
        for i, picture in enumerate(pictures):
            reader = vtkPNGReader()
            reader.SetFileName(picture)
            reader.Update()
            writer.SetInputData(reader.GetOutput())
            if i == 0:
                writer.Start()
            writer.Write()
        writer.End()
    if not os.path.exists(path) or os.path.getsize(path) == 0:
        fail("%s: cannot be written" % path)


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


class Picture:
    """One window whose actors get new data frame by frame."""

    def __init__(self, size):
        self.renderer = vtkRenderer()
        self.renderer.SetBackground(1, 1, 1)
        self.renderer.AutomaticLightCreationOff()
        for position, strength in (((-0.6, 1.0, 0.8), 0.85), ((0.9, 0.5, 0.6), 0.30), ((0.2, -1.0, 0.5), 0.55)):
            light = vtkLight()
            light.SetLightTypeToCameraLight()
            light.SetPosition(*position)
            light.SetFocalPoint(0, 0, 0)
            light.SetIntensity(strength)
            self.renderer.AddLight(light)
        self.window = vtkRenderWindow()
        self.window.SetOffScreenRendering(1)
        self.window.SetMultiSamples(8)
        self.window.SetSize(*size)
        self.window.AddRenderer(self.renderer)
        self.actors = []
        self.water = None
        self.colours = vtkColorTransferFunction()
        with open(PRESET, encoding="utf-8") as preset:
            points = json.load(preset)[0]["RGBPoints"]
        for i in range(0, len(points), 4):
            self.colours.AddRGBPoint(*points[i:i + 4])
        self.label = vtkTextActor()
        self.label.GetTextProperty().SetColor(*INK)
        self.label.GetTextProperty().SetFontSize(max(12, size[1] // 34))
        self.label.SetPosition(size[0] // 40, size[1] // 40)
        self.texts = [self.label]
        self.renderer.AddActor2D(self.label)

    def add_legend(self):
        legend = vtkScalarBarActor()
        legend.SetLookupTable(self.colours)
        legend.SetTitle("saturation")
        legend.SetNumberOfLabels(4)
        legend.SetLabelFormat("%.1f")
        legend.SetPosition(0.89, 0.05)
        legend.SetWidth(0.075)
        legend.SetHeight(0.32)
        for text in (legend.GetTitleTextProperty(), legend.GetLabelTextProperty()):
            text.SetColor(*INK)
            text.SetBold(0)
            text.SetItalic(0)
            text.SetShadow(0)
            text.SetFontSize(max(11, self.window.GetSize()[1] // 48))
        legend.UnconstrainedFontSizeOn()
        self.texts.append(legend)
        self.renderer.AddActor2D(legend)

    def clear(self):
        for actor in self.actors:
            self.renderer.RemoveActor(actor)
        self.actors, self.water = [], None

    def add(self, mapper, colour=(1, 1, 1), opacity=1.0):
        actor = vtkActor()
        actor.SetMapper(mapper)
        actor.GetProperty().SetColor(*colour)
        actor.GetProperty().SetOpacity(opacity)
        actor.GetProperty().SetAmbient(0.22)
        actor.GetProperty().SetDiffuse(0.85)
        self.renderer.AddActor(actor)
        self.actors.append(actor)
        return actor

    def add_fluid(self, grid):
        if grid.GetNumberOfPoints() == 0:
            return
        ball = vtkSphereSource()
        ball.SetRadius(1.12)  # a little over the particle's radius, so that neighbours close into a surface
        detail = 12 if grid.GetNumberOfPoints() < 50000 else 8
        ball.SetThetaResolution(detail)
        ball.SetPhiResolution(detail)
        mapper = vtkGlyph3DMapper()
        mapper.SetInputData(grid)
        mapper.SetSourceConnection(ball.GetOutputPort())
        mapper.SetScaleArray("radius")
        mapper.SetScaleModeToScaleByMagnitude()
        mapper.ScalarVisibilityOff()
        mapper.OrientOff()
        self.water = self.add(mapper, WATER)
        self.water.GetProperty().SetSpecular(0.35)
        self.water.GetProperty().SetSpecularPower(25)

    def add_surface(self, grid):
        if grid.GetNumberOfPoints() == 0:
            return
        surface = vtkDataSetSurfaceFilter()
        surface.SetInputData(grid)
        mapper = vtkPolyDataMapper()
        mapper.SetInputConnection(surface.GetOutputPort())
        mapper.ScalarVisibilityOff()
        self.water = self.add(mapper, WATER)
        self.water.GetProperty().SetSpecular(0.7)
        self.water.GetProperty().SetSpecularPower(60)

    def add_cloth(self, grid):
        surface = vtkDataSetSurfaceFilter()
        surface.SetInputData(grid)
        normals = vtkPolyDataNormals()
        normals.SetInputConnection(surface.GetOutputPort())
        normals.SplittingOff()
        mapper = vtkPolyDataMapper()
        mapper.SetInputConnection(normals.GetOutputPort())
        mapper.SetScalarModeToUsePointFieldData()
        mapper.SelectColorArray("saturation")
        mapper.SetLookupTable(self.colours)
        mapper.UseLookupTableScalarRangeOn()
        mapper.InterpolateScalarsBeforeMappingOff()
        self.add(mapper).GetProperty().SetSpecular(0.05)

    def add_bodies(self, grid):
        for field, value in (("container", 1), ("plane", 1), ("", 0)):
            surface = self.surface_of(grid, field, value)
            if surface.GetOutput().GetNumberOfCells() == 0:
                continue
            mapper = vtkPolyDataMapper()
            mapper.ScalarVisibilityOff()
            if field == "container":
                edges = vtkFeatureEdges()
                edges.SetInputConnection(surface.GetOutputPort())
                edges.SetFeatureAngle(20)
                edges.ColoringOff()
                mapper.SetInputConnection(edges.GetOutputPort())
                self.add(mapper, (0.45, 0.45, 0.48)).GetProperty().SetLineWidth(1.5)
                continue
            normals = vtkPolyDataNormals()
            normals.SetInputConnection(surface.GetOutputPort())
            normals.SetFeatureAngle(40)
            mapper.SetInputConnection(normals.GetOutputPort())
            actor = self.add(mapper, (0.62, 0.63, 0.66), 0.45)
            if field == "plane":  # a floor does not hide what a camera under it looks at
                actor.GetProperty().BackfaceCullingOn()

    @staticmethod
    def surface_of(grid, field, value):
        """Surface of the cells whose `field` is `value`; without a field, of those that are neither of the others."""
        surface = vtkDataSetSurfaceFilter()
        source = grid
        for name in [field] if field else ["container", "plane"]:
            part = vtkThreshold()
            part.SetInputData(source)
            part.SetInputArrayToProcess(0, 0, 0, vtkDataObject.FIELD_ASSOCIATION_CELLS, name)
            part.SetLowerThreshold(value - 0.5)
            part.SetUpperThreshold(value + 0.5)
            part.SetThresholdFunction(vtkThreshold.THRESHOLD_BETWEEN)
            part.Update()
            source = part.GetOutput()
        surface.SetInputData(source)
        surface.Update()
        return surface

    def grab(self):
        self.renderer.ResetCameraClippingRange()
        self.window.Render()
        image = vtkWindowToImageFilter()
        image.SetInput(self.window)
        image.SetInputBufferTypeToRGB()
        image.ReadFrontBufferOff()
        image.Update()
        return image.GetOutput()

    def water_opacity(self):
        """How much of each pixel is water: what is seen along its surface mirrors, what is seen at right angles is clear."""
        floor = 0.2  # grey of water seen along its surface; what is no water is black
        shown = [(actor, actor.GetMapper().GetScalarVisibility(), actor.GetProperty()) for actor in self.actors]
        flat = vtkProperty()
        flat.SetColor(0, 0, 0)
        for actor, _, __ in shown:
            actor.SetProperty(flat)
            actor.GetMapper().ScalarVisibilityOff()
        for text in self.texts:
            text.VisibilityOff()
        white = vtkProperty()
        white.SetAmbient(floor)
        white.SetDiffuse(1 - floor)
        self.water.SetProperty(white)
        lights = self.renderer.GetLights()
        lights.InitTraversal()
        strengths = []
        for _ in range(lights.GetNumberOfItems()):
            light = lights.GetNextItem()
            strengths.append((light, light.GetIntensity()))
            light.SetIntensity(0)
        eye = vtkLight()
        eye.SetLightTypeToHeadlight()
        self.renderer.AddLight(eye)
        background = self.renderer.GetBackground()
        self.renderer.SetBackground(0, 0, 0)
        grey = vtkImageExtractComponents()
        grey.SetInputData(self.grab())
        grey.SetComponents(0)
        self.renderer.SetBackground(*background)
        self.renderer.RemoveLight(eye)
        for text in self.texts:
            text.VisibilityOn()
        for light, strength in strengths:
            light.SetIntensity(strength)
        for actor, scalars, own in shown:
            actor.SetProperty(own)
            actor.GetMapper().SetScalarVisibility(scalars)
        table = vtkLookupTable()
        table.SetNumberOfTableValues(256)
        table.SetRange(0, 255)
        for i in range(256):
            slope = (i / 255 - floor) / (1 - floor)  # cosine of the angle between the view and the surface's normal
            clear, mirror = WATER_OPACITY
            opacity = clear + (mirror - clear) * (1 - slope)**3 if slope >= 0 else mirror * i / 255 / floor
            table.SetTableValue(i, opacity, opacity, opacity, 1)
        mask = vtkImageMapToColors()
        mask.SetInputConnection(grey.GetOutputPort())
        mask.SetLookupTable(table)
        mask.SetOutputFormatToLuminance()
        mask.Update()
        return mask.GetOutput()

    def image(self):
        """Water is mixed in as one layer: behind its surface one sees the cloth, not its other surfaces."""
        wet = self.grab()
        if self.water is None:
            return wet
        opacity = self.water_opacity()
        self.water.VisibilityOff()
        dry = self.grab()
        self.water.VisibilityOn()
        layer = vtkImageAppendComponents()
        layer.AddInputData(wet)
        layer.AddInputData(opacity)
        mix = vtkImageBlend()
        mix.AddInputData(dry)
        mix.AddInputConnection(layer.GetOutputPort())
        mix.Update()
        return mix.GetOutput()

    @staticmethod
    def save(image, path):
        writer = vtkPNGWriter()
        writer.SetFileName(path)
        writer.SetInputData(image)
        writer.Write()
        if not os.path.exists(path):
            fail("%s: cannot be written" % path)


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
        picture.save(picture.image(), pictures[-1])
    print("%d pictures in %s" % (len(times), pngdir))
    if options.animation:
        interval = (times[-1] - times[0]) / max(1, len(times) - 1)
        write_animation(options.animation, pictures, options.fps or min(50.0, 1 / interval if interval > 0 else 1.0))
        print("animation: %s" % options.animation)


main()
