"""What the readers of other programs' scenes share: the text of a drench scene, its mesh files, and the list of what the scene
cannot express. Needs no module besides Python's own."""

import argparse
import json
import math
import re
import struct
import sys
from pathlib import Path

from refusal import fail


def is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def number(x):
    """The shortest text that has ten digits of `x`."""
    if isinstance(x, int):
        return str(x)
    if not math.isfinite(x):
        return ".inf" if x > 0 else "-.inf"
    text = f"{x:.10g}"
    mantissa, e, exponent = text.partition("e")
    return f"{mantissa if '.' in mantissa else mantissa + '.0'}e{exponent}" if e else text  # YAML 1.1 needs the point


def flow(value):
    """One line of YAML."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {flow(v)}" for key, v in value.items()) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(flow(v) for v in value) + "]"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return number(value)
    plain = re.fullmatch(r"[A-Za-z_][\w./-]*", value, re.ASCII) and value not in ("true", "false", "on", "yes", "no", "null")
    return value if plain else json.dumps(value)  # `off` is a word of drench


def block(value, indent=0):
    """Lines of YAML: what fits in 110 columns in one line, the rest in blocks."""
    pad, lines = " " * indent, []
    items = value.items() if isinstance(value, dict) else (("-", v) for v in value)
    for key, v in items:
        head = f"{pad}-" if key == "-" else f"{pad}{key}:"
        text = f"{head} {flow(v)}"
        nested = isinstance(v, (dict, list, tuple)) and v and any(isinstance(w, (dict, list, tuple)) for w in
                                                                  (v.values() if isinstance(v, dict) else v))
        if not nested or len(text) <= 110 and key not in ("cloth", "bodies", "fluid"):
            lines.append(text)
        elif key == "-":
            inner = block(v, indent + 2)
            lines += [f"{pad}- {inner[0].lstrip()}", *inner[1:]]
        else:
            lines += [head, *block(v, indent + 2)]
    return lines


class Missing:
    """What of a scene the imported one does not express: names with their lines, under a reason."""

    def __init__(self):
        self.reasons = {}

    def add(self, reason, name, line=None):
        names = self.reasons.setdefault(reason, {})
        count, first = names.get(name, (0, line))
        names[name] = (count + 1, first)

    def lines(self):
        out = []
        for reason, names in self.reasons.items():
            told = [f"{name} (line {first}{f', {count} times' if count > 1 else ''})" if first else name
                    for name, (count, first) in names.items()]
            out.append(f"{', '.join(told)}: {reason}")
        return out


class Output:
    """The folder of an imported scene."""

    def __init__(self, source, folder):
        self.source, self.folder = source, folder or source.with_suffix("")
        self.name = source.stem
        self.meshes = 0
        if (self.folder / f"{self.name}.yaml").exists():
            fail(f"{self.folder / self.name}.yaml: exists; remove it, or choose another folder with -o")
        self.folder.mkdir(parents=True, exist_ok=True)

    def mesh(self, name, points, triangles):
        """Writes a mesh in metres; returns its name for the scene."""
        self.meshes += 1
        write_mesh(self.folder / f"{name}.ply", points, triangles)
        return f"{name}.ply"

    def particles(self, name, points, velocities, masses=None):
        self.meshes += 1
        write_particles(self.folder / f"{name}.ply", points, velocities, masses)
        return f"{name}.ply"

    def scene(self, program, scene, missing, comments=()):
        """Writes the scene and prints what became of the file."""
        path = self.folder / f"{self.name}.yaml"
        lost = missing.lines()
        head = [f"# Imported from {self.source.name} ({program}) by drench import.", *(f"# {line}" for line in comments)]
        if lost:
            head += ["# Not expressed:", *(f"# - {line}" for line in lost)]
        path.write_text("\n".join([*head, *block(scene)]) + "\n", encoding="utf-8")
        files = f" and {self.meshes} file{'s' if self.meshes > 1 else ''} of meshes and particles" if self.meshes else ""
        print(f"{path}: scene{files} from {self.source} ({program})")
        if lost:
            print("not expressed:")
            print("\n".join(f"  {line}" for line in lost))
        print(f"next: drench check {path}")


def write_mesh(path, points, triangles):
    header = ("ply\nformat binary_little_endian 1.0\ncomment metres\n"
              f"element vertex {len(points)}\nproperty double x\nproperty double y\nproperty double z\n"
              f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n")
    path.write_bytes(b"".join([header.encode(), *(struct.pack("<3d", *p) for p in points),
                               *(struct.pack("<B3i", 3, *t) for t in triangles)]))


def write_particles(path, points, velocities, masses):
    names = ["x", "y", "z", "vx", "vy", "vz"] + (["mass"] if masses else [])
    header = (f"ply\nformat binary_little_endian 1.0\ncomment metres\nelement vertex {len(points)}\n"
              + "".join(f"property double {name}\n" for name in names) + "end_header\n")
    rows = (struct.pack(f"<{len(names)}d", *p, *v, *((masses[k],) if masses else ()))
            for k, (p, v) in enumerate(zip(points, velocities)))
    path.write_bytes(b"".join([header.encode(), *rows]))


def read_obj(path, where):
    """Points and triangles (fans of the polygons) of an .obj file."""
    points, triangles = [], []
    try:
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        fail(f"{where}: {path}: cannot be read: {error.strerror}")
    for at, line in enumerate(text.splitlines(), 1):
        words = line.split()
        try:
            if words[:1] == ["v"]:
                points.append(tuple(float(w) for w in words[1:4]))
                if len(points[-1]) < 3:
                    raise ValueError
            elif words[:1] == ["f"]:
                corners = [int(w.split("/")[0]) for w in words[1:]]
                corners = [c - 1 if c > 0 else c + len(points) for c in corners]
                if min(corners) < 0 or max(corners) >= len(points):
                    raise ValueError
                triangles += [(corners[0], corners[k], corners[k + 1]) for k in range(1, len(corners) - 1)]
        except ValueError:
            fail(f"{path}:{at}: is not a line of an .obj file that can be read; export the mesh again")
    if not triangles:
        fail(f"{path}: holds no faces; {where} needs a mesh")
    return points, triangles


def find_file(name, source, where, more=()):
    """A file that a scene names, from the scene's folder, one above it, or the working folder."""
    places = [*more, source.parent, *source.resolve().parents, Path.cwd()]
    for place in places:
        if (place / name).is_file():
            return place / name
    fail(f"{where}: {name}: no such file; copy it to {source.parent / name}")


