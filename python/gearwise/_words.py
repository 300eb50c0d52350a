"""What is asked, in the words of a requirement file: the reader of files checks it."""

# Written by python/generate.py: change the reader or the schema, not this file.

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from os import PathLike
    from typing import Any

    from gearwise._native import Motion

from gearwise._light import final
from gearwise._table import Words


@final
class Bus(Words):
    """The supply. A number is SI, a text has its unit ("48 V"); what is left out holds as in a file."""

    __slots__ = ('voltage', 'regeneration', 'drive_phase_resistance', 'drive_standby_power', 'drive_continuous_current', 'field_weakening_current', 'drive_current', 'regeneration_efficiency', 'brake_power', 'internal_resistance', 'max_voltage', 'drive_efficiency', 'flux_braking', 'modulation', 'modulation_limit', 'power', 'current',)
    _keys = {}

    voltage: "float | str"
    """Of the bus; required [voltage]."""
    regeneration: "float | str | None"
    """What the bus takes back at any instant; all by default [allowed, none, dissipated, or a power]."""
    drive_phase_resistance: "float | str | None"
    """Of switch and leads per phase, in series with the winding; loses r i² [resistance]."""
    drive_standby_power: "float | str | None"
    """That one drive takes whatever its motor does [power]."""
    drive_continuous_current: "float | str | None"
    """Continuous, of a drive: amplitude of a phase at constant speed, root mean square over the motion [current]."""
    field_weakening_current: "float | str | None"
    """Largest current against the magnets, amplitude of a phase: where voltage ends, this much of it is used; none: i_d =
    0 by default [current].
    """
    drive_current: "float | str | None"
    """Largest drive current, phase amplitude (DC ampere of a brushed motor) [current]."""
    regeneration_efficiency: "float | None"
    """Share of what a motor gives back that is kept, drive and supply together; `drive_efficiency` by default."""
    brake_power: "float | str | None"
    """That a braking resistor takes of one joint's where the supply does not take it [power]."""
    internal_resistance: "float | str | None"
    """Of the supply and its main leads; `voltage` is then that without current; none by default [resistance]."""
    max_voltage: "float | str | None"
    """That drives and capacitors bear: of the motor at its top speed when the drive lets go, and of a bus with a
    resistance where power comes back [voltage].
    """
    drive_efficiency: "float | None"
    """Efficiency of the drive, η_d; 1 by default."""
    flux_braking: "bool | None"
    """Whether power that would come back beyond `regeneration` is turned into heat of the winding, by a current along d;
    false by default.
    """
    modulation: "str | None"
    """How the drive makes phase voltages; `space_vector` by default."""
    modulation_limit: "float | None"
    """Share of the ideal voltage that may be used; a reserve goes here; 1 by default."""
    power: "float | str | None"
    """Largest power that the bus gives one joint [power]."""
    current: "float | str | None"
    """Largest current that the bus gives one joint [current]."""

    def __init__(
        self,
        voltage: "float | str",
        *,
        regeneration: "float | str | None" = None,
        drive_phase_resistance: "float | str | None" = None,
        drive_standby_power: "float | str | None" = None,
        drive_continuous_current: "float | str | None" = None,
        field_weakening_current: "float | str | None" = None,
        drive_current: "float | str | None" = None,
        regeneration_efficiency: "float | None" = None,
        brake_power: "float | str | None" = None,
        internal_resistance: "float | str | None" = None,
        max_voltage: "float | str | None" = None,
        drive_efficiency: "float | None" = None,
        flux_braking: "bool | None" = None,
        modulation: "str | None" = None,
        modulation_limit: "float | None" = None,
        power: "float | str | None" = None,
        current: "float | str | None" = None,
    ) -> None:
        """Words of a requirement; what is left out holds as in a file."""
        self._fill(voltage=voltage, regeneration=regeneration, drive_phase_resistance=drive_phase_resistance, drive_standby_power=drive_standby_power, drive_continuous_current=drive_continuous_current, field_weakening_current=field_weakening_current, drive_current=drive_current, regeneration_efficiency=regeneration_efficiency, brake_power=brake_power, internal_resistance=internal_resistance, max_voltage=max_voltage, drive_efficiency=drive_efficiency, flux_braking=flux_braking, modulation=modulation, modulation_limit=modulation_limit, power=power, current=current)


