"""Operators: check, bake, continue, pause, cancel, delete the cache, wet look."""

import contextlib
import time

import bpy
from bpy.props import BoolProperty

from . import bakes, materials, playback, process
from .problem import Problem

SECONDS_PER_LOOK = 0.25


def duration(seconds):
    """For example 1:05 min."""
    whole = int(round(seconds))
    return f"{whole} s" if whole < 60 else f"{whole // 60}:{whole % 60:02d} min" if whole < 3600 else \
        f"{whole // 3600}:{whole // 60 % 60:02d} h"


def progress_text(bake):
    if bake.phase:
        return bake.phase
    done, total = bake.frames()
    left = bake.seconds_left()
    return f"frame {done} of {total}" + (f", {duration(left)} left" if left is not None else "")


def redraw(context):
    for window in context.window_manager.windows if context.window_manager else ():
        for area in window.screen.areas:
            if area.type in ("PROPERTIES", "VIEW_3D", "STATUSBAR"):
                area.tag_redraw()


def in_background():
    """Is there no window whose events an operator could wait for?"""
    return bpy.app.background


class Idle:
    """Is available while no bake runs."""

    @classmethod
    def poll(cls, _context):
        return not bakes.running()


class Busy:
    """Is available while a bake runs."""

    @classmethod
    def poll(cls, _context):
        return bakes.running()


class Guarded:
    """An operator whose problems become one message for the user."""

    def execute(self, context):
        return self.attempt(context, self.run)

    def attempt(self, context, action):
        context.scene.drench.messages = ""
        try:
            return action(context)
        except Problem as problem:
            message = str(problem)
        except OSError as error:
            message = f"{error.filename or 'a file'}: {error.strerror or error}: check the cache folder and the disk"
        context.scene.drench.messages = message
        self.report({"ERROR"}, message)
        redraw(context)
        return {"CANCELLED"}


@contextlib.contextmanager
def cursor_progress(context):
    """Shows the part that is done, 0 to 1, at the mouse cursor."""
    if in_background():
        yield lambda part: None
        return
    context.window_manager.progress_begin(0, 1)
    try:
        yield context.window_manager.progress_update
    finally:
        context.window_manager.progress_end()


class DRENCH_OT_check(Idle, Guarded, bpy.types.Operator):
    """Check the scene without baking it"""
    bl_idname = "drench.check"
    bl_label = "Check"

    def run(self, context):
        with cursor_progress(context) as progress:
            valid, lines = bakes.check(context, progress)
        context.scene.drench.messages = "\n".join(lines)
        for line in lines:
            self.report({"WARNING"} if line.startswith("warning: ") else {"INFO"} if valid else {"ERROR"}, line)
        return {"FINISHED"} if valid else {"CANCELLED"}


