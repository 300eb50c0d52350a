"""The Newton layer read by Newton itself: what arrives in its model, and its clip against the line.

By hand, with `.ci/simulators`: Newton, Warp and OpenUSD are 190 MB to load and 800 MB on disk. The `gearwise` program is the only
argument.
"""

import json
import math
import pathlib
import subprocess
import sys
import tempfile

import newton
import numpy
import warp as wp
from newton import actuators
from pxr import Sdf, Usd

PROGRAM = sys.argv[1] if len(sys.argv) > 1 else "target/debug/gearwise"
MOTORS = """id,terminals,current,resistance [ohm],torque_constant [N*m/A],rotor_inertia [kg*m^2],mass [kg],peak_current [A],\
max_speed [rad/s],coulomb_friction [N*m],viscous_friction [N*m*s/rad],source,source_kind
m,q_axis,q_axis,0.5,0.1,2e-5,0.3,20,300,0.01,1e-4,worked example,derived
"""
ROBOT = """name = "leg"
bus = { voltage = "48 V" }
[[joint]]
name = "knee"
ratio = { min = 3, max = 30 }
motor_drag = "off"
gear = { inertia = "1e-5 kg*m^2" }
points = [ { torque = "0.2 N*m", speed = "3 rad/s", duration = "1 s" } ]
"""
STAGE = """#usda 1.0
(
    defaultPrim = "Robot"
    metersPerUnit = 1
    upAxis = "Z"
)
def Xform "Robot" (
    prepend apiSchemas = ["PhysicsArticulationRootAPI"]
)
{
    def Xform "base" (
        prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"]
    )
    {
        float physics:mass = 1
        bool physics:kinematicEnabled = true
    }
    def Xform "link" (
        prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"]
    )
    {
        float physics:mass = 1
        float3 physics:diagonalInertia = (0.01, 0.01, 0.01)
    }
    def Scope "joints"
    {
        def PhysicsFixedJoint "root"
        {
            rel physics:body1 = </Robot/base>
        }
        def PhysicsRevoluteJoint "knee"
        {
            uniform token physics:axis = "Y"
            rel physics:body0 = </Robot/base>
            rel physics:body1 = </Robot/link>
        }
    }
}
"""


def gearwise(*arguments):
    done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode in (0, 1), done.stderr
    return done.stdout


def close(actual, expected, what, tolerance=1e-6):
    error = abs(actual - expected) / max(abs(expected), 1e-12)
    assert error <= tolerance, f"{what}: {actual!r}, {expected!r} expected, off by {error:.1e}"


def main():
    folder = pathlib.Path(tempfile.mkdtemp())
    (folder / "motors.csv").write_text(MOTORS)
    (folder / "robot.toml").write_text(ROBOT)
    design = ["export", "m@9", folder / "robot.toml", "--catalog", folder / "motors.csv"]
    facts = json.loads(gearwise(*design, "--to", "json"))["joints"][0]
    gearwise(*design, "--to", "newton", "--out", folder / "layer.usda")
    (folder / "stage.usda").write_text(STAGE)
    root = Sdf.Layer.CreateNew(str(folder / "root.usda"))
    root.subLayerPaths = ["layer.usda", "stage.usda"]
    root.Save()
    builder = newton.ModelBuilder()
    builder.add_usd(str(folder / "root.usda"))
    model = builder.finalize(device="cpu")
    names = list(model.joint_label)
    knee = next(k for k, name in enumerate(names) if "knee" in name)
    dof = model.joint_qd_start.numpy()[knee]
    close(model.joint_armature.numpy()[dof], facts["armature_kgm2"], "armature")
    close(model.joint_friction.numpy()[dof], facts["friction_loss_nm"], "friction")
    close(model.joint_velocity_limit.numpy()[dof], facts["mechanical_velocity_rad_per_s"], "velocity limit")
    if getattr(model, "joint_damping", None) is not None:
        close(model.joint_damping.numpy()[dof], facts["damping_nms_per_rad"], "damping")
    stage = Usd.Stage.Open(str(folder / "root.usda"))
    parsed = actuators.parse_actuator_prim(stage.GetPrimAtPath("/Robot/joints/knee_actuator"))
    (clamp, values), = [spec for spec in parsed.component_specs if "DCMotor" in spec[0].__name__]
    line = facts["line"]
    close(values["max_motor_effort"], line["effort_nm"], "e")
    close(values["saturation_effort"], line["stall_nm"], "s")
    close(values["velocity_limit"], line["no_load_rad_per_s"], "no load")
    e, s, w0 = line["effort_nm"], line["stall_nm"], line["no_load_rad_per_s"]
    speeds = numpy.linspace(-1.4 * w0, 1.4 * w0, 57)
    worst = 0.0
    for command in (-2 * e, 0.4 * e, 2 * e):
        n = len(speeds)
        array = lambda value: wp.array(numpy.full(n, value), dtype=wp.float32, device="cpu")  # noqa: E731
        made = clamp(saturation_effort=array(s), velocity_limit=array(w0), max_motor_effort=array(e))
        source, out = array(command), array(0.0)
        at = wp.array(numpy.arange(n), dtype=wp.uint32, device="cpu")
        velocities = wp.array(speeds, dtype=wp.float32, device="cpu")
        made.modify_forces(source, out, array(0.0), velocities, at, at, device="cpu")
        for speed, found in zip(speeds, out.numpy()):
            high, low = min(e, s * (1 - speed / w0)), max(-e, s * (-1 - speed / w0))
            expected = max(min(command, max(high, -e)), min(low, e))
            worst = max(worst, abs(found - expected) / e)
    assert worst < 1e-6, worst
    print(f"Newton {newton.__version__}: joint and actuator arrive; its clip is the line within {worst:.1e} of e")


main()