@final
class Gear(Words):
    """The gear that goes with a continuous ratio. A number is SI, a text has its unit ("48 V"); what is left out holds as
    in a file.
    """

    __slots__ = ('efficiency', 'backdrive_efficiency', 'mass_per_stage', 'stage_ratio', 'mass', 'no_load_torque', 'starting_torque', 'no_load_torque_speed', 'no_load_viscous', 'inertia', 'peak_torque', 'continuous_torque', 'max_input_speed', 'average_torque', 'momentary_peak_torque', 'ratcheting_torque', 'average_input_speed', 'rated_speed', 'rated_life', 'life_quantile', 'continuous_torque_is', 'backlash', 'stiffness', 'outer_diameter', 'length', 'price', 'lead_time', 'efficiency_covers', 'map',)
    _keys = {}

    efficiency: "float | None"
    """When the motor drives, η; 1 by default."""
    backdrive_efficiency: "float | None"
    """When the load drives, η_b; at most 1; 2 − 1/η by default."""
    mass_per_stage: "float | str | None"
    """Of each stage, in place of `mass` [mass]."""
    stage_ratio: "float | None"
    """Largest ratio of one stage, at least 1.1; with `mass_per_stage`, unless `ratio` lists stages."""
    mass: "float | str | None"
    """Where it does not depend on the ratio; none by default [mass]."""
    no_load_torque: "float | str | None"
    """That keeps it going without load, at its input: at any speed, or with `starting_torque` at `no_load_torque_speed`;
    `efficiency` is then that of the load alone; none by default [torque].
    """
    starting_torque: "float | str | None"
    """That sets it going without load, at its input; none by default [torque]."""
    no_load_torque_speed: "float | str | None"
    """Of the input, that `no_load_torque` holds at [speed]."""
    no_load_viscous: "float | str | None"
    """What it takes without load more per speed of the input; none by default [viscous friction]."""
    inertia: "float | str | None"
    """At the input, J_g; none by default [inertia]."""
    peak_torque: "float | str | None"
    """Largest, at the output [torque]."""
    continuous_torque: "float | str | None"
    """Continuous, at the output [torque]."""
    max_input_speed: "float | str | None"
    """Largest, at the input [speed]."""
    average_torque: "float | str | None"
    """Largest average, at the output [torque]."""
    momentary_peak_torque: "float | str | None"
    """Of a few shocks in a life, at the output [torque]."""
    ratcheting_torque: "float | str | None"
    """At which teeth skip, at the output [torque]."""
    average_input_speed: "float | str | None"
    """Largest average, at the input [speed]."""
    rated_speed: "float | str | None"
    """Of the input, that `rated_life` holds at [speed]."""
    rated_life: "float | str | None"
    """At `continuous_torque` and `rated_speed` [time]."""
    life_quantile: "str | None"
    """What `rated_life` is: nine in ten gears last longer, or half of them."""
    continuous_torque_is: "str | None"
    """What `continuous_torque` is a limit of: that of the rated life, or of heat."""
    backlash: "float | str | None"
    """At the output [angle]."""
    stiffness: "float | str | None"
    """Torsional, at the output [stiffness]."""
    outer_diameter: "float | str | None"
    """Of the gear; without it a limit on the diameter is not judged [length]."""
    length: "float | str | None"
    """Of the gear along its axis; without it a limit on the length is not judged [length]."""
    price: "float | str | None"
    """Of the gear; without it a limit on the price is not judged [money]."""
    lead_time: "float | str | None"
    """Of the gear; without it a limit on it is not judged [time]."""
    efficiency_covers: "str | None"
    """Only `load` here: `load_and_gear` needs gears of the catalogue; `load` by default."""
    map: "str | PathLike[str] | None"
    """CSV file next to this one: the gear over the ratio, a row for each of a family; between two rows it is interpolated;
    a gear that is the same at all ratios by default.
    """

    def __init__(
        self,
        efficiency: "float | None" = None,
        *,
        backdrive_efficiency: "float | None" = None,
        mass_per_stage: "float | str | None" = None,
        stage_ratio: "float | None" = None,
        mass: "float | str | None" = None,
        no_load_torque: "float | str | None" = None,
        starting_torque: "float | str | None" = None,
        no_load_torque_speed: "float | str | None" = None,
        no_load_viscous: "float | str | None" = None,
        inertia: "float | str | None" = None,
        peak_torque: "float | str | None" = None,
        continuous_torque: "float | str | None" = None,
        max_input_speed: "float | str | None" = None,
        average_torque: "float | str | None" = None,
        momentary_peak_torque: "float | str | None" = None,
        ratcheting_torque: "float | str | None" = None,
        average_input_speed: "float | str | None" = None,
        rated_speed: "float | str | None" = None,
        rated_life: "float | str | None" = None,
        life_quantile: "str | None" = None,
        continuous_torque_is: "str | None" = None,
        backlash: "float | str | None" = None,
        stiffness: "float | str | None" = None,
        outer_diameter: "float | str | None" = None,
        length: "float | str | None" = None,
        price: "float | str | None" = None,
        lead_time: "float | str | None" = None,
        efficiency_covers: "str | None" = None,
        map: "str | PathLike[str] | None" = None,
    ) -> None:
        """Words of a requirement; what is left out holds as in a file."""
        self._fill(efficiency=efficiency, backdrive_efficiency=backdrive_efficiency, mass_per_stage=mass_per_stage, stage_ratio=stage_ratio, mass=mass, no_load_torque=no_load_torque, starting_torque=starting_torque, no_load_torque_speed=no_load_torque_speed, no_load_viscous=no_load_viscous, inertia=inertia, peak_torque=peak_torque, continuous_torque=continuous_torque, max_input_speed=max_input_speed, average_torque=average_torque, momentary_peak_torque=momentary_peak_torque, ratcheting_torque=ratcheting_torque, average_input_speed=average_input_speed, rated_speed=rated_speed, rated_life=rated_life, life_quantile=life_quantile, continuous_torque_is=continuous_torque_is, backlash=backlash, stiffness=stiffness, outer_diameter=outer_diameter, length=length, price=price, lead_time=lead_time, efficiency_covers=efficiency_covers, map=map)


