"""render_cycles.py FILE.usdc PNGDIR RATE: pictures of an exported run by Blender's Cycles. `tools/render OUT --cycles` starts it;
`tools/setup blender` makes the Python that it needs. Water is glass, cloth looks as its saturation says, on a grey floor."""

import argparse
import math
import os
import sys

import bpy
from mathutils import Vector

from picture_options import NAMED_VIEWS, OptionError, camera, picture_size

DRY = ("liquid", "surface")  # what is not cloth or body
BACKDROPS = {"light": dict(floor=(0.55, 0.55, 0.57), sky=0.55, key=90, look="None"),
             "dark": dict(floor=(0.10, 0.11, 0.13), sky=0.5, key=60, look="AgX - High Contrast")}
SKY = (0.85, 0.9, 1)


def fail(message):
    print(f"tools/render: {message}", file=sys.stderr)
    sys.exit(2)


def parse_arguments():
    parser = argparse.ArgumentParser(prog="tools/render --cycles", description=__doc__)
    parser.add_argument("file")
    parser.add_argument("pngdir")
    parser.add_argument("rate", type=float, help="frames per second of the file")
    parser.add_argument("--frames", type=int, metavar="N", help="only N frames, evenly spaced (default: all)")
    parser.add_argument("--size", default="900x600", metavar="WxH")
    parser.add_argument("--samples", type=int, default=64, help="paths per pixel (default: 64)")
    parser.add_argument("--camera", default="auto",
                        help="auto, below, front, top, or px,py,pz,fx,fy,fz: position and focal point in m, in the file's axes")
    parser.add_argument("--backdrop", choices=BACKDROPS, default="light",
                        help="light: a floor under a sky; dark: without a horizon, for drops and films")
    parser.add_argument("--fps", type=float, help="pictures per second of the video (default: real time)")
    options = parser.parse_args()
    for name, read in (("size", picture_size), ("camera", camera)):
        try:
            setattr(options, name, read(getattr(options, name)))
        except OptionError as wrong:
            fail(f"--{name}: {wrong}")
    if options.samples < 1 or (options.frames is not None and options.frames < 1):
        fail("--samples and --frames must be at least 1")
    if options.fps is not None and not 0.1 <= options.fps <= 100:
        fail(f"--fps: {options.fps:g} is not a rate; allowed: 0.1 to 100 pictures per second")
    return options


def load(file):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.usd_import(filepath=file, import_render=True, import_proxy=False, import_guide=False)
    return bpy.context.scene


def make_material(name, **inputs):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    set_inputs(material, **inputs)
    return material


def set_inputs(material, **inputs):
    shader = material.node_tree.nodes["Principled BSDF"]
    for name, value in inputs.items():
        shader.inputs[name.replace("_", " ")].default_value = value


def make_water_glass():
    for material in bpy.data.materials:
        if material.name.startswith(DRY) and material.node_tree:
            set_inputs(material, Transmission_Weight=0.95, Alpha=1, IOR=1.33, Roughness=0.02, Base_Color=(0.75, 0.9, 1, 1))


