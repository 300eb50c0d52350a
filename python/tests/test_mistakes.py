"""Wrong input: one clear error with its place, nothing assumed."""

import math

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import gearwise as gw
from conftest import leg


def refused(make: object) -> gw.InputError:
    """The error that something raises."""
    with pytest.raises(gw.InputError) as caught:
        make()  # type: ignore[operator]
    return caught.value


def test_all_mistakes_at_once_with_their_keys() -> None:
    joint = {"name": "knee", "points": [{"torque": 1, "speed": "3 rmp"}], "ratio": {"min": 30, "max": 3}}
    error = refused(lambda: gw.Requirement({"name": "leg", "bus": {"voltag": 48}, "joint": [joint]}))
    keys = [problem.key for problem in error.problems]
    assert 'joint "knee".points[0].speed' in keys and 'joint "knee".ratio.max' in keys and "bus.voltag" in keys
    assert "did you mean `voltage`" in str(error) and all(problem.file is None for problem in error.problems)
    assert len(error.problems) >= 4


def test_a_file_has_lines(tmp_path: object) -> None:
    path = tmp_path / "leg.toml"  # type: ignore[operator]
    path.write_text('name = "leg"\n[bus]\nvoltage = 48\n')
    error = refused(lambda: gw.optimize(path))
    # In a file a bare number is no quantity.
    bare = next(problem for problem in error.problems if "has no unit" in problem.message)
    assert (bare.line, bare.column, bare.key) == (3, 11, None) and bare.file == str(path)


def test_a_bare_temperature_is_kelvin() -> None:
    assert gw.optimize(leg(limits=gw.Limits(winding_temperature=383.15)), only_top=1).satisfied
    error = refused(lambda: gw.optimize(leg(limits=gw.Limits(winding_temperature=110))))
    assert 'did you mean "110 degC"' in str(error)
    error = refused(lambda: gw.actuator_map(None, [9], bus=gw.Bus("24 V"), ambient=25))
    assert 'did you mean "25 degC"' in str(error)


def test_changes_are_checked(robot: gw.Robot) -> None:
    asked = gw.Requirement(robot)
    assert "did you mean `voltage`" in str(refused(lambda: asked.replace({"bus.voltag": 36})))
    assert "None is no value" in str(refused(lambda: asked.replace({"bus.voltage": None})))
    assert "names no `joint`" in str(refused(lambda: asked.replace({"joint.hip.limits.safety": 1.3})))
    assert "kelvin" in str(refused(lambda: asked.replace({"ambient.temperature": 40})))
    refused(lambda: asked.replace({"scale.torque": "much"}))
    refused(lambda: asked.replace({'bus."voltage': 1}))
    assert gw.optimize(asked.replace({"bus.voltage": 36.0}), only_top=1).robot["set"] == [
        {"key": "bus.voltage", "value": "36.0"}
    ]
    # The same key twice is the last value, and the first requirement stays what it was.
    twice = asked.replace({"bus.voltage": 36.0}).replace({"bus.voltage": "48 V"})
    assert gw.optimize(twice)["knee"].best.ratio == gw.optimize(asked)["knee"].best.ratio


def test_motions_are_checked() -> None:
    time = np.linspace(0, 1, 11)
    ones = np.ones(11)
    wave = np.sin(2 * np.pi * time)
    bad = {
        "9 entries": lambda: gw.Motion(time, ones[:9], wave),
        "needs `velocity` or `position`": lambda: gw.Motion(time, ones),
        "does not increase": lambda: gw.Motion(time[::-1], ones, wave),
        "`torque`, sample 3: NaN": lambda: gw.Motion(time, np.where(time == time[3], np.nan, ones), wave),
        "repeats its first row": lambda: gw.Motion(time, ones, time),
        "longer than its period": lambda: gw.Motion(time, ones, wave, period=0.5),
        "a period of -1": lambda: gw.Motion(time, ones, wave, period=-1.0),
        "too few": lambda: gw.Motion([0.0, 1.0], [1.0, 1.0], [0.0, 0.0]),
        "no samples": lambda: gw.Motion([], [], []),
        "one axis": lambda: gw.Motion(time.reshape(1, -1), ones, wave),
        "no array of numbers": lambda: gw.Motion(time, ["a"] * 11, wave),
        "is no number of a motion": lambda: gw.Motion(time, 1e300 * ones, wave),
        "not the rate of": lambda: gw.Motion(time, ones, 100 * wave, position=-np.cos(2 * np.pi * time)),
        "not greater than zero": lambda: gw.Motion.points([1.0], [1.0], duration=[0.0]),
        "no operating point": lambda: gw.Motion.points([], []),
        "expected a factor": lambda: gw.Motion(time, ones, wave).scaled(torque=0.0),
        "happens once": lambda: gw.Motion(time, ones, wave, periodic=False, period=2.0),
    }
    for words, make in bad.items():
        assert words in str(refused(make)), words
    assert "says nothing of a motion that is handed over" in str(refused(lambda: gw.Requirement(leg(periodic=True))))


