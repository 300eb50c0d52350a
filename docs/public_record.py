#!/usr/bin/env python3
"""Writes the public record of docs/measuring.md again: real logs that nobody here wrote, by regression and by gearwise.

    docs/public_record.py [PROGRAM]                  runs everything and writes the table between its two marks
    docs/public_record.py [PROGRAM] --check          exit status 1, with the difference, where the page says something else
    docs/public_record.py [PROGRAM] --only emps,d5065  only these; printed, not written (with --check: compared)

PROGRAM is target/release/gearwise by default. GEARWISE_REAL_DATA names the folder of the data, which are no part of the
repository: a folder a set, as tests/fixtures/benches says. Needs numpy. The regressions share no code with gearwise;
they take from a bench file which columns and rows are meant, and from gearwise's answer only the band of the filter.
"""

import argparse
import csv
import difflib
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import tomllib

import numpy as np

HERE = pathlib.Path(__file__).resolve().parents[1]
PAGE = HERE / "docs/measuring.md"
BENCHES = HERE / "tests/fixtures/benches"
NAMED = "../../../../shared/data"  # where the bench files say that the data are
BEGIN, END = "<!-- public record: begin -->", "<!-- public record: end -->"
AMPLITUDE = math.sqrt(1.5)  # q axis per ampere of phase amplitude


class Wrong(Exception):
    """What the user has to put right."""


# --- Logs, as a bench file names them -------------------------------------------------------------------------------


def rows_of(path, cache={}):
    if path not in cache:
        if not path.is_file():
            raise Wrong(
                f"{path}: no such file (GEARWISE_REAL_DATA names the folder of the data; --only leaves sets out)"
            )
        with open(path, newline="") as file:
            reader = csv.DictReader(file)
            cache[path] = (reader.fieldnames or [], list(reader))
    return cache[path]


def logs_of(name, data):
    """The logs of a bench: columns by role in the units of the file, sign and scale applied, and rows' texts."""
    bench = tomllib.loads((BENCHES / f"{name}.toml").read_text())
    found = []
    for log in bench["log"]:
        path = data / pathlib.PurePosixPath(log["file"]).relative_to(NAMED)
        names, rows = rows_of(path)
        select = log.get("select", [])
        select = select if isinstance(select, list) else [select]
        for column in [c["name"] for c in bench["columns"].values()] + [s["column"] for s in select]:
            if column not in names:
                raise Wrong(f"{path}: no column `{column}`, which {name}.toml names; there are {', '.join(names)}")
        try:
            rows = [row for row in rows if all(selected(row[s["column"]], s) for s in select)]
        except (TypeError, ValueError) as error:
            raise Wrong(f"{path}: rows cannot be selected as {name}.toml asks: {error}") from None
        if not rows:
            raise Wrong(f"{path}: no row is as {name}.toml selects")
        columns = {}
        for role, column in bench["columns"].items():
            try:
                x = np.array([float(row[column["name"]]) for row in rows])
            except (TypeError, ValueError) as error:
                raise Wrong(f"{path}: column `{column['name']}`: {error}") from None
            if not np.isfinite(x).all():
                raise Wrong(f"{path}: column `{column['name']}` has values that are no numbers")
            if "bits" in column:
                x = np.where(x >= 2.0 ** (column["bits"] - 1), x - 2.0 ** column["bits"], x)
            columns[role] = x * column.get("sign", 1) * column.get("scale", 1)
        equals = [s["equals"] for s in select if "equals" in s]
        columns["name"] = equals[0] if equals else ""
        columns["held"] = log.get("use", "fit") == "held_out"
        columns["log"] = log
        columns["rows"] = rows
        found.append(columns)
    return bench, found


def selected(cell, s):
    if "equals" in s:
        wanted = s["equals"] if isinstance(s["equals"], list) else [s["equals"]]
        return any(cell == w if isinstance(w, str) else abs(float(cell) - w) <= 1e-9 * abs(w) for w in wanted)
    return s.get("min", -math.inf) <= float(cell) <= s.get("max", math.inf)


# --- Filter and rows ------------------------------------------------------------------------------------------------


def kernel(band, rate):
    """A low-pass filter without delay: a windowed sinc."""
    half = max(3, round(1.6 * rate / band))
    k = np.arange(-half, half + 1)
    h = np.sinc(2 * band / rate * k) * np.hamming(2 * half + 1)
    return h / h.sum()


def through(x, h):
    return np.convolve(x, h, "same")


def stretches(log, roles):
    """A log on an even grid of time, cut at gaps."""
    t = log["time"]
    step = float(np.median(np.diff(t)))
    cuts = np.flatnonzero((np.diff(t) > 10 * step) | (np.diff(t) <= 0)) + 1
    for part in np.split(np.arange(len(t)), cuts):
        if len(part) < 60:
            continue
        step = float(np.mean(np.diff(t[part])))
        even = t[part][0] + step * np.arange(len(part))
        yield 1 / step, {"time": even} | {r: np.interp(even, t[part], log[r][part]) for r in roles}


def filtered(logs, roles, band, columns):
    """Rows of all logs: for each the log, the target and the columns, formed at full rate, filtered, and thinned to what
    the band can hold. Rows of a shaft that does not move are left out where `columns` gives its direction."""
    out = []
    for index, log in enumerate(logs):
        for rate, s in stretches(log, roles):
            target, made, direction = columns(s, rate)
            h = kernel(band, rate)
            made = {name: through(x, h) for name, x in made.items()}
            keep = np.arange(len(h), len(target) - len(h), max(1, round(rate / (3 * band))))
            if direction is not None:
                keep = keep[np.abs(through(direction, h)[keep]) > 0.5]
            out.append((np.full(len(keep), index), through(target, h)[keep], {n: x[keep] for n, x in made.items()}))
    log = np.concatenate([o[0] for o in out])
    target = np.concatenate([o[1] for o in out])
    return log, target, {name: np.concatenate([o[2][name] for o in out]) for name in out[0][2]}


