"""Camera, light and backdrop that the example scenes share."""

import math

import bpy
from mathutils import Vector


def new_scene(frames, fps=24):
    """An empty file with a scene of that many frames."""
    bpy.ops.wm.read_homefile(use_empty=True)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end, scene.render.fps = 1, frames, fps
    scene.frame_set(1)
    return scene


def add(name, data, location=(0, 0, 0)):
    thing = bpy.data.objects.new(name, data)
    thing.location = location
    bpy.context.scene.collection.objects.link(thing)
    return thing


def mesh_object(name, points, faces, location=(0, 0, 0), smooth=False):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([tuple(p) for p in points], [], [tuple(f) for f in faces])
    if smooth:
        mesh.shade_smooth()
    return add(name, mesh, location)


def box(name, low, high):
    """A closed box with its origin in its middle. m."""
    middle = (Vector(low) + Vector(high)) / 2
    half = (Vector(high) - Vector(low)) / 2
    corners = [(x * half.x, y * half.y, z * half.z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return mesh_object(name, corners, faces, middle)


def grid(name, size, cells, location=(0, 0, 0)):
    """A horizontal rectangle of cells[0] by cells[1] squares, with texture coordinates. m."""
    points = [((i / cells[0] - 0.5) * size[0], (j / cells[1] - 0.5) * size[1], 0)
              for j in range(cells[1] + 1) for i in range(cells[0] + 1)]
    row = cells[0] + 1
    faces = []
    for j in range(cells[1]):
        for i in range(cells[0]):
            a = i + j * row
            b, c, d = a + 1, a + row + 1, a + row
            faces += [(a, b, c), (a, c, d)] if (i + j) % 2 else [(a, b, d), (b, c, d)]
    thing = mesh_object(name, points, faces, location, smooth=True)
    layer = thing.data.uv_layers.new(name="UVMap")
    for loop in thing.data.loops:
        x, y, _ = points[loop.vertex_index]
        layer.data[loop.index].uv = (x / size[0] + 0.5, y / size[1] + 0.5)
    return thing


def group(thing, name, vertices):
    thing.vertex_groups.new(name=name).add(list(vertices), 1.0, "REPLACE")


def color(thing, rgb, roughness=0.6):
    material = bpy.data.materials.new(thing.name)
    if material.node_tree is None:
        material.use_nodes = True
    shader = material.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*rgb, 1)
    shader.inputs["Roughness"].default_value = roughness
    thing.data.materials.append(material)


def aim(thing, target):
    thing.rotation_euler = (Vector(target) - thing.location).to_track_quat("-Z", "Y").to_euler()


def studio(scene, target, distance, height, angle, floor):
    """Camera at `distance` (m) from the target, `height` above it, at `angle` (degrees); light; floor at `floor`."""
    turn = math.radians(angle)
    lens = bpy.data.cameras.new("Camera")
    lens.angle = math.radians(32)
    place = Vector(target) + Vector((distance * math.sin(turn), -distance * math.cos(turn), height))
    scene.camera = add("Camera", lens, place)
    aim(scene.camera, target)
    key = bpy.data.lights.new("Key", "AREA")
    key.size, key.energy = distance, 25 * distance**2
    lamp = add("Key", key, Vector(target) + distance * Vector((-1.2, -0.8, 1.8)))
    aim(lamp, target)
    ground = grid("Floor", (60 * distance, 60 * distance), (1, 1), (target[0], target[1], floor))
    color(ground, (0.42, 0.43, 0.46), 0.7)
    world = scene.world = bpy.data.worlds.new("World")
    if world.node_tree is None:
        world.use_nodes = True
    sky = world.node_tree.nodes["Background"].inputs
    sky[0].default_value, sky[1].default_value = (0.8, 0.87, 1, 1), 0.45


def set_render(scene, size=(480, 360), samples=24):
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.device = samples, True, "CPU"
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.view_settings.look = "AgX - Medium High Contrast"
    scene.render.threads_mode, scene.render.threads = "FIXED", 2


def wet_look(thing, rgb):
    color(thing, rgb, 0.9)
    with bpy.context.temp_override(object=thing):
        bpy.ops.drench.wet_look()
