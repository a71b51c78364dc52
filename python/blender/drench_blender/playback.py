"""Shows the frames of a bake: cloth on the user's objects, liquid as objects of their own.

The frame of a cloth goes to a hidden mesh of vertices; a geometry nodes modifier of the user's object takes positions
and saturation from it. The user's mesh is never changed, and modifiers below ours apply to the simulated cloth."""

from pathlib import Path

import bpy
import numpy as np
from bpy.app.handlers import persistent

from . import materials, nodes
from .cache import Cache
from .frames import read_frame
from .meshes import MODIFIER, modifier_index
from .problem import Problem

REFINING = ("SUBSURF", "SOLIDIFY", "MULTIRES", "BEVEL", "WEIGHTED_NORMAL")  # modifiers that belong below ours
_caches, _maps = {}, {}
paused = False  # during an export, which goes through all frames


def cache_of(scene):
    """The cache of a scene. Problem: its folder is relative to a file that has not been saved."""
    folder = scene.drench.cache or f"//drench_cache/{Path(bpy.data.filepath).stem}_{bpy.path.clean_name(scene.name)}"
    if folder.startswith("//") and not bpy.data.filepath:
        raise Problem("the cache folder is relative to the .blend file, which has not been saved: save the file, or "
                      "choose an absolute folder")
    path = Path(bpy.path.abspath(folder)).resolve()
    return _caches.setdefault(path, Cache(path))


# Objects.

def follow_role(thing):
    """Gives a cloth its modifier, and takes it from an object that is no cloth any more."""
    if thing.drench.role == "CLOTH" and thing.type == "MESH":
        ensure_modifier(thing)
        return
    if (modifier := thing.modifiers.get(MODIFIER)) is not None and modifier.type == "NODES":
        thing.modifiers.remove(modifier)
    thing.drench.cloth_index = -1
    if thing.drench.shown is not None:
        if not _shares(thing):
            bpy.data.meshes.remove(thing.drench.shown.data)  # removes the object too
        thing.drench.shown = None


def _shares(thing):
    """Is there another object with the same simulated cloth, because one is a copy of the other?"""
    return any(other != thing and other.drench.shown == thing.drench.shown for other in bpy.data.objects)


def ensure_modifier(thing):
    """The modifier that shows the simulated cloth; above modifiers at the end that only refine a surface.

    A copy of a cloth gets a simulated cloth of its own."""
    place = modifier_index(thing)
    if thing.drench.shown is None or _shares(thing):
        name = f"Drench {thing.name}"
        thing.drench.shown = bpy.data.objects.new(name, bpy.data.meshes.new(name))
    elif place < len(thing.modifiers):
        return
    if place == len(thing.modifiers):
        while place > 0 and thing.modifiers[place - 1].type in REFINING:
            place -= 1
        thing.modifiers.new(MODIFIER, "NODES")
        thing.modifiers.move(len(thing.modifiers) - 1, place)
    thing.modifiers[place].node_group = nodes.cloth_tree(f"Drench {thing.name}", thing.drench.shown)


def _liquid_object(scene, key, name):
    thing = getattr(scene.drench, key)
    if thing is None:
        thing = bpy.data.objects.new(name, bpy.data.meshes.new(name))
        thing.data.materials.append(materials.water())
        setattr(scene.drench, key, thing)
    if thing.name not in scene.collection.all_objects:
        scene.collection.objects.link(thing)
    return thing


def prepare_liquid(scene, record):
    """The objects that show the liquid of a bake."""
    if record.get("fluid"):
        particles = _liquid_object(scene, "particles", "Drench Particles")
        if MODIFIER not in particles.modifiers:
            modifier = particles.modifiers.new(MODIFIER, "NODES")
            modifier.node_group = nodes.sphere_tree("Drench Spheres", materials.water())
        if record.get("surface"):
            _liquid_object(scene, "liquid_surface", "Drench Surface")
    show_liquid(scene)


def show_liquid(scene):
    """Shows the object of the chosen display and hides the other one."""
    own = scene.drench
    as_surface = own.display == "SURFACE" and own.liquid_surface is not None
    for thing, visible in ((own.particles, not as_surface), (own.liquid_surface, as_surface)):
        if thing is not None:
            thing.hide_viewport = thing.hide_render = not visible
    if own.particles is not None and (modifier := own.particles.modifiers.get(MODIFIER)) is not None:
        modifier.show_viewport = modifier.show_render = own.display != "POINTS"
    show(scene)


# Frames.

def _set_vertices(mesh, points, faces=None, **attributes):
    """Replaces the contents of a mesh; arrays that keep their length are overwritten in place."""
    if faces is not None or len(mesh.vertices) != len(points) or len(mesh.polygons):
        mesh.clear_geometry()
        mesh.vertices.add(len(points))
        if faces is not None and len(faces):
            mesh.loops.add(faces.size)
            mesh.polygons.add(len(faces))
            mesh.loops.foreach_set("vertex_index", np.ascontiguousarray(faces, np.int32).ravel())
            mesh.polygons.foreach_set("loop_start", np.arange(0, faces.size, 3, dtype=np.int32))
    mesh.vertices.foreach_set("co", np.ascontiguousarray(points, np.float32).ravel())
    for name, values in attributes.items():
        kind, field = ("FLOAT_VECTOR", "vector") if values.ndim == 2 else ("FLOAT", "value")
        attribute = mesh.attributes.get(name) or mesh.attributes.new(name, kind, "POINT")
        attribute.data.foreach_set(field, np.ascontiguousarray(values, np.float32).ravel())
    mesh.update(calc_edges=faces is not None)