def test_wrong_types_are_input_errors(robot: gw.Robot) -> None:
    for thing in (3, None, [1], object(), b"leg.toml", {"name": object()}, {1: 2}, {"bus": {"voltage": 10**30}}):
        refused(lambda thing=thing: gw.optimize(thing))
    deep: dict[str, object] = {}
    deep["name"] = deep
    refused(lambda: gw.Requirement(deep))
    refused(lambda: gw.optimize(robot, only_top=0))
    refused(lambda: gw.optimize(robot, threads=0))
    refused(lambda: gw.optimize(robot, catalog="motors.csv"))  # type: ignore[arg-type]
    refused(lambda: gw.sweep(robot, ratios=0))
    refused(lambda: gw.pareto(robot, "loss"))
    refused(lambda: gw.pareto(robot, "loss", "weight"))
    refused(lambda: gw.rank(by="weight"))
    refused(lambda: gw.rank(tolerance=2.0))
    refused(lambda: gw.compare("t-motor-ri50", "nothing"))
    refused(lambda: gw.compare("t-motor-ri50", "t-motor-u8", inertia=-1.0))
    refused(lambda: gw.explain("t-motor-ri50@x", robot))
    refused(lambda: gw.check("nothing.toml"))
    refused(lambda: gw.identify("nothing.toml"))
    refused(lambda: gw.characterize("nothing.toml"))


def test_a_list_of_many_and_a_large_file(tmp_path: object) -> None:
    path = tmp_path / "noise.toml"  # type: ignore[operator]
    path.write_bytes(bytes(np.random.default_rng(1).integers(0, 256, 10_000_000, dtype=np.uint8)))
    refused(lambda: gw.optimize(path))
    refused(lambda: gw.Catalog(path))
    refused(lambda: gw.Requirement({"name": "x", "bus": {"voltage": 1}, "joint": [{}] * 200_000}))


SCALARS = st.one_of(
    st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=12), st.sampled_from(["48 V", "3 N*m", "loss"])
)
KEYS = st.sampled_from(
    ["name", "bus", "voltage", "joint", "ratio", "min", "max", "gear", "efficiency", "limits", "motion", "points", "torque",
     "speed", "objective", "gears", "modules", "turns", "case", "transmission", "spring", "count", "phases", "budget"]
)  # fmt: skip
VALUES = st.recursive(
    SCALARS, lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(KEYS, inner, max_size=5)), max_leaves=25
)


@settings(max_examples=300, deadline=None, suppress_health_check=list(HealthCheck))
@given(st.dictionaries(KEYS, VALUES, max_size=6))
def test_no_mapping_gives_anything_but_a_requirement_or_an_error(mapping: dict[str, object]) -> None:
    try:
        gw.Requirement(mapping)
    except gw.GearwiseError as error:
        assert not isinstance(error, gw.InternalError) and str(error)


@settings(max_examples=150, deadline=None, suppress_health_check=list(HealthCheck))
@given(st.dictionaries(KEYS, VALUES, max_size=3), st.sampled_from(["bus", "joint.knee", "joint.knee.limits", "joint.*"]))
def test_no_change_gives_anything_but_a_requirement_or_an_error(mapping: dict[str, object], under: str) -> None:
    asked = gw.Requirement(leg())
    try:
        asked.replace({f"{under}.{key}": value for key, value in mapping.items()})
    except gw.GearwiseError as error:
        assert not isinstance(error, gw.InternalError) and str(error)


ARRAYS = hnp.arrays(
    dtype=st.sampled_from([np.float64, np.float32, np.int32, np.uint8, np.bool_, np.complex128]),
    shape=hnp.array_shapes(min_dims=0, max_dims=2, max_side=12),
)


@settings(max_examples=300, deadline=None, suppress_health_check=list(HealthCheck))
@given(ARRAYS, ARRAYS, ARRAYS, st.booleans())
def test_no_array_gives_anything_but_a_motion_or_an_error(
    time: object, torque: object, velocity: object, periodic: bool
) -> None:
    try:
        motion = gw.Motion(time, torque, velocity, periodic=periodic)  # type: ignore[arg-type]
    except gw.GearwiseError as error:
        assert not isinstance(error, gw.InternalError)
    else:
        assert len(motion) > 1 and all(math.isfinite(value) for value in motion.acceleration)


@settings(max_examples=100, deadline=None, suppress_health_check=list(HealthCheck))
@given(st.dictionaries(st.text(max_size=20), st.lists(SCALARS, max_size=4), max_size=5))
def test_no_frame_gives_anything_but_a_catalogue_or_an_error(columns: dict[str, list[object]]) -> None:
    try:
        gw.Catalog.from_frame(columns)
    except gw.GearwiseError as error:
        assert not isinstance(error, gw.InternalError)


def test_words_that_are_of_another_kind_say_what_is_meant() -> None:
    points = [{"torque": 1.0, "speed": 1.0}]
    for ratio in ([3, 30], 9, (1, 2, 3), "9"):
        with pytest.raises(gw.InputError, match="expected \\(least, most\\)"):
            gw.Requirement(gw.Robot("r", gw.Bus(48), [gw.Joint("k", points=points, ratio=ratio)]))  # type: ignore[arg-type]
    with pytest.raises(gw.InputError, match="expected a Bus"):
        gw.Requirement(gw.Robot("r", "48 V", [gw.Joint("k", points=points, ratio=(3, 30))]))  # type: ignore[arg-type]
    two = gw.Robot("r", gw.Bus(48), [gw.Joint(name, points=points, ratio=(3, 30), objective="loss") for name in "ab"])
    with pytest.raises(gw.InputError) as caught:
        gw.evaluate(two, None, [9.0])
    assert "--" not in str(caught.value) and "joint" in str(caught.value)
    with pytest.raises(gw.InputError, match="`instant`"):
        gw.evaluate(two, None, [9.0], joint="a", limits="instants")
    best = gw.optimize(two, only_top=1)["a"].best
    with pytest.raises(AttributeError, match="`loss_w`"):
        getattr(best, "loss")
