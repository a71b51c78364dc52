"""From the zip file to rendered pictures: the three example scenes are built, saved, reloaded, baked and rendered.

DRENCH_BLENDER_PICTURES keeps the pictures in that folder."""

import os
import sys
import time
from pathlib import Path

import numpy as np

import support  # first: it sets the paths of the modules after it

if support.HAS_BLENDER:
    import make_scenes

SIZE = (160, 120)
SECONDS = 240  # each bakes in less than a minute on a free machine, but tests share it


@support.needs_program
class Examples(support.BlenderCase):
    def render(self, frame, name):
        """The picture of a frame as an array of rows, columns and colours, 0 to 1."""
        scene = self.bpy.context.scene
        scene.frame_set(frame)
        path = self.pictures / f"{name}_{frame:03d}.png"
        scene.render.filepath = str(path)
        with support.Quiet():
            self.bpy.ops.render.render(write_still=True)
        image = self.bpy.data.images.load(str(path))
        pixels = np.empty(4 * image.size[0] * image.size[1], np.float32)
        image.pixels.foreach_get(pixels)
        self.bpy.data.images.remove(image)
        return pixels.reshape(SIZE[1], SIZE[0], 4)[:, :, :3]

    def bake_example(self, name):
        """Builds and bakes an example after saving and loading it again. Returns the pictures of some frames."""
        self.pictures = Path(os.environ.get("DRENCH_BLENDER_PICTURES", self.folder)).resolve()
        with support.Quiet():
            path = make_scenes.make(name, self.folder)
            self.bpy.ops.wm.read_homefile(use_empty=True)
            self.bpy.ops.wm.open_mainfile(filepath=str(path))
        scene = self.bpy.context.scene
        scene.drench.threads = 1
        scene.render.resolution_x, scene.render.resolution_y = SIZE
        scene.cycles.samples = 8
        began = time.monotonic()
        self.assertEqual(self.bake(), {"FINISHED"})
        seconds = time.monotonic() - began
        print(f"{name}: baked in {seconds:.0f} s", file=sys.stderr, flush=True)
        self.assertLess(seconds, SECONDS)
        self.assertTrue((self.folder / f"drench_cache/{name}_Scene/bake.json").exists())
        last = scene.frame_end
        pictures = [self.render(frame, name) for frame in (1, last // 2, last)]
        for picture in pictures:
            self.assertGreater(picture.std(), 0.02)  # neither black nor empty
        for first, second in zip(pictures, pictures[1:]):
            self.assertGreater(np.abs(first - second).mean(), 0.005)
        return scene

    def wetness(self, name):
        """Saturation of the vertices of a cloth at the current frame."""
        return self.positions(self.bpy.data.objects[name])[1]

    def test_napkin(self):
        self.bake_example("napkin")
        wet = self.wetness("Napkin")
        self.assertTrue(0.1 < (wet > 0.5).mean() < 0.9, "the napkin is neither dry nor soaked")

    def test_towel(self):
        scene = self.bake_example("towel")
        points, wet = self.positions(self.bpy.data.objects["Towel"])
        self.assertGreater(points[:, 2].max(), 0.5)
        self.assertGreater(wet.min(), 0.3)
        self.animation(scene)

    def test_shirt(self):
        self.bake_example("shirt")
        points, wet = self.positions(self.bpy.data.objects["Shirt"])
        self.assertTrue(0.0 < (wet > 0.2).mean() < 0.9, f"wet: {(wet > 0.2).mean():.2f}, largest {wet.max():.2f}")
        self.assertGreater(points[:, 2].max(), 0.45)  # it hangs on the shoulders
        skin = self.positions(self.bpy.data.objects["Mannequin"])[0]
        self.assertLess(np.abs(points[:, :2]).max() - np.abs(skin[:, :2]).max(), 0.15)

    def animation(self, scene):
        """Rendering an animation shows every frame in turn."""
        scene.frame_start, scene.frame_end = 12, 14
        scene.render.filepath = str(self.folder / "film_")
        with support.Quiet():
            self.bpy.ops.render.render(animation=True)
        pictures = [(self.folder / f"film_{frame:04d}.png").read_bytes() for frame in (12, 13, 14)]
        self.assertEqual(len(set(pictures)), 3)


if __name__ == "__main__":
    support.unittest.main()
