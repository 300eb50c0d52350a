"""Episodes of MuJoCo as a motion, the choice, and the chosen actuator back in MuJoCo: it follows the same episodes within
1 %, and no limit is exceeded."""

import json
import warnings

import mujoco
import numpy as np

import gearwise as gw

DT, STEPS, EPISODES = 0.002, 1500, 6
ARMATURE, DAMPING = 0.02, 0.05  # what the simulator's joint has before anything is chosen
ARM = """
<mujoco><option timestep="{dt}" integrator="implicitfast"/>
  {defaults}
  <worldbody><body><joint name="elbow" type="hinge" axis="0 1 0" armature="{armature}" damping="{damping}"/>
    <geom type="capsule" fromto="0 0 0 0 0 -0.3" size="0.02" mass="0.6"/>
    <geom type="sphere" pos="0 0 -0.3" size="0.04" mass="0.8"/></body></worldbody>
  <actuator>{actuator}</actuator></mujoco>"""


def goal(episode: int, time: float) -> float:
    """The angle that an episode wants."""
    a, w = 0.4 + 0.1 * episode, 2.0 + 0.6 * episode
    ramp = 1 - np.exp(-((time / 0.6) ** 2))
    return float(a * ramp * np.sin(w * time))


def run(model: mujoco.MjModel, episode: int, to_control: float, most: float) -> dict[str, np.ndarray]:
    """One episode under a controller of position, whose torque at the joint is `ctrl / to_control`."""
    data = mujoco.MjData(model)
    kept: dict[str, list[float]] = {key: [] for key in ("torque", "velocity", "acceleration", "position", "asked")}
    for step in range(STEPS):
        want = goal(episode, step * DT)
        torque = float(np.clip(60.0 * (want - data.qpos[0]) - 4.0 * data.qvel[0], -most, most))
        data.ctrl[0] = torque * to_control
        mujoco.mj_step1(model, data)
        mujoco.mj_step2(model, data)
        mujoco.mj_forward(model, data)
        kept["torque"].append(float(data.qfrc_actuator[0]))
        kept["velocity"].append(float(data.qvel[0]))
        kept["acceleration"].append(float(data.qacc[0]))
        kept["position"].append(float(data.qpos[0]))
        kept["asked"].append(torque)
    return {key: np.array(values) for key, values in kept.items()}


plain = mujoco.MjModel.from_xml_string(
    ARM.format(dt=DT, armature=ARMATURE, damping=DAMPING, defaults="", actuator='<motor joint="elbow" gear="1"/>')
)
before = [run(plain, episode, 1.0, 1e3) for episode in range(EPISODES)]
episodes = [{"dt": np.array(DT), **{key: e[key] for key in ("torque", "velocity", "acceleration")}} for e in before]

motion = gw.rollouts(episodes, armature=ARMATURE, damping=DAMPING)
bus = gw.Bus("24 V", drive_current="20 A")
elbow = gw.Joint("elbow", motion, ratio=(3, 60), gear=gw.Gear(1.0), objective="loss", limits=gw.Limits(reflected_inertia="0.05 kg*m^2"))
found = gw.optimize(gw.Robot("arm", bus, [elbow]))
best = found["elbow"].best
print(motion, "->", best.motor, f"at N = {best.ratio:.2f}, loss {best.loss_w:.3f} W")

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    text = gw.export(found, "dcmotor")
defaults = text[text.index("<default>") : text.rindex("</default>") + len("</default>")]
chosen = mujoco.MjModel.from_xml_string(
    ARM.format(
        dt=DT,
        # The actuator has its own; the joint's stand-ins are gone.
        armature=0,
        damping=0,
        defaults=defaults,
        actuator='<dcmotor class="elbow_actuator" joint="elbow"/>',
    )
)
ratio, effort = best.ratio, json.loads(gw.export(found, "json"))["joints"][0]["effort_nm"]
followed = [run(chosen, episode, 1.0 / ratio, effort) for episode in range(EPISODES)]
for episode, (was, now) in enumerate(zip(before, followed)):
    off = np.abs(now["position"] - was["position"]).max() / np.abs(was["position"]).max()
    assert off < 0.01, (episode, off)
    # What was asked for is what the motor gave: no limit of torque or voltage was met.
    assert np.allclose(now["torque"], now["asked"], rtol=1e-6, atol=1e-6), episode
    print(f"episode {episode}: the same way within {100 * off:.2f} %, most {np.abs(now['torque']).max():.2f} of {effort:.2f} N m")
assert min(margin for margin in best.margins.values() if margin is not None) > -1e-9
