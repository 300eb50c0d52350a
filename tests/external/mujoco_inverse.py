"""Joint torques of `gearwise torques` against mj_inverse of MuJoCo, for the three robots of tests/fixtures/robots and random trees.

mujoco_inverse.py GEARWISE [--write]    GEARWISE is the program; --write writes tests/fixtures/robots/mujoco.json anew.

MuJoCo's inverse dynamics has the rotor (`armature`) and the joint friction in it; gearwise leaves the rotor to the actuator. So the
model's armature and frictionloss are set to zero here, and contacts and limits are switched off.
"""
import json, math, pathlib, subprocess, sys, tempfile

import mujoco
import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
GEARWISE = sys.argv[1]
ROBOTS = [ROOT / "requirements/robots/ur5e.urdf", ROOT / "tests/fixtures/robots/panda.urdf", ROOT / "tests/fixtures/robots/mini_cheetah_leg.xml"]
TOLERANCE = 1e-9


def load(text):
    """The model as it is written: links without mass and fixed links are kept apart from what moves."""
    model = mujoco.MjModel.from_xml_string(text)
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    model.dof_armature[:] = 0
    model.opt.gravity[:] = model.opt.gravity if "<mujoco" in text else (0, 0, -9.81)
    return model


def inverse(model, q, v, a, forces=()):
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:], data.qacc[:] = q, v, a
    mujoco.mj_inverse(model, data)
    torque = data.qfrc_inverse.copy()
    for site, force in forces:
        jacobian = np.zeros((3, model.nv))
        mujoco.mj_jacSite(model, data, jacobian, None, model.site(site).id)
        torque -= jacobian.T @ force
    return torque


def gearwise(text, suffix, table, extra=()):
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        (folder / f"robot{suffix}").write_text(text)
        names, units, rows = table
        lines = [",".join(["time [s]"] + [f"{n} [{u}]" for n, u in zip(names, units)])]
        lines += [",".join(repr(float(x)) for x in [k * 0.01, *row]) for k, row in enumerate(rows)]
        (folder / "t.csv").write_text("\n".join(lines) + "\n")
        command = [GEARWISE, "torques", folder / f"robot{suffix}", folder / "t.csv", "--once", "--csv", "--without-joint-friction", *extra]
        out = subprocess.run(command, capture_output=True, text=True)
        assert out.returncode == 0, out.stderr
        header, *body = out.stdout.strip().splitlines()
        columns = [c.strip('"') for c in header.split(",")]
        values = np.array([[float(x) for x in line.split(",")] for line in body])
        return {c.split(" ")[0].rsplit(".", 1)[0]: values[:, i] for i, c in enumerate(columns) if ".torque" in c or ".force [" in c}


def compare(text, suffix, rng, samples=50, smooth=False, sites=()):
    """Largest difference over the samples, relative to the largest torque of the sample."""
    model = load(text)
    model.dof_damping[:] = 0
    joints = [model.joint(i).name for i in range(model.njnt)]
    units = ["m" if model.jnt_type[i] == mujoco.mjtJoint.mjJNT_SLIDE else "rad" for i in range(model.njnt)]
    n = model.nv
    if smooth:
        t = np.arange(samples)[:, None] * 0.01
        size, rate, phase = rng.uniform(0.2, 1.2, n), rng.uniform(2, 9, n), rng.uniform(0, 6, n)
        q, v, a = size * np.sin(rate * t + phase), size * rate * np.cos(rate * t + phase), -size * rate**2 * np.sin(rate * t + phase)
    else:
        q, v, a = rng.uniform(-3, 3, (samples, n)), rng.normal(0, 4, (samples, n)), rng.normal(0, 30, (samples, n))
    names = joints + [f"{j}.velocity" for j in joints] + [f"{j}.acceleration" for j in joints]
    kinds = units + [f"{u}/s" for u in units] + [f"{u}/s^2" for u in units]
    forces = rng.normal(0, 50, (samples, 3 * len(sites)))
    names += [f"{s}.force_{x}" for s in sites for x in "xyz"]
    kinds += ["N"] * (3 * len(sites))
    ours = gearwise(text, suffix, (names, kinds, np.hstack([q, v, a, forces])))
    worst, rows = 0.0, []
    for k in range(samples):
        pushes = [(s, forces[k, 3 * i:3 * i + 3]) for i, s in enumerate(sites)]
        theirs = inverse(model, q[k], v[k], a[k], pushes)
        mine = np.array([ours[j][k] for j in joints])
        worst = max(worst, np.abs(mine - theirs).max() / max(np.abs(theirs).max(), 1e-6))
        rows.append([q[k].tolist(), v[k].tolist(), a[k].tolist(), theirs.tolist()])
    return worst, joints, rows


