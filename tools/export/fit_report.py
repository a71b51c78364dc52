"""What `drench fit` writes: a fabric file, a table, a plot and the text for the terminal."""

import csv
import json
import math
import re
from pathlib import Path

COLOURS = {"data": "#1f4e79", "fit": "#c8501e", "held": "#4b7f52"}


def rounded(value):
    return f"{value:.4g}"


def basis(parameter):
    """The word of docs/manual/fabrics.md for a fitted value."""
    return "derived" if parameter["identified"] else "assumed"


def interval(parameter):
    if parameter["at_bound"]:
        return "at its bound, so without an interval"
    if not parameter["interval"]:
        return "not determined by these curves"
    return f"95 % interval {rounded(parameter['low'])} to {rounded(parameter['high'])}"


def in_yaml(text):
    """In quotes where it needs them."""
    return text if re.fullmatch(r"[A-Za-z_][\w.-]*", text) else json.dumps(text)


def fabric_file(found, name):
    """A scene of one square of the fabric; its keys stand where a cloth of another scene has them."""
    name = name or (Path(found["fabric"]).stem if found["fabric"] != "none" else "fabric") + "_fitted"
    lines = [f"# {name}: {found['fabric']} with values fitted by `drench fit`.",
             f"# Date {found['date']}; drench {found['drench']}; SciPy {found['scipy']}."]
    for title, curves in (("Fitted to", found["curves"]), ("Held out:", found["held_out"])):
        for c in curves:
            lines.append(f"# {title} {c['file']} ({c['test']}, {c['direction']}, {c['quantity']}, {c['points']} points): "
                         f"error {rounded(c['rms_error'])} {c['unit']}" +
                         (f", {100 * c['relative_error']:.2g} %" if c["relative_error"] is not None else ""))
            lines += [f"#   {about}" for about in c["about"]]
    lines += [f"# Warning: {w}" for w in found["warnings"]]
    lines += ["# Use: `fabric: fabric.yaml` in a cloth of another scene. `drench check` prints the values of the named fabric that remain.",
              "# derived: computed from measurements of this fabric; assumed: the measurements do not determine it; given: by --set.",
              "drench: 1", "cloth:", f"  - name: {in_yaml(name)}", "    mesh: {grid: {size: [0.1, 0.1], nodes: [5, 5]}}"]
    if found["fabric"] != "none":
        lines.append(f"    fabric: {in_yaml(found['fabric'])}")
    entries = {}
    for s in found["settings"]:
        match = re.match(r"cloth\.0\.((?:membrane|bending|porous)\.)?(\w+)=(.*)$", s)
        if match and match.group(2) in ("areal_density", "thickness", "compression", "stretch", "bend", "friction", "adhesion",
                                        "strain_limit") or match and match.group(1):
            entries.setdefault((match.group(1) or "").rstrip("."), []).append((match.group(2), match.group(3), "given"))
    for p in found["parameters"]:
        group, _, key = p["key"].removeprefix("cloth.0.").rpartition(".")
        unit = f"{p['unit']}; " if p["unit"] else ""
        files = ", ".join(dict.fromkeys(Path(c["file"]).name for c in found["curves"]))
        tests = ", ".join(dict.fromkeys(c["test"] for c in found["curves"]))
        entries.setdefault(group, []).append((key, f"{p['value']:.5g}", f"{unit}{basis(p)}: fitted to {files} by {tests}, {interval(p)}"))
    for group in sorted(entries):
        if group:
            lines.append(f"    {group}:")
        for key, value, note in entries[group]:
            lines.append(f"    {'  ' if group else ''}{key}: {value}  # {note}")
    if "porous" not in entries:
        lines.append("    porous: {}")
    return "\n".join(lines) + "\n"


def write_table(path, curves, held):
    with path.open("w", encoding="utf-8", newline="") as file:
        out = csv.writer(file)
        out.writerow(["file", "use", "across", "across unit", "quantity", "unit", "at", "measured", "simulated", "difference"])
        for use, group in (("fit", curves), ("held out", held)):
            for c in group:
                for x, y, model in c["rows"]:
                    out.writerow([c["file"], use, c["across"] or "", c["across_unit"] or "", c["quantity"], c["unit"],
                                  "" if x is None else f"{x:.7g}", f"{y:.7g}", f"{model:.7g}", f"{model - y:.4g}"])


def error_line(c):
    percent = f" ({100 * c['relative_error']:.1f} %)" if c["relative_error"] is not None else ""
    return (f"  {Path(c['file']).name}, {c['test']}, {c['quantity']}, {c['points']} points: "
            f"error {rounded(c['rms_error'])} {c['unit']}{percent}, mean {c['mean_error']:+.3g}, largest {rounded(c['largest_error'])}" +
            (f", R² {c['r_squared']:.4f}" if c["r_squared"] is not None else "") +
            (f", standard deviation {rounded(c['scatter'])}" if c["scatter"] is not None else ""))


def failure(c):
    """Why a curve was not met; "" if it was. Errors below 5 % are no failure: R² of a flat curve may be below 0."""
    name = Path(c["file"]).name
    if c["across"]:
        flat = c["r_squared"] is not None and c["r_squared"] < 0 and c["relative_error"] > 0.05
        return f"{name}: R² below 0 means that a horizontal line fits the data better" if flat else ""
    misfit, scatter = abs(c["mean_error"]), c["scatter"] or 0
    if misfit <= max(2 * scatter, 0.05 * c["mean"]):
        return ""
    return f"{name}: the simulated value is {rounded(misfit)} {c['unit']} from the mean of the specimens" + (
        f", {misfit / scatter:.2g} times their standard deviation" if scatter else "")


