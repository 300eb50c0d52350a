"""Linkages in MuJoCo itself, with the loop closed by constraints: do ratios, torques and speeds agree?

Run by .ci/external with the `gearwise` program as the only argument. A crank, a rod and a driven link are bodies of their own in MuJoCo; `connect`
closes the loop. The loop is assembled by Newton steps on MuJoCo's constraints, and the ratio of crank and joint is what the constraints' Jacobian leaves
free. `gearwise optimize --json` says the smallest and largest ratio over the motion and the largest torque and speed of each actuator.
"""

import json
import math
import pathlib
import subprocess
import sys
import tempfile

import mujoco
import numpy as np

PROGRAM = str(pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "target/debug/gearwise").resolve())
SAMPLES, PERIOD = 400, 1.0

FOUR_BAR = """<mujoco><option gravity="0 0 0"/><worldbody>
  <body><joint name="q" type="hinge" axis="0 0 1"/><geom size="0.01" mass="1"/><site name="pin" pos="{px} {py} 0"/></body>
  <body pos="{gx} {gy} 0"><joint name="theta" type="hinge" axis="0 0 1"/><geom size="0.01" mass="1"/>
    <body pos="{crank} 0 0"><joint name="rod" type="hinge" axis="0 0 1"/><geom size="0.01" mass="1"/><site name="end" pos="{coupler} 0 0"/></body></body>
</worldbody><equality><connect site1="end" site2="pin"/></equality></mujoco>"""

SLIDER = """<mujoco><option gravity="0 0 0"/><worldbody>
  <body><joint name="q" type="hinge" axis="0 0 1"/><geom size="0.01" mass="1"/><site name="pin" pos="{px} {py} 0"/></body>
  <body pos="{gx} {gy} 0"><joint name="swing" type="hinge" axis="0 0 1"/><geom size="0.01" mass="1"/>
    <body><joint name="slide" type="slide" axis="1 0 0"/><geom size="0.01" mass="1"/><site name="end"/></body></body>
</worldbody><equality><connect site1="end" site2="pin"/></equality></mujoco>"""

CRANK = """<body pos="0 {side} {height}"><joint name="theta{n}" type="hinge" axis="0 1 0"/><geom size="0.01" mass="1"/>
    <body pos="-0.045 {dy} 0"><joint name="ball{n}" type="ball"/><geom size="0.01" mass="1"/><site name="end{n}" pos="{ex} {ey} {ez}"/></body></body>"""
ANKLE = """<mujoco><option gravity="0 0 0"/><worldbody>
  <body><joint name="pitch" type="hinge" axis="0 1 0"/><joint name="roll" type="hinge" axis="1 0 0"/><geom size="0.01" mass="1"/>{sites}</body>{cranks}
</worldbody><equality><connect site1="end0" site2="pin0"/><connect site1="end1" site2="pin1"/></equality></mujoco>"""


class Loop:
    """A model whose loop is closed for given angles of its joints."""

    def __init__(self, xml, joints, driven):
        self.model = mujoco.MjModel.from_xml_string(xml)
        self.data = mujoco.MjData(self.model)
        dof = lambda name: self.model.jnt_dofadr[self.model.joint(name).id]
        self.joints, self.driven = [dof(n) for n in joints], [dof(n) for n in driven]
        self.places = [self.model.jnt_qposadr[self.model.joint(n).id] for n in joints]
        self.rest = [k for k in range(self.model.nv) if k not in self.joints]

    def rows(self):
        mujoco.mj_forward(self.model, self.data)
        d = self.data
        jacobian = d.efc_J.reshape(-1, self.model.nv) if not mujoco.mj_isSparse(self.model) else None
        if jacobian is None:
            jacobian = np.zeros((d.nefc, self.model.nv))
            mujoco.mju_sparse2dense(jacobian, d.efc_J, d.efc_J_rownnz, d.efc_J_rowadr, d.efc_J_colind)
        return d.efc_pos.copy(), jacobian

    def closed(self, angles, start=None):
        if start is not None:
            self.data.qpos[:] = start
        for place, angle in zip(self.places, angles):
            self.data.qpos[place] = angle
        for _ in range(60):
            off, jacobian = self.rows()
            if np.abs(off).max() < 1e-13:
                break
            step = np.zeros(self.model.nv)
            step[self.rest] = -np.linalg.lstsq(jacobian[:, self.rest], off, rcond=None)[0]
            mujoco.mj_integratePos(self.model, self.data.qpos, step, 1.0)
        off, jacobian = self.rows()
        assert np.abs(off).max() < 1e-10, f"the loop does not close: {off}"
        free = -np.linalg.lstsq(jacobian[:, self.rest], jacobian[:, self.joints], rcond=None)[0]
        full = np.zeros((self.model.nv, len(self.joints)))
        full[self.rest] = free
        return full[self.driven]


def gearwise(robot, files):
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        (folder / "robot.toml").write_text(robot)
        for name, text in files.items():
            (folder / name).write_text(text)
        ran = subprocess.run([PROGRAM, "optimize", "robot.toml", "--json"], cwd=folder, capture_output=True, text=True)
        assert ran.stdout, ran.stderr
        return json.loads(ran.stdout)["joints"][0]["transmission"]


