"""Materials: cloth that looks wet where the attribute `saturation` says so, and water."""

import bpy

GROUP = "Drench Wet Look"
DARK, GLOSSY = 0.3, 1 / 3  # base colour and roughness of saturated cloth, relative to dry cloth


def _scaled(tree, links, factor, name, place):
    """A node that gives 1 for dry and `factor` for saturated cloth."""
    node = tree.nodes.new("ShaderNodeMapRange")
    node.label, node.location = name, place
    node.inputs["From Min"].default_value, node.inputs["From Max"].default_value = 0, 1
    node.inputs["To Min"].default_value, node.inputs["To Max"].default_value = 1, factor
    node.clamp = True
    tree.links.new(links, node.inputs["Value"])
    return node.outputs[0]


def wet_group():
    """The node group that scales a base colour and a roughness by the saturation."""
    tree = bpy.data.node_groups.get(GROUP)
    if tree is not None:
        return tree
    tree = bpy.data.node_groups.new(GROUP, "ShaderNodeTree")
    sockets = (("Base Color", "NodeSocketColor", (0.8, 0.8, 0.8, 1)), ("Roughness", "NodeSocketFloat", 0.9))
    for name, kind, value in sockets:
        for direction in ("INPUT", "OUTPUT"):
            socket = tree.interface.new_socket(name, in_out=direction, socket_type=kind)
            if direction == "INPUT":
                socket.default_value = value
    first, last = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    first.location, last.location = (-600, 200), (400, 0)
    wet = tree.nodes.new("ShaderNodeAttribute")
    wet.attribute_name, wet.location = "saturation", (-600, -100)
    factor = [_scaled(tree, wet.outputs["Fac"], *values)
              for values in ((DARK, "Darkening", (-350, -100)), (GLOSSY, "Gloss", (-350, -400)))]
    color = tree.nodes.new("ShaderNodeVectorMath")
    color.operation, color.location = "SCALE", (0, 100)
    tree.links.new(first.outputs["Base Color"], color.inputs[0])
    tree.links.new(factor[0], color.inputs["Scale"])
    tree.links.new(color.outputs[0], last.inputs["Base Color"])
    rough = tree.nodes.new("ShaderNodeMath")
    rough.operation, rough.location = "MULTIPLY", (0, -200)
    tree.links.new(first.outputs["Roughness"], rough.inputs[0])
    tree.links.new(factor[1], rough.inputs[1])
    tree.links.new(rough.outputs[0], last.inputs["Roughness"])
    return tree


def add_wet_look(material):
    """Puts the group between the base colour and roughness of a material and its principled shader. Returns whether
    the material has one of them and did not have the group."""
    if material.node_tree is None:
        material.use_nodes = True
    tree = material.node_tree
    if any(node.type == "GROUP" and node.node_tree and node.node_tree.name == GROUP for node in tree.nodes):
        return False
    shader = next((node for node in tree.nodes if node.type == "BSDF_PRINCIPLED"), None)
    if shader is None:
        return False
    group = tree.nodes.new("ShaderNodeGroup")
    group.node_tree, group.location = wet_group(), (shader.location.x - 220, shader.location.y)
    for name in ("Base Color", "Roughness"):
        socket = shader.inputs[name]
        if socket.is_linked:
            tree.links.new(socket.links[0].from_socket, group.inputs[name])
        else:
            group.inputs[name].default_value = socket.default_value
        tree.links.new(group.outputs[name], socket)
    return True


def make_material(name, **inputs):
    """A material with one principled shader; `inputs` by name with _ for spaces."""
    material = bpy.data.materials.new(name)
    if material.node_tree is None:  # Blender 5 makes the nodes itself
        material.use_nodes = True
    shader = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    for key, value in inputs.items():
        shader.inputs[key.replace("_", " ")].default_value = value
    return material


def wet_cloth(thing):
    """Gives all materials of a cloth the wet look; a new material where it has none. Returns how many changed."""
    if not any(slot.material for slot in thing.material_slots):
        material = make_material(f"{thing.name} Fabric", Base_Color=(0.55, 0.6, 0.7, 1), Roughness=0.9)
        if thing.material_slots:
            thing.material_slots[0].material = material
        else:
            thing.data.materials.append(material)
    return sum(add_wet_look(slot.material) for slot in thing.material_slots if slot.material)


def water():
    """The material of liquid, made once per file."""
    return bpy.data.materials.get("Drench Water") or make_material(
        "Drench Water", Base_Color=(0.85, 0.95, 1, 1), Roughness=0.02, IOR=1.33, Transmission_Weight=1.0)
