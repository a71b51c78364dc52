"""Geometry nodes: the simulated cloth on the user's mesh, and particles as spheres."""

import bpy


class Tree:
    """A geometry node tree from and to a geometry."""

    def __init__(self, name):
        self.tree = bpy.data.node_groups.new(name, "GeometryNodeTree")
        self.tree.is_modifier = True
        for direction in ("INPUT", "OUTPUT"):
            self.tree.interface.new_socket("Geometry", in_out=direction, socket_type="NodeSocketGeometry")
        self.column = 0
        self.input = self.node("NodeGroupInput").outputs[0]

    def node(self, kind, inputs=(), **settings):
        """A node with settings, and `inputs` {socket name or number: socket or value}."""
        node = self.tree.nodes.new(kind)
        node.location = self.column, 0
        self.column += 190
        for name, value in settings.items():
            setattr(node, name, value)
        for key, value in dict(inputs).items():
            socket = active_socket(node.inputs, key)
            if isinstance(value, bpy.types.NodeSocket):
                self.tree.links.new(value, socket)
            else:
                socket.default_value = value
        return node

    def finish(self, geometry):
        self.node("NodeGroupOutput", {0: geometry})
        return self.tree


def active_socket(sockets, key):
    """By number among all, or by name among those that the settings of the node leave active."""
    if isinstance(key, int):
        return sockets[key]
    return next(s for s in sockets if s.name == key and s.enabled)


def cloth_tree(name, shown):
    """Moves each vertex to that of the object `shown` with the same number and takes over its saturation.

    A mesh with another number of vertices stays as it is."""
    t = Tree(name)
    result = t.node("GeometryNodeObjectInfo", {"Object": shown}, transform_space="RELATIVE").outputs["Geometry"]
    counts = [t.node("GeometryNodeAttributeDomainSize", {"Geometry": g}, component="MESH").outputs["Point Count"]
              for g in (t.input, result)]
    same = t.node("FunctionNodeCompare", {"A": counts[0], "B": counts[1]}, data_type="INT", operation="EQUAL")
    index = t.node("GeometryNodeInputIndex").outputs[0]

    def sampled(kind, value):
        node = t.node("GeometryNodeSampleIndex", data_type=kind, domain="POINT")
        t.tree.links.new(result, node.inputs["Geometry"])
        t.tree.links.new(value, active_socket(node.inputs, "Value"))
        t.tree.links.new(index, node.inputs["Index"])
        return next(socket for socket in node.outputs if socket.enabled)

    place = sampled("FLOAT_VECTOR", t.node("GeometryNodeInputPosition").outputs[0])
    moved = t.node("GeometryNodeSetPosition", {"Geometry": t.input, "Position": place}).outputs[0]
    attribute = t.node("GeometryNodeInputNamedAttribute", {"Name": "saturation"}, data_type="FLOAT")
    value = sampled("FLOAT", next(socket for socket in attribute.outputs if socket.enabled))
    wet = t.node("GeometryNodeStoreNamedAttribute", {"Geometry": moved, "Name": "saturation", "Value": value},
                 data_type="FLOAT", domain="POINT").outputs[0]
    choice = t.node("GeometryNodeSwitch", {"Switch": same.outputs[0], "False": t.input, "True": wet},
                    input_type="GEOMETRY")
    return t.finish(next(socket for socket in choice.outputs if socket.enabled))


def sphere_tree(name, material):
    """A sphere per vertex, with the radius that the attribute `radius` gives."""
    t = Tree(name)
    points = t.node("GeometryNodeMeshToPoints", {"Mesh": t.input}, mode="VERTICES").outputs[0]
    ball = t.node("GeometryNodeMeshIcoSphere", {"Radius": 1.0, "Subdivisions": 2}).outputs[0]
    smooth = t.node("GeometryNodeSetShadeSmooth", {0: ball}).outputs[0]
    colored = t.node("GeometryNodeSetMaterial", {"Geometry": smooth, "Material": material}).outputs[0]
    radius = t.node("GeometryNodeInputNamedAttribute", {"Name": "radius"}, data_type="FLOAT")
    size = next(socket for socket in radius.outputs if socket.enabled)
    return t.finish(t.node("GeometryNodeInstanceOnPoints",
                           {"Points": points, "Instance": colored, "Scale": size}).outputs[0])
