"""Pick and place with a UR5e-class six-axis arm -> ../motions/arm_*.csv.   Needs numpy.

Published: Denavit-Hartenberg parameters, link masses and centres of mass of the UR5e, Universal Robots, "DH Parameters for
calculations of kinematics and dynamics"; the article calls the links' own inertia tensors negligible for this size, so links are
points at their centres of mass here.
Assumed: payload a 3 kg cube of 0.1 m edge, its centre 0.08 m before the flange and 0.03 m beside the axis; a cycle of 4 s between
four poses (lift 0.17 m, turn 72 degrees, put down in a chute tilted by 30 degrees, and back empty). Every move is rest to rest with the
polynomial of degree 7 (velocity, acceleration and jerk zero at both ends); while the arm dwells at the pick and at the place the weight
of the payload passes to and from the gripper by the same polynomial, so torque and its rate are continuous.
Torque = recursive Newton-Euler with gravity, no friction, no rotor inertia. Torque x velocity > 0: the actuator delivers power.
"""
import numpy as np

PI2 = np.pi / 2
D = [0.1625, 0, 0, 0.1333, 0.0997, 0.0996]
A = [0, -0.425, -0.3922, 0, 0, 0]
ALPHA = [PI2, 0, 0, PI2, -PI2, 0]
MASS = [3.761, 8.058, 2.846, 1.37, 1.3, 0.365]
CENTRE = np.array([[0, -0.02561, 0.00193], [0.2125, 0, 0.11336], [0.15, 0, 0.0265],
                   [0, -0.0018, 0.01634], [0, 0.0018, 0.01634], [0, 0, -0.001159]])
PAYLOAD, PAYLOAD_CENTRE, PAYLOAD_EDGE = 3.0, np.array([0.03, 0, 0.08]), 0.1
GRAVITY = np.array([0, 0, -9.81])

PICK = [64.3, -46.0, 100.3, -144.3, -90.0, 154.3]  # degrees
ABOVE_PICK = [64.3, -62.2, 96.0, -123.9, -90.0, 154.3]
ABOVE_PLACE = [-7.8, -68.1, 95.1, -121.5, -119.7, 81.0]
PLACE = [-7.8, -55.8, 102.5, -141.2, -119.7, 81.0]
# duration [s], pose at the end, share of the payload carried at the end
MOVES = [(0.2, PICK, 1), (0.4, ABOVE_PICK, 1), (1.1, ABOVE_PLACE, 1), (0.4, PLACE, 1),
         (0.2, PLACE, 0), (0.4, ABOVE_PLACE, 0), (0.9, ABOVE_PICK, 0), (0.4, PICK, 0)]
CYCLE = sum(move[0] for move in MOVES)
SAMPLES = 320
STEP = np.polynomial.Polynomial([0, 0, 0, 0, 35, -84, 70, -20])
NAMES = ["base", "shoulder", "elbow", "wrist_1", "wrist_2", "wrist_3"]


def motion(t):
    """Joint positions, velocities, accelerations and carried payload at time t."""
    pose, carried = PICK, 0
    for duration, end, share in MOVES:
        if t < duration - 1e-9 or (duration, end, share) == MOVES[-1]:
            s = np.clip(t / duration, 0, 1)
            step = np.radians(np.subtract(end, pose))
            position = np.radians(pose) + step * STEP(s)
            velocity, acceleration = step * STEP.deriv(1)(s) / duration, step * STEP.deriv(2)(s) / duration ** 2
            return position, velocity, acceleration, carried + (share - carried) * STEP(s)
        t, pose, carried = t - duration, end, share


def inverse_dynamics(q, qd, qdd, carried):
    rotation, position = np.eye(3), np.zeros(3)
    omega, alpha, acceleration = np.zeros(3), np.zeros(3), -GRAVITY
    axes, origins, wrenches = [], [], []
    for i in range(6):
        axis = rotation[:, 2]
        axes.append(axis), origins.append(position)
        alpha = alpha + axis * qdd[i] + np.cross(omega, axis) * qd[i]
        omega = omega + axis * qd[i]
        c, s, ca, sa = np.cos(q[i]), np.sin(q[i]), np.cos(ALPHA[i]), np.sin(ALPHA[i])
        offset = rotation @ [A[i] * c, A[i] * s, D[i]]
        rotation = rotation @ np.array([[c, -s * ca, s * sa], [s, c * ca, -c * sa], [0, sa, ca]])

        def at(r):
            return acceleration + np.cross(alpha, r) + np.cross(omega, np.cross(omega, r))

        bodies = [(MASS[i], CENTRE[i], 0.0)]
        if i == 5:
            bodies.append((PAYLOAD * carried, PAYLOAD_CENTRE, PAYLOAD * carried * PAYLOAD_EDGE ** 2 / 6))
        for mass, centre, inertia in bodies:
            r = offset + rotation @ centre
            wrenches.append((i, position + r, mass * at(r), inertia * alpha))
        acceleration = at(offset)
        position = position + offset
    return [sum(axes[j] @ (np.cross(point - origins[j], force) + moment) for i, point, force, moment in wrenches if i >= j)
            for j in range(6)]


if __name__ == "__main__":
    times = np.linspace(0, CYCLE, SAMPLES + 1)
    states = [motion(t) for t in times]
    torques = np.array([inverse_dynamics(*state) for state in states])
    for j, name in enumerate(NAMES):
        rows = np.array([[t, torque[j], qd[j], q[j], qdd[j]] for t, torque, (q, qd, qdd, _) in zip(times, torques, states)])
        rows[-1, 1:] = rows[0, 1:]
        with open(f"../motions/arm_{name}.csv", "w") as out:
            out.write("# UR5e kinematics, masses, centres of mass: Universal Robots, DH Parameters for calculations of kinematics and dynamics\n")
            out.write(f"# {name} (joint {j + 1}): pick and place of 3 kg in 4 s; rigid-body inverse dynamics without rotors, see make/arm.py.\n")
            out.write("time [s], torque [N*m], velocity [rad/s], position [rad], acceleration [rad/s^2]\n")
            for row in rows:
                out.write(", ".join(f"{x:.7g}" if abs(x) > 1e-9 else "0" for x in row) + "\n")
