"""`<dcmotor>` as MuJoCo itself runs it: does the exported motor do what the model says?

Run by .ci/external with the `gearwise` program as the only argument. Motors of the catalogue and motors whose every number is
chosen here, with inductance, K_T unlike K_B, friction, cogging and heat. The line of torque over speed is compared with MuJoCo
to 1e-6; what the line is off the motor's voltage circle is worked out here again and compared with what gearwise says.
"""

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
COPPER = 0.00393 / (1 + 0.00393 * 5)  # per kelvin at 25 °C
RATIOS = [3.0, 9.0, 27.0]
VOLTAGE = 24.0
SCENE = """<mujoco model="scene">
  {include}
  <option gravity="0 0 0" timestep="{step}" integrator="Euler" tolerance="1e-14" iterations="500"><flag eulerdamp="disable"/></option>
  <worldbody>{bodies}</worldbody>
</mujoco>
"""
BODY = """<body name="b_{joint}"><joint name="{joint}" class="{joint}_actuator" type="hinge" axis="0 1 0"/>
  <inertial pos="0 0 0" mass="1" diaginertia="{inertia} {inertia} {inertia}"/></body>"""


def gearwise(*arguments, status=(0,)):
    done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode in status, f"{arguments}: {done.returncode}: {done.stderr}"
    return done.stdout


def close(actual, expected, what, tolerance=TOLERANCE, scale=None):
    error = abs(actual - expected) / max(abs(scale if scale is not None else expected), 1e-12)
    assert error <= tolerance, f"{what}: {actual!r}, {expected!r} expected, off by {error:.1e}"
    return error


def requirement(names, folder, voltage=VOLTAGE, extra=""):
    joints = "".join(
        f'[[joint]]\nname = "{name}"\nratio = {{ min = 1, max = 100 }}\nmotor_drag = "off"\n'
        f'gear = {{ inertia = "1e-6 kg*m^2" }}\n'
        f'points = [ {{ torque = "0.01 N*m", speed = "0.1 rad/s", duration = "1 s" }} ]\n'
        for name in names
    )
    path = folder / "robot.toml"
    path.write_text(f'name = "bench"\nbus = {{ voltage = "{voltage} V", drive_current = "60 A" }}\n{extra}{joints}')
    return path


def design(folder, joints, catalog=None, name="design.toml", **keywords):
    """A requirement and a design of joints {name: (motor, ratio)}."""
    requirement(joints, folder, **keywords)
    text = 'requirement = "robot.toml"\n'
    if catalog:
        text += f'catalog = ["{catalog}"]\n'
    for joint, (motor, ratio) in joints.items():
        text += f'[[joint]]\nname = "{joint}"\nmotor = "{motor}"\nratio = {ratio!r}\n'
    path = folder / name
    path.write_text(text)
    return path


def facts_of(path):
    return {j["joint"]: j for j in json.loads(gearwise("export", path, "--to", "json", status=(0, 1)))["joints"]}


def model_of(folder, path, joints, *options, step=1e-5, inertia=0.01, to="dcmotor"):
    gearwise("export", path, "--to", to, *options, "--out", folder / "actuators.xml", status=(0, 1))
    bodies = "".join(BODY.format(joint=joint, inertia=inertia) for joint in joints)
    scene = folder / "scene.xml"
    scene.write_text(SCENE.format(include='<include file="actuators.xml"/>', bodies=bodies, step=step))
    return mujoco.MjModel.from_xml_path(str(scene))


def line(facts, command, speed, key="line"):
    """The clip that all these simulators share, at the joint; the command is torque there."""
    at = facts[key]
    e, s, w0 = at["effort_nm"], at["stall_nm"], at["no_load_rad_per_s"]
    low, high = max(-e, s * (-1 - speed / w0)), min(e, s * (1 - speed / w0))
    # Beyond the speed at which the line leaves -e its own end counts, as in a motor that is driven: clamp the line itself.
    return min(max(command, max(low, -e)), min(high, e)) if low <= high else numpy.clip(high, -e, e)


