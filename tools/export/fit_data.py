"""Measured curves for `drench fit`: CSV files whose header names quantities and units."""

import csv
import math
import re

import numpy

import fit_strip
from refusal import fail

# dimension and factor to the SI unit
UNITS = {
    "mm": ("length", 1e-3), "cm": ("length", 1e-2), "m": ("length", 1.0), "um": ("length", 1e-6), "in": ("length", 0.0254),
    "s": ("time", 1.0), "min": ("time", 60.0), "h": ("time", 3600.0),
    "g": ("mass", 1e-3), "mg": ("mass", 1e-6), "kg": ("mass", 1.0),
    "mm2": ("area", 1e-6), "cm2": ("area", 1e-4), "m2": ("area", 1.0),
    "N": ("force", 1.0), "mN": ("force", 1e-3), "cN": ("force", 1e-2), "kN": ("force", 1e3),
    "N/m": ("force per width", 1.0), "N/cm": ("force per width", 1e2), "N/mm": ("force per width", 1e3),
    "kN/m": ("force per width", 1e3),
    "Pa": ("pressure", 1.0), "kPa": ("pressure", 1e3), "mbar": ("pressure", 100.0),
    "N m": ("rigidity", 1.0), "uN m": ("rigidity", 1e-6), "mN cm": ("rigidity", 1e-5),
    "g/h": ("mass rate", 1e-3 / 3600), "g/min": ("mass rate", 1e-3 / 60), "mL/h": ("mass rate", 1e-3 / 3600),
    "%": ("ratio", 0.01), "1": ("ratio", 1.0),
}

# names in a header that mean the same
SYNONYMS = {
    "wicking height": "height", "wicking distance": "height", "rise": "height",
    "absorbed water": "mass", "absorbed mass": "mass", "water": "mass", "uptake": "mass", "residual water": "mass", "residual mass": "mass",
    "drop area": "area", "wet area": "area", "spot area": "area", "wet diameter": "diameter", "spot diameter": "diameter",
    "wet length": "length", "wet width": "width", "elongation": "strain", "force per width": "line force", "tension": "line force",
    "residual ratio": "residual", "moisture": "residual",
}

STRIP_WIDTH, GAUGE, PULL = 0.05, 0.2, 0.1 / 60  # m, m, m/s, of the tensile test


class Test:
    """What `drench fit` can compare with a test. A column is its name in curve.csv, or such names and a function.

    `end`: time, s, at which the test ends at the latest. `extends`: largest value, in SI units, of each name of
    `across` up to which a fit moves that time to the last point of the data. `stops`: the event at which the test
    ends earlier. `most`: largest value, in SI units, that a quantity can have in this test, and the reason."""

    def __init__(self, aliases, across, columns, numbers, directions=False, end=None, extends=None, stops="",
                 most=None):
        self.aliases, self.across, self.columns, self.numbers = aliases, across, columns, numbers
        self.directions, self.end, self.extends = directions, end, extends or {}
        self.stops, self.most = stops, most or {}


