"""Exported joints in MuJoCo itself: does a joint accelerate as the model says?

Run by .ci/external with the `gearwise` program as the only argument. For an operating point (load torque, speed,
acceleration) `gearwise explain` says which current it takes; that current's torque is given to the exported motor in
MuJoCo, which must find the same acceleration to 1e-6. Both sides know nothing of each other but the exported file.
"""

import itertools
import json
import math
import pathlib
import subprocess
import sys
import tempfile

import mujoco
import numpy

PROGRAM = sys.argv[1] if len(sys.argv) > 1 else "target/debug/gearwise"
TOLERANCE = 1e-6
# A rigid link that swings about y: mass, distance of its centre, inertia about the centre.
MASS, LENGTH, INERTIA, GRAVITY = 1.5, 0.2, 0.004, 9.81
KT, RATIO = 0.1, 9.0

MOTORS = """id,terminals,current,resistance [ohm],inductance [mH],torque_constant [N*m/A],rotor_inertia [kg*m^2],\
mass [kg],pole_pairs,continuous_current [A],peak_current [A],coulomb_friction [N*m],viscous_friction [N*m*s/rad],\
source,source_kind
m,q_axis,q_axis,0.5,0,0.1,2e-5,0.3,7,50,60,0.01,1e-4,worked example,derived
"""
ROBOT = """name = "leg"
bus = {{ voltage = "480 V" }}
[[joint]]
name = "knee"
ratio = {{ min = 3, max = 30 }}
gear = {{ inertia = "1e-5 kg*m^2" }}
points = [ {{ torque = "{torque!r} N*m", speed = "{speed!r} rad/s", acceleration = "{acceleration!r} rad/s^2", duration = "1 s" }} ]
"""
SCENE = """<mujoco model="scene">
  {include}
  <option gravity="0 0 -9.81" tolerance="1e-14" iterations="500"/>
  <worldbody>
    <body name="link">
      <joint name="knee" {of_class} type="hinge" axis="0 1 0"/>
      <inertial pos="0 0 -0.2" mass="1.5" diaginertia="0.004 0.004 0.004"/>
    </body>
  </worldbody>
</mujoco>
"""
URDF = """<robot name="leg">
  <link name="base"/>
  <link name="link"><inertial><origin xyz="0 0 -0.2"/><mass value="1.5"/>
    <inertia ixx="0.004" iyy="0.004" izz="0.004" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="knee" type="revolute">
    <parent link="base"/><child link="link"/><axis xyz="0 1 0"/>
    <limit lower="-1.5" upper="1.5" effort="1" velocity="1"/>
  </joint>
</robot>
"""


def gearwise(*arguments, status=0):
    done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == status, f"{arguments}: {done.stderr}"
    return done.stdout


def close(actual, expected, what, tolerance=TOLERANCE):
    error = abs(actual - expected) / max(abs(expected), 1e-12)
    assert error <= tolerance, f"{what}: {actual!r} in MuJoCo, {expected!r} expected, off by {error:.1e}"
    return error


def acceleration(model, angle, speed, command):
    data = mujoco.MjData(model)
    data.qpos[0], data.qvel[0], data.ctrl[0] = angle, speed, command
    mujoco.mj_forward(model, data)
    return data.qacc[0]


def model_torque(folder, load, speed, accel):
    """Torque at the motor that gearwise says this operating point takes, without its sign."""
    robot = folder / "point.toml"
    robot.write_text(ROBOT.format(torque=load, speed=speed, acceleration=accel))
    story = json.loads(gearwise("explain", f"m@{RATIO}", robot, "--catalog", folder / "motors.csv", "--json"))
    return story["joints"][0]["design"]["peak_current_q_a"] * KT


