"""A GIF of tools/render's pictures: render_gif.py PNGDIR COUNT RATE FILE. Needs python3-pil."""

import os
import sys

from PIL import Image

folder, count, rate, path = sys.argv[1], int(sys.argv[2]), float(sys.argv[3]), sys.argv[4]
images = [Image.open(os.path.join(folder, "frame_%04d.png" % i)).convert("RGB") for i in range(count)]
palette = images[len(images) // 2].quantize(128)  # one for all, so that colours do not flicker
images = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]
try:
    images[0].save(path, save_all=True, append_images=images[1:], duration=max(20, round(1000 / rate)), loop=0,
                   optimize=False)
except OSError as error:
    sys.exit("tools/render: %s: %s" % (path, error.strerror))
