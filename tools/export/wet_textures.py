"""Wet maps of bodies as images in the bodies' texture coordinates: one OpenEXR file per body and frame."""

import struct
import zlib

import numpy as np

BORDER = 4  # pixels around each island of the texture that repeat its edge, so that filtering finds no seam
OUTSIDE = 1e-4  # of the square, by which coordinates may leave it


class Texture:
    """Which triangle lies under each pixel of a square image, and where in it."""

    def __init__(self, coordinates, corners, size):
        """`coordinates`: u and v of each corner; `corners`: the points of the same triangles, three each."""
        self.size = size
        uv, self.corners = coordinates.reshape(-1, 3, 2).astype(float), corners.reshape(-1, 3)
        inside = ((uv >= -OUTSIDE) & (uv <= 1 + OUTSIDE)).all((1, 2))
        self.outside = int((~inside).sum())
        places = np.stack([uv[..., 0] * size - 0.5, (1 - uv[..., 1]) * size - 0.5], -1)  # the first row is at v = 1
        pixels, triangles, weights = [], [], []
        for t in np.flatnonzero(inside):
            found, weight = self._pixels_of(places[t])
            pixels.append(found)
            weights.append(weight)
            triangles.append(np.full(len(found), t))
        self.triangle = np.concatenate(triangles) if triangles else np.zeros(0, int)
        self.weight = np.concatenate(weights) if weights else np.zeros((0, 3))
        self.source = self._with_borders(np.concatenate(pixels) if pixels else np.zeros(0, int))

    def _pixels_of(self, p):
        low = np.clip(np.ceil(p.min(0) - 1e-9), 0, self.size - 1).astype(int)
        high = np.clip(np.floor(p.max(0) + 1e-9), 0, self.size - 1).astype(int)
        x, y = np.meshgrid(np.arange(low[0], high[0] + 1), np.arange(low[1], high[1] + 1))
        x, y = x.ravel(), y.ravel()
        (ax, ay), (bx, by) = p[1] - p[0], p[2] - p[0]
        area = ax * by - ay * bx
        if area == 0 or len(x) == 0:
            return np.zeros(0, int), np.zeros((0, 3))
        b = ((x - p[0, 0]) * by - (y - p[0, 1]) * bx) / area
        c = ((y - p[0, 1]) * ax - (x - p[0, 0]) * ay) / area
        weight = np.stack([1 - b - c, b, c], 1)
        within = (weight >= -1e-9).all(1)
        return (y * self.size + x)[within], weight[within]

    def _with_borders(self, pixels):
        """Of each pixel the row of `triangle` and `weight` that it shows, −1 for none."""
        source = np.full((self.size, self.size), -1)
        source.ravel()[pixels] = np.arange(len(pixels))
        for _ in range(BORDER):
            before = source.copy()
            for axis, step in ((0, 1), (0, -1), (1, 1), (1, -1)):
                beside = np.roll(before, step, axis)
                edge = [slice(None), slice(None)]
                edge[axis] = 0 if step == 1 else -1
                beside[tuple(edge)] = -1  # no pixel is beside one of the opposite edge
                source = np.where((source < 0) & (beside >= 0), beside, source)
        return source

    def image(self, values):
        """Linear between the points' `values`, 0 beside the texture."""
        shown = (self.weight * values[self.corners[self.triangle]]).sum(1)
        return np.where(self.source >= 0, np.append(shown, 0.0)[self.source], 0.0).astype(np.float32)


def write_exr(path, channels):
    """{name: float32 image}, in blocks of 16 rows that are compressed as OpenEXR's ZIP."""
    names = sorted(channels)
    height, width = channels[names[0]].shape

    def attribute(name, kind, value):
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value

    listed = b"".join(n.encode() + b"\0" + struct.pack("<iB3xii", 2, 0, 1, 1) for n in names) + b"\0"
    window = struct.pack("<iiii", 0, 0, width - 1, height - 1)
    header = struct.pack("<ii", 20000630, 2) + b"".join((
        attribute("channels", "chlist", listed), attribute("compression", "compression", b"\x03"),
        attribute("dataWindow", "box2i", window), attribute("displayWindow", "box2i", window),
        attribute("lineOrder", "lineOrder", b"\0"), attribute("pixelAspectRatio", "float", struct.pack("<f", 1)),
        attribute("screenWindowCenter", "v2f", struct.pack("<ff", 0, 0)),
        attribute("screenWindowWidth", "float", struct.pack("<f", 1)))) + b"\0"
    blocks = []
    for first in range(0, height, 16):
        rows = np.stack([channels[n][first:first + 16].astype("<f4") for n in names], 1)  # channels of a row side by side
        raw = np.frombuffer(rows.tobytes(), np.uint8)
        apart = np.concatenate([raw[::2], raw[1::2]]).astype(np.int16)
        differences = np.concatenate([apart[:1], np.diff(apart) + 128]).astype(np.uint8)
        packed = zlib.compress(differences.tobytes(), 6)
        blocks.append(struct.pack("<i", first) + _sized(packed if len(packed) < len(raw) else raw.tobytes()))
    at = len(header) + 8 * len(blocks) + np.cumsum([0] + [len(b) for b in blocks[:-1]])
    path.write_bytes(header + b"".join(struct.pack("<Q", int(a)) for a in at) + b"".join(blocks))


def _sized(data):
    return struct.pack("<i", len(data)) + data