def held_rows(log, logs):
    """Rows that judge: of the held-out logs, else every fifth block of equal numbers of rows, as gearwise does."""
    held = np.array([logs[k]["held"] for k in log])
    if not held.any():
        block = np.arange(len(log)) // -(-len(log) // min(60, max(20, len(log) // 40)))
        held = block % 5 == 3
    return held


# --- Least squares --------------------------------------------------------------------------------------------------


class Fit:
    """Ordinary least squares on the rows to fit; `zero` gives every log a constant, the held-out ones from their own
    mean. The ± is the naive one of 95 %: rows count as independent."""

    def __init__(self, target, columns, names, held, log, zero):
        x = np.column_stack([columns[n] for n in names])
        constants = sorted(set(log[~held])) if zero else []
        a = np.column_stack([x] + [(log == k).astype(float) for k in constants])
        size = np.sqrt((a[~held] ** 2).mean(axis=0))
        if not (size > 0).all() or np.linalg.cond(a[~held] / size) > 1e7:
            raise Wrong("the columns of a regression depend on one another: have the data changed?")
        scaled = a[~held] / size
        solution = np.linalg.lstsq(scaled, target[~held], rcond=None)[0]
        left = target[~held] - scaled @ solution
        s2 = (left**2).sum() / (len(left) - len(solution))
        error = np.sqrt(np.diag(np.linalg.inv(scaled.T @ scaled)) * s2)
        self.value = dict(zip(names, solution / size))
        self.error = dict(zip(names, error / size))
        self.zeros = dict(zip(constants, (solution / size)[len(names) :]))
        residual = target - x @ (solution / size)[: len(names)]
        for k in set(log) if zero else ():
            rows = log == k
            residual[rows] -= self.zeros[k] if k in self.zeros else residual[rows].mean()
        self.held_out = rms(residual[held])

    def significant(self, name):
        return abs(self.value[name]) > 1.96 * self.error[name]


def rms(x):
    return float(np.sqrt((x**2).mean()))


# --- What is said of a set ------------------------------------------------------------------------------------------


class Term:
    """A column of a regression: what people call it, which effect of gearwise it is, and its printed unit. `flip` is -1
    where the column's coefficient is the effect's with the other sign."""

    def __init__(self, column, says, effect, scale=1.0, unit=""):
        self.column, self.says, self.effect, self.scale, self.unit = column, says, effect, scale, unit


class Wanted:
    """What a set has, by its README or its source: one of `effects` is a hit; `known` is the range of a value that is
    published or regressed separately, `value` which one of gearwise it is, in the SI unit of its JSON; `near` is another
    form that comes near to it."""

    def __init__(self, says, effects, value=None, known=None, near=()):
        self.says, self.effects, self.value, self.known, self.near = says, set(effects), value, known, set(near)


def orders(theta, which):
    return {f"{f}{k}": getattr(np, f)(k * theta) for k in which for f in ("cos", "sin")}


def harmonics(which, scale, unit):
    return [Term(f"{f}{k}", f"order {k}", f"cogging {k}", scale, unit) for k in which for f in ("cos", "sin")]


def emps(bench, logs, band):
    def columns(s, rate):
        light = kernel(3 * band, rate)
        x = s["position"]
        v, a = np.gradient(x) * rate, np.gradient(np.gradient(x)) * rate**2
        v_light, a_light = through(v, light), through(a, light)
        sign = np.sign(v_light)
        made = {
            "a": a, "v": v, "sgn": sign, "1": np.ones_like(x), "abs": np.abs(v_light), "quad": v_light * np.abs(v_light),
            "stribeck": sign * np.exp(-((v_light / 0.01) ** 2)), "load": sign * np.abs(a_light), "x": x,
        }  # fmt: skip
        return s["force"], made, sign

    log, target, made = filtered(logs, ["position", "force"], band, columns)
    declared = target - float(bench["actuator"]["mass"].split()[0]) * made["a"]
    textbook = [
        Term("a", "mass", "mass", 1, "kg"), Term("v", "viscous", "viscous_friction", 1, "N s/m"),
        Term("sgn", "Coulomb", "coulomb_friction", 1, "N"), Term("1", "offset", "torque_offset", 1, "N"),
    ]  # fmt: skip
    everything = textbook + [
        Term("abs", "asymmetry", "direction_asymmetry", 1, "N s/m"), Term("quad", "quadratic", "quadratic drag", 1, "N s²/m²"),
        Term("stribeck", "Stribeck at 10 mm/s", "stribeck_friction", 1, "N"),
        Term("load", "load-dependent", "load_dependent_friction", 1, "kg"), Term("x", "spring", "spring", 1, "N/m"),
    ]  # fmt: skip
    result = fits(log, logs, target, made, declared, textbook, everything, zero=False)
    one_more = Fit(target, made, ["a", "v", "sgn", "1", "abs"], held_rows(log, logs), log, zero=False)
    offset, half = (f"{number(one_more.value[n])} ± {number(1.96 * one_more.error[n], 2)}" for n in ("1", "abs"))
    result["also"] = [
        f"textbook with the asymmetry: {number(one_more.held_out)} N",
        f"asymmetry {half} N s/m, offset {offset} N",
    ]
    return result


