#!/usr/bin/python3 -I
"""report_test.py SOURCE BUILD: a report as a browser shows it: its tables say what stats.csv says, it fits a phone, it is dark
where the reader wants it, and its charts answer the pointer. Exit code 77, skipped, without Chromium."""

import csv
import re
import shutil
import subprocess
import sys
import tempfile
from html.parser import HTMLParser
from pathlib import Path

BINARY = Path(sys.argv[2]).resolve() / "drench"
SCENE = """drench: 1
time: {step: 0.002, end: 0.12, mode: cfl}
domain: {min: [-0.5, -0.2, -0.5], max: [0.5, 0.8, 0.5]}
output: {every: 0.02, report: true}
fluid:
  spacing: 0.02
  sources: [{block: {min: [-0.06, 0.14, -0.06], max: [0.06, 0.24, 0.06]}}]
cloth:
  - name: sheet
    mesh: {grid: {size: [0.3, 0.3], nodes: [13, 13]}}
    place: {position: [0, 0.1, 0]}
    pin: [{corners: true}]
    porous: {absorption: 0.05}
bodies:
  - plane: {point: [0, 0, 0], normal: [0, 1, 0]}
"""
BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)


def expect(good, message):
    if not good:
        sys.exit(f"report_test: {message}")


def drench(folder, *words, code=0):
    ran = subprocess.run([str(BINARY), *words], cwd=folder, capture_output=True, text=True)
    expect(ran.returncode == code, f"{words} ended with {ran.returncode}:\n{ran.stdout}{ran.stderr}")
    return ran


def browse(folder, *options):
    """What the browser prints. It knows no network: the page must not want one."""
    words = [BROWSER, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--allow-file-access-from-files",
             "--host-resolver-rules=MAP * ~NOTFOUND", f"--user-data-dir={folder}/profile", *options]
    ran = subprocess.run(words, capture_output=True, text=True, timeout=120)
    expect(ran.returncode == 0, f"{BROWSER} ended with {ran.returncode}: {ran.stderr[-400:]}")
    return ran.stdout


class Page(HTMLParser):
    """Tables by their id, as rows of cells; pictures; texts of charts."""

    def __init__(self, text):
        super().__init__()
        self.tables, self.images, self.curves, self.ids = {}, [], 0, set()
        self._rows = self._cell = None
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        self.ids.add(attributes.get("id"))
        if tag == "table":
            self._rows = self.tables.setdefault(attributes.get("id"), [])
        elif tag == "tr" and self._rows is not None:
            self._rows.append([])
        elif tag in ("td", "th"):
            self._cell = ""
        elif tag == "img":
            self.images.append(attributes["src"])
        elif tag == "path" and attributes.get("class", "").startswith("l "):
            self.curves += 1

    def handle_data(self, data):
        if self._cell is not None:
            self._cell += data

    def handle_endtag(self, tag):
        if tag in ("td", "th"):
            self._rows[-1].append(self._cell)
            self._cell = None

    def row(self, table, heading):
        rows = [row for row in self.tables[table] if row[0].startswith(heading)]
        expect(len(rows) == 1, f"{table} has {len(rows)} rows {heading}")
        return rows[0]


def near(shown, value, digits):
    return abs(float(shown) - value) <= 10 ** -digits * abs(value)


