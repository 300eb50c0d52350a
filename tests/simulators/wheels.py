"""Keys and clips of isaaclab and mjlab, read from their own wheels: are the keys that gearwise writes there, and is their clip the line?

By hand, with `.ci/simulators`, which loads the wheels; nothing of them is installed or kept. Their functions run with NumPy in the
place of torch. Arguments: the `gearwise` program, and the folder with the wheels.
"""

import ast
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import types
import zipfile

import numpy

PROGRAM, WHEELS = sys.argv[1], pathlib.Path(sys.argv[2])
DESIGN = "requirements/designs/quadruped_mini_cheetah/design.toml"
TORCH = types.SimpleNamespace(
    Tensor=numpy.ndarray,
    clamp=lambda x, min=None, max=None: numpy.clip(x, min, max),  # noqa: A002
    clip=lambda x, min=None, max=None: numpy.clip(x, min, max),  # noqa: A002
)


def source(wheel, ending):
    (path,) = WHEELS.glob(wheel)
    with zipfile.ZipFile(path) as archive:
        (name,) = [n for n in archive.namelist() if n.endswith(ending)]
        return archive.read(name).decode()


def fields(text, names):
    """Annotated fields of classes of a module, by name."""
    classes = {node.name: node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.ClassDef)}
    return {f.target.id for name in names for f in classes[name].body if isinstance(f, ast.AnnAssign)}


def function(text, name, of=None):
    """A function of a module, or of a class in it, with NumPy as torch."""
    body = ast.parse(text).body
    if of:
        (body,) = [n.body for n in body if isinstance(n, ast.ClassDef) and n.name == of]
    (node,) = [n for n in body if isinstance(n, ast.FunctionDef) and n.name == name]
    for argument in node.args.args:
        argument.annotation = None
    node.returns = None
    inside = {"torch": TORCH}
    exec(compile(ast.Module([node], []), name, "exec"), inside)  # noqa: S102
    return inside[name]


def exported(to):
    text = subprocess.run([PROGRAM, "export", DESIGN, "--to", to, "--joint", "knee"], capture_output=True, text=True).stdout
    return set(re.findall(r"^        (\w+)=", text, re.M)), text


def main():
    lab_base = source("isaaclab-2*.whl", "isaaclab/actuators/actuator_base_cfg.py")
    lab_pd = source("isaaclab-2*.whl", "isaaclab/actuators/actuator_pd_cfg.py")
    keys, text = exported("isaaclab2")
    there = fields(lab_base, ["ActuatorBaseCfg"]) | fields(lab_pd, ["DCMotorCfg"])
    assert keys <= there, keys - there
    events = source("isaaclab-2*.whl", "isaaclab/envs/mdp/events.py")
    for key in ("armature_distribution_params", "friction_distribution_params"):
        assert f"{key}: tuple[float, float] | None" in events, key
    mjlab = source("mjlab-*.whl", "mjlab/actuator/dc_actuator.py")
    there = (fields(source("mjlab-*.whl", "mjlab/actuator/actuator.py"), ["ActuatorCfg"])
             | fields(source("mjlab-*.whl", "mjlab/actuator/pd_actuator.py"), ["IdealPdActuatorCfg"])
             | fields(mjlab, ["DcMotorActuatorCfg"]))
    keys, _ = exported("mjlab")
    assert keys <= there, keys - there
    dr = source("mjlab-*.whl", "mdp/dr/__init__.py")
    for name in ("joint_armature", "joint_damping", "joint_friction", "effort_limits"):
        assert name in dr, name
    text = subprocess.run([PROGRAM, "export", DESIGN, "--to", "json", "--joint", "knee"], capture_output=True, text=True).stdout
    line = json.loads(text)["joints"][0]["line"]
    e, s, w0 = line["effort_nm"], line["stall_nm"], line["no_load_rad_per_s"]
    speed, command = (a.ravel() for a in numpy.meshgrid(numpy.linspace(-2 * w0, 2 * w0, 201), numpy.linspace(-2 * e, 2 * e, 9)))
    full = lambda value: numpy.full_like(speed, value)  # noqa: E731
    high, low = numpy.minimum(e, s * (1 - speed / w0)), numpy.maximum(-e, s * (-1 - speed / w0))
    expected = numpy.maximum(numpy.minimum(command, numpy.maximum(high, -e)), numpy.minimum(low, e))
    found = function(mjlab, "dc_motor_clip")(command, full(s), full(w0), full(e), speed)
    of_mjlab = numpy.abs(found - expected).max() / e
    clip = function(source("isaaclab-2*.whl", "isaaclab/actuators/actuator_pd.py"), "_clip_effort", of="DCMotor")
    state = types.SimpleNamespace(_joint_vel=speed.copy(), _vel_at_effort_lim=w0 * (1 + e / s), _saturation_effort=s,
                                  velocity_limit=w0, effort_limit=e)
    of_lab = numpy.abs(clip(state, command) - expected).max() / e
    assert max(of_mjlab, of_lab) < 1e-12, (of_mjlab, of_lab)
    print(f"wheels: keys are there; clips are the line within {of_lab:.1e} (isaaclab) and {of_mjlab:.1e} (mjlab) of e")


main()
