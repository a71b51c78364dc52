"""What `drench fit` runs: finds values of a fabric with which tests of `drench test` give measured curves (docs/manual/fit.md)."""

import argparse
import itertools
import json
import math
import os
import signal
import sys
from datetime import date
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from refusal import fail  # noqa: E402

REMEDY = "run tools/setup fit, or name a Python that has numpy and scipy in DRENCH_PYTHON"
try:
    import numpy
    import scipy
    from scipy.optimize import least_squares
except ImportError as error:
    fail(f"fit needs Python's {error.name}: {REMEDY}")

import fit_report  # noqa: E402
from fit_data import Curve, is_number, test_named  # noqa: E402
from fit_runs import Program, Rejection, RunError, is_of_fabric, resolve  # noqa: E402

STEP = 0.03  # of the logarithm of a parameter, for differences
SPAN = 100.0  # bounds over and under the start, by default
EXACT = 1e-4  # error over the root mean square of the data, below which the search ends: less than that of a run
WIDEST = SPAN**2  # ratio of the ends of an interval: a wider one says nothing about the value
FLAT = 0.02  # change of a curve over its largest value, below which it is warned of
AGREE = 0.01  # largest difference of the strip's equation from the simulation, over the root mean square of the data

# where a parameter acts, for advice
TESTS_FOR = {"porous.diffusivity": "aatcc197", "porous.weft_diffusivity": "aatcc197 (weft)", "porous.capillary_height": "aatcc197",
             "porous.diffusion_exponent": "aatcc197", "porous.retention_exponent": "aatcc197", "porous.permeability": "iso9073-8",
             "porous.uptake_velocity": "aatcc79", "porous.breakthrough_pressure": "iso811", "porous.critical_saturation": "iso17617",
             "membrane.warp": "iso13934-1 (warp)", "membrane.weft": "iso13934-1 (weft)", "membrane.shear": "iso9073-9",
             "membrane.warp_locking": "iso13934-1 (warp)", "membrane.weft_locking": "iso13934-1 (weft)",
             "bending.warp": "iso9073-7 (warp)", "bending.weft": "iso9073-7 (weft)", "bend": "iso9073-7", "stretch": "iso13934-1",
             "areal_density": "none: weigh the fabric"}
ADVICE = {
    frozenset(["porous.diffusivity", "porous.capillary_height"]):
        "heights until the strip has nearly stopped rising, or the wet area of aatcc198, on which capillary_height has little effect",
    frozenset(["porous.diffusivity", "porous.diffusion_exponent"]):
        "the absorbed mass over time: the exponent shapes the saturation below the front",
    frozenset(["porous.capillary_height", "porous.diffusion_exponent"]):
        "the absorbed mass over time: the exponent shapes the saturation below the front",
    frozenset(["porous.solid_fraction", "thickness"]): "a measured thickness; the absorbed mass depends only on their product",
    frozenset(["areal_density", "bending.warp"]): "the mass per unit area from scales; the bending length depends only on their ratio",
    frozenset(["areal_density", "bending.weft"]): "the mass per unit area from scales; the bending length depends only on their ratio",
}


class Exact(Exception):
    """The search met the data; `x` is the point."""

    def __init__(self, x):
        super().__init__()
        self.x = x


