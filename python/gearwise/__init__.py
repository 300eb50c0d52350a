"""Choose the motor and the gear ratio of a robot joint, and prove that the choice is the best there is.

    import gearwise as gw
    motion = gw.Motion(time, torque, velocity)                     # s, N m, rad/s; the last sample repeats the first
    knee = gw.Joint("knee", motion, ratio=(3, 30), gear=gw.Gear(0.95, mass="150 g"))
    found = gw.optimize(gw.Robot("leg", gw.Bus("48 V", drive_current="40 A"), [knee]))
    found["knee"].best.motor, found["knee"].best.ratio

Numbers are SI; a text has its unit. docs/python.md has the rest."""

from gearwise._answers import ActuatorMap, Answer, Evaluated, Figure, JointResult, Optimized
from gearwise._calls import (
    actuator_map,
    audit,
    characterize,
    check,
    compare,
    evaluate,
    explain,
    export,
    identify,
    merge,
    optimize,
    pareto,
    rank,
    robust,
    study,
    sweep,
)
from gearwise._catalog import Catalog
from gearwise._design import Design
from gearwise._errors import GearwiseError, InputError, InternalError, NoDesign, Problem
from gearwise._native import Motion, Requirement, __version__
from gearwise._rollouts import rollouts
from gearwise._table import Table
from gearwise._words import Bus, Gear, Joint, Limits, Robot

__all__ = [
    "ActuatorMap",
    "Answer",
    "Bus",
    "Catalog",
    "Design",
    "Evaluated",
    "Figure",
    "Gear",
    "GearwiseError",
    "InputError",
    "InternalError",
    "Joint",
    "JointResult",
    "Limits",
    "Motion",
    "NoDesign",
    "Optimized",
    "Problem",
    "Requirement",
    "Robot",
    "Table",
    "__version__",
    "actuator_map",
    "audit",
    "characterize",
    "check",
    "compare",
    "evaluate",
    "explain",
    "export",
    "identify",
    "merge",
    "optimize",
    "pareto",
    "rank",
    "robust",
    "rollouts",
    "study",
    "sweep",
]
