#!/usr/bin/env python3
"""Peers on the same work as gearwise: seconds, microseconds per pair, and whether the answers agree.

    python3 benches/peers.py --shared FOLDER --gearwise target/release/gearwise

FOLDER has `mgdb` (the Motor-Gearbox Database) and `cases/cords` (the published problem). Needs numpy.
Part 1: one arm joint, all pairs of motor and gearbox. Part 2: the ratio of one quadruped hip, all motors.
All methods run on one thread, one after the other; figures are medians. The page: docs/performance.md.
"""

import argparse
import csv
import fnmatch
import json
import math
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"
import numpy as np  # noqa: E402  (after the number of threads is set)

REPOSITORY = Path(__file__).resolve().parent.parent


# ---------------------------------------------------------------- measuring


def measured(work, repeat, who=resource.RUSAGE_SELF):
    """Medians of the clock and of the processor time (user and system), and what the last call returned."""
    def spent():
        used = resource.getrusage(who)
        return used.ru_utime + used.ru_stime

    clock, processor, result = [], [], None
    for _ in range(repeat):
        before, start = spent(), time.perf_counter()
        result = work()
        clock.append(time.perf_counter() - start)
        processor.append(spent() - before)
    return statistics.median(clock), statistics.median(processor), result


def process(command, repeat):
    """The same for a whole process, starting and reading its files included."""
    def work():
        done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        if done.returncode > 1:
            sys.exit(f"{' '.join(map(str, command))}: {done.stderr}")
    return measured(work, repeat, resource.RUSAGE_CHILDREN)[:2]


def output(command):
    """What a command prints; status 1 is an answer too (no design keeps everything)."""
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode > 1:
        sys.exit(f"{' '.join(map(str, command))}: {done.stderr}")
    return done.stdout


def table(unit, rows):
    """A table in markdown; a row is (name, clock, processor time, how many). The first row is the measure of the others."""
    print(f"| | clock [s] | processor [s] | µs per {unit} | times gearwise |\n|---|---|---|---|---|")
    base = rows[0][2] / rows[0][3]
    for name, clock, processor, count in rows:
        each = processor / count
        print(f"| {name} | {clock:.2g} | {processor:.2g} | {float(f'{1e6 * each:.2g}'):g} | {each / base:.2g} |")


# ---------------------------------------------------------------- part 1: pairs of motor and gearbox


def number(text, unknown):
    """A cell of the database; blank and NaN are unknown."""
    value = float(text) if text and text.strip() else math.nan
    return unknown if math.isnan(value) else value


def database(folder):
    """Motors, gearboxes and which fits which, out of the database's own files."""
    motors, gears, fits = {}, {}, {}
    for path in sorted(folder.glob("*/*_motors.csv")):
        for row in csv.DictReader(path.open()):
            motors[row["key"]] = row
    for path in sorted(folder.glob("*/*_gearboxes.csv")):
        for row in csv.DictReader(path.open()):
            gears[row["key"]] = row
    for path in sorted(folder.glob("*/*_compatibility.csv")):
        for motor, *patterns in csv.reader(path.open()):
            for pattern in filter(None, map(str.strip, patterns)):
                found = [pattern] if pattern in gears else fnmatch.filter(gears, pattern)
                fits.setdefault(motor, {}).update(dict.fromkeys(found))
    gears["DD"] = {"ratio": "1", "inertia": "0", "efficiency": "1"}
    return motors, gears, {motor: [*fits.get(motor, {}), "DD"] for motor in motors}


def cords_motor(row):
    """R, k_t, J, Coulomb and viscous friction, highest speed: what the case derives from a row."""
    r, k, volts = (number(row[name], math.nan) for name in ("R", "k_t", "V"))
    no_load_speed = number(row["omega_nl"], math.nan)
    no_load = number(row["I_nl"], (volts - k * no_load_speed) / r)
    coulomb, viscous = number(row["coulomb_friction"], math.nan), number(row["viscous_friction"], math.nan)
    if row["type"] == "DC":
        coulomb = k * no_load if math.isnan(coulomb) else coulomb
        viscous = 0.0 if math.isnan(viscous) else viscous
    else:
        coulomb = 0.0 if math.isnan(coulomb) else coulomb
        viscous = k * max(no_load, 0.0) / no_load_speed if math.isnan(viscous) else viscous
    speed = number(row.get("max_int_speed"), math.inf)
    return r, k, number(row["inertia"], 0.0), np.nan_to_num(coulomb), np.nan_to_num(viscous), speed


