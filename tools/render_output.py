"""What tools/render writes: pictures, and animations of them."""

import os
import shutil
import subprocess
import sys

from vtkmodules.vtkIOImage import vtkPNGReader, vtkPNGWriter


def fail(message):
    print("tools/render: " + message, file=sys.stderr)
    sys.exit(2)


def save_picture(image, path):
    writer = vtkPNGWriter()
    writer.SetFileName(path)
    writer.SetInputData(image)
    writer.Write()
    if not os.path.exists(path):
        fail("%s: cannot be written" % path)


def check_animation(path):
    """Fails now, and not after an hour of drawing, if that kind of file cannot be written here."""
    kind = os.path.splitext(path)[1]
    try:
        if kind == ".ogv":
            import vtkmodules.vtkIOOggTheora  # noqa: F401
        elif kind == ".gif":
            import PIL.Image  # noqa: F401
        elif kind != ".mp4":
            fail("--animation %s: must end in .ogv, .gif or .mp4" % path)
        elif not shutil.which("ffmpeg"):
            fail("--animation %s: ffmpeg is not here: apt-get install ffmpeg, or write .ogv" % path)
    except ImportError as missing:
        fail("--animation %s: Python's module %s is not here%s" %
             (path, missing.name, ": apt-get install python3-pil, or write .ogv" if kind == ".gif" else ""))


def write_animation(path, pictures, fps):
    kind = os.path.splitext(path)[1]
    if kind == ".mp4":
        pattern = os.path.join(os.path.dirname(pictures[0]), "frame_%04d.png")
        command = ["ffmpeg", "-y", "-loglevel", "error", "-framerate", "%.6g" % fps, "-i", pattern, "-frames:v",
                   str(len(pictures)), "-pix_fmt", "yuv420p", "-vf", "crop=trunc(iw/2)*2:trunc(ih/2)*2", path]
        if subprocess.run(command).returncode != 0:
            fail("%s: ffmpeg failed" % path)
    elif kind == ".gif":
        from PIL import Image
        images = [Image.open(picture).convert("RGB") for picture in pictures]
        palette = images[len(images) // 2].quantize(128)  # one for all, so that colours do not flicker
        images = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]
        images[0].save(path, save_all=True, append_images=images[1:], duration=max(20, round(1000 / fps)), loop=0,
                       optimize=False)
    else:
        from vtkmodules.vtkIOOggTheora import vtkOggTheoraWriter
        writer = vtkOggTheoraWriter()
        writer.SetFileName(path)
        writer.SetRate(max(1, round(fps)))
        writer.SetQuality(2)
        for i, picture in enumerate(pictures):
            reader = vtkPNGReader()
            reader.SetFileName(picture)
            reader.Update()
            writer.SetInputData(reader.GetOutput())
            if i == 0:
                writer.Start()
            writer.Write()
        writer.End()
    if not os.path.exists(path) or os.path.getsize(path) == 0:
        fail("%s: cannot be written" % path)
