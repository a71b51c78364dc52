#!/usr/bin/env python3
"""make_shirt.py [FOLDER [ROWS]]: writes shirt.obj, a sleeveless shirt with a V-neck, and form.obj, the dress form that wears it.

The shirt is open where a shirt is: two sheets of ROWS x COLUMNS squares, front and back. Below the armholes they share
their side edges, so that they make a tube; at the shoulders they share the tops of the straps. The form is closed, as a
solid has to be. Lengths are in metres, x points to the side, y up and z to the front; the hem is at y = 0."""

import math
import sys
from pathlib import Path

ROWS = int(sys.argv[2]) if len(sys.argv) > 2 else 30  # of squares in a sheet; a multiple of 5
COLUMNS = ROWS * 4 // 5
HEIGHT = 0.60                             # from hem to shoulder
HEM, CHEST, SHOULDER = 0.25, 0.22, 0.155  # half the width
DEPTH = 0.11                              # half the depth of the tube
ARMPIT = ROWS * 3 // 5                    # the row at which the armholes begin
NECK = {+1: 0.16, -1: 0.06}               # depth of the neckline: front, back
STRAP = 0.60                              # the straps begin at this part of half the width

# The form's cross-sections are ellipses: height, half the width, half the depth.
FORM = ((-0.08, 0.150, 0.070), (0.00, 0.170, 0.085), (0.12, 0.165, 0.080), (0.24, 0.160, 0.076), (0.34, 0.175, 0.080),
        (0.42, 0.175, 0.072), (0.48, 0.165, 0.058), (0.52, 0.148, 0.047), (0.55, 0.115, 0.042), (0.57, 0.075, 0.041),
        (0.60, 0.052, 0.042), (0.68, 0.048, 0.044))
AROUND = 40                               # points of a cross-section


def shirt_point(side, row, column):
    """Where a point of the front (side = 1) or of the back (side = -1) lies."""
    across = 1 - 2 * column / COLUMNS  # 1 to -1, from one seam to the other
    sine, cosine = math.sin(math.pi * column / COLUMNS), math.cos(math.pi * column / COLUMNS)
    neckline = NECK[side] * max(0, 1 - abs(across) / STRAP) ** 1.2
    y = (HEIGHT - neckline) * row / ROWS
    height = y / HEIGHT                                          # 0 at the hem, 1 at the shoulder
    up = max(0, (height - ARMPIT / ROWS) / (1 - ARMPIT / ROWS))  # 0 at the armpit, 1 at the shoulder
    width = HEM + (CHEST - HEM) * min(1, height * ROWS / ARMPIT) + (SHOULDER - CHEST) * up ** 0.6
    x = width * ((1 - height) * cosine + height * across)
    opening = sine + (0.6 - sine) * up ** 0.7                    # the edges of the armholes come apart
    return x, y, side * DEPTH * math.sqrt(1 - min(1, up) ** 2) * opening


def sewn(row, column):
    """Is there one point for front and back?"""
    at_side = column in (0, COLUMNS) and row <= ARMPIT
    at_shoulder = row == ROWS and abs(1 - 2 * column / COLUMNS) >= STRAP
    return at_side or at_shoulder


def shirt():
    numbers, points, triangles = {}, [], []

    def number(side, row, column):
        key = (0 if sewn(row, column) else side, row, column)
        if key not in numbers:
            points.append(shirt_point(side, row, column))
            numbers[key] = len(points)
        return numbers[key]

    for side in (1, -1):
        for row in range(ROWS):
            for column in range(COLUMNS):
                a, b = number(side, row, column), number(side, row, column + 1)
                c, d = number(side, row + 1, column + 1), number(side, row + 1, column)
                halves = [(a, b, c), (a, c, d)] if (row + column) % 2 else [(a, b, d), (b, c, d)]
                triangles += halves if side < 0 else [half[::-1] for half in halves]  # normals point outwards
    return points, triangles


def form():
    points, triangles = [], []
    for y, width, depth in FORM:
        for k in range(AROUND):
            angle = 2 * math.pi * k / AROUND
            points.append((width * math.cos(angle), y, depth * math.sin(angle)))
    points += [(0, FORM[0][0], 0), (0, FORM[-1][0], 0)]
    bottom, top, last = len(points) - 1, len(points), (len(FORM) - 1) * AROUND
    for k in range(AROUND):
        following = (k + 1) % AROUND
        for row in range(0, last, AROUND):
            a, b, c, d = row + k + 1, row + following + 1, row + AROUND + following + 1, row + AROUND + k + 1
            triangles += [(a, c, b), (a, d, c)]
        triangles += [(bottom, k + 1, following + 1), (top, last + following + 1, last + k + 1)]
    return points, triangles


def write(path, mesh):
    points, triangles = mesh
    with path.open("w", encoding="utf-8") as file:
        file.writelines("v %.5f %.5f %.5f\n" % point for point in points)
        file.writelines("f %d %d %d\n" % triangle for triangle in triangles)
    print("%s: %d points, %d triangles" % (path, len(points), len(triangles)))


def main():
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    folder.mkdir(parents=True, exist_ok=True)
    write(folder / "shirt.obj", shirt())
    write(folder / "form.obj", form())


main()