def _node_maps(cache, record):
    """Per cloth: (node of each vertex, -1 for none; vertices that no face uses; their positions in m)."""
    if _maps.get("record") is not record:
        _maps["record"] = record
        _maps["maps"] = [(np.array(cloth["node"], np.int64), np.array(list(cloth["loose"]), np.int64),
                          np.array(list(cloth["loose"].values()), float).reshape(-1, 3)) for cloth in record["cloths"]]
    return _maps["maps"]


def _cloth_arrays(cache, position):
    """Positions (m) and saturation of all nodes, interpolated between two frames. `position` counts frames from 0."""
    frames = cache.frames("cloth")
    if not frames:
        return None
    position = min(max(position, 0), max(frames))
    before, part = int(position), position - int(position)
    first = read_frame(frames[before], {"Points", "saturation"})
    points, wet = first["Points"], first.get("saturation")
    if part > 0 and before + 1 in frames:
        second = read_frame(frames[before + 1], {"Points", "saturation"})
        points = points + part * (second["Points"] - points)
        wet = wet + part * (second["saturation"] - wet) if wet is not None else None
    return points, np.zeros(len(points), np.float32) if wet is None else wet


def _show_cloths(scene, cache, record, position):
    shown = [thing for thing in scene.objects
             if thing.drench.role == "CLOTH" and thing.drench.shown and thing.drench.cloth_index >= 0]
    arrays = _cloth_arrays(cache, position) if shown else None
    if arrays is None:
        return
    points, wet = arrays
    starts = np.cumsum([0] + [cloth["nodes"] for cloth in record["cloths"]])
    if len(points) != starts[-1]:
        raise Problem("the frames of the cloths do not belong to this bake: bake again")
    for thing in shown:
        number = thing.drench.cloth_index
        if number >= len(record["cloths"]):
            continue
        node, loose, places = _node_maps(cache, record)[number]
        rows = starts[number] + np.maximum(node, 0)
        own = points[rows]
        own[loose] = places
        _set_vertices(thing.drench.shown.data, own / record["unit"],
                      saturation=np.where(node >= 0, wet[rows], 0))


def _show_liquid(scene, cache, record, position):
    own, unit = scene.drench, record["unit"]
    particles, surface = own.particles, own.liquid_surface
    pace = record["speed"] / unit  # units of length per second of the film
    if particles is not None and not particles.hide_render and (frames := cache.frames("fluid")):
        arrays = read_frame(frames[_whole(frames, position)], {"Points", "velocity", "radius", "id"})
        _set_vertices(particles.data, arrays["Points"].reshape(-1, 3) / unit,
                      velocity=arrays["velocity"].reshape(-1, 3) * pace, radius=arrays["radius"].reshape(-1) / unit)
    if surface is not None and not surface.hide_render and (frames := cache.frames("surface")):
        arrays = read_frame(frames[_whole(frames, position)], {"Points", "velocity", "connectivity"})
        count = len(arrays["Points"])
        faces = arrays["connectivity"].reshape(-1, 3) if count else np.zeros((0, 3), np.int32)
        _set_vertices(surface.data, arrays["Points"].reshape(-1, 3) / unit, faces,
                      velocity=arrays["velocity"].reshape(-1, 3) * pace)


def _whole(frames, position):
    """The number of particles differs between frames, so they are not interpolated; `velocity` gives motion blur."""
    return int(min(max(position, 0), max(frames)))


def show(scene):
    """Shows the current frame if there is a bake. Returns a message where it cannot be shown, otherwise ""."""
    try:
        cache = cache_of(scene)
        record = cache.record()
        if record is not None:
            position = scene.frame_current + scene.frame_subframe - record["first_frame"]
            _show_cloths(scene, cache, record, position)
            _show_liquid(scene, cache, record, position)
    except Problem as problem:
        return str(problem)
    return ""


def connect(scene, record):
    """Tells the objects of a new bake which of its cloths they are."""
    for thing in scene.objects:
        if thing.drench.role != "CLOTH":
            continue
        names = [cloth["object"] for cloth in record["cloths"]]
        thing.drench.cloth_index = names.index(thing.name) if thing.name in names else -1
        if thing.drench.cloth_index >= 0:
            ensure_modifier(thing)
    prepare_liquid(scene, record)
    scene.render.use_lock_interface = True  # frames must not change while the viewport reads them


def clear(scene):
    """Shows the meshes as they are without a bake."""
    for thing in scene.objects:
        thing.drench.cloth_index = -1
        if thing.drench.shown is not None:
            thing.drench.shown.data.clear_geometry()
    for thing in (scene.drench.particles, scene.drench.liquid_surface):
        if thing is not None:
            thing.data.clear_geometry()
    _maps.clear()


def _report(scene):
    if message := show(scene):
        if "has not been saved" not in message and scene.drench.messages != message:
            scene.drench.messages = message
            print(f"Drench: {message}")


@persistent
def on_frame(scene, _depsgraph=None):
    if not paused:
        _report(scene)


@persistent
def on_load(*_):
    _caches.clear()
    _maps.clear()
    for scene in bpy.data.scenes:
        _report(scene)


HANDLERS = (("frame_change_pre", on_frame), ("load_post", on_load), ("undo_post", on_load), ("redo_post", on_load))


def register():
    for name, handler in HANDLERS:
        handlers = getattr(bpy.app.handlers, name)
        if handler not in handlers:
            handlers.append(handler)


def unregister():
    for name, handler in HANDLERS:
        handlers = getattr(bpy.app.handlers, name)
        if handler in handlers:
            handlers.remove(handler)