def motor_drag(which):
    """The idle motor behind a torque sensor: inertia, friction, a zero of each log, orders of the angle."""

    def regression(bench, logs, band):
        def columns(s, rate):
            w, theta = s["velocity"], np.unwrap(s["position"])
            a = np.gradient(w) * rate
            light = through(w, kernel(min(3 * band, 0.45 * rate), rate))
            made = {
                "a": a, "w": w, "quad": light * np.abs(light), "stribeck": np.exp(-((light / 10) ** 2)) * np.sign(light),
                "load": np.abs(a) * np.sign(light),
            }  # fmt: skip
            return s["torque"], made | orders(theta, which), np.sign(light)

        log, target, made = filtered(logs, ["velocity", "position", "torque"], band, columns)
        # What the motor gives to the sensor is the drag with the other sign, on this bench.
        made = {name: -x for name, x in made.items()}
        rotor = 90.1e-7  # [kg*m^2], the catalogue's
        textbook = [
            Term("a", "inertia", "inertia", 1e7, "g cm²"), Term("w", "viscous", "viscous_friction", 1e3, "mN m s/rad"),
        ]  # fmt: skip
        everything = textbook + [
            Term("quad", "quadratic", "quadratic drag", 1e6, "µN m s²"),
            Term("stribeck", "Stribeck at 10 rad/s", "stribeck_friction", 1e3, "mN m"),
            Term("load", "load-dependent", "load_dependent_friction", 1e7, "g cm²"),
        ] + harmonics(which, 1e3, "mN m")  # fmt: skip
        declared = target - rotor * made["a"]
        return fits(log, logs, target, made, declared, textbook, everything, zero=True)

    return regression


def stall(bench, logs, band):
    def columns(s, rate):
        i, temperature = s["current"], s["motor_temperature"]
        made = {
            "i": i, "sat": i * np.abs(i), "heat": i * (temperature - 25), "t": (s["time"] - s["time"].mean()) / 60,
            "abs": np.abs(i), "cubic": i**3, "w": s["velocity"],
        }  # fmt: skip
        return s["torque"], made, None

    log, target, made = filtered(logs, ["current", "velocity", "torque", "motor_temperature"], band, columns)
    textbook = [
        Term("i", "K_T", "torque_constant", 1e3, "mN m/A"),
        Term("w", "viscous", "viscous_friction", 1e3, "mN m s/rad"),
    ]
    everything = textbook + [
        Term("sat", "saturation \\|i\\| i", "torque_constant_saturation", 1e3, "mN m/A²"),
        Term("cubic", "saturation i³", "torque_constant_saturation", 1e3, "mN m/A³"),
        Term("heat", "K_T by temperature", "torque_constant_temperature", 1e3, "mN m/A/K"),
        Term("abs", "hysteresis \\|i\\|", "hysteresis", 1e3, "mN m/A"),
        Term("t", "drift", "drift", 1e3, "mN m/min"),
    ]
    declared = target - 0.105 * AMPLITUDE * made["i"]
    slopes = []
    for k, one in enumerate(logs):
        rows = log == k
        if not one["held"]:
            i, y = made["i"][rows], target[rows]
            slopes.append((one["name"], float(np.polyfit(i, y, 1)[0])))
    # What the slopes show is put right by hand before the second regression; the first one is blind.
    usual = float(np.median([abs(v) for _, v in slopes]))
    factors = {
        n: (-1.0 if v < 0 else 1.0) * (usual / abs(v) if abs(abs(v) / usual - 1) > 0.2 else 1.0) for n, v in slopes
    }
    right = np.array([factors.get(one["name"], 1.0) for one in logs])[log]
    result = fits(log, logs, target, made, declared, textbook, everything, zero=True)
    result["everything"] = fits(log, logs, target * right, made, declared, textbook, everything, zero=True)[
        "everything"
    ]
    for n, factor in factors.items():
        if factor < 0:
            result.setdefault("by hand", {})[f"sign {n}"] = (-1.0, None)
        if abs(factor) != 1:
            result.setdefault("by hand", {})[f"gain {n}"] = (1 / abs(factor), None)
    result["also"] = [
        "K_T of each log by itself [mN m/A]: " + ", ".join(f"{n[6:]} {number(v * 1e3)}" for n, v in slopes),
        "whoever looks sees sign and gain: both are put right by hand before *everything*, the textbook regression is blind",
    ]
    return result


def dynamometer(bench, logs, band):
    made, target, log = [], [], []
    for k, one in enumerate(logs):
        i, w, temperature = one["current"], one["velocity"], one["motor_temperature"]
        made.append({
            "i": i, "w": w, "sat": i * np.abs(i), "cubic": i**3, "heat": i * (temperature - 30), "quad": w**2,
            "stribeck": np.exp(-((w / 50) ** 2)), "warm": temperature - 30,
        })  # fmt: skip
        target.append(one["torque"])
        log.append(np.full(len(i), k))
    log, target = np.concatenate(log), np.concatenate(target)
    made = {name: np.concatenate([m[name] for m in made]) for name in made[0]} | {"1": np.ones(len(log))}
    for friction in ("1", "w", "quad", "stribeck"):
        made[friction] = -made[friction]  # positive is a drag
    textbook = [
        Term("i", "K_T", "torque_constant", 1e3, "mN m/A"), Term("1", "constant, taken for Coulomb", "coulomb_friction", 1e3, "mN m"),
        Term("w", "viscous", "viscous_friction", 1e3, "mN m s/rad"),
    ]  # fmt: skip
    everything = textbook + [
        Term("sat", "saturation \\|i\\| i", "torque_constant_saturation", 1e3, "mN m/A²"),
        Term("cubic", "saturation i³", "torque_constant_saturation", 1e6, "µN m/A³"),
        Term("heat", "K_T by temperature", "torque_constant_temperature", 1e3, "mN m/A/K"),
        Term("quad", "quadratic", "quadratic drag", 1e9, "nN m s²"),
        Term("stribeck", "Stribeck at 50 rad/s", "stribeck_friction", 1e3, "mN m"),
        Term("warm", "offset by temperature", "drift", 1e3, "mN m/K"),
    ]
    declared = target - 0.0306 * made["i"]
    return fits(log, logs, target, made, declared, textbook, everything, zero=False)


