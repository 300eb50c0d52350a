"""Logs of a bench that does not exist -> ../bench/leg_actuator_*.csv.   Needs nothing but Python.

A T-Motor RI50 (numbers of the shipped catalogue) behind a gear of 9:1 on a dynamometer: it moves by a sum of sines, a second
machine loads it by another sum of sines. What the declared model does not have: Coulomb friction of COULOMB and cogging of
order 12 (12 slots) of COGGING, both at the motor. What the measurement adds: noise, a zero of each log on the torque sensor,
an encoder of 14 bits, a speed and position that come LATE.
"""
import math
import random

RATIO, K_T, J = 9.0, 0.105, 90.1e-7
COULOMB, COGGING, ORDER = 0.055, 0.03, 12
RATE, DURATION, LATE = 400.0, 7.5, 0.004
COUNTS = 16384
AMPLITUDE = math.sqrt(1.5)  # q-axis ampere per ampere of phase amplitude
ZEROS = [0.06, -0.11, 0.15]


def sines(r, lowest, highest, amplitude, count=6):
    """(frequency, amplitude, phase) of each sine."""
    frequencies = [lowest * (highest / lowest) ** ((k + r.random()) / count) for k in range(count)]
    return [(f, amplitude / count ** 0.5 * r.uniform(0.7, 1.3), r.uniform(0, 2 * math.pi)) for f in frequencies]


def at(parts, t, derivative=0):
    """Value, derivative or integral (-1) of a sum of sines."""
    return sum(a * (2 * math.pi * f) ** derivative * math.sin(2 * math.pi * f * t + p + derivative * math.pi / 2) for f, a, p in parts)


for log, zero in enumerate(ZEROS, 1):
    r = random.Random(100 + log)
    speed, load = sines(r, 0.15, 2.5, 3.2), sines(r, 0.2, 3.5, 3.0)
    with open(f"../bench/leg_actuator_{log}.csv", "w") as out:
        out.write("t_s,iq_a,omega_radps,theta_rad,tau_nm,winding_degc\n")
        for k in range(int(RATE * DURATION)):
            t = k / RATE
            omega, alpha, theta = (RATIO * at(speed, t, d) for d in (0, 1, -1))
            tau = at(load, t)
            friction = COULOMB * math.tanh(omega / 0.05) + COGGING * math.cos(ORDER * theta - 0.7)
            current = (tau / RATIO + J * alpha + friction) / K_T
            count = round(RATIO * at(speed, t - LATE, -1) * COUNTS / (2 * math.pi))
            cells = [
                f"{t:.4f}",
                f"{current / AMPLITUDE + r.gauss(0, 0.02):.3f}",
                f"{RATIO * at(speed, t - LATE) + r.gauss(0, 0.05):.3f}",
                f"{count * 2 * math.pi / COUNTS:.4f}",
                f"{tau + zero + r.gauss(0, 0.04):.3f}",
                f"{25 + 14 * (1 - math.exp(-t / 6)) + 4 * log + r.gauss(0, 0.1):.1f}",
            ]
            out.write(",".join(cells) + "\n")