def torque(model, index, speed, command):
    data = mujoco.MjData(model)
    data.qvel[index], data.ctrl[index] = speed, command
    mujoco.mj_forward(model, data)
    return data.qfrc_actuator[index]


def catalogue(folder):
    """The motors of the catalogue at three ratios: MuJoCo's torque is the line, everywhere."""
    rows = json.loads(gearwise("catalog", "list", "motors", "--json"))["motors"]
    # Of some rows nothing says the inertia of the rotor: these are no designs.
    known = {row["id"]: {number["column"] for number in row["numbers"]} for row in rows}
    constants = ("torque_constant", "back_emf_constant", "speed_constant")
    motors = [motor for motor, numbers in known.items()
              if {"resistance", "rotor_inertia"} <= numbers and numbers & set(constants)]
    joints = {f"j{k}_{n}": (motor, ratio) for k, motor in enumerate(motors) for n, ratio in enumerate(RATIOS)}
    facts = facts_of(design(folder, joints))
    known = {joint: of for joint, of in joints.items() if facts[joint]["line"]}
    assert len(known) >= 300, f"{len(known)} of {len(joints)} have a line"
    worst = 0.0
    for option, key in (((), "line"), (("--line", "below"), "line_below")):
        model = model_of(folder, design(folder, known), known, *option)
        data = mujoco.MjData(model)
        names = list(known)
        order = [model.joint(name).dofadr[0] for name in names]
        ends = numpy.array([facts[n][key]["no_load_rad_per_s"] for n in names])
        efforts = numpy.array([facts[n][key]["effort_nm"] for n in names])
        for share in numpy.linspace(-1.6, 1.6, 81):
            for command in (-2.0, -0.4, 0.0, 0.3, 2.0):
                data.qvel[order] = share * ends
                gear = numpy.array([facts[n]["ratio"] for n in names])
                data.ctrl[:] = command * efforts / gear
                mujoco.mj_forward(model, data)
                for k, name in enumerate(names):
                    expected = line(facts[name], command * efforts[k], share * ends[k], key)
                    scale = max(efforts[k], abs(expected))
                    what = f"{known[name]} at {share} of its speed, command {command}"
                    worst = max(worst, close(data.qfrc_actuator[order[k]], expected, what, scale=scale))
    return len(known), worst