def bounds(scene, frames):
    """The box around all that does not flow, over some frames; around the water where there is nothing else."""
    points = {True: [], False: []}
    for frame in frames[:: max(1, len(frames) // 4)]:
        scene.frame_set(frame)
        graph = bpy.context.evaluated_depsgraph_get()
        for thing in bpy.data.objects:
            if thing.type in ("MESH", "POINTCLOUD"):
                seen = thing.evaluated_get(graph)
                items = seen.data.vertices if thing.type == "MESH" else seen.data.points
                points[thing.name.startswith(DRY)] += [seen.matrix_world @ item.co for item in items]
    found = points[False] or points[True]
    if not found:
        fail("there is nothing to draw in these frames")
    low, high = (Vector([f(p[axis] for p in found) for axis in range(3)]) for f in (min, max))
    return low, high


def add(scene, data, name, location, target):
    thing = bpy.data.objects.new(name, data)
    thing.location = location
    thing.rotation_euler = (target - location).to_track_quat("-Z", "Y").to_euler()
    scene.collection.objects.link(thing)
    return thing


def to_blender(point):
    """The import turns the file's root, World, so that up is Blender's z."""
    return bpy.data.objects["World"].matrix_world @ point


def view(camera, box, half_angle):
    """Where the camera stands, and where it looks."""
    if isinstance(camera, tuple):
        return [to_blender(Vector(point)) for point in (camera[:3], camera[3:])]
    low, high = box
    azimuth, elevation = (math.radians(a) for a in NAMED_VIEWS[camera])
    way = Vector((math.sin(azimuth) * math.cos(elevation), -math.cos(azimuth) * math.cos(elevation), math.sin(elevation)))
    center = (low + high) / 2
    return center + way * (0.47 * (high - low).length / math.sin(half_angle)), center


def make_floor(low, center, size, backdrop):
    bpy.ops.mesh.primitive_plane_add(size=400 * size, location=(center.x, center.y, low.z - 0.2 * size))
    material = make_material("floor", Base_Color=(*backdrop["floor"], 1), Roughness=0.7)
    bpy.context.object.data.materials.append(material)
    return material


def hide_horizon(scene, floor, backdrop):
    """The floor only scatters, and the camera sees the sky as the far floor looks: lit by the sky alone."""
    floor.node_tree.nodes["Principled BSDF"].inputs["Specular IOR Level"].default_value = 0
    tree = scene.world.node_tree
    new, link = tree.nodes.new, tree.links.new
    seen, mix, path = new("ShaderNodeBackground"), new("ShaderNodeMixShader"), new("ShaderNodeLightPath")
    seen.inputs[0].default_value = (*(a * b for a, b in zip(backdrop["floor"], SKY)), 1)
    seen.inputs[1].default_value = backdrop["sky"]
    link(path.outputs["Is Camera Ray"], mix.inputs[0])
    link(tree.nodes["Background"].outputs[0], mix.inputs[1])
    link(seen.outputs[0], mix.inputs[2])
    link(mix.outputs[0], tree.nodes["World Output"].inputs["Surface"])


def light_and_frame(scene, box, options):
    backdrop = BACKDROPS[options.backdrop]
    low, high = box
    center, size = (low + high) / 2, (high - low).length
    floor = make_floor(low, center, size, backdrop)
    lens = bpy.data.cameras.new("camera")
    lens.angle = math.radians(34)
    lens.clip_end = 1000 * size
    width, height = options.size
    half_angle = math.atan(math.tan(lens.angle / 2) * min(1, height / width))
    scene.camera = add(scene, lens, "camera", *view(options.camera, box, half_angle))
    key = bpy.data.lights.new("key", "AREA")
    key.size, key.energy = size, backdrop["key"] * size**2
    add(scene, key, "key", center + Vector((-1.2, -1.2, 1.8)) * size, center)
    scene.world = bpy.data.worlds.new("sky")
    scene.world.use_nodes = True
    sky = scene.world.node_tree.nodes["Background"].inputs
    sky[0].default_value, sky[1].default_value = (*SKY, 1), backdrop["sky"]
    if options.backdrop == "dark":
        hide_horizon(scene, floor, backdrop)
    scene.view_settings.look = backdrop["look"]


def main():
    options = parse_arguments()
    scene = load(options.file)
    make_water_glass()
    frames = list(range(scene.frame_start, scene.frame_end + 1))
    last, wanted = len(frames) - 1, min(options.frames or len(frames), len(frames))
    chosen = [frames[last]] if wanted == 1 else [frames[round(k * last / (wanted - 1))] for k in range(wanted)]
    width, height = options.size
    light_and_frame(scene, bounds(scene, frames), options)
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising = options.samples, True
    scene.render.resolution_x, scene.render.resolution_y = width, height
    os.makedirs(options.pngdir, exist_ok=True)
    for frame in chosen:
        scene.frame_set(frame)
        scene.render.filepath = os.path.join(os.path.abspath(options.pngdir), f"cycles_{frame:06d}.png")
        bpy.ops.render.render(write_still=True)
        print(scene.render.filepath)
    passed = (chosen[-1] - chosen[0]) / options.rate  # s
    rate = options.fps or (min(50, (len(chosen) - 1) / passed) if passed > 0 else 1)
    print(f"{len(chosen)} pictures, {rate:.6g} per second")


main()
