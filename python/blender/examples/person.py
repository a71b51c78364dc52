"""A mannequin with an armature, and the shirt of docs/tutorial/make_shirt.py. z is up, and the hem is at z = 0."""

import math
import subprocess
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np

import stage

MAKE_SHIRT = Path(__file__).resolve().parents[3] / "docs/tutorial/make_shirt.py"
ROWS = 20  # of squares of the shirt
# The mannequin's cross-sections are ellipses: height, half the width, half the depth, in m. The first eleven are those
# of the form in make_shirt.py, on which its shirt fits.
RINGS = ((-0.08, 0.150, 0.070), (0.00, 0.170, 0.085), (0.12, 0.165, 0.080), (0.24, 0.160, 0.076), (0.34, 0.175, 0.080),
         (0.42, 0.175, 0.072), (0.48, 0.165, 0.058), (0.52, 0.148, 0.047), (0.55, 0.115, 0.042), (0.57, 0.075, 0.041),
         (0.60, 0.052, 0.042), (0.65, 0.048, 0.046), (0.68, 0.058, 0.062), (0.72, 0.072, 0.080), (0.77, 0.078, 0.088),
         (0.82, 0.072, 0.082), (0.86, 0.052, 0.060), (0.88, 0.022, 0.026))
AROUND = 32  # points of a cross-section
BONES = ((0, 0, -0.08), (0, 0, 0.14), (0, 0, 0.36), (0, 0, 0.66))
LEAN, TURN = 7, 6  # degrees per bone


def _skin():
    turns = np.arange(AROUND) * 2 * math.pi / AROUND
    points = [(w * math.cos(t), d * math.sin(t), z) for z, w, d in RINGS for t in turns]
    faces = [(row + k, row + (k + 1) % AROUND, row + AROUND + (k + 1) % AROUND, row + AROUND + k)
             for row in range(0, (len(RINGS) - 1) * AROUND, AROUND) for k in range(AROUND)]
    faces += [tuple(reversed(range(AROUND))), tuple(range(len(points) - AROUND, len(points)))]
    return stage.mesh_object("Mannequin", points, faces, smooth=True)


def body(scene):
    """The mannequin, bent by the upper two of three bones over the frames of the scene."""
    thing = _skin()
    rig = stage.add("Rig", bpy.data.armatures.new("Rig"))
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    parent = None
    for k in range(3):
        bone = rig.data.edit_bones.new(f"Spine {k}")
        bone.head, bone.tail, bone.parent = BONES[k], BONES[k + 1], parent
        parent = bone
    bpy.ops.object.mode_set(mode="OBJECT")
    heights = np.array([v.co.z for v in thing.data.vertices])
    middles = np.array([(BONES[k][2] + BONES[k + 1][2]) / 2 for k in range(3)])
    for k in range(3):  # linear blend between the middles of the bones
        weighted = thing.vertex_groups.new(name=f"Spine {k}")
        for vertex, weight in enumerate(np.interp(heights, middles, np.eye(3)[k])):
            if weight > 0:
                weighted.add([vertex], float(weight), "REPLACE")
    thing.modifiers.new("Armature", "ARMATURE").object = rig
    rig.hide_render = True
    span = scene.frame_end - scene.frame_start
    for bone in list(rig.pose.bones)[1:]:
        bone.rotation_mode = "XYZ"
        for part, lean in ((0.0, 0), (0.2, 0), (0.6, 1), (1.0, -0.6)):
            bone.rotation_euler = (0, math.radians(TURN * lean), math.radians(LEAN * lean))
            bone.keyframe_insert("rotation_euler", frame=scene.frame_start + round(part * span))
    return thing


def shirt():
    """A sleeveless shirt, 2 cm above the shoulders, with modifiers that refine the simulated cloth."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([sys.executable, MAKE_SHIRT, folder, str(ROWS)], check=True, stdout=subprocess.DEVNULL)
        lines = [line.split() for line in (Path(folder) / "shirt.obj").read_text(encoding="utf-8").splitlines()]
    points = [(float(x), -float(z), float(y) + 0.02) for kind, x, y, z in lines if kind == "v"]  # from y up to z up
    faces = [(int(a) - 1, int(b) - 1, int(c) - 1) for kind, a, b, c in lines if kind == "f"]
    thing = stage.mesh_object("Shirt", points, faces, smooth=True)
    smooth = thing.modifiers.new("Subdivision", "SUBSURF")
    smooth.levels = smooth.render_levels = 1
    hem = thing.modifiers.new("Solidify", "SOLIDIFY")
    hem.thickness, hem.offset = 0.006, 1.0  # outwards, so that the coarse cloth covers the curved skin
    return thing
