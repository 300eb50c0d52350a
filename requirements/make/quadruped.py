"""Trot of one leg of a Mini-Cheetah-class quadruped -> ../motions/quadruped_trot_*.csv.   Needs numpy.

Published: mass 9 kg, 24 V, 6:1 actuators (B. Katz, J. Di Carlo, S. Kim, "Mini Cheetah", ICRA 2019); links 0.209 m and 0.195 m,
link masses, centres of mass and inertias from MiniCheetah.h of mit-biomimetics/Cheetah-Software
(thigh 0.634 kg, with the knee's actuator, centre 0.020 m below the hip, 2103e-6 kg m^2; shank 0.064 kg, 0.061 m below the knee,
248e-6 kg m^2).
Assumed: speed 1 m/s, period 0.5 s, duty factor 0.5, hip 0.27 m above ground at constant height and speed, no horizontal ground force.
Stance: the foot moves back at 1 m/s; vertical ground force F sin^2(pi s), s = 0..1 over stance, whose mean over the
period is a quarter of the weight: F = m g / (2 duty).
Swing: forward by the polynomial of degree 7 that joins position, velocity, acceleration and jerk of stance; lift 0.06 m sin^4(pi s).
Torque = inverse dynamics of thigh and shank (planar, relative knee angle) minus J^T (ground force).
x forward, z up; hip angle of the thigh from straight down, forward positive; knee angle positive when the shank swings forward
(so a bent knee is negative). Torque and velocity have the same sign convention: their product is the power of the actuator.
"""
import numpy as np

G, MASS, SPEED, PERIOD, DUTY, HEIGHT, LIFT = 9.81, 9.0, 1.0, 0.5, 0.5, 0.27, 0.06
L1, L2 = 0.209, 0.195
M1, C1, I1 = 0.634, 0.020, 2103e-6
M2, C2, I2 = 0.064, 0.061, 248e-6
SAMPLES = 200
SHIFT = 0.37 * PERIOD / SAMPLES  # first sample, so that none falls on a reversal
STANCE = DUTY * PERIOD
SWING = PERIOD - STANCE


def foot(t):
    """Foot relative to the hip, its velocity and acceleration (rows x, z), and the vertical ground force."""
    if t < STANCE:
        force = MASS * G / (2 * DUTY) * np.sin(np.pi * t / STANCE) ** 2
        return np.array([[STANCE * SPEED / 2 - SPEED * t, -SPEED, 0], [-HEIGHT, 0, 0]]), force
    # degree 7: what remains of a straight line at -SPEED is a rest-to-rest move over SPEED * PERIOD
    s = (t - STANCE) / SWING
    step = np.polynomial.Polynomial([0, 0, 0, 0, 35, -84, 70, -20])
    d = [step.deriv(k)(s) / SWING ** k if k else step(s) for k in range(3)]
    x = [-STANCE * SPEED / 2 - SPEED * (t - STANCE) + SPEED * PERIOD * d[0], -SPEED + SPEED * PERIOD * d[1], SPEED * PERIOD * d[2]]
    a, w = np.pi * s, np.pi / SWING
    z = [-HEIGHT + LIFT * np.sin(a) ** 4, LIFT * w * 4 * np.sin(a) ** 3 * np.cos(a),
         LIFT * w * w * (12 * np.sin(a) ** 2 * np.cos(a) ** 2 - 4 * np.sin(a) ** 4)]
    return np.array([x, z]), 0.0


def leg(t):
    """Rows hip, knee: position, velocity, acceleration, torque."""
    (p, v, a), force = foot(t)[0].T, foot(t)[1]
    r2 = p @ p
    knee = -np.arccos((r2 - L1 ** 2 - L2 ** 2) / (2 * L1 * L2))
    hip = np.arctan2(p[0], -p[1]) - np.arctan2(L2 * np.sin(knee), L1 + L2 * np.cos(knee))
    b = hip + knee
    jac = np.array([[L1 * np.cos(hip) + L2 * np.cos(b), L2 * np.cos(b)], [L1 * np.sin(hip) + L2 * np.sin(b), L2 * np.sin(b)]])
    qd = np.linalg.solve(jac, v)
    bd = qd[0] + qd[1]
    drift = np.array([-L1 * np.sin(hip) * qd[0] ** 2 - L2 * np.sin(b) * bd ** 2, L1 * np.cos(hip) * qd[0] ** 2 + L2 * np.cos(b) * bd ** 2])
    qdd = np.linalg.solve(jac, a - drift)
    # both links with absolute angles, then the knee's torque acts between them
    coupling = M2 * L1 * C2
    c, s, bdd = np.cos(knee), np.sin(knee), qdd[0] + qdd[1]
    shank = (I2 + M2 * C2 ** 2) * bdd + coupling * (c * qdd[0] + s * qd[0] ** 2) + M2 * G * C2 * np.sin(b)
    thigh = (I1 + M1 * C1 ** 2 + M2 * L1 ** 2) * qdd[0] + coupling * (c * bdd - s * bd ** 2) + (M1 * C1 + M2 * L1) * G * np.sin(hip)
    torque = np.array([thigh + shank, shank]) - jac.T @ np.array([0, force])
    return np.column_stack([[hip, knee], qd, qdd, torque]), force


def write(name, what, rows):
    rows[-1, 1:] = rows[0, 1:]
    with open(f"../motions/quadruped_trot_{name}.csv", "w") as out:
        out.write("# Mini-Cheetah-class quadruped: Katz, Di Carlo, Kim, ICRA 2019; links from MiniCheetah.h, mit-biomimetics/Cheetah-Software\n")
        out.write(f"# {what}\n# Trot at 1 m/s, period 0.5 s, duty 0.5; model and assumptions in make/quadruped.py.\n")
        out.write("time [s], torque [N*m], velocity [rad/s], position [rad], acceleration [rad/s^2]\n")
        for row in rows:
            out.write(", ".join(f"{x:.7g}" if abs(x) > 1e-9 else "0" for x in row) + "\n")


if __name__ == "__main__":
    times = np.linspace(0, PERIOD, SAMPLES + 1)
    legs = [leg((t + SHIFT) % PERIOD) for t in times]
    for i, name in enumerate(["hip", "knee"]):
        q = np.array([state[i] for state, _ in legs])
        write(name, f"{name} of one leg: ground force in stance, inertia and gravity of thigh and shank throughout.",
              np.column_stack([times, q[:, 3], q[:, 1], q[:, 0], q[:, 2]]))
