"""Scene files and meshes as the program reads them. Does not need Blender."""

import json
import math
import re

import numpy as np


def _scalar(value):
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)  # unquoted, an object named "off" would be a switch
    if isinstance(value, float) and not math.isfinite(value):
        return ".nan" if math.isnan(value) else ".inf" if value > 0 else "-.inf"
    return repr(value)


def _flow(value):
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {_flow(entry)}" for key, entry in value.items()) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(_flow, value)) + "]"
    return _scalar(value)


def scene_text(scene):
    """A scene as YAML: a line per section, and a line per key of each cloth and body."""
    lines = []
    for section, value in scene.items():
        if isinstance(value, list) and value and isinstance(value[0], dict):
            lines.append(f"{section}:")
            for entry in value:
                keys = [f"{key}: {_flow(item)}" for key, item in entry.items()]
                lines += ["  - " + keys[0], *("    " + key for key in keys[1:])]
        else:
            lines.append(f"{section}: {_flow(value)}")
    return "\n".join(lines) + "\n"


def write_ply(path, points, triangles):
    """points: m, in the axes of the scene; float32, which is the precision of Blender's meshes.

    As in tools/export/mesh_files.py, which is not there where only the extension is installed."""
    corners = np.empty(len(triangles), [("count", "u1"), ("corners", "<i4", 3)])
    corners["count"], corners["corners"] = 3, triangles
    header = ("ply\nformat binary_little_endian 1.0\ncomment metres\n"
              f"element vertex {len(points)}\nproperty float x\nproperty float y\nproperty float z\n"
              f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n")
    path.write_bytes(header.encode() + np.ascontiguousarray(points, "<f4").tobytes() + corners.tobytes())


def file_name(prefix, number, name):
    """A name for files of an object, with letters that need no quoting on any system."""
    return f"{prefix}_{number}_" + re.sub(r"[^A-Za-z0-9]+", "_", name)[:40].strip("_")