def text(found):
    wide = max(len(p["key"]) for p in found["parameters"]) - len("cloth.0.")
    lines = [f"fabric {found['fabric']}, {found['degrees_of_freedom']} degrees of freedom, {found['steps']} steps, "
             f"{found['simulated_runs']} simulated runs", ""]
    for p in found["parameters"]:
        lines.append(f"  {p['key'].removeprefix('cloth.0.'):<{wide}}  {p['value']:<11.5g} {p['unit']:<6} {interval(p)}")
    lines += ["", *map(error_line, found["curves"])]
    lines += [f"  warning: {why}: this fit failed. Check data and units, or fit other parameters."
              for why in map(failure, found["curves"]) if why]
    if found["equation_against_simulation"] is not None:
        lines.append(f"  The errors are those of simulated runs; the fit used the equation of the strip, which differs by "
                     f"{100 * found['equation_against_simulation']:.2f} % from them.")
    if found["held_out"]:
        lines += ["", "  Prediction of the data that was held out:", *map(error_line, found["held_out"])]
    return "\n".join(lines) + "\n\n"


# ---- plots


def draw(folder, curves, dense, fitted):
    """A panel for each file; returns the name of the picture."""
    try:
        import matplotlib
    except ImportError:
        (folder / "fit.svg").write_text(svg(curves, dense, fitted), encoding="utf-8")
        return "fit.svg"
    matplotlib.use("Agg")
    from matplotlib import pyplot
    figure, axes = pyplot.subplots(1, len(curves), figsize=(5.2 * len(curves), 4), squeeze=False)
    for k, (c, line) in enumerate(zip(curves, dense)):
        panel, held = axes[0][k], k >= fitted
        x = [row[0] if row[0] is not None else i + 1 for i, row in enumerate(c["rows"])]
        panel.plot(x, [row[1] for row in c["rows"]], "o", ms=4, color=COLOURS["held" if held else "data"],
                   label="held out" if held else "measured")
        if line:
            keep = line[0] <= 1.02 * max(x)
            panel.plot(line[0][keep], line[1][keep], "-", color=COLOURS["fit"], label="predicted" if held else "fitted")
        else:
            panel.axhline(c["rows"][0][2], color=COLOURS["fit"], label="predicted" if held else "fitted")
        panel.set_xlabel(f"{c['across']} ({c['across_unit']})" if c["across"] else "specimen")
        panel.set_ylabel(f"{c['quantity']} ({c['unit']})")
        panel.set_title(f"{Path(c['file']).name}, {c['test']}", fontsize=9)
        panel.set_ylim(bottom=0)
        panel.grid(True, alpha=0.3)
        panel.legend(fontsize=8)
    figure.tight_layout()
    figure.savefig(folder / "fit.png", dpi=120)
    pyplot.close(figure)
    return "fit.png"


def ticks(top):
    step = 10 ** math.floor(math.log10(top / 2)) if top > 0 else 1
    step *= next((f for f in (1, 2, 5) if top / (step * f) <= 6), 10)
    return [k * step for k in range(int(top / step) + 1)]


def escaped(word):
    return word.replace("&", "&amp;").replace("<", "&lt;")


def svg(curves, dense, fitted):
    """The same plot without matplotlib."""
    width, height, left, bottom, above, gap = 480, 340, 60, 44, 28, 12
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width * len(curves)}" height="{height}" font-family="sans-serif" '
             'font-size="11">', f'<rect width="{width * len(curves)}" height="{height}" fill="white"/>']
    for k, (c, line) in enumerate(zip(curves, dense)):
        x = [row[0] if row[0] is not None else i + 1 for i, row in enumerate(c["rows"])]
        y = [row[1] for row in c["rows"]]
        right = 1.02 * max(x) or 1.0
        path = [(a, b) for a, b in zip(*line) if a <= right] if line else [(0, c["rows"][0][2]), (right, c["rows"][0][2])]
        top = 1.05 * max([*y, *(b for _, b in path), 1e-300])

        def place(a, b, k=k, right=right, top=top):
            return (k * width + left + a / right * (width - left - gap), above + (1 - max(b, 0) / top) * (height - above - bottom))

        for t in ticks(right):
            a, b = place(t, 0)
            parts.append(f'<path d="M{a:.1f} {b:.1f}V{above}" stroke="#ddd"/>'
                         f'<text x="{a:.1f}" y="{b + 14:.1f}" text-anchor="middle">{t:.4g}</text>')
        for t in ticks(top):
            a, b = place(0, t)
            parts.append(f'<path d="M{a:.1f} {b:.1f}H{(k + 1) * width - gap}" stroke="#ddd"/>'
                         f'<text x="{a - 5:.1f}" y="{b + 4:.1f}" text-anchor="end">{t:.4g}</text>')
        points = " ".join("{:.1f},{:.1f}".format(*place(a, b)) for a, b in path)
        parts.append(f'<polyline points="{points}" fill="none" stroke="{COLOURS["fit"]}" stroke-width="1.5"/>')
        colour = COLOURS["held" if k >= fitted else "data"]
        parts += ['<circle cx="{:.1f}" cy="{:.1f}" r="2.5" fill="{}"/>'.format(*place(a, b), colour) for a, b in zip(x, y)]
        across = f"{c['across']} ({c['across_unit']})" if c["across"] else "specimen"
        middle = k * width + (left + width) / 2
        use = "held out, line: predicted" if k >= fitted else "measured, line: fitted"
        parts += [f'<text x="{middle}" y="{height - 8}" text-anchor="middle">{escaped(across)}</text>',
                  f'<text x="{k * width + left}" y="{above - 10}">{escaped(Path(c["file"]).name)}, {c["test"]}: '
                  f'{escaped(c["quantity"])} ({escaped(c["unit"])}); points: {use}</text>']
    return "\n".join([*parts, "</svg>"]) + "\n"
