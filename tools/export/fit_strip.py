"""The vertical wicking test of `drench test aatcc197` along one line of nodes: Eq. 16c and 18b of docs/theory/porous.md on the
same nodes, integrated by SciPy. It takes 0.1 s, where the simulation takes several."""

import numpy
from scipy.integrate import solve_ivp

LENGTH, CELLS, IMMERSED, WET = 0.165, 82, 0.005, 0.1  # m, 1, m, saturation, as in src/laboratory/wicking_tests.cpp
WIDTH, DENSITY = 0.025, 1000.0  # m, kg/m³
TOP = (CELLS - int(IMMERSED * CELLS / LENGTH + 1e-6)) * LENGTH / CELLS  # m, of the strip's end above the water

# keys that this model knows; with others, only the simulation is right
KEYS = {"porous.diffusivity", "porous.weft_diffusivity", "porous.diffusion_exponent", "porous.capillary_height",
        "porous.retention_exponent", "porous.solid_fraction", "thickness"}


def saturations(diffusivity, exponent, height, retention, times):
    """Rows of saturations at the given times, s, from the lower end of the strip to the upper one."""
    cell = LENGTH / CELLS
    held = numpy.arange(CELLS + 1) * cell <= IMMERSED * (1 + 1e-6)
    share = numpy.ones(CELLS + 1)
    share[-1] = 0.5
    power = exponent / retention

    def flows(_, s):
        s = numpy.clip(s, 0, 1)
        t = s**retention
        low, high = t[:-1], t[1:]
        rise = high - low
        close = numpy.abs(rise) < 1e-7
        mean = numpy.where(close, (0.5 * (low + high))**power,
                           (high**(power + 1) - low**(power + 1)) / ((power + 1) * numpy.where(close, 1, rise)))
        drive = rise / cell + 1 / height
        donor = numpy.where(drive > 0, s[1:], s[:-1])
        flow = diffusivity * numpy.minimum(mean, 2 * donor**exponent) * drive  # downwards
        change = numpy.zeros_like(s)
        change[:-1] += flow
        change[1:] -= flow
        change /= cell * share
        change[held] = 0
        return change

    start = held.astype(float)
    done = solve_ivp(flows, (0, times[-1]), start, method="LSODA", t_eval=times, rtol=1e-5, atol=1e-7, lband=1, uband=1)
    if not done.success:
        return None
    return numpy.clip(done.y.T, 0, 1)


def heights(rows):
    """Heights of the wet part above the water, m, as the test measures them."""
    cell = LENGTH / CELLS
    first = int(IMMERSED / cell + 1e-6)
    found = []
    for s in rows:
        dry = numpy.flatnonzero(s[first + 1:] < WET)
        if len(dry) == 0:
            found.append(TOP)
            continue
        k = first + 1 + dry[0]
        below = 1.0 if k == first + 1 else s[k - 1]
        found.append(max(0.0, (k - 1 - first) * cell + cell * (below - WET) / max(1e-12, below - s[k])))
    return numpy.array(found)


def curve(values, end, direction):
    """Time (s), height (mm) and absorbed water (g) for the values of the keys; None where the equation cannot be integrated."""
    times = numpy.concatenate([numpy.arange(0, min(end, 60) + 1e-9, 1), numpy.arange(70, end + 1e-9, 10)])
    if times[-1] < end * (1 - 1e-9):
        times = numpy.append(times, end)
    diffusivity = values["porous.diffusivity"]
    if direction == "weft":
        diffusivity = values.get("porous.weft_diffusivity", diffusivity)
    rows = saturations(diffusivity, values.get("porous.diffusion_exponent", 0.0), values["porous.capillary_height"],
                       values.get("porous.retention_exponent", 1.0), times)
    if rows is None:
        return None
    weights = numpy.full(CELLS + 1, LENGTH / CELLS)
    weights[[0, -1]] /= 2
    mass = (rows @ weights) * WIDTH * (1 - values["porous.solid_fraction"]) * values["thickness"] * DENSITY
    return times, 1e3 * heights(rows), 1e3 * mass