@final
class Limits(Words):
    """What a choice must keep. A number is SI, a text has its unit ("48 V"); what is left out holds as in a file."""

    __slots__ = ('spring', 'torque_bandwidth', 'life', 'life_quantile', 'actuator_mass', 'outer_diameter', 'axial_length', 'arrangement', 'price', 'lead_time', 'reflected_inertia', 'winding_temperature', 'shock_torque', 'max_backlash', 'min_stiffness', 'max_backdriving_torque', 'safety', 'reserve',)
    _keys = {}

    spring: "Mapping[str, object] | None"
    """A parallel spring to be chosen with the ratio."""
    torque_bandwidth: "Mapping[str, object] | None"
    """A sinusoidal torque on top of the motion."""
    life: "float | str | None"
    """Of the gear, in hours of this motion; its pauses count, and rest that follows it does not [time]."""
    life_quantile: "str | None"
    """What `life` is: nine in ten gears last longer, or half of them; `L10` by default."""
    actuator_mass: "float | str | None"
    """Of motor and gear; like every limit here it has to be judged, or the motor is no choice [mass]."""
    outer_diameter: "float | str | None"
    """Of the largest of motor and gear; a module as printed, a box by its diagonal across the axis [length]."""
    axial_length: "float | str | None"
    """Of motor and gear together; a module as printed [length]."""
    arrangement: "str | None"
    """One behind the other, whose lengths add up, or side by side, of which the longer one counts; for `axial_length`;
    `coaxial` by default.
    """
    price: "float | str | None"
    """Of motor and gear together, or of a module; needs [prices] [money]."""
    lead_time: "float | str | None"
    """The longest of motor and gear, or of a module [time]."""
    reflected_inertia: "float | str | None"
    """N² (J_m + J_g) at the output; through a `transmission` at the joint [inertia]."""
    winding_temperature: "float | str | None"
    """Highest; the motor's own holds too [temperature]."""
    shock_torque: "float | str | None"
    """Of a few shocks in a life, at the output; the gear's momentary peak and ratcheting torque are compared with it
    [torque].
    """
    max_backlash: "float | str | None"
    """Largest of the gear, at the output [angle]."""
    min_stiffness: "float | str | None"
    """Smallest of the gear, torsional, at the output [stiffness]."""
    max_backdriving_torque: "float | str | None"
    """Largest that sets the actuator going without current, at the output [torque]."""
    safety: "float | None"
    """Factor on demanded torque and current, not on heat; 1 by default."""
    reserve: "Mapping[str, object] | None"
    """What of each limit is left, by its name; `all` for those that are not named."""

    def __init__(
        self,
        *,
        spring: "Mapping[str, object] | None" = None,
        torque_bandwidth: "Mapping[str, object] | None" = None,
        life: "float | str | None" = None,
        life_quantile: "str | None" = None,
        actuator_mass: "float | str | None" = None,
        outer_diameter: "float | str | None" = None,
        axial_length: "float | str | None" = None,
        arrangement: "str | None" = None,
        price: "float | str | None" = None,
        lead_time: "float | str | None" = None,
        reflected_inertia: "float | str | None" = None,
        winding_temperature: "float | str | None" = None,
        shock_torque: "float | str | None" = None,
        max_backlash: "float | str | None" = None,
        min_stiffness: "float | str | None" = None,
        max_backdriving_torque: "float | str | None" = None,
        safety: "float | None" = None,
        reserve: "Mapping[str, object] | None" = None,
    ) -> None:
        """Words of a requirement; what is left out holds as in a file."""
        self._fill(spring=spring, torque_bandwidth=torque_bandwidth, life=life, life_quantile=life_quantile, actuator_mass=actuator_mass, outer_diameter=outer_diameter, axial_length=axial_length, arrangement=arrangement, price=price, lead_time=lead_time, reflected_inertia=reflected_inertia, winding_temperature=winding_temperature, shock_torque=shock_torque, max_backlash=max_backlash, min_stiffness=min_stiffness, max_backdriving_torque=max_backdriving_torque, safety=safety, reserve=reserve)


