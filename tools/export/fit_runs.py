"""Runs of `drench test` for `drench fit`: several at a time, each only once, and the keys that can be fitted."""

import concurrent.futures
import csv
import difflib
import hashlib
import json
import math
import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy

import fit_strip
from refusal import fail


class RunError(Exception):
    """A simulation that failed; one line."""


class Result:
    """Numbers and curves of one run of a test."""

    def __init__(self, numbers, columns, test):
        self.numbers, self.columns, self.test = numbers, columns, test  # {key: (value, unit)}, {specimen: {column: values}}

    @classmethod
    def read(cls, folder):
        found = json.loads((folder / "result.json").read_text(encoding="utf-8"))
        numbers = {n["key"]: (n["mean"], n["unit"]) for n in found["numbers"] if n["mean"] is not None}
        columns = {}
        with (folder / "curve.csv").open(encoding="utf-8", newline="") as file:
            for row in csv.DictReader(file):
                own = columns.setdefault(row.pop("specimen"), {})
                for name, value in row.items():
                    own.setdefault(name, []).append(float(value) if value else math.nan)
        return cls(numbers, columns, found["test"])

    def number(self, key):
        if key not in self.numbers:
            raise RunError(f"{self.test} does not report {key} for these values; it reports {', '.join(self.numbers)}")
        return self.numbers[key]

    def column(self, name, direction):
        wanted = [own for specimen, own in self.columns.items() if not specimen[0].isalpha() or specimen.startswith(direction)]
        if not wanted or name not in wanted[0]:
            raise RunError(f"{self.test}: curve.csv has no column {name}; program and tool are of different versions")
        return numpy.array(wanted[0][name])


def is_of_fabric(setting):
    """Whether a KEY=VALUE of --set changes the fabric of the specimen, and not its shape or the test."""
    return re.match(r"cloth\.0\.(fabric|areal_density|thickness|compression|stretch|membrane|bend|bending|friction|"
                    r"adhesion|strain_limit|porous)\b", setting)


def number_text(value):
    return f"{value:.7g}"


