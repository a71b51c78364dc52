"""Writes a material of ARCSim (.json) as a fabric of drench. read_json.py calls it.

Stretching: six rows of c11, c12, c22, c33 in N/m, the first at rest, the others at a strain of 1/6 along 0°, 22.5°, 45°, 67.5° and 90°
from the texture's u axis. ARCSim doubles them (src/dde.cpp) and takes u for the first direction, which is drench's weft. Bending: three
rows, of edges along u, at 45° and along v, each at curvatures of 0, 10, 20, 30 and 40 1/m. Its energy of a hinge has a quarter of the
value as flexural rigidity (src/physics.cpp; Bridson et al. 2003)."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

from json_lines import read_json
from refusal import fail
from scene_files import Missing, flow, is_number, number

KEYS = {"density", "stretching", "bending"}
LEAST_STRETCHING = 5e-4  # N/m, half of what a membrane in drench has at least
# Of fabrics, with room on both sides; and the largest values of the keys in drench, in the file's terms.
USUAL = {"density": (0.005, 20.0), "stretching": (0.0, 1e6), "bending": (0.0, 1.0)}
LARGEST = {"density": 1000.0, "stretching": 5e8, "bending": 4e6}
LEAST_DENSITY = 1e-4
UNITS = {"density": "kg/m²", "stretching": "N/m", "bending": "N·m"}
ROWS = {"stretching": (6, 4), "bending": (3, 5)}


def is_material(data):
    return isinstance(data, dict) and bool({"stretching", "bending"} & data.keys())


class Importer:
    def __init__(self, source, folder):
        self.source, self.folder = source, folder or source.with_suffix("")
        self.data, self.missing = read_json(source), Missing()
        density = self.data.get("density")
        if not is_number(density) or density <= 0:
            fail(f"{source}:{self.data.lines.get('density', self.data.line)}: density: is not a number above 0, in kg/m²; correct it")
        if density < LEAST_DENSITY:
            fail(f"{source}:{self.data.lines['density']}: density: is {density:g}; "
                 f"allowed: at least {LEAST_DENSITY:g} kg/m²")
        self.density = float(density)
        self.stretching, self.bending = self.table("stretching"), self.table("bending")
        for name, value in (("c11", self.stretching[0][0]), ("c22", self.stretching[0][2])):
            if value < LEAST_STRETCHING:
                fail(f"{source}:{self.data['stretching'].lines[0]}: stretching[0]: {name} is {value:g}; "
                     f"allowed: at least {LEAST_STRETCHING:g} N/m")
        self.check_size("density", self.density)
        for key, rows in (("stretching", self.stretching[:1]), ("bending", [row[:1] for row in self.bending])):
            self.check_size(key, max(max(row) for row in rows))
        for key, line in self.data.repeated.items():
            self.missing.add("it stands there twice; the last value counts, as in ARCSim", key, line)
        for key in self.data:
            if key not in KEYS:
                self.missing.add("it is no key of ARCSim's material files", key, self.data.lines[key])

    def check_size(self, key, value):
        """Numbers in another unit would pass otherwise."""
        place, unit = f"{self.source}:{self.data.lines[key]}: {key}", UNITS[key]
        if value > LARGEST[key]:
            fail(f"{place}: has {value:g}; allowed: at most {LARGEST[key]:g} {unit}")
        least, most = USUAL[key]
        if not least <= value <= most:
            hint = f" ({value:g} g/m² are {value / 1000:g})" if key == "density" and value > most else ""
            compared = "more" if value > most else "less"
            print(f"warning: {place} has {value:g}, {compared} than any fabric; the unit is {unit}{hint}",
                  file=sys.stderr)

    def table(self, key):
        rows, columns = ROWS[key]
        if key not in self.data:
            fail(f"{self.source}:{self.data.line}: {key}: is missing; "
                 "a material of ARCSim has density, stretching and bending")
        data = self.data[key]
        if not isinstance(data, list) or len(data) != rows:
            fail(f"{self.source}:{self.data.lines[key]}: {key}: is not a list of {rows} rows; correct it")
        for k, row in enumerate(data):
            if not isinstance(row, list) or len(row) != columns or not all(map(is_number, row)):
                fail(f"{self.source}:{data.lines[k]}: {key}[{k}]: is not a list of {columns} numbers; correct it")
        return [[float(x) for x in row] for row in data]

    @staticmethod
    def membrane(weft, warp, shear):
        """ARCSim replaces negative coefficients by 0."""
        return {"warp": 2 * max(0.0, warp), "weft": 2 * max(0.0, weft), "shear": max(0.0, shear)}

    def plate(self):
        warp, bias, weft = (max(0.0, row[0]) / 4 for row in self.bending)
        twist = 2 * bias - (warp + weft) / 2
        if twist < 0:
            self.missing.add("cloth that is this limp along the bias; twist is 0", "bending", self.data.lines["bending"])
        return {"warp": warp, "weft": weft, "twist": max(0.0, twist)}

    def run(self):
        rest, stretched = self.stretching[0], self.stretching
        plate = self.plate()
        if rest[3] < 0:
            self.missing.add("negative shear counts as 0, as in ARCSim", "stretching", self.data.lines["stretching"])
        if rest[1] > 0:
            self.missing.add(f"c12 = {number(rest[1])}: cloth in drench does not narrow as it is stretched", "stretching",
                             self.data.lines["stretching"])
        if any(row != rest for row in stretched[1:]):
            along = self.membrane(stretched[1][0], stretched[5][2], stretched[3][3])
            self.missing.add("stiffness at larger strains; drench uses that at rest. At a strain of 17 %: "
                             + ", ".join(f"{key} {value:.4g} N/m" for key, value in along.items()), "stretching",
                             self.data.lines["stretching"])
        if any(x != row[0] for row in self.bending for x in row):
            self.missing.add("bending at larger curvatures; drench uses that of flat cloth", "bending", self.data.lines["bending"])
        if any(row[0] < 0 for row in self.bending):
            self.missing.add("negative bending counts as 0, as in ARCSim", "bending", self.data.lines["bending"])
        lines = [f"# Imported from {self.source.name} (a material of ARCSim) by drench import."]
        lost = self.missing.lines()
        if lost:
            lines += ["# Not expressed:", *(f"# - {line}" for line in lost)]
        rounded = {key: {k: float(f"{v:.4g}") for k, v in values.items()}
                   for key, values in (("membrane", self.membrane(rest[0], rest[2], rest[3])), ("bending", plate))}
        lines += [f"about: {flow(self.source.stem + ', a material of ARCSim')}",
                  f"areal_density: {number(self.density)}   # kg/m²",
                  f"membrane: {flow(rounded['membrane'])}   # N/m",
                  f"bending: {flow(rounded['bending'])}   # N·m"]
        self.folder.mkdir(parents=True, exist_ok=True)
        path = self.folder / f"{self.source.stem}.yaml"
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
        print(f"{path}: fabric from {self.source} (ARCSim)")
        if lost:
            print("not expressed:")
            print("\n".join(f"  {line}" for line in lost))
        print(f"next: write fabric: {path} in a cloth of your scene; the file has no thickness and nothing about liquid")
