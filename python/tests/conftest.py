"""What the tests of the package share. DRENCH_PROGRAM names the command, for tests that compare with it."""

import os
import struct

import pytest

#: A block of water over a porous sheet that two pins hold and one jet hits, in a box, with a falling sphere.
SCENE = {
    "drench": 1,
    "time": {"step": 0.002, "end": 0.3},
    "domain": {"min": [-0.5, -0.5, -0.5], "max": [0.5, 0.5, 0.5]},
    "output": {"every": 0.02, "checkpoint_every": 1.0},
    "fluid": {
        "spacing": 0.02,
        "sources": [
            {"block": {"min": [-0.08, 0.03, -0.08], "max": [0.08, 0.15, 0.08]}},
            {"jet": {"center": [0.0, 0.3, 0.0], "radius": 0.03, "velocity": [0, -1, 0]}},
        ],
    },
    "cloth": [{
        "name": "sheet",
        "mesh": {"grid": {"size": [0.4, 0.4], "nodes": [17, 17]}},
        "pin": [{"box": {"min": [-0.21, -0.01, -0.21], "max": [-0.19, 0.01, 0.21]}},
                {"box": {"min": [0.19, -0.01, -0.21], "max": [0.21, 0.01, 0.21]}, "velocity": [0, 0.01, 0]}],
        "porous": {},
    }],
    "bodies": [{"box": {"min": [-0.4, -0.4, -0.4], "max": [0.4, 0.4, 0.4], "inside": True}},
               {"sphere": {"center": [0, -0.2, 0], "radius": 0.05, "dynamic": True, "density": 500}}],
}


@pytest.fixture
def scene():
    import copy
    return copy.deepcopy(SCENE)


@pytest.fixture
def program():
    path = os.environ.get("DRENCH_PROGRAM")
    if not path:
        pytest.skip("DRENCH_PROGRAM does not name the command")
    return path


def checkpoint_records(path):
    """name → bytes of each record of a checkpoint (src/output/checkpoint.hpp)."""
    with open(path, "rb") as file:
        data = file.read()
    at, end = data.index(b"\n") + 1, len(data) - 8
    records = {}
    while at < end:
        length, = struct.unpack_from("<I", data, at)
        name = data[at + 4:at + 4 + length].decode()
        at += 4 + length
        size, count = struct.unpack_from("<IQ", data, at)
        at += 12
        records[name] = data[at:at + size * count]
        at += size * count
    return records
