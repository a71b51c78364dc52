"""Bake, cancel, continue, crash, quit and delete."""

import hashlib
import os
import shutil
import subprocess
import sys
import textwrap
import time
import types
from pathlib import Path

import support  # first: it sets the paths of the modules after it


def is_alive(pid):
    """Does the process exist and run? A process that ended and was not collected yet does not run."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


@support.needs_program
class Bake(support.BakeCase):
    @property
    def run_folder(self):
        return self.folder / "cache" / "run"

    def frame_files(self):
        """{name: hash of the contents} of all frames."""
        return {path.name: hashlib.sha256(path.read_bytes()).hexdigest()
                for path in sorted((self.run_folder / "frames").iterdir())}

    def start_and_wait(self, frames):
        """Starts a bake without blocking and returns it once it has so many frames."""
        bake = self.bakes.start(self.bpy.context)
        deadline = time.monotonic() + 60
        while bake.poll() and bake.frames()[0] < frames and time.monotonic() < deadline:
            time.sleep(0.005)
        self.assertEqual(bake.status, "running", "the scene is too short for this test")
        return bake

    def assert_whole_frames(self):
        """Nothing half-written, and each listed frame can be read."""
        self.assertEqual([p.name for p in (self.run_folder / "frames").iterdir() if not p.name.endswith(".vtu")], [])
        for series in ("cloth", "fluid", "surface"):
            for path in self.cache().frames(series).values():
                self.assertIn("Points", self.frames.read_frame(path, {"Points"}))

    def test_cancel_and_continue_give_the_same_bits(self):
        self.wet_sheet(frames=40)
        self.assertEqual(self.bake(), {"FINISHED"})
        wanted = self.frame_files()
        bake = self.start_and_wait(8)
        pid = bake.process.pid
        with support.Quiet():
            self.bpy.ops.drench.cancel()
        self.assertFalse(is_alive(pid))
        self.assertEqual(self.cache().record()["status"], "stopped")
        done = self.cache().frames_done()
        self.assertTrue(8 <= done < 40, done)
        self.assert_whole_frames()
        with support.Quiet():
            self.assertEqual(self.bpy.ops.drench.resume(), {"FINISHED"})
        self.assertEqual(self.frame_files(), wanted)
        self.assertIn("complete", self.message(self.bpy.ops.drench.resume))

    def test_pause_and_continue_twice(self):
        self.wet_sheet(frames=30)
        self.bake()
        wanted = self.frame_files()
        self.start_and_wait(4)
        for more in (5, 5):
            with support.Quiet():
                self.bpy.ops.drench.stop(wait=True)
            before = self.cache().frames_done()
            bake = self.bakes.start(self.bpy.context, resume=True)
            while bake.poll() and bake.frames()[0] < before + more:
                time.sleep(0.005)
        while bake.poll():
            time.sleep(0.005)
        self.assertEqual((bake.status, self.frame_files() == wanted), ("finished", True))

    def test_cancel_by_force(self):
        """After kill -9 the last regular checkpoint is used, and no half frame is left."""
        self.wet_sheet(frames=30)
        self.scene.drench.checkpoint_frames = 4
        self.bake()
        wanted = self.frame_files()
        bake = self.start_and_wait(10)
        bake.process.kill()
        while bake.poll():
            time.sleep(0.005)
        self.assertEqual(bake.status, "failed")
        (self.run_folder / "frames" / ".cloth_000011.vtu.part").write_text("half")
        self.bakes.start(self.bpy.context, resume=True)
        while self.bakes.current.poll():
            time.sleep(0.005)
        self.assert_whole_frames()
        self.assertEqual(self.frame_files(), wanted)

    def test_modal(self):
        """The operator with a window: here the window, its timer and its events are stand-ins."""
        self.wet_sheet(frames=8)
        operators = support.part("operators")
        timers = []
        manager = types.SimpleNamespace(
            progress_begin=lambda *_: None, progress_update=lambda *_: None, progress_end=lambda: None, windows=(),
            event_timer_add=lambda seconds, window: timers.append(seconds) or seconds,
            event_timer_remove=timers.remove, modal_handler_add=lambda _: None)
        window = types.SimpleNamespace(
            scene=self.scene, window=object(), window_manager=manager, view_layer=self.bpy.context.view_layer,
            evaluated_depsgraph_get=self.bpy.context.evaluated_depsgraph_get, preferences=self.bpy.context.preferences)
        reports = []
        operator = type("Stand", (operators.BakeOperator,), {"report": lambda _, *words: reports.append(words)})()
        background, operators.in_background = operators.in_background, lambda: False
        try:
            self.assertEqual(operator.invoke(window, None), {"RUNNING_MODAL"})
            self.assertEqual(operator.modal(window, types.SimpleNamespace(type="MOUSEMOVE")), {"PASS_THROUGH"})
            timer, states = types.SimpleNamespace(type="TIMER"), []
            while not states or states[-1] == {"PASS_THROUGH"}:
                states.append(operator.modal(window, timer))
                time.sleep(0.01)
            self.assertEqual((states[-1], timers, reports[-1]),
                             ({"FINISHED"}, [], ({"INFO"}, "8 of 8 frames are baked")))
            for thing in [t for t in self.scene.objects if t.drench.role != "NONE"]:
                thing.drench.role = "NONE"
            self.assertEqual(operator.invoke(window, None), {"CANCELLED"})
            self.assertIn("there is nothing to simulate", reports[-1][1])
        finally:
            operators.in_background = background

    def test_written_here_and_run_elsewhere(self):
        """The folder is copied, run by the program alone, and loaded again."""
        sheet = self.wet_sheet(frames=6)
        with support.Quiet():
            self.bpy.ops.drench.write()
        self.assertEqual(self.cache().frames_done(), 0)
        away = self.folder / "elsewhere"
        shutil.copytree(self.folder / "cache", away)
        subprocess.run([support.PROGRAM, "run", "scene.yaml", "-o", "run", "--threads", "1"], cwd=away, check=True,
                       stdout=subprocess.DEVNULL)
        self.scene.drench.cache = str(away)
        with support.Quiet():
            self.bpy.ops.drench.load()
        self.assertEqual(self.cache().record()["status"], "finished")
        self.scene.frame_set(6)
        self.assertLess(self.positions(sheet)[0][:, 2].min(), -0.001)
        self.scene.drench.cache = str(self.folder / "none")
        self.assertIn("contains no bake: choose the folder", self.message(self.bpy.ops.drench.load))

    def test_one_bake_at_a_time(self):
        self.wet_sheet(frames=40)
        self.start_and_wait(1)
        self.assertFalse(self.bpy.ops.drench.bake.poll())
        self.assertFalse(self.bpy.ops.drench.delete_cache.poll())
        self.bakes.stop()

    def test_loading_a_file_stops_the_process(self):
        self.wet_sheet(frames=60)
        pid = self.start_and_wait(2).process.pid
        with support.Quiet():
            self.bpy.ops.wm.read_homefile(use_empty=True)
        self.assertFalse(is_alive(pid))

    def script(self, ending):
        """Another Blender that bakes this file and then ends in some way; returns the process id of its program."""
        with support.Quiet():
            self.bpy.ops.wm.save_as_mainfile(filepath=str(self.folder / "scene.blend"))
        code = textwrap.dedent(f"""
            import os, signal, sys, time
            import bpy  # first: it brings the modules below
            import addon_utils
            addon_utils.enable("{support.MODULE}")
            bpy.ops.wm.open_mainfile(filepath={str(self.folder / "scene.blend")!r})
            from {support.MODULE} import bakes
            bake = bakes.start(bpy.context)
            while bake.poll() and bake.frames()[0] < 4:
                time.sleep(0.01)
            print("pid", bake.process.pid, flush=True)
            {ending}
            """)
        done = subprocess.run([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                              timeout=120, env={**os.environ, "DRENCH_PROGRAM": support.PROGRAM}, check=False)
        self.assertIn("pid ", done.stdout)
        return int(done.stdout.split("pid ")[1].split()[0])

    def test_quitting_stops_the_process(self):
        self.wet_sheet(frames=200)
        pid = self.script("pass")
        self.assertFalse(is_alive(pid))
        self.assert_whole_frames()

    @support.unittest.skipUnless(Path("/proc/self").exists(), "needs /proc")
    def test_crash_leaves_a_process_that_is_ended(self):
        self.wet_sheet(frames=60)
        self.bake()
        wanted = self.frame_files()
        pid = self.script("os.kill(os.getpid(), signal.SIGKILL)")
        cache = self.cache()
        if is_alive(pid):
            self.assertEqual(self.process.left_over(cache), pid)
        with support.Quiet():
            self.bpy.ops.drench.resume()
        self.assertFalse(is_alive(pid))
        self.assertEqual(self.frame_files(), wanted)

    def test_damaged_record(self):
        """It is reported, and a new bake or a deletion is possible."""
        self.wet_sheet(frames=3)
        record = self.folder / "cache" / "bake.json"
        for text in ("{", "[]", '{"drench_cache": 99}'):
            self.bake()
            record.write_text(text)
            self.assertIn("delete the cache and bake again", self.message(self.bpy.ops.drench.resume))
            self.scene.frame_set(2)
            self.assertIn("delete the cache and bake again", self.scene.drench.messages)
        with support.Quiet():
            self.bpy.ops.drench.delete_cache()
        self.assertFalse((self.folder / "cache").exists())

    def test_an_error_keeps_the_earlier_bake(self):
        sheet = self.wet_sheet(frames=4)
        self.bake()
        before = self.frame_files()
        sheet.drench.pin_group = "None such"
        self.message(self.bpy.ops.drench.bake)
        self.assertEqual((self.frame_files(), self.cache().record()["status"]), (before, "finished"))
        self.assertFalse((self.folder / "cache" / "check").exists())

    def test_failed_run_names_the_object(self):
        """The program's error is reported with the names of objects."""
        self.wet_sheet().drench.fabric = "velvet"
        message = self.message(self.bpy.ops.drench.bake)
        self.assertRegex(message, "'Sheet' fabric: ")
        self.assertEqual(self.cache().record()["status"], "failed")


if __name__ == "__main__":
    support.unittest.main()
