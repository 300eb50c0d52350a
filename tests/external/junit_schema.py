"""JUnit output of `gearwise check` against the public schema of Jenkins' xunit plugin (tests/fixtures/schemas/junit-10.xsd).

Usage: junit_schema.py PATH/TO/gearwise, from the root of the repository. Needs the package `xmlschema`.
"""

import pathlib
import subprocess
import sys
import tempfile

import xmlschema

ROOT = pathlib.Path(__file__).resolve().parents[2]
NAME = "a<b>&\\\"c\\\" é√ 100%"

ROBOT = f"""name = "{NAME}"
[bus]
voltage = "24 V"
drive_current = "10 A"
[[joint]]
name = "{NAME}"
ratio = {{ min = 3, max = 30 }}
points = [ {{ torque = "30 N*m", speed = "20 rad/s", duration = "1 s" }} ]
"""
DESIGN = f"""requirement = "robot.toml"
[[joint]]
name = "{NAME}"
motor = "t-motor-ri50"
ratio = 9
"""


def main():
    program = pathlib.Path(sys.argv[1]).resolve()
    schema = xmlschema.XMLSchema(str(ROOT / "tests/fixtures/schemas/junit-10.xsd"))
    designs = sorted((ROOT / "requirements/designs").glob("*/design.toml"))
    assert designs, "there are shipped designs"
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        (folder / "robot.toml").write_text(ROBOT, encoding="utf-8")
        (folder / "design.toml").write_text(DESIGN, encoding="utf-8")
        failing = folder / "design.toml"
        for design in [*designs, failing]:
            out = folder / "out.xml"
            status = subprocess.run([program, "check", design, "--junit", out], capture_output=True).returncode
            assert status == (1 if design == failing else 0), (design, status)
            schema.validate(str(out))
            print(f"{design.parent.name}/{design.name}: valid")


main()