def random_tree(rng):
    """An MJCF tree with hinges and slides, several joints per body, all orientations, and inertias of geoms."""
    count, made = int(rng.integers(2, 9)), [0]
    numbers = lambda x: " ".join(repr(float(v)) for v in np.atleast_1d(x))

    def turned():
        kind = rng.integers(5)
        return [lambda: f'quat="{numbers(rng.normal(size=4))}"', lambda: f'axisangle="{numbers([*rng.normal(size=3), rng.uniform(-90, 90)])}"',
                lambda: f'euler="{numbers(rng.uniform(-180, 180, 3))}"', lambda: f'zaxis="{numbers(rng.normal(size=3))}"',
                lambda: f'xyaxes="{numbers(rng.normal(size=6))}"'][kind]()

    def geom():
        size, kind = rng.uniform(0.02, 0.2, 3), ["sphere", "capsule", "cylinder", "box", "ellipsoid"][rng.integers(5)]
        place = f'pos="{numbers(rng.normal(0, 0.2, 3))}" {turned()}'
        if kind != "sphere" and rng.random() < 0.3:
            place, size = f'fromto="{numbers(rng.normal(0, 0.3, 6))}"', size[:1]
        weight = rng.choice([f'mass="{rng.uniform(0.1, 3)}"', f'density="{rng.uniform(100, 3000)}"', ""])
        return f'<geom type="{kind}" size="{numbers(size)}" {place} {weight}/>'

    def body(depth):
        text = f'<body pos="{numbers(rng.normal(0, 0.4, 3))}" {turned()}>'
        if rng.random() < 0.5:
            a, b = rng.uniform(0.01, 0.1, 2)
            inertia = sorted([a, b, rng.uniform(abs(a - b), a + b)])
            text += f'<inertial pos="{numbers(rng.normal(0, 0.2, 3))}" {turned()} mass="{rng.uniform(0.2, 4)}" diaginertia="{numbers(inertia)}"/>'
        for _ in range(int(rng.integers(0 if depth else 1, 3))):
            made[0] += 1
            kind = "slide" if rng.random() < 0.3 else "hinge"
            text += f'<joint name="j{made[0]}" type="{kind}" axis="{numbers(rng.normal(size=3))}" pos="{numbers(rng.normal(0, 0.1, 3))}" ref="{rng.uniform(-1, 1)}"/>'
        text += geom() + (geom() if rng.random() < 0.5 else "")
        if rng.random() < 0.3:
            text += f'<frame pos="{numbers(rng.normal(0, 0.1, 3))}" {turned()}>{geom()}</frame>'
        while made[0] < count and rng.random() < 0.7 and depth < 6:
            text += body(depth + 1)
        return text + "</body>"

    letters = "".join(rng.permutation(list("xyz")))
    letters = letters.upper() if rng.random() < 0.5 else letters
    total = f'settotalmass="{rng.uniform(5, 20)}"' if rng.random() < 0.2 else ""
    return (f'<mujoco><compiler eulerseq="{letters}" {total}/><option gravity="{numbers(rng.normal(0, 9, 3))}"/>'
            f"<worldbody>{body(0)}{body(0)}</worldbody></mujoco>")


def main():
    rng = np.random.default_rng(6)
    worst, table = 0.0, {"mujoco": mujoco.__version__, "numpy": np.__version__, "made_by": "tests/external/mujoco_inverse.py --write", "robots": []}
    for path in ROBOTS:
        text, sites = path.read_text(), ["foot"] if path.suffix == ".xml" else []
        # MuJoCo drops fixed links into their parents and refuses links without mass; both are kept in motion by this extension.
        asked = text.replace('<robot name="ur5e">', '<robot name="ur5e">\n<mujoco><compiler balanceinertia="false"/></mujoco>')
        still, joints, rows = compare(asked, path.suffix, rng)
        moving, *_ = compare(asked, path.suffix, rng, samples=200, smooth=True)
        pushed = compare(asked, path.suffix, rng, sites=sites)[0] if sites else 0.0
        print(f"{path.name}: random states {still:.1e}, trajectory {moving:.1e}, with a force at {sites or 'no site'} {pushed:.1e}")
        worst = max(worst, still, moving, pushed)
        table["robots"].append({"model": str(path.relative_to(ROOT)), "joints": joints, "states": rows[:8]})
    trees = [compare(random_tree(rng), ".xml", rng, samples=20)[0] for _ in range(50)]
    print(f"50 random trees: worst {max(trees):.1e}, median {sorted(trees)[25]:.1e}")
    worst = max(worst, *trees)
    if "--write" in sys.argv:
        (ROOT / "tests/fixtures/robots/mujoco.json").write_text(json.dumps(table, indent=1) + "\n")
    print(f"largest difference relative to the largest torque of a state: {worst:.1e} (at most {TOLERANCE:.0e})")
    assert worst <= TOLERANCE


main()