TIME = {"time": "time (s)"}
SECONDS = {"time": 1.0, "strain": GAUGE / PULL, "extension": 1 / PULL}  # of a test, per SI unit of its `across`
TESTS = {
    "aatcc197": Test(["vertical-wicking"], TIME, {"height": "wicking height (mm)", "mass": "absorbed water (g)"}, {}, True,
                     end=600, extends={"time": 7200.0},
                     most={"height": (fit_strip.TOP, "the end of the strip above the water")}),
    "aatcc198": Test(["horizontal-wicking"], TIME, {
        "length": "wet length (mm)", "width": "wet width (mm)", "mass": "absorbed water (g)",
        "area": (["wet length (mm)", "wet width (mm)"], "mm2", lambda a, b: math.pi / 4 * a * b)},
        {"horizontal wicking rate": "rate"},
        end=300, stops="the spot reaches a circle of 100 mm",
        most={"length": (0.2, "the specimen"), "width": (0.2, "the specimen"), "area": (0.04, "the specimen"),
              "mass": (1.05e-3, "the water and 5 % of scatter")}),
    "aatcc79": Test(["drop"], TIME, {
        "mass": "absorbed water (mg)", "diameter": "wet diameter (mm)",
        "area": (["wet diameter (mm)"], "mm2", lambda d: math.pi / 4 * d * d)}, {"wetting time": "wetting_time"},
        end=60, stops="the drop is absorbed, or is absorbed too slowly",
        most={"diameter": (0.06, "the specimen"), "area": (0.0036, "the specimen"),
              "mass": (0.0525e-3, "the drop and 5 % of scatter")}),
    "iso9073-14": Test(["wetback"], TIME, {"mass": "water in the pick-up paper (g)"}, {"wetback": "wetback"}, end=120),
    "iso17617": Test(["drying"], {"time": "time (min)"}, {
        "mass": "residual water (g)", "residual": "residual water (%)", "area": "wet area (cm2)"},
        {"drying rate": "drying_rate", "time to dry": "time_to_dry"}, end=21600,
        stops="less than 10 % of the water is left",
        most={"residual": (1.05, "all of the water and 5 % of scatter"), "area": (0.01, "the specimen")}),
    "iso9073-9": Test(["drape", "cusick"], {}, {}, {"drape coefficient": "drape_coefficient"},
                      most={"drape coefficient": (1.0, "a flat specimen")}),
    "iso13934-1": Test(["tensile"], {"strain": "strain (%)", "extension": "extension (mm)"}, {
        "force": "force (N)", "line force": (["force (N)"], "N/m", lambda f: f / STRIP_WIDTH)},
        {"tensile stiffness": "stiffness"}, True, end=0.05 * GAUGE / PULL,
        extends={"strain": 0.5, "extension": 0.5 * GAUGE}),
    "iso9073-7": Test(["astm-d1388", "cantilever"], {}, {},
                      {"bending length": "bending_length", "flexural rigidity": "flexural_rigidity"}, True),
    "iso811": Test(["hydrostatic-head"], {}, {}, {"hydrostatic head": "head", "pressure": "pressure"}),
    "iso9073-8": Test(["strike-through"], {}, {}, {"strike-through time": "time"}),
}


def test_named(word):
    for name, test in TESTS.items():
        if word == name or word in test.aliases:
            return name
    fail(f"--test: {word} is not a test that can be fitted; allowed: {', '.join(TESTS)}")


def parse_column(word):
    """Name and unit of `name (unit)`; the unit is "" where there is none."""
    found = re.match(r"^\s*(.*?)\s*(?:[(\[]\s*(.*?)\s*[)\]])?\s*$", word)
    unit = (found.group(2) or "").replace("²", "2").replace("^2", "2").replace("·", " ").replace("µ", "u").replace("μ", "u").replace("sec", "s")
    return re.sub(r"[\s_]+", " ", found.group(1).lower()), unit


def factor(unit, wanted):
    """From `unit` to `wanted`, both known."""
    return UNITS[unit][1] / UNITS[wanted][1]


