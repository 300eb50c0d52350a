"""Words in place of files, files in place of words: requirements, designs, logs, studies."""

import csv
import pathlib
import pickle
import sys

import numpy as np
import pytest

import gearwise as gw
from conftest import ROOT, leg

SHIPPED = sorted((ROOT / "requirements").glob("*.toml"))


def number(value: float | None) -> float:
    """A number that is known."""
    assert value is not None
    return value


def logs_of(folder: pathlib.Path, pattern: str) -> dict[str, dict[str, np.ndarray]]:
    """CSV files as arrays."""
    logs = {}
    for path in folder.glob(pattern):
        rows = list(csv.reader(line for line in path.open() if not line.startswith("#")))
        columns = zip(*rows[1:], strict=True)
        logs[path.name] = {name: np.array(column, dtype=float) for name, column in zip(rows[0], columns, strict=True)}
    return logs


@pytest.mark.skipif(sys.version_info < (3, 11), reason="tomllib")
@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_every_shipped_requirement_as_words(path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import tomllib

    # Cases, transmissions, mechanisms, springs, families: what a file can say a mapping can say.
    monkeypatch.chdir(path.parent)
    words = tomllib.loads(path.read_text())
    assert gw.optimize(words, only_top=1).to_dict()["joints"] == gw.optimize(path, only_top=1).to_dict()["joints"]


def test_modules_and_turns() -> None:
    time = np.linspace(0.0, 0.5, 51)
    motion = gw.Motion(time, 4.0 * np.sin(4 * np.pi * time), 3.0 * np.cos(4 * np.pi * time))
    bus = gw.Bus("24 V", drive_current="40 A")
    modules = gw.optimize(gw.Robot("arm", bus, [gw.Joint("elbow", motion, modules=["damiao-*"], objective="mass")]))
    assert modules["elbow"].best.motor.startswith("damiao-")
    wound = gw.Joint("elbow", motion, ratio=(3, 30), gear=gw.Gear(0.95), turns={"min": 0.5, "max": 2}, objective="loss")
    found = gw.optimize(gw.Robot("arm", bus, [wound]))
    # Among more windings there is no worse one.
    plain = gw.optimize(gw.Robot("arm", bus, [gw.Joint("elbow", motion, ratio=(3, 30), gear=gw.Gear(0.95), objective="loss")]))
    assert number(found["elbow"].best.loss_w) <= number(plain["elbow"].best.loss_w) * (1 + 1e-9)


def test_rules_are_kept_and_checked_without_a_file(tmp_path: pathlib.Path) -> None:
    plain = gw.optimize(leg(objective="loss"))["knee"].best
    # Half of what the first choice reflects is a rule of one's own; it is kept, and the check says so.
    rules = tmp_path / "rules.toml"
    most = 0.5 * number(plain.reflected_inertia_kgm2)
    rules.write_text(
        f'[[rule]]\nname = "light"\nmeasure = "reflected_inertia"\nmax = "{most} kg*m^2"\nreason = "what the foot feels"\n'
    )
    kept = gw.optimize(leg(objective="loss"), rules=rules)
    best = kept["knee"].best
    assert number(best.reflected_inertia_kgm2) <= most * (1 + 1e-9)
    assert number(best.loss_w) > number(plain.loss_w)
    assert gw.check(kept, rules=rules).satisfied
    # Without the rules the first choice breaks them.
    broken = gw.check(gw.optimize(leg(objective="loss")), rules=rules, strict=True)
    assert not broken.satisfied and "light" in broken.text() and "the choice joint" in broken.text()


def test_a_choice_is_checked_as_its_design_file(tmp_path: pathlib.Path) -> None:
    asked = gw.Requirement(leg())
    found = gw.optimize(asked)
    best = found["knee"].best
    path, *_ = asked.save(tmp_path / "leg.toml")[-1:]
    design = tmp_path / "design.toml"
    design.write_text(
        f'requirement = "{pathlib.Path(path).name}"\n[[joint]]\nname = "knee"\nmotor = "{best.motor}"\nratio = {best.ratio!r}\n'
    )
    of_choice, of_file = gw.check(found), gw.check(design)
    assert of_choice.satisfied == of_file.satisfied

    def said(answer: gw.Answer) -> list[tuple[str, str]]:
        return [(f["name"], f["message"]) for f in answer.to_dict()["findings"]]

    assert said(of_choice) == said(of_file)
    with pytest.raises(gw.InputError, match="chose"):
        gw.check(gw.audit())  # type: ignore[arg-type]
    nothing = gw.optimize(leg(1e4))
    with pytest.raises(gw.InputError, match="has no design"):
        gw.check(nothing)


def test_a_saved_requirement_answers_the_same(tmp_path: pathlib.Path) -> None:
    time = np.linspace(0.0, 0.5, 51)
    torque, speed = 10.0 * np.sin(4 * np.pi * time), 8.0 * np.cos(4 * np.pi * time)
    walk = gw.Motion(time, torque, speed)
    once = gw.Motion(time, torque, speed, periodic=False)
    open_ended = gw.Motion(time[:-1], torque[:-1], speed[:-1], period="0.5 s")
    points = gw.Motion.points([18.0, 2.0], [0.0, 9.0], duration=[0.1, 0.4])
    joints = [
        gw.Joint("hip", walk, ratio=(3, 30), objective="loss"),
        gw.Joint("knee", walk.scaled(torque=0.8, speed=1.1), ratio=(3, 30), scale={"torque": 0.9}, objective="loss"),
        gw.Joint("heel", once, repeat_every="3 s", ratio=(3, 30), objective="loss"),
        gw.Joint("toe", open_ended, ratio=(3, 30), objective="loss"),
        gw.Joint("arm", points, ratio=(3, 30), objective="loss"),
        gw.Joint(
            "back",
            case=[{"name": "walk", "motion": walk, "share": 0.6}, {"name": "hold", "motion": points, "share": 0.4}],
            ratio=(3, 30),
            objective="loss",
        ),
    ]
    asked = gw.Requirement(gw.Robot("six ways", gw.Bus("48 V", drive_current="60 A"), joints))
    files = [pathlib.Path(path) for path in asked.save(tmp_path / "robot.toml")]
    assert files[-1] == tmp_path / "robot.toml" and {path.suffix for path in files[:-1]} == {".csv"}
    first, again = gw.optimize(asked, only_top=2), gw.optimize(tmp_path / "robot.toml", only_top=2)
    for joint in asked.joints:
        a, b = first[joint].best, again[joint].best
        assert a.motor == b.motor, joint
        assert [a.ratio, a.loss_w] == pytest.approx([b.ratio, b.loss_w], rel=1e-9)
    # Saved again it is the same, to the byte.
    texts = [path.read_bytes() for path in files]
    asked.save(tmp_path / "robot.toml")
    assert [path.read_bytes() for path in files] == texts


def test_what_cannot_be_saved_says_why(tmp_path: pathlib.Path) -> None:
    time = np.linspace(0.0, 1.0, 200)
    motion = gw.rollouts([{"time": time, "torque": np.sin(9 * time), "velocity": np.cos(9 * time)}])
    robot = gw.Robot("r", gw.Bus("48 V", drive_current="40 A"), [gw.Joint("knee", motion, ratio=(3, 30))])
    with pytest.raises(gw.InputError, match="`knee`: no file holds a motion of episodes"):
        gw.Requirement(robot).save(tmp_path / "r.toml")
    hip = gw.Requirement(ROOT / "requirements/exoskeleton_hip.toml").replace({"bus.voltage": "40 V"})
    with pytest.raises(gw.InputError, match="save it in"):
        hip.save(tmp_path / "hip.toml")
    with pytest.raises(gw.InputError, match="cannot write"):
        gw.Requirement(leg()).save(tmp_path / "no such folder" / "leg.toml")
    assert list(tmp_path.iterdir()) == []


def test_motions_come_back_from_a_pickle_as_they_are(tmp_path: pathlib.Path) -> None:
    time = np.linspace(0.0, 1.0, 200)
    episodes = gw.rollouts([{"time": time, "torque": 9 * np.sin(9 * time), "velocity": 5 * np.cos(9 * time)}])
    read = gw.Motion.read(ROOT / "requirements/motions/quadruped_trot_knee.csv")
    for motion in (episodes, read, episodes.scaled(torque=0.5), read.scaled(speed=1.5)):
        robot = gw.Robot("r", gw.Bus("24 V", drive_current="40 A"), [gw.Joint("knee", motion, ratio=(3, 30), objective="loss")])
        copy = pickle.loads(pickle.dumps(gw.Requirement(robot)))
        assert gw.optimize(copy).to_dict()["joints"] == gw.optimize(robot).to_dict()["joints"]


def test_answers_go_into_other_processes() -> None:
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing import get_context

    asked = gw.Requirement(leg())
    here = gw.optimize(asked)
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        there = pool.submit(gw.optimize, asked, threads=1).result()
    assert there.to_json() == here.to_json() and there.satisfied and there.text() == here.text()
    assert there["knee"].best == here["knee"].best and there["knee"].best.ratio == here["knee"].best.ratio
    assert len(there["knee"].candidates) == len(here["knee"].candidates) and there.warnings == here.warnings
    assert len(there["knee"]) == len(here["knee"]) and there.to_dict() == here.to_dict()
    for use in (there.html, lambda: there.figure().png(), lambda: gw.export(there, "json"), lambda: gw.check(there), lambda: there.text(why=True)):
        with pytest.raises(gw.InputError, match="came from another process"):
            use()
    again = pickle.loads(pickle.dumps(pickle.loads(pickle.dumps(there))))
    assert again.to_json() == here.to_json()
    nothing = pickle.loads(pickle.dumps(gw.optimize(leg(1e4))))
    with pytest.raises(gw.NoDesign, match="nearest"):
        nothing["knee"].best
    at = gw.evaluate(asked, None, [9.0, 12.0])
    copy = pickle.loads(pickle.dumps(at))
    for name in ("loss_w", "margin", "sample", "feasible", "judged", "ratio"):
        np.testing.assert_array_equal(getattr(copy, name), getattr(at, name))
    assert copy.motors == at.motors and copy.limits == at.limits and copy.unusable == at.unusable
    able = gw.actuator_map(["t-motor-ri50"], [9.0], bus=gw.Bus("24 V"))
    map_copy = pickle.loads(pickle.dumps(able))
    np.testing.assert_array_equal(map_copy.peak_torque_nm, able.peak_torque_nm)
    np.testing.assert_array_equal(map_copy.envelope([0.0, 5.0])[0], able.envelope([0.0, 5.0])[0])
    assert "proved" in here.text(why=True) and len(here.text(why=True)) > len(here.text())


def test_logs_of_arrays_are_those_of_files(tmp_path: pathlib.Path) -> None:
    bench = ROOT / "requirements/bench/leg_actuator.toml"
    logs = logs_of(bench.parent, "leg_actuator_*.csv")
    assert len(logs) == 3
    alone = tmp_path / "bench.toml"
    alone.write_text(bench.read_text())
    of_files, of_arrays = gw.identify(bench).to_dict(), gw.identify(alone, logs=logs).to_dict()
    # The hashes are of what was read.
    assert of_files["effects"] == of_arrays["effects"] and of_files["parameters"] == of_arrays["parameters"]
    with pytest.raises(gw.InputError, match="leg_actuator_2.csv"):
        gw.identify(alone, logs={"leg_actuator_1.csv": logs["leg_actuator_1.csv"]})
    with pytest.raises(gw.InputError, match="names no log `leg_actuator_4.csv`"):
        gw.identify(bench, logs={"leg_actuator_4.csv": logs["leg_actuator_1.csv"]})
    bad = {name: dict(columns) for name, columns in logs.items()}
    name = next(iter(bad["leg_actuator_1.csv"]))
    bad["leg_actuator_1.csv"][name] = np.full(len(bad["leg_actuator_1.csv"][name]), np.nan)
    with pytest.raises(gw.InputError, match="leg_actuator_1.csv") as caught:
        gw.identify(alone, logs=bad)
    assert "/tmp" not in str(caught.value).replace(str(tmp_path), "")
    for wrong, said in [
        ({"leg_actuator_1.csv": {"t": [[1.0, 2.0]]}}, "no list of numbers"),
        ({"leg_actuator_1.csv": {}}, "has no columns"),
        ({"leg_actuator_1.csv": [1, 2]}, "no mapping of columns"),
        ([1], "no mapping of files"),
        ({"leg_actuator_1.csv": {"\ud800": [1.0]}}, "cannot be printed"),
    ]:
        with pytest.raises(gw.InputError, match=said):
            gw.identify(alone, logs=wrong)  # type: ignore[arg-type]
    # What is masked is missing.
    masked = {file: dict(columns) for file, columns in logs.items()}
    holes = {file: dict(columns) for file, columns in logs.items()}
    for name, values in logs["leg_actuator_1.csv"].items():
        if "cur" in name or "i" in name.split("_"):
            gone = np.arange(len(values)) % 37 == 5
            masked["leg_actuator_1.csv"][name] = np.ma.masked_array(np.where(gone, -999.0, values), mask=gone)
            holes["leg_actuator_1.csv"][name] = np.where(gone, np.nan, values)
            break
    assert gw.identify(alone, logs=masked).to_dict()["rows"] == gw.identify(alone, logs=holes).to_dict()["rows"]


def test_nothing_is_learnt_from_nothing(tmp_path: pathlib.Path) -> None:
    bench = ROOT / "requirements/bench/leg_actuator.toml"
    logs = logs_of(bench.parent, "leg_actuator_*.csv")
    still = {file: {name: v if name.startswith("t") else np.full(len(v), 1.0) for name, v in c.items()} for file, c in logs.items()}
    found = gw.identify(bench, logs=still)
    assert "Nothing can be learnt" in found.text() and not found.satisfied
    assert gw.identify(bench).satisfied


def test_rows_of_arrays_are_those_of_files(tmp_path: pathlib.Path) -> None:
    bench = ROOT / "requirements/bench/motor_on_bench.toml"
    alone = tmp_path / "bench.toml"
    alone.write_text(bench.read_text())
    given = gw.characterize(alone, logs=logs_of(bench.parent, "motor_on_bench_*.csv"))
    of_files = gw.characterize(bench)
    assert given.to_dict()["tests"] == of_files.to_dict()["tests"]
    # But for what it was read from, the row is the same.
    rows = [{**answer.to_dict()["row"], "source": None} for answer in (given, of_files)]
    assert rows[0] == rows[1] and "bench.toml" in given.to_dict()["row"]["source"]


def test_a_study_in_shards_is_that_of_the_command(tmp_path: pathlib.Path, program: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import subprocess

    monkeypatch.chdir(ROOT)
    file = "requirements/studies/quadruped.toml"
    subprocess.run([program, "study", file, "--out", tmp_path / "command"], check=True, capture_output=True)
    whole = gw.study(file, out=tmp_path / "whole")
    parts = [tmp_path / f"part{k}" for k in (1, 2, 3)]
    shards = [gw.study(file, out=part, shard=(k, 3), threads=1) for k, part in enumerate(parts, 1)]
    assert sum(shard.to_dict()["robots"] for shard in shards) == whole.to_dict()["robots"] == 18
    merged = gw.merge(tmp_path / "merged", parts)
    for name in ("results.csv", "summary.json", "errors.csv", "inputs.csv"):
        texts = {(tmp_path / folder / name).read_bytes() for folder in ("command", "whole", "merged")}
        assert len(texts) == 1, name
    assert whole.satisfied and merged.to_json() == whole.to_json()
    assert len(whole.table()) == len((tmp_path / "whole/results.csv").read_text().splitlines()) - 1
    with pytest.raises(gw.InputError, match="results already"):
        gw.study(file, out=tmp_path / "whole")
    again = gw.study(file, out=tmp_path / "whole", resume=True)
    assert again.to_json() == whole.to_json()


def test_the_cluster_script_uses_the_package(tmp_path: pathlib.Path) -> None:
    import os
    import subprocess

    study = tmp_path / "study.toml"
    base = ROOT / "requirements/exoskeleton_hip.toml"
    study.write_text(f'requirement = "{base}"\n[grid]\n"bus.voltage" = ["36 V", "48 V"]\n"scale.torque" = [0.8, 1]\n')
    script: list[str | pathlib.Path] = [sys.executable, ROOT / "tools/gearwise_cluster.py"]
    script += ["--shards", "2", "--out", tmp_path / "out"]
    # The package is where this one is; a program is nowhere.
    paths = os.pathsep.join([str(pathlib.Path(gw.__file__).parents[1]), *sys.path])
    environment = {**os.environ, "PATH": str(tmp_path), "PYTHONPATH": paths}
    done = subprocess.run([*script, "--", study], env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    gw.study(study, out=tmp_path / "alone")
    assert (tmp_path / "out/results.csv").read_bytes() == (tmp_path / "alone/results.csv").read_bytes()
    named = subprocess.run([*script, "--gearwise", "no-such-program", "--", study], env=environment, capture_output=True, text=True)
    assert named.returncode == 2 and "no-such-program" in named.stderr


def test_a_study_of_words_over_a_grid(tmp_path: pathlib.Path) -> None:
    seen: list[tuple[int, int]] = []
    answer = gw.study(
        leg(objective="loss"),
        {"bus.voltage": [36.0, "48 V"], "scale.torque": np.array([0.8, 1.0]), "joint.knee.limits.safety": [1, 1.2]},
        out=tmp_path / "out",
        top=1,
        progress=lambda done, of: seen.append((done, of)),
    )
    rows = answer.table().columns()
    assert len(answer.table()) == 8 and seen[-1] == (8, 8)
    at = {(v, s, f): k for k, (v, s, f) in enumerate(zip(rows["grid_bus_voltage"], rows["grid_scale_torque"], rows["grid_joint_knee_limits_safety"], strict=True))}
    for (voltage, scale, safety), row in at.items():
        changes = {"bus.voltage": str(voltage) if "V" in str(voltage) else float(voltage), "scale.torque": float(scale), "joint.knee.limits.safety": float(safety)}
        best = gw.optimize(gw.Requirement(leg(objective="loss")).replace(changes), only_top=1)["knee"].best
        assert best.motor == rows["motor"][row] and best.ratio == pytest.approx(float(rows["ratio"][row]), rel=1e-9)
    # Another requirement does not take its place unasked, and is not left behind.
    before = sorted((tmp_path / "out").iterdir())
    with pytest.raises(gw.InputError, match="another"):
        gw.study(leg(2.0), out=tmp_path / "out", resume=True)
    with pytest.raises(gw.InputError, match="results already"):
        gw.study(leg(2.0), out=tmp_path / "out")
    assert sorted((tmp_path / "out").iterdir()) == before
    gw.study(leg(2.0), out=tmp_path / "out", force=True)
    for grid, said in [
        ({"bus.voltag": [48.0]}, "voltag"),
        ({"bus.voltage": 48.0}, "list"),
        ({"bus.voltage": []}, "empty"),
        ({"scale.torqe": [1.0]}, "torqe"),
        ({"bus.voltage": ["fast"]}, "fast"),
        ({"joint.knee.motion": [gw.Motion.points([1.0], [0.0])]}, "has motions"),
        ({"bus.voltage": None}, "None"),
    ]:
        with pytest.raises(gw.InputError, match=said):
            gw.study(leg(), grid, out=tmp_path / "wrong")  # type: ignore[arg-type]
    # A mistake leaves nothing that a corrected call would stumble over.
    assert gw.study(leg(2.0), {"bus.voltage": [48.0]}, out=tmp_path / "wrong").satisfied
    for shard in ((0, 3), (4, 3), (-1, 3), ("1", "3"), (1.5, 3), (1, 3, 2), 2):
        with pytest.raises(gw.InputError, match="shard"):
            gw.study(SHIPPED[0], out=tmp_path / "wrong", shard=shard)  # type: ignore[arg-type]
    for top in (0, -1):
        with pytest.raises(gw.InputError, match="`top`"):
            gw.study(SHIPPED[0], out=tmp_path / "wrong", top=top)
    (tmp_path / "afile").write_text("")
    with pytest.raises(gw.InputError, match="cannot write"):
        gw.study(leg(), out=tmp_path / "afile/x")
    with pytest.raises(gw.InputError, match="no shards"):
        gw.merge(tmp_path / "merged", [])


def test_a_study_of_a_file_is_of_what_was_read(tmp_path: pathlib.Path) -> None:
    gw.Requirement(leg(objective="loss")).save(tmp_path / "leg.toml")
    read = gw.Requirement(tmp_path / "leg.toml")
    changed = read.replace({"bus.voltage": 30, "joint.knee.limits.safety": 1.3})
    rows = gw.study(changed, {"scale.torque": [0.5, 1.0]}, out=tmp_path / "out", top=1).table().columns()
    for scale, motor, ratio in zip(rows["grid_scale_torque"], rows["motor"], rows["ratio"], strict=True):
        best = gw.optimize(changed.replace({"scale.torque": float(scale)}), only_top=1)["knee"].best
        assert best.motor == motor and best.ratio == pytest.approx(float(ratio), rel=1e-9)
    gw.Requirement(leg(2.0)).save(tmp_path / "leg.toml")
    with pytest.raises(gw.InputError, match="has changed since"):
        gw.study(read, out=tmp_path / "again")

def test_a_study_that_is_stopped_goes_on(tmp_path: pathlib.Path) -> None:
    class Enough(Exception):
        pass

    def progress(done: int, of: int) -> None:
        if done > 2:
            raise Enough

    grid = {"scale.torque": list(np.linspace(0.5, 1.0, 60)), "scale.speed": list(np.linspace(0.8, 1.0, 10))}
    with pytest.raises(Enough):
        gw.study(leg(), grid, out=tmp_path / "out", progress=progress)
    begun: list[int] = []
    answer = gw.study(leg(), grid, out=tmp_path / "out", resume=True, progress=lambda done, of: begun.append(done))
    assert begun[0] > 0 and answer.to_dict()["robots"] == 600
