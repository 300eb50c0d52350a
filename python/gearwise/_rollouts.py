"""Motions from episodes of a simulator."""

from gearwise import _native
from gearwise._errors import InputError

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping
    from os import PathLike
    from typing import Any

    from numpy.typing import ArrayLike

KEYS = ("time", "dt", "torque", "velocity", "acceleration", "done", "names")


def rollouts(
    episodes: "str | PathLike[str] | Mapping[str, ArrayLike] | Iterable[Mapping[str, ArrayLike]]",
    joint: "str | int" = 0,
    *,
    armature: "float | str" = 0.0,
    damping: "float | str" = 0.0,
    friction: "float | str" = 0.0,
) -> _native.Motion:
    """What a joint has to do in many episodes of a simulator, as a motion: all samples together, weighed by how long each
    lasts. Derivatives are taken within an episode, by its own spline.

    `episodes`: mappings of arrays, one for each episode; one mapping whose arrays have an axis of episodes in front; an
    `.npz` file with such arrays; or a Parquet file with a column `episode`. Keys: `time` [s] or `dt` [s], `torque` [N m] and
    `velocity` [rad/s] over step, or over step and joint; optional `acceleration` [rad/s^2], `done` (an episode ends where
    it is true; steps behind that are the next episode, unless they are done too, zeros or NaN) and `names` of the joints. Two axes are
    episode and step, with `names` step and joint; where that is not clear it is refused. Torque is what the actuator gives the joint: MuJoCo's `qfrc_actuator`, Isaac
    Lab's `applied_torque`. `joint`: a name of `names`, or the place on the last axis.

    `armature` [kg m^2], `damping` [N m s/rad] and `friction` [N m]: what the simulator's joint had of its own in place of an
    actuator's. Its torque moved that, and the real actuator brings its own: so it is taken out, torque - armature a -
    damping w - friction sgn w.

    Samples have an order within an episode only, so temperature over the motion is not checked; heat in steady state is."""
    own = _native._simulated(armature, damping, friction)
    made: "list[tuple[Any, Any, Any, Any]]" = []
    for place, episode in enumerate(_episodes(episodes)):
        made += _one(episode, joint, f"episode {place}")
    if not made:
        raise InputError._said("there is no episode")
    return _native._rollouts(made, own)


def _episodes(episodes: "Any") -> "Iterable[Mapping[str, Any]]":
    import zipfile

    import numpy

    if isinstance(episodes, str) or hasattr(episodes, "__fspath__"):
        path = str(episodes)
        if path.endswith(".npz"):
            try:
                with numpy.load(path, allow_pickle=False) as file:
                    episodes = {name: file[name] for name in file.files}
            except (OSError, ValueError, EOFError, KeyError, zipfile.BadZipFile) as why:
                raise InputError._said(f"{path}: cannot be read as an .npz file: {why}") from None
        elif path.endswith(".parquet"):
            yield from _parquet(path)
            return
        else:
            raise InputError._said(f"{path}: expected an .npz or a .parquet file")
    if not hasattr(episodes, "keys"):
        try:
            yield from episodes
        except TypeError:
            raise InputError._said("`episodes` is no mapping, no list of mappings and no file") from None
        return
    unknown = [name for name in episodes if name not in KEYS]
    if unknown:
        raise InputError._said(f"`{unknown[0]}` is no key of an episode: there are {', '.join(KEYS)}")
    arrays = {name: value if numpy.ma.isMaskedArray(value) else numpy.asarray(value) for name, value in episodes.items()}
    if "torque" not in arrays:
        raise InputError._said("the episodes have no `torque`")
    axes = arrays["torque"].ndim
    if axes == 0:
        raise InputError._said("`torque` is one number: expected an array")
    if axes == 1 or (axes == 2 and not _are_episodes(arrays)):
        yield arrays
        return
    count = arrays["torque"].shape[0]
    for place in range(count):
        each = {}
        for name, array in arrays.items():
            # One time for all episodes, one end for all of them.
            common = name in ("time", "done") and array.ndim == 1
            if name not in ("names", "dt") and array.ndim and not common:
                if array.shape[0] != count:
                    raise InputError._said(f"`{name}` has {array.shape[0]} episodes, and `torque` has {count}")
                each[name] = array[place]
            else:
                each[name] = array
        yield each