def servo(bench, logs, band):
    """Voltage of the duty cycle = A q̈ + B q̇ + G sin q + friction; then the position is simulated with those constants,
    from the goal through the firmware's law, since that is the error that gearwise states."""
    for one in logs:
        if "torque_enable" not in one["rows"][0]:
            raise Wrong("bam_xl330.csv: no column `torque_enable`, which says when the drive is on")
        one["on"] = np.array([float(row["torque_enable"]) for row in one["rows"]])

    def columns(s, rate):
        q, w = s["position"], np.gradient(s["position"]) * rate
        light = through(w, kernel(30, rate))
        a = np.gradient(np.gradient(q)) * rate**2
        sign = np.where(np.abs(light) > 0.02, np.sign(light), 0)
        made = (
            {"a": a, "w": w, "sin": np.sin(q)}
            | {n: f(q, light) for n, f in extra.items()}
            | {"sgn": sign, "on": s["on"]}
        )
        for n in ("stribeck", "load"):
            made[n] = made[n] * sign
        return s["duty"] * s["supply"], made, sign

    extra = {
        "1": lambda q, w: np.ones_like(q), "cos": lambda q, w: np.cos(q), "quad": lambda q, w: w * np.abs(w),
        "stribeck": lambda q, w: np.exp(-((w / 0.5) ** 2)), "load": lambda q, w: np.abs(np.sin(q)), "abs": lambda q, w: np.abs(w),
    }  # fmt: skip
    log, target, made = filtered(logs, ["position", "duty", "supply", "on"], 10.0, columns)
    powered = made.pop("on") > 0.999
    log, target, made = log[powered], target[powered], {n: x[powered] for n, x in made.items()}
    textbook = [
        Term("a", "inertia", "inertia", 1, "V s²"), Term("w", "viscous and back-EMF", "viscous_friction", 1, "V s/rad"),
        Term("sin", "gravity of the pendulum", "pendulum", 1, "V"), Term("sgn", "Coulomb", "coulomb_friction", 1, "V"),
        Term("1", "offset", "torque_offset", 1, "V"),
    ]  # fmt: skip
    everything = textbook + [
        Term("stribeck", "Stribeck at 0.5 rad/s", "stribeck_friction", 1, "V"),
        Term("load", "load-dependent", "load_dependent_friction", 1, "V"), Term("quad", "quadratic", "quadratic drag", 1, "V s²"),
        Term("cos", "cos q", "zero of the angle", 1, "V"), Term("abs", "asymmetry", "direction_asymmetry", 1, "V s/rad"),
    ]  # fmt: skip
    result = fits(log, logs, target, made, target, textbook, everything, zero=False)
    k, kg = 0.354 / 3.4, 0.49 * 0.1
    declared = {"a": kg * 0.1 / k, "w": 0.354, "sin": kg * 9.80665 / k, "sgn": 0.0, "1": 0.0}
    result["declared"] = simulated(logs, declared)
    result["also"] = [
        f"of the voltage that is fitted: {number(result['textbook'].held_out)} and {number(result['everything'].held_out)} V held out",
        "the set's README fits the simulated position itself: 0.169 without friction, 0.073 with viscous and Coulomb, 0.051 with load",
        "0.049 with a delay, 0.045 with the measured supply",
    ]
    for fit in ("textbook", "everything"):
        result[fit].held_out = simulated(logs, result[fit].value)
    return result


def simulated(logs, c):
    """Error of the simulated position on the held-out logs; friction that jumps with the direction holds at rest."""
    g = lambda n: c.get(n, 0.0)
    errors = []
    for one in (x for x in logs if x["held"]):
        t, goal, supply, on, q_measured = (one[n] for n in ("time", "goal", "supply", "on", "position"))
        gain = one["log"]["controller"]["gain"]
        q, w = q_measured[0], 0.0
        left = [0.0]
        for k in range(len(t) - 1):
            parts = 8
            h = (t[k + 1] - t[k]) / parts
            for _ in range(parts):
                u = min(1.0, max(-1.0, gain * (goal[k] - q))) * supply[k] if on[k] else 0.0
                smooth = (
                    u
                    - g("sin") * math.sin(q)
                    - g("cos") * math.cos(q)
                    - g("1")
                    - g("abs") * abs(w)
                    - g("quad") * w * abs(w)
                )
                smooth -= g("w") * w if on[k] else 0.0
                jump = max(0.0, g("sgn") + g("load") * abs(math.sin(q)) + g("stribeck") * math.exp(-((w / 0.5) ** 2)))
                free = w + h * smooth / g("a")
                brake = h * jump / g("a")
                w = 0.0 if abs(free) <= brake else free - math.copysign(brake, free)
                q += h * w
                if not abs(q) < 1e3:
                    raise Wrong("the simulation of a servo runs away: have the data changed?")
            left.append(q - q_measured[k + 1])
        errors.append(np.array(left))
    return rms(np.concatenate(errors))


def fits(log, logs, target, made, declared, textbook, everything, zero):
    held = held_rows(log, logs)
    result = {"declared": rms(declared[held]), "also": []}
    for name, terms in (("textbook", textbook), ("everything", everything)):
        result[name] = Fit(target, made, [t.column for t in terms], held, log, zero)
        result[name + " terms"] = terms
    return result


