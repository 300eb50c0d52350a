"""The length of a shank with the motor and the ratio of its knee, twice: Optuna around `optimize`, and CMA-ES over arrays of
`evaluate`. Both find the same best loss."""

import cma
import numpy as np
import optuna
from joblib import Parallel, delayed

import gearwise as gw

BODY, STRIDE, PERIOD = 12.0, 0.3, 0.35  # kg, m, s


def jump(shank: float) -> gw.Motion:
    """What the knee does with a shank of this length [m]: a short one turns further, a long one has a longer arm."""
    time = np.linspace(0.0, PERIOD, 101)
    phase = 2 * np.pi * time / PERIOD
    swing = STRIDE / (2 * shank)
    angle = -swing * np.cos(phase)
    velocity = swing * np.sin(phase) * 2 * np.pi / PERIOD
    inertia = 0.15 * shank**2 + 0.002
    acceleration = swing * np.cos(phase) * (2 * np.pi / PERIOD) ** 2
    stance = np.clip(np.cos(phase), 0, None)
    torque = 0.15 * BODY * 9.81 * shank * np.sin(0.6 + angle) * stance + inertia * acceleration
    return gw.Motion(time, torque, velocity)


def leg(motion: gw.Motion) -> gw.Robot:
    """The leg with this motion."""
    knee = gw.Joint("knee", motion, ratio=(3, 40), gear=gw.Gear(0.93, mass="180 g"), objective="loss")
    return gw.Robot("leg", gw.Bus("24 V", drive_current="30 A"), [knee])


base = gw.Requirement(leg(jump(0.2)))

# One way: the ratio program inside, one number outside.
optuna.logging.set_verbosity(optuna.logging.WARNING)
study = optuna.create_study(sampler=optuna.samplers.TPESampler(seed=1))
space: dict[str, optuna.distributions.BaseDistribution] = {"shank": optuna.distributions.FloatDistribution(0.1, 0.35)}
for _ in range(12):
    trials = [study.ask(space) for _ in range(8)]
    legs = [base.replace({"joint.knee.motion": jump(t.params["shank"])}) for t in trials]
    answers = Parallel(2, prefer="threads")(delayed(gw.optimize)(each, only_top=1, threads=1) for each in legs)
    for trial, answer in zip(trials, answers):
        if answer.satisfied:
            study.tell(trial, answer["knee"].best.loss_w)
        else:
            study.tell(trial, state=optuna.trial.TrialState.FAIL)
shank = study.best_params["shank"]
first = gw.optimize(leg(jump(shank)), only_top=1)["knee"].best
print(f"Optuna: shank {shank:.4f} m, {first.motor} at N = {first.ratio:.3f}, {study.best_value:.5f} W")

# The other: shank and ratio outside, all motors at once inside, as arrays.
LOW, HIGH = [0.1, np.log(3.0)], [0.35, np.log(40.0)]


def cost(x: np.ndarray) -> float:
    """The least loss of all motors at a shank and the logarithm of a ratio; large where none is a choice."""
    at = gw.evaluate(leg(jump(float(x[0]))), None, [float(np.exp(x[1]))])
    ok = at.feasible & at.judged
    return float(np.min(at.loss_w[ok])) if ok.any() else 1e3


# Each motor has a valley of its own: several starts.
options = {"seed": 2, "verbose": -9, "CMA_stds": [0.05, 0.4], "bounds": [LOW, HIGH], "maxfevals": 250}
starts = [[shank, np.log(ratio)] for shank in (0.13, 0.2) for ratio in (10.0, 20.0, 38.0)]
runs = [cma.fmin2(cost, start, 1.0, options)[1].result for start in starts]
best = min(runs, key=lambda run: float(run.fbest))
print(f"CMA-ES: shank {best.xbest[0]:.4f} m, N = {np.exp(best.xbest[1]):.3f}, {best.fbest:.5f} W")

again = gw.optimize(leg(jump(float(best.xbest[0]))), only_top=1)["knee"].best
assert again.loss_w is not None and best.fbest >= again.loss_w * (1 - 1e-9), "nothing is better than the certified optimum"
assert abs(best.fbest / study.best_value - 1) < 0.01, "both ways find the same optimum"

# What the chosen actuator can do whatever the motion.
able = gw.actuator_map(first.motor, [first.ratio], bus=gw.Bus("24 V", drive_current="30 A"), gear=gw.Gear(0.93, mass="180 g"))
print(f"peak torque {able.peak_torque_nm[0, 0]:.2f} N m up to {able.speed_at_peak_rad_per_s[0, 0]:.1f} rad/s")
assert able.peak_torque_nm[0, 0] >= np.abs(jump(shank).torque).max() * 0.9
