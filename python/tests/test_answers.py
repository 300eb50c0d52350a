"""What answers are in Python."""

import json
import pickle
import typing
import warnings

import numpy as np
import pytest

import gearwise as gw
from conftest import ROOT, leg


def test_attributes_are_the_keys_of_the_json(robot: gw.Robot) -> None:
    answer = gw.optimize(robot)
    joint = answer.to_dict()["joints"][0]
    assert answer["knee"].joint == joint["joint"]
    assert len(answer["knee"].candidates) == len(joint["candidates"]) > 20
    schema = json.loads((ROOT / "docs/schema.json").read_text())["$defs"]["Design"]["properties"]
    stated = set(gw.Design.__annotations__)
    assert stated == set(schema)
    for design, said in zip(answer["knee"].candidates, joint["candidates"]):
        assert design.to_dict() == said
        assert set(said) <= stated
        for key, value in said.items():
            assert getattr(design, key) == (tuple(value) if key == "window" else value)
    with pytest.raises(AttributeError):
        answer["knee"].best.los_w  # type: ignore[attr-defined]
    with pytest.raises(AttributeError):
        answer["knee"].best.loss_w = 1.0


def test_types_of_attributes_hold(robot: gw.Robot) -> None:
    """What the annotations say is what is there."""
    plain = {"float": float, "int": int, "str": str, "bool": bool, "None": type(None)}
    for design in gw.optimize(robot)["knee"].candidates:
        for name, stated in gw.Design.__annotations__.items():
            value = getattr(design, name)
            parts = [part.strip() for part in stated.strip("'\"").split(" | ")]
            fits = [isinstance(value, plain[part]) for part in parts if part in plain]
            fits += ["float" in parts and isinstance(value, int)]
            fits += [part.startswith("Mapping") and isinstance(value, dict) for part in parts]
            fits += [part.startswith(("Sequence", "tuple")) and isinstance(value, (list, tuple)) for part in parts]
            assert any(fits), (name, stated, value)


def test_a_joint_without_a_design_says_what_came_nearest() -> None:
    answer = gw.optimize(leg(40.0))
    assert not answer.satisfied and not len(answer["knee"].candidates)
    with pytest.raises(gw.NoDesign) as caught:
        answer["knee"].best
    assert "the nearest, " in str(caught.value) and "exceeds" in str(caught.value)
    assert isinstance(caught.value, LookupError) and isinstance(caught.value, gw.GearwiseError)
    assert len(answer["knee"].rejected) > 50


def test_whole_robots_and_other_joints(robot: gw.Robot) -> None:
    answer = gw.optimize(robot, whole_robot=True, only_top=3)
    assert answer.robot["choice"]["best"]
    with pytest.raises(KeyError, match="there is no joint `hip`: there are knee"):
        answer["hip"]
    assert list(answer.joints) == ["knee"]


def test_tables_go_to_frames(robot: gw.Robot) -> None:
    answer = gw.optimize(robot)
    table = answer["knee"]
    columns = table.columns()
    assert len(table) == len(columns["motor"]) and columns["loss_w"].dtype == np.float64
    frame = table.to_pandas()
    assert list(frame["motor"][:3]) == [design.motor for design in table.candidates[:3]]
    np.testing.assert_allclose(frame["loss_w"][:3], np.array([design.loss_w for design in table.candidates[:3]], float), rtol=1e-12)
    polars = pytest.importorskip("polars")
    assert polars.DataFrame(table).height == len(table)
    assert polars.DataFrame(table)["loss_w"].null_count() == int(np.isnan(columns["loss_w"]).sum())
    nanoarrow = pytest.importorskip("nanoarrow")
    assert nanoarrow.ArrayStream(table).read_all().schema.type.name == "STRUCT"
    both = gw.optimize(gw.Robot("two", robot.bus, [*robot.joints, gw.Joint("hip", robot.joints[0].motion, ratio=(3, 9))]))  # type: ignore[union-attr]
    assert len(both["knee"]) + len(both["hip"]) == len(both.table())


