"""Shapes of a signed distance, negative inside, and meshes of their surfaces. Lengths have any one unit."""

import math

from scene_files import add, bounds, dot, length, minus, times, turned_back, volume_of

MOST_CELLS = 400_000  # of the lattice of a mesh


class Sphere:
    def __init__(self, center, radius):
        self.center, self.radius = center, radius

    def distance(self, p):
        return math.dist(p, self.center) - self.radius

    def box(self):
        r = (self.radius,) * 3
        return minus(self.center, r), add(self.center, r)

    def volume(self):
        return 4 / 3 * math.pi * self.radius ** 3


class Turned:
    """A shape in axes of its own."""

    def __init__(self, center, matrix):
        self.center, self.matrix = center, matrix

    def distance(self, p):
        return self.own_distance(turned_back(self.matrix, minus(p, self.center)))

    def box(self):
        half = self.half_extent()
        size = tuple(sum(abs(self.matrix[r][k]) * half[k] for k in range(3)) for r in range(3))
        return minus(self.center, size), add(self.center, size)


class RoundedBox(Turned):
    """A box of half sides `half`, and everything within `radius` of it."""

    def __init__(self, center, matrix, half, radius):
        super().__init__(center, matrix)
        self.half, self.radius = half, radius

    def half_extent(self):
        return add(self.half, (self.radius,) * 3)

    def own_distance(self, p):
        d = tuple(abs(x) - h for x, h in zip(p, self.half))
        return min(max(d), 0.0) + math.sqrt(sum(max(x, 0.0) ** 2 for x in d)) - self.radius

    def volume(self):
        (a, b, c), r = times(self.half, 2), self.radius
        return a * b * c + 2 * (a * b + b * c + c * a) * r + (a + b + c) * math.pi * r * r + 4 / 3 * math.pi * r ** 3


class Capsule(Turned):
    """Along its x."""

    def __init__(self, center, matrix, radius, half_length):
        super().__init__(center, matrix)
        self.radius, self.half_length = radius, half_length

    def half_extent(self):
        return (self.half_length + self.radius, self.radius, self.radius)

    def own_distance(self, p):
        return length((max(abs(p[0]) - self.half_length, 0.0), p[1], p[2])) - self.radius

    def volume(self):
        return math.pi * self.radius ** 2 * (2 * self.half_length + 4 / 3 * self.radius)


class Cylinder(Turned):
    """Along its y; its rims are rounded by `corner`, and it ends `corner` beyond its half length."""

    def __init__(self, center, matrix, radius, corner, half_length):
        super().__init__(center, matrix)
        self.radius, self.corner, self.half_length = radius, corner, half_length

    def half_extent(self):
        return (self.radius, self.half_length + self.corner, self.radius)

    def own_distance(self, p):
        d = (math.hypot(p[0], p[2]) - self.radius + self.corner, abs(p[1]) - self.half_length)
        return min(max(d), 0.0) + math.hypot(max(d[0], 0.0), max(d[1], 0.0)) - self.corner

    def volume(self):
        a, c, h = self.radius - self.corner, self.corner, self.half_length
        return 2 * math.pi * self.radius ** 2 * h + 2 * math.pi * (a * a * c + a * math.pi / 2 * c * c + 2 / 3 * c ** 3)


class Inverse:
    def __init__(self, shape):
        self.shape = shape

    def distance(self, p):
        return -self.shape.distance(p)

    def box(self):
        return (-math.inf,) * 3, (math.inf,) * 3


class Union:
    def __init__(self, parts):
        self.parts = parts

    def distance(self, p):
        return min(part.distance(p) for part in self.parts)

    def box(self):
        low, high = zip(*(part.box() for part in self.parts))
        return tuple(map(min, zip(*low))), tuple(map(max, zip(*high)))


class Intersection:
    def __init__(self, parts):
        self.parts = parts

    def distance(self, p):
        return max(part.distance(p) for part in self.parts)

    def box(self):
        low, high = zip(*(part.box() for part in self.parts))
        return tuple(map(max, zip(*low))), tuple(map(min, zip(*high)))


