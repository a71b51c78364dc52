"""Particles of Houdini's classic .bgeo files (version 5), plain or gzipped, which SPlisHSPlasH reads by Partio."""

import gzip
import struct
import zlib

from refusal import fail

FLOAT, INTEGER, VECTOR = 0, 1, 5


class Cursor:
    def __init__(self, data):
        self.data, self.at = data, 0

    def take(self, form):
        values = struct.unpack_from(">" + form, self.data, self.at)
        self.at += struct.calcsize(">" + form)
        return values


def read_bgeo(path, where):
    """Positions and velocities; no velocities where the file has none."""
    try:
        data = path.read_bytes()
        if data[:2] == b"\x1f\x8b":
            data = gzip.decompress(data)
        return parse(data, path, where)
    except (OSError, EOFError, zlib.error) as error:
        fail(f"{where}: {path}: cannot be read: {getattr(error, 'strerror', None) or error}")
    except (struct.error, UnicodeDecodeError):
        fail(f"{where}: {path}: ends early or is damaged; write it again")


def parse(data, path, where):
    cursor = Cursor(data)
    magic, kind, version, count = cursor.take("4scii")
    if magic != b"Bgeo" or kind != b"V" or version != 5:
        fail(f"{where}: {path}: is not a .bgeo file of version 5; convert it to .ply with x, y and z")
    *_, attributes, _, _, _ = cursor.take("7i")  # groups, then attributes of points, vertices, primitives, the whole
    at, size = {}, 4
    for _ in range(attributes):
        name = cursor.take(f"{cursor.take('H')[0]}s")[0].decode()
        numbers, kind = cursor.take("Hi")
        if kind == 4:  # text, stored as numbers
            for _ in range(cursor.take("i")[0]):
                cursor.take(f"{cursor.take('H')[0]}s")
            numbers_here = numbers
        elif kind in (FLOAT, INTEGER, VECTOR):
            cursor.take(f"{numbers}i")
            numbers_here = numbers
        else:
            fail(f"{where}: {path}: its attribute {name} is of a kind that drench does not read; convert it to .ply with x, y and z")
        at[name], size = (size, numbers, kind), size + numbers_here
    start, stride = cursor.at, 4 * size
    if start + count * stride > len(data):
        raise struct.error
    positions = [struct.unpack_from(">3f", data, start + k * stride) for k in range(count)]
    velocity = at.get("v") or at.get("velocity")
    if velocity is None or velocity[1] != 3 or velocity[2] == INTEGER:
        return positions, None
    return positions, [struct.unpack_from(">3f", data, start + k * stride + 4 * velocity[0]) for k in range(count)]