def cords_gear(row):
    """Ratio with its direction, inertia, efficiency (1 where none is given), peak and continuous torque."""
    names = (("ratio", 1.0), ("direction", 1.0), ("inertia", 0.0), ("efficiency", 1.0))
    ratio, direction, inertia, efficiency = (number(row.get(name), unknown) for name, unknown in names)
    torques = (number(row.get(name), math.inf) for name in ("max_int_torque", "max_cont_torque"))
    return ratio * direction, inertia, efficiency, *torques


def gearwise_id(key):
    """What gearwise's importer makes of a key of the database."""
    return "direct" if key == "DD" else key.lower().replace("_", "-").replace(":", "-")


class Cords:
    """The published problem: 24 V, 80 A, copper loss summed over the samples."""

    volts, amperes, filter_peak, filter_rms = 24.0, 80.0, 10.0, 0.77386

    def __init__(self, shared):
        rows = list(csv.DictReader((shared / "cases/cords/arm_trajectory.csv").open()))
        column = lambda name: np.array([float(row[name]) for row in rows])
        self.omega, self.alpha = column("omega_nudged_rad_s"), column("omega_dot_rad_s2")
        self.tau = column("tau_des_Nm")
        self.samples = list(zip(self.omega.tolist(), self.alpha.tolist(), self.tau.tolist()))
        self.fastest, self.largest = np.abs(self.omega).max(), np.abs(self.tau).max()
        motors, gears, fits = database(shared / "mgdb")
        self.motors = {key: cords_motor(row) for key, row in motors.items()}
        self.gears = {key: cords_gear(row) for key, row in gears.items()}
        self.fits = fits

    def only(self, pairs):
        """Keeps the pairs that gearwise has too; says how many others there were."""
        all_pairs = [(motor, gear) for motor in self.fits for gear in self.fits[motor]]
        self.pairs = [pair for pair in all_pairs if tuple(map(gearwise_id, pair)) in pairs]
        self.fits = {}
        for motor, gear in self.pairs:
            self.fits.setdefault(motor, []).append(gear)
        return len(all_pairs) - len(self.pairs)

    def passes(self, motor, gear):
        """Limits that need no sample: speed of the motor, torques of the gear."""
        torque = max(self.filter_peak, self.largest)
        return abs(gear[0]) * self.fastest <= motor[5] and torque <= gear[3] and self.filter_rms <= gear[4]

    def by_numpy(self):
        """The closed form of a pair in numpy over its samples; loss and whether it is feasible, pair by pair."""
        losses, feasible = np.empty(len(self.pairs)), np.empty(len(self.pairs), bool)
        for at, (motor, gear) in enumerate(self.pairs):
            motor, gear = self.motors[motor], self.gears[gear]
            (r, k, inertia, coulomb, viscous, _), (ratio, gear_inertia, efficiency, *_) = motor, gear
            speed = ratio * self.omega
            load = self.tau + gear_inertia * ratio**2 * self.alpha
            torque = load / ratio * np.where(load * self.omega > 0, 1 / efficiency, efficiency)
            torque += ratio * inertia * self.alpha + coulomb * np.sign(speed) + viscous * speed
            current = torque / k
            losses[at] = r * (current @ current)
            feasible[at] = (
                np.abs(current).max() <= self.amperes
                and np.abs(r * current + k * speed).max() <= self.volts
                and self.passes(motor, gear)
            )
        return losses, feasible

    def by_numpy_at_once(self):
        """The same with all gears of a motor in one array."""
        losses, feasible = [], []
        for motor, gears in self.fits.items():
            r, k, inertia, coulomb, viscous, fastest = self.motors[motor]
            ratio, gear_inertia, efficiency, peak, continuous = np.array([self.gears[key] for key in gears]).T[:, :, None]
            speed = ratio * self.omega
            load = self.tau + gear_inertia * ratio**2 * self.alpha
            torque = load / ratio * np.where(load * self.omega > 0, 1 / efficiency, efficiency)
            torque += ratio * inertia * self.alpha + coulomb * np.sign(speed) + viscous * speed
            current = torque / k
            losses.append(r * (current**2).sum(axis=1))
            keeps = np.abs(current).max(axis=1) <= self.amperes
            keeps &= np.abs(r * current + k * speed).max(axis=1) <= self.volts
            keeps &= (np.abs(ratio) * self.fastest <= fastest)[:, 0]
            torque = max(self.filter_peak, self.largest)
            keeps &= ((torque <= peak) & (self.filter_rms <= continuous))[:, 0]
            feasible.append(keeps)
        return np.concatenate(losses), np.concatenate(feasible)

    def by_loop(self, pairs):
        """The same with a plain loop over the samples."""
        found = []
        for motor, gear in pairs:
            motor, gear = self.motors[motor], self.gears[gear]
            (r, k, inertia, coulomb, viscous, _), (ratio, gear_inertia, efficiency, *_) = motor, gear
            total, most_current, most_voltage = 0.0, 0.0, 0.0
            for omega, alpha, tau in self.samples:
                speed = ratio * omega
                load = tau + gear_inertia * ratio * ratio * alpha
                torque = load / ratio * (1 / efficiency if load * omega > 0 else efficiency)
                torque += ratio * inertia * alpha + math.copysign(coulomb, speed) + viscous * speed
                current = torque / k
                total += current * current
                most_current = max(most_current, abs(current))
                most_voltage = max(most_voltage, abs(r * current + k * speed))
            keeps = most_current <= self.amperes and most_voltage <= self.volts
            found.append((r * total, keeps and self.passes(motor, gear)))
        return found

    def requirement(self, path, gears):
        """The problem as a requirement of gearwise."""
        with path.open("w") as file:
            file.write(f'name = "arm"\n[bus]\nvoltage = "{self.volts} V"\ndrive_current = "{self.amperes} A"\n')
            file.write(f'[[joint]]\nname = "arm"\ngears = ["{gears}"]\nefficiency_covers = "load_and_gear"\n')
            file.write('objective = "copper_loss"\npoints = [\n')
            for omega, alpha, tau in self.samples:
                file.write(f'    {{ torque = "{tau!r} N*m", speed = "{omega!r} rad/s", ')
                file.write(f'acceleration = "{alpha!r} rad/s^2", duration = "0.01 s" }},\n')
            file.write("]\n")


