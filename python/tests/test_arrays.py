"""Arrays: motors at ratios, and what actuators can do."""

import numpy as np
import pytest

import gearwise as gw
from conftest import leg


def test_the_best_of_an_evaluation_is_the_optimum(robot: gw.Robot) -> None:
    """The optimum by program and by a scan of arrays."""
    best = gw.optimize(robot)["knee"].best
    assert best.loss_w is not None
    low, high = best.window
    found = gw.evaluate(robot, best.motor, np.linspace(low * 1.0000001, high * 0.9999999, 4001))
    assert found.feasible.all() and found.judged.all()
    assert found.loss_w.min() >= best.loss_w * (1 - 1e-12)
    assert found.loss_w.min() == pytest.approx(best.loss_w, rel=1e-6)
    here = gw.evaluate(robot, best.motor, [best.ratio])
    for name in ("loss_w", "peak_current_q_a", "rms_current_q_a", "reflected_inertia_kgm2", "mass_kg", "mean_electrical_power_w"):
        assert getattr(here, name)[0, 0] == pytest.approx(getattr(best, name), rel=1e-12), name
    for place, limit in enumerate(here.limits):
        if limit in best.margins:
            assert here.margin[0, 0, place] == pytest.approx(best.margins[limit], rel=1e-12)
    outside = gw.evaluate(robot, best.motor, [low * 0.999])
    assert not (outside.feasible & outside.judged)[0, 0]


def test_every_window_is_where_evaluation_is_feasible(robot: gw.Robot) -> None:
    answer = gw.optimize(robot)
    ratios = np.geomspace(3, 30, 61)
    found = gw.evaluate(robot, None, ratios)
    place = {motor: k for k, motor in enumerate(found.motors)}
    for design in answer["knee"].candidates:
        inside = np.zeros(len(ratios), bool)
        edge = np.zeros(len(ratios), bool)
        for window in design.windows:
            inside |= (ratios >= window["min"]) & (ratios <= window["max"])
            for end in (window["min"], window["max"]):
                edge |= np.abs(ratios / end - 1) < 1e-6
        row = place[design.motor]
        ok = found.feasible[row] & found.judged[row]
        assert (ok == inside)[~edge].all(), design.motor
    # What is rejected is feasible nowhere, or not judged.
    chosen = {design.motor for design in answer["knee"].candidates} | {u["motor"] for u in answer["knee"].unjudged}
    for motor in set(found.motors) - chosen:
        assert not (found.feasible[place[motor]] & found.judged[place[motor]]).any(), motor


def test_slopes_are_those_of_differences(robot: gw.Robot) -> None:
    ratios = np.geomspace(4, 28, 25)
    here = gw.evaluate(robot, None, ratios)
    up, down = (gw.evaluate(robot, None, ratios * (1 + e)) for e in (1e-6, -1e-6))
    slope = (up.loss_w - down.loss_w) / (2e-6 * ratios)
    known = np.isfinite(here.loss_slope_w)
    assert known.mean() > 0.8
    np.testing.assert_allclose(here.loss_slope_w[known], slope[known], rtol=1e-5, atol=1e-6)


def test_which_limits_are_looked_at(robot: gw.Robot) -> None:
    whole = gw.evaluate(robot, None, [9.0])
    instant = gw.evaluate(robot, None, [9.0], limits="instant")
    assert "winding_peak_temperature" in whole.limits and "winding_peak_temperature" not in instant.limits
    alone = gw.evaluate(robot, None, [9.0], limits=["voltage"])
    assert alone.limits == ("voltage",)
    assert (alone.feasible >= whole.feasible).all()
    with pytest.raises(gw.InputError, match="did you mean `voltage`"):
        gw.evaluate(robot, None, [9.0], limits=["voltag"])


def test_wrong_asks_of_arrays(robot: gw.Robot) -> None:
    for ratios in ([], [0.0], [-3.0], [np.nan], [np.inf]):
        with pytest.raises(gw.InputError, match="ratio"):
            gw.evaluate(robot, None, ratios)
    with pytest.raises(gw.InputError, match="one axis"):
        gw.evaluate(robot, None, [[3.0, 4.0]])
    with pytest.raises(gw.InputError, match="did you mean"):
        gw.evaluate(robot, "t-motor-ri5", [9.0])
    with pytest.raises(gw.InputError, match="there is no joint `hip`"):
        gw.evaluate(robot, None, [9.0], joint="hip")
    geared = gw.Robot("r", robot.bus, [gw.Joint("k", robot.joints[0].motion, gears=["planetary-*"])])  # type: ignore[union-attr]
    with pytest.raises(gw.InputError, match="takes gears of the catalogue"):
        gw.evaluate(geared, None, [9.0])


