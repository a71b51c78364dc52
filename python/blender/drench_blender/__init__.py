"""Drench for Blender: simulate water interacting with absorbent cloth."""

from . import bakes, operators, panels, playback, preferences, properties

MODULES = (properties, preferences, operators, panels, playback, bakes)


def register():
    for module in MODULES:
        module.register()


def unregister():
    for module in reversed(MODULES):
        module.unregister()