SOURCES = {
    "emps": "[EMPS, nonlinear benchmark](https://www.nonlinearbenchmark.org/benchmarks/emps) (Janot, Gautier, Brunot 2019), by "
    "[forgi86/sysid-neural-continuous](https://github.com/forgi86/sysid-neural-continuous); free to use with citation, no "
    "licence text; that repository: Apache-2.0",
    "embir": "[EMBiR-Modular-Leg/embir-modular-leg](https://github.com/EMBiR-Modular-Leg/embir-modular-leg), the laboratory of "
    "[Urs, Adu, Rouse, Moore](https://arxiv.org/abs/2202.12365); no licence stated",
    "odrive": "[Capo01/odrive_based_electric_motor_dynamometer](https://github.com/Capo01/odrive_based_electric_motor_dynamometer); "
    "GPL-3.0",
    "bam": "[Rhoban/bam](https://github.com/Rhoban/bam), method: [Duclusaud and others](https://arxiv.org/abs/2410.08650); Apache-2.0",
}
RI50 = "T-Motor RI50, 12 slots and 7 pole pairs, no gear, on a torque sensor"
SETS = [
    dict(
        name="emps", bands=["10 Hz", "40 Hz"], title="EMPS", what="ball screw with a Maxon motor, position and force of the drive", source="emps",
        log="1 log to fit, 1 held out (other pulses); 25 s each, 1 kHz", unit="N", scale=1, run=emps,
        # The published model is symmetric; the asymmetry is the set's README.
        wanted=[
            Wanted("viscous friction, 203.5 N s/m", ["viscous_friction"], "coefficient", (203.5, 203.5)),
            Wanted("Coulomb friction, 20.4 N", ["coulomb_friction"], "torque", (20.4, 20.4)),
            Wanted("offset, −3.16 N in the published symmetric model", ["torque_offset"], "torque", (-3.1648, -3.1648)),
            Wanted("asymmetry of the viscous term, −36.6 N s/m of half difference", ["direction_asymmetry"], "half_difference", (-36.6, -36.6)),
        ],
        more=["mass 95.1 kg"],
    ),
    dict(
        name="ri50_drag", bands=["12 Hz", "40 Hz"], title="RI50, drag", what=RI50 + "; the idle motor's drag at steps of speed up to 134 rad/s", source="embir",
        log="1 log, 45 s, about 105 Hz; every fifth block of time is held out", unit="mN m", scale=1e3,
        run=motor_drag([1, 2, 7, 12, 14, 24]),
        wanted=[
            Wanted("eddy drag, 53.1 mN m with a knee at 115.6 rad/s", ["eddy_drag"], "speed", (115.6, 115.6), ["quadratic drag"]),
            Wanted("cogging of order 1", ["cogging 1"]),
        ],
        more=["its values are of a separate regression", "the orders of the slow turns may show"],
        spare={"viscous_friction", "cogging 2", "cogging 7", "cogging 12", "cogging 14", "cogging 24"},
    ),
    dict(
        name="ri50_slow", bands=["12 Hz", "20 Hz"], title="RI50, slow turns", what=RI50 + "; half a turn a second", source="embir",
        log="1 log to fit, 154 s with a gap, 1 held out, 20 s; 60 to 80 Hz", unit="mN m", scale=1e3,
        run=motor_drag([1, 7, 12, 14, 24, 36]),
        wanted=[Wanted(f"cogging of order {k}", [f"cogging {k}"]) for k in (1, 7, 12, 14)],
        more=["the drag log has a drag of 0.92 mN m s/rad at low speed"],
        spare={"cogging 24", "cogging 36"},
        limits={"viscous_friction": ("coefficient", 0.92e-3)},
    ),
    dict(
        name="ri50_stall", phase=True, bands=["9 Hz", "36 Hz"], title="RI50, stall", what=RI50 + "; steps of current against a motor that holds", source="embir",
        log="5 logs to fit, 1 held out; one log has the wrong sign, one the wrong gain", unit="mN m", scale=1e3, run=stall,
        wanted=[
            Wanted("the sign of log 11b", ["sign stall_11b"]),
            Wanted("the gain of log 24b, 0.69", ["gain stall_24b_badgain"], None, (0.69, 0.69)),
            Wanted("K_T of the others, 104 to 108 mN m/A of phase amplitude", ["torque_constant"], None, (0.1042, 0.1080)),
        ],
        more=["a zero of each log"],
    ),
    dict(
        name="d5065", phase=True, title="D5065", what="ODrive D5065, 270 KV, outrunner on a dynamometer of two motors", source="odrive",
        log="342 steady points, every fourth speed held out", unit="mN m", scale=1e3, run=dynamometer,
        wanted=[
            Wanted("saturation of K_T", ["torque_constant_saturation"]),
            Wanted("drag without load", ["coulomb_friction", "viscous_friction"]),
        ],
        more=["a temperature term that no magnet has is a false name"],
    ),
    dict(
        name="xl330", title="XL330", what="Dynamixel XL330 servo with a pendulum; duty cycle, supply and position only", source="bam",
        log="12 logs to fit, 4 held out; 6 s each, 190 to 290 Hz; four gains of the firmware", unit="rad", scale=1, run=servo,
        wanted=[
            Wanted("load-dependent friction", ["load_dependent_friction"]),
            Wanted("a delay", ["lag"]),
        ],
        more=["sag of the supply is measured, an input", "friction without load and back-EMF are one number", "no Stribeck"],
        spare={"viscous_friction"},
    ),
]  # fmt: skip
PHYSICS = {"mass", "inertia", "torque_constant", "pendulum", "damping"}  # what the declared model has


POSITIVE = {"inertia", "viscous_friction", "coulomb_friction", "stribeck_friction", "load_dependent_friction"}


# --- gearwise -------------------------------------------------------------------------------------------------------


def answer(program, name, data, band=()):
    with tempfile.TemporaryDirectory() as folder:
        for file in BENCHES.iterdir():
            text = file.read_text().replace(NAMED, data.as_posix())
            (pathlib.Path(folder) / file.name).write_text(text)
        run = subprocess.run(
            [program, "identify", f"{folder}/{name}.toml", "--json", *band], capture_output=True, text=True, check=False
        )
    if run.returncode not in (0, 1):
        raise Wrong(f"gearwise identify {name}.toml: exit status {run.returncode}\n{run.stderr.strip()}")
    try:
        return json.loads(run.stdout)
    except json.JSONDecodeError as error:
        raise Wrong(f"gearwise identify {name}.toml --json: no JSON ({error})") from None


NAMES = {
    "viscous_friction": "viscous friction", "coulomb_friction": "Coulomb friction", "torque_offset": "offset",
    "direction_asymmetry": "asymmetry", "eddy_drag": "eddy drag", "stribeck_friction": "Stribeck friction",
    "load_dependent_friction": "load-dependent friction", "torque_constant_saturation": "saturation",
    "torque_constant_temperature": "K_T by temperature", "torque_constant": "K_T",
}  # fmt: skip
SCALED = {
    "N*m": (1e3, "mN m"), "N*m/A": (1e3, "mN m/A"), "N*m*s/rad": (1e3, "mN m s/rad"), "kg*m^2": (1e7, "g cm²"),
    "N*s/m": (1, "N s/m"), "s": (1e3, "ms"), "1": (1, ""),
}  # fmt: skip


