#!/usr/bin/env python3
"""make_scenes.py [FOLDER]: write napkin.blend, towel.blend and shirt.blend, examples for the Blender extension.

Needs Blender as a Python module, or `blender --background --python make_scenes.py -- FOLDER`, with the extension
enabled. Bake and render with `blender --background FILE.blend --python-expr "import bpy; bpy.ops.drench.bake()"`."""

import math
import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parent))
import person  # noqa: E402
import stage  # noqa: E402


def napkin():
    """A glass of water is knocked over onto a napkin."""
    scene = stage.new_scene(30)
    table = stage.box("Table", (-0.3, -0.2, -0.04), (0.3, 0.2, 0))
    stage.color(table, (0.20, 0.09, 0.045), 0.35)
    table.drench.role, table.drench.collider_shape = "COLLIDER", "MESH"

    cloth = stage.grid("Napkin", (0.24, 0.24), (24, 24), (0.06, 0, 0.004))
    own = cloth.drench
    own.role, own.fabric, own.self_collision = "CLOTH", "cotton_terry", False
    own.friction = 0.5
    stage.wet_look(cloth, (0.75, 0.16, 0.12))

    bpy.ops.mesh.primitive_cylinder_add(vertices=32, radius=0.024, depth=0.075, location=(-0.125, 0, 0.032),
                                        rotation=(0, math.radians(90), 0))
    spill = bpy.context.object
    spill.name = "Spill"
    spill.hide_render, spill.display_type = True, "WIRE"
    spill.drench.role, spill.drench.liquid_shape = "LIQUID", "MESH"
    spill.drench.liquid_velocity = (0.8, 0, -0.1)

    settings = scene.drench
    settings.spacing, settings.substeps = 0.006, 10
    stage.studio(scene, (0.0, 0.0, 0.0), 0.75, 0.5, -25, -0.4)
    return scene


def bath():
    """The mesh of a tub with walls of 6 cm, open at the top. m."""
    outer, inner, bottom, rim, floor = (0.31, 0.26), (0.25, 0.20), -0.06, 0.20, 0.0
    corners = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    levels = ((outer, bottom), (outer, rim), (inner, rim), (inner, floor))
    points = [(x * size[0], y * size[1], z) for size, z in levels for x, y in corners]
    faces = [(3, 2, 1, 0), (12, 13, 14, 15)]
    for level in range(3):
        for k in range(4):
            a, b = 4 * level + k, 4 * level + (k + 1) % 4
            faces.append((a, b, b + 4, a + 4))
    return stage.mesh_object("Bath", points, faces)


def towel():
    """A towel is pulled out of a bath by one edge."""
    scene = stage.new_scene(36)
    tub = bath()
    stage.color(tub, (0.85, 0.85, 0.83), 0.25)
    tub.drench.role = "COLLIDER"

    water = stage.box("Water", (-0.25, -0.20, 0.0), (0.25, 0.20, 0.12))
    water.hide_render, water.display_type = True, "WIRE"
    water.drench.role = "LIQUID"

    cloth = stage.grid("Towel", (0.40, 0.26), (26, 17), (0, 0, 0.06))
    own = cloth.drench
    own.role, own.fabric, own.saturation, own.self_collision = "CLOTH", "cotton_terry", 0.9, True
    edge = [v.index for v in cloth.data.vertices if v.co.x < -0.199]
    stage.group(cloth, "Hand", edge)
    own.pin_group = "Hand"
    stage.wet_look(cloth, (0.25, 0.45, 0.75))
    cloth.keyframe_insert("location", frame=1)
    cloth.location = (0.16, 0, 0.56)
    cloth.keyframe_insert("location", frame=30)

    settings = scene.drench
    settings.spacing, settings.substeps = 0.02, 10
    stage.studio(scene, (0.0, 0.0, 0.27), 1.6, 0.7, -28, -0.06)
    return scene


def shirt():
    """A mannequin in a shirt leans from side to side in the rain."""
    scene = stage.new_scene(36)
    body = person.body(scene)
    stage.color(body, (0.50, 0.36, 0.27), 0.5)
    body.drench.role = "COLLIDER"

    cloth = person.shirt()
    own = cloth.drench
    own.role, own.fabric, own.friction, own.self_collision = "CLOTH", "cotton_interlock", 0.6, False
    stage.wet_look(cloth, (0.42, 0.55, 0.72))

    places = ((-0.15, 0.02), (-0.09, -0.05), (-0.03, 0.05), (0.03, -0.07), (0.08, 0.03), (0.13, -0.03))
    for k, (x, y) in enumerate(places):
        nozzle = stage.add(f"Rain {k}", None, (x, y, 0.98))
        nozzle.empty_display_size = 0.03
        own = nozzle.drench
        own.role, own.emitter_radius = "EMITTER", 0.011
        for frame in range(scene.frame_start, scene.frame_end + 1):  # drops: open for two frames, closed for two
            own.emitter_speed = 1.5 if (frame + 2 * k) % 4 < 2 else 0
            nozzle.keyframe_insert("drench.emitter_speed", frame=frame)
    settings = scene.drench
    settings.spacing, settings.substeps, settings.adaptive = 0.016, 10, False
    stage.studio(scene, (0.0, 0.0, 0.42), 2.25, 0.35, -20, -0.3)
    return scene


SCENES = {"napkin": napkin, "towel": towel, "shirt": shirt}


def make(name, folder):
    """Builds a scene and saves it. Returns the path of the file."""
    scene = SCENES[name]()
    stage.set_render(scene)
    path = folder / f"{name}.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path.resolve()))
    return path


def main():
    words = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else sys.argv[1:]
    folder = Path(words[0] if words else ".")
    folder.mkdir(parents=True, exist_ok=True)
    if not hasattr(bpy.types.Scene, "drench"):
        sys.exit("make_scenes.py: the extension Drench is not enabled: install it (docs/manual/blender.md)")
    for name in SCENES:
        print(make(name, folder))


if __name__ == "__main__":
    main()