# No robot has so many joints: a longer axis is of steps.
_MOST_JOINTS = 64


def _are_episodes(arrays: "Mapping[str, Any]") -> bool:
    """Whether two axes are of episodes and steps, or of steps and joints."""
    first, last = arrays["torque"].shape
    if "names" in arrays:
        return False
    for name in ("time", "done"):
        if name not in arrays:
            continue
        if arrays[name].ndim == 2:
            return True
        length = arrays[name].size
        if length in (first, last) and first != last:
            return bool(length == last)
    if last > _MOST_JOINTS:
        return True
    raise InputError._said(
        f"`torque` is {first} by {last}: are that episodes and steps, or steps and joints? Give `names` of the joints, "
        "`time` over the steps, or a list of episodes"
    )


def _parquet(path: str) -> "Iterable[Mapping[str, Any]]":
    """Episodes of a Parquet file: rows of one `episode` belong together, in their order."""
    import numpy

    try:
        import polars  # type: ignore[import-not-found, unused-ignore]

        frame = polars.read_parquet(path)
        columns = {name: frame[name].to_numpy() for name in frame.columns}
    except ImportError:
        try:
            import pandas  # type: ignore[import-untyped, unused-ignore]

            table = pandas.read_parquet(path)
        except ImportError:
            raise InputError._said(f"{path}: reading Parquet needs polars, or pandas with pyarrow") from None
        columns = {str(name): table[name].to_numpy() for name in table.columns}
    except Exception as why:
        raise InputError._said(f"{path}: cannot be read as a Parquet file: {why}") from None
    if "episode" not in columns:
        raise InputError._said(f"{path}: there is no column `episode`")
    unknown = [name for name in columns if name != "episode" and name not in KEYS]
    if unknown:
        raise InputError._said(f"{path}: `{unknown[0]}` is no column of episodes: there are episode, {', '.join(KEYS)}")
    number = columns.pop("episode")
    starts = numpy.flatnonzero(numpy.r_[True, number[1:] != number[:-1]])
    if len(set(number[starts].tolist())) != len(starts):
        raise InputError._said(f"{path}: the rows of an episode are not together")
    for begin, end in zip(starts, [*starts[1:], len(number)], strict=True):
        yield {name: values[begin:end] for name, values in columns.items()}


def _numbers(values: "Any", key: str, name: str) -> "Any":
    import numpy

    if numpy.ma.isMaskedArray(values) and numpy.ma.getmaskarray(values).any():
        raise InputError._said(f"{name}: `{key}` has masked entries: leave those samples out")
    try:
        array = numpy.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise InputError._said(f"{name}: `{key}` is no array of numbers") from None
    if array.ndim == 0 and key != "dt":
        raise InputError._said(f"{name}: `{key}` is one number: expected an array")
    return array


def _place(joint: "Any") -> int:
    import operator

    try:
        return operator.index(joint)
    except TypeError:
        raise InputError._said("`joint` is neither a name nor a place") from None