class Curve:
    """One file: what was measured, in the units of the test's own curve."""

    def __init__(self, path, test_name, direction, given_end=None, standard_specimen=True):
        self.path, self.test_name, self.test, self.direction = path, test_name, TESTS[test_name], direction
        self.given_end, self.standard_specimen = given_end, standard_specimen  # s, of --set time.end
        rows = self._read()
        self._place_columns(*rows[0])
        self._take_rows(rows[1:])

    def refuse(self, line, what):
        fail(f"{self.path}:{line}: {what}")

    def _read(self):
        """(line number, words) of the header and of each row."""
        try:
            with open(self.path, encoding="utf-8-sig", newline="") as file:
                lines = file.read().splitlines()
        except (OSError, UnicodeDecodeError) as error:
            fail(f"{self.path}: cannot be read: {getattr(error, 'strerror', None) or 'it is not a text in UTF-8'}")
        comments = [line.lstrip().startswith("#") for line in lines]
        self.about = [line.strip().lstrip("# ") for line, comment in zip(lines, comments) if comment]
        kept = [(n, line) for n, (line, comment) in enumerate(zip(lines, comments), 1) if line.strip() and not comment]
        if not kept:
            fail(f"{self.path}: no header; for example: time (s),height (mm)")
        self.mark = max(";\t,", key=kept[0][1].count) if any(c in kept[0][1] for c in ";\t,") else ","
        rows = [(n, next(csv.reader([line], delimiter=self.mark))) for n, line in kept]
        header = rows[0][1]
        while len(header) > 1 and not header[-1].strip():  # spreadsheets end lines with delimiters
            header.pop()
        for _, words in rows[1:]:
            while len(words) > len(header) and not words[-1].strip():
                words.pop()
        if all(map(is_number, rows[0][1])):
            self.refuse(rows[0][0], "no header above the values; for example: time (s),height (mm)")
        return rows

    def _place_columns(self, line, words):
        self.header_line, self.count, self.x_at, self.y_at, self.sd_at = line, len(words), None, None, None
        for k, word in enumerate(words):
            name, unit = parse_column(word)
            for direction in ("warp", "weft"):
                if re.search(rf"\b{direction}\b", name):
                    self.direction = direction
                    name = re.sub(rf"[\s,]*\b{direction}\b[\s,]*", " ", name).strip()
            name = SYNONYMS.get(name, name)
            known = (*self.test.across, *self.test.columns, *self.test.numbers, "standard deviation", "sd")
            if not unit and name not in known:
                name = word.strip() or f"column {k + 1}"
                self.refuse(line, f"{name}: is no quantity of this test; remove this column; {self._allowed()}")
            if not unit:
                self.refuse(line, f"{word.strip()}: the unit is missing; write for example: time (s),height (mm)")
            if unit not in UNITS:
                self.refuse(line, f"{word.strip()}: {unit} is not a unit; allowed: {', '.join(UNITS)}")
            if name in ("standard deviation", "sd") and self.sd_at is None:
                self.sd_at, self.sd_unit = k, unit
            elif name in self.test.across and self.x_at is None:
                self.x_at, self.x_name, self.x_unit = k, name, unit
            elif self.y_at is None:
                self.y_at, self.y_name, self.y_unit, self.y_word = k, name, unit, word.strip()
            else:
                self.refuse(line, f"{word.strip()}: one measured quantity per file; remove this column")
        if self.y_at is None:
            self.refuse(line, "no measured quantity; " + self._allowed())
        self._match(line)

    def _allowed(self):
        curves = ", ".join(self.test.columns)
        numbers = ", ".join(self.test.numbers)
        parts = [f"over {' or '.join(self.test.across)}: {curves}"] if curves else []
        return f"{self.test_name} reports " + "; ".join(parts + ([f"without another column: {numbers}"] if numbers else []))

    def _match(self, line):
        source = self.test.columns if self.x_at is not None else self.test.numbers
        if self.y_name not in source:
            self.refuse(line, f"{self.y_word}: is no quantity of this test; {self._allowed()}")
        self.source = source[self.y_name]
        if self.x_at is not None:
            self.x_column = self.test.across[self.x_name]
            own = parse_column(self.x_column)[1]
            self._same_dimension(line, self.x_name, self.x_unit, own)
            self.x_factor, self.x_own = factor(self.x_unit, own), own
            own = self.source[1] if isinstance(self.source, tuple) else parse_column(self.source)[1]
            self._own_unit(line, own)
        else:
            self.own = None  # known with the first result

    def _own_unit(self, line, own):
        self._same_dimension(line, self.y_word, self.y_unit, own)
        self.own, self.y_factor = own, factor(self.y_unit, own)
        if self.sd_at is not None:
            self._same_dimension(line, "standard deviation", self.sd_unit, own)
            self.sd_factor = factor(self.sd_unit, own)

    def _same_dimension(self, line, name, unit, own):
        if UNITS[unit][0] != UNITS[own][0]:
            allowed = [u for u, (dimension, _) in UNITS.items() if dimension == UNITS[own][0]]
            self.refuse(line, f"{name}: {unit} is not a unit of this quantity; allowed: {', '.join(allowed)}")

    def _take_rows(self, rows):
        x, y, sd, self.lines = [], [], [], []
        for line, words in rows:
            if len(words) != self.count:
                more = self.mark == "," and len(words) > self.count
                commas = more and all(re.fullmatch(r"\s*\d+\s*", w) for w in words[1:])
                self.refuse(line, f"{len(words)} values; the header has {self.count} columns" +
                            ("; write decimal points if these are decimal commas" if commas else ""))
            try:
                values = [float(word) for word in words]
            except ValueError:
                self.refuse(line, not_a_number(next(w for w in words if not is_number(w)).strip()))
            if not all(map(math.isfinite, values)):
                self.refuse(line, "a value is not finite")
            if self.sd_at is not None and not values[self.sd_at] > 0:
                self.refuse(line, "a standard deviation must be above 0")
            if self.x_at is not None and values[self.x_at] < 0:
                self.refuse(line, f"{self.x_name}: {values[self.x_at]:g} is not allowed; allowed: 0 or more")
            x.append(values[self.x_at] if self.x_at is not None else 0.0)
            y.append(values[self.y_at])
            sd.append(values[self.sd_at] if self.sd_at is not None else 0.0)
            self.lines.append(line)
        if not y:
            self.refuse(self.header_line, "no values below the header")
        scatter = 0.05 * max(0.0, max(y))  # of a balance around 0, for example
        for line, value in zip(self.lines, y):
            if value < -scatter:
                self.refuse(line, f"{self.y_name}: {value:g} {self.y_unit} is not possible; allowed: 0 or more (scatter around 0 "
                                  "down to -5 % of the largest value)")
        self.given_x, self.given_y, self.given_sd = numpy.array(x), numpy.array(y), numpy.array(sd)
        self.kept, self.note = numpy.ones(len(y), bool), ""
        self._check_most()
        if self.x_at is not None:
            self.x = self.given_x * self.x_factor
            if numpy.any(numpy.diff(self.x) < 0):
                self.refuse(self.lines[int(numpy.argmax(numpy.diff(self.x) < 0)) + 1], f"{self.x_name} must not decrease")
            self._check_end()
            self._settle()

    def _check_most(self):
        """Values that the test cannot reach are most often in another unit."""
        if self.y_name not in self.test.most or not self.standard_specimen:
            return
        most, reason = self.test.most[self.y_name]
        dimension, size = UNITS[self.y_unit]
        above = self.given_y * size > most * (1 + 1e-9)
        if dimension != self._dimension() or not above.any():
            return
        k, largest = int(numpy.argmax(above)), float(self.given_y.max())
        others = [u for u, (d, f) in UNITS.items() if d == dimension and f < size and 0.05 * most < largest * f <= most]
        remedy = f"is the unit {others[0]}?" if others else "check the unit, or remove such points"
        unit = "" if self.y_unit == "1" else f" {self.y_unit}"
        self.refuse(self.lines[k], f"{self.y_name}: {self.given_y[k]:g}{unit} is not possible in {self.test_name}; "
                                   f"allowed: at most {most / size:.4g}{unit}, {reason}; {remedy}")

    def _dimension(self):
        """Of the measured quantity in this test."""
        if self.x_at is None:
            return "ratio"  # of all numbers with a largest value
        return UNITS[self.source[1] if isinstance(self.source, tuple) else parse_column(self.source)[1]][0]

    def _check_end(self):
        per_unit = UNITS[self.x_unit][1]
        if self.given_end:
            longest, reason = self.given_end / SECONDS[self.x_name], ", where --set time.end ends the test"
        elif self.test.extends:
            longest, reason = self.test.extends[self.x_name], ""
        else:
            longest, reason = self.test.end, ", where the test ends; --set time.end=SECONDS moves its end"
        late = self.given_x * per_unit > longest * (1 + 1e-9)
        if late.any():
            k = int(numpy.argmax(late))
            self.refuse(self.lines[k], f"{self.x_name}: {self.given_x[k]:g} {self.x_unit} is not allowed; "
                                       f"allowed: 0 to {longest / per_unit:g} {self.x_unit}{reason}")

    def _settle(self):
        self.y = self.given_y * self.y_factor
        self.scale = float(numpy.sqrt(numpy.mean(self.y[self.kept]**2))) or 1.0
        self.weight = numpy.ones_like(self.y)
        if self.sd_at is not None:
            sd = self.given_sd * self.sd_factor
            self.weight = numpy.mean(sd[self.kept]) / sd

    @property
    def end(self):
        """The time, s, at which a test covers the data; None where a fit does not move its end."""
        if not self.test.extends:
            return None
        if self.x_at is None:  # a number of the whole test, also beside a shorter curve
            return self.test.end
        return float(self.given_x[-1]) * UNITS[self.x_unit][1] * SECONDS[self.x_name]

    def covered(self, result, reach=1.0):
        """Which points are within the simulated test, which may end at an event that depends on the fitted values."""
        if self.x_at is None:
            return numpy.ones(len(self.given_y), bool)
        return self.x <= result.column(self.x_column, self.direction)[-1] * reach * (1 + 1e-5)

    def keep(self, points, result):
        """Leaves out the others, which are the last ones: `across` does not decrease. `note` is a line about them."""
        self.kept, self.note = points, ""
        if points.all():
            self._settle()
            return
        first = int(numpy.argmin(points))
        end = result.column(self.x_column, self.direction)[-1] / self.x_factor
        count = len(self.lines) - first
        which = f"{count} points from this line on are" if count > 1 else "this last point is"
        self.note = (f"{self.path}:{self.lines[first]}: {self.test_name} ends at {end:.4g} {self.x_unit} with the "
                     f"fitted values ({self.test.stops}), so {which} left out")
        if points.any():
            self._settle()

    def model(self, result):
        """The test's values at the points of the data, in the test's units."""
        if self.x_at is None:
            key = self.source + (f"_{self.direction}" if self.test.directions else "")
            value, unit = result.number(key)
            if self.own is None:
                self._own_unit(self.header_line, unit)
                self._settle()
            return numpy.full(len(self.given_y), value)
        names, compute = ([self.source], lambda v: v) if isinstance(self.source, str) else (self.source[0], self.source[2])
        x = result.column(self.x_column, self.direction)
        y = compute(*[result.column(name, self.direction) for name in names])
        return numpy.where(self.x <= x[-1], numpy.interp(self.x, x, y), continued(x, y, self.x))

    def dense(self, result):
        """The test's whole curve in the units of the file, for plots."""
        names, compute = ([self.source], lambda v: v) if isinstance(self.source, str) else (self.source[0], self.source[2])
        x = result.column(self.x_column, self.direction)
        y = compute(*[result.column(name, self.direction) for name in names])
        return x / self.x_factor, y / self.y_factor

    def residuals(self, result):
        """Model minus data over the file's root mean square, so that files of several quantities weigh the same per point."""
        model = self.model(result)
        return ((model - self.y) / self.scale * self.weight)[self.kept]


def continued(x, y, at):
    """A curve after its end, by the power law of its second half and at most to twice its end. Only the search uses
    such values, whose trial points may end the test before a point of the data; no reported error contains them."""
    middle, last = float(numpy.interp(x[-1] / 2, x, y)), float(y[-1])
    if not (x[-1] > 0 and middle > 0 and last > 0):
        return numpy.full(len(at), last)
    power = min(max(math.log(last / middle) / math.log(2), -4.0), 1.0)
    return last * numpy.clip(at / x[-1], 1, 2)**power


def not_a_number(word):
    if re.fullmatch(r"[-+]?\d+,\d+(e[-+]?\d+)?", word, re.IGNORECASE):
        return f"{word}: is not a number; write a decimal point: {word.replace(',', '.')}"
    if "#" in word:
        return f"{word}: is not a number; write comments in lines of their own"
    return f"{word or 'an empty value'}: is not a number"


def is_number(word):
    try:
        return math.isfinite(float(word))
    except ValueError:
        return False