def main():
    folder = pathlib.Path(tempfile.mkdtemp())
    motors, robot = folder / "motors.csv", folder / "robot.toml"
    motors.write_text(MOTORS)
    robot.write_text(ROBOT.format(torque=2.0, speed=3.0, acceleration=0.0))
    design = ["export", f"m@{RATIO}", robot, "--catalog", motors]
    gearwise(*design, "--to", "mjcf", "--out", folder / "knee.xml")
    facts = json.loads(gearwise(*design, "--to", "json"))["joints"][0]

    scene = folder / "scene.xml"
    scene.write_text(SCENE.format(include='<include file="knee.xml"/>', of_class='class="knee_actuator"'))
    included = mujoco.MjModel.from_xml_path(str(scene))
    bare = folder / "bare.xml"
    bare.write_text(SCENE.format(include="", of_class=""))
    gearwise(*design, "--into", bare, "--out", folder / "patched.xml")
    patched = mujoco.MjModel.from_xml_path(str(folder / "patched.xml"))

    worst, cases = 0.0, 0
    # MuJoCo's friction loss is a soft constraint that stops within solreffriction's 0.02 s: from 4 rad/s on it is
    # saturated at all these accelerations, as Coulomb friction of a joint that moves is.
    for speed, accel, angle in itertools.product([-20.0, -4.0, 4.0, 20.0], [-300.0, -10.0, 40.0, 250.0], [0.0, 0.7, -1.2]):
        # The link's own torque about the joint; its centre hangs below for angle zero.
        load = (INERTIA + MASS * LENGTH**2) * accel + MASS * GRAVITY * LENGTH * math.sin(angle)
        size = model_torque(folder, load, speed, accel)
        # The sign that explain leaves out follows from the sum of its terms.
        by_hand = load / RATIO + RATIO * (3e-5 * accel + 1e-4 * speed) + math.copysign(0.01, speed)
        close(size, abs(by_hand), "explain")
        for model in (included, patched):
            found = acceleration(model, angle, speed, math.copysign(size, by_hand))
            worst = max(worst, close(found, accel, f"speed {speed}, acceleration {accel}, angle {angle}"))
            cases += 1

    # Beyond the range the torque is the largest one, either way.
    data = mujoco.MjData(included)
    for command in (1e3, -1e3):
        data.ctrl[0] = command
        mujoco.mj_forward(included, data)
        close(data.qfrc_actuator[0], math.copysign(facts["effort_nm"], command), "effort")

    # URDF: limits and friction arrive, the armature cannot.
    urdf, with_limits = folder / "leg.urdf", folder / "with_limits.urdf"
    urdf.write_text(URDF)
    gearwise(*design, "--into", urdf, "--out", with_limits)
    model = mujoco.MjModel.from_xml_path(str(with_limits))
    close(model.jnt_actfrcrange[0][1], facts["effort_nm"], "URDF effort", 1e-9)
    close(model.dof_damping[0], facts["damping_nms_per_rad"], "URDF damping", 1e-9)
    close(model.dof_frictionloss[0], facts["friction_loss_nm"], "URDF friction", 1e-9)
    assert numpy.allclose(model.jnt_range[0], [-1.5, 1.5]), "the model's own range stays"
    assert model.dof_armature[0] == 0.0

    # A motor of the catalogue, whose sheet counts amperes in its own way: J_m of the RI50 is 90.1 g*cm^2.
    shipped = "requirements/quadruped_mini_cheetah.toml"
    # It breaks the voltage of the torque bandwidth there, which status 1 says; its numbers are what is looked at.
    knee = ("export", "t-motor-ri50@9", shipped, "--joint", "knee")
    gearwise(*knee, "--to", "mjcf", "--out", folder / "knee.xml", status=1)
    model = mujoco.MjModel.from_xml_path(str(scene))
    facts = json.loads(gearwise(*knee, "--to", "json", status=1))["joints"][0]
    armature = 81 * (90.1e-7 + 2e-6)  # with the gear that the requirement describes
    close(facts["armature_kgm2"], armature, "armature of the RI50", 1e-9)
    close(model.dof_armature[0], armature, "armature of the RI50 in MuJoCo", 1e-9)
    close(acceleration(model, 0.0, 0.0, 0.5), 9 * 0.5 / (armature + INERTIA + MASS * LENGTH**2), "RI50")
    print(f"mujoco {mujoco.__version__}: {cases} accelerations, at most {worst:.1e} off")


main()
