"""The formats in Python, run by Python: do they import, with the keys that each simulator has, and clip as the line says?

Run by .ci/external with the `gearwise` program as the only argument. The simulators themselves are large and need a GPU. So
the modules that the formats import are stand-ins here, with exactly the keys of isaaclab 2.3.2, Isaac Lab 3.0, mjlab 1.6.0 and
unitree_rl_lab: another key is refused, as it is there. The clips are written down once more from their documentation.
"""

import ast
import dataclasses
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile
import types

PROGRAM = sys.argv[1] if len(sys.argv) > 1 else "target/debug/gearwise"
BASE = ["class_type", "joint_names_expr", "stiffness", "damping", "armature", "friction", "dynamic_friction", "viscous_friction"]
LAB2 = [*BASE, "effort_limit", "velocity_limit", "effort_limit_sim", "velocity_limit_sim", "saturation_effort"]
LAB3 = [*BASE, "actuator_effort_limit", "actuator_velocity_limit", "joint_effort_limit", "joint_velocity_limit", "saturation_effort"]
UNITREE = [*BASE, "effort_limit", "velocity_limit", "effort_limit_sim", "velocity_limit_sim", "min_delay", "max_delay",
           "X1", "X2", "Y1", "Y2", "Fs", "Fd", "Va"]
MJLAB = ["target_names_expr", "transmission_type", "armature", "frictionloss", "viscous_damping", "delay_min_lag", "delay_max_lag",
         "stiffness", "damping", "effort_limit", "saturation_effort", "velocity_limit"]
# `friction_distribution_params` is a key, too, but sets static, dynamic and viscous friction alike: it is not written.
RANDOMIZE = {"armature_distribution_params", "lower_limit_distribution_params", "upper_limit_distribution_params"}
DR = {"joint_armature", "joint_damping", "joint_friction", "effort_limits"}
FORMATS = {
    "isaaclab2": ("isaaclab.actuators", "DCMotorCfg", LAB2, RANDOMIZE),
    "isaaclab3": ("isaaclab.actuators", "DCMotorCfg", LAB3, RANDOMIZE),
    "mjlab": ("mjlab.actuator", "DcMotorActuatorCfg", MJLAB, DR),
    "unitree": ("unitree_rl_lab.assets.robots.unitree_actuators", "UnitreeActuatorCfg", UNITREE, RANDOMIZE),
}
HOSTILE = ['knee', 'a"""; import os; os.system("touch owned"); """', "b\\", "1 two", "def", "é\u2028x", "Knee", "k*"]
FITTED = """gearwise = "0.1.0"
[motor]
id = "f"
terminals = "q_axis"
current = "q_axis"
resistance = "0.5 ohm"
resistance_tolerance = "0.02 ohm"
torque_constant = "0.1 N*m/A"
rotor_inertia = "2e-5 kg*m^2"
rotor_inertia_tolerance = "1e-6 kg*m^2"
peak_current = "20 A"
max_speed = "300 rad/s"
viscous_friction = "1e-4 N*m*s/rad"
source = "a bench of '''\\"\\"\\" quotes"
source_kind = "measured"
[effects.coulomb_friction]
torque = "0.02 N*m"
torque_tolerance = "0.004 N*m"
[effects.stribeck_friction]
torque = "0.01 N*m"
speed = "8 rad/s"
[[provenance]]
log = "run.csv"
"""


def gearwise(*arguments, status=(0, 1)):
    done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode in status, f"{arguments}: {done.returncode}: {done.stderr}"
    return done.stdout, done.stderr


def close(actual, expected, what, tolerance=1e-9, scale=0.0):
    assert abs(actual - expected) <= tolerance * max(abs(expected), scale, 1e-12), f"{what}: {actual!r}, {expected!r} expected"


def imported(text, path, name, keys):
    """The module's globals, with a stand-in that knows these keys alone."""
    ast.parse(text)
    stand_in = dataclasses.make_dataclass(name, [(key, object, None) for key in keys], kw_only=True)
    parts = path.split(".")
    modules = {".".join(parts[: k + 1]): types.ModuleType(".".join(parts[: k + 1])) for k in range(len(parts))}
    setattr(modules[path], name, stand_in)
    saved = {key: sys.modules.get(key) for key in modules}
    sys.modules.update(modules)
    try:
        inside = {}
        exec(compile(text, "exported", "exec"), inside)  # noqa: S102
    finally:
        for key, old in saved.items():
            sys.modules.pop(key) if old is None else sys.modules.__setitem__(key, old)
    return inside


def dc_motor(effort, speed, limit, stall, no_load):
    """Clip of Isaac Lab and mjlab, after their documentation."""
    corner = no_load * (1 + limit / stall)
    speed = min(max(speed, -corner), corner)
    high = min(stall * (1 - speed / no_load), limit)
    low = max(stall * (-1 - speed / no_load), -limit)
    return min(max(effort, low), high)


def unitree(effort, speed, c):
    """Clip of Unitree's form."""
    most = c.Y1 if effort * speed > 0 else c.Y2
    if abs(speed) >= c.X1:
        most = max(most * (c.X2 - abs(speed)) / (c.X2 - c.X1), 0.0)
    return min(max(effort, -most), most)


