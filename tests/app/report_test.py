#!/usr/bin/env python3
"""report_test.py SOURCE BUILD: a report as a browser shows it: pictures and curves are drawn, it fits a phone, it is dark where
the reader wants it, and its charts answer the pointer. Numbers: report_test.cpp. Exit code 77, skipped, without Chromium."""

import re
import shutil
import tempfile
from pathlib import Path

from support import call, drench, expect, skip, stats

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


def browse(folder, *options):
    """What the browser prints. It knows no network: the page must not want one."""
    words = [BROWSER, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--allow-file-access-from-files",
             "--host-resolver-rules=MAP * ~NOTFOUND", f"--user-data-dir={folder}/profile", *options]
    ran = call(*words, timeout=120)
    expect(ran.returncode == 0, f"{BROWSER} ended with {ran.returncode}: {ran.stderr[-400:]}")
    return ran.stdout


def measured(folder, name, script, options=()):
    """Puts a script at the end of a copy of the page, and returns what it leaves as the page's title."""
    text = (folder / "o/report.html").read_text(encoding="utf-8")
    (folder / name).write_text(text.replace("</body>", f"<script>{script}</script></body>"), encoding="utf-8")
    shown = browse(folder, *options, "--dump-dom", f"file://{folder}/{name}")
    return re.search("<title>(.*?)</title>", shown, re.S).group(1)


def test_drawn(folder):
    said = measured(folder, "drawn.html", "document.title=[...document.images].filter(i=>i.complete&&i.naturalWidth>0).length+' '+"
                    "document.querySelectorAll('path.l').length")
    pictures, curves = map(int, said.split())
    expect(pictures == 9 and curves >= 10, f"{pictures} pictures, {curves} curves")


def test_pointer(folder):
    said = measured(folder, "pointer.html", """
const svg=document.querySelector('svg.chart'),box=svg.getBoundingClientRect(),[l,t,w,h]=svg.dataset.box.split(' ').map(Number);
svg.dispatchEvent(new PointerEvent('pointermove',{clientX:box.left+(l+w)*box.width/svg.viewBox.baseVal.width-0.01,clientY:box.top+50}));
document.title=document.getElementById('tip').textContent;""")
    last = stats(folder / "o")[-1]
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


if not BROWSER:
    skip("no Chromium; tools/setup browser")
with tempfile.TemporaryDirectory(prefix="drench_report_") as name:
    here = Path(name)
    (here / "scene.yaml").write_text(SCENE, encoding="utf-8")
    drench("run", "scene.yaml", "-o", "o", "--quiet", cwd=here)
    for test in (test_drawn, test_pointer, test_phone, test_dark):
        test(here)
print("report_test: all good")
