"""What the tests share."""

import pathlib

import numpy as np
import pytest
from hypothesis import settings

import gearwise as gw

# The same cases in every run.
settings.register_profile("same", derandomize=True)
settings.load_profile("same")

ROOT = pathlib.Path(__file__).parents[2]


def leg(scale: float = 1.0, **words: object) -> gw.Robot:
    """A leg with one joint."""
    time = np.linspace(0.0, 0.5, 51)
    motion = gw.Motion(
        time, scale * 10.0 * np.sin(2 * np.pi * time / 0.5), 8.0 * np.cos(2 * np.pi * time / 0.5)
    )
    knee = gw.Joint("knee", motion, ratio=(3.0, 30.0), gear=gw.Gear(0.95, mass="150 g"), **words)  # type: ignore[arg-type]
    return gw.Robot("leg", gw.Bus("48 V", drive_current="40 A"), [knee])


@pytest.fixture(scope="session")
def robot() -> gw.Robot:
    """A leg with one joint."""
    return leg()


@pytest.fixture(scope="session")
def program() -> pathlib.Path:
    """The program that this checkout has built."""
    found = [path for path in (ROOT / "target/debug/gearwise", ROOT / "target/release/gearwise") if path.exists()]
    import os

    given = os.environ.get("GEARWISE_PROGRAM")
    if given:
        return pathlib.Path(given)
    if not found:
        pytest.skip("the program is not built: cargo build")
    return found[0]