def main():
    folder = pathlib.Path(tempfile.mkdtemp())
    (folder / "f.toml").write_text(FITTED)
    joints = "".join(
        f'[[joint]]\nname = {json.dumps(name)}\nratio = {{ min = 1, max = 100 }}\nmotor_drag = "off"\n'
        'gear = { efficiency = 0.8, backdrive_efficiency = 0.75, inertia = "1e-6 kg*m^2" }\n'
        'points = [ { torque = "0.1 N*m", speed = "0.1 rad/s", duration = "1 s" } ]\n'
        for name in HOSTILE
    )
    (folder / "robot.toml").write_text(f'name = "a \\"bench\\""\nbus = {{ voltage = "48 V" }}\n{joints}')
    design = folder / "design.toml"
    design.write_text('requirement = "robot.toml"\ncatalog = ["f.toml"]\n' + "".join(
        f'[[joint]]\nname = {json.dumps(name)}\nmotor = "f"\nratio = 9.0\n' for name in HOSTILE))
    text, _ = gearwise("export", design, "--to", "json", "--ranges")
    facts = {j["joint"]: j for j in json.loads(text)["joints"]}
    f = facts["knee"]
    e, s, w0, wc = (f["line"][k] for k in ("effort_nm", "stall_nm", "no_load_rad_per_s", "corner_rad_per_s"))
    ranges = {r["name"]: (r["low"], r["high"]) for r in f["ranges"]}
    close(ranges["armature"][1] - ranges["armature"][0], 2 * 81e-6, "range of the armature", 1e-6)
    close(ranges["friction_loss"][1] - ranges["friction_loss"][0], 2 * 9 * 0.004, "range of friction", 1e-6)
    assert "damping" not in ranges, "viscous friction has no ±"
    calls = 0
    for name, (path, cls, keys, range_keys) in FORMATS.items():
        text, _ = gearwise("export", design, "--to", name, "--ranges", "--draws", "5")
        inside = imported(text, path, cls, keys)
        functions = [v for k, v in inside.items() if callable(v) and k != cls and not k.startswith("_")]
        assert len(functions) == len(HOSTILE), f"{name}: {len(functions)} functions"
        made = [function(20.0, 0.5) for function in functions]
        expressions = [getattr(m, "joint_names_expr", None) or m.target_names_expr for m in made]
        for joint, expression in zip(HOSTILE, expressions):
            literal = joint.replace("*", "anything")
            assert re.fullmatch(expression[0], literal), f"{name}: {expression[0]!r} does not match {literal!r}"
        knee = made[0]
        assert (knee.stiffness, knee.damping) == (20.0, 0.5), "the gains are the user's"
        close(knee.armature, f["armature_kgm2"], f"{name} armature")
        close(f["friction_at_rest_nm"], 9 * 0.01, "friction at rest")
        found = inside["KNEE_RANGES"]
        assert set(found) <= range_keys, f"{name}: {set(found) - range_keys}"
        key = "joint_armature" if name == "mjlab" else "armature_distribution_params"
        close(found[key][0], ranges["armature"][0], f"{name} range")
        draws = inside["KNEE_DRAWS"]
        assert len(draws) == 5 and all(d["armature"] > 0 for d in draws)
        if name == "unitree":
            for got, expected in ((knee.X1, wc), (knee.X2, w0), (knee.Y1, 0.8 * e), (knee.Y2, e / 0.75), (knee.Fs, 9 * 0.02),
                                  (knee.Fd, 81e-4), (knee.velocity_limit_sim, 300 / 9)):
                close(got, expected, "unitree")
            # Driving: η of the line, exactly. Braking below the corner: e/η_b.
            for speed in (0.2 * wc, 0.9 * wc, 0.5 * (wc + w0), 0.99 * w0):
                close(unitree(1e9, speed, knee), 0.8 * min(e, s * (1 - speed / w0)), "unitree driving", 1e-6)
            close(unitree(-1e9, 0.5 * wc, knee), -e / 0.75, "unitree braking")
            calls += 5
            continue
        if name == "mjlab":
            close(knee.viscous_damping, 81e-4, "mjlab damping")
            close(knee.frictionloss, 9 * 0.02, "mjlab friction")
            limit, no_load = knee.effort_limit, knee.velocity_limit
        else:
            close(knee.viscous_friction, 81e-4, f"{name} damping")
            close(knee.dynamic_friction, 9 * 0.02, f"{name} friction")
            close(knee.friction, 9 * 0.03, f"{name} friction at rest")
            prefix = "" if name == "isaaclab2" else "actuator_"
            limit, no_load = (getattr(knee, prefix + key) for key in ("effort_limit", "velocity_limit"))
            mechanical = knee.velocity_limit_sim if name == "isaaclab2" else knee.joint_velocity_limit
            close(mechanical, 300 / 9, f"{name} mechanical speed")
        for share in (-1.5, -1.0, -0.4, 0.0, 0.3, 0.6, 0.95, 1.4):
            for command in (-3 * e, -0.5 * e, 0.0, 0.5 * e, 3 * e):
                high, low = min(e, s * (1 - share)), max(-e, s * (-1 - share))
                expected = max(min(command, max(high, -e)), min(low, e))
                close(dc_motor(command, share * w0, limit, knee.saturation_effort, no_load), expected, f"{name} at {share}", scale=e)
                calls += 1
    print(f"formats in Python: {len(FORMATS)} import with the keys of their simulators and clip as the line in {calls} points; "
          f"{len(HOSTILE)} names of joints come back as they were")


main()
