"""The functions: each answers as the command of its name does.

Every function takes `catalog` (the built-in one by default). Where something long is worked out it takes `threads` (1 inside
workers of joblib, Dask or Ray; by default all of the machine) and `progress` (True for a bar of tqdm, or a function of steps
done and steps there are). The answer is the same for any number of threads. Ctrl-C and an exception of `progress` end a call
within a tenth of a second. Mistakes raise InputError with all of them; a mistake of gearwise raises InternalError."""

from gearwise import _native
from gearwise._answers import ActuatorMap, Answer, Evaluated, Optimized
from gearwise._catalog import Catalog, builtin
from gearwise._errors import InputError
from gearwise._kept import needed

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from os import PathLike
    from typing import Any, Literal, TypeAlias

    from numpy.typing import ArrayLike

    from gearwise._words import Bus, Gear, Robot

    Path: TypeAlias = str | PathLike[str]
    Requirement: TypeAlias = _native.Requirement | Robot | Mapping[str, object] | Path
    Logs: TypeAlias = Mapping[str, Mapping[str, ArrayLike]] | None
    Progress: TypeAlias = bool | Callable[[int, int], object] | None


def _bar(progress: "Progress") -> "Callable[[int, int], object] | None":
    if progress is not True:
        return progress or None
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return None
    bar = tqdm(leave=False)

    def step(done: int, of: int) -> None:
        bar.total = of
        bar.update(done - bar.n)
        if done >= of:
            bar.close()

    return step


def _said(requirement: object) -> str:
    """A requirement as it is named on pages."""
    if isinstance(requirement, (list, tuple)):
        return ", ".join(str(path) for path in requirement)
    if isinstance(requirement, _native.Requirement):
        return requirement.name
    return str(requirement) if isinstance(requirement, str) or hasattr(requirement, "__fspath__") else "requirement"


def optimize(
    requirement: "Requirement",
    *,
    only_top: "int | None" = None,
    only_checked: bool = False,
    whole_robot: bool = False,
    runner_ups: int = 3,
    rules: "Path | None" = None,
    keep_rules: bool = True,
    catalog: "Catalog | None" = None,
    threads: "int | None" = None,
    progress: "Progress" = None,
) -> Optimized:
    """The best motors of each joint, each with its best ratio N*, what binds, margins and proof.

    `only_top`: the first designs of each joint alone; motors that provably are not among them are not solved, which is
    faster. `only_checked`: motors whose rows do not say enough to check every limit are left out. `whole_robot`: the best
    combination for the whole robot, even where nothing couples the joints, with so many `runner_ups`. `rules`: a rules file
    that choices have to keep, in place of the one that the requirement names; `keep_rules=False` looks at none.

    A joint without a design is an answer: `satisfied` is False."""
    answer = _native.optimize(
        requirement,
        builtin(catalog),
        only_top,
        only_checked,
        whole_robot,
        runner_ups,
        rules,
        keep_rules,
        threads,
        _bar(progress),
    )
    return Optimized(answer, f"gearwise.optimize({_said(requirement)})", catalog)


def robust(
    requirement: "Requirement",
    *,
    only_checked: bool = False,
    tolerance: "float | None" = None,
    catalog: "Catalog | None" = None,
    threads: "int | None" = None,
    progress: "Progress" = None,
) -> Answer:
    """Designs that keep all limits over the tolerances of the motors, and how likely the first choice stays first.

    `tolerance`: the +- (95 %) of every number whose row states none, as a share, e.g. 0.05."""
    answer = _native.optimize_robust(
        requirement, builtin(catalog), only_checked, tolerance, threads, _bar(progress)
    )
    return Answer(answer, f"gearwise.robust({_said(requirement)})")


