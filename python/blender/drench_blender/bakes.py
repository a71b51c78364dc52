"""The bake of this Blender session: at most one runs at a time, and none outlives its file or its Blender."""

import atexit

import bpy
from bpy.app.handlers import persistent

from . import export, playback, preferences, process, program
from .problem import Names, Problem

current = None  # process.Bake
SECONDS_TO_CLOSE = 5


def running():
    return current is not None and current.status == "running"


def check(context, progress=lambda part: None):
    """Writes the scene into a folder of its own and checks it. Returns (valid, lines for the user)."""
    path = preferences.find_program(context)
    cache = playback.cache_of(context.scene)
    folder = cache.check_folder()
    try:
        record = _export(context, folder, progress)
        result = program.call(path, "check", "scene.yaml", seconds=600, cwd=folder)
    finally:
        cache.remove_check_folder()
    names = Names(**record["names"])
    lines = (result.stderr + "\n" + result.stdout).splitlines()
    messages = process.chosen_messages(lines, names)
    if result.returncode != 0:
        return False, messages or [f"{path} check ended with exit code {result.returncode}"]
    wanted = ("fluid: ", "cloth in all: ", "memory: ", "steps: ")
    return True, messages + [line for line in lines if line.startswith(wanted)]


def start(context, resume=False, progress=lambda part: None):
    """Starts a bake, or continues the last one with the scene that it was started with."""
    global current
    need_no_bake()
    path = preferences.find_program(context)
    program.version(path)
    cache = playback.cache_of(context.scene)
    if resume:
        record = cache.record()
        if record is None:
            raise Problem("there is no bake to continue: start a new one")
        if record.get("status") == "finished":
            raise Problem("the bake is complete: there is nothing to continue")
        process.end_left_over(cache)
        playback.connect(context.scene, record)
    else:
        write(context, progress)
    remember("Bake")
    current = process.Bake(path, cache, context.scene.drench.threads, resume)
    return current


def need_no_bake():
    if running():
        raise Problem("a bake is running: pause or cancel it first")


def write(context, progress=lambda part: None):
    """Replaces an earlier bake by the files of a new one, which no program has run yet. Returns its cache."""
    need_no_bake()
    cache = playback.cache_of(context.scene)
    folder = cache.check_folder()
    try:  # an error leaves the earlier bake as it is
        record = _export(context, folder, progress)
        process.end_left_over(cache)
        playback.clear(context.scene)
        cache.replace_by(folder, {**record, "status": "written"})
    finally:
        cache.remove_check_folder()
    playback.connect(context.scene, cache.record())
    return cache


def load(context):
    """Shows the bake in the cache folder, for example one that another computer has run. Returns its cache."""
    need_no_bake()
    cache = playback.cache_of(context.scene)
    record = cache.record()
    if record is None:
        raise Problem(f"{cache.folder} contains no bake: choose the folder with bake.json")
    if process.left_over(cache) is None and cache.frames_done() >= record["frames"] > 0:
        cache.set_status("finished", pid=None)
    playback.connect(context.scene, cache.record())
    remember("Load Bake")
    return cache


def remember(message):
    """An undo step. Otherwise undoing the step before would remove the objects that show the bake."""
    if bpy.ops.ed.undo_push.poll():
        bpy.ops.ed.undo_push(message=message)


def _export(context, folder, progress):
    """Playback is paused, because the export goes through all frames."""
    playback.paused = True
    try:
        return export.Exporter(context, folder, progress).write()
    finally:
        playback.paused = False


def stop(seconds=process.SECONDS_TO_STOP):
    """Ends a running bake, which can be continued. Returns when the process has ended."""
    if running():
        current.stop(seconds)


def delete(context):
    """Removes the frames and the files of the bake. Returns whether there were some."""
    need_no_bake()
    cache = playback.cache_of(context.scene)
    process.end_left_over(cache)
    playback.clear(context.scene)
    return cache.delete()


@persistent
def _on_load_pre(*_):
    stop(SECONDS_TO_CLOSE)


def _at_exit():
    stop(SECONDS_TO_CLOSE)


def register():
    bpy.app.handlers.load_pre.append(_on_load_pre)
    atexit.register(_at_exit)


def unregister():
    stop(SECONDS_TO_CLOSE)
    atexit.unregister(_at_exit)
    if _on_load_pre in bpy.app.handlers.load_pre:
        bpy.app.handlers.load_pre.remove(_on_load_pre)
