"""What is answered. Attributes are the keys of the JSON, in SI with the unit in the name."""

from gearwise import _native
from gearwise._design import Design
from gearwise._errors import NoDesign
from gearwise._light import final, overload
from gearwise._table import Table

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence
    from typing import Any

    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from gearwise._catalog import Catalog

    F = NDArray[np.float64]


@final
class Figure:
    """The picture of an answer; a notebook shows it."""

    __slots__ = ("_of",)

    def __init__(self, of: "_native.Answer") -> None:
        """The picture of an answer of the library."""
        self._of = of

    def data(self) -> "dict[str, Any]":
        """What is drawn: groups of panels of series, each with `x` and `y`."""
        return self._of.figure_data()

    def svg(self) -> str:
        """As SVG."""
        return self._of.svg()

    def png(self) -> bytes:
        """As PNG."""
        return self._of.png()

    def _repr_svg_(self) -> str:
        return self._of.svg()


class Answer:
    """An answer. Its content is in `to_dict()`; its keys are attributes, too. A form of it is made when it is asked for."""

    __slots__ = ("_of", "_call", "_dict")

    def __init__(self, of: "_native.Answer", call: str) -> None:
        """Of an answer of the library, and how it was asked for."""
        self._of = of
        self._call = call
        self._dict: "dict[str, Any] | None" = None

    @property
    def satisfied(self) -> bool:
        """Whether what was asked is satisfied: what the exit status of the command says."""
        return self._of.satisfied

    @property
    def warnings(self) -> "tuple[str, ...]":
        """What should be known before the result is used."""
        return tuple(self._of.warnings())

    def to_dict(self) -> "dict[str, Any]":
        """What `--json` prints, as values of Python. Made once: do not change it."""
        if self._dict is None:
            self._dict = self._of.to_dict()
        return self._dict

    def to_json(self) -> str:
        """What `--json` prints, to the byte."""
        return self._of.to_json()

    def text(self) -> str:
        """What the command prints for people."""
        return self._of.text()

    def table(self) -> Table:
        """What `--csv` prints, as a table. Raises InputError where the command has no CSV."""
        csv = self._of.csv()
        if not csv:
            from gearwise._errors import InputError

            raise InputError._said("this answer has no table: its content is in to_dict()")
        return Table(_native.Table(csv))

    def figure(self) -> Figure:
        """Its picture, as `--plot` draws it. Raises InputError, when it is drawn, where the command has none."""
        return Figure(self._of)

    def html(self) -> str:
        """The page of `--html`: one file that opens without a network."""
        return self._of.html(self._call)

    def show(self) -> None:
        """Shows the page in a notebook, in a frame without a network."""
        from IPython.display import HTML, display

        from gearwise._html import escaped

        frame = '<iframe sandbox="allow-scripts" style="width:100%;height:640px;border:0" srcdoc="{}"></iframe>'
        display(HTML(frame.format(escaped(self.html()))))

    if not TYPE_CHECKING:

        def __getattr__(self, name):
            if name.startswith("_"):
                raise AttributeError(name)
            content = self.to_dict()
            if name in content:
                return content[name]
            raise AttributeError(f"{type(self).__name__} has no `{name}`; there are {', '.join(content)}")

    def __reduce__(self) -> "tuple[object, ...]":
        from gearwise._kept import state

        return (type(self)._again, (state(self._of), self._call))

    @classmethod
    def _again(cls, state: "dict[str, Any]", *how: "Any") -> "Answer":
        from gearwise._kept import Kept

        of: "Any" = Kept(state)
        return cls(of, *how)

    def __dir__(self) -> "list[str]":
        return sorted({*object.__dir__(self), *self.to_dict()})

    def __repr__(self) -> str:
        return f"<{type(self).__name__} of {self._call}: {'' if self.satisfied else 'not '}satisfied>"

    def _repr_html_(self) -> str:
        from gearwise._html import escaped, table_html

        csv = self._of.csv()
        shown = f"<p>{escaped(self._of.headline())}</p>"
        if csv:
            table = Table(_native.Table(csv))
            shown += table_html(table._native_table().names, list(table._rows(10)), len(table))
        return shown