class Fit:
    def __init__(self, opt):
        self.opt = opt
        if opt.hold_out_test and not opt.hold_out:
            fail("--hold-out-test: names the test of a file of --hold-out, which is missing")
        end, standard = given_end(opt.set), all(is_of_fabric(s) or s.startswith(("time.", "air.")) for s in opt.set)
        self.curves = [Curve(path, test, opt.direction, end, standard) for path, test in
                       pairs(opt.data, opt.test, "--test", "data file")]
        self.held = [Curve(path, test, opt.direction, end, standard) for path, test in
                     pairs(opt.hold_out, opt.hold_out_test or opt.test[:1], "--hold-out-test", "--hold-out")]
        self._check_data()
        self.folder = output_folder(opt)
        if opt.fabric.endswith((".yaml", ".yml")):
            opt.fabric = str(Path(opt.fabric).resolve())
        self.program = Program(opt.program, opt.fabric, opt.set, self.folder, opt.jobs or max(1, len(os.sched_getaffinity(0))))
        self.base = self.program.values()
        self.keys = self.program.keys()
        self.names = []
        for word in opt.parameters:
            key = resolve(word, self.keys)
            if key in self.names:
                fail(f"--parameters: {word} is given twice")
            if any(s.startswith(f"cloth.0.{key}=") for s in opt.set):
                fail(f"--parameters: {key} is fixed by --set; remove one of them")
            self.names.append(key)
        self._choose_start()
        # one end for all curves of a test, so that they share runs
        self.ends = {}
        for curve in self.curves + self.held:
            if curve.end:
                self.ends[curve.test_name] = max(self.ends.get(curve.test_name, 0), curve.end)
        self.quick = False
        self.evaluations = 0
        self.warnings = []

    def _check_data(self):
        for c in self.curves:
            if not c.given_y.max() > 0:
                c.refuse(c.lines[0], f"{c.y_name}: no value is above 0, so there is nothing to fit")
        fitted = [Path(c.path).resolve() for c in self.curves]
        for k, path in enumerate(fitted):
            if path in fitted[:k]:  # its points would count twice, and the intervals would be too narrow
                fail(f"{self.curves[k].path}: is given twice; remove one")
        for c in self.held:
            if Path(c.path).resolve() in fitted:
                fail(f"--hold-out: {c.path} is fitted too, so it cannot be predicted; remove it from one of them")
        points, parameters = self.points(), len(self.opt.parameters)
        if not parameters:
            fail("--parameters: names no key of the fabric; for example: --parameters diffusivity,capillary_height")
        if points < parameters:
            fail(f"{points} point{'s' if points > 1 else ''} for {parameters} parameters; "
                 "add points, or fix parameters with --set")

    def points(self):
        return sum(int(c.kept.sum()) for c in self.curves)

    def _choose_start(self):
        given, bounds = {}, {}
        for words, into, form, option in ((self.opt.start, given, "NAME=VALUE", "--start"),
                                          (self.opt.bounds, bounds, "NAME=LOW:HIGH", "--bounds")):
            for word in words:
                name, _, value = word.partition("=")
                parts = value.split(":")
                if len(parts) != (1 if into is given else 2) or not all(map(is_number, parts)) or not all(float(p) > 0 for p in parts):
                    fail(f"{option}: {word} is not allowed; allowed: {form} with numbers above 0")
                key = resolve(name, self.keys)
                if key not in self.names:
                    fail(f"{option}: {key} is not one of --parameters")
                into[key] = [float(p) for p in parts] if into is bounds else float(value)
                if into is bounds and not into[key][0] < into[key][1]:
                    fail(f"{option}: {word} is not allowed; allowed: LOW below HIGH")
        start, low, high = [], [], []
        for key in self.names:
            least, most = self.keys[key][:2]
            value = given.get(key, math.sqrt(math.prod(bounds[key])) if key in bounds else self.base.get(key, 0))
            if not value > 0:
                fail(f"--parameters: {key} of {self.opt.fabric} is {value:g} or not given, and the fit varies its logarithm: "
                     f"give --start {key}=VALUE")
            a, b = bounds.get(key, (max(least, value / SPAN), min(most, value * SPAN)))
            if a < least or b > most:
                fail(f"--bounds: {key} is allowed from {least:g} to {most:g}")
            if not a <= value <= b:
                fail(f"--start: {key}={value:g} is outside its bounds, {a:g} to {b:g}")
            start.append(value)
            low.append(a)
            high.append(b)
        self.start = numpy.log(start)
        self.low, self.high = numpy.log(low), numpy.log(high)
        inset = 1e-3 * (self.high - self.low)
        self.start = numpy.clip(self.start, self.low + inset, self.high - inset)

    def say(self, text):
        if not self.opt.quiet:
            print(text, file=sys.stderr, flush=True)

    def values(self, x):
        return dict(zip(self.names, numpy.exp(x)))

    # ---- evaluation

    def begin(self, x, curves, simulate=False):
        for test in {c.test_name for c in curves}:
            if simulate or not self.is_quick(test):
                self.program.start(test, self.values(x), self.ends.get(test))

    def is_quick(self, test):
        return self.quick and self.program.has_strip(test, self.names)

    def result(self, test, x, simulate=False):
        if not simulate and self.is_quick(test):
            found = self.program.strip(self.base, self.values(x), self.ends.get(test))
            if found is not None:
                return found
        return self.program.start(test, self.values(x), self.ends.get(test)).result()

    def residuals(self, x, simulate=False):
        self.begin(x, self.curves, simulate)
        return numpy.concatenate([c.residuals(self.result(c.test_name, x, simulate)) for c in self.curves])

    def cost(self, x):
        if self.program.jobs > 1:  # the Jacobian's runs, which are next, keep the other cores busy
            self.begin(x, self.curves)
            for _, up in self.differences(x):
                self.begin(up, self.curves)
        found = self.residuals(x)
        self.evaluations += 1
        text = ", ".join(f"{k.rsplit('.', 1)[-1]} {v:.4g}" for k, v in self.values(x).items())
        error = math.sqrt(numpy.mean(found**2))
        self.say(f"[{self.evaluations}] {text}: error {100 * error:.2f} %")
        if error < EXACT:
            raise Exact(x)
        return found

    def differences(self, x, central=False):
        """Two points for the derivative by each parameter; the first is x itself where a one-sided difference will do."""
        points = []
        for k in range(len(x)):
            up, down = x.copy(), x.copy()
            up[k] = min(x[k] + STEP, self.high[k])
            if central or up[k] <= x[k]:
                down[k] = max(x[k] - STEP, self.low[k])
            points.append((down, up))
        return points

    def jacobian(self, x, central=False):
        points = self.differences(x, central)
        for down, up in points:
            self.begin(down, self.curves)
            self.begin(up, self.curves)
        return numpy.column_stack([(self.residuals(up) - self.residuals(down)) / (up - down).sum() for down, up in points])

    def difference(self, x):
        """Largest difference of the strip's equation from the simulation at the points of the data."""
        worst = 0.0
        for c in self.curves:
            if self.is_quick(c.test_name):
                a, b = (c.residuals(self.result(c.test_name, x, simulate)) for simulate in (False, True))
                worst = max(worst, float(numpy.max(numpy.abs(a - b) / c.weight)))
        return worst

    # ---- the fit

    def solve(self, start):
        """The solution and whether the search converged."""
        inside = numpy.clip(start, self.low + 1e-9, self.high - 1e-9)
        try:
            found = least_squares(self.cost, inside, jac=self.jacobian, bounds=(self.low, self.high), method="trf",
                                  x_scale=1.0, xtol=1e-3, ftol=1e-4, gtol=1e-9, max_nfev=self.opt.max_steps)
        except Exact as exact:
            return rounded(exact.x), True
        return rounded(found.x), found.status != 0

    def of_varying_end(self):
        return [c for c in self.curves if c.x_at is not None and not c.test.extends]

    def leave_out_far(self, x):
        """Leaves out, before the search, points much later than the end of the test, which would mislead it."""
        for c in self.of_varying_end():
            result = self.result(c.test_name, x)
            near = c.covered(result, reach=2)
            if self.points() - numpy.sum(~near) >= len(self.names) and numpy.any(c.given_y[near] > 0):
                c.keep(near, result)

    def leave_out(self, x, shrink):
        """Leaves out the points after the end of a test that ends at an event; returns whether the points have changed.
        With `shrink` it adds none again, so that a search that is repeated with the points that remain ends."""
        changed = False
        for c in self.of_varying_end():
            result = self.result(c.test_name, x)
            covered = c.covered(result)
            if shrink:
                covered &= c.kept
            same = numpy.array_equal(covered, c.kept)
            c.keep(covered, result)  # also if they are the same: the end of the test has moved
            if same:
                continue
            changed = True
            if not numpy.any(c.given_y[covered] > 0):
                fail(f"{c.note}; no point with a value above 0 remains")
            if self.points() < len(self.names):
                fail(f"{c.note}; too few remain for {len(self.names)} parameters")
        return changed

    def run(self):
        quick_tests = [c.test_name for c in self.curves if self.program.has_strip(c.test_name, self.names)]
        self.agreement = None
        if quick_tests and not self.opt.simulate:
            self.quick = True
            apart = self.difference(self.start)
            self.quick = apart <= AGREE
            self.say(f"aatcc197: the equation of the strip and the simulation differ by {100 * apart:.2f} %; the fit "
                     + ("uses the equation" if self.quick else "uses simulations"))
        x = self.start
        self.leave_out_far(x)
        for attempt in itertools.count():
            x, converged = self.solve(x)
            if self.quick:
                self.agreement = self.difference(x)
                if self.agreement > AGREE:
                    self.say(f"at the solution they differ by {100 * self.agreement:.2f} %; "
                             "the fit continues with simulations")
                    self.quick, self.agreement = False, None
                    x, converged = self.solve(x)
            if not self.leave_out(x, shrink=attempt > 1):
                break
            self.say(f"the fit continues with the {self.points()} points that the tests cover")
            x = min((x, self.start), key=lambda v: numpy.linalg.norm(self.residuals(v)))
        if not converged:
            self.warnings.append(f"the fit did not converge in {self.opt.max_steps} steps; use --max-steps or closer --bounds")
        self.begin(x, self.curves + self.held, simulate=True)
        self.warn_of_data(x)
        self.statistics(x)
        return self.report(x)

    def warn_of_data(self, x):
        for c in self.curves:
            if c.note:
                self.warnings.append(c.note)
            if c.x_at is not None and c.kept.sum() > 1 and numpy.ptp(c.y[c.kept]) < FLAT * c.y.max():
                self.warnings.append(f"{c.path}: {c.y_name} changes by less than {100 * FLAT:g} % over these points, "
                                     "so they do not determine how fast it changes; add points before")
        for c in list(self.held):
            result = self.result(c.test_name, x, simulate=True)
            c.keep(c.covered(result), result)
            if c.note:
                self.warnings.append(c.note)
            if not c.kept.any():
                self.held.remove(c)

    def statistics(self, x):
        jacobian = self.jacobian(x, central=True)
        residuals = self.residuals(x, simulate=True)
        self.freedom = len(residuals) - len(x)
        norms = numpy.linalg.norm(jacobian, axis=0)
        self.acts = norms > 1e-3 * math.sqrt(len(residuals))  # 1 % more of it changes the curves by more than 0.001 %
        self.intervals = [None] * len(x)
        self.sigma = math.sqrt(float(residuals @ residuals) / self.freedom) if self.freedom > 0 else None
        self.correlation = numpy.eye(len(x))
        self.at_bound = [k for k in range(len(x)) if min(x[k] - self.low[k], self.high[k] - x[k]) < 1e-3]
        for k in self.at_bound:
            self.warnings.append(f"{self.names[k]} ended at its bound, {math.exp(x[k]):.4g}; widen it with --bounds, "
                                 "or fix the value with --set")
        for k, name in enumerate(self.names):
            if not self.acts[k]:
                self.warnings.append(f"{name} has no effect on these curves, so it cannot be found: fix it with --set, or add a curve "
                                     f"of {TESTS_FOR.get(name, 'another test')}")
        active = numpy.flatnonzero(self.acts)
        self.condition = None
        if self.freedom <= 0:
            self.warnings.append(f"{len(residuals)} points for {len(x)} parameters: no confidence intervals; add points or fix parameters")
        if len(active) == 0:
            return
        scaled = jacobian[:, active] / norms[active]
        _, singular, axes = numpy.linalg.svd(scaled, full_matrices=False)
        self.condition = float(singular[0] / max(singular[-1], 1e-300))
        inverse = (axes.T / numpy.maximum(singular, 1e-12) ** 2) @ axes
        covariance = inverse / numpy.outer(norms[active], norms[active])
        deviation = numpy.sqrt(numpy.diag(covariance))
        correlation = covariance / numpy.outer(deviation, deviation)
        self.correlation[numpy.ix_(active, active)] = correlation
        if self.sigma is not None:
            reach = scipy.stats.t.ppf(0.975, self.freedom) * self.sigma * deviation
            for k, r in zip(active, reach):
                if 2 * r < math.log(WIDEST) and k not in self.at_bound:  # there the error is not at its minimum
                    self.intervals[k] = (math.exp(x[k] - r), math.exp(x[k] + r))
        named = self._warn_of_correlation(active, correlation, deviation, axes)
        for k in active:
            explained = self.names[k] in named or k in self.at_bound
            if self.sigma is not None and self.intervals[k] is None and not explained:
                test = TESTS_FOR.get(self.names[k], "another test")
                self.warnings.append(f"{self.names[k]} is not determined: its 95 % interval is wider than a factor of "
                                     f"{WIDEST:g}; fix it with --set, or add a curve of {test}")

    def _warn_of_correlation(self, active, correlation, deviation, axes):
        named = set()
        for i in range(len(active)):
            for j in range(i):
                if abs(correlation[i, j]) > 0.95:
                    pair = [self.names[active[j]], self.names[active[i]]]
                    named.update(pair)
                    weaker = pair[0] if deviation[j] > deviation[i] else pair[1]
                    advice = ADVICE.get(frozenset(pair), "a curve of a test on which they act differently")
                    self.warnings.append(f"{pair[0]} and {pair[1]} are correlated ({correlation[i, j]:.3f}), so these curves "
                                         f"determine them only together: fix {weaker} with --set, or add {advice}")
        if self.condition > 1e3:
            weak = [self.names[active[k]] for k in range(len(active)) if abs(axes[-1, k]) > 0.3]
            if len(weak) > 1 and not named.issuperset(weak):
                self.warnings.append(f"the Jacobian is nearly singular (condition number {self.condition:.1e}): "
                                     f"{', '.join(weak)} cannot be told apart; fix one of them with --set, or add a curve of another test")
                named.update(weak)
        return named

    def compare(self, curve, x):
        """How far a simulated curve is from its data, in the file's units."""
        model = curve.model(self.result(curve.test_name, x, simulate=True))[curve.kept] / curve.y_factor
        given = curve.given_y[curve.kept]
        error = model - given
        size = float(numpy.sqrt(numpy.mean(given**2)))
        rms = float(numpy.sqrt(numpy.mean(error**2)))
        # Specimens have a scatter, but their order has no meaning, and R² is not above 0 even if the mean is met.
        specimens = curve.x_at is None
        spread = 0 if specimens else float(numpy.sum((given - given.mean())**2))
        scatter = float(given.std(ddof=1)) if specimens and len(given) > 1 else None
        centred = error - error.mean()
        has_lag = not specimens and len(error) > 5 and centred @ centred > 0
        lag = float(centred[1:] @ centred[:-1] / (centred @ centred)) if has_lag else None
        return {"file": str(curve.path), "about": curve.about, "test": curve.test_name, "direction": curve.direction,
                "quantity": curve.y_name, "unit": curve.y_unit, "across": curve.x_name if curve.x_at is not None else None,
                "across_unit": curve.x_unit if curve.x_at is not None else None, "points": len(error), "rms_error": rms,
                "relative_error": rms / size if size else None, "mean_error": float(error.mean()),
                "largest_error": float(numpy.max(numpy.abs(error))), "r_squared": 1 - float(error @ error) / spread if spread else None,
                "scatter": scatter, "mean": float(given.mean()), "lag_correlation": lag,
                "left_out": [line for line, kept in zip(curve.lines, curve.kept) if not kept],
                "rows": [[None if curve.x_at is None else float(a), float(b), float(c)] for a, b, c in
                         zip(curve.given_x[curve.kept], given, model)]}

    def report(self, x):
        curves = [self.compare(c, x) for c in self.curves]
        held = [self.compare(c, x) for c in self.held]
        for c in curves:
            lag = c["lag_correlation"]
            if lag is not None and lag > 0.5 and c["relative_error"] > 0.005:
                self.warnings.append(f"{c['file']}: the residuals are systematic (lag-1 correlation {c['lag_correlation']:.2f}): the model "
                                     "does not have the shape of this curve, and the intervals are too narrow")
        info = self.program.version
        parameters = [{"key": f"cloth.0.{k}", "value": float(f"{math.exp(v):.5g}"),
                       "low": i and i[0], "high": i and i[1], "unit": self.keys[k][2], "start": float(numpy.exp(s)),
                       "identified": i is not None and i[1] <= 4 * i[0], "interval": i is not None,
                       "at_bound": n in self.at_bound}
                      for n, (k, v, i, s) in enumerate(zip(self.names, x, self.intervals, self.start))]
        found = {"fabric": self.opt.fabric, "settings": self.opt.set, "parameters": parameters,
                 "correlation": numpy.round(self.correlation, 4).tolist(), "condition_number": self.condition,
                 "residual_deviation": self.sigma, "degrees_of_freedom": self.freedom, "curves": curves, "held_out": held,
                 "warnings": self.warnings, "steps": self.evaluations, "simulated_runs": self.program.simulated,
                 "runs_of_the_equation": self.program.computed, "equation_against_simulation": self.agreement,
                 "date": date.today().isoformat(), "drench": " ".join(line.split(": ", 1)[-1] for line in info[:2]), "program": info,
                 "scipy": scipy.__version__, "numpy": numpy.__version__}
        dense = [c.dense(self.result(c.test_name, x, simulate=True)) if c.x_at is not None else None for c in self.curves + self.held]
        picture = fit_report.draw(self.folder, curves + held, dense, len(curves))
        (self.folder / "fit.json").write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
        of_file = self.opt.fabric.endswith((".yaml", ".yml"))  # named from the new file, so that both can be moved
        base = {**found, "fabric": os.path.relpath(self.opt.fabric, self.folder)} if of_file else found
        (self.folder / "fabric.yaml").write_text(fit_report.fabric_file(base, self.opt.name), encoding="utf-8")
        fit_report.write_table(self.folder / "residuals.csv", curves, held)
        for line in self.warnings:
            print(f"warning: {line}", file=sys.stderr)
        print(fit_report.text(found), end="")
        print(f"  fabric.yaml, fit.json, residuals.csv and {picture} are in {self.folder}")