def readable(name):
    return NAMES.get(name, name.replace("cogging ", "cogging of order ").replace("_", " "))


def number(x, digits=3):
    if x == 0 or not math.isfinite(x):
        return "0" if x == 0 else "not finite"
    places = digits - 1 - math.floor(math.log10(abs(x)))
    x = round(x, places)
    text = f"{x:.{max(0, digits - 1 - math.floor(math.log10(abs(x))))}f}" if x else "0"
    return text.replace("-", "−")


def with_error(value, error, unit):
    factor, unit = SCALED.get(unit, (1, unit))
    text = number(value * factor) + (f" ± {number(error * factor, 2)}" if error is not None else "")
    return f"{text} {unit}".strip()


def named_by(report):
    """What gearwise names: effect -> list of (parameter, value, ±, unit); orders of cogging each for itself."""
    found = {}
    for effect in report["effects"]:
        for p in effect["parameters"]:
            name, what = effect["name"], p["name"]
            if name == "cogging":
                order, what = p["name"].rsplit(".", 1)
                name = f"cogging {order}"
            found.setdefault(name, []).append((what, p["fitted"], p["plus_minus"], p["unit"]))
    for p in report["parameters"]:
        found[p["name"]] = [(p["name"], p["fitted"], p["plus_minus"], p["unit"])]
    for a in report["artefacts"]:
        channel = a["channel"].split(", run ")[-1]
        found[f"{a['kind']} {channel}" if a["kind"] != "lag" else "lag"] = [(a["kind"], a["value"], None, a["unit"])]
    return found


def amplitude(values):
    by = {what: (value, error) for what, value, error, _ in values}
    (c, ec), (s, es) = by["cosine"], by["sine"]
    size = math.hypot(c, s)
    return size, math.hypot(c * (ec or 0), s * (es or 0)) / size


def effects_of(report, named):
    out, order = [], []
    for effect in report["effects"]:
        also = f" (or {', '.join(readable(c) for c in effect['confounded_with'])})" if effect["confounded_with"] else ""
        if effect["name"] == "cogging":
            for name in sorted((n for n in named if n.startswith("cogging ")), key=lambda n: float(n[8:])):
                size, error = amplitude(named[name])
                order.append(f"{name[8:]}: {with_error(size, error, effect['parameters'][0]['unit'])}")
            out.append("cogging, order and amplitude, " + "; ".join(order) + also)
        else:
            values = ", ".join(with_error(p["fitted"], p["plus_minus"], p["unit"]) for p in effect["parameters"])
            out.append(f"{readable(effect['name'])} {values}{also}")
    return out


def parameters_of(report, phase):
    def per_phase(p):
        if not phase or p["name"] != "torque_constant":
            return ""
        return f" of the q axis, {with_error(p['fitted'] * AMPLITUDE, p['plus_minus'] * AMPLITUDE, p['unit'])} of phase amplitude"

    return [
        f"{readable(p['name'])} {with_error(p['fitted'], p['plus_minus'], p['unit'])}"
        + per_phase(p)
        + (f" (declared {with_error(p['declared'], None, p['unit'])})" if p["declared"] is not None else "")
        for p in report["parameters"]
        if p["plus_minus"] is not None
    ]


def artefacts_of(report):
    out, zeros = [], []
    for a in report["artefacts"]:
        log = a["channel"].split(", run ")[-1].split(", mode")[0] if ".csv" in a["channel"] else ""
        if a["kind"] == "zero":
            zeros.append(number(a["value"] * SCALED.get(a["unit"], (1,))[0]))
        else:
            channel = a["channel"].split(" of ")[0]
            value = "−1" if a["kind"] == "sign" else with_error(a["value"], None, a["unit"])
            out.append(f"{a['kind']} of {channel}{' of ' + log if log else ''} {value}")
    if zeros:
        out.append(f"zero of each log [mN m] {', '.join(zeros)}")
    return out


# --- The table ------------------------------------------------------------------------------------------------------


def off(value, error, known):
    low, high = known
    reach = max(error or 0, 0.1 * max(abs(low), abs(high)))
    return not low - reach <= value <= high + reach


def judged(spec, named, value_of):
    """Of what is wanted: hits, hits with another value, misses; then what is named and not wanted."""
    hits, others, misses = [], [], []
    for w in spec["wanted"]:
        name = next((n for n in sorted(w.effects) if n in named), None)
        if name is None:
            (others if w.near & set(named) else misses).append(w.says.split(",")[0])
            continue
        value, error = value_of(name, w)
        (others if w.known and value is not None and off(value, error, w.known) else hits).append(w.says.split(",")[0])
    wanted = {e for w in spec["wanted"] for e in w.effects | w.near} | spec.get("spare", set())
    extra = [n for n in named if n not in wanted and n not in PHYSICS]
    return hits, others, misses, extra


def claims(fit, terms, spec):
    """Effects that a regression's significant terms would claim, and a line of them. Orders have two terms."""
    named, lines, done = {}, [], set()
    for t in terms:
        if t.effect.startswith("cogging"):
            if t.effect in done:
                continue
            done.add(t.effect)
            pair = [x for x in terms if x.effect == t.effect]
            if not any(fit.significant(x.column) for x in pair):
                continue
            size = math.hypot(*(fit.value[x.column] for x in pair))
            error = 1.96 * max(fit.error[x.column] for x in pair)
            named.setdefault(t.effect, (size, error))
            lines.append(f"{t.says} {number(size * t.scale)} ± {number(error * t.scale, 2)} {t.unit}")
        elif fit.significant(t.column):
            named.setdefault(t.effect, (fit.value[t.column], 1.96 * fit.error[t.column]))
            value = f"{number(fit.value[t.column] * t.scale)} ± {number(1.96 * fit.error[t.column] * t.scale, 2)}"
            lines.append(f"{t.says} {value} {t.unit}")
    return named, lines


