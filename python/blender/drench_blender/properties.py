"""The settings of objects and scenes. They are saved in the .blend file and take part in undo."""

import math

import bpy
from bpy.props import (BoolProperty, EnumProperty, FloatProperty, FloatVectorProperty, IntProperty, PointerProperty,
                       StringProperty)

ROLES = (("NONE", "None", "This object takes no part in the simulation"),
         ("CLOTH", "Cloth", "A surface of fabric. Its mesh at the first frame is simulated"),
         ("LIQUID", "Liquid", "Liquid that fills this object at the first frame"),
         ("EMITTER", "Emitter", "A nozzle or spray at the origin of this object, its faces, or rain from it"),
         ("COLLIDER", "Collider", "A solid that liquid and cloth touch; it may be animated"))
RELATIVE = {"options": {"PATH_SUPPORTS_BLEND_RELATIVE"}} if bpy.app.version >= (4, 5, 0) else {}
# Kinematic viscosity, m²/s, and surface tension, N/m, at 20 °C.
LIQUIDS = {"WATER": (1e-6, 0.0), "MILK": (2e-6, 0.0), "OIL": (8e-5, 0.0), "HONEY": (5e-3, 0.0)}


def _search_fabrics(_self, context, text):
    from . import preferences, program
    from .problem import Problem
    try:
        names = program.fabrics(preferences.find_program(context))
    except Problem:
        return []
    return [name for name in names if text.lower() in name]


def _role_changed(self, _context):
    from . import playback
    playback.follow_role(self.id_data)


def _display_changed(self, _context):
    from . import playback
    playback.show_liquid(self.id_data)


