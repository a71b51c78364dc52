"""What the tests share: a Blender with the extension installed from its zip file, and small scenes.

The program is that of DRENCH_PROGRAM. Settings of the user's own Blender are neither read nor changed."""

import atexit
import importlib
import importlib.util
import os
import shutil
import sys
import tempfile
import unittest
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.dont_write_bytecode = True
sys.path[:0] = [str(HERE.parent), str(HERE.parent / "examples")]

#: The module of the installed extension.
MODULE = "bl_ext.user_default.drench"
HAS_BLENDER = importlib.util.find_spec("bpy") is not None
PROGRAM = shutil.which(os.environ.get("DRENCH_PROGRAM", "drench"))

needs_blender = unittest.skipUnless(HAS_BLENDER, "needs Blender as a Python module: tools/setup blender")
needs_program = unittest.skipUnless(HAS_BLENDER and PROGRAM, "needs Blender as a Python module and the program drench, "
                                    "which DRENCH_PROGRAM names")
_installed = False

# This folder replaces the user's settings and extensions. Blender reads the variable when bpy is imported.
_FOLDER = tempfile.mkdtemp(prefix="drench_blender_")
os.environ["BLENDER_USER_RESOURCES"] = _FOLDER
atexit.register(shutil.rmtree, _FOLDER, ignore_errors=True)


def install():
    """Builds the zip file, installs it as a user does, and returns bpy."""
    global _installed
    import bpy
    if not _installed:
        import build
        folder = Path(tempfile.mkdtemp(prefix="drench_zip_"))
        archive = build.build(folder)
        with Quiet():
            bpy.ops.extensions.package_install_files(filepath=str(archive), repo="user_default", enable_on_install=True)
        shutil.rmtree(folder)
        _installed = True
    return bpy


def part(name):
    """A module of the installed extension."""
    return importlib.import_module(f"{MODULE}.{name}")


class Quiet:
    """Discards what Blender prints, also past Python."""

    def __enter__(self):
        sys.stdout.flush()
        self.kept, nothing = os.dup(1), os.open(os.devnull, os.O_WRONLY)
        os.dup2(nothing, 1)
        os.close(nothing)

    def __exit__(self, *_):
        sys.stdout.flush()
        os.dup2(self.kept, 1)
        os.close(self.kept)


class BlenderCase(unittest.TestCase):
    """A test with an empty scene and a folder of its own."""

    def setUp(self):
        self.bpy = install()
        self.folder = Path(tempfile.mkdtemp(prefix="drench_test_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.empty_file()

    def empty_file(self):
        self.bpy.ops.wm.read_homefile(use_empty=True)
        self.scene = self.bpy.context.scene
        self.scene.drench.cache = str(self.folder / "cache")
        self.scene.drench.threads = 1

    def sheet(self, name="Sheet", cells=8, size=0.4):
        """A horizontal square with a pin group "Corners"."""
        import stage
        thing = stage.grid(name, (size, size), (cells, cells))
        n = cells + 1
        stage.group(thing, "Corners", [0, n - 1, n * (n - 1), n * n - 1])
        thing.drench.role, thing.drench.pin_group = "CLOTH", "Corners"
        return thing

    def check(self):
        """The messages of a check of the scene that succeeds; needs the program."""
        with Quiet():
            self.assertEqual(self.bpy.ops.drench.check(), {"FINISHED"})
        return self.scene.drench.messages

    def water(self, low=(-0.06, -0.06, 0.05), high=(0.06, 0.06, 0.17)):
        import stage
        thing = stage.box("Water", low, high)
        thing.drench.role = "LIQUID"
        return thing

    def wet_sheet(self, frames=24, spacing=0.03):
        """Water falls on a sheet that hangs by its corners."""
        sheet, self.scene.drench.spacing = self.sheet(), spacing
        self.water()
        self.scene.frame_start, self.scene.frame_end = 1, frames
        return sheet

    def bake(self):
        with Quiet():
            return self.bpy.ops.drench.bake()

    def message(self, operator, *words):
        """The error message of an operator, which must fail without a traceback."""
        with self.assertRaises(RuntimeError) as caught, Quiet():
            operator(*words)
        text = str(caught.exception)
        self.assertNotIn("Traceback", text)
        return text

    def positions(self, thing):
        """Vertices of the evaluated object in world coordinates, and its attribute `saturation`."""
        import numpy as np
        seen = thing.evaluated_get(self.bpy.context.evaluated_depsgraph_get())
        points = np.array([seen.matrix_world @ v.co for v in seen.data.vertices])
        wet = seen.data.attributes.get("saturation")
        return points, None if wet is None else np.array([v.value for v in wet.data])


class BakeCase(BlenderCase):
    """A test that looks at the modules and the cache of the extension."""

    def setUp(self):
        super().setUp()
        self.bakes, self.playback = part("bakes"), part("playback")
        self.frames, self.process = part("frames"), part("process")

    def cache(self):
        return self.playback.cache_of(self.scene)
