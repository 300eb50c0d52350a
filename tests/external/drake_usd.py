"""URDF and SDFormat in Drake itself, and the USD layers in OpenUSD with Newton's own schemas.

Run by .ci/external with the `gearwise` program as the only argument. Drake and MuJoCo have to accelerate alike; the layers have
to compose with a stage, with attributes that the schemas define and the values that gearwise says, degrees where they want them.
"""

import json
import math
import pathlib
import subprocess
import sys
import tempfile
import warnings

import mujoco
import newton_usd_schemas  # noqa: F401  registers the schemas
from pxr import Sdf, Usd
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

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
gear = { efficiency = 0.9, inertia = "1e-5 kg*m^2" }
points = [ { torque = "0.2 N*m", speed = "3 rad/s", duration = "1 s" } ]
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
SDF = """<?xml version="1.0"?>
<sdf version="1.9">
  <model name="leg">
    <link name="base"/>
    <link name="link"><inertial><pose>0 0 -0.2 0 0 0</pose><mass>1.5</mass>
      <inertia><ixx>0.004</ixx><iyy>0.004</iyy><izz>0.004</izz></inertia></inertial></link>
    <joint name="knee" type="revolute">
      <parent>base</parent><child>link</child>
      <axis><xyz>0 1 0</xyz><limit><lower>-1.5</lower><upper>1.5</upper><effort>1</effort></limit></axis>
    </joint>
  </model>
</sdf>
"""
MJCF = """<mujoco><option gravity="0 0 -9.81"/><worldbody><body name="link"><joint name="knee" type="hinge" axis="0 1 0"/>
  <inertial pos="0 0 -0.2" mass="1.5" diaginertia="0.004 0.004 0.004"/></body></worldbody></mujoco>
"""
STAGE = """#usda 1.0
def Xform "Robot"
{
    def Scope "joints"
    {
        def PhysicsRevoluteJoint "knee"
        {
        }
    }
}
"""


def gearwise(*arguments, status=(0, 1)):
    done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode in status, f"{arguments}: {done.returncode}: {done.stderr}"
    return done.stdout


def close(actual, expected, what, tolerance=1e-9):
    error = abs(actual - expected) / max(abs(expected), 1e-12)
    assert error <= tolerance, f"{what}: {actual!r}, {expected!r} expected, off by {error:.1e}"
    return error


def drake(path):
    """A plant of one joint, pinned to the world."""
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, 0.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Parser(plant).AddModels(str(path))
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("base"))
    plant.Finalize()
    return plant, builder.Build()


def accelerates(plant, diagram, angle, speed, torque):
    context = diagram.CreateDefaultContext()
    mine = plant.GetMyMutableContextFromRoot(context)
    joint = plant.GetJointByName("knee")
    joint.set_angle(mine, angle)
    joint.set_angular_rate(mine, speed)
    plant.get_actuation_input_port().FixValue(mine, [torque])
    return plant.get_generalized_acceleration_output_port(plant.GetModelInstanceByName("leg")).Eval(mine)[0]


def in_drake(folder, design, facts):
    texts = {"urdf": URDF, "sdf": SDF, "xml": MJCF}
    for kind, text in texts.items():
        (folder / f"bare.{kind}").write_text(text)
        options = ["--drake"] if kind == "urdf" else []
        gearwise(*design, "--into", folder / f"bare.{kind}", *options, "--out", folder / f"leg.{kind}")
    model = mujoco.MjModel.from_xml_path(str(folder / "leg.xml"))
    worst = 0.0
    for kind in ("urdf", "sdf"):
        plant, diagram = drake(folder / f"leg.{kind}")
        actuator = plant.get_joint_actuator(plant.GetJointActuatorIndices()[0])
        close(actuator.effort_limit(), facts["effort_nm"], f"{kind} effort")
        close(actuator.default_reflected_inertia(), facts["armature_kgm2"], f"{kind} armature")
        close(plant.GetVelocityUpperLimits()[0], facts["velocity_rad_per_s"], f"{kind} velocity")
        joint = plant.GetJointByName("knee")
        close(joint.default_damping(), facts["damping_nms_per_rad"], f"{kind} damping")
        close(joint.position_upper_limits()[0], 1.5, f"{kind}: the model's own range stays")
        for angle, speed, torque in ((0.0, 0.0, 3.0), (0.4, 5.0, -2.0), (-1.1, -7.0, 6.0)):
            data = mujoco.MjData(model)
            data.qpos[0], data.qvel[0], data.ctrl[0] = angle, speed, torque / facts["ratio"]
            # Drake has no Coulomb friction in a continuous plant: it is left out of MuJoCo here.
            model.dof_frictionloss[0] = 0
            mujoco.mj_forward(model, data)
            found = accelerates(plant, diagram, angle, speed, torque)
            worst = max(worst, close(found, data.qacc[0], f"{kind} at {angle}, {speed}, {torque}"))
    # Written twice, the second time changes nothing.
    for kind in texts:
        again = folder / f"again.{kind}"
        gearwise(*design, "--into", folder / f"leg.{kind}", *(["--drake"] if kind == "urdf" else []), "--out", again)
        assert again.read_text() == (folder / f"leg.{kind}").read_text(), f"{kind}: the second time changes something"
    return worst