def verdict_in_short(report):
    left = [f"{u['depends_on']}: {u['detail']}" for u in report["unexplained"]]
    return f"`{report['verdict']}`" + (f"; left without a name, depends on {'; '.join(left)}" if left else "")


ALWAYS = {"viscous_friction", "coulomb_friction", "stribeck_friction", "eddy_drag"}


def refusals(report, regression_named, spec):
    """gearwise's own reason for each name that is wanted or that the regression would claim, and that it does not say."""
    asked = {e for w in spec["wanted"] for e in w.effects} | set(regression_named) | ALWAYS
    out = {}
    for r in report["refused"]:
        if r["name"] in asked:
            out.setdefault(r["reason"].strip(), []).append(readable(r["name"]))
    return [f"{', '.join(dict.fromkeys(names))}: {reason}" for reason, names in out.items()]


def sure(report):
    e = report["evidence"]
    parts = []
    if report["noise_floor"] is None and e.get("noise_cannot_be_told"):
        parts.append(f"the noise of the instrument is not known ({e['noise_cannot_be_told']})")
    elif e.get("times_the_noise"):
        parts.append(f"{number(e['times_the_noise'])} times the noise of the instrument is left")
    if e["refused"]:
        r = e["refused"][0]
        parts.append(
            f"strongest refused: {'another order of cogging' if r['name'] == 'cogging' else readable(r['name'])}, would lower the error by {number(r['error_falls_percent'], 2)} %, "
            f"at most {number(r['at_most_percent'], 2)} % (95 %)"
        )
    if report["next_runs"]:
        parts.append("next: " + "; ".join(report["next_runs"]))
    return parts


def others_bands(spec, program, data):
    """The same question in other bands: what changes with the band is no property of the machine."""
    parts = []
    for band in spec.get("bands", []):
        report = answer(program, spec["name"], data, ["--band", band])
        value = number(report["errors"]["final"]["held_out"] * spec["scale"])
        names = effects_of(report, named_by(report)) or ["no effect"]
        parts += cells(f'`--band "{band}"`', [f"→ {value} {spec['unit']}", *names])
    return parts


def remarks_of(report):
    """What gearwise asks to be checked of the declared numbers."""
    return [r for r in report["remarks"] if "check" in r]


def cells(label, items, width=190):
    """Rows of a table with one label, none of them much wider than the page."""
    lines, line = [], ""
    for item in items:
        if line and len(line) + len(item) > width:
            lines.append(line + ";")
            line = ""
        line += ("; " if line else "") + item
    lines += [line] if line else []
    return [f"| {label if k == 0 else ''} | {text} |".replace("|  |", "| |") for k, text in enumerate(lines)]


def record(spec, program, data):
    """The row of the summary, and the table of one set."""
    report = answer(program, spec["name"], data)
    bench, logs = logs_of(spec["name"], data)
    result = spec["run"](bench, logs, report["band_hz"])
    scale, unit = spec["scale"], spec["unit"]
    named = named_by(report)
    shown = {
        n for n in named if n in {e["name"] for e in report["effects"]} or n.startswith(("cogging ", "sign ", "gain "))
    }
    shown |= {"lag"} & set(named) if spec["name"] == "xl330" else set()
    shown |= {p["name"] for p in report["parameters"]}
    ours = {n: named[n] for n in named if n in shown}

    def value_of(name, w):
        if name == "torque_constant":
            return ours[name][0][1] * AMPLITUDE, (ours[name][0][2] or 0) * AMPLITUDE
        chosen = [v for v in ours[name] if w.value is None or v[0] == w.value]
        return (chosen[0][1], chosen[0][2]) if chosen else (None, None)

    hits, others, misses, extra = judged(spec, ours, value_of)
    weak = [
        n
        for n, values in ours.items()
        if n in {e["name"] for e in report["effects"]} and any(v[2] is not None and abs(v[1]) < v[2] for v in values)
    ]
    too_large = []
    for name, (parameter, limit) in spec.get("limits", {}).items():
        for v in ours.get(name, []):
            if v[0] == parameter and off(v[1], v[2], (limit, limit)):
                too_large.append(f"{readable(name)} is {number(v[1] / limit, 2)} times as large as what is known")
    textbook_named, textbook_lines = claims(result["textbook"], result["textbook terms"], spec)
    all_named, all_lines = claims(result["everything"], result["everything terms"], spec)
    all_named |= result.get("by hand", {})
    negative = [
        t.says
        for t in result["everything terms"]
        if t.effect in POSITIVE
        and result["everything"].significant(t.column)
        and result["everything"].value[t.column] < 0
    ]
    their_notes = [f"negative, which no machine has: {', '.join(negative)}"] if negative else []
    for name, (_, limit) in spec.get("limits", {}).items():
        if name in all_named and off(*all_named[name], (limit, limit)):
            their_notes.append(
                f"{readable(name)} is {number(all_named[name][0] / limit, 2)} times as large as what is known"
            )

    def theirs(named_):
        h, o, m, x = judged(spec, named_, lambda n, w: (named_[n][0], named_[n][1]))
        return h, o, m, x

    t_hits, t_others, t_misses, t_extra = theirs(textbook_named)
    a_hits, a_others, a_misses, a_extra = theirs(all_named)
    errors = [result["declared"], result["textbook"].held_out, result["everything"].held_out]
    final, declared = report["errors"]["final"]["held_out"], report["errors"]["declared"]["held_out"]
    if abs(declared / errors[0] - 1) > 0.05:
        raise Wrong(
            f"{spec['name']}: as declared {errors[0]:.4g} here and {declared:.4g} by gearwise: not the same question"
        )
    count = len(spec["wanted"])

    def score(h, o):
        return f"{len(h)} of {count}" + (f" + {len(o)} with another value" if o else "")

    counts = [len(a_hits), len(a_others), len(a_extra), len(hits), len(others), len(extra), count]
    counts += [errors[2] < final * (1 - 1e-3)]
    summary = (
        f"| [{spec['title']}](#{spec['title'].lower().replace(',', '').replace(' ', '-')}) [{unit}] | {number(errors[0] * scale)} | {number(errors[1] * scale)} "
        f"| {number(errors[2] * scale)} | {number(declared * scale)} → {number(final * scale)} "
        f"| {score(a_hits, a_others)} | {len(a_extra)} | {score(hits, others)} | {len(extra)} |"
    )

    def verdicts(h, o, m, x, notes):
        heads = (
            ("right", h),
            ("with another value or form", o),
            ("missed", m),
            ("not known of it", [readable(n) for n in x]),
        )
        parts = [f"{head}: {', '.join(items)}" for head, items in heads if items]
        return parts + ([f"beware: {', '.join(notes)}"] if notes else [])

    notes = []
    if weak:
        notes.append(f"not beyond its own error: {', '.join(readable(n) for n in weak)}")
    notes += too_large
    found = effects_of(report, named) or ["no effect"]
    gone = f"{number(declared * scale)} → {number(final * scale)} {unit}, {verdict_in_short(report)}"
    ours_judged = verdicts(hits, others, misses, extra, notes)
    theirs_judged = verdicts(a_hits, a_others, a_misses, a_extra, their_notes)
    lines = [
        f"### {spec['title']}",
        "",
        f"| | {spec['what']} |",
        "|---|---|",
        *cells("source", SOURCES[spec["source"]].split("; ")),
        *cells("log", [spec["log"]]),
        *cells("known of it", [w.says for w in spec["wanted"]] + spec["more"]),
        *cells("*textbook*", [f"{number(errors[0] * scale)} → {number(errors[1] * scale)} {unit}", *textbook_lines]),
        *cells("*everything*", [f"{number(errors[0] * scale)} → {number(errors[2] * scale)} {unit}", *all_lines]),
        *cells("also by regression", result["also"]),
        *cells("**regression, judged**", theirs_judged),
        *cells("gearwise", [gone]),
        *cells("it names", found),
        *cells(
            "parameters, artefacts",
            parameters_of(report, spec.get("phase")) + artefacts_of(report) + remarks_of(report),
        ),
        *cells("it does not name", refusals(report, all_named, spec)),
        *others_bands(spec, program, data),
        *cells("how sure", sure(report) or ["only the ± above say it"]),
        *cells("**gearwise, judged**", ours_judged),
    ]
    return summary, lines, counts