def test_a_map_agrees_with_the_limits_of_the_choice() -> None:
    """A load of the map's torque is just kept, a little more is not: by another way through the model."""
    bus = gw.Bus("48 V", drive_current="40 A")
    gear = gw.Gear(0.9, mass="200 g", inertia="1e-5 kg*m^2")
    ratios = np.array([4.0, 9.0, 20.0])
    whole = gw.actuator_map(None, ratios, bus=bus, gear=gear)
    picked = ["t-motor-ri50", "t-motor-u8-lee", "maxon-ec-60-flat-625855", "tq-robodrive-ilm-85x26"]
    found = gw.actuator_map(picked, ratios, bus=bus, gear=gear)
    assert len(whole.motors) > 100 and found.motors == tuple(picked)
    checked = 0
    for row, motor in enumerate(picked):
        for column, ratio in enumerate(ratios):
            peak = found.peak_torque_nm[row, column]
            speed = 0.5 * found.speed_at_peak_rad_per_s[row, column]
            if not np.isfinite(peak) or not speed > 0:
                continue
            for share, kept in ((0.999, True), (1.001, False)):
                # Friction comes off what the map says.
                friction = np.nan_to_num(found.friction_loss_nm[row, column])
                viscous = np.nan_to_num(found.damping_nms_per_rad[row, column])
                load = share * (peak - 0.9 * (friction + viscous * speed))
                motion = gw.Motion.points([load], [speed])
                joint = gw.Joint("k", motion, ratio=(1, 100), gear=gear, objective="loss", motor_drag="off")
                at = gw.evaluate(
                    gw.Robot("r", bus, [joint]),
                    motor,
                    [ratio],
                    limits=["peak_current", "peak_torque", "gear_peak_torque", "voltage"],
                )
                assert at.feasible[0, 0] == kept, (motor, ratio, share, at.margin)
                checked += 1
                assert at.mass_kg[0, 0] == pytest.approx(found.mass_kg[row, column], rel=1e-12)
                inertia = found.reflected_inertia_kgm2[row, column]
                assert at.reflected_inertia_kgm2[0, 0] == pytest.approx(inertia, rel=1e-12)
    assert checked >= 16


def test_envelopes_fall_and_end(robot: gw.Robot) -> None:
    found = gw.actuator_map("t-motor-ri50", [9.0], bus=gw.Bus("24 V", drive_current="30 A"))
    end = float(found.max_speed_rad_per_s[0, 0])
    driving, braking = found.envelope(np.linspace(0, 1.1 * end, 200))
    assert driving.shape == braking.shape == (1, 1, 200)
    assert driving[0, 0, 0] == pytest.approx(found.peak_torque_nm[0, 0])
    assert (np.diff(driving[0, 0]) <= 1e-9).all() and driving[0, 0, -1] == 0.0
    assert braking[0, 0, 0] >= driving[0, 0, 0]
    back, _ = found.envelope([-5.0, 5.0])
    assert back[0, 0, 0] == back[0, 0, 1]
    frame = found.to_pandas()
    assert frame["peak_torque_nm"][0] == pytest.approx(found.peak_torque_nm[0, 0])


def test_what_is_not_known_is_not_a_number() -> None:
    found = gw.actuator_map(None, [9.0], bus=gw.Bus("24 V"))
    assert np.isnan(found.friction_loss_nm).any() and not np.isnan(found.friction_loss_nm).all()
    assert found.unusable and all(isinstance(why, str) and why for why in found.unusable.values())
    for motor in found.unusable:
        assert np.isnan(found.mass_kg[found.motors.index(motor), 0])
    # Without a drive's current, and of a motor that says none, a largest torque is the voltage's.
    assert (found.peak_torque_nm <= found.stall_torque_nm + 1e-9)[~np.isnan(found.peak_torque_nm)].all()


def test_ratios_outside_the_range_are_not_feasible() -> None:
    found = gw.evaluate(leg(0.1), None, [2.9, 3.0, 30.0, 30.1])
    assert not found.feasible[:, 0].any() and not found.feasible[:, 3].any()
    assert found.feasible[:, 1].any()
