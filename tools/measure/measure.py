"""What the measuring tools share: running drench, reading what it writes, tables. Needs the standard library alone, so
that the tools run on a machine that has nothing but the binaries; only plots need matplotlib, and are drawn apart."""

import argparse
import array
import base64
import csv
import importlib.util
import math
import os
import re
import shutil
import signal
import statistics
import struct
import subprocess
import sys
import time
import xml.etree.ElementTree as ElementTree
import zlib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TOOL = Path(sys.argv[0]).name


def give_up(message):
    sys.exit(f"{TOOL}: {message}")


OPTIONS = {
    "backend": {"choices": ("openmp", "serial", "cuda"), "default": "openmp"},
    "precision": {"choices": ("float", "double"), "default": "float", "help": "of the binary that is built"},
    "threads": {"type": int, "default": os.cpu_count()},
    "set": {"action": "append", "default": [], "metavar": "KEY=VALUE", "help": "passed on to drench"},
    "no-build": {"action": "store_true"},
    "binary": {"type": Path, "help": "instead of the one in build/; nothing is built"},
    "table": {"type": Path, "metavar": "FILE.csv", "help": "keeps the numbers"},
    "keep": {"type": Path, "metavar": "FOLDER", "help": "keeps the runs' folders there"}}


def parser(doc, *names):
    """Of a tool's command line, with those of OPTIONS that are named; its help begins with `doc`."""
    made = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter, usage=argparse.SUPPRESS,
                                   prog=doc.split(maxsplit=1)[0])
    for name in names:
        made.add_argument("--" + name, **OPTIONS[name])
    return made


def program(binary, backend, precision, build=True):
    """The binary that is named, or else the one in build/, built first unless `build` is off."""
    if not binary:
        binary = ROOT / "build" / f"{backend}-{precision}" / "drench"
        if build:
            subprocess.run([ROOT / "tools" / "build", backend, precision, "drench"], stdout=sys.stderr, check=True)
    if not os.access(binary, os.X_OK):
        give_up(f"{binary}: no such program")
    return Path(binary).resolve()


def info(binary):
    """What `drench info` prints: the version, the device. Gives up where there is no device."""
    os.environ.setdefault("OMP_PROC_BIND", "false")
    os.environ.setdefault("OMP_WAIT_POLICY", "passive")
    said = subprocess.run([binary, "info"], capture_output=True, text=True)
    if said.returncode != 0:
        give_up(said.stderr.strip() or "drench info failed")
    return said.stdout.strip()


def last_line(text, otherwise):
    lines = text.strip().splitlines()
    return lines[-1] if lines else otherwise


def overrides(settings):
    return [word for value in settings for word in ("--set", value)]


class Run:
    """One `drench run`. `rows` are those of stats.csv; `problem` is "" or says in a line what went wrong. With
    `seconds` of wall time it ends, in order, at the step that it is at then: `cut`. `launcher`: words before the
    program's own, as `mpi_launcher` has them."""

    def __init__(self, binary, scene, folder, threads=None, steps=None, settings=(), more=(), seconds=None, launcher=()):
        self.folder, self.problem, self.cut = Path(folder), "", False
        command = [*launcher, str(binary), "run", str(scene), "-o", str(folder), "--overwrite", "--quiet",
                   *overrides(settings), *more]
        if threads:
            command += ["--threads", str(threads)]
        if steps:
            command += ["--steps", str(steps)]
        began = time.monotonic()
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        try:
            _, said = process.communicate(timeout=seconds)
        except subprocess.TimeoutExpired:
            self.cut = True
            said = self.end(process)
        self.wall_seconds = time.monotonic() - began
        self.code = process.returncode
        stats, log = self.folder / "stats.csv", self.folder / "run.log"
        self.rows = []
        if stats.exists():
            with stats.open() as file:
                self.rows = [row for row in csv.DictReader(file) if None not in row.values()]
        self.log = log.read_text() if log.exists() else ""
        if self.cut and not self.rows:
            self.problem = f"no step was done in {seconds:g} s"
        elif process.returncode != 0 and not self.cut:
            self.problem = last_line(said, f"exit code {process.returncode}")

    @staticmethod
    def end(process):
        process.send_signal(signal.SIGINT)  # it finishes its step
        try:
            return process.communicate(timeout=60)[1]
        except subprocess.TimeoutExpired:
            process.kill()
            return process.communicate()[1]

    def column(self, key):
        return [float(row[key]) for row in self.rows if key in row]

    def mean(self, key):
        values = self.column(key)
        return statistics.fmean(values) if values else None

    def peak_bytes(self):
        """Of the backend's arrays, those on the device; None where the run did not get to say."""
        found = re.search(r"peak memory of the backend's arrays ([\d.]+) MiB", self.log)
        return float(found.group(1)) * 2**20 if found else None

    def at_cap(self):
        """Which solves ended at their limit of iterations, and in how many steps."""
        return re.findall(r"the (.+?) did not converge in (\d+) of", self.log)


