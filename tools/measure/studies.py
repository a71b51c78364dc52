"""The studies of tools/measure/speed_error: small cases of liquid, cloth and porous cloth, each run as it is by default and with one
setting changed at a time; of each run the time for a simulated second beside the error, against an analytic answer where
there is one, otherwise against the finest run, which is not among the rows."""

import math
import statistics
from pathlib import Path

import measure
from series import cloth_series, error_of, liquid_series, mark_pareto

COLUMN = """drench: 1
time: {{step: {step}, end: 1, mode: fixed}}
output: {{every: 0.04}}
neighbors: {{sort: {sort}}}
fluid:
  spacing: {spacing}
  viscosity: 1.0e-3
  kernel: {kernel}
  support: {support}
  solver: {{density_error: {tolerance}, divergence_error: {tolerance}}}
  sources: [{{block: {{min: [0, 0, 0], max: [0.2, 0.2, 0.2]}}}}]
bodies: [{{box: {{min: [0, 0, 0], max: [0.2, 0.3, 0.2], inside: true}}}}]
"""
SPLASH = """drench: 1
time: {{step: {step}, end: 0.6, mode: {mode}}}
output: {{every: 0.024}}
neighbors: {{sort: {sort}}}
fluid:
  spacing: {spacing}
  viscosity: 1.0e-4
  kernel: {kernel}
  support: {support}
  solver: {{density_error: {tolerance}, divergence_error: {tolerance}}}
  sources: [{{block: {{min: [0, 0, 0], max: [0.16, 0.16, 0.16]}}}}]
bodies: [{{box: {{min: [0, 0, 0], max: [0.48, 0.48, 0.16], inside: true}}}}]
"""
SHEET = """drench: 1
time: {{step: {step}, end: 1, mode: fixed}}
output: {{every: 0.04}}
cloth_solver: {{method: {method}, tolerance: {tolerance}, max_iterations: {iterations}}}
cloth:
  - mesh: {{grid: {{size: [1, 1], nodes: [{nodes}, {nodes}]}}}}
    areal_density: 0.2
    stretch: 500
    bend: 1.0e-4
    damping: 2.0
    pin: [{{corners: true}}]
"""
WICK = """drench: 1
time: {{step: {step}, end: 4, mode: fixed}}
gravity: [0, 0, 0]
output: {{every: 0.2}}
cloth:
  - mesh: {{grid: {{size: [0.4, 0.1], nodes: [{nodes}, {across}]}}}}
    dynamics: false
    hold_saturation: [{{box: {{min: [-0.201, -0.01, -0.06], max: [-0.179, 0.01, 0.06]}}, value: 1.0}}]
    porous: {{solid_fraction: 0.4, diffusivity: 1.0e-3}}
"""
SOAK = """drench: 1
time: {{step: {step}, end: 0.4, mode: fixed}}
output: {{every: 0.016}}
domain: {{min: [-0.6, -0.6, -0.6], max: [0.6, 0.6, 0.6]}}
fluid:
  spacing: {spacing}
  viscosity: 1.0e-4
  solver: {{density_error: {tolerance}, divergence_error: {tolerance}}}
  sources: [{{block: {{min: [-0.08, 0.03, -0.08], max: [0.08, 0.11, 0.08]}}}}]
cloth_solver: {{tolerance: {cloth}}}
cloth:
  - mesh: {{grid: {{size: [0.6, 0.6], nodes: [31, 31]}}}}
    areal_density: 0.4
    thickness: 0.002
    stretch: 600
    strain_damping: 0.01
    pin: [{{edges: true}}]
    porous: {{solid_fraction: 0.3, diffusivity: 1.0e-3}}
"""