class BakeOperator(Idle, Guarded):
    """Runs in the background with a timer where there is a window, otherwise until the bake ends."""

    resume = False
    _timer = None

    def start(self, context):
        with cursor_progress(context) as progress:
            return bakes.start(context, self.resume, progress)

    def run(self, context):
        bake = self.start(context)
        try:
            shown = None
            while bake.poll():
                if (state := (bake.phase, bake.frames()[0])) != shown:
                    shown = state
                    print(f"Drench: {progress_text(bake)}", flush=True)
                time.sleep(0.05)
        except KeyboardInterrupt:
            bake.stop()
        return self.finish(context, bake)

    def invoke(self, context, _event):
        if in_background() or context.window is None:
            return self.execute(context)
        return self.attempt(context, self.wait_for_events)

    def wait_for_events(self, context):
        self.bake = self.start(context)
        self._timer = context.window_manager.event_timer_add(SECONDS_PER_LOOK, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        if self.bake.poll():
            redraw(context)
            return {"PASS_THROUGH"}
        context.window_manager.event_timer_remove(self._timer)
        playback.show(context.scene)
        return self.finish(context, self.bake)

    def cancel(self, _context):
        bakes.close()

    def finish(self, context, bake):
        playback.show(context.scene)
        done, total = bake.frames()
        lines = process.messages(bake.cache)
        context.scene.drench.messages = "\n".join(lines)
        redraw(context)
        if bake.status == "failed":
            self.report({"ERROR"}, bake.error)
            return {"CANCELLED"}
        self.report({"INFO"}, f"{done} of {total} frames are baked")
        return {"FINISHED"} if bake.status == "finished" else {"CANCELLED"}


class DRENCH_OT_bake(BakeOperator, bpy.types.Operator):
    """Simulate all frames. Without a window, for example in a script, it returns when the bake has ended"""
    bl_idname = "drench.bake"
    bl_label = "Bake"


class DRENCH_OT_resume(BakeOperator, bpy.types.Operator):
    """Continue a bake that was paused, cancelled or ended by a crash, with the scene that it was started with"""
    bl_idname = "drench.resume"
    bl_label = "Continue"
    resume = True


class DRENCH_OT_stop(Busy, Guarded, bpy.types.Operator):
    """Stop the bake after the current step and write a checkpoint. Continue takes it up again, also after a restart of
    Blender"""
    bl_idname = "drench.stop"
    bl_label = "Pause"
    wait: BoolProperty(name="Wait", default=False, description="Return when the process has ended")

    def run(self, _context):
        if self.wait:
            bakes.stop()
        else:
            bakes.current.ask_to_stop()
        return {"FINISHED"}


class DRENCH_OT_cancel(Busy, Guarded, bpy.types.Operator):
    """End the bake. The frames so far are kept, and Continue takes it up again"""
    bl_idname = "drench.cancel"
    bl_label = "Cancel"

    def run(self, _context):
        bakes.stop(process.SECONDS_TO_CLOSE)
        return {"FINISHED"}


class DRENCH_OT_write(Idle, Guarded, bpy.types.Operator):
    """Write the scene file and the meshes of a bake without running it, for example to run it on another computer"""
    bl_idname = "drench.write"
    bl_label = "Write Scene"

    def run(self, context):
        with cursor_progress(context) as progress:
            cache = bakes.write(context, progress)
        self.report({"INFO"}, f"{cache.folder / 'scene.yaml'} is written")
        return {"FINISHED"}


class DRENCH_OT_load(Idle, Guarded, bpy.types.Operator):
    """Show the bake in the cache folder, for example one that was run on another computer"""
    bl_idname = "drench.load"
    bl_label = "Load Bake"

    def run(self, context):
        cache = bakes.load(context)
        self.report({"INFO"}, f"{cache.frames_done()} of {cache.record()['frames']} frames are loaded")
        return {"FINISHED"}


class DRENCH_OT_delete_cache(Idle, Guarded, bpy.types.Operator):
    """Delete all files of the bake from the cache folder"""
    bl_idname = "drench.delete_cache"
    bl_label = "Delete Cache"

    def invoke(self, context, event):
        return context.window_manager.invoke_confirm(self, event)

    def run(self, context):
        existed, warning = bakes.delete(context)
        if warning:
            self.report({"WARNING"}, warning)
        self.report({"INFO"}, "the cache is deleted" if existed else "there is no cache to delete")
        return {"FINISHED"}


class DRENCH_OT_wet_look(Guarded, bpy.types.Operator):
    """Make the materials of this cloth darker and glossier where the cloth is wet"""
    bl_idname = "drench.wet_look"
    bl_label = "Add Wet Look"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return context.object is not None and context.object.drench.role == "CLOTH"

    def run(self, context):
        changed = materials.wet_cloth(context.object)
        self.report({"INFO"}, f"{changed} materials changed" if changed else
                    "no material has a Principled BSDF without the wet look")
        return {"FINISHED"}


CLASSES = (DRENCH_OT_check, DRENCH_OT_bake, DRENCH_OT_resume, DRENCH_OT_stop, DRENCH_OT_cancel, DRENCH_OT_write,
           DRENCH_OT_load, DRENCH_OT_delete_cache, DRENCH_OT_wet_look)


register, unregister = bpy.utils.register_classes_factory(CLASSES)