class Program:
    """The program, the base fabric and the fixed keys."""

    def __init__(self, path, fabric, settings, folder, jobs):
        self.path, self.fabric, self.settings = path, fabric, settings
        self.folder, self.jobs = folder, jobs
        self.pool = concurrent.futures.ThreadPoolExecutor(jobs)
        self.futures, self.simulated, self.computed, self.strips = {}, 0, 0, {}
        self.environment = {**os.environ, "OMP_PROC_BIND": "false", "OMP_WAIT_POLICY": "passive", "OMP_NUM_THREADS": "1"}
        lines = self.call(["info", "--threads", "1"]).stdout.splitlines()
        self.contents = Path(fabric).read_text(encoding="utf-8") if fabric.endswith((".yaml", ".yml")) else ""
        self.version = [line for line in lines if line.split(":")[0] in ("version", "commit", "precision", "backend", "device", "Kokkos")]

    def call(self, words):
        return subprocess.run([self.path, *words], capture_output=True, text=True, env=self.environment, check=False)

    def checked(self, words):
        """Runs the program; a line that rejects the command ends this tool too."""
        done = self.call(words)
        if done.returncode == 2:
            fail(done.stderr.strip().splitlines()[-1].removeprefix("drench: "))
        return done

    # ---- keys

    def keys(self):
        """{key of cloth.0: (lowest, highest, unit, description)} of all numbers that a fit may change."""
        found, section = {}, None
        for line in self.checked(["schema"]).stdout.splitlines():
            if line.startswith("#"):
                match = re.match(r"^#+ `cloth\.N(?:\.(membrane|bending|porous))?`$", line)
                section = None if not match else (match.group(1) + "." if match.group(1) else "")
                continue
            cells = [c.strip() for c in line.split(" | ")]
            if section is None or len(cells) < 6 or cells[1] != "number":
                continue
            span = re.match(r"^[\[(]([^,]+), ([^\])]+)[\])]$", cells[2])
            if span:
                found[section + cells[0].strip("|` ")] = (float(span.group(1)), float(span.group(2)), cells[3], cells[5].rstrip(" |"))
        return found

    def values(self):
        """Numbers of cloth.0 before the fit, from the scene that the program resolves: {key: value}."""
        own = list(filter(is_of_fabric, self.settings))
        with tempfile.TemporaryDirectory() as scratch:
            scene = Path(scratch) / "fabric.yaml"
            scene.write_text("drench: 1\ncloth:\n  - name: specimen\n    fabric: " + json.dumps(self.fabric) +
                             "\n    mesh: {grid: {size: [0.1, 0.1], nodes: [2, 2]}}\n    porous: {}\n", encoding="utf-8")
            words = [w for s in own for w in ("--set", s)]
            done = self.call(["run", str(scene), "--steps", "0", "--quiet", "--threads", "1", "-o", str(Path(scratch) / "out"), *words])
            if done.returncode != 0:
                line = (done.stderr.strip().splitlines() or ["no message"])[-1]
                fail(re.sub(r"^\S*fabric\.yaml\S* ", "", line).removeprefix("drench: "))
            return cloth_values((Path(scratch) / "out" / "scene.yaml").read_text(encoding="utf-8"))

    # ---- runs

    def words(self, test, values, end):
        settings = list(self.settings)
        if end and not any(s.startswith("time.end=") for s in settings):
            settings.append(f"time.end={number_text(end)}")
        settings += [f"cloth.0.{key}={number_text(value)}" for key, value in values.items()]
        return ["test", test, "--fabric", self.fabric, *[w for s in settings for w in ("--set", s)]]

    def _simulate(self, words):
        name = hashlib.sha256(json.dumps([self.version, self.contents, words]).encode()).hexdigest()[:12]
        folder = self.folder / "runs" / f"{words[1]}-{name}"
        if not (folder / "result.json").exists():
            shutil.rmtree(folder, ignore_errors=True)
            done = self.call([*words, "--repeats", "1", "--threads", "1", "--quiet", "-o", str(folder)])
            self.simulated += 1
            if done.returncode != 0:
                line = (done.stderr.strip().splitlines() or [f"exit code {done.returncode}"])[-1].removeprefix("drench: ")
                if done.returncode == 2:
                    line = re.sub(r"^\S*scene_\w+\.yaml:\S* ", "", line)
                    raise Rejection(line)
                raise RunError(f"{' '.join(words)}: {line}")
        return Result.read(folder)

    def start(self, test, values, end):
        """A run in the background, or the one that was started with the same words."""
        words = self.words(test, values, end)
        key = tuple(words)
        if key not in self.futures:
            self.futures[key] = self.pool.submit(self._simulate, words)
        return self.futures[key]

    def close(self):
        self.pool.shutdown(wait=True, cancel_futures=True)

    # ---- the strip of aatcc197 without a simulation

    def has_strip(self, test, keys):
        free = {s.split("=")[0] for s in self.settings}
        known = {f"cloth.0.{k}" for k in fit_strip.KEYS} | {"time.end"}
        return test == "aatcc197" and free <= known and set(keys) <= fit_strip.KEYS

    def strip(self, base, values, end):
        """The same test by fit_strip.py; None where it cannot be integrated."""
        given = [float(s.split("=")[1]) for s in self.settings if s.startswith("time.end=")]
        end = given[-1] if given else end or 600.0
        all_values = {**base, **values}
        key = (tuple(sorted((k, number_text(v)) for k, v in values.items())), end)
        if key not in self.strips:
            self.computed += 1
            columns = {}
            for direction in ("warp", "weft"):
                if direction == "weft" and "porous.weft_diffusivity" not in all_values:
                    columns["weft 1"] = columns["warp 1"]
                    continue
                found = fit_strip.curve(all_values, end, direction)
                if found is None:
                    return None
                columns[f"{direction} 1"] = dict(zip(("time (s)", "wicking height (mm)", "absorbed water (g)"), found))
            self.strips[key] = Result({}, columns, "aatcc197")
        return self.strips[key]


class Rejection(Exception):
    """A key or value that the program rejects; one line."""


def cloth_values(text):
    """Numbers of the first cloth of a scene as the program writes it: {key below cloth.0: value}."""
    values, inside, group = {}, False, ""
    for line in text.splitlines():
        line = line.split("  #")[0].rstrip()
        if not line.startswith(" "):
            inside = line == "cloth:"
            continue
        if not inside:
            continue
        depth = len(line) - len(line.lstrip())
        entry = re.match(r"^([a-z_]+):\s*(.*)$", line.lstrip().removeprefix("- "))
        if not entry:
            continue
        key, value = entry.groups()
        if depth <= 4:
            group = ""
        if depth <= 4 and value == "":
            group = key + "."
        elif value.startswith("{") and "[" not in value:
            for name, number in re.findall(r"([a-z_]+): ([-+.\deE]+)", value):
                values[f"{key}.{name}"] = float(number)
        elif re.fullmatch(r"[-+.\d][-+.\deE]*", value):
            values[group + key] = float(value)
        elif (group, key, value) == ("porous.", "diffusion", "degenerate"):
            values["porous.diffusion_exponent"] = 1.0
    return values


def resolve(word, keys):
    """The key below cloth.0 that a name on the command line means."""
    name = word.removeprefix("cloth.0.")
    if name in keys:
        return name
    found = [key for key in keys if key.rsplit(".", 1)[-1] == name]
    # porous.adhesion and adhesion, for example: the name as it stands was looked up first
    if len(found) == 1:
        return found[0]
    if found:
        fail(f"--parameters: {word} is ambiguous; write one of {', '.join(found)}")
    near = difflib.get_close_matches(name, [k.rsplit(".", 1)[-1] for k in keys] + list(keys), 1)
    fail(f"--parameters: {word} is not a number of a cloth in a scene" + (f"; did you mean {near[0]}?" if near else "") +
         "; `drench schema` lists them under cloth.N")