def column_error(folder, settings, _):
    """rms over the particles of their pressure's mean over the last 0.4 s, less ρ g (H − z), over ρ g H."""
    gravity, height, sums = 9.81, 0.2, {}
    for time, path in measure.frames(folder, "fluid"):
        if time < 0.6 - 1e-9:
            continue
        frame = measure.read_frame(path, ("pressure", "id"))
        for i, p, y in zip(frame["id"], frame["pressure"], frame["points"][1::3]):
            of = sums.setdefault(i, [0.0, 0])
            of[0] += p / 1000 - gravity * (height - y)
            of[1] += 1
    return math.sqrt(statistics.fmean((p / n) ** 2 for p, n in sums.values())) / (gravity * height)


def wick_error(folder, settings, _):
    """rms over the nodes and times of s − erfc((x − x0)/2√(D t)), that of a strip without end."""
    squares = []
    for time, path in measure.frames(folder, "cloth"):
        if time <= 0:
            continue
        frame = measure.read_frame(path, ("saturation",))
        for x, s in zip(frame["points"][::3], frame["saturation"]):
            if x > -0.179:
                squares.append((s - math.erfc((x + 0.18) / (2 * math.sqrt(1e-3 * time)))) ** 2)
    return math.sqrt(statistics.fmean(squares))


