"""The preferences of the extension: the path of the program, and the version that was found."""

import os

import bpy
from bpy.props import StringProperty

from . import program
from .problem import Problem


class DrenchPreferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    program: StringProperty(name="Program", subtype="FILE_PATH",
                            description="Path of the program drench; empty: that of an installed Python package, "
                            "otherwise that on PATH")
    found: StringProperty(options={"HIDDEN", "SKIP_SAVE"})

    def draw(self, _context):
        self.layout.prop(self, "program")
        self.layout.operator("drench.find_program")
        if self.found:
            self.layout.label(text=self.found)


class DRENCH_OT_find_program(bpy.types.Operator):
    """Look for the program drench and show its version"""
    bl_idname = "drench.find_program"
    bl_label = "Find Program"
    bl_options = {"INTERNAL"}

    def execute(self, context):
        program.version.cache_clear()
        program.fabrics.cache_clear()
        try:
            path = find_program(context)
            found = f"drench {program.version(path)}: {path}"
        except Problem as problem:
            settings(context, found=str(problem))
            self.report({"ERROR"}, str(problem))
            return {"CANCELLED"}
        settings(context, found=found)
        self.report({"INFO"}, found)
        return {"FINISHED"}


def settings(context, **values):
    """The preferences, or None where the extension was loaded without being enabled; sets `values`."""
    addon = context.preferences.addons.get(__package__)
    for name, value in values.items() if addon else ():
        setattr(addon.preferences, name, value)
    return addon.preferences if addon else None


def find_program(context):
    """The path of the program: of the preferences, else of the environment variable DRENCH_PROGRAM, else as found."""
    own = settings(context)
    preferred = bpy.path.abspath(own.program) if own and own.program else os.environ.get("DRENCH_PROGRAM", "")
    return program.find_program(preferred)


CLASSES = (DrenchPreferences, DRENCH_OT_find_program)


register, unregister = bpy.utils.register_classes_factory(CLASSES)
