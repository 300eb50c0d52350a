"""Requirements: what is written down can be read again."""

import pathlib
import typing

import numpy as np
import pytest

import gearwise as gw
from conftest import ROOT, leg


def test_a_requirement_of_numbers_is_a_file_with_units(tmp_path: pathlib.Path) -> None:
    knee = gw.Joint(
        "knee",
        points=[{"torque": 18.0, "speed": 0, "duration": 0.5}, {"torque": 5, "speed": 9.0, "duration": "1 s"}],
        ratio=(3, 30),
        gear=gw.Gear(0.95, mass=0.15),
        limits=gw.Limits(winding_temperature=383.15, torque_bandwidth={"frequency": 60.0, "amplitude": 2}),
    )
    asked = gw.Requirement(gw.Robot("leg", gw.Bus(48, drive_current=40.0), [knee], ambient=300.0))
    text = asked.to_toml()
    assert 'voltage = "48 V"' in text and 'speed = "0 rad/s"' in text and 'temperature = "300.0 K"' in text
    path = tmp_path / "leg.toml"
    path.write_text(text)
    assert gw.optimize(path).to_json() == gw.optimize(asked).to_json()


def test_changes_are_written_where_they_are_read(tmp_path: pathlib.Path) -> None:
    source = ROOT / "requirements/exoskeleton_hip.toml"
    changes: dict[str, object] = {
        "bus.voltage": 30.0,
        "joint.*.limits.safety": 1.1,
        "joint.*.limits.actuator_mass": "1.1 kg",
        "scale.torque": 0.9,
        "ambient.temperature": "35 degC",
    }
    asked = gw.Requirement(source).replace(changes)
    text = asked.to_toml()
    assert 'voltage = "30.0 V"' in text and "safety = 1.1" in text
    # Comments of the file stay.
    comments = [line for line in source.read_text().splitlines() if line.startswith("#")]
    assert all(comment in text for comment in comments)
    path = tmp_path / "hip.toml"
    path.write_text(text.replace('"motions/', f'"{ROOT}/requirements/motions/'))
    again, first = gw.optimize(path), gw.optimize(asked)
    name = asked.joints[0]
    assert [d.to_dict() for d in again[name].candidates] == [d.to_dict() for d in first[name].candidates]


def test_a_motion_stands_by_its_content() -> None:
    asked = gw.Requirement(leg())
    (name,) = asked.motions
    assert name in asked.to_toml()
    assert gw.Requirement(leg()) == asked and hash(gw.Requirement(leg())) == hash(asked)
    assert gw.Requirement(leg(2.0)) != asked
    time = np.linspace(0.0, 0.5, 51)
    same = gw.Motion(time, 10.0 * np.sin(2 * np.pi * time / 0.5), 8.0 * np.cos(2 * np.pi * time / 0.5))
    assert asked.replace({"joint.knee.motion": same}).motions.keys() == asked.motions.keys()


def test_an_answer_is_the_same_in_every_run() -> None:
    """A motion's name is no number of a process."""
    import subprocess
    import sys

    script = "from conftest import leg; import gearwise as gw; print(gw.optimize(gw.Requirement(leg()).replace({'scale.torque': 0.9})).to_json())"
    runs = [
        subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, cwd=pathlib.Path(__file__).parent).stdout
        for _ in range(2)
    ]
    assert runs[0] == runs[1] and len(runs[0]) > 1000


