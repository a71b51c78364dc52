"""What `drench import` writes: PLY files of a mesh, and the lines of a scene that use them."""

import math
import re

import numpy as np

from refusal import fail

MOST_FILES = 100_000  # of a sequence
RIGID = 1e-5  # of a mesh's size: how far the points of a body's sequence may be from a turned and shifted copy


def fans(counts, corners):
    """Polygons as triangles around their first corner."""
    starts = np.cumsum(counts) - counts
    pieces = np.maximum(counts - 2, 0)
    first = np.repeat(starts, pieces)
    step = np.arange(pieces.sum()) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    return corners[np.stack([first, first + step + 1, first + step + 2], 1)]


def ears(points, normal):
    """n − 2 triangles of the corners of a polygon, by ear clipping in the plane of its normal, the best-shaped ear first."""
    axis = np.eye(3)[np.argmin(np.abs(normal))]
    u = np.cross(axis, normal) / np.linalg.norm(np.cross(axis, normal))
    flat = points @ np.stack([u, np.cross(normal / np.linalg.norm(normal), u)], 1)

    def area(a, b, c):
        return (flat[b, 0] - flat[a, 0]) * (flat[c, 1] - flat[a, 1]) - (flat[b, 1] - flat[a, 1]) * (flat[c, 0] - flat[a, 0])

    def quality(k):
        """perimeter²/area of the ear at place k; infinite if it is none."""
        a, b, c = left[k - 1], left[k], left[(k + 1) % len(left)]
        if area(a, b, c) <= 0:
            return math.inf
        if any(min(area(a, b, d), area(b, c, d), area(c, a, d)) >= 0 for d in left if d not in (a, b, c)):
            return math.inf
        sides = sum(np.linalg.norm(flat[i] - flat[j]) for i, j in ((a, b), (b, c), (c, a)))
        return sides * sides / area(a, b, c)

    left, found = list(range(len(points))), []
    while len(left) > 3:
        k = min(range(len(left)), key=quality)
        found.append((left[k - 1], left[k], left[(k + 1) % len(left)]))
        del left[k]
    return np.array([*found, left])


def triangulate(counts, corners, points):
    """n − 2 triangles of each polygon: around its first corner, or ears where one of those is turned over or has no area."""
    triangles = fans(counts, corners)
    polygon = np.repeat(np.arange(len(counts)), np.maximum(counts - 2, 0))
    a, b, c = (points[triangles[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    whole = np.zeros((len(counts), 3))
    np.add.at(whole, polygon, normal)
    for p in np.unique(polygon[np.einsum("ij,ij->i", normal, whole[polygon]) <= 0]):
        if counts[p] > 3 and whole[p].any():
            own = corners[counts[:p].sum():][:counts[p]]
            triangles[polygon == p] = own[ears(points[own], whole[p])]
    return triangles


def write_ply(path, points, triangles):
    corners = np.empty(len(triangles), [("count", "u1"), ("corners", "<i4", 3)])
    corners["count"], corners["corners"] = 3, triangles
    header = ("ply\nformat binary_little_endian 1.0\ncomment metres\n"
              f"element vertex {len(points)}\nproperty float x\nproperty float y\nproperty float z\n"
              f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n")
    path.write_bytes(header.encode() + np.ascontiguousarray(points, "<f4").tobytes() + corners.tobytes())


def distance_from_rigid(a, b):
    """m: how far b is from the turned and shifted copy of a that is nearest (Kabsch 1976)."""
    mean_a, mean_b = a.mean(0), b.mean(0)
    left, _, right = np.linalg.svd((a - mean_a).T @ (b - mean_b))
    turn = left @ np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))]) @ right
    return np.linalg.norm((a - mean_a) @ turn + mean_b - b, axis=1).max()


def merged_points(points):
    """How many are left where exact copies count once, as the scene's reader counts them."""
    return len(np.unique(points.astype(np.float32), axis=0))


def is_closed(triangles):
    """Does every edge have two triangles?"""
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    return bool((np.unique(edges, axis=0, return_counts=True)[1] == 2).all())