def test_pages_and_pictures(robot: gw.Robot) -> None:
    hostile = gw.optimize(gw.Robot("<script>alert(1)</script>", robot.bus, robot.joints), only_top=3)
    page = hostile.html()
    assert page.startswith("<!DOCTYPE html>") and "<script>alert" not in page
    shown = hostile._repr_html_()
    assert "<script" not in shown and "<table>" in shown
    assert hostile.figure().svg().startswith("<svg") and hostile.figure().png().startswith(b"\x89PNG")
    data = hostile.figure().data()
    assert data["groups"][0]["panels"][0]["series"][0]["x"]
    with pytest.raises(gw.InputError, match="no figure"):
        gw.audit().figure().svg()
    with pytest.raises(gw.InputError, match="no table"):
        gw.compare("t-motor-ri50", "t-motor-u8").table()


def test_exports_warn(robot: gw.Robot) -> None:
    answer = gw.optimize(robot, only_top=1)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        text = gw.export(answer, "dcmotor")
        weak = gw.export("t-motor-ri50@3", "mjcf", requirement=leg(20.0))
    assert "dcmotor" in text and "motor" in weak
    assert any("is not feasible" in str(warning.message) for warning in said)
    with pytest.raises(gw.InputError, match="did you mean `mjcf`"):
        gw.export(answer, "mjfc")
    with pytest.raises(gw.InputError, match="has no design to export"):
        gw.export(gw.optimize(leg(40.0)), "mjcf")


def test_everything_can_be_pickled(robot: gw.Robot) -> None:
    motion = typing.cast(gw.Motion, robot.joints[0].motion)  # type: ignore[union-attr]
    again = pickle.loads(pickle.dumps(motion))
    assert again == motion and hash(again) == hash(motion)
    scaled = motion.scaled(torque=1.3, speed=0.7)
    assert pickle.loads(pickle.dumps(scaled)) == scaled != motion
    points = gw.Motion.points([1.0, 2.0], [0.0, 3.0])
    assert pickle.loads(pickle.dumps(points)) == points
    asked = gw.Requirement(robot).replace({"bus.voltage": 36.0})
    assert pickle.loads(pickle.dumps(asked)) == asked
    assert gw.optimize(pickle.loads(pickle.dumps(asked))).to_json() == gw.optimize(asked).to_json()
    catalog = gw.Catalog().filter("maxon mass<0.5kg")
    assert len(pickle.loads(pickle.dumps(catalog))) == len(catalog)
    design = gw.optimize(robot)["knee"].best
    assert pickle.loads(pickle.dumps(design)) == design
    assert pickle.loads(pickle.dumps(robot)) == robot


def test_another_version_is_refused() -> None:
    from gearwise import _native

    with pytest.raises(gw.InputError, match="was pickled by gearwise 0.0.1"):
        _native.Requirement._again("0.0.1", "x", "", True, [], {})


def test_catalogues(tmp_path: typing.Any) -> None:
    whole = gw.Catalog()
    few = whole.filter("maxon -flat mass<0.5kg")
    rows = few.columns()
    assert 0 < len(few) < len(whole)
    assert all("maxon" in name and "flat" not in name for name in rows["id"])
    same = whole.filter(lambda row: row["id"] in set(rows["id"]))
    assert list(same.columns()["id"]) == list(rows["id"])
    # A frame is read as the file is that it would be.
    frame = few.to_pandas()
    again = gw.Catalog.from_frame(frame)
    assert list(again.columns()["id"]) == list(rows["id"])
    motion = gw.Motion.points([3.0], [5.0])
    ask = gw.Robot("r", gw.Bus("24 V", drive_current="20 A"), [gw.Joint("k", motion, ratio=(3, 30))])
    one, two = gw.optimize(ask, catalog=few), gw.optimize(ask, catalog=again)
    assert [d.to_dict() for d in one["k"].candidates] == [d.to_dict() for d in two["k"].candidates]
    with pytest.raises(gw.InputError, match="column"):
        gw.Catalog.from_frame({"id": ["a"], "mas [kg]": [1.0]})
    with pytest.raises(gw.InputError):
        gw.Catalog(tmp_path / "nothing.csv")
    with pytest.raises(gw.InputError, match="a int is no catalogue"):
        gw.Catalog(3)  # type: ignore[arg-type]
    both = gw.Catalog("builtin", few) if False else gw.Catalog(whole)
    assert len(both) == len(whole)