def lattice_of(box, cell):
    """Corner, number of cells per axis and size of the lattice around a box; larger cells where there would be too many."""
    size = minus(box[1], box[0])
    while math.prod(math.ceil(s / cell) + 4 for s in size) > MOST_CELLS:
        cell *= 1.1
    counts = tuple(math.ceil(s / cell) + 4 for s in size)
    corner = tuple(low - (n * cell - s) / 2 for low, n, s in zip(box[0], counts, size))
    return corner, counts, cell


def surface(shape, cell):
    """Points and triangles, outward, of the closed surface of `shape`: one point in each cell of a lattice that the surface
    crosses (surface nets, Gibson 1998), moved onto the surface. [] where the lattice finds none."""
    corner, (nx, ny, nz), cell = lattice_of(shape.box(), cell)

    def place(i, j, k):
        return (corner[0] + i * cell, corner[1] + j * cell, corner[2] + k * cell)

    value = [[[shape.distance(place(i, j, k)) for k in range(nz + 1)] for j in range(ny + 1)] for i in range(nx + 1)]
    steps = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
    crossings, quads = {}, []  # sums per cell; four cells around each crossed edge
    for i in range(1, nx):
        for j in range(1, ny):
            for k in range(1, nz):
                v = value[i][j][k]
                for axis, (a, b, c) in enumerate(steps):
                    w = value[i + a][j + b][k + c]
                    if (v < 0) == (w < 0):
                        continue
                    s = v / (v - w)
                    point = place(i + a * s, j + b * s, k + c * s)
                    u, t = steps[(axis + 1) % 3], steps[(axis + 2) % 3]
                    around = [tuple(n - du * p - dt * q for n, du, dt in zip((i, j, k), u, t))
                              for p, q in ((1, 1), (0, 1), (0, 0), (1, 0))]
                    for own in around:
                        total = crossings.setdefault(own, [0.0, 0.0, 0.0, 0])
                        for axis_of_sum in range(3):
                            total[axis_of_sum] += point[axis_of_sum]
                        total[3] += 1
                    quads.append(around if v < 0 else around[::-1])
    numbers = {own: n for n, own in enumerate(crossings)}
    points = [on_surface(shape, (x / n, y / n, z / n), cell) for x, y, z, n in crossings.values()]
    triangles = []
    for a, b, c, d in ([numbers[own] for own in quad] for quad in quads):
        if math.dist(points[a], points[c]) <= math.dist(points[b], points[d]):
            triangles += [(a, b, c), (a, c, d)]
        else:
            triangles += [(b, c, d), (b, d, a)]
    return points, triangles


def on_surface(shape, p, cell):
    """Moves a point to distance 0, by at most half a cell, against the gradient."""
    start, e = p, 1e-4 * cell
    for _ in range(4):
        d = shape.distance(p)
        if abs(d) < 1e-7 * cell:
            break
        gradient = [(shape.distance(add(p, step)) - shape.distance(minus(p, step))) / (2 * e)
                    for step in ((e, 0, 0), (0, e, 0), (0, 0, e))]
        steepness = dot(gradient, gradient)
        if steepness < 0.25:
            break
        nearer = minus(p, times(gradient, d / steepness))
        if math.dist(nearer, start) > 0.5 * cell:
            break
        p = nearer
    return p


def scaled_to_volume(points, triangles, volume):
    """About the middle of its bounding box, by the little that its chords lose."""
    factor = (volume / volume_of(points, triangles)) ** (1 / 3)
    low, high = bounds(points)
    middle = times(add(low, high), 0.5)
    return [add(middle, times(minus(p, middle), factor)) for p in points]


def shell(shape, cell, thickness):
    """A closed mesh of a hollow body: a box around the shape, with the shape as a cavity."""
    inner, triangles = surface(shape, cell)
    low, high = shape.box()
    low, high = minus(low, (thickness,) * 3), add(high, (thickness,) * 3)
    corners = [tuple((low, high)[bit >> axis & 1][axis] for axis in range(3)) for bit in range(8)]
    faces = [(0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)]
    n = len(inner)
    outer = [t for a, b, c, d in faces for t in ((n + a, n + b, n + c), (n + a, n + c, n + d))]
    return inner + corners, [(a, c, b) for a, b, c in triangles] + outer
