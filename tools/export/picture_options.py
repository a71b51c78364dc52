"""--size and --camera of pictures, as drench-view takes them: both read views.json, which lies beside this file."""

import json
import math
import os
import re

with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "views.json"), encoding="utf-8") as _file:
    _SAID = json.load(_file)

NAMED_VIEWS = _SAID["views"]  # azimuth, elevation, degrees
LEAST_SIDE, MOST_SIDE = _SAID["least_side"], _SAID["most_side"]  # pixels
NUMBER = r"\s*[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"


class OptionError(ValueError):
    """A text that is not allowed; the message says what is."""


def picture_size(text):
    """"900x600" → (900, 600)."""
    match = re.fullmatch(r"([0-9]{1,5})x([0-9]{1,5})", text)
    size = tuple(int(side) for side in match.groups()) if match else (0, 0)
    if min(size) < LEAST_SIDE or max(size) > MOST_SIDE:
        raise OptionError(f"{text} is not a size; allowed: WIDTHxHEIGHT of {LEAST_SIDE} to {MOST_SIDE} pixels")
    return size


def camera(text):
    """A name of NAMED_VIEWS as it is, or six numbers: position and focal point, m."""
    if text in NAMED_VIEWS:
        return text
    numbers = [float(x) for x in text.split(",")] if re.fullmatch(rf"{NUMBER}(?:\s*,{NUMBER}){{5}}", text) else []
    if not numbers or not all(map(math.isfinite, numbers)) or numbers[:3] == numbers[3:]:
        raise OptionError(f"{text} is not a view; allowed: {', '.join(NAMED_VIEWS)}, or px,py,pz,fx,fy,fz, in m")
    return tuple(numbers)