def sweep(
    requirement: "Requirement",
    *,
    ratios: int = 25,
    by: str = "objective",
    catalog: "Catalog | None" = None,
    threads: "int | None" = None,
    progress: "Progress" = None,
) -> Answer:
    """Every motor at so many ratios, evenly spaced in ln N, or with every gear: feasible, or why not. `by` orders."""
    answer = _native.sweep(requirement, builtin(catalog), ratios, by, threads, _bar(progress))
    return Answer(answer, f"gearwise.sweep({_said(requirement)})")


def evaluate(
    requirement: "Requirement",
    motors: "str | Sequence[str] | None",
    ratios: "ArrayLike",
    *,
    joint: "str | None" = None,
    limits: "Literal['all', 'instant'] | Sequence[str]" = "all",
    catalog: "Catalog | None" = None,
    threads: "int | None" = None,
    progress: "Progress" = None,
) -> Evaluated:
    """Motors (None: all that the joint allows) at given ratios N, as arrays: for a search of your own.

    `ratios` has one axis. `joint` may be left out where there is only one. `limits`: all, all but temperature over the
    motion (`"instant"`), which takes the longest, or those of these names."""
    found = _native.evaluate(
        requirement, motors, ratios, joint, limits, builtin(catalog), threads, _bar(progress)
    )
    return Evaluated(found)


def actuator_map(
    motors: "str | Sequence[str] | None",
    ratios: "ArrayLike",
    *,
    bus: "Bus | Mapping[str, object]",
    gear: "Gear | Mapping[str, object] | None" = None,
    ambient: "float | str" = "25 degC",
    catalog: "Catalog | None" = None,
    threads: "int | None" = None,
) -> ActuatorMap:
    """What motors (None: all) can do behind a gear of given ratios N: mass, inertia, loss, torques, speeds, as arrays. No
    motion is needed: for loops in which the motion is still sought. Without `gear` it has no loss, inertia or mass."""
    import numpy

    ratios = numpy.atleast_1d(numpy.asarray(ratios, dtype=float))
    least, most = (float(ratios.min()), float(ratios.max())) if ratios.size else (1.0, 1.0)
    joint: "dict[str, object]" = {
        "name": "actuator",
        "ratio": {"min": least, "max": max(most, least)},
        "points": [{"torque": 0.0, "speed": 0.0}],
        "gear": gear,
        "objective": "loss",
    }
    robot = _native.Requirement(
        {"name": "actuators", "bus": bus, "ambient": {"temperature": ambient}, "joint": [joint]}
    )

    made = _Maps(robot, motors, ratios, catalog, threads)
    return ActuatorMap(made(None), made)


class _Maps:
    """Maps of actuators at speeds, as often as they are asked for, in any process."""

    def __init__(self, *how: "Any") -> None:
        """Of a robot, motors, ratios, a catalogue and a number of threads."""
        self.how = how

    def __call__(self, speed: "ArrayLike | None") -> _native.ActuatorMap:
        import numpy

        robot, motors, ratios, catalog, threads = self.how
        speeds = None if speed is None else numpy.atleast_1d(numpy.asarray(speed, dtype=float))
        return _native.actuator_map(robot, motors, ratios, speeds, builtin(catalog), threads)


def explain(
    design: str,
    requirement: "Requirement",
    *,
    joint: "str | None" = None,
    catalog: "Catalog | None" = None,
    threads: "int | None" = None,
) -> Answer:
    """The whole story of one motor at a joint, feasible or not. `design` is "MOTOR", "MOTOR@RATIO" or "MOTOR@GEAR"."""
    answer = _native.explain(design, requirement, joint, builtin(catalog), threads)
    return Answer(answer, f"gearwise.explain({design}, {_said(requirement)})")


def pareto(
    requirement: "Requirement",
    *quantities: str,
    points: int = 33,
    only_checked: bool = False,
    catalog: "Catalog | None" = None,
    threads: "int | None" = None,
    progress: "Progress" = None,
) -> Answer:
    """The front of two or more quantities, e.g. "loss", "mass", "reflected_inertia": designs of which none has less of one
    without more of another. `points`: so many ratios along each motor's own front."""
    answer = _native.pareto(
        requirement, list(quantities), points, only_checked, builtin(catalog), threads, _bar(progress)
    )
    return Answer(answer, f"gearwise.pareto({_said(requirement)}, {', '.join(quantities)})")