def test_tables(folder):
    page = Page(browse(folder, "--dump-dom", f"file://{folder}/o/report.html"))
    with open(folder / "o/stats.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    stats = {name: [float(row[name]) for row in rows] for name in rows[0]}
    for heading, column in (("supplied", "mass_supplied"), ("in the liquid", "mass_fluid"), ("in cloth", "mass_cloth")):
        row = page.row("mass-table", heading)
        expect(near(row[1], stats[column][0], 8) and near(row[2], stats[column][-1], 8), f"{row} beside {column}")
    expect(stats["mass_cloth"][-1] > 0, "the cloth of this scene takes up water")
    for name, column, error in (("density", "density_iterations", "density_error"),
                                ("divergence", "divergence_iterations", "divergence_error"),
                                ("cloth", "cloth_iterations", "cloth_residual")):
        row = page.row("solve-table", name)
        expect(near(row[1], sum(stats[column]) / len(rows), 3), f"{row} beside the mean of {column}")
        expect(float(row[3]) == max(stats[column]) and near(row[6], max(stats[error]), 2), f"{row} beside {error}")
    stages = [name for name in stats if name.startswith("ms_") and name != "ms_step"]
    total = sum(sum(stats[name]) for name in stages)
    for name in stages:
        row = page.row("stage-table", name[3:])
        share = 100 * sum(stats[name]) / total
        expect(abs(float(row[4]) - share) <= 0.01 * share + 1e-9, f"{row} beside a share of {share}")
    expect(len(page.images) == 9 and page.curves >= 10, f"{len(page.images)} pictures, {page.curves} curves")


def measured(folder, name, script, options=()):
    """Puts a script at the end of a copy of the page, and returns what it leaves as the page's title."""
    text = (folder / "o/report.html").read_text(encoding="utf-8")
    (folder / name).write_text(text.replace("</body>", f"<script>{script}</script></body>"), encoding="utf-8")
    shown = browse(folder, *options, "--dump-dom", f"file://{folder}/{name}")
    return re.search("<title>(.*?)</title>", shown, re.S).group(1)


def test_pointer(folder):
    said = measured(folder, "pointer.html", """
const svg=document.querySelector('svg.chart'),box=svg.getBoundingClientRect(),[l,t,w,h]=svg.dataset.box.split(' ').map(Number);
svg.dispatchEvent(new PointerEvent('pointermove',{clientX:box.left+(l+w)*box.width/svg.viewBox.baseVal.width-0.01,clientY:box.top+50}));
document.title=document.getElementById('tip').textContent;""")
    with open(folder / "o/stats.csv", encoding="utf-8") as file:
        last = list(csv.DictReader(file))[-1]
    for label, column in (("in the liquid", "mass_fluid"), ("in cloth", "mass_cloth")):
        found = re.search(label + r"\s+≈ ([0-9.e+-]+)", said)
        expect(found and abs(float(found.group(1)) - float(last[column])) < 0.01 * float(last["mass_fluid"]),
               f"the pointer at the end of the curves shows {said!r}, {column} is {last[column]}")


def test_phone(folder):
    frame = folder / "phone.html"
    frame.write_text("""<title></title><iframe src="o/report.html" width="360" height="740" onload="
const d=this.contentDocument.documentElement;document.title=d.scrollWidth+' '+d.clientWidth"></iframe>""", encoding="utf-8")
    shown = browse(folder, "--dump-dom", f"file://{frame}")
    wide, screen = map(int, re.search("<title>(.*?)</title>", shown).group(1).split())
    expect(wide <= screen <= 360, f"on a screen of {screen} the page is {wide} wide")


def test_dark(folder):
    script = "document.title=getComputedStyle(document.body).backgroundColor"
    light = measured(folder, "light.html", script)
    dark = measured(folder, "dark.html", script, ["--blink-settings=preferredColorScheme=0"])
    expect(light == "rgb(255, 255, 255)", f"light ground is {light}")
    expect(all(int(part) < 40 for part in re.findall(r"\d+", dark)), f"dark ground is {dark}")


def test_two_runs(folder):
    drench(folder, "run", "scene.yaml", "-o", "p", "--quiet", "--set", "cloth.0.porous.absorption=0.01")
    drench(folder, "report", "o", "p", "-o", "both.html")
    page = Page(browse(folder, "--dump-dom", f"file://{folder}/both.html"))
    row = page.row("scene-differences", "cloth.0.porous.absorption")
    expect(row[1:] == ["0.05", "0.01"], f"the scenes' difference is {row}")
    expect(len(page.tables["scene-differences"]) == 2, f"{page.tables['scene-differences']}")
    a, b = (float(cell) for cell in page.row("state-differences", "in cloth")[1:3])
    expect(a > b > 0, f"cloth that absorbs faster holds {a}, the other {b}")
    expect({"mass-table", "mass-table-b", "stage-table-b"} <= page.ids, "tables of both runs")


def test_failed_run(folder):
    piston = SCENE.split("cloth:")[0].replace("spacing: 0.02", "spacing: 0.02\n  solver: {max_iterations: 10}")
    piston = piston.replace("min: [-0.06, 0.14, -0.06], max: [0.06, 0.24, 0.06]", "min: [-0.06, 0, -0.06], max: [0.06, 0.2, 0.06]")
    piston = piston.replace("end: 0.12, mode: cfl", "end: 1") + """bodies:
  - box: {min: [-0.06, 0, -0.06], max: [0.06, 0.4, 0.06], inside: true}
  - box: {min: [-0.1, 0.21, -0.1], max: [0.1, 0.5, 0.1], velocity: [0, -1, 0]}
"""
    (folder / "piston.yaml").write_text(piston, encoding="utf-8")
    drench(folder, "run", "piston.yaml", "-o", "f", "--quiet", code=1)
    shown = browse(folder, "--dump-dom", f"file://{folder}/f/report.html")
    text = re.sub("<[^>]*>", " ", re.sub("<(style|script)>.*?</\\1>", "", shown, flags=re.S))
    why = text.find("The run failed in stage pressure")
    expect(0 < why < text.find("Summary"), f"the page does not begin with why the run failed: {text[:600]}")
    expect("the liquid collapses" in text and "raise the limit, or halve time.step" in text, text[why:why + 600])


if not BROWSER:
    print("SKIPPED: no Chromium; tools/setup browser")
    sys.exit(77)
with tempfile.TemporaryDirectory(prefix="drench_report_") as name:
    here = Path(name)
    (here / "scene.yaml").write_text(SCENE, encoding="utf-8")
    drench(here, "run", "scene.yaml", "-o", "o", "--quiet")
    for test in (test_tables, test_pointer, test_phone, test_dark, test_two_runs, test_failed_run):
        test(here)
print("report_test: all good")
