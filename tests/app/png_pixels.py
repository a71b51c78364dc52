"""Reads the PNG files that drench writes: 8 bits a channel, RGB. For tests that shall need nothing but Python."""

import struct
import zlib


def read_png(path):
    """(width, height, rows), a row being bytes red, green, blue of each pixel."""
    with open(path, "rb") as file:
        data = file.read()
    if data[:8] != b"\x89PNG\r\n\x1a\n":
        raise ValueError("%s is no PNG file" % path)
    at, packed = 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + length]
        if kind == b"IHDR":
            width, height, depth, colour = struct.unpack(">IIBB", body[:10])
            if (depth, colour) != (8, 2):
                raise ValueError("%s is not 8-bit RGB" % path)
        elif kind == b"IDAT":
            packed += body
        at += length + 12
    raw, stride, rows = zlib.decompress(packed), 3 * width, []
    above = bytes(stride)
    for y in range(height):
        kind, line = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for i in range(stride if kind else 0):
            left, over = line[i - 3] if i >= 3 else 0, above[i]
            corner = above[i - 3] if i >= 3 else 0
            if kind == 4:
                guess = left + over - corner
                near = min((abs(guess - left), 0, left), (abs(guess - over), 1, over), (abs(guess - corner), 2, corner))[2]
            else:
                near = (left, over, (left + over) // 2)[kind - 1]
            line[i] = (line[i] + near) & 255
        above = bytes(line)
        rows.append(above)
    return width, height, rows


def share(path, is_so):
    """Part of the pixels whose (red, green, blue) are so."""
    width, height, rows = read_png(path)
    return sum(1 for row in rows for i in range(0, 3 * width, 3) if is_so(*row[i:i + 3])) / (width * height)