def total(counts):
    """The last row of the summary."""
    a, b, c, d, e, f, count, nearer = (sum(x) for x in zip(*counts))

    def score(h, o):
        return f"{h} of {count}" + (f" + {o} with another value" if o else "")

    return (
        f"| all | | | nearer than gearwise in {nearer} of {len(counts)} | | {score(a, b)} | {c} | {score(d, e)} | {f} |"
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", nargs="?", default=str(HERE / "target/release/gearwise"))
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--only", help="names of benches, with commas between")
    given = parser.parse_args()
    try:
        return run(given)
    except Wrong as error:
        print(f"public_record.py: {error}", file=sys.stderr)
        return 2


def run(given):
    known = [s["name"] for s in SETS]
    only = given.only.split(",") if given.only else known
    for name in only:
        if name not in known:
            raise Wrong(f"--only {name}: no such bench; there are {', '.join(known)}")
    if "GEARWISE_REAL_DATA" not in os.environ:
        raise Wrong("GEARWISE_REAL_DATA is not set: it names the folder of the data")
    data = pathlib.Path(os.environ["GEARWISE_REAL_DATA"]).absolute()
    if not data.is_dir():
        raise Wrong(f"GEARWISE_REAL_DATA: {data} is no folder")
    if not os.access(given.program, os.X_OK) or pathlib.Path(given.program).is_dir():
        raise Wrong(f"{given.program}: no program (cargo build --release, or name one)")
    page = PAGE.read_text()
    if page.count(BEGIN) != 1 or page.count(END) != 1 or page.index(BEGIN) > page.index(END):
        raise Wrong(f"docs/measuring.md has not the marks {BEGIN} and {END}, once each")
    for name in only:  # every file is looked for before anything runs
        logs_of(name, data)
    heads = [
        "| error held out | as declared | *textbook* | *everything* | gearwise | known effects: *everything* | other names | known effects: gearwise | other names |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    try:
        made = [record(s, os.path.abspath(given.program), data) for s in SETS if s["name"] in only]
    except KeyError as error:
        raise Wrong(f"{error} is not where it was: in gearwise's answer, or in a bench file") from None
    if str(data) in "\n".join([m[0] for m in made] + sum((m[1] for m in made), [])):
        raise Wrong("the folder of the data is in the table: gearwise names its logs in another way now")
    sums = [total([m[2] for m in made])] if len(made) == len(SETS) else []
    parts = [heads[0], heads[1], *(m[0] for m in made), *sums, ""] + sum(([*m[1], ""] for m in made), [])
    if given.only and not given.check:
        print("\n".join(parts))
        return 0
    before, rest = page.split(BEGIN)
    old, after = rest.split(END)
    if given.only:
        lines = [line for line in parts if line]
        missing = [line for line in lines if line not in old.split("\n")]
        for line in missing:
            print(f"not in docs/measuring.md: {line}")
        return 1 if missing else 0
    new = "\n\n" + "\n".join(parts) + "\n"
    if given.check:
        if new == old:
            return 0
        print(
            "\n".join(
                difflib.unified_diff(old.split("\n"), new.split("\n"), "docs/measuring.md", "this run", lineterm="")
            )
        )
        return 1
    PAGE.write_text(before + BEGIN + new + END + after)
    return 0


if __name__ == "__main__":
    sys.exit(main())