class DrenchObject(bpy.types.PropertyGroup):
    role: EnumProperty(name="Role", items=ROLES, default="NONE", update=_role_changed,
                       description="The part of this object in the simulation")

    fabric: StringProperty(
        name="Fabric", search=_search_fabrics, search_options={"SORT"},
        description="Named fabric of the program, which supplies mass, thickness, stiffness and absorption; "
        "empty: the values below")
    use_density: BoolProperty(name="Own Mass", description="Replace the mass per unit area of the fabric")
    density: FloatProperty(name="Mass per Unit Area", default=0.2, min=1e-4, soft_max=2, max=1000, precision=3,
                           description="Of the dry fabric, in kg/m²; 150 g/m² is 0.15")
    use_thickness: BoolProperty(name="Own Thickness", description="Replace the thickness of the fabric")
    thickness: FloatProperty(name="Thickness", default=1.0, min=1e-3, soft_max=10, max=1000, precision=2,
                             description="Of the fabric, in mm; it determines how much liquid the fabric holds")
    stretch: FloatProperty(name="Tensile Stiffness", default=500, min=1e-3, soft_max=1e4, max=1e9,
                           description="Young's modulus times thickness, in N/m; only without a named fabric")
    bend: FloatProperty(name="Bending Stiffness", default=100, min=0, soft_max=1e4, max=1e12,
                        description="Flexural rigidity, in µN·m; only without a named fabric")
    friction: FloatProperty(name="Friction", default=0.3, min=0, max=10, soft_max=1,
                            description="Friction coefficient of dry fabric on colliders and cloth")
    friction_wet: FloatProperty(name="Wet Friction", default=0.9, min=0, max=10, soft_max=1.5,
                                description="Friction coefficient of saturated fabric")
    damping: FloatProperty(name="Damping", default=1, min=0, soft_max=10, max=1e6,
                           description="Damping rate of the velocity, by the air, in 1/s")
    warp: EnumProperty(name="Warp", default="AUTO", description="Direction of the stronger yarns", items=(
        ("AUTO", "Automatic", "The local Z axis if the cloth extends along it, otherwise the local Y axis"),
        ("X", "X", "The local X axis"), ("Y", "Y", "The local Y axis"), ("Z", "Z", "The local Z axis")))
    pin_group: StringProperty(name="Pin Group", description="Vertices with a weight of at least 0.5 in this vertex "
                              "group follow the animation of the object; all others are simulated")
    use_pin_stiffness: BoolProperty(name="Soft Pins", description="Hold pinned vertices by springs instead of rigidly")
    pin_stiffness: FloatProperty(name="Pin Stiffness", default=500, min=1e-3, soft_max=1e5, max=1e9,
                                 description="Of the springs of all pinned vertices together, in N/m")
    use_pin_release: BoolProperty(name="Release Pins", description="Let go of the pinned vertices at a frame")
    pin_release: IntProperty(name="Release Frame", default=50, description="Frame from which the pins no longer hold")
    self_collision: BoolProperty(name="Self Collision", default=False,
                                 description="Collisions with itself and with other cloths that have this option; "
                                 "increases the run time")
    absorbs: BoolProperty(name="Absorbs Water", default=True,
                          description="The fabric absorbs, spreads and drips liquid; otherwise it acts as a wall")
    saturation: FloatProperty(name="Initial Saturation", default=0, min=0, max=1, subtype="FACTOR",
                              description="Volume of liquid in the fabric divided by the volume of its pores")
    weld: BoolProperty(name="Close Seams", default=True,
                       description="Merge boundary vertices that lie in the same place, within 0.01 mm")

    liquid_shape: EnumProperty(name="Shape", default="BOX", items=(
        ("BOX", "Bounding Box", "Fill the bounding box along the axes of the world"),
        ("MESH", "Closed Mesh", "Fill the inside of the mesh, which must be closed")))
    liquid_velocity: FloatVectorProperty(name="Velocity", subtype="VELOCITY", size=3, soft_min=-10, soft_max=10,
                                         min=-1000, max=1000, description="Initial velocity in m/s, in world axes")

    emitter_shape: EnumProperty(name="Shape", default="NOZZLE", items=(
        ("NOZZLE", "Nozzle", "A round nozzle at the origin of the object"),
        ("SPRAY", "Spray", "Drops from the origin of the object in all directions of a cone, as from a shower head"),
        ("FACES", "Faces", "The faces of the mesh, along their normals, for example a plane"),
        ("RAIN", "Rain", "Drops from the level rectangle that the object covers")))
    emitter_rate: FloatProperty(name="Rate", default=2000, min=1e-6, soft_max=10000, max=1e6,
                                description="Depth of water per hour on level ground, in mm/h. A cloudburst has 50; "
                                "drops that a film shows well need hundreds or thousands")
    emitter_drop: FloatProperty(name="Drop Diameter", default=0.004, min=1e-5, soft_max=0.006, max=0.01, precision=4,
                                description="Diameter of a drop in m, at most 1.2 particle spacings. Rain falls at the "
                                "terminal speed of this diameter")
    emitter_radius: FloatProperty(name="Radius", default=0.05, min=1e-6, soft_max=1, max=100, unit="LENGTH",
                                  description="Radius of the nozzle, at least half a particle spacing")
    emitter_speed: FloatProperty(name="Speed", default=1, min=0, soft_max=10, max=1000,
                                 description="Speed of the liquid relative to the emitter, in m/s. It may be animated, "
                                 "like the location and rotation of the object; 0 closes the emitter")
    emitter_angle: FloatProperty(name="Cone Angle", default=math.radians(40), min=0, max=2 * math.pi, subtype="ANGLE",
                                 description="Angle of the whole cone that the drops fill")
    emitter_flow: FloatProperty(name="Flow", default=10, min=1e-6, soft_max=100, max=1e6,
                                description="Volume per time in L/min. A shower has about 10")
    emitter_axis: EnumProperty(name="Direction", default="-Z", items=(
        ("-Z", "Local -Z", "Downwards for an object that is not rotated, like lights and cameras"),
        ("+Z", "Local +Z", "Upwards for an object that is not rotated")))
    use_emitter_range: BoolProperty(name="Limit Frames", description="Emit only between two frames")
    emitter_start: IntProperty(name="First Frame", default=1, description="Frame at which the flow starts")
    emitter_end: IntProperty(name="Last Frame", default=50, description="Frame at which the flow stops")

    collider_shape: EnumProperty(name="Shape", default="MESH", items=(
        ("MESH", "Mesh", "The mesh, which must enclose a volume in scenes with cloth; its holes are closed"),
        ("PLANE", "Plane", "An infinite plane through the origin of the object; its local +Z side is free"),
        ("CONTAINER", "Container", "The inside of its bounding box is free and everything outside is solid")))
    collider_open: BoolProperty(name="Open Top", default=True,
                                description="The container has no lid: its walls reach up to the end of the domain")
    collider_animated: BoolProperty(name="Follow Animation", default=True,
                                    description="Export the mesh at every frame if it moves or changes its shape")

    # Set by a bake; they are pointers so that objects may be renamed.
    shown: PointerProperty(name="Simulated Cloth", type=bpy.types.Object, options={"HIDDEN"})
    cloth_index: IntProperty(default=-1, options={"HIDDEN"})