def rewritten(source, target, change):
    """A catalogue file with every row changed."""
    rows = csv.reader(line for line in source.open() if not line.startswith("#"))
    head = [cell.strip() for cell in next(rows)]
    rows = [change(dict(zip(head, row))) for row in rows]
    target.parent.mkdir(parents=True, exist_ok=True)
    with target.open("w", newline="") as file:
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        writer.writerows(rows)


def blank(row, *names):
    """Columns whose names begin so lose their value."""
    return {key: "" if key.startswith(names) else value for key, value in row.items()}


def published_motor(row):
    """What the problem does not know: inductance, ratings, heat, copper that gets warmer."""
    row = blank(row, "continuous_", "peak_torque", "thermal_", "inductance", "reference_temperature")
    return row | {"inductance [H]": "0", "reference_temperature [degC]": "100"}


def published_gear(row):
    """The filter by the continuous torque is a number of the problem's own."""
    small = number(row.get("continuous_torque [N*m]"), math.inf) < Cords.filter_rms
    row = blank(row, "continuous_torque")
    return row | {"peak_torque [N*m]": "1e-9"} if small else row


def pairs_of_motor_and_gear(options, folder):
    *reading_time, cords = measured(lambda: Cords(options.shared), options.repeat)
    whole, reduced = folder / "whole", folder / "published"
    output([options.gearwise, "import", "mgdb", options.shared / "mgdb", "--out", whole])
    for path in whole.glob("motors/*.csv"):
        rewritten(path, reduced / "motors" / path.name, published_motor)
    for path in whole.glob("gears/*.csv"):
        rewritten(path, reduced / "gears" / path.name, published_gear)
    cords.requirement(folder / "arm.toml", "*")
    cords.requirement(folder / "start.toml", "direct")

    def command(catalog, requirement="arm.toml"):
        flags = ["--no-estimates", "--threads", "1", "--quiet"]
        return [options.gearwise, "sweep", folder / requirement, "--catalog", catalog, *flags]

    text = output([*command(reduced), "--csv", "--infeasible"])
    ours = {(row["motor"], row["gear"]): row for row in csv.DictReader(text.splitlines())}
    others = cords.only(ours.keys())
    count, some = len(cords.pairs), cords.pairs[:: options.every]
    *start_time, = process(command(reduced, "start.toml"), options.repeat)
    *sweep_time, = process(command(reduced), options.repeat)
    *whole_time, = process(command(whole), options.repeat)
    *numpy_time, (losses, feasible) = measured(cords.by_numpy, options.repeat)
    *once_time, (losses_at_once, feasible_at_once) = measured(cords.by_numpy_at_once, options.repeat)
    *loop_time, by_loop = measured(lambda: cords.by_loop(some), options.repeat)
    scale = count / len(some)

    print(f"## All pairs of motor and gearbox\n\n{count} pairs, {len(cords.samples)} samples.\n")
    table("pair", [
        ("gearwise `sweep`, limits of the problem, whole process", *sweep_time, count),
        ("gearwise `sweep`, its own limits too, whole process", *whole_time, count),
        ("CORDS' method, numpy over the samples", *numpy_time, count),
        ("the same, numpy over gears and samples", *once_time, count),
        (f"plain Python loop ({len(some)} pairs, scaled)", *(scale * x for x in loop_time), count),
    ])

    def same(a, b):
        return abs(a / b - 1) <= 1e-6

    theirs = {(gearwise_id(m), gearwise_id(g)): (losses[at], feasible[at]) for at, (m, g) in enumerate(cords.pairs)}
    loss = {pair: 101 * float(row["copper_loss_w"]) for pair, row in ours.items() if row["copper_loss_w"]}
    keeps = {pair for pair, row in ours.items() if row["state"] in ("candidate", "unjudged")}
    said = {pair for pair, (_, kept) in theirs.items() if kept}
    exact = {}
    for row in csv.DictReader((options.shared / "cases/cords/joule_rigid_exact.csv").open()):
        if row["passes_cords_filter"] == row["feasible"] == "1":
            exact[gearwise_id(row["motor"]), gearwise_id(row["gearbox"])] = float(row["cost_sum_R_I2"])
    agree = sum(same(loss[pair], theirs[pair][0]) for pair in keeps & said)
    everywhere = sum(pair in theirs and same(loss[pair], theirs[pair][0]) for pair in loss)
    print(f"\nStart and reading of gearwise, in its figures: {start_time[1]:.2g} s (a sweep with direct drive alone). ", end="")
    print(f"Reading in Python, in none of its figures: {reading_time[1]:.2g} s.")
    print(f"Pairs in both lists: {len(ours.keys() & theirs.keys())} of {len(ours)}; left out of Python's: {others}.")
    print(f"Feasible: gearwise {len(keeps)}, numpy {len(said)}, both {len(keeps & said)}; loss within 1e-6: {agree}.")
    print(f"Loss within 1e-6, infeasible pairs too: {everywhere} of {len(loss)}.")
    published = sum(pair in said and same(theirs[pair][0], cost) for pair, cost in exact.items())
    print(f"Published exact losses: {len(exact)}; numpy agrees with {published} of them, ", end="")
    print(f"gearwise with {sum(pair in keeps and same(loss[pair], cost) for pair, cost in exact.items())}.")
    as_one = np.allclose(losses, losses_at_once, rtol=1e-9) and (feasible == feasible_at_once).all()
    looped = all(same(a, losses[options.every * i]) and b == feasible[options.every * i] for i, (a, b) in enumerate(by_loop))
    print(f"Both numpy forms agree: {'yes' if as_one else 'NO'}; the plain loop with them: {'yes' if looped else 'NO'}.\n")


