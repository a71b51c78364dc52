"""Reads drench's own frames: .pvd collections, and .vtu files with inline binary arrays that zlib compressed. Takes only the
arrays that are asked for, which is several times as fast as a general XML reader on a million particles."""

import binascii
import mmap
import re
import xml.etree.ElementTree as ElementTree
import zlib
from pathlib import Path

import numpy as np

TYPES = {"Float32": "<f4", "Float64": "<f8", "Int32": "<i4", "Int64": "<i8", "UInt8": "u1", "UInt32": "<u4",
         "UInt64": "<u8", "Int8": "i1"}


class FrameError(Exception):
    """A frame or a collection that cannot be read. One line."""


def read_collection(folder, series):
    """{time in s: [paths]} of `folder`/`series`.pvd, ascending; {} when the run has none."""
    path = Path(folder) / f"{series}.pvd"
    if not path.exists():
        return {}
    frames = {}
    try:
        for entry in ElementTree.parse(path).iter("DataSet"):
            frames.setdefault(float(entry.get("timestep")), []).append(Path(folder) / entry.get("file"))
    except (ElementTree.ParseError, TypeError, ValueError) as error:
        raise FrameError(f"{path}: cannot be read: {error}") from error
    return dict(sorted(frames.items()))


class Frame:
    """A .vtu file: `points` and `cells` in all, and arrays by name. Use it in a with statement."""

    def __init__(self, path):
        self.path = Path(path)
        try:
            with open(path, "rb") as file:
                self._text = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        except (OSError, ValueError) as error:
            raise FrameError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from error
        head = self._text[:4096].decode("ascii", "replace")
        whole = self._text[-64:].rstrip().endswith(b"</VTKFile>")
        piece = re.search(r'<Piece NumberOfPoints="(\d+)"\s+NumberOfCells="(\d+)"', head)
        if not whole or not piece or 'byte_order="LittleEndian"' not in head:
            self.close()
            raise FrameError(f"{path}: is not a complete frame of drench")
        self.points, self.cells = int(piece[1]), int(piece[2])
        self._wide = np.dtype("<u8" if 'header_type="UInt64"' in head else "<u4")
        self._compressed = 'compressor="vtkZLibDataCompressor"' in head
        self._places = self._find_arrays()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        self._text.close()

    def names(self):
        return set(self._places)

    def read(self, name):
        """The array `name` ("Points" for the positions), with one row a tuple where it has several components."""
        if name not in self._places:
            raise FrameError(f"{self.path}: has no array {name}")
        attributes, begin, end = self._places[name]
        dtype = TYPES.get(attributes["type"])
        if dtype is None or attributes.get("format") != "binary":
            raise FrameError(f"{self.path}: array {name} is not inline binary of a known type")
        try:
            values = np.frombuffer(self._decode(self._text[begin:end].strip()), dtype)
        except (binascii.Error, zlib.error, ValueError, IndexError) as error:
            raise FrameError(f"{self.path}: array {name} is damaged: {error}") from error
        components = int(attributes.get("NumberOfComponents", 1))
        return values.reshape(-1, components) if components > 1 else values

    def _find_arrays(self):
        """{name: (attributes, begin, end of its text)}; jumps over the text from tag to tag."""
        places, at, text = {}, 0, self._text
        while (at := text.find(b"<DataArray ", at)) >= 0:
            begin = text.find(b">", at) + 1
            attributes = dict(re.findall(r'(\w+)="([^"]*)"', text[at:begin].decode("ascii", "replace")))
            if text[begin - 2:begin] == b"/>":
                end = begin
            else:
                while text[begin:(end := text.find(b"<", begin))].isspace() and text[end:end + 5] == b"<Info":
                    begin = text.find(b"</InformationKey>", end) + len(b"</InformationKey>")  # some versions of VTK: first
            places.setdefault(attributes.get("Name", "Points"), (attributes, begin, end))
            at = end
        return places

    def _decode(self, text):
        """Base64 of a header (blocks, bytes of a block, of the last, compressed bytes of each) and, after it, of the blocks."""
        size = self._wide.itemsize
        if not text:
            return b""
        if not self._compressed:
            raw = binascii.a2b_base64(text)
            return raw[size:size + int(np.frombuffer(raw, self._wide, 1)[0])]
        first = np.frombuffer(binascii.a2b_base64(text[:4 * -(-3 * size // 3)]), self._wide, 3)
        blocks, full, last = (int(n) for n in first)
        if blocks == 0:
            return b""
        header_text = 4 * -(-(3 + blocks) * size // 3)
        sizes = np.frombuffer(binascii.a2b_base64(text[:header_text]), self._wide, blocks, 3 * size).tolist()
        raw = memoryview(binascii.a2b_base64(text[header_text:]))
        plain, at = [], 0
        for packed in sizes:
            plain.append(zlib.decompress(raw[at:at + packed]))
            at += packed
        whole = b"".join(plain)
        if len(whole) != (full * (blocks - 1) + last if last else full * blocks):
            raise ValueError("its length is not as its header says")
        return whole
