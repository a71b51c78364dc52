"""export_blender_reader.py FILE CODE...: what Blender's own import finds in a USD file at these frames, as JSON in the file's
axes; for export_test.py. Needs Python's bpy."""

import json
import sys

import bpy


def values(data, name):
    attribute = data.attributes.get(name)
    if attribute is None:
        return []
    kind = {"FLOAT_VECTOR": "vector", "FLOAT_COLOR": "color"}.get(attribute.data_type, "value")
    return [list(v)[:3] if hasattr(v, "__len__") else v for v in (getattr(item, kind) for item in attribute.data)]


def read_object(thing):
    """Blender's z is up: (x, y, z) of the file is (x, −z, y) there."""
    data, to_world = thing.data, thing.matrix_world
    places = [to_world @ (item.co) for item in (data.vertices if thing.type == "MESH" else data.points)]
    found = {"points": [[p[0], p[2], -p[1]] for p in places]}
    for name in ("saturation", "roughness", "displayColor", "velocity", "radius"):
        found[name] = values(data, name)
    if thing.type == "MESH":
        found["triangles"] = len(data.polygons)
    return found


def main():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.usd_import(filepath=sys.argv[1], import_proxy=True, import_guide=True, import_render=True)
    frames = []
    for code in map(int, sys.argv[2:]):
        bpy.context.scene.frame_set(code)
        graph = bpy.context.evaluated_depsgraph_get()
        things = [thing.evaluated_get(graph) for thing in bpy.data.objects if thing.type in ("MESH", "POINTCLOUD")]
        frames.append({thing.name: read_object(thing) for thing in things})
    links = {material.name: sorted(f"{link.from_node.attribute_name} -> {link.to_socket.name}"
                                   for link in material.node_tree.links if link.from_node.type == "ATTRIBUTE")
             for material in bpy.data.materials}
    print("JSON" + json.dumps({"frames": frames, "links": links}))


main()