def chosen(folder, seed=25):
    """Motors of chosen numbers: armature once, friction, and how far the line is off the voltage circle."""
    random = numpy.random.default_rng(seed)
    rows = ["id,terminals,current,resistance [ohm],inductance [mH],torque_constant [N*m/A],back_emf_constant [V*s/rad],"
            "back_emf_convention,rotor_inertia [kg*m^2],mass [kg],pole_pairs,continuous_current [A],peak_current [A],"
            "coulomb_friction [N*m],viscous_friction [N*m*s/rad],max_winding_temperature [degC],source,source_kind"]
    motors = {}
    for k in range(24):
        between = lambda low, high: low * (high / low) ** random.random()  # noqa: E731
        m = dict(r=between(0.05, 1), l=between(0.02, 0.6), kt=between(0.03, 0.2), j=between(1e-6, 1e-4), p=random.integers(4, 22),
                 i=between(5, 50), c=between(1e-3, 0.02), b=between(1e-6, 1e-4))
        m["kb"] = m["kt"] * between(1.0, 1.15)
        motors[f"m{k}"] = m
        rows.append(f"m{k},q_axis,q_axis,{m['r']!r},{m['l']!r},{m['kt']!r},{m['kb']!r},q_axis,{m['j']!r},0.3,{m['p']},5,{m['i']!r},"
                    f"{m['c']!r},{m['b']!r},120,worked example,derived")
    (folder / "motors.csv").write_text("\n".join(rows) + "\n")
    joints = {f"j_{m}": (m, RATIOS[k % 3]) for k, m in enumerate(motors)}
    path = design(folder, joints, catalog="motors.csv")
    facts = facts_of(path)
    # A link so heavy that it hardly accelerates: MuJoCo's friction is a soft constraint, saturated only then.
    model = model_of(folder, path, joints, inertia=10.0)
    volt = VOLTAGE / math.sqrt(2)
    off = 0.0
    for joint, (name, ratio) in joints.items():
        m, f, index = motors[name], facts[joint], model.joint(joint).dofadr[0]
        close(f["armature_kgm2"], ratio**2 * (m["j"] + 1e-6), "armature", 1e-9)
        close(f["line"]["no_load_rad_per_s"], volt / m["kb"] / ratio, "no load", 1e-9)
        # The voltage circle with the winding at 120 °C: speed at which a torque ends.
        r = m["r"] * (1 + COPPER * 95)
        limit = min(f["line"]["effort_nm"] / ratio / m["kt"], m["i"])
        currents = numpy.linspace(0, limit, 4001)[1:]
        a = m["kb"] ** 2 + (m["p"] * m["l"] * 1e-3 * currents) ** 2
        b = r * currents * m["kb"]
        c = (r * currents) ** 2 - volt**2
        speeds = (-b + numpy.sqrt(numpy.maximum(b * b - a * c, 0))) / a / ratio
        torques = currents * m["kt"] * ratio
        straight = numpy.minimum(f["line"]["effort_nm"], f["line"]["stall_nm"] * (1 - speeds / f["line"]["no_load_rad_per_s"]))
        if f["line"]["corner_rad_per_s"] > 0:
            close(f["line"]["corner_rad_per_s"], speeds[-1], "corner", 1e-9)
        for key, found in (("excess_nm", (straight - torques).max()), ("shortfall_nm", (torques - straight).max())):
            close(f["line"][key], max(found, 0), f"{name} {key}", 2e-3, scale=f["line"]["effort_nm"])
            off = max(off, f["line"][key] / f["line"]["effort_nm"])
        below = numpy.minimum(f["line_below"]["effort_nm"],
                              f["line_below"]["stall_nm"] * (1 - speeds / f["line_below"]["no_load_rad_per_s"]))
        assert (below - torques).max() <= 2e-3 * f["line"]["effort_nm"], f"{name}: the line below promises too much"
        # Accelerations: armature once, damping and friction of motor and gear; friction is saturated at these speeds.
        for speed in (-0.3 * f["line"]["no_load_rad_per_s"], 0.4 * f["line"]["no_load_rad_per_s"]):
            command = 0.2 * f["line"]["effort_nm"] / ratio
            data = mujoco.MjData(model)
            data.qvel[index], data.ctrl[index] = speed, command
            mujoco.mj_forward(model, data)
            given = line(f, command * ratio, speed)
            rest = given - f["damping_nms_per_rad"] * speed - math.copysign(f["friction_loss_nm"], speed)
            close(data.qacc[index], rest / (f["armature_kgm2"] + 10.0), f"{name} accelerates at {speed}")
    return off


def one(folder, row="", ratio=9.0, extra="", effects=""):
    """A fitted actuator whose every number is chosen, as a file."""
    (folder / "f.toml").write_text(
        'gearwise = "0.1.0"\n[motor]\nid = "f"\nterminals = "q_axis"\ncurrent = "q_axis"\nresistance = "0.5 ohm"\n'
        'torque_constant = "0.1 N*m/A"\nrotor_inertia = "2e-5 kg*m^2"\npeak_current = "20 A"\nsource = "s"\nsource_kind = "measured"\n'
        f'max_winding_temperature = "120 degC"\n{row}{effects}[[provenance]]\nlog = "run.csv"\n')
    return design(folder, {"knee": ("f", ratio)}, catalog="f.toml", extra=extra)