@final
class Designs:
    """Designs of a joint, the best first; each is made when it is asked for."""

    __slots__ = ("_of", "_joint", "_count")

    def __init__(self, of: "_native.Answer", joint: int) -> None:
        """Those of a joint, by its place."""
        self._of = of
        self._joint = joint
        self._count = of.candidates(joint)

    def __len__(self) -> int:
        return self._count

    @overload
    def __getitem__(self, place: int) -> Design: ...
    @overload
    def __getitem__(self, place: slice) -> "list[Design]": ...
    def __getitem__(self, place: "int | slice") -> "Design | list[Design]":
        if isinstance(place, slice):
            return [self[k] for k in range(*place.indices(self._count))]
        if place < 0:
            place += self._count
        if not 0 <= place < self._count:
            raise IndexError(f"there are {self._count} designs")
        found = self._of.design(self._joint, place)
        assert found is not None
        return Design(found)

    def __iter__(self) -> "Iterator[Design]":
        return (self[place] for place in range(self._count))

    def __repr__(self) -> str:
        return f"<{self._count} designs>"


@final
class JointResult(Table):
    """What was found for a joint; as a table, a row for each motor."""

    __slots__ = ("_answer", "_place", "joint")

    joint: str
    """Name of the joint."""

    def __init__(self, answer: "Optimized", place: int, joint: str) -> None:
        """The joint at a place of an answer."""
        super().__init__()
        self._answer = answer
        self._place = place
        self.joint = joint

    def _native_table(self) -> "_native.Table":
        if self._made is None:
            self._made = _native.Table(self._answer._of.csv()).only("joint", self.joint)
        return self._made

    def __reduce__(self) -> "tuple[object, ...]":
        return (JointResult, (self._answer, self._place, self.joint))

    @property
    def candidates(self) -> Designs:
        """Designs of which every limit that the requirement states could be judged and is kept, the best first."""
        return Designs(self._answer._of, self._place)

    @property
    def unjudged(self) -> "Sequence[Mapping[str, Any]]":
        """Motors of which such a limit could not be judged: none of them is a choice."""
        found: "Sequence[Mapping[str, Any]]" = self.to_dict()["unjudged"]
        return found

    @property
    def rejected(self) -> "Sequence[Mapping[str, Any]]":
        """Motors that cannot do it, each with the reason in `because`."""
        found: "Sequence[Mapping[str, Any]]" = self.to_dict()["rejected"]
        return found

    @property
    def best(self) -> Design:
        """The first design. Raises NoDesign where there is none; its text says which motor came nearest, and why not."""
        if len(self.candidates):
            return self.candidates[0]
        raise NoDesign(self._answer._of.without(self._place))

    def to_dict(self) -> "dict[str, Any]":
        """What the JSON has of the joint."""
        found: "dict[str, Any]" = self._answer.to_dict()["joints"][self._place]
        return found

    def __repr__(self) -> str:
        return f"<JointResult {self.joint}: {len(self.candidates)} designs>"


@final
class Optimized(Answer):
    """The best motors and ratios of each joint. `answer["knee"].best` is the first choice."""

    __slots__ = ("_catalog",)

    def __init__(self, of: "_native.Answer", call: str, catalog: "Catalog | None") -> None:
        """Of a choice of the library, how it was asked for, and the catalogue that it was made from."""
        super().__init__(of, call)
        self._catalog = catalog

    def __reduce__(self) -> "tuple[object, ...]":
        from gearwise._kept import state

        return (type(self)._again, (state(self._of), self._call, self._catalog))

    def text(self, *, why: bool = False, rejected: bool = False, full: bool = False) -> str:
        """What the command prints for people; `why`: what binds, what gears near N* cost, what was assumed, how sure it is;
        `rejected`: why not the others; `full`: all of it."""
        if not (why or rejected or full):
            return self._of.text()
        from gearwise._kept import needed

        said: str = needed(self._of).text_of(why, rejected, full)
        return said

    @property
    def joints(self) -> "Mapping[str, JointResult]":
        """Each joint by its name, in the order of the requirement."""
        return {name: JointResult(self, place, name) for place, name in enumerate(self._of.joints())}

    @property
    def robot(self) -> "Mapping[str, Any]":
        """What the JSON has of the robot as a whole."""
        found: "Mapping[str, Any]" = self.to_dict()["robot"]
        return found

    def __getitem__(self, joint: str) -> JointResult:
        names = self._of.joints()
        if joint not in names:
            raise KeyError(f"there is no joint `{joint}`: there are {', '.join(names)}")
        return JointResult(self, names.index(joint), joint)