def rounded(x):
    """Logarithms of the numbers that are printed."""
    return numpy.log([float(f"{v:.5g}") for v in numpy.exp(x)])


def given_end(settings):
    """The time, s, at which --set ends the tests; None without it."""
    words = [s.partition("=")[2] for s in settings if s.startswith("time.end=")]
    if not words:
        return None
    if not is_number(words[-1]) or not float(words[-1]) > 0:
        fail(f"--set: time.end={words[-1]} is not allowed; allowed: a number of seconds above 0")
    return float(words[-1])


def pairs(files, tests, option, what):
    if not files:
        return []
    names = [test_named(t) for t in tests]
    if len(names) not in (1, len(files)):
        fail(f"{option}: {len(names)} tests for {len(files)} files; give one test, or one for each {what} in the same order")
    return list(zip(files, names * len(files) if len(names) == 1 else names))


def output_folder(opt):
    folder = Path(opt.output) if opt.output else Path("out") / f"fit-{Path(opt.data[0]).stem}"
    if folder.exists() and not folder.is_dir():
        fail(f"{folder}: is not a folder; choose another with -o")
    if folder.exists() and any(folder.iterdir()) and not (folder / "runs").is_dir():
        fail(f"{folder}: is not empty and has no earlier fit; choose another with -o")
    try:
        (folder / "runs").mkdir(parents=True, exist_ok=True)
    except OSError as error:
        fail(f"{folder}: {error.strerror}")
    return folder