def rank(
    *,
    by: str = "s_m",
    mark: "Sequence[str]" = (),
    modules: "Sequence[str]" = (),
    tolerance: "float | None" = None,
    catalog: "Catalog | None" = None,
) -> Answer:
    """Motors by a metric: s_m, s_t, mass_s_m, mass_s_t, k_m, k_t, … `mark` marks motors in the picture."""
    answer = _native.rank(by, list(mark), list(modules), tolerance, builtin(catalog))
    return Answer(answer, f"gearwise.rank(by={by})")


def compare(a: str, b: str, *, inertia: "float | str | None" = None, catalog: "Catalog | None" = None) -> Answer:
    """Two motors side by side, at an actuator inertia [kg m^2]; by default the larger rotor inertia of the two."""
    return Answer(_native.compare(a, b, inertia, builtin(catalog)), f"gearwise.compare({a}, {b})")


def audit(*, catalog: "Catalog | None" = None) -> Answer:
    """Whether the rows of a catalogue agree with themselves, and what would explain a mismatch."""
    return Answer(_native.audit(builtin(catalog)), "gearwise.audit()")


def check(
    design: "Path | Optimized",
    *,
    rules: "Path | None" = None,
    strict: bool = False,
    catalog: "Catalog | None" = None,
) -> Answer:
    """Whether a design keeps its rules, those of `rules`, or the default ones; `strict`: warnings fail too. `design`: a design
    file, or what `optimize` chose, at the ratios that it found."""
    if isinstance(design, Optimized):
        native = builtin(design._catalog if catalog is None else catalog)
        answer = _native.check(needed(design._of), rules, strict, native)
        return Answer(answer, f"gearwise.check({design._call})")
    if isinstance(design, Answer):
        raise InputError._said("only what `optimize` chose is checked")
    given = None if catalog is None else catalog._catalog
    return Answer(_native.check(design, rules, strict, given), f"gearwise.check({design})")


def _handed(logs: "Logs", folder: str) -> "list[tuple[str, str]]":
    """Arrays as files in a folder, each with the name that the bench file has for it."""
    import os
    import zipfile

    import numpy

    files: "list[tuple[str, str]]" = []
    if not hasattr(logs or {}, "items"):
        raise InputError._said("`logs` is no mapping of files to their columns")
    for place, (name, columns) in enumerate((logs or {}).items()):
        if not hasattr(columns, "items"):
            raise InputError._said(f"`logs`: `{name}` is no mapping of columns to arrays")
        if not columns:
            raise InputError._said(f"`logs`: `{name}` has no columns")
        arrays = {}
        for column, values in columns.items():
            array = numpy.asarray(values)
            # What is masked is missing.
            if numpy.ma.isMaskedArray(values):
                array = numpy.ma.filled(values.astype(float), numpy.nan)
            if "\0" in str(column) or not str(column).isprintable():
                raise InputError._said(f"`logs`: `{name}` has a column whose name cannot be printed")
            if array.ndim != 1 or array.dtype.kind not in "biufUS":
                raise InputError._said(f"`logs`: column `{column}` of `{name}` is no list of numbers or texts")
            arrays[column] = array
        path = os.path.join(folder, f"{place}.npz")
        # A column may have any name, that of an argument of savez too.
        with zipfile.ZipFile(path, "w") as archive:
            for column, array in arrays.items():
                # The time of writing is no part of a log.
                with archive.open(zipfile.ZipInfo(f"{column}.npy"), "w") as file:
                    numpy.lib.format.write_array(file, array, allow_pickle=False)
        files.append((str(name), path))
    return files