@final
class Evaluated:
    """Designs as arrays over (motor, ratio); `margin` and `sample` have a third axis, limit. What is not known is NaN."""

    __slots__ = ("_of",)

    def __init__(self, of: "_native.Evaluated") -> None:
        """Of arrays of the library."""
        self._of = of

    @property
    def motors(self) -> "tuple[str, ...]":
        """Ids of the motors, the first axis."""
        return tuple(self._of.motors)

    @property
    def ratio(self) -> "F":
        """Ratios N, the second axis."""
        return self._of.ratio

    @property
    def unusable(self) -> "Mapping[str, str]":
        """Motors that cannot be evaluated, with the reason; their numbers are NaN."""
        return self._of.unusable

    @property
    def unknown_losses(self) -> "Mapping[str, Sequence[str]]":
        """For each motor the parts of its loss of which nothing is known: `loss_w` has none of them."""
        return self._of.unknown_losses

    @property
    def feasible(self) -> "NDArray[np.bool_]":
        """Whether the ratio is allowed and every limit that was looked at and could be checked is kept."""
        return self._of.feasible

    @property
    def judged(self) -> "NDArray[np.bool_]":
        """Whether every limit that the requirement states, of those that were looked at, could be judged. A design is a
        choice where it is feasible and judged."""
        return self._of.judged

    @property
    def loss_w(self) -> "F":
        """Mean of all losses that are known [W]."""
        return self._of.loss_w

    @property
    def loss_slope_w(self) -> "F":
        """Derivative of `loss_w` by the ratio [W]; NaN where it has none in closed form."""
        return self._of.loss_slope_w

    @property
    def peak_current_q_a(self) -> "F":
        """Largest q-axis current, power invariant [A]."""
        return self._of.peak_current_q_a

    @property
    def rms_current_q_a(self) -> "F":
        """Root mean square of the q-axis current, power invariant [A]."""
        return self._of.rms_current_q_a

    @property
    def mean_electrical_power_w(self) -> "F":
        """Mean electrical power at the motor's terminals [W]."""
        return self._of.mean_electrical_power_w

    @property
    def reflected_inertia_kgm2(self) -> "F":
        """Inertia of the actuator at the joint [kg m^2]."""
        return self._of.reflected_inertia_kgm2

    @property
    def mass_kg(self) -> "F":
        """Mass of motor and gear [kg]."""
        return self._of.mass_kg

    @property
    def objective(self) -> "F":
        """The joint's objective, in its own unit."""
        return self._of.objective

    @property
    def limits(self) -> "tuple[str, ...]":
        """Names of the limits, the third axis of `margin` and `sample`."""
        return tuple(self._of.limits)

    @property
    def margin(self) -> "F":
        """`1 - demand/bound` over (motor, ratio, limit); NaN where a limit is not asked of the motor, or could not be
        checked."""
        return self._of.margin

    @property
    def sample(self) -> "NDArray[np.int64]":
        """The sample of the motion that asks most of the limit; -1 where none does."""
        return self._of.sample

    def __repr__(self) -> str:
        return f"<Evaluated: {len(self.motors)} motors at {len(self.ratio)} ratios>"

    def __reduce__(self) -> "tuple[object, ...]":
        names = [name for name, what in vars(Evaluated).items() if isinstance(what, property)]
        return (Evaluated._again, ({name: getattr(self, name) for name in names},))

    @staticmethod
    def _again(arrays: "dict[str, Any]") -> "Evaluated":
        from types import SimpleNamespace

        of: "Any" = SimpleNamespace(**arrays)
        return Evaluated(of)