def in_usd(folder, design, facts):
    checked = 0
    line = facts["line"]
    newton = {
        "/Robot/joints/knee": {
            "newton:armature": facts["armature_kgm2"],
            "newton:damping": facts["damping_nms_per_rad"] * math.pi / 180,
            "newton:friction": facts["friction_loss_nm"],
            "newton:velocityLimit": math.degrees(facts["mechanical_velocity_rad_per_s"]),
        },
        "/Robot/joints/knee_actuator": {
            "newton:maxMotorEffort": line["effort_nm"],
            "newton:saturationEffort": line["stall_nm"],
            "newton:velocityLimit": line["no_load_rad_per_s"],
        },
    }
    axis, envelope = "physxJointAxis:angular:", "physxDrivePerformanceEnvelope:angular:"
    physx = {
        "/Robot/joints/knee": {
            "drive:angular:physics:maxForce": line["effort_nm"],
            envelope + "maxActuatorVelocity": math.degrees(line["no_load_rad_per_s"]),
            envelope + "speedEffortGradient": math.degrees(line["no_load_rad_per_s"] / line["stall_nm"]),
            axis + "armature": facts["armature_kgm2"],
            axis + "viscousFrictionCoefficient": facts["damping_nms_per_rad"] * math.pi / 180,
            axis + "dynamicFrictionEffort": facts["friction_loss_nm"],
            axis + "staticFrictionEffort": facts["friction_loss_nm"],
            axis + "maxJointVelocity": math.degrees(facts["mechanical_velocity_rad_per_s"]),
        },
    }
    for name, expected in (("newton", newton), ("physx", physx)):
        layer = folder / f"{name}.usda"
        gearwise(*design, "--to", name, "--out", layer)
        (folder / "stage.usda").write_text(STAGE)
        # The layer over the asset, as its sublayer.
        root = Sdf.Layer.CreateAnonymous(".usda")
        root.subLayerPaths = [str(layer), str(folder / "stage.usda")]
        stage = Usd.Stage.Open(root)
        assert stage.GetPrimAtPath("/Robot/joints/knee").GetTypeName() == "PhysicsRevoluteJoint", "the stage's joint stays"
        for path, attributes in expected.items():
            prim = stage.GetPrimAtPath(path)
            defined = set()
            for schema in prim.GetMetadata("apiSchemas").GetAppliedItems():
                definition = Usd.SchemaRegistry().FindAppliedAPIPrimDefinition(schema)
                if name == "newton":
                    assert definition, f"{schema} is no schema"
                    defined |= set(definition.GetPropertyNames())
            authored = {a.GetName(): a.Get() for a in prim.GetAuthoredAttributes()}
            assert set(authored) == set(attributes), f"{path}: {set(authored) ^ set(attributes)}"
            for key, value in attributes.items():
                assert name != "newton" or key in defined, f"{path}: {key} is no attribute of its schemas"
                close(authored[key], value, f"{path} {key}", 1e-6)
                checked += 1
        if name == "newton":
            actuator = stage.GetPrimAtPath("/Robot/joints/knee_actuator")
            assert actuator.GetTypeName() == "NewtonActuator"
            targets = actuator.GetRelationship("newton:targets").GetTargets()
            assert [str(t) for t in targets] == ["/Robot/joints/knee"], targets
    return checked


def main():
    folder = pathlib.Path(tempfile.mkdtemp())
    (folder / "motors.csv").write_text(MOTORS)
    (folder / "robot.toml").write_text(ROBOT)
    design = ["export", "m@9", folder / "robot.toml", "--catalog", folder / "motors.csv"]
    facts = json.loads(gearwise(*design, "--to", "json"))["joints"][0]
    worst = in_drake(folder, design, facts)
    checked = in_usd(folder, design, facts)
    print(f"Drake accelerates as MuJoCo does within {worst:.1e}, from URDF and SDFormat; {checked} attributes of USD layers compose")


main()