# ---------------------------------------------------------------- part 2: the ratio of one joint

UNITS = {
    "ohm": 1.0, "mH": 1e-3, "N*m/A": 1.0, "V*s/rad": 1.0, "rpm/V": math.pi / 30, "g*cm^2": 1e-7, "A": 1.0,
    "N*m": 1.0, "rpm": math.pi / 30, "degC": 1.0, "N*m*s/rad": 1.0,
}
BLOCK = math.sqrt(1.5) * math.pi / (3 * math.sqrt(3))
TORQUE_CONSTANT = {"q_axis": 1.0, "phase_amplitude": math.sqrt(2 / 3), "rms": 1 / math.sqrt(3), "dc": BLOCK}
HEATING = {"q_axis": 1.0, "phase_amplitude": math.sqrt(1.5), "rms": math.sqrt(3), "dc": math.sqrt(2)}
BACK_EMF = {
    "q_axis": 1.0, "line_to_line_peak": math.sqrt(0.5), "line_to_line_rms": 1.0, "phase_peak": math.sqrt(1.5),
    "phase_rms": math.sqrt(3), "dc": BLOCK,
}


def q_axis(row):
    """A row of a motor catalogue as its q-axis machine (docs/formats.md, Conventions); None where a number lacks."""
    value = {}
    for key, cell in row.items():
        column, _, unit = key.partition(" [")
        if unit.rstrip("]") in UNITS and "tolerance" not in column:
            value[column] = number(cell, math.nan) * UNITS[unit.rstrip("]")]
    brushed, current = row["commutation"] == "brushed", row["current"]
    terminals = 0.5 if row["terminals"] == "line_to_line" else 1.0
    if row["terminals"] == "winding" and row["winding"] == "delta":
        terminals = 1 / 3
    terminals = 1.0 if brushed else terminals
    factor = lambda table, convention: 1.0 if brushed else table.get(convention, math.nan)
    k_t = value["torque_constant"] * factor(TORQUE_CONSTANT, current)
    k_b = value["back_emf_constant"] * factor(BACK_EMF, row["back_emf_convention"])
    by_speed = factor(BACK_EMF, row["speed_constant_convention"]) / value["speed_constant"]
    if math.isnan(k_t):
        k_t = by_speed if math.isnan(k_b) else k_b
    if math.isnan(k_b):
        k_b = by_speed if by_speed > 1.01 * k_t else k_t
    known = lambda name, otherwise: otherwise if math.isnan(value[name]) else value[name]
    reference, hottest = known("reference_temperature", 25.0), known("max_winding_temperature", 100.0)
    per_kelvin = 0.00393 / (1 + 0.00393 * (reference - 20))
    r = value["resistance"] * terminals
    pairs = 0.0 if brushed else number(row["pole_pairs"], math.nan)
    motor = {
        "r": r, "hot": r * (1 + per_kelvin * (hottest - reference)), "k_t": k_t, "k_b": max(k_b, k_t),
        "l": np.nan_to_num(value["inductance"]) * terminals, "p": np.nan_to_num(pairs),
        "j": value["rotor_inertia"], "c": np.nan_to_num(value["coulomb_friction"]),
        "b": np.nan_to_num(value["viscous_friction"]), "brushed": brushed,
        "peak_current": known("peak_current", math.inf) / factor(TORQUE_CONSTANT, current),
        "continuous_current": known("continuous_current", math.inf) * factor(HEATING, current),
        "peak_torque": known("peak_torque", math.inf), "continuous_torque": known("continuous_torque", math.inf),
        "max_speed": known("max_speed", math.inf),
    }
    return None if any(math.isnan(motor[name]) for name in ("r", "k_t", "j")) else motor