def sheet_series(folder, settings):
    """Height of the middle, and the mean over the sheet: a node on the boundary stands for half of one inside."""
    n = settings["nodes"]
    weight = [(0.5 if i in (0, n - 1) else 1) for i in range(n)]
    middle, mean = [], []
    for time, path in measure.frames(folder, "cloth"):
        y = measure.read_frame(path, ())["points"][1::3]
        middle.append((time, (y[(n * n - 1) // 2],)))
        mean.append((time, (sum(weight[k % n] * weight[k // n] * y[k] for k in range(n * n)) / (n - 1) ** 2,)))
    return {"middle": middle, "mean height": mean}


def liquid(folder, settings):
    series, _ = liquid_series(folder)
    return {q: series[q] for q in ("centre", "energy", "spread")}


def liquid_and_cloth(folder, settings):
    series, axis = liquid_series(folder)
    return {q: s for q, s in {**series, **cloth_series(folder, axis)}.items() if q != "front"}


class Study:
    """`base` are the settings, `changes` what is tried of each, one at a time; `finest` the run that errors are against,
    with `series` of each run, or `error` an analytic answer. A pair of keys changes both."""

    def __init__(self, title, scene, base, changes, finest=None, series=None, error=None):
        self.title, self.scene, self.base, self.changes = title, scene, base, changes
        self.finest, self.series, self.error = finest, series, error


LIQUID = {"spacing": 0.01, "step": 0.004, "tolerance": 1e-3, "kernel": "cubic", "support": 2.0, "sort": "auto",
          "precision": "float"}
STUDIES = {
    "column": Study("water at rest, 0.2 m deep: pressure against ρ g (H − z)", COLUMN, LIQUID,
                    {"spacing": [0.02, 0.008], "step": [0.008, 0.002, 0.001], "tolerance": [1e-2, 1e-4, 1e-5],
                     "kernel": ["wendland", "poly6"], "support": [1.8, 2.5], "precision": ["double"],
                     "sort": ["counting", "radix", "bitonic"]},
                    error=column_error),
    "splash": Study("a block of 16 cm collapses in a box: centre, energy and spread against the finest run", SPLASH,
                    {**LIQUID, "mode": "fixed"},
                    {"spacing": [0.02, 0.016, 0.008], "step": [0.008, 0.002, 0.001], "mode": ["cfl"],
                     "tolerance": [1e-2, 1e-4], "kernel": ["wendland", "poly6"], "support": [2.5], "precision": ["double"],
                     "sort": ["radix"]},
                    finest={"spacing": 0.005, "step": 0.001, "tolerance": 1e-4, "precision": "double"}, series=liquid),
    "sheet": Study("a sheet of 1 m, held at its corners, falls and swings: height against the finest run", SHEET,
                   {"nodes": 31, "step": 0.004, "method": "pd", "tolerance": 1e-3, "iterations": 300, "precision": "float"},
                   {"nodes": [15, 61], "step": [0.008, 0.002, 0.001], "method": ["xpbd"], "tolerance": [1e-1, 1e-2, 1e-4],
                    "iterations": [5, 10, 20, 40], "precision": ["double"], "nodes, step": [(61, 0.001)],
                    "step, iterations": [(0.001, 10), (0.002, 20)]},
                   finest={"nodes": 61, "step": 0.0005, "tolerance": 1e-5, "iterations": 3000, "precision": "double"},
                   series=sheet_series),
    "wick": Study("a strip wicks from a reservoir: saturation against erfc", WICK,
                  {"nodes": 41, "across": 11, "step": 0.02, "precision": "float"},
                  {"nodes": [21, 81, 161], "step": [0.1, 0.04, 0.005], "precision": ["double"]}, error=wick_error),
    "soak": Study("a block of water falls on a porous sheet: liquid, sag and uptake against the finest run", SOAK,
                  {"spacing": 0.01, "step": 0.004, "tolerance": 1e-3, "cloth": 1e-3, "precision": "float"},
                  {"spacing": [0.016, 0.008], "step": [0.002, 0.001], "tolerance": [1e-2, 1e-4], "cloth": [1e-1, 1e-2],
                   "precision": ["double"], "step, tolerance": [(0.002, 1e-2), (0.001, 1e-2), (0.001, 1e-4)]},
                  finest={"spacing": 0.00667, "step": 0.0005, "tolerance": 1e-4, "cloth": 1e-4, "precision": "double"},
                  series=liquid_and_cloth),
}


def variants(study):
    """[(what is changed, settings)], the base first."""
    rows = [("as it is", dict(study.base))]
    for key, values in study.changes.items():
        names = key.split(", ")
        for value in values:
            one = dict(zip(names, value if len(names) > 1 else (value,)))
            rows.append((", ".join(f"{k} {shown(k, v)}" for k, v in one.items()), {**study.base, **one}))
    return rows


def shown(key, value):
    if key == "step":
        return f"{1000 * value:g} ms"
    if key == "spacing":
        return f"{1000 * value:g} mm"
    return f"{value:g}" if isinstance(value, float) else str(value)


def run_study(name, study, opt, binaries, scratch):
    """Rows for the table, and what went wrong."""
    rows, problems, exact = [], [], None

    def run(what, settings):
        print(f"{name}: {what} ...", flush=True, file=measure.sys.stderr)
        folder = scratch / f"{name}_{len(rows)}_{what.replace(' ', '_').replace(',', '')}"
        scene = scratch / f"{folder.name}.yaml"
        scene.write_text(study.scene.format(**settings))
        done = measure.Run(binaries[settings["precision"]], scene, folder, opt.threads, settings=opt.set,
                           seconds=opt.max_seconds)
        problem = done.problem or (f"not done in {opt.max_seconds:g} s" if done.cut else "")
        if problem:
            problems.append(f"{name}, {what}: {problem}")
        return None if problem else done

    if study.finest:
        settings = {**study.base, **study.finest}
        done = run("the finest", settings)
        if not done:
            return rows, problems
        exact = study.series(done.folder, settings)
    for what, settings in variants(study):
        done = run(what, settings)
        if not done:
            continue
        if study.error:
            errors = {"error": study.error(done.folder, settings, exact)}
            worst = errors["error"]
        else:
            series = study.series(done.folder, settings)
            errors = {q: error_of(series[q], exact[q]) for q in exact}
            worst = max(e or 0 for e in errors.values())
        simulated = sum(done.column("dt"))
        rows.append({"study": name, "changed": what, "time": sum(done.column("ms_step")) / 1000 / simulated,
                     "ms_step": done.mean("ms_step"), "error": worst, "reference": 0,
                     **{key: done.mean(key) for key in ("density_iterations", "cloth_iterations", "density_error")},
                     "errors": "; ".join(f"{q} {100 * e:.2g} %" for q, e in errors.items() if e is not None),
                     "at_cap": "; ".join(f"{solve} {n}" for solve, n in done.at_cap()), "pareto": 0})
        mark_pareto(rows)
    return rows, problems


def print_study(study, rows):
    print(f"**{study.title[0].upper() + study.title[1:]}**\n")
    print("As it is: " + ", ".join(f"{k} {shown(k, v)}" for k, v in study.base.items()) + "." +
          (" The finest: " + ", ".join(f"{k} {shown(k, v)}" for k, v in study.finest.items()) + "."
           if study.finest else "") + "\n")
    number = lambda value, form: format(value, form) if value is not None else "–"
    cells = [[r["changed"], f"{r['time']:.3g}", f"{r['ms_step']:.3g}", f"{100 * r['error']:.2g} %",
              "yes" if r["pareto"] else "", r["errors"] if not study.error else "", number(r["density_error"], ".1e"),
              number(r["density_iterations"], ".1f"), number(r["cloth_iterations"], ".1f"), r["at_cap"] or "none"]
             for r in sorted(rows, key=lambda r: r["time"])]
    head = ["changed", "s for a simulated second", "ms per step", "error", "Pareto", "of it", "density error",
            "density iterations", "cloth iterations", "steps at the limit"]
    useless = set() if "spacing" in study.base else {"density error", "density iterations"}
    empty = [k for k, name in enumerate(head) if name in useless or all(c[k] in ("", "–") for c in cells)]
    measure.table(*([c for k, c in enumerate(row) if k not in empty] for row in [head]),
                  [[c for k, c in enumerate(row) if k not in empty] for row in cells])


def run_studies(opt, binaries, scratch):
    """Of each of opt.study; returns what went wrong. --table keeps the rows of all of them."""
    everything, problems = [], []
    for name in opt.study:
        rows, wrong = run_study(name, STUDIES[name], opt, binaries, Path(scratch))
        problems += wrong
        everything += rows
        if rows:
            print_study(STUDIES[name], rows)
        if opt.table and everything:
            measure.write_csv(opt.table, everything)
    return problems


def draw_studies(rows, path):
    """Time against error, a panel a study; runs that differ in the same setting have the same colour."""
    pyplot = measure.matplotlib()
    names = list(dict.fromkeys(r["study"] for r in rows))
    across = min(3, len(names))
    figure, plots = pyplot.subplots(-(-len(names) // across), across, figsize=(5.2 * across, 4.4 * -(-len(names) // across)),
                                    squeeze=False)
    for plot in plots.flat[len(names):]:
        plot.axis("off")
    for name, plot in zip(names, plots.flat):
        part = [r for r in rows if r["study"] == name]
        keys = list(dict.fromkeys(r["changed"].rsplit(" ", 1)[0].split(" ")[0] for r in part[1:]))
        base = part[0]
        plot.plot(float(base["time"]), 100 * float(base["error"]), "k*", markersize=14)
        for r in part[1:]:
            colour = f"C{keys.index(r['changed'].split(' ')[0]) % 10}"
            plot.plot(float(r["time"]), 100 * float(r["error"]), "o", color=colour)
            plot.annotate(r["changed"], (float(r["time"]), 100 * float(r["error"])), fontsize=7, color=colour,
                          xytext=(4, 3), textcoords="offset points")
        front = sorted((float(r["time"]), 100 * float(r["error"])) for r in part if r["pareto"] == "1")
        plot.step(*zip(*front), where="post", color="black", alpha=0.2, linewidth=5, zorder=0)
        plot.set_xscale("log")
        plot.set_yscale("log")
        plot.grid(True, which="both", alpha=0.3)
        plot.set_title(name)
        plot.set_xlabel("wall time for a simulated second (s)")
        plot.set_ylabel("error (%)")
    figure.tight_layout()
    figure.savefig(path, dpi=100)