def test_rollouts(tmp_path: pathlib.Path) -> None:
    steps, episodes = 400, 3
    t = 0.002 * np.arange(steps)
    speed = np.stack([np.stack([2 * np.sin((3 + e) * t), np.cos(t)], -1) for e in range(episodes)])
    acceleration = np.stack([np.stack([2 * (3 + e) * np.cos((3 + e) * t), -np.sin(t)], -1) for e in range(episodes)])
    load = 5 + np.cos(4 * t)
    torque = np.stack([np.stack([load, 0 * t], -1)] * episodes) + 0.02 * acceleration + 0.3 * speed
    done = np.zeros((episodes, steps), bool)
    done[1, 99] = True
    for array in (torque, speed, acceleration):
        array[1, 100:] = 0.0
    arrays: dict[str, typing.Any] = {"dt": 0.002, "torque": torque, "velocity": speed, "acceleration": acceleration, "done": done, "names": np.array(["hip", "knee"])}
    made = gw.rollouts(arrays, "hip", armature=0.02, damping="0.3 N*m*s/rad")
    assert len(made) == 400 + 100 + 400
    np.testing.assert_allclose(made.torque[:400], load, rtol=1e-12)
    np.testing.assert_allclose(made.weight.sum(), 1.0)
    path = tmp_path / "episodes.npz"
    np.savez(path, **arrays)
    assert gw.rollouts(path, "hip", armature=0.02, damping=0.3) == made
    each: list[dict[str, typing.Any]] = [
        {"dt": 0.002, "torque": torque[e, :, 0], "velocity": speed[e, :, 0], "acceleration": acceleration[e, :, 0], "done": done[e]}
        for e in range(episodes)
    ]
    assert gw.rollouts(each, armature=0.02, damping=0.3) == made
    polars = pytest.importorskip("polars")
    columns = {
        "episode": np.repeat(np.arange(episodes), steps),
        "time": np.tile(t, episodes),
        "torque": torque[:, :, 0].ravel(),
        "velocity": speed[:, :, 0].ravel(),
        "acceleration": acceleration[:, :, 0].ravel(),
        "done": done.ravel(),
    }
    table = tmp_path / "episodes.parquet"
    polars.DataFrame(columns).write_parquet(table)
    assert gw.rollouts(table, armature=0.02, damping=0.3) == made
    # The order of episodes does not matter to a choice, and it says what it does not follow.
    joint = gw.Joint("k", made, ratio=(3, 40), objective="loss")
    back = gw.Joint("k", gw.rollouts(each[::-1], armature=0.02, damping=0.3), ratio=(3, 40), objective="loss")
    one, two = (gw.optimize(gw.Robot("r", gw.Bus("24 V", drive_current="30 A"), [j]), only_top=3) for j in (joint, back))
    assert one["k"].best.motor == two["k"].best.motor
    assert one["k"].best.ratio == pytest.approx(two["k"].best.ratio, rel=1e-6)
    assert any("many episodes" in str(said) for said in one["k"].best.assumed)


def test_axes_of_rollouts_are_what_they_are(tmp_path: pathlib.Path) -> None:
    episodes, steps, dt = 8, 1000, 0.002
    time = dt * np.arange(steps)
    sizes = np.linspace(0.5, 1.2, episodes)[:, None]
    torque, velocity = 10 * sizes * np.sin(4 * np.pi * time), 6 * sizes * np.cos(4 * np.pi * time)
    each = gw.rollouts([{"dt": dt, "torque": torque[k], "velocity": velocity[k]} for k in range(episodes)])
    assert len(each) == episodes * steps
    both: dict[str, typing.Any] = {"torque": torque, "velocity": velocity}
    assert gw.rollouts({"dt": dt, **both}) == each
    assert gw.rollouts({"time": time, **both}) == each
    assert gw.rollouts({"dt": dt, **both, "done": np.arange(steps) == steps - 1}) == each
    np.savez(tmp_path / "dt.npz", dt=dt, **both)
    assert gw.rollouts(tmp_path / "dt.npz") == each
    # Over step and joint, named or with a time that has the steps.
    hip = gw.rollouts([{"dt": dt, "torque": torque[2], "velocity": velocity[2]}])
    turned = {"torque": torque.T, "velocity": velocity.T}
    assert gw.rollouts({"dt": dt, **turned, "names": list("abcdefgh")}, "c") == hip
    assert gw.rollouts({"time": time, **turned}, 2) == hip
    # What could be both is refused.
    for arrays in (turned, {"torque": torque[:, :60], "velocity": velocity[:, :60]}):
        with pytest.raises(gw.InputError, match="episodes and steps, or steps and joints"):
            gw.rollouts({"dt": dt, **arrays})
    # Noise anywhere is seen.
    bad = torque.copy()
    bad[3, 700] = np.nan
    with pytest.raises(gw.InputError, match="episode 3"):
        gw.rollouts({"dt": dt, "torque": bad, "velocity": velocity})


def test_masks_and_odd_values_are_not_data(tmp_path: pathlib.Path) -> None:
    time = np.linspace(0.0, 0.5, 51)
    torque, velocity = 10 * np.sin(4 * np.pi * time), 8 * np.cos(4 * np.pi * time)
    bad = np.ma.masked_array(np.where(np.arange(51) == 20, 60.0, torque), mask=np.arange(51) == 20)
    with pytest.raises(gw.InputError, match="masked"):
        gw.Motion(time, bad, velocity)
    with pytest.raises(gw.InputError, match="masked"):
        gw.rollouts([{"time": time, "torque": bad, "velocity": velocity}])
    assert len(gw.Motion(time, np.ma.masked_array(torque, mask=False), velocity)) > 0
    motion = gw.Motion(time, torque, velocity)
    with pytest.raises(ValueError, match="WRITEABLE"):
        motion.torque.flags.writeable = True
    good: dict[str, typing.Any] = {"dt": 0.01, "torque": torque, "velocity": velocity}
    both: dict[str, typing.Any] = {"dt": 0.01, "torque": np.stack([torque, torque], -1), "velocity": np.stack([velocity, velocity], -1)}
    wrong: list[tuple[object, object, str]] = [
        ([{**good, "dt": "a"}], 0, "`dt` is no array of numbers"),
        ([{**good, "torque": 3.0}], 0, "one number"),
        ({"dt": 0.01, "torque": 3.0, "velocity": 3.0}, 0, "one number"),
        ([good], 7, "no axis of joints"),
        ([{**both, "names": ["a", "b", "c"]}], 0, "`names` has 3 joints"),
        ([{**both, "names": ["a", "a"]}], "a", "twice"),
        ([good], 1.5, "neither a name nor a place"),
    ]
    for episodes, joint, said in wrong:
        with pytest.raises(gw.InputError, match=said):
            gw.rollouts(episodes, joint)  # type: ignore[arg-type]
    assert gw.rollouts([both], typing.cast(int, np.int64(1))) == gw.rollouts([good])
    (tmp_path / "noise.parquet").write_bytes(b"PAR1 noise")
    with pytest.raises(gw.InputError, match="cannot be read as a Parquet"):
        gw.rollouts(tmp_path / "noise.parquet")