class DrenchScene(bpy.types.PropertyGroup):
    spacing: FloatProperty(name="Particle Spacing", default=0.02, min=1e-6, soft_max=0.2, max=10, unit="LENGTH",
                           precision=4, description="Diameter of a particle. Half the spacing needs at least 16 "
                           "times the run time")
    substeps: IntProperty(name="Steps per Frame", default=10, min=1, soft_max=100, max=10000,
                          description="Time steps per frame")
    adaptive: BoolProperty(name="Adaptive Steps", default=True,
                           description="Use shorter steps while the liquid is fast")
    use_range: BoolProperty(name="Own Frame Range", description="Simulate other frames than those of the scene")
    frame_start: IntProperty(name="First Frame", default=1, description="Frame at which the simulation starts")
    frame_end: IntProperty(name="Last Frame", default=50, description="Last frame to simulate")
    time_scale: FloatProperty(name="Speed", default=1, min=1e-3, soft_min=0.1, soft_max=2, max=100,
                              description="Simulated seconds per second of the film; 0.5 is half speed. Colliders and "
                              "pins keep their speed in the film, so at half speed the liquid meets them twice as fast")
    domain: PointerProperty(name="Domain", type=bpy.types.Object,
                            description="Liquid outside the bounding box of this object is removed; "
                            "empty: a box around all objects of the simulation")
    liquid: EnumProperty(name="Liquid", default="WATER", items=(
        ("WATER", "Water", "1e-6 m²/s"), ("MILK", "Milk", "2e-6 m²/s"), ("OIL", "Vegetable Oil", "8e-5 m²/s"),
        ("HONEY", "Honey", "0.005 m²/s"), ("OWN", "Own Viscosity", "The value below")))
    viscosity: FloatProperty(name="Viscosity", default=1e-6, min=0, max=100, precision=7,
                             description="Kinematic viscosity, in m²/s")
    surface_tension: FloatProperty(name="Surface Tension", default=0, min=0, max=10, precision=3,
                                   description="In N/m; water has 0.072. It requires shorter time steps")
    surface: BoolProperty(name="Bake Surface", default=True,
                          description="Write the surface of the liquid as a mesh at every frame")
    display: EnumProperty(name="Show Liquid As", default="SURFACE", update=_display_changed, items=(
        ("SURFACE", "Surface", "The mesh of the program, which requires Bake Surface"),
        ("SPHERES", "Spheres", "A sphere per particle"),
        ("POINTS", "Points", "The particles as vertices with attributes, for your own geometry nodes")))
    cache: StringProperty(name="Cache Folder", subtype="DIR_PATH", default="",
                          description="Folder for the scene, the meshes and the frames; empty: a folder in "
                          "drench_cache beside the file, named after the file and the scene", **RELATIVE)
    run_on: EnumProperty(name="Run On", default="LOCAL", description="Where a new bake and a check run", items=(
        ("LOCAL", "This Computer", "The program of the preferences"),
        ("REMOTE", "Remote Machine", "The machine of the preferences, by ssh. A bake there outlives Blender")))
    threads: IntProperty(name="Threads", default=0, min=0, max=1024,
                         description="Number of processor threads; 0: those that are free. The result is the same")
    checkpoint_frames: IntProperty(name="Frames per Checkpoint", default=10, min=1, max=10000,
                                   description="A bake that was ended by force continues from the last checkpoint")
    messages: StringProperty(options={"HIDDEN", "SKIP_SAVE"})  # of the last check or bake, one per line

    particles: PointerProperty(type=bpy.types.Object, options={"HIDDEN"})
    liquid_surface: PointerProperty(type=bpy.types.Object, options={"HIDDEN"})


CLASSES = (DrenchObject, DrenchScene)


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Object.drench = PointerProperty(type=DrenchObject)
    bpy.types.Scene.drench = PointerProperty(type=DrenchScene)


def unregister():
    del bpy.types.Object.drench, bpy.types.Scene.drench
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
