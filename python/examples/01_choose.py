"""A joint from arrays: the choice, why not the others, its table and its page."""

import pathlib
import tempfile

import numpy as np

import gearwise as gw

# A knee in a trot at 2 Hz: half of the time it carries the body, half of it swings.
period = 0.5
time = np.linspace(0.0, period, 101)
phase = 2 * np.pi * time / period
torque = 9.0 * np.clip(np.sin(phase), 0, None) ** 2 + 1.5 * np.sin(phase)  # N m, as the load needs it
velocity = 6.0 * np.cos(phase)  # rad/s

knee = gw.Joint(
    "knee",
    gw.Motion(time, torque, velocity),
    ratio=(3, 30),
    gear=gw.Gear(0.95, mass="150 g", inertia="2e-6 kg*m^2"),
    limits=gw.Limits(actuator_mass="0.8 kg", reflected_inertia="0.03 kg*m^2", winding_temperature="110 degC"),
    objective="loss",
)
found = gw.optimize(gw.Robot("leg", gw.Bus("24 V", drive_current="30 A"), [knee]))
best = found["knee"].best
print(f"take {best.motor} at N = {best.ratio:.3f}, loss {best.loss_w:.3f} W, window {best.window}")
print("what ends the window:", best.binds, "certified:", best.certificate["certified"])

# The bound is computed without what found N*.
assert best.certificate["certified"] and best.feasible
assert best.window[0] <= best.ratio <= best.window[1]
assert all(margin is None or margin > -1e-9 for margin in best.margins.values())

# Why not the others.
for motor in found["knee"].rejected[:3]:
    print(motor["motor"], "cannot do it:", motor["because"])
story = gw.explain(best.motor, gw.Robot("leg", gw.Bus("24 V", drive_current="30 A"), [knee]))
assert story.satisfied

frame = found["knee"].to_pandas()
print(frame[["motor", "ratio", "loss_w", "mass_kg"]].head(3))
assert frame["motor"][0] == best.motor

with tempfile.TemporaryDirectory() as folder:
    page = pathlib.Path(folder) / "leg.html"
    page.write_text(found.html())
    assert page.stat().st_size > 50_000