def test_a_power_of_the_bus_is_a_number(tmp_path: pathlib.Path) -> None:
    robot = leg()
    asked = gw.Requirement(robot).replace({"bus.regeneration": 200})
    assert 'regeneration = "200 W"' in asked.to_toml()
    assert asked.to_toml() == gw.Requirement(robot).replace({"bus.regeneration": "200 W"}).to_toml()
    with pytest.raises(gw.InputError, match="regeneration"):
        gw.Requirement(robot).replace({"bus.regeneration": -1})


def test_a_stream_that_is_reset_is_several_episodes() -> None:
    time = 0.002 * np.arange(1000)
    torque, velocity = np.sin(20 * time), np.cos(20 * time)
    done = np.isin(np.arange(1000), [99, 499, 999])
    stream = gw.rollouts({"dt": 0.002, "torque": torque, "velocity": velocity, "done": done})
    parts = [slice(0, 100), slice(100, 500), slice(500, 1000)]
    each = gw.rollouts([{"dt": 0.002, "torque": torque[p], "velocity": velocity[p]} for p in parts])
    for of_stream, of_parts in ((stream.torque, each.torque), (stream.weight, each.weight)):
        np.testing.assert_allclose(of_stream, of_parts, rtol=1e-12)
    np.testing.assert_allclose(stream.acceleration, each.acceleration, rtol=1e-6, atol=1e-6)
    # Done for good: what is behind it is padding.
    padded = gw.rollouts({"dt": 0.002, "torque": torque, "velocity": velocity, "done": np.arange(1000) >= 99})
    assert len(padded) == 100
    with pytest.warns(UserWarning, match="2 of 1000 steps"):
        short = np.isin(np.arange(1000), [997, 998])
        assert len(gw.rollouts({"dt": 0.002, "torque": torque, "velocity": velocity, "done": short})) == 998


def test_wrong_rollouts(tmp_path: pathlib.Path) -> None:
    good: dict[str, typing.Any] = {"dt": 0.01, "torque": np.ones(20), "velocity": np.ones(20)}
    wrong: list[tuple[object, str]] = [
        ([{**good, "velocity": np.ones(19)}], "`velocity` has 19 steps"),
        ([{**good, "speed": np.ones(20)}], "`speed` is no key"),
        ([{**good, "time": np.arange(20)}], "one of the two"),
        ([{"torque": np.ones(20), "velocity": np.ones(20)}], "one of the two"),
        ([{**good, "dt": -1}], "not one number greater than zero"),
        ([{**good, "torque": np.full(20, np.nan)}], "episode 0: `torque`, sample 0: NaN"),
        ([good, {**good, "dt": 0.01, "torque": np.ones((20, 2)), "velocity": np.ones((20, 2))}], "different"),
        ([], "no episode"),
        (3, "no mapping"),
        ([3], "no mapping"),
        (tmp_path / "nothing.npz", "cannot be read"),
        (tmp_path / "nothing.csv", "expected an .npz or a .parquet"),
        ([{**good, "done": 20 * [True]}], "too few"),
    ]
    for episodes, words in wrong:
        if words == "different":
            continue
        with pytest.raises(gw.InputError, match=words):
            gw.rollouts(episodes)  # type: ignore[arg-type]
    with pytest.raises(gw.InputError, match="there is no joint `elbow`"):
        gw.rollouts([{**good, "names": ["a"]}], "elbow")
    with pytest.raises(gw.InputError, match="2 joints"):
        gw.rollouts([{**good, "torque": np.ones((20, 2)), "velocity": np.ones((20, 2))}], 2)
    with pytest.raises(gw.InputError, match="below zero"):
        gw.rollouts([good], armature=-0.1)
    (tmp_path / "noise.npz").write_bytes(b"PK\x03\x04" + bytes(1000))
    with pytest.raises(gw.InputError):
        gw.rollouts(tmp_path / "noise.npz")