def options():
    parser = argparse.ArgumentParser(prog="drench fit")
    parser.add_argument("data", nargs="+")
    parser.add_argument("--program", required=True)
    for name in ("--test", "--parameters", "--hold-out", "--hold-out-test", "--set", "--start", "--bounds"):
        parser.add_argument(name, action="append", default=[])
    parser.add_argument("--fabric", default="cotton_interlock")
    parser.add_argument("--direction", choices=("warp", "weft"), default="warp")
    parser.add_argument("--name", default="")
    parser.add_argument("-o", "--output")
    parser.add_argument("-j", "--jobs", type=int)
    parser.add_argument("--max-steps", type=int, default=40)
    parser.add_argument("--simulate", action="store_true")
    parser.add_argument("--quiet", action="store_true")
    opt = parser.parse_args()
    opt.parameters = [w for words in opt.parameters for w in words.split(",") if w]
    return opt


def main():
    try:
        fit = Fit(options())
    except Rejection as error:
        fail(error)
    try:
        fit.run()
    except Rejection as error:
        fail(error)
    except RunError as error:
        print(f"drench: {error}", file=sys.stderr)
        return 1
    finally:
        fit.program.close()
    return 0


if __name__ == "__main__":
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        print("drench: interrupted; the same command with the same -o keeps the completed runs", file=sys.stderr)
        sys.stderr.flush()
        os._exit(130)