def identify(
    bench: "Path",
    *,
    logs: "Logs" = None,
    requirement: "Requirement | None" = None,
    joint: "str | None" = None,
    band: "float | str | None" = None,
    catalog: "Catalog | None" = None,
    threads: "int | None" = None,
) -> Answer:
    """Bench logs against the declared model: what it lacks, by how much, and how sure that is. With `requirement` its
    choice is made again with what was fitted. `band`: cut-off of the filter [Hz]; by default chosen from the data. `logs`:
    arrays in place of files that the bench file names, as `{"run1.csv": {"time": t, "current": i, …}}`, with the columns and
    units that it says of them."""
    import tempfile

    native = None if catalog is None else catalog._catalog
    with tempfile.TemporaryDirectory() as folder:
        answer = _native.identify(bench, _handed(logs, folder), requirement, joint, band, native, threads)
    return Answer(answer, f"gearwise.identify({bench})")


def characterize(
    bench: "Path", *, logs: "Logs" = None, catalog: "Catalog | None" = None, threads: "int | None" = None
) -> Answer:
    """Raw bench logs of a motor as a catalogue row, with uncertainties. `logs`: arrays in place of files, as for `identify`."""
    import tempfile

    native = None if catalog is None else catalog._catalog
    with tempfile.TemporaryDirectory() as folder:
        answer = _native.characterize(bench, _handed(logs, folder), native, threads)
    return Answer(answer, f"gearwise.characterize({bench})")


def study(
    requirement: "Requirement | Sequence[Path]",
    grid: "Mapping[str, ArrayLike | Sequence[object] | Mapping[str, object]] | None" = None,
    *,
    out: "Path",
    top: "int | None" = 3,
    only_checked: bool = False,
    shard: "tuple[int, int]" = (1, 1),
    resume: bool = False,
    force: bool = False,
    catalog: "Catalog | None" = None,
    threads: "int | None" = None,
    progress: "Progress" = None,
) -> Answer:
    """Many robots in one go: each requirement (a file, files, folders, patterns, a study file, or one that Python made) at every
    point of a `grid` of values, as `{"bus.voltage": ["24 V", "48 V"], "scale.torque": [1.0, 1.2]}`. The results are in the folder
    `out`: `table()` has a row for each design.

    `top`: so many designs of each joint; None for all. `resume` goes on with what was stopped, `force` starts again. `shard`:
    one part of so many, for many machines, each with its own `out`; `merge` puts them together, to the same bytes."""
    if resume and force:
        raise InputError._said("`resume` goes on and `force` starts again: give one of the two")
    shard = _shard(shard)
    paths, changes = _paths(requirement)
    made = None
    if paths is None:
        if shard != (1, 1):
            raise InputError._said("every shard names the requirement by its file: write one with `save`, and give its path")
        paths, made = _own(requirement, out)
    native = None if catalog is None else catalog._catalog
    existing = "resume" if resume else "force" if force else ""
    try:
        answer = _native.study(
            paths, changes, grid, out, top, only_checked, shard, existing, native, threads, _bar(progress)
        )
    except InputError:
        # What no study rests on is not left behind.
        if made is not None:
            import pathlib
            import shutil

            if not (pathlib.Path(out) / "journal").exists():
                shutil.rmtree(made, ignore_errors=True)
        raise
    return Answer(answer, f"gearwise.study({_said(requirement)}, out={out})")


def _shard(shard: "Any") -> "tuple[int, int]":
    import operator

    try:
        number, of = tuple(shard)
        return operator.index(number), operator.index(of)
    except (TypeError, ValueError):
        raise InputError._said(f"`shard` is {shard!r}: expected two whole numbers, as in (2, 8)") from None


