"""Logs of a motor bench that does not exist -> ../bench/motor_on_bench_*.csv.   Needs nothing but Python.

A motor of the size of a T-Motor RI50 goes through every test that `characterize` knows. What the motor is: the constants
below. What the measurement adds: noise, a zero of each log on the torque sensor, a slope that differs by 2 % from stall log
to stall log, a velocity that comes LATE, and in the third stall log a sensor of the wrong sign.
"""
import math
import random

K_T = K_B = 0.0857          # q axis [N m/A, V s/rad]
R_LL = 1.41                 # line to line [ohm]
J_M, J_FIXTURE, RATIO = 9.0e-6, 1.48e-4, 7.5
B_WITH, B_WITHOUT = 1.6e-3, 0.9e-3
COULOMB, VISCOUS = 0.015, 1.2e-4
R_WH, R_HA, TAU_W, TAU_H = 1.6, 2.4, 28.0, 420.0
AMBIENT, COPPER = 22.0, 0.0039
RATE, DURATION, LATE, CUT_OFF = 500.0, 7.5, 0.004, 40.0
AMPLITUDE = math.sqrt(1.5)  # q-axis ampere per ampere of phase amplitude


def write(name, header, rows):
    with open(f"../bench/motor_on_bench_{name}.csv", "w") as out:
        out.write(header + "\n")
        out.writelines(",".join(row) + "\n" for row in rows)


def stall(log, slope, zero, sign):
    """Steps of current of 2 s, -6 to 6 A in steps of 2 A, up and down."""
    r = random.Random(10 + log)
    steps = list(range(-6, 7, 2)) + list(range(4, -7, -2))
    rows = []
    for step, amperes in enumerate(steps):
        position = 0.0012 * r.gauss(0, 1)  # cogging where it happens to stand
        for k in range(50):
            i = amperes - 0.9 * math.exp(-k / 2)
            torque = sign * (slope * K_T * AMPLITUDE * i + position) + zero + r.gauss(0, 0.004)
            warm = 24 + 0.8 * step + 0.02 * k
            rows.append((f"{2 * step + k / 25:.2f}", f"{i + r.gauss(0, 0.02):.3f}", f"{torque:.4f}", f"{warm:.1f}"))
    write(f"stall_{log}", "t_s,iq_a,tau_nm,winding_degc", rows)


def backdrive():
    """A drill, an oscilloscope between two terminals: speed and amplitude."""
    r = random.Random(20)
    rows = [(str(rpm), f"{math.sqrt(2) * K_B * rpm * math.pi / 30 + r.gauss(0, 0.05):.3f}") for rpm in range(250, 2251, 250)]
    write("backdrive", "speed_rpm,amplitude_v", rows)


def random_torque(log, inertia, damping, seed):
    """Low-passed white noise drives J w' + B w = T, exactly between steps of an eighth of a sample."""
    r = random.Random(seed)
    fine, h = 8, 1 / (8 * RATE)
    k = math.tan(math.pi * CUT_OFF * h)
    norm = 1 / (1 + math.sqrt(2) * k + k * k)
    b0, a1, a2 = k * k * norm, 2 * (k * k - 1) * norm, (1 - math.sqrt(2) * k + k * k) * norm
    s1 = s2 = speed = 0.0
    decay = math.exp(-damping * h / inertia)
    torques, speeds = [], []
    for _ in range(int((DURATION + 2) * RATE * fine)):
        x = r.gauss(0, 1)
        y = b0 * x + s1
        s1, s2 = 2 * b0 * x - a1 * y + s2, b0 * x - a2 * y
        torques.append(2.4 * y)
        speeds.append(speed)
        speed = 2.4 * y / damping + (speed - 2.4 * y / damping) * decay
    first = int(1 * RATE * fine)
    rows = []
    for sample in range(int(DURATION * RATE)):
        at = first + sample * fine
        late = speeds[at - round(LATE / h)] + r.gauss(0, 0.03)
        command = torques[at + 16] / 0.79  # the drive needs 4 ms
        rows.append((f"{sample / RATE:.3f}", f"{command:.3f}", f"{(torques[at - 1] + torques[at]) / 2 + 0.03 + r.gauss(0, 0.02):.3f}", f"{late:.2f}"))
    write(log, "t_s,cmd_a,tau_nm,omega_radps", rows)


def drag():
    """Steps of speed of 2 s both ways, torque sensor between driving and driven machine."""
    r = random.Random(40)
    rows = []
    for step, speed in enumerate([0, 15, 30, 60, 90, 120, 0, -15, -30, -60, -90, -120]):
        off = r.gauss(0, 0.0004)
        for k in range(40):
            omega = speed * (1 - math.exp(-k / 2)) + r.gauss(0, 0.1)
            torque = COULOMB * (speed > 0) - COULOMB * (speed < 0) + VISCOUS * omega + off - 0.021 + r.gauss(0, 0.002)
            rows.append((f"{2 * step + k / 20:.2f}", f"{omega:.2f}", f"{torque:.4f}"))
    write("drag", "t_s,omega_radps,tau_nm", rows)


def thermal():
    """DC of 3 A between two terminals for 20 minutes, then 10 minutes of cooling."""
    r = random.Random(50)
    c_w, c_h = TAU_W / R_WH, TAU_H / R_HA
    winding = housing = AMBIENT
    rows, dt = [], 0.05
    for k in range(int(1800 / dt)):
        current = 3.0 if k * dt < 1200 else 0.0
        if k % int(5 / dt) == 0:
            rows.append((f"{k * dt:.0f}", f"{current:.2f}", f"{winding + r.gauss(0, 0.15):.1f}", f"{housing + r.gauss(0, 0.15):.1f}"))
        heat = R_LL * (1 + COPPER * (winding - AMBIENT)) * current ** 2
        through = (winding - housing) / R_WH
        winding, housing = winding + dt * (heat - through) / c_w, housing + dt * (through - (housing - AMBIENT) / R_HA) / c_h
    write("thermal", "t_s,dc_a,winding_degc,housing_degc", rows)


stall(1, 0.985, -0.031, 1)
stall(2, 1.01, 0.012, 1)
stall(3, 1.0, 0.004, -1)
backdrive()
random_torque("rotor", J_FIXTURE + RATIO ** 2 * J_M, B_WITH, 30)
random_torque("no_rotor", J_FIXTURE, B_WITHOUT, 31)
drag()
thermal()