@final
class Joint(Words):
    """What a joint has to do, and what may be chosen for it. A number is SI, a text has its unit ("48 V"); what is left
    out holds as in a file.
    """

    __slots__ = ('name', 'motion', 'count', 'modules', 'family', 'ratio', 'gears', 'gear', 'scale', 'case', 'mechanism_joint', 'periodic', 'period', 'repeat_every', 'points', 'transmission', 'objective', 'reference', 'limits', 'spring', 'mount', 'drive', 'motor_drag', 'torque_per_mass', 'motors', 'exclude', 'turns', 'phases', 'efficiency_covers', 'between', 'lead', 'actuator_at', 'order',)
    _keys = {}

    name: "str"
    """Name of the joint; required."""
    motion: "Motion | str | PathLike[str] | None"
    """CSV file next to this one; this or `points`."""
    count: "int | None"
    """How many joints like this; 1 by default."""
    modules: "Sequence[str] | None"
    """Modules that may be chosen, by id or maker, `*` for any run of characters; next to motors where the joint has
    `ratio`, `gears` or `family`, else alone.
    """
    family: "Sequence[str] | None"
    """Families of gears by name, `*` for any run of characters: each of their points is a gear; this or `ratio`."""
    ratio: "tuple[float, float] | Mapping[str, object] | None"
    """The ratios that may be chosen: any between two, a grid, or a list; this or `gears` or `family`."""
    gears: "Sequence[str] | None"
    """Gears of the catalogue by id, `*` for any run of characters; this or `ratio`."""
    gear: "Gear | Mapping[str, object] | None"
    """The gear that goes with a continuous ratio; an ideal one by default."""
    scale: "Mapping[str, object] | None"
    """Factors on the motion; they hold before `repeat_every` is looked at."""
    case: "Sequence[Mapping[str, object]] | None"
    """Load cases in place of one motion: each with a motion or points of its own; this or `motion`."""
    mechanism_joint: "str | None"
    """A joint of `[mechanism]`; this or `motion`."""
    periodic: "bool | None"
    """Whether the motion repeats; true by default."""
    period: "float | str | None"
    """Of a motion whose last row does not repeat the first [time]."""
    repeat_every: "float | str | None"
    """Of a motion that happens once (`periodic = false`): from one start to the next, with rest in between; without it
    heat starts cold [time].
    """
    points: "Sequence[Mapping[str, object]] | None"
    """Operating points, each for itself; this or `motion`."""
    transmission: "Mapping[str, object] | None"
    """What is between the actuator and the joint: one of `ratio`, `table`, `four_bar`, `lever`; nothing by default."""
    objective: "str | Mapping[str, object] | None"
    """What is minimised; a weight, also a single one, is a pure number; `balanced` by default."""
    reference: "Mapping[str, object] | None"
    """What each weighted quantity is divided by."""
    limits: "Limits | Mapping[str, object] | None"
    """What a choice must keep."""
    spring: "Mapping[str, object] | None"
    """A parallel spring to be chosen with the ratio; may be in `[limits]`."""
    mount: "Mapping[str, object] | None"
    """How the motor is mounted here."""
    drive: "Mapping[str, object] | None"
    """The drive of this joint, in place of the bus's."""
    motor_drag: "str | None"
    """`off` leaves out what no-load currents and estimates say of a motor's drag; `counted` by default."""
    torque_per_mass: "Mapping[str, object] | None"
    """What a kilogram of the actuator of a joint, by its name, adds to this joint's torque."""
    motors: "Sequence[str] | None"
    """Motors that may be chosen, by id or maker, `*` for any run of characters; all by default."""
    exclude: "Sequence[str] | None"
    """Motors that may not be chosen, by id or maker."""
    turns: "Sequence[float] | Mapping[str, float] | None"
    """Turns of the winding as multiples of the row's: any between two, as `{ min = 0.5, max = 2 }`, or of a list, where
    0.577 is a star connected in delta and 0.5 two halves in parallel; the row's own where it is not given.
    """
    phases: "Sequence[float] | Mapping[str, float] | None"
    """By how much of the period each of the `count` joints is late, 0 to 1."""
    efficiency_covers: "str | None"
    """What the efficiency of these gears is counted for; `load` by default."""
    between: "bool | None"
    """Whether a ratio between two points of the family may be chosen, where the gear is interpolated; one family then;
    false by default.
    """
    lead: "float | str | None"
    """With `mechanism_joint`, where that slides: travel per turn of the gear's output [length]."""
    actuator_at: "Mapping[str, object] | None"
    """With `mechanism_joint`: where the actuator sits; at the joint by default."""
    order: "Sequence[Mapping[str, object]] | None"
    """The sequence of load cases, in which heat is followed; it is made again and again."""

    def __init__(
        self,
        name: "str",
        motion: "Motion | str | PathLike[str] | None" = None,
        *,
        count: "int | None" = None,
        modules: "Sequence[str] | None" = None,
        family: "Sequence[str] | None" = None,
        ratio: "tuple[float, float] | Mapping[str, object] | None" = None,
        gears: "Sequence[str] | None" = None,
        gear: "Gear | Mapping[str, object] | None" = None,
        scale: "Mapping[str, object] | None" = None,
        case: "Sequence[Mapping[str, object]] | None" = None,
        mechanism_joint: "str | None" = None,
        periodic: "bool | None" = None,
        period: "float | str | None" = None,
        repeat_every: "float | str | None" = None,
        points: "Sequence[Mapping[str, object]] | None" = None,
        transmission: "Mapping[str, object] | None" = None,
        objective: "str | Mapping[str, object] | None" = None,
        reference: "Mapping[str, object] | None" = None,
        limits: "Limits | Mapping[str, object] | None" = None,
        spring: "Mapping[str, object] | None" = None,
        mount: "Mapping[str, object] | None" = None,
        drive: "Mapping[str, object] | None" = None,
        motor_drag: "str | None" = None,
        torque_per_mass: "Mapping[str, object] | None" = None,
        motors: "Sequence[str] | None" = None,
        exclude: "Sequence[str] | None" = None,
        turns: "Sequence[float] | Mapping[str, float] | None" = None,
        phases: "Sequence[float] | Mapping[str, float] | None" = None,
        efficiency_covers: "str | None" = None,
        between: "bool | None" = None,
        lead: "float | str | None" = None,
        actuator_at: "Mapping[str, object] | None" = None,
        order: "Sequence[Mapping[str, object]] | None" = None,
    ) -> None:
        """Words of a requirement; what is left out holds as in a file."""
        self._fill(name=name, motion=motion, count=count, modules=modules, family=family, ratio=ratio, gears=gears, gear=gear, scale=scale, case=case, mechanism_joint=mechanism_joint, periodic=periodic, period=period, repeat_every=repeat_every, points=points, transmission=transmission, objective=objective, reference=reference, limits=limits, spring=spring, mount=mount, drive=drive, motor_drag=motor_drag, torque_per_mass=torque_per_mass, motors=motors, exclude=exclude, turns=turns, phases=phases, efficiency_covers=efficiency_covers, between=between, lead=lead, actuator_at=actuator_at, order=order)


