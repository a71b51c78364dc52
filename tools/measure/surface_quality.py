"""The liquid's surface by several methods, measured: called by tools/measure/surface_quality."""

import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pysplashsurf

FIELDS = "frame | particles | surface | time, 1 thread | 2 threads | triangles | angle, median | RMS | height | volume | drops"


def spacing_of(run):
    lines = (Path(run) / "scene.yaml").read_text().splitlines()
    return next(float(line.split("#")[0].split(":")[1]) for line in lines if line.strip().startswith("spacing:"))


def by_drench(bench, run, frame, kernel, threads, repeats):
    """Time (s), points, triangles and particles (x, y, z, volume)."""
    with tempfile.TemporaryDirectory() as folder:
        said = subprocess.run([bench, run, frame, kernel, str(threads), str(repeats), folder], capture_output=True, text=True)
        if said.returncode:
            sys.exit(said.stderr.strip())
        raw = {name: np.fromfile(Path(folder) / name, kind)
               for name, kind in (("points", "f8"), ("triangles", "i4"), ("particles", "f8"))}
    return float(said.stdout), raw["points"].reshape(-1, 3), raw["triangles"].reshape(-1, 3), raw["particles"].reshape(-1, 4)


def by_splashsurf(particles, d, smooth, multi, repeats):
    """As its README recommends: l = 2 and t = 0.6, weighted Laplacian smoothing in 25 rounds; cubes of half a spacing."""
    more = {"mesh_cleanup": True, "mesh_smoothing_weights": True, "mesh_smoothing_iters": 25} if smooth else {}
    best = 1e9
    for _ in range(repeats):
        begin = time.perf_counter()
        made = pysplashsurf.reconstruction_pipeline(
            np.ascontiguousarray(particles[:, :3], np.float32), particle_radius=d / 2, smoothing_length=2.0, cube_size=1.0,
            iso_surface_threshold=0.6, multi_threading=multi, compute_normals=True, **more)
        best = min(best, time.perf_counter() - begin)
    mesh = (made[0] if isinstance(made, tuple) else made).mesh
    return best, np.asarray(mesh.vertices, float), np.asarray(mesh.triangles, np.int64)


def normals_of(points, triangles):
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return np.cross(b - a, c - a)


def volume_of(points, triangles):
    return float(np.einsum("ij,ij->", points[triangles[:, 0]], normals_of(points, triangles))) / 6


def roughness_of(points, triangles):
    """Degrees: median and RMS angle between the normals of triangles that share an edge."""
    normals = normals_of(points, triangles)
    length = np.linalg.norm(normals, axis=1)
    good = length > 1e-12 * length.max()
    normals = normals[good] / length[good, None]
    triangles = triangles[good]
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    owner = np.tile(np.arange(len(triangles)), 3)
    order = np.lexsort((edges[:, 1], edges[:, 0]))
    edges, owner = edges[order], owner[order]
    pair = np.nonzero((edges[1:] == edges[:-1]).all(axis=1))[0]
    cosine = np.einsum("ij,ij->i", normals[owner[pair]], normals[owner[pair + 1]])
    angle = np.degrees(np.arccos(np.clip(cosine, -1, 1)))
    return float(np.median(angle)), float(np.sqrt(np.mean(angle ** 2)))


def height_of(points, particles, d):
    """RMS distance to the plane of least squares, in spacings, of a level top; None where the liquid has none."""
    low, high = particles[:, :3].min(axis=0), particles[:, :3].max(axis=0)
    inside = ((points[:, [0, 2]] > low[[0, 2]] + 4 * d) & (points[:, [0, 2]] < high[[0, 2]] - 4 * d)).all(axis=1)
    top = points[inside & (points[:, 1] > low[1] + 2 * d)]
    if len(top) < 100 or np.ptp(top[:, 1]) > 2 * d:
        return None
    plane = np.c_[top[:, [0, 2]], np.ones(len(top))]
    fit, *_ = np.linalg.lstsq(plane, top[:, 1], rcond=None)
    return float(np.sqrt(np.mean((top[:, 1] - plane @ fit) ** 2))) / d


def lone_drops(particles, d):
    """Places of particles that have no other within two spacings."""
    cells = {}
    x = particles[:, :3]
    index = np.floor(x / (2 * d)).astype(int)
    for i, cell in enumerate(map(tuple, index)):
        cells.setdefault(cell, []).append(i)
    steps = [(a, b, c) for a in (-1, 0, 1) for b in (-1, 0, 1) for c in (-1, 0, 1)]

    def alone(i):
        near = [j for s in steps for j in cells.get(tuple(index[i] + s), ()) if j != i]
        return not near or np.min(np.sum((x[near] - x[i]) ** 2, axis=1)) > 4 * d * d
    return x[[i for i in range(len(x)) if alone(i)]]


def kept(drops, points, d):
    return sum(bool((np.sum((points - drop) ** 2, axis=1) < d * d).any()) for drop in drops)


def row(name, count, method, times, points, triangles, particles, drops, d):
    height = height_of(points, particles, d)
    median, rms = roughness_of(points, triangles)
    error = 100 * (volume_of(points, triangles) / particles[:, 3].sum() - 1)
    print("|", " | ".join([name, str(count), method, *(f"{t:.2f} s" for t in times), str(len(triangles)),
                           f"{median:.1f}°", f"{rms:.1f}°", "" if height is None else f"{height:.3f} d",
                           f"{error:+.1f} %", f"{kept(drops, points, d)} of {len(drops)}"]), "|", flush=True)


def main():
    ask = argparse.ArgumentParser(prog="surface_quality")
    ask.add_argument("bench")
    ask.add_argument("frames", nargs="+", metavar="RUN:FRAME")
    ask.add_argument("--repeats", type=int, default=3)
    asked = ask.parse_args()
    print("|", FIELDS, "|\n|" + "---|" * len(FIELDS.split("|")))
    for word in asked.frames:
        run, _, frame = word.rpartition(":")
        if not frame.isdigit() or not (Path(run) / "scene.yaml").is_file():
            sys.exit(f"surface_quality: {word}: allowed: the folder of a run, a colon and the number of a frame")
        d = spacing_of(run)
        name, drops = f"{Path(run).name} {frame}", None
        for kernel in ("isotropic", "anisotropic"):
            made = [by_drench(asked.bench, run, frame, kernel, threads, asked.repeats) for threads in (1, 2)]
            _, points, triangles, particles = made[0]
            if not (np.array_equal(points, made[1][1]) and np.array_equal(triangles, made[1][2])):
                sys.exit(f"surface_quality: {word}: one thread and two make other surfaces")
            drops = lone_drops(particles, d) if drops is None else drops
            row(name, len(particles), kernel, [m[0] for m in made], points, triangles, particles, drops, d)
        for method, smooth in (("splashsurf, not smoothed", False), ("splashsurf", True)):
            made = [by_splashsurf(particles, d, smooth, multi, asked.repeats) for multi in (False, True)]
            row(name, len(particles), method, [m[0] for m in made], *made[0][1:], particles, drops, d)


main()