def mpi_launcher(ranks, bind=True):
    """The words of `mpirun` for so many ranks, each bound to a core where there are that many. Ranks that share cores
    give way to each other while they wait."""
    if not shutil.which("mpirun"):
        give_up("--ranks needs mpirun: tools/setup installs Open MPI")
    for name in ("OMPI_ALLOW_RUN_AS_ROOT", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM"):  # a container's user may be root
        os.environ.setdefault(name, "1")
    if not bind:
        return ["mpirun", "-n", str(ranks), "--bind-to", "none"]
    if ranks <= len(os.sched_getaffinity(0)):
        return ["mpirun", "-n", str(ranks), "--bind-to", "core"]
    return ["mpirun", "-n", str(ranks), "--oversubscribe", "--bind-to", "none", "--mca", "mpi_yield_when_idle", "1"]


def check(binary, scene, settings=()):
    """What `drench check` prints, and the problem where it refuses the scene."""
    said = subprocess.run([str(binary), "check", str(scene), *overrides(settings)], capture_output=True, text=True)
    return said.stdout, "" if said.returncode == 0 else last_line(said.stderr, "drench check failed")


# --- Tables

def table(header, rows):
    """In Markdown."""
    print("| " + " | ".join(header) + " |")
    print("|" + "---|" * len(header))
    for row in rows:
        print("| " + " | ".join(str(cell) for cell in row) + " |")
    print()


def print_info(text):
    print("\n".join("    " + line for line in text.splitlines()) + "\n")


def write_csv(path, rows):
    """Dictionaries with the same keys; written beside and renamed, so that a kill leaves the last whole table."""
    beside = Path(str(path) + ".part")
    with beside.open("w", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys())
        writer.writeheader()
        writer.writerows(rows)
    beside.replace(path)


def read_csv(path):
    try:
        with open(path, newline="") as file:
            return list(csv.DictReader(file))
    except OSError as error:
        give_up(f"{path}: {error.strerror}")


# --- Frames

FORMATS = {"Float32": "f", "Float64": "d", "Int8": "b", "UInt8": "B", "Int32": "i", "UInt32": "I", "Int64": "q",
           "UInt64": "Q"}


def frames(folder, series):
    """[(time, path)] of an output folder's `fluid` or `cloth`."""
    pvd = Path(folder) / (series + ".pvd")
    if not pvd.exists():
        return []
    return [(float(entry.get("timestep")), Path(folder) / entry.get("file"))
            for entry in ElementTree.parse(pvd).getroot().iter("DataSet") if entry.get("part") == "0"]


def decoded(element, word):
    """The values of a DataArray: zlib in base64, the header apart, as VTK writes it inline."""
    text = "".join((element.text or "").split())
    size = struct.calcsize("<" + word)

    def header(count):
        characters = 4 * math.ceil(count * size / 3)
        return struct.unpack(f"<{count}{word}", base64.b64decode(text[:characters])[:count * size]), characters

    values = array.array(FORMATS[element.get("type")])
    if not text or header(1)[0] == (0,):
        return values
    sizes, start = header(3 + header(1)[0][0])
    data, at = base64.b64decode(text[start:]), 0
    for packed in sizes[3:]:
        values.frombytes(zlib.decompress(data[at:at + packed]))
        at += packed
    if sys.byteorder == "big":
        values.byteswap()
    return values


def read_frame(path, fields):
    """{name: values} of a VTU file of drench's: `points` (x, y, z, x, …) and the point fields that are named."""
    root = ElementTree.parse(path).getroot()
    word = "Q" if root.get("header_type") == "UInt64" else "I"
    found = {"points": decoded(root.find(".//Points/DataArray"), word)}
    for element in root.iterfind(".//PointData/DataArray"):
        if element.get("Name") in fields:
            found[element.get("Name")] = decoded(element, word)
    return found


def read_corners(path):
    """The node numbers of the cells of a VTU file, cell after cell."""
    root = ElementTree.parse(path).getroot()
    return decoded(root.find(".//Cells/DataArray[@Name='connectivity']"), "Q" if root.get("header_type") == "UInt64" else "I")


# --- Plots

def has(module):
    return importlib.util.find_spec(module) is not None


def prefer_debian(*modules):
    """Debian's Python packages belong to Debian's interpreter, whatever else is on the PATH: where this one lacks a module
    and that one has them all, the tool starts again with that one."""
    debian = "/usr/bin/python3"
    if all(map(has, modules)) or not os.access(debian, os.X_OK) or os.path.realpath(debian) == os.path.realpath(sys.executable):
        return
    if subprocess.run([debian, "-c", "import " + ", ".join(modules)], stderr=subprocess.DEVNULL).returncode == 0:
        os.execv(debian, [debian, *sys.argv])


def matplotlib():
    """matplotlib.pyplot, drawing to files."""
    prefer_debian("matplotlib")
    if not has("matplotlib"):
        give_up("a plot needs matplotlib: apt-get install python3-matplotlib; the table needs nothing")
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot
    return pyplot