@final
class Robot(Words):
    """A robot: its supply and its joints. A number is SI, a text has its unit ("48 V"); what is left out holds as in a
    file.
    """

    __slots__ = ('name', 'bus', 'joints', 'rules', 'ambient', 'budget', 'prices', 'mechanism', 'case', 'coupling',)
    _keys = {"joints": "joint"}

    name: "str"
    """Name of the robot; required."""
    bus: "Bus | Mapping[str, object]"
    """The supply; required."""
    joints: "Sequence[Joint | Mapping[str, object]]"
    """The joints, at least one; required."""
    rules: "str | PathLike[str] | None"
    """Rules file that a design has to keep, for `optimize` and `check`."""
    ambient: "float | str | Mapping[str, object] | None"
    """The surroundings."""
    budget: "Mapping[str, object] | None"
    """What the whole robot may have."""
    prices: "Mapping[str, object] | None"
    """In what currency prices are counted: without it no price is."""
    mechanism: "Mapping[str, object] | None"
    """A description of the robot that torques are computed from."""
    case: "Sequence[Mapping[str, object]] | None"
    """Load cases of the joints that happen together; what no [[case]] has happens by name."""
    coupling: "Sequence[Mapping[str, object]] | None"
    """Two joints that two equal actuators move together: differential, parallel ankle."""

    def __init__(
        self,
        name: "str",
        bus: "Bus | Mapping[str, object]",
        joints: "Sequence[Joint | Mapping[str, object]]",
        *,
        rules: "str | PathLike[str] | None" = None,
        ambient: "float | str | Mapping[str, object] | None" = None,
        budget: "Mapping[str, object] | None" = None,
        prices: "Mapping[str, object] | None" = None,
        mechanism: "Mapping[str, object] | None" = None,
        case: "Sequence[Mapping[str, object]] | None" = None,
        coupling: "Sequence[Mapping[str, object]] | None" = None,
    ) -> None:
        """Words of a requirement; what is left out holds as in a file."""
        self._fill(name=name, bus=bus, joints=joints, rules=rules, ambient=ambient, budget=budget, prices=prices, mechanism=mechanism, case=case, coupling=coupling)
