"""Roll of a humanoid's ankle at the times of ../motions/ankle_walking_75kg.csv -> ../motions/humanoid_ankle_roll.csv.   No packages.

ASSUMED throughout: no measured roll was read. The foot stays flat while the body sways sideways by 3 degrees once a stride; the torque is that of a foot 5 cm
to the side of the body's middle, on the ground for 60 % of the stride, for the body mass of 75 kg that the pitch motion has.
"""
import math
import pathlib

HERE = pathlib.Path(__file__).parent
STRIDE, SWAY, MOST = 1.14, math.radians(3.0), 0.018 * 75 * 9.81  # s, rad, N*m

lines = (HERE / "../motions/ankle_walking_75kg.csv").read_text().splitlines()
times = [float(line.split(",")[0]) for line in lines if line[0].isdigit()]
w = 2 * math.pi / STRIDE
out = [
    "# Roll of a humanoid's ankle in level walking, ASSUMED: see make/ankle.py.",
    "# At the times of ankle_walking_75kg.csv, for the same body mass of 75 kg.",
    "time [s], torque [N*m], velocity [rad/s], position [rad], acceleration [rad/s^2]",
]
for t in times:
    share = t / STRIDE
    torque = MOST * math.sin(math.pi * share / 0.6) ** 2 if share < 0.6 else 0.0
    q, v, a = SWAY * math.sin(w * t), SWAY * w * math.cos(w * t), -SWAY * w * w * math.sin(w * t)
    out.append(f"{t:.7g}, {torque:.7g}, {v:.7g}, {q:.7g}, {a:.7g}")
(HERE / "../motions/humanoid_ankle_roll.csv").write_text("\n".join(out) + "\n")