# Vectors and rotations.

def add(a, b):
    return tuple(x + y for x, y in zip(a, b))


def minus(a, b):
    return tuple(x - y for x, y in zip(a, b))


def times(a, s):
    return tuple(x * s for x in a)


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def length(a):
    return math.sqrt(dot(a, a))


def rotation(axis, angle):
    """Rows of the matrix that rotates by `angle` (rad) about `axis`; none about an axis of no length."""
    size = length(axis)
    if size == 0 or angle == 0:
        return ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    x, y, z = times(axis, 1 / size)
    c, s = math.cos(angle), math.sin(angle)
    d = 1 - c
    return ((c + x * x * d, x * y * d - z * s, x * z * d + y * s),
            (y * x * d + z * s, c + y * y * d, y * z * d - x * s),
            (z * x * d - y * s, z * y * d + x * s, c + z * z * d))


def turned(matrix, p):
    return tuple(dot(row, p) for row in matrix)


def turned_back(matrix, p):
    return tuple(sum(matrix[k][axis] * p[k] for k in range(3)) for axis in range(3))


def along_axes(matrix):
    """Does it take the axes to axes?"""
    return all(min(abs(x), abs(abs(x) - 1)) < 1e-9 for row in matrix for x in row)


def bounds(points):
    return tuple(map(min, zip(*points))), tuple(map(max, zip(*points)))


def volume_of(points, triangles):
    return sum(dot(points[a], cross(points[b], points[c])) for a, b, c in triangles) / 6


def run_reader(name, meaning, importer):
    """The program of a reader: `importer(file, folder).run()` writes the scene and prints what it cannot express."""
    parser = argparse.ArgumentParser(prog=name, description=meaning)
    parser.add_argument("file", type=Path)
    parser.add_argument("folder", type=Path, nargs="?")
    options = parser.parse_args()
    try:
        importer(options.file, options.folder).run()
        sys.stdout.flush()
    except BrokenPipeError:  # the reader of the list has seen enough; the scene is written
        sys.stderr.close()
    except OSError as error:
        fail(f"{error.filename or options.folder or options.file}: cannot be written: {error.strerror}")