def spin_up(folder):
    """From standstill with all the voltage: the closed form, in the limit of small steps."""
    path = one(folder, row='viscous_friction = "0 N*m*s/rad"\n')
    f = facts_of(path)["knee"]
    e, s, w0 = (f["line"][k] for k in ("effort_nm", "stall_nm", "no_load_rad_per_s"))
    inertia = 0.01 + f["armature_kgm2"]
    corner = f["line"]["corner_rad_per_s"]
    end = corner * inertia / e + 0.7 * w0 * inertia / s
    expected = w0 - (w0 - corner) * math.exp(-0.7)
    found = []
    for steps in (20000, 40000):
        model = model_of(folder, path, ["knee"], step=end / steps)
        data = mujoco.MjData(model)
        data.ctrl[0] = 100
        for _ in range(steps):
            mujoco.mj_step(model, data)
        found.append(data.qvel[0])
    return close(2 * found[1] - found[0], expected, "spin-up", 1e-5)


def cogging(folder):
    """The torque of a fitted order, with its sign: the motor has to supply a cos + b sin more."""
    a, b, order, ratio = 0.004, -0.003, 12, 9.0
    effects = (f'[[effects.cogging]]\norder = {order}\ncosine = "{a} N*m"\nsine = "{b} N*m"\n'
               '[[effects.cogging]]\norder = 24\ncosine = "0.001 N*m"\nsine = "0 N*m"\n')
    path = one(folder, effects=effects, ratio=ratio)
    model = model_of(folder, path, ["knee"])
    worst = 0.0
    for angle in numpy.linspace(-1, 1, 41):
        data = mujoco.MjData(model)
        data.qpos[0] = angle
        mujoco.mj_forward(model, data)
        motor = order * ratio * angle
        expected = -ratio * (a * math.cos(motor) + b * math.sin(motor))
        worst = max(worst, close(data.qfrc_actuator[0], expected, f"cogging at {angle}", scale=ratio * 0.005))
    text = (folder / "actuators.xml").read_text()
    assert "left out: cogging of other orders: 0.001 N*m of order 24" in text, text
    return worst


def electrical(folder):
    """A step of the command: the torque follows with L/R."""
    path = one(folder, row='inductance = "1 mH"\npole_pairs = 7\n')
    time = 1e-3 / 0.5
    found = []
    for steps in (2000, 4000):
        model = model_of(folder, path, ["knee"], "--electrical", step=time / steps, inertia=1e6)
        data = mujoco.MjData(model)
        data.ctrl[0] = 0.5
        for _ in range(steps):
            mujoco.mj_step(model, data)
        mujoco.mj_forward(model, data)
        found.append(data.qfrc_actuator[0])
    return close(found[1], 9 * 0.5 * (1 - math.exp(-1)), "63 % after L/R", 1e-3)


def heat(folder):
    """A torque that lasts: the winding ends where R_th R i² says, and the torque stays what it was."""
    row = ('thermal_resistance_winding_housing = "1 K/W"\nthermal_resistance_housing_ambient = "3 K/W"\n'
           'thermal_time_constant_winding = "20 s"\nthermal_time_constant_housing = "400 s"\n')
    path = one(folder, row=row, extra='[ambient]\ntemperature = "30 degC"\n')
    f = facts_of(path)["knee"]
    model = model_of(folder, path, ["knee"], "--thermal", step=1.0, inertia=1e9)
    data = mujoco.MjData(model)
    current = 5.0
    data.ctrl[0] = 0.1 * current
    for _ in range(8000):
        mujoco.mj_step(model, data)
    # As if the winding were at its hottest, 120 °C: rise = R_th R i². The torque stays the command.
    expected = f["heat"]["resistance_k_per_w"] * 0.5 * (1 + COPPER * 95) * current**2
    mujoco.mj_forward(model, data)
    close(data.qfrc_actuator[0], 9 * 0.1 * current, "the torque of a hot winding")
    return close(data.act[-1], expected, "steady temperature above ambient", 1e-6)


