"""The preferences of the extension: the program, and another machine that can run it."""

import os

import bpy
from bpy.props import IntProperty, StringProperty

from . import machine, program
from .problem import Problem


class DrenchPreferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    program: StringProperty(name="Program", subtype="FILE_PATH",
                            description="Path of the program drench; empty: that of an installed Python package, "
                            "otherwise that on PATH")
    found: StringProperty(options={"HIDDEN", "SKIP_SAVE"})
    host: StringProperty(name="Host", description="Machine that is reached by ssh: user@host, or a name of ssh's "
                         "configuration. It must accept a key without asking for a password")
    port: IntProperty(name="Port", default=0, min=0, max=65535, description="Port of ssh; 0: as in ssh's configuration")
    identity: StringProperty(name="Identity File", subtype="FILE_PATH",
                             description="Private key; empty: those of the agent and of ssh's configuration")
    remote_program: StringProperty(name="Remote Program", default="drench",
                                   description="Path of the program drench on the remote machine, from its home folder")
    remote_folder: StringProperty(name="Remote Folder", default="drench_bakes",
                                  description="Folder for bakes on the remote machine, from its home folder")
    connection: StringProperty(options={"HIDDEN", "SKIP_SAVE"})

    def draw(self, _context):
        self.layout.prop(self, "program")
        self.layout.operator("drench.find_program")
        if self.found:
            self.layout.label(text=self.found)
        box = self.layout.box()
        box.label(text="Remote Machine")
        for name in ("host", "port", "identity", "remote_program", "remote_folder"):
            box.prop(self, name)
        box.operator("drench.check_connection")
        if self.connection:
            box.label(text=self.connection)


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


class DRENCH_OT_check_connection(bpy.types.Operator):
    """Connect to the remote machine and show the version of its program drench"""
    bl_idname = "drench.check_connection"
    bl_label = "Check Connection"
    bl_options = {"INTERNAL"}

    def execute(self, context):
        try:
            kind, line = "INFO", machine_of(context).info(program.VERSION)
        except Problem as problem:
            kind, line = "ERROR", str(problem)
        settings(context, connection=line)
        self.report({kind}, line)
        return {"FINISHED"} if kind == "INFO" else {"CANCELLED"}


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


def machine_of(context, host=None):
    """The remote machine of the preferences. `host`: where a bake was started, which must be that machine."""
    own = settings(context)
    if host and (own is None or own.host != host):
        raise Problem(f"this bake was started on {host}: enter it as host in the preferences of the extension, "
                      "or delete the cache")
    if not bpy.app.online_access:
        raise Problem("Blender must not use the network: turn on Allow Online Access in the preferences, System")
    if own is None:
        raise Problem("the extension is not enabled: enable it in the preferences")
    return machine.Machine(own.host.strip(), own.port, os.path.expanduser(bpy.path.abspath(own.identity)),
                           own.remote_program.strip(), own.remote_folder.strip())


CLASSES = (DrenchPreferences, DRENCH_OT_find_program, DRENCH_OT_check_connection)


register, unregister = bpy.utils.register_classes_factory(CLASSES)
