"""An answer is that of the command, byte for byte."""

import pathlib
import subprocess
import sys

import pytest

import gearwise as gw
from conftest import ROOT

SHIPPED = sorted((ROOT / "requirements").glob("*.toml"))


def printed(program: pathlib.Path, *words: str) -> str:
    """What a command prints."""
    done = subprocess.run([program, *words], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode in (0, 1), done.stderr
    return done.stdout


def test_there_are_requirements() -> None:
    assert len(SHIPPED) >= 10


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_every_shipped_requirement(path: pathlib.Path, program: pathlib.Path) -> None:
    answer = gw.optimize(path, only_top=2)
    assert answer.to_json() == printed(program, "optimize", str(path), "--json", "--only-top", "2")


def test_other_answers(program: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    hip = "requirements/exoskeleton_hip.toml"
    design = "requirements/designs/quadruped_mini_cheetah/design.toml"
    bench = "requirements/bench/motor_on_bench.toml"
    pairs: list[tuple[gw.Answer, list[str]]] = [
        (gw.optimize(hip), ["optimize", hip]),
        (gw.sweep(hip, ratios=3), ["sweep", hip, "--ratios", "3"]),
        (gw.explain("t-motor-ri50@9", hip), ["explain", "t-motor-ri50@9", hip]),
        (gw.pareto(hip, "loss", "mass", points=9), ["optimize", hip, "--pareto", "loss,mass", "--points", "9"]),
        (gw.robust(hip, tolerance=0.05), ["optimize", hip, "--robust", "--tolerance", "5%"]),
        (gw.rank(by="k_m"), ["rank", "--sort", "k_m"]),
        (gw.compare("t-motor-ri50", "t-motor-u8"), ["compare", "t-motor-ri50", "t-motor-u8"]),
        (gw.audit(), ["audit"]),
        (gw.check(design), ["check", design]),
        (gw.characterize(bench), ["characterize", bench]),
    ]
    for answer, words in pairs:
        assert answer.to_json() == printed(program, *words, "--json"), words
        assert answer.to_dict()["command"].split(" ")[0] == words[0]
    exported = ["export", design, "--to", "mjcf"]
    assert gw.export(design, "mjcf") == printed(program, *exported)


def test_identify(program: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    bench = "requirements/bench/leg_actuator.toml"
    assert gw.identify(bench).to_json() == printed(program, "identify", bench, "--json")


def test_values_are_read_as_a_file_is(program: pathlib.Path, tmp_path: pathlib.Path) -> None:
    """The same robot in words of Python and in a file."""
    text = """
name = "leg"
[bus]
voltage = "48 V"
drive_current = "40 A"
[[joint]]
name = "knee"
ratio = { min = 3, max = 30 }
gear = { efficiency = 0.95, mass = "150 g" }
points = [{ torque = "18 N*m", speed = "0 rad/s", duration = "0.5 s" }, { torque = "5 N*m", speed = "9 rad/s", duration = "1 s" }]
[joint.limits]
winding_temperature = "110 degC"
"""
    path = tmp_path / "leg.toml"
    path.write_text(text)
    knee = gw.Joint(
        "knee",
        ratio=(3, 30),
        gear=gw.Gear(0.95, mass=0.15),
        points=[{"torque": 18, "speed": 0, "duration": 0.5}, {"torque": 5.0, "speed": 9.0, "duration": "1 s"}],
        limits=gw.Limits(winding_temperature="110 degC"),
    )
    words = gw.Robot("leg", gw.Bus(48, drive_current=40.0), [knee])
    mapping = {
        "name": "leg",
        "bus": {"voltage": 48.0, "drive_current": "40 A"},
        "joint": [
            {
                "name": "knee",
                "ratio": {"min": 3, "max": 30},
                "gear": {"efficiency": 0.95, "mass": "150 g"},
                "motion": gw.Motion.points([18.0, 5.0], [0.0, 9.0], duration=[0.5, 1.0]),
                "limits": {"winding_temperature": 383.15},
            }
        ],
    }
    wanted = printed(program, "optimize", str(path), "--json")
    assert gw.optimize(path).to_json() == wanted
    assert gw.optimize(words).to_json() == wanted
    assert gw.optimize(mapping).to_json() == wanted


def test_a_file_of_a_motion_and_its_arrays(program: pathlib.Path, tmp_path: pathlib.Path) -> None:
    hip = (ROOT / "requirements/exoskeleton_hip.toml").read_text()
    assert "motion" in hip
    motion = next((ROOT / "requirements/motions").glob("*.csv"))
    import csv

    with motion.open() as file:
        rows = [row for row in csv.reader(line for line in file if not line.startswith("#"))]
    header = [name.strip() for name in rows[0]]
    columns = {name.split(" ")[0]: [float(row[k]) for row in rows[1:]] for k, name in enumerate(header)}
    if not {"time [s]", "torque [N*m]"} <= set(header):
        pytest.skip("the motion is in other units")
    read = gw.Motion.read(motion)
    made = gw.Motion(
        columns["time"],
        columns["torque"],
        columns.get("velocity"),
        position=columns.get("position"),
        acceleration=columns.get("acceleration"),
    )
    assert read == made


def test_the_command_line_is_in_the_package(program: pathlib.Path) -> None:
    words = ["rank", "--top", "3"]
    done = subprocess.run([sys.executable, "-m", "gearwise", *words], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout == printed(program, *words)
    wrong = subprocess.run([sys.executable, "-m", "gearwise", "optimize", "no.toml"], capture_output=True, text=True)
    assert wrong.returncode == 2 and "no such file" in wrong.stderr