class Hip:
    """One hip of requirements/quadruped_mini_cheetah.toml with a free ratio; all rates are given, so samples are all."""

    least, most, volts, share, amperes, safety, inertia = 3.0, 60.0, 24.0, 0.95, 40.0, 1.2, 0.01
    efficiency, gear_inertia = 0.94, 2e-6

    def __init__(self, returned=None, finer=1):
        self.returned = returned
        path = REPOSITORY / "requirements/motions/quadruped_trot_hip.csv"
        rows = csv.DictReader((line for line in path.open() if not line.startswith("#")), skipinitialspace=True)
        rows = list(rows)[:-1]  # the last row repeats the first
        column = lambda name: np.array([float(row[name]) for row in rows])
        self.time, self.tau = column("time [s]"), column("torque [N*m]")
        self.omega, self.alpha = column("velocity [rad/s]"), column("acceleration [rad/s^2]")
        if finer > 1:
            at, end = np.arange(len(rows) * finer) * self.time[1] / finer, len(rows) * self.time[1]
            column = lambda x: np.interp(at, [*self.time, end], [*x, x[0]])
            self.tau, self.omega, self.alpha, self.time = *map(column, (self.tau, self.omega, self.alpha)), at
        slope = lambda x: (np.roll(x, -1) - np.roll(x, 1)) / (2 * (self.time[1] - self.time[0]))
        self.rate, self.jerk = slope(self.tau), slope(self.alpha)
        self.factor = np.where(self.tau * self.omega > 0, 1 / self.efficiency, 2 - 1 / self.efficiency)

    def requirement(self, folder):
        regeneration = "allowed" if self.returned is None else f"{self.returned} W"
        columns = np.array([self.time, self.tau, self.omega, self.alpha, self.rate, self.jerk])
        last = columns[:, :1] + [[self.time[1] * len(self.time)], *[[0.0]] * 5]  # the first again, a period later
        names = "time [s],torque [N*m],velocity [rad/s],acceleration [rad/s^2],torque_rate [N*m/s],jerk [rad/s^3]"
        rows = [",".join(map(repr, row)) for row in np.hstack([columns, last]).T.tolist()]
        (folder / "hip.csv").write_text("\n".join([names, *rows]) + "\n")
        (folder / "hip.toml").write_text(
            f'name = "hip"\n[bus]\nvoltage = "{self.volts} V"\nmodulation = "space_vector"\n'
            f'modulation_limit = {self.share}\ndrive_current = "{self.amperes} A"\n'
            f'regeneration = "{regeneration}"\n[[joint]]\nname = "hip"\nratio = {{ min = {self.least}, max = {self.most} }}\n'
            f'gear = {{ efficiency = {self.efficiency}, inertia = "{self.gear_inertia} kg*m^2" }}\n'
            f'motion = "hip.csv"\nobjective = "copper_loss"\nmotor_drag = "off"\n'
            f'[joint.limits]\nreflected_inertia = "{self.inertia} kg*m^2"\nsafety = {self.safety}\n'
        )

    def at(self, m, n):
        """Copper loss at a ratio, and the largest demand over its bound."""
        j = m["j"] + self.gear_inertia
        torque = self.factor * self.tau / n + n * (j * self.alpha + m["b"] * self.omega) + m["c"] * np.sign(self.omega)
        rate = self.factor * self.rate / n + n * (j * self.jerk + m["b"] * self.alpha)
        v_q = (m["hot"] * torque + m["l"] * rate) / m["k_t"] + m["k_b"] * n * self.omega
        v_d = m["p"] * n * self.omega * m["l"] * torque / m["k_t"]
        volts = self.share * self.volts / (1.0 if m["brushed"] else math.sqrt(2))
        drive = self.amperes * (1.0 if m["brushed"] else math.sqrt(1.5))
        mean = (torque @ torque) / len(torque)
        largest, rms = np.abs(torque).max(), math.sqrt(mean)
        worst = max(
            self.safety * largest / m["k_t"] / min(drive, m["peak_current"]),
            self.safety * largest / m["peak_torque"],
            rms / m["k_t"] / m["continuous_current"],
            rms / m["continuous_torque"],
            math.sqrt((v_q * v_q + v_d * v_d).max()) / volts,
            n * np.abs(self.omega).max() / m["max_speed"],
            n * n * j / self.inertia,
        )
        if self.returned is not None:
            power = m["r"] * torque**2 / m["k_t"] ** 2 + m["k_b"] / m["k_t"] * n * self.omega * torque
            worst = max(worst, -power.min() / self.returned)
        return m["r"] * mean / m["k_t"] ** 2, worst

    def by_grid(self, motors, ratios=200):
        """The best of a grid of ratios for each motor: (ratio, loss), or None."""
        grid = np.geomspace(self.least, self.most, ratios)
        best = {}
        for name, m in motors.items():
            best[name] = None
            for n in grid:
                loss, worst = self.at(m, n)
                if worst <= 1 and (best[name] is None or loss < best[name][1]):
                    best[name] = (n, loss)
        return best

    def by_penalty(self, motors):
        """Golden section over ln N of the loss, with a penalty where a limit is exceeded: (ratio, loss), or None."""
        best = {}
        for name, m in motors.items():
            def penalised(x):
                loss, worst = self.at(m, math.exp(x))
                return loss if worst <= 1 else 1e9 * worst
            x = golden(penalised, math.log(self.least), math.log(self.most))
            loss = penalised(x)
            best[name] = (math.exp(x), loss) if loss < 1e9 else None
        return best

    def by_golden_section(self, motors):
        """Golden section over ln N between the ends that bisection finds: (ratio, loss, low, high), or None."""
        best = {}
        for name, m in motors.items():
            low, high = math.log(self.least), math.log(self.most)
            worst = lambda x: self.at(m, math.exp(x))[1]
            inside = golden(worst, low, high, until=1.0)
            if worst(inside) > 1:
                best[name] = None
                continue
            low, high = edge(worst, inside, low), edge(worst, inside, high)
            loss = lambda x: self.at(m, math.exp(x))[0]
            x = min(low, high, golden(loss, low, high), key=loss)
            best[name] = (math.exp(x), loss(x), math.exp(low), math.exp(high))
        return best