class MeshFiles:
    """The files of a mesh that has `triangles`, and goes through points(moment), in metres, at each of `moments`."""

    def __init__(self, folder, name, label, triangles, moments, points, described=str):
        self.folder, self.name = folder, name
        self.count, self.digits = len(moments), max(4, len(str(len(moments) - 1)))
        self.closed = is_closed(np.asarray(triangles))
        folder.mkdir(parents=True, exist_ok=True)
        self.first, off = points(moments[0]), 0.0
        size, count = np.linalg.norm(np.ptp(self.first, axis=0)), merged_points(self.first)
        for k, moment in enumerate(moments):
            now = points(moment)
            if merged_points(now) != count:
                fail(f"{label}: points lie in the same place at {described(moment)} and not at {described(moments[0])}, "
                     "or the other way round")
            off = max(off, distance_from_rigid(self.first, now))
            write_ply(self.path(k), now, triangles)
        self.off = off / size if size > 0 else 0.0
        later = re.compile(re.escape(name) + rf"_(\d{{{self.digits},}})\.ply")
        for path in folder.iterdir():  # of an import that had more: the scene would go on with them
            if (match := later.fullmatch(path.name)) and int(match[1]) >= self.count:
                path.unlink()

    def path(self, k):
        return self.folder / f"{self.name}_{k:0{self.digits}d}.ply"

    def pattern(self):
        return f"{self.folder / self.name}_{{:0{self.digits}d}}.ply"

    def names(self, fps):
        """The first file; of an animated mesh also the pattern of all, and how many there are per second."""
        return [str(self.path(0))] + ([self.pattern(), f"{fps:.9g}"] if self.count > 1 else [])

    def scene_lines(self, fps):
        """What a scene says to use the files."""
        first = f'"{self.path(0)}"'
        if self.count == 1:
            mesh = f"  - mesh: {{file: {first}}}"
            return ["bodies:", mesh, "# or, for a cloth:", "cloth:", mesh]
        files = f'sequence: "{self.pattern()}", fps: {fps:.9g}'
        if self.off <= RIGID or self.closed:
            changes = [] if self.off <= RIGID else ["# It changes its shape."]
            return [*changes, "bodies:", f"  - mesh: {{{files}}}"]
        points = self.first
        margin = 0.01 * np.linalg.norm(np.ptp(points, axis=0))
        low, high = (", ".join(f"{x:.6g}" for x in corner) for corner in (points.min(0) - margin, points.max(0) + margin))
        return ["# It changes its shape and is not closed: a cloth whose nodes in the box, here all, go where the files have them.",
                "cloth:", f"  - mesh: {{file: {first}}}", f"    pin: [{{box: {{min: [{low}], max: [{high}]}}, {files}}}]"]


def number_of_files(label, seconds, fps):
    files = math.floor(seconds * fps + 1e-6) + 1
    if files > MOST_FILES:
        fail(f"{label}: would be {files} files; allowed: up to {MOST_FILES}, which --fps decides")
    return max(files, 1)


def add_options(parser, mesh_meaning):
    from pathlib import Path

    parser.add_argument("file", type=Path)
    parser.add_argument("folder", type=Path, nargs="?", help="for the PLY files (default: the file's name without its extension)")
    parser.add_argument("--prim", help=mesh_meaning)
    parser.add_argument("--fps", type=float, help="files per second (default: rate of the file)")
    parser.add_argument("--first", action="store_true", help="print only the names of the PLY files and their rate")
    options = parser.parse_args()
    options.folder = options.folder or options.file.with_suffix("")
    return options


def named(paths, most=8):
    return ", ".join(str(path) for path in paths[:most]) + (f" and {len(paths) - most} more" if len(paths) > most else "")


def told(files, fps, triangles, what):
    count = "1 file" if files.count == 1 else f"{files.count} files at {fps:.6g} per second, {(files.count - 1) / fps:.6g} s"
    return f"{files.folder}: {count}, {len(files.first)} points, {len(triangles)} triangles of {what}"
