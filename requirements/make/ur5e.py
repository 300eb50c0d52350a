"""The cycle of arm.py as a trajectory of all joints of ../robots/ur5e.urdf -> ../robots/ur5e_pick.csv.   Needs numpy."""
import numpy as np

from arm import CYCLE, SAMPLES, motion

JOINTS = ["shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3"]

with open("../robots/ur5e_pick.csv", "w") as out:
    out.write("# Pick and place in 4 s between four poses, rest to rest with polynomials of degree 7: make/arm.py, which lists poses and times.\n")
    columns = [f"{j} [rad]" for j in JOINTS] + [f"{j}.velocity [rad/s]" for j in JOINTS] + [f"{j}.acceleration [rad/s^2]" for j in JOINTS]
    out.write(", ".join(["time [s]"] + columns) + "\n")
    times = np.linspace(0, CYCLE, SAMPLES + 1)
    rows = [np.concatenate(motion(t)[:3]) for t in times]
    rows[-1] = rows[0]
    for t, row in zip(times, rows):
        out.write(", ".join(f"{x:.9g}" if abs(x) > 1e-9 else "0" for x in [t, *row]) + "\n")