@final
class ActuatorMap(Table):
    """What actuators can do over (motor, ratio), without a motion. Torques are those that arrive at the joint at steady
    speed but for friction: behind the gear's loss while the motor drives. Friction (`friction_loss_nm`, `damping_nms_per_rad`
    times speed) comes off, and what the rotor takes for its own acceleration, `reflected_inertia_kgm2` times it. What is not known is NaN. As a table it has a row for each pair."""

    __slots__ = ("_of", "_again")

    def __init__(self, of: "_native.ActuatorMap", again: "Callable[[ArrayLike | None], _native.ActuatorMap]") -> None:
        """Of arrays of the library; `again` makes them at speeds."""
        super().__init__()
        self._of = of
        self._again = again

    def __reduce__(self) -> "tuple[object, ...]":
        # It is made again in no time.
        return (ActuatorMap._made_again, (self._again,))

    @staticmethod
    def _made_again(again: "Callable[[ArrayLike | None], _native.ActuatorMap]") -> "ActuatorMap":
        return ActuatorMap(again(None), again)

    def _figure(self, name: str) -> "F":
        found = self._of.figure(name)
        assert found is not None
        return found

    @property
    def motors(self) -> "tuple[str, ...]":
        """Ids of the motors, the first axis."""
        return tuple(self._of.motors)

    @property
    def ratio(self) -> "F":
        """Ratios N, the second axis."""
        return self._of.ratio

    @property
    def unusable(self) -> "Mapping[str, str]":
        """Motors of which nothing can be worked out, with the reason."""
        return self._of.unusable

    @property
    def mass_kg(self) -> "F":
        """Mass of motor and gear [kg]."""
        return self._figure("mass_kg")

    @property
    def reflected_inertia_kgm2(self) -> "F":
        """Inertia at the joint, N^2 (J_m + J_g) [kg m^2]."""
        return self._figure("reflected_inertia_kgm2")

    @property
    def copper_loss_w_per_nm2(self) -> "F":
        """Copper loss per square of the torque at the joint while the motor drives, at the reference temperature
        [W/(N m)^2]."""
        return self._figure("copper_loss_w_per_nm2")

    @property
    def peak_torque_nm(self) -> "F":
        """Largest torque while the motor drives [N m], at standstill and up to `speed_at_peak_rad_per_s`."""
        return self._figure("peak_torque_nm")

    @property
    def peak_braking_torque_nm(self) -> "F":
        """Largest torque against a load that drives [N m]."""
        return self._figure("peak_braking_torque_nm")

    @property
    def continuous_torque_nm(self) -> "F":
        """Torque that can be held for ever while the motor drives [N m]."""
        return self._figure("continuous_torque_nm")

    @property
    def stall_torque_nm(self) -> "F":
        """Torque that the voltage alone allows at standstill [N m]."""
        return self._figure("stall_torque_nm")

    @property
    def speed_at_peak_rad_per_s(self) -> "F":
        """Speed up to which the largest torque can be had [rad/s]."""
        return self._figure("speed_at_peak_rad_per_s")

    @property
    def no_load_speed_rad_per_s(self) -> "F":
        """Speed without load [rad/s]."""
        return self._figure("no_load_speed_rad_per_s")

    @property
    def max_speed_rad_per_s(self) -> "F":
        """Largest speed that motor, gear and voltage allow [rad/s]."""
        return self._figure("max_speed_rad_per_s")

    @property
    def damping_nms_per_rad(self) -> "F":
        """Viscous friction at the joint [N m s/rad]."""
        return self._figure("damping_nms_per_rad")

    @property
    def friction_loss_nm(self) -> "F":
        """Coulomb friction at the joint [N m]."""
        return self._figure("friction_loss_nm")

    def envelope(self, speed: "ArrayLike") -> "tuple[F, F]":
        """Largest torque [N m] while the motor drives, and against a load that drives, over (motor, ratio, speed); speeds
        in rad/s. Zero beyond the largest speed."""
        return self._again(speed).envelope()

    def _native_table(self) -> "_native.Table":
        if self._made is None:
            self._made = _native.Table(self._of.csv())
        return self._made

    def __repr__(self) -> str:
        return f"<ActuatorMap: {len(self.motors)} motors at {len(self.ratio)} ratios>"