def course(amplitude, middle, torque, phase):
    t = np.arange(SAMPLES + 1) * PERIOD / SAMPLES
    w = 2 * math.pi / PERIOD
    return t, middle + amplitude * np.sin(w * t + phase), amplitude * w * np.cos(w * t + phase), torque * (1.2 + np.cos(w * t))


def motion(of):
    rows = zip(*of)
    return "time [s], position [rad], velocity [rad/s], torque [N*m]\n" + "".join(",".join(repr(float(x)) for x in row) + "\n" for row in rows)


def near(what, found, wanted, within=2e-4):
    assert abs(found - wanted) <= within * abs(wanted), f"{what}: gearwise says {found}, MuJoCo {wanted}"
    print(f"  {what}: {found:.8g} and {wanted:.8g}")


JOINT = """[[joint]]
name = "{name}"
ratio = {{ min = 3, max = 30 }}
gear = {{ efficiency = 0.9, mass = "100 g" }}
motion = "{name}.csv"
objective = "copper_loss"
"""
HEAD = 'name = "x"\n[bus]\nvoltage = "48 V"\n'


def single(name, xml, driven, transmission, scale, start):
    of = course(0.5, 0.1, 20.0, 0.3)
    said = gearwise(HEAD + JOINT.format(name="knee") + f"[joint.transmission]\n{transmission}\n", {"knee.csv": motion(of)})
    loop = Loop(xml, ["q"], [driven])
    loop.data.qpos[:] = start
    ratios, before = [], None
    for q in of[1]:
        ratios.append(float(scale * loop.closed([q], before)[0, 0]))
        before = loop.data.qpos.copy()
    ratios = np.array(ratios)
    print(name)
    near("least ratio", said["least_ratio"], np.abs(ratios).min())
    near("largest ratio", said["largest_ratio"], np.abs(ratios).max())
    near("torque", said["actuators"][0]["peak_torque_nm"], np.abs(of[3] / ratios).max())
    near("speed", said["actuators"][0]["peak_speed_rad_s"], np.abs(of[2] * ratios).max())


def ankle():
    pins = [(-0.05, 0.035, 0.01), (-0.05, -0.035, 0.01)]
    cranks = [(0.03, 0.25, 0.002), (-0.03, 0.18, -0.002)]
    sites = "".join(f'<site name="pin{n}" pos="{x} {y} {z}"/>' for n, (x, y, z) in enumerate(pins))
    bodies = "".join(
        CRANK.format(n=n, side=side, height=height, dy=dy, ex=pins[n][0] + 0.045, ey=pins[n][1] - side - dy, ez=pins[n][2] - height)
        for n, (side, height, dy) in enumerate(cranks)
    )
    loop = Loop(ANKLE.format(sites=sites, cranks=bodies), ["pitch", "roll"], ["theta0", "theta1"])
    pitch, roll = course(0.3, 0.0, 30.0, 0.0), course(0.12, 0.0, 9.0, 1.1)
    point = lambda *xyz: "[" + ", ".join(f'"{1000 * v!r} mm"' for v in xyz) + "]"
    rods = ",\n".join(
        f"{{ axis_at = {point(0.0, side, height)}, axis = [0, 1, 0], crank_pin = {point(-0.045, side + dy, height)}, link_pin = {point(*pins[n])} }}"
        for n, (side, height, dy) in enumerate(cranks)
    )
    coupling = f'[[coupling]]\nname = "ankle"\njoints = ["pitch", "roll"]\nrods = [\n{rods}\n]\n'
    said = gearwise(
        HEAD + JOINT.format(name="pitch") + JOINT.format(name="roll") + coupling, {"pitch.csv": motion(pitch), "roll.csv": motion(roll)}
    )
    torques, speeds, before = [], [], None
    for k in range(SAMPLES + 1):
        jacobian = loop.closed([pitch[1][k], roll[1][k]], before)
        before = loop.data.qpos.copy()
        torques.append(np.linalg.solve(jacobian.T, [pitch[3][k], roll[3][k]]))
        speeds.append(jacobian @ [pitch[2][k], roll[2][k]])
    torques, speeds = np.abs(torques).max(axis=0), np.abs(speeds).max(axis=0)
    print("ankle with two rods")
    for n in range(2):
        near(f"torque of actuator {n + 1}", said["actuators"][n]["peak_torque_nm"], torques[n])
        near(f"speed of actuator {n + 1}", said["actuators"][n]["peak_speed_rad_s"], speeds[n])


zero = math.radians(10)
place = dict(gx=0.02, gy=0.21, px=0.05 * math.cos(zero), py=0.05 * math.sin(zero))
single(
    "four-bar linkage",
    FOUR_BAR.format(crank=0.04, coupler=0.215, **place),
    "theta",
    'four_bar = { ground = ["20 mm", "210 mm"], crank = "40 mm", coupler = "215 mm", rocker = "50 mm", rocker_zero = "10 deg" }',
    1.0,
    [0.1, 0.0, -1.5],
)
single(
    "lever with a screw",
    SLIDER.format(**place),
    "slide",
    'lever = { pivot = ["20 mm", "210 mm"], arm = "50 mm", arm_zero = "10 deg", lead = "5 mm" }',
    2 * math.pi / 0.005,
    [0.1, -1.5, 0.2],
)
ankle()
