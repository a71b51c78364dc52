"""Numbers over time of what drench writes, and how far two runs are apart in them; shared by tools/measure/speed_error and its studies."""

import itertools
import math
import operator
import statistics

import measure

QUANTITIES = ("centre", "energy", "spread", "sag", "absorbed", "wet")  # front is shown beside them


# --- Quantities: a time series each, of tuples of numbers

def liquid_series(folder):
    centre, energy, spread, front, axis = [], [], [], [], None
    for time, path in measure.frames(folder, "fluid"):
        frame = measure.read_frame(path, ("mass", "velocity"))
        mass, at = frame["mass"], [frame["points"][k::3] for k in range(3)]
        total = sum(mass)
        if not total:
            energy.append((time, (0.0,)))
            for series in (centre, spread, front):
                series.append((time, None))
            continue
        middle = tuple(sum(map(operator.mul, mass, x)) / total for x in at)
        axis = axis or middle
        speed = [frame["velocity"][k::3] for k in range(3)]
        centre.append((time, middle))
        energy.append((time, (0.5 * sum(sum(map(operator.mul, mass, map(operator.mul, v, v))) for v in speed),)))
        way = sorted((math.hypot(x - axis[0], z - axis[2]), m) for x, z, m in zip(at[0], at[2], mass))
        spread.append((time, (sum(r * m for r, m in way) / total,)))
        inside = itertools.accumulate(m for _, m in way)
        front.append((time, (next(r for (r, _), m in zip(way, inside) if m >= 0.95 * total * (1 - 1e-9)),)))
    return {"centre": centre, "energy": energy, "spread": spread, "front": front}, axis


def cloth_series(folder, axis):
    sag, absorbed, wet = [], [], []
    for time, path in measure.frames(folder, "cloth"):
        frame = measure.read_frame(path, ("liquid_mass",))
        at = [frame["points"][k::3] for k in range(3)]
        sag.append((time, (statistics.fmean(at[1]),)))
        if "liquid_mass" not in frame:
            continue
        mass, (x0, _, z0) = frame["liquid_mass"], axis or (0, 0, 0)
        total = sum(mass)
        absorbed.append((time, (total,)))
        second = sum(m * ((x - x0) ** 2 + (z - z0) ** 2) for x, z, m in zip(at[0], at[2], mass))
        wet.append((time, (math.sqrt(second / total),) if total > 0 else None))
    return {"sag": sag, "absorbed": absorbed, "wet": wet}


def series_of(folder):
    liquid, axis = liquid_series(folder)
    return {**liquid, **cloth_series(folder, axis)}


def error_of(series, exact):
    """Root mean square of the difference over the range; None where there is nothing that changes."""
    if [round(t, 9) for t, _ in series] != [round(t, 9) for t, _ in exact]:
        raise ValueError("its frames are not at the finest run's times")
    both = [(a, b) for (_, a), (_, b) in zip(series, exact) if a and b]
    if not both:
        return None
    size = math.sqrt(sum((max(column) - min(column)) ** 2 for column in zip(*(b for _, b in both))))
    if size <= 1e-9 * max(abs(v) for _, b in both for v in b):
        return None
    return math.sqrt(statistics.fmean(math.dist(a, b) ** 2 for a, b in both)) / size


def mark_pareto(rows):
    """No other row is as quick and as near to the finest, and better in one of them; the finest does not count."""
    others = [r for r in rows if not r["reference"]]
    for row in others:
        row["pareto"] = int(not any(o["time"] <= row["time"] and o["error"] <= row["error"] and
                                    (o["time"], o["error"]) != (row["time"], row["error"]) for o in others))