def _paths(requirement: "Any") -> "tuple[list[Path] | None, list[tuple[str, str]]]":
    """Files, folders and patterns, and what was changed in them; None for a requirement that Python made."""
    if isinstance(requirement, _native.Requirement):
        file = requirement._file()
        return (None, []) if file is None else ([file[0]], file[1])
    if isinstance(requirement, (list, tuple)):
        for each in requirement:
            if not (isinstance(each, str) or hasattr(each, "__fspath__")):
                raise InputError._said(
                    "a study of several requirements takes their files: write each with `save`, and give the paths"
                )
        return list(requirement), []
    if isinstance(requirement, str) or hasattr(requirement, "__fspath__"):
        return [requirement], []
    return None, []


def _own(requirement: object, out: "Path") -> "tuple[list[Path], Path | None]":
    """The file of a requirement in the folder of its study, and the folder that was made for it. It is named by what is in it, so
    that no other takes its place."""
    import hashlib
    import pathlib
    import tempfile

    made = _native.Requirement(requirement)
    with tempfile.TemporaryDirectory() as new:
        files = [pathlib.Path(path) for path in made.save(f"{new}/robot.toml")]
        texts = {file.name: file.read_bytes() for file in files}
    digest = hashlib.sha256(b"\0".join(text for _, text in sorted(texts.items()))).hexdigest()
    folder = pathlib.Path(out) / f"requirement-{digest[:8]}"
    if folder.exists():
        return [folder / "robot.toml"], None
    try:
        folder.mkdir(parents=True)
        for name, text in texts.items():
            (folder / name).write_bytes(text)
    except OSError as why:
        raise InputError._said(f"`out`: cannot write `{folder}`: {why.strerror}") from None
    return [folder / "robot.toml"], folder


def merge(out: "Path", shards: "Sequence[Path]", *, force: bool = False) -> Answer:
    """All shards of a study, in their folders, as one study in the folder `out`; `force` replaces results that are there."""
    one: "Any" = shards
    folders: "list[Path]" = [one] if isinstance(one, str) or hasattr(one, "__fspath__") else list(shards)
    if not folders:
        raise InputError._said("there are no shards to merge: give the folders of all of them")
    return Answer(_native.merge(out, folders, force), f"gearwise.merge({out})")


def export(
    design: "str | PathLike[str] | Optimized",
    to: "str | None" = None,
    *,
    requirement: "Requirement | None" = None,
    into: "Path | None" = None,
    joint: "str | Sequence[str]" = (),
    joint_map: "Mapping[str, str] | None" = None,
    with_efficiency: bool = False,
    line_below: bool = False,
    thermal: bool = False,
    electrical: bool = False,
    drake: bool = False,
    gear_joint: bool = False,
    ranges: bool = False,
    draws: "int | None" = None,
    catalog: "Catalog | None" = None,
) -> str:
    """A chosen design for a simulator, as text: what `optimize` chose, a design file, or with `requirement` one motor as
    "MOTOR@RATIO". `to`: mjcf, dcmotor, isaaclab2, isaaclab3, mjlab, unitree, newton, physx, urdf, sdf, ros2_control, json;
    or `into` a model (MJCF, URDF, SDFormat) that is written into. What to be warned of comes as Python warnings, as that a
    design is not feasible. `joint_map`: which joints of the model a joint of the design is, `*` for any run of characters."""
    options = {
        "with_efficiency": with_efficiency,
        "line_below": line_below,
        "thermal": thermal,
        "electrical": electrical,
        "drake": drake,
        "gear_joint": gear_joint,
        "ranges": ranges,
    }
    joints = [joint] if isinstance(joint, str) else list(joint)
    native = None if catalog is None else catalog._catalog
    names = [f"{name}={pattern}" for name, pattern in (joint_map or {}).items()]
    given = [name for name, is_given in options.items() if is_given]
    of = needed(design._of) if isinstance(design, Optimized) else design
    if isinstance(design, Answer) and not isinstance(design, Optimized):
        raise InputError._said("only what `optimize` chose is exported")
    text, remarks, _ = _native.export(of, requirement, to, into, joints, names, given, draws, native)
    if remarks:
        import warnings

        for remark in remarks:
            warnings.warn(remark, stacklevel=2)
    return text