def _one(episode: "Any", joint: "str | int", name: str) -> "list[tuple[Any, Any, Any, Any]]":
    """Time, torque, velocity and acceleration of one joint in one episode, or in each of a stream."""
    import numpy

    if not hasattr(episode, "keys"):
        raise InputError._said(f"{name} is no mapping of arrays")
    unknown = [key for key in episode if key not in KEYS]
    if unknown:
        raise InputError._said(f"{name}: `{unknown[0]}` is no key of an episode: there are {', '.join(KEYS)}")
    names = episode.get("names")
    listed = [] if names is None else [str(each) for each in numpy.asarray(names).ravel()]
    if len(set(listed)) != len(listed):
        raise InputError._said(f"{name}: `names` has a joint twice")
    place = joint if isinstance(joint, str) else _place(joint)
    if isinstance(joint, str):
        if names is None:
            raise InputError._said(f"{name} has no `names`: give the place of the joint, or add them")
        if joint not in listed:
            raise InputError._said(f"{name}: there is no joint `{joint}`: there are {', '.join(listed)}")
        place = listed.index(joint)

    def column(key: str) -> "Any":
        if key not in episode:
            return None
        values = _numbers(episode[key], key, name)
        if values.ndim == 1 and place != 0 and names is None:
            raise InputError._said(f"{name}: `{key}` has no axis of joints, and joint {joint} is asked for")
        if values.ndim == 2:
            if names is not None and len(listed) != values.shape[1]:
                raise InputError._said(f"{name}: `names` has {len(listed)} joints, and `{key}` has {values.shape[1]}")
            if not isinstance(place, int) or not -values.shape[1] <= place < values.shape[1]:
                raise InputError._said(f"{name}: `{key}` has {values.shape[1]} joints, and joint {joint} is asked for")
            values = values[:, place]
        if values.ndim != 1:
            raise InputError._said(f"{name}: `{key}` has {values.ndim} axes: expected step, or step and joint")
        return values

    torque, velocity, acceleration = column("torque"), column("velocity"), column("acceleration")
    if torque is None or velocity is None:
        raise InputError._said(f"{name} has no `{'torque' if torque is None else 'velocity'}`")
    steps = len(torque)
    if ("time" in episode) == ("dt" in episode):
        raise InputError._said(f"{name}: give `time` or `dt`, one of the two")
    if "dt" in episode:
        dt = _numbers(episode["dt"], "dt", name)
        if dt.size != 1 or not float(dt.reshape(())) > 0:
            raise InputError._said(f"{name}: `dt` is not one number greater than zero")
        time = float(dt.reshape(())) * numpy.arange(steps)
    else:
        time = _numbers(episode["time"], "time", name)
    for key, values in (("time", time), ("velocity", velocity), ("acceleration", acceleration)):
        if values is not None and len(values) != steps:
            raise InputError._said(f"{name}: `{key}` has {len(values)} steps, and `torque` has {steps}")
    if "done" in episode:
        done = numpy.asarray(episode["done"]).ravel()
        if len(done) != steps:
            raise InputError._said(f"{name}: `done` has {len(done)} steps, and `torque` has {steps}")
        return _cut(time, torque, velocity, acceleration, done.astype(bool), name)
    return [(time, torque, velocity, acceleration)]


# Fewer samples than a spline takes say nothing of an acceleration.
_LEAST_STEPS = 4


def _cut(
    time: "Any", torque: "Any", velocity: "Any", acceleration: "Any", done: "Any", name: str
) -> "list[tuple[Any, Any, Any, Any]]":
    """An episode up to where it is done; a stream that goes on behind that is several episodes."""
    import numpy

    ends = numpy.flatnonzero(done)
    if not len(ends):
        return [(time, torque, velocity, acceleration)]
    # What is done for good stays done to the end of its array, or has nothing behind it but zeros or no numbers.
    behind = slice(int(ends[0]) + 1, None)
    padding = done[behind].all() or all((numpy.isnan(each[behind]) | (each[behind] == 0)).all() for each in (torque, velocity))
    starts = [0] if padding else [0, *(ends + 1)]
    stops = [ends[0] + 1] if padding else [*(ends + 1), len(done)]
    pieces = []
    short = 0
    for begin, end in zip(starts, stops, strict=True):
        if end - begin >= _LEAST_STEPS or padding:
            part = slice(begin, end)
            pieces.append((time[part], torque[part], velocity[part], None if acceleration is None else acceleration[part]))
        else:
            short += int(end - begin)
    if short:
        import warnings

        warnings.warn(f"{name}: {short} of {len(done)} steps are in pieces of fewer than {_LEAST_STEPS}: left out", stacklevel=4)
    return pieces
