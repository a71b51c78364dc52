"""A film of pictures: film.py RATE FILE PNG…; film.py --check FILE says what is missing for it. A .gif or a .webp needs python3-pil,
an .mp4 ffmpeg. tools/render starts it. Exit code 2 with one line where it cannot be written."""

import os
import shutil
import subprocess
import sys
import tempfile


def fail(message):
    print("tools/render: " + message, file=sys.stderr)
    sys.exit(2)


def check(path):
    ending = os.path.splitext(path)[1]
    if ending == ".mp4":
        if not shutil.which("ffmpeg"):
            fail("--animation %s: ffmpeg is missing: apt-get install ffmpeg" % path)
    elif ending in (".gif", ".webp"):
        try:
            import PIL.Image  # noqa: F401
        except ImportError:
            fail("--animation %s: Python's PIL is missing: apt-get install python3-pil" % path)
    else:
        fail("--animation %s: must end in .gif, .webp or .mp4, and without --cycles also .ogv" % path)


def join_by_pil(rate, path, pictures):
    from PIL import Image
    images = [Image.open(picture).convert("RGB") for picture in pictures]
    options = {"save_all": True, "duration": max(20, round(1000 / rate)), "loop": 0}
    if path.endswith(".webp"):
        options.update(quality=82, method=6)
    else:
        palette = images[len(images) // 2].quantize(128)  # one for all, so that colours do not flicker
        images = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]
        options["optimize"] = False
    try:
        images[0].save(path, append_images=images[1:], **options)
    except OSError as error:
        fail("%s: %s" % (path, error.strerror or error))


def join_by_ffmpeg(rate, path, pictures):
    with tempfile.TemporaryDirectory() as folder:
        for k, picture in enumerate(pictures):
            os.symlink(os.path.abspath(picture), os.path.join(folder, "%06d.png" % k))
        words = ["ffmpeg", "-y", "-loglevel", "error", "-framerate", "%g" % rate, "-i", os.path.join(folder, "%06d.png"), "-pix_fmt", "yuv420p",
                 "-vf", "crop=trunc(iw/2)*2:trunc(ih/2)*2", path]
        if subprocess.run(words, check=False).returncode:
            fail("%s: ffmpeg failed" % path)


def main():
    if sys.argv[1] == "--check":
        return check(sys.argv[2])
    rate, path, pictures = float(sys.argv[1]), sys.argv[2], sys.argv[3:]
    (join_by_ffmpeg if path.endswith(".mp4") else join_by_pil)(rate, path, pictures)
    print("animation: " + path)
    return None


main()