def gear_joint(folder):
    """Elasticity as a second joint: it rings as two inertias with a spring between them do; play lets the link go as far."""
    model_text = ('<mujoco><option gravity="0 0 0" timestep="1e-5" integrator="implicit"/><compiler angle="radian"/><worldbody>'
                  '<body name="link"><joint name="knee" type="hinge" axis="0 1 0"/><inertial pos="0 0 0" mass="1" '
                  'diaginertia="0.01 0.01 0.01"/></body></worldbody></mujoco>')
    bare = folder / "bare.xml"
    bare.write_text(model_text)
    path = one(folder, row='viscous_friction = "0 N*m*s/rad"\n', effects='[effects.gear_compliance]\ncompliance = "2e-3 rad/(N*m)"\n')
    out = folder / "elastic.xml"
    gearwise("export", path, "--into", bare, "--gear-joint", "--out", out, status=(0, 1))
    model = mujoco.MjModel.from_xml_path(str(out))
    assert model.nv == 2, model.nv
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    mass = numpy.zeros((2, 2))
    mujoco.mj_fullM(model, data, mass)
    armature = 81 * (2e-5 + 1e-6)
    frequencies = numpy.sqrt(numpy.sort(numpy.linalg.eigvals(numpy.linalg.solve(mass, numpy.diag(model.jnt_stiffness))).real))
    expected = math.sqrt(500 * (1 / 0.01 + 1 / armature))
    found = close(frequencies[1], expected, "resonance", 1e-6)
    path = one(folder, effects='[effects.backlash]\nhalf_play = "0.004 rad"\n')
    gearwise("export", path, "--into", bare, "--gear-joint", "--out", out, status=(0, 1))
    model = mujoco.MjModel.from_xml_path(str(out))
    close(model.joint("knee_gear").range[1], 0.004, "play", 1e-9)
    # Written twice, the second time changes nothing.
    again = folder / "again.xml"
    gearwise("export", path, "--into", out, "--gear-joint", "--out", again, status=(0, 1))
    assert again.read_text() == out.read_text(), "the second time changes something"
    return found


def into(folder):
    """`--into` with `--to dcmotor`: the joint's own armature and damping do not count twice."""
    bare = folder / "bare.xml"
    bare.write_text('<mujoco><option gravity="0 0 0"/><worldbody><body name="link"><joint name="knee" type="hinge" axis="0 1 0" '
                    'armature="0.5" damping="3"/><inertial pos="0 0 0" mass="1" diaginertia="0.01 0.01 0.01"/></body></worldbody></mujoco>')
    path = one(folder, row='viscous_friction = "1e-4 N*m*s/rad"\n')
    f = facts_of(path)["knee"]
    out = folder / "into.xml"
    gearwise("export", path, "--into", bare, "--to", "dcmotor", "--out", out, status=(0, 1))
    model = mujoco.MjModel.from_xml_path(str(out))
    data = mujoco.MjData(model)
    data.qvel[0], data.ctrl[0] = 5.0, 0.7
    mujoco.mj_forward(model, data)
    expected = (9 * 0.7 - f["damping_nms_per_rad"] * 5) / (f["armature_kgm2"] + 0.01)
    return close(data.qacc[0], expected, "acceleration in a model")


def main():
    folder = pathlib.Path(tempfile.mkdtemp())
    count, worst = (0, 0.0) if '--quick' in sys.argv else catalogue(folder)
    off = chosen(folder)
    print(f"mujoco {mujoco.__version__} dcmotor: {count} designs of the catalogue follow the line within {worst:.1e}; "
          f"line and voltage circle of 24 chosen motors are up to {100 * off:.1f} % of e apart, as gearwise says; "
          f"spin-up {spin_up(folder):.1e}, cogging {cogging(folder):.1e}, L/R {electrical(folder):.1e}, "
          f"steady temperature {heat(folder):.1e}, resonance {gear_joint(folder):.1e}, into a model {into(folder):.1e}")


main()
