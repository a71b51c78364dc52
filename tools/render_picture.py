"""One picture of tools/render: the window, its lights and what is drawn in it."""

import json
import os

import vtkmodules.vtkRenderingFreeType  # noqa: F401  (registers the text renderer)
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  (registers the OpenGL renderer)
from vtkmodules.vtkCommonCore import vtkLookupTable
from vtkmodules.vtkCommonDataModel import vtkDataObject
from vtkmodules.vtkFiltersCore import vtkFeatureEdges, vtkPolyDataNormals, vtkThreshold
from vtkmodules.vtkFiltersGeometry import vtkDataSetSurfaceFilter
from vtkmodules.vtkFiltersSources import vtkSphereSource
from vtkmodules.vtkImagingCore import vtkImageAppendComponents, vtkImageBlend, vtkImageExtractComponents, vtkImageMapToColors
from vtkmodules.vtkRenderingAnnotation import vtkScalarBarActor
from vtkmodules.vtkRenderingCore import (vtkActor, vtkColorTransferFunction, vtkGlyph3DMapper, vtkLight,
                                         vtkPolyDataMapper, vtkProperty, vtkRenderer, vtkRenderWindow, vtkTextActor,
                                         vtkWindowToImageFilter)

WATER = (0.13, 0.45, 0.80)
PRESET = os.path.join(os.path.dirname(os.path.abspath(__file__)), "saturation.json")  # ParaView reads it too
INK = (0.15, 0.15, 0.18)
WATER_OPACITY = 0.72, 0.97  # of water seen at right angles, and along its surface


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
            cosine = (i / 255 - floor) / (1 - floor)  # of the angle between the view and the surface's normal
            clear, mirror = WATER_OPACITY
            opacity = clear + (mirror - clear) * (1 - cosine)**3 if cosine >= 0 else mirror * i / 255 / floor
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