def golden(f, low, high, until=-math.inf):
    """Where a function of one valley is least; ends early where it is no more than `until`."""
    share = (math.sqrt(5) - 1) / 2
    a, b = high - share * (high - low), low + share * (high - low)
    f_a, f_b = f(a), f(b)
    while high - low > 1e-8 and min(f_a, f_b) > until:
        if f_a < f_b:
            high, b, f_b = b, a, f_a
            a = high - share * (high - low)
            f_a = f(a)
        else:
            low, a, f_a = a, b, f_b
            b = low + share * (high - low)
            f_b = f(b)
    return a if f_a < f_b else b


def edge(worst, inside, outside):
    """The last point that keeps every limit on the way from one that does."""
    if worst(outside) <= 1:
        return outside
    for _ in range(45):
        middle = (inside + outside) / 2
        inside, outside = (middle, outside) if worst(middle) <= 1 else (inside, middle)
    return inside


def own_motor(row):
    """Heat and iron that saturates are left out, so that both sides compute the same."""
    return blank(row, "thermal_", "peak_torque_of")


def ratio_of_one_joint(options, folder, title, hip):
    motors = {}
    hip.requirement(folder)
    for path in sorted((REPOSITORY / "catalogs/motors").glob("*.csv")):
        rewritten(path, folder / "motors" / path.name, own_motor)
        for row in csv.DictReader((folder / "motors" / path.name).open()):
            motor = q_axis(row)
            if motor and not row["only_inside"] and not row["same_as"]:
                motors[row["id"]] = motor
    flags = ["--no-estimates", "--threads", "1", "--quiet"]
    command = [options.gearwise, "optimize", folder / "hip.toml", "--catalog", folder / "motors", *flags]
    joint = json.loads(output([*command, "--json"]))["joints"][0]
    designs = joint["candidates"] + [entry["design"] for entry in joint["unjudged"] if entry.get("design")]
    solved = len(joint["candidates"]) + len(joint["unjudged"]) + len(joint["rejected"])
    ours_time = process(command, options.repeat)
    top_time = process([*command, "--only-top", "3"], options.repeat)
    *grid_time, by_grid = measured(lambda: hip.by_grid(motors), options.repeat)
    *penalty_time, by_penalty = measured(lambda: hip.by_penalty(motors), options.repeat)
    *golden_time, by_golden = measured(lambda: hip.by_golden_section(motors), options.repeat)

    print(f"## {title}\n\n{len(motors)} motors ({solved} of gearwise), {len(hip.time)} samples, ", end="")
    print(f"ratios {hip.least:g} to {hip.most:g}.\n")
    table("motor", [
        ("gearwise `optimize` with proof, whole process", *ours_time, len(motors)),
        ("gearwise `optimize --only-top 3`, whole process", *top_time, len(motors)),
        ("grid of 200 ratios, numpy over the samples", *grid_time, len(motors)),
        ("golden section over N with a penalty", *penalty_time, len(motors)),
        ("golden section over N between ends by bisection", *golden_time, len(motors)),
    ])

    same = {}
    for design in designs:
        m = motors.get(design["motor"])
        if m is None:
            continue
        loss, worst = hip.at(m, design["ratio"])
        if abs(loss / design["objective"] - 1) <= 1e-6 and worst <= 1 + 1e-6:
            same[design["motor"]] = design
    certified = {name: d for name, d in same.items() if d["certificate"]["certified"]}
    print(f"\nDesigns of gearwise: {len(designs)}. Loss within 1e-6 at gearwise's ratio, all limits kept: {len(same)}, ", end="")
    print(f"of these proved: {len(certified)}. The rest of this part is about these.")
    inner = sum(hip.least * 1.0001 < d["ratio"] < hip.most / 1.0001 for d in certified.values())
    print(f"N* between the given ends: {inner} (the others at an end).")

    def windows_agree(name):
        low, high = certified[name]["window"]
        found = by_golden[name]
        return found is not None and abs(found[2] / low - 1) <= 1e-6 and abs(found[3] / high - 1) <= 1e-6

    print(f"Both ends of the window within 1e-6 of bisection's: {sum(map(windows_agree, certified))}.\n")
    print("| | finds no ratio | N off by more than 0.1 % | loss above by more than 1e-6 | by more than 0.1 % ", end="")
    print("| most above | loss below by more than 1e-6 |\n|---|---|---|---|---|---|---|")
    methods = {"grid of 200 ratios": by_grid, "golden section, penalty": by_penalty, "golden section, ends by bisection": by_golden}
    for label, found in methods.items():
        none = sum(found[name] is None for name in certified)
        pairs = [(found[name], d) for name, d in certified.items() if found[name]]
        above = [f[1] / d["objective"] - 1 for f, d in pairs]
        off = sum(abs(f[0] / d["ratio"] - 1) > 1e-3 for f, d in pairs)
        print(f"| {label} | {none} | {off} | {sum(x > 1e-6 for x in above)} | {sum(x > 1e-3 for x in above)} ", end="")
        print(f"| {max(above, default=0):.2g} | {sum(x < -1e-6 for x in above)} |")
    wrong = [name for name, found in by_golden.items() if found and name not in {d["motor"] for d in designs}]
    print(f"\nMotors that gearwise rejects and golden section keeps: {', '.join(wrong) or 'none'}.\n")
    if options.verbose:
        for design in designs:
            if design["motor"] not in same and design["motor"] in motors:
                loss, worst = hip.at(motors[design["motor"]], design["ratio"])
                print(f"  other physics: {design['motor']} {design['ratio']:.6g} {design['objective']:.6g} {loss:.6g} {worst:.8g}")
        for name in certified:
            if not windows_agree(name):
                print(f"  window: {name} {certified[name]['window']} {certified[name]['binds']} {by_golden[name]}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shared", type=Path, default=REPOSITORY.parent / "shared", help="folder with `mgdb` and `cases`")
    parser.add_argument("--gearwise", type=Path, default=REPOSITORY / "target/release/gearwise", help="the program")
    parser.add_argument("--repeat", type=int, default=5, help="repetitions; the median is shown [default: 5]")
    parser.add_argument("--every", type=int, default=40, help="the plain loop takes one pair of so many [default: 40]")
    parser.add_argument("--returned", type=float, default=20.0, help="watts that may come back in the last problem [default: 20]")
    parser.add_argument("--verbose", action="store_true", help="motors that differ, one by one")
    options = parser.parse_args()
    if not ((options.shared / "mgdb").is_dir() and (options.shared / "cases/cords").is_dir()):
        print(f"skipped: {options.shared} has no `mgdb` and `cases/cords`")
        return
    print(f"Python {sys.version.split()[0]}, numpy {np.__version__}, ", end="")
    print(f"{output([options.gearwise, '--version']).strip()}, median of {options.repeat}.\n")
    with tempfile.TemporaryDirectory() as folder:
        pairs_of_motor_and_gear(options, Path(folder))
        ratio_of_one_joint(options, Path(folder), "The ratio of one joint", Hip())
        ratio_of_one_joint(options, Path(folder), "The same with ten times as many samples", Hip(finer=10))
        title = f"The same with at most {options.returned:g} W back to the bus"
        ratio_of_one_joint(options, Path(folder), title, Hip(options.returned))


if __name__ == "__main__":
    main()
