"""Reads the frames of a run with numpy: .pvd lists, and .vtu files with inline binary arrays. Does not need Blender.

The program writes a frame under a temporary name, renames it, and then adds it to the list. A frame that is listed is
therefore complete."""

import base64
import binascii
import re
import zlib
from pathlib import Path

import numpy as np

from .problem import Problem

TYPES = {"Float32": "<f4", "Float64": "<f8", "Int32": "<i4", "Int64": "<i8", "UInt8": "u1", "UInt32": "<u4",
         "UInt64": "<u8", "Int8": "i1"}
ENTRY = re.compile(r'<DataSet timestep="([^"]*)"[^>]*file="(frames/[^"]*_(\d+)\.vtu)"/>')
ARRAY = re.compile(rb"<DataArray ([^>]*?)(/?)>")
PIECE = re.compile(rb'<Piece NumberOfPoints="(\d+)"\s+NumberOfCells="(\d+)"')


def listed_frames(run, series):
    """{number: path} of the frames of `run`/`series`.pvd; {} if there is no such list yet."""
    path = Path(run) / f"{series}.pvd"
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        return {}
    except (OSError, UnicodeDecodeError) as error:
        raise Problem(f"{path}: cannot be read: {error}: bake again") from None
    return {int(number): Path(run) / file for _, file, number in ENTRY.findall(text)}


def _decode(text, word, compressed):
    """Base64 of a header (blocks, bytes per block, bytes of the last, packed bytes of each), then of the blocks."""
    size = word.itemsize
    if not text:
        return b""
    if not compressed:
        raw = base64.b64decode(text)
        return raw[size:size + int(np.frombuffer(raw, word, 1)[0])]
    blocks = int(np.frombuffer(base64.b64decode(text[:4 * -(-3 * size // 3)]), word, 1)[0])
    if blocks == 0:
        return b""
    length = 4 * -(-(3 + blocks) * size // 3)
    packed = np.frombuffer(base64.b64decode(text[:length]), word, blocks, 3 * size).tolist()
    raw, plain, at = memoryview(base64.b64decode(text[length:])), [], 0
    for count in packed:
        plain.append(zlib.decompress(raw[at:at + count]))
        at += count
    return b"".join(plain)


def read_frame(path, wanted):
    """{name: array} of those of the `wanted` arrays that the frame has; "Points" are the positions in m.

    Arrays of several components have one row per point or cell."""
    path = Path(path)
    try:
        text = path.read_bytes()
    except OSError as error:
        raise Problem(f"{path}: cannot be read: {error.strerror}: bake again") from None
    piece = PIECE.search(text, 0, 4096)
    if piece is None or not text.rstrip().endswith(b"</VTKFile>"):
        raise Problem(f"{path}: is not a complete frame: bake again")
    word = np.dtype("<u8" if b'header_type="UInt64"' in text[:piece.start()] else "<u4")
    compressed = b"vtkZLibDataCompressor" in text[:piece.start()]
    arrays, at = {}, piece.end()
    while (found := ARRAY.search(text, at)) is not None:
        at = found.end()
        attributes = dict(re.findall(r'(\w+)="([^"]*)"', found[1].decode("ascii", "replace")))
        name = attributes.get("Name", "Points")
        if name not in wanted or name in arrays:
            continue
        end = at if found[2] else text.index(b"<", at)
        try:
            while text[at:end].isspace() and text[end:end + 5] == b"<Info":  # some versions of VTK put details first
                at = text.index(b"</InformationKey>", end) + len(b"</InformationKey>")
                end = text.index(b"<", at)
            values = np.frombuffer(_decode(text[at:end].strip(), word, compressed), TYPES[attributes["type"]])
        except (binascii.Error, zlib.error, ValueError, IndexError, KeyError) as error:
            raise Problem(f"{path}: the array {name} is damaged ({error}): bake again") from None
        components = int(attributes.get("NumberOfComponents", 1))
        arrays[name] = values.reshape(-1, components) if components > 1 else values
    return arrays
