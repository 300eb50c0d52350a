"""How long calls take, each as a ratio to a baseline of the same run; nothing is asserted. `--large` has a million samples."""

import statistics
import subprocess
import sys
import time

import numpy as np

import gearwise as gw

BUS = gw.Bus("24 V", drive_current="30 A")


def best_of(times: int, call: "object") -> float:
    """The least time of several calls [s]."""
    took = []
    for _ in range(times):
        begun = time.perf_counter()
        call()  # type: ignore[operator]
        took.append(time.perf_counter() - begun)
    return min(took)


def robot(samples: int = 200) -> gw.Robot:
    """A robot with one joint."""
    t = np.linspace(0.0, 0.5, samples + 1)
    motion = gw.Motion(t, 10 * np.sin(4 * np.pi * t), 8 * np.cos(4 * np.pi * t), acceleration=-100 * np.sin(4 * np.pi * t))
    return gw.Robot("leg", BUS, [gw.Joint("knee", motion, ratio=(3, 30), gear=gw.Gear(0.95), objective="loss")])


def main() -> None:
    """Prints a table."""
    asked = gw.Requirement(robot())
    ratios = np.geomspace(3, 30, 200)
    motors = list(gw.Catalog().columns()["id"])[:125]
    gw.optimize(asked)
    plain = best_of(9, lambda: gw.evaluate(asked, motors[0], [9.0]))
    rows = [
        ("evaluate: one motor at one ratio", plain, plain),
        ("evaluate: one motor at 200 ratios", best_of(9, lambda: gw.evaluate(asked, motors[0], ratios)), plain),
        ("evaluate: 125 motors at 200 ratios, instant", best_of(5, lambda: gw.evaluate(asked, motors, ratios, limits="instant")), plain),
        ("evaluate: 125 motors at 200 ratios, all", best_of(5, lambda: gw.evaluate(asked, motors, ratios)), plain),
        ("actuator_map: one motor at 200 ratios", best_of(9, lambda: gw.actuator_map(motors[0], ratios, bus=BUS)), plain),
    ]
    whole, first = best_of(5, lambda: gw.optimize(asked)), best_of(5, lambda: gw.optimize(asked, only_top=1))
    rows += [
        ("optimize: all motors", whole, whole),
        ("optimize: only_top=1", first, whole),
        ("replace and optimize, only_top=1", best_of(5, lambda: gw.optimize(asked.replace({"bus.voltage": 30.0}), only_top=1)), whole),
        ("to_json of it", best_of(5, lambda answer=gw.optimize(asked): answer.to_json()), whole),  # type: ignore[misc]
    ]
    pool, empty = best_of(200, lambda: gw.actuator_map(motors[:2], [9.0], bus=BUS)), best_of(200, lambda: gw.actuator_map(motors[0], [9.0], bus=BUS))
    rows.append(("a call on the pool, over one where it is made", pool, empty))
    bare = "import time; t = time.perf_counter(); {}; print(time.perf_counter() - t)"
    imports = {
        name: statistics.median(
            float(subprocess.run([sys.executable, "-c", bare.format(f"import {name}")], capture_output=True, text=True).stdout)
            for _ in range(9)
        )
        for name in ("gearwise", "numpy")
    }
    rows.append(("import gearwise, over import numpy", imports["gearwise"], imports["numpy"]))
    if "--large" in sys.argv:
        rng = np.random.default_rng(1)
        t = 0.002 * np.arange(1000)

        def episode() -> dict[str, object]:
            phase, size = rng.uniform(0, 6, 4), rng.uniform(0.5, 1.5, 4)
            speed = sum(2 * size[k] * np.sin((k + 1) * 5 * t + phase[k]) for k in range(4))
            torque = sum(1.5 * size[k] * np.cos((k + 1) * 4 * t + phase[k]) for k in range(4)) + rng.normal(0, 0.3, 1000)
            return {"dt": 0.002, "torque": torque, "velocity": speed}

        motion = gw.rollouts([episode() for _ in range(1000)])  # type: ignore[misc]
        joint = gw.Joint("knee", motion, ratio=(2, 40), gear=gw.Gear(0.9), objective="loss")
        large = gw.Requirement(gw.Robot("large", BUS, [joint]))
        rows.append(("optimize: a million samples, all motors", best_of(1, lambda: gw.optimize(large)), whole))
    for name, took, baseline in rows:
        print(f"{name:48} {1e3 * took:10.3f} ms {took / baseline:10.2f} times the baseline")


if __name__ == "__main__":
    main()
