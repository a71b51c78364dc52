"""Panels: the role of an object (tab Physics), and the simulation (tab Scene)."""

import textwrap

import bpy

from . import bakes, operators, playback
from .problem import Problem


def show_lines(layout, text, width=60, most=12):
    """Messages of one line each, wrapped."""
    box = layout.box().column(align=True)
    lines = [(part, k == 0) for line in text.splitlines() for k, part in enumerate(textwrap.wrap(line, width))]
    for part, first in lines[:most]:
        icon = "ERROR" if first and part.startswith("warning") else "NONE"
        box.label(text=part if first else "    " + part, icon=icon)
    if len(lines) > most:
        box.label(text="… more in the Info editor")


class Panel:
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"


class DRENCH_PT_object(Panel, bpy.types.Panel):
    bl_label = "Drench"
    bl_context = "physics"

    @classmethod
    def poll(cls, context):
        return context.object is not None

    def draw(self, context):
        layout, own = self.layout, context.object.drench
        layout.use_property_split = True
        layout.prop(own, "role")
        if own.role in ("CLOTH", "LIQUID", "COLLIDER") and context.object.type != "MESH":
            layout.label(text="This role needs a mesh", icon="ERROR")
            return
        draw = {"CLOTH": draw_cloth, "LIQUID": draw_liquid, "EMITTER": draw_emitter, "COLLIDER": draw_collider}
        if own.role in draw:
            draw[own.role](layout, context.object)


def draw_cloth(layout, thing):
    own = thing.drench
    layout.prop(own, "fabric", icon="MATCLOTH")
    for use, value in (("use_density", "density"), ("use_thickness", "thickness")):
        row = layout.row(heading="")
        if own.fabric:
            row.prop(own, use, text="")
        sub = row.row()
        sub.active = not own.fabric or getattr(own, use)
        sub.prop(own, value)
    if not own.fabric:
        layout.prop(own, "stretch")
        layout.prop(own, "bend")
    for name in ("warp", "friction", "damping"):
        layout.prop(own, name)
    layout.prop_search(own, "pin_group", thing, "vertex_groups")
    for use, value in (("use_pin_stiffness", "pin_stiffness"), ("use_pin_release", "pin_release")):
        row = layout.row(heading="")
        row.active = bool(own.pin_group)
        row.prop(own, use, text="")
        sub = row.row()
        sub.active = getattr(own, use)
        sub.prop(own, value)
    layout.prop(own, "self_collision")
    layout.prop(own, "weld")
    layout.separator()
    layout.prop(own, "absorbs")
    column = layout.column()
    column.active = own.absorbs
    column.prop(own, "saturation")
    column.prop(own, "friction_wet")
    layout.operator("drench.wet_look")


def draw_liquid(layout, thing):
    layout.prop(thing.drench, "liquid_shape")
    layout.prop(thing.drench, "liquid_velocity")


def draw_emitter(layout, thing):
    own = thing.drench
    settings = {"NOZZLE": ("emitter_axis", "emitter_radius", "emitter_speed"), "FACES": ("emitter_speed",),
                "SPRAY": ("emitter_axis", "emitter_angle", "emitter_speed", "emitter_flow"),
                "RAIN": ("emitter_rate", "emitter_drop")}
    for name in ("emitter_shape", *settings[own.emitter_shape], "use_emitter_range"):
        layout.prop(own, name)
    column = layout.column()
    column.active = own.use_emitter_range
    column.prop(own, "emitter_start")
    column.prop(own, "emitter_end")


def draw_collider(layout, thing):
    own = thing.drench
    layout.prop(own, "collider_shape")
    if own.collider_shape == "MESH":
        layout.prop(own, "collider_animated")
    if own.collider_shape == "CONTAINER":
        layout.prop(own, "collider_open")


class DRENCH_PT_scene(Panel, bpy.types.Panel):
    bl_label = "Drench"
    bl_context = "scene"

    def draw(self, context):
        layout, own = self.layout, context.scene.drench
        layout.use_property_split = True
        for name in ("spacing", "substeps", "adaptive", "time_scale", "use_range"):
            layout.prop(own, name)
        if own.use_range:
            layout.prop(own, "frame_start")
            layout.prop(own, "frame_end")
        layout.prop(own, "domain")
        layout.separator()
        layout.prop(own, "liquid")
        if own.liquid == "OWN":
            layout.prop(own, "viscosity")
        layout.prop(own, "surface_tension")
        layout.prop(own, "surface")
        layout.prop(own, "display")


class DRENCH_PT_bake(Panel, bpy.types.Panel):
    bl_label = "Bake"
    bl_context = "scene"
    bl_parent_id = "DRENCH_PT_scene"

    def draw(self, context):
        layout, own = self.layout, context.scene.drench
        layout.use_property_split = True
        column = layout.column()
        column.enabled = not bakes.running()
        for name in ("run_on", "cache", "threads", "checkpoint_frames"):
            column.prop(own, name)
        layout.operator("drench.check", icon="CHECKMARK")
        if bakes.running():
            self._draw_running(layout)
        else:
            self._draw_idle(layout, context.scene)
        if own.messages:
            show_lines(layout, own.messages)

    def _draw_running(self, layout):
        done, total = bakes.current.frames()
        layout.progress(factor=done / max(total, 1), text=operators.progress_text(bakes.current))
        row = layout.row()
        if bakes.current.stop_after is not None:
            row.label(text="Writing a checkpoint …")
            return
        row.operator("drench.stop", icon="PAUSE")
        row.operator("drench.cancel", icon="X")

    def _draw_idle(self, layout, scene):
        row = layout.row()
        row.operator("drench.bake", icon="RENDER_ANIMATION")
        try:
            cache = playback.cache_of(scene)
            record = cache.record()
        except Problem as problem:
            show_lines(layout, str(problem))
            return
        layout.operator("drench.write", icon="EXPORT")
        if record is None:
            return
        if record.get("status") != "finished":
            row.operator("drench.resume", icon="PLAY")
        layout.label(text=f"{cache.frames_done()} of {record['frames']} frames are baked")
        if record.get("remote") and record.get("status") == "running":
            layout.label(text=f"May still run on {record['remote']['host']}: Continue fetches its frames")
        row = layout.row()
        row.operator("drench.load", icon="FILE_REFRESH")
        row.operator("drench.delete_cache", icon="TRASH")


CLASSES = (DRENCH_PT_object, DRENCH_PT_scene, DRENCH_PT_bake)


register, unregister = bpy.utils.register_classes_factory(CLASSES)
