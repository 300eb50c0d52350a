"""A design: a motor with its ratio or gear at a joint."""

# Written by python/generate.py: change the reader or the schema, not this file.

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from typing import Any

from gearwise._light import final
from gearwise._table import Record


@final
class Design(Record):
    """A motor with its ratio or gear at a joint. Its attributes are the keys of the JSON, in SI with the unit in the name;
    what is not known is None.
    """

    __slots__ = ()

    motor: "str"
    """Id of the motor."""
    gear: "str | None"
    """Id of the gear, where it is one of the catalogue."""
    ratio: "float"
    """Ratio N."""
    teeth: "Mapping[str, Any] | None"
    """Teeth of a gear of this ratio, where the requirement lists the stages."""
    family: "Mapping[str, Any] | None"
    """Where the ratio lies among the points of its gear family, where it may lie between them."""
    feasible: "bool"
    """Whether every limit that could be checked is kept."""
    objective: "float | None"
    """Objective; `null` where a number that it needs is not known."""
    objective_unit: "str"
    """Unit of the objective; `1` for a weighted sum."""
    losses_w: "Mapping[str, Any]"
    """Where the loss is, by its parts: they sum to `loss_w`."""
    unknown_losses: "Sequence[str] | None"
    """Parts of the loss of which nothing is known."""
    loss_w: "float | None"
    """Mean of all losses that are known: copper, motor drag, gear, drive."""
    copper_loss_w: "float | None"
    """Mean copper loss."""
    loss_at_least_w: "float | None"
    """The least that the loss may be, by what is known of the motor's drag."""
    motor_drag_loss_w: "float | None"
    """Part of the loss: bearings, hysteresis and eddy currents of the motor."""
    gear_loss_w: "float | None"
    """Part of the loss: the gear's, under load and without."""
    gear_efficiency_at_mean: "float | None"
    """Efficiency of the gear with its torque without load, at the means of torque and speed over the time that is not at
    standstill; where both are known.
    """
    gear_efficiency_at_peak: "float | None"
    """Efficiency of the gear with its torque without load, at the largest load torque and the speed there; where both are
    known.
    """
    gear_backdriving_torque_nm: "float | None"
    """Torque at the output that sets motor and gear going without current, N (c + c_g)/η_b, the motor's friction at its
    worse end; behind a transmission at the joint; where it is known.
    """
    gear_l10_life_s: "float | None"
    """How long nine in ten gears last in this motion with its pauses, from the rated life; where that is known."""
    drive_loss_w: "float | None"
    """Part of the loss: resistance of drive and leads, standby, and what the drive's efficiency takes."""
    braking_loss_w: "float | None"
    """Part of the loss: what comes back to the bus and is not kept, in a braking resistor or in the supply."""
    field_weakening_current_a: "float | None"
    """Largest current against the magnets, amplitude of a phase; where `field_weakening_current` or `flux_braking` is
    given.
    """
    field_weakening_loss_w: "float | None"
    """Part of the copper loss: that of the current against the magnets."""
    field_weakening_rate: "float | None"
    """Largest voltage of a changing current against the magnets, which the voltage leaves out, as a share of the voltage
    limit; from one sample to the next.
    """
    lowest_bus_voltage_v: "float | None"
    """Voltage of the bus at the instant of most power, by this joint alone; where `internal_resistance` is given."""
    highest_bus_voltage_v: "float | None"
    """Voltage of the bus at the instant of most power that comes back, by this joint alone; where `internal_resistance` is
    given.
    """
    supply_heat_w: "float | None"
    """Mean heat in the resistance of the supply and its leads, by this joint alone; not in the loss; where
    `internal_resistance` is given.
    """
    mean_electrical_power_w: "float | None"
    """Mean electrical power at the motor's terminals."""
    energy_per_cycle_j: "float | None"
    """Energy drawn from the bus per cycle."""
    peak_electrical_power_w: "float | None"
    """Largest electrical power drawn from the bus."""
    rms_current_phase_a: "float | None"
    """Root mean square of the current as the drive is bought: phase amplitude, DC of a brushed motor."""
    rms_current_q_a: "float | None"
    """Root mean square of the q-axis current."""
    peak_current_phase_a: "float | None"
    """Largest current as the drive is bought: phase amplitude, DC of a brushed motor."""
    peak_current_q_a: "float | None"
    """Largest q-axis current."""
    reflected_inertia_kgm2: "float | None"
    """Inertia of rotor and gear at the output, N² (J_m + J_g); behind a transmission that at the joint, r² (N² (J_m + J_g)
    + J_t) + J_j at the largest r of the motion.
    """
    mass_kg: "float | None"
    """Mass of motor and gear."""
    price: "float | None"
    """Price of motor and gear, or of a module, in the currency of `[prices]`; where all of it is known."""
    lead_time_s: "float | None"
    """Longest lead time of motor and gear, or that of a module; where all of it is known."""
    winding_temperature_k: "float | None"
    """Steady winding temperature."""
    reversal_time_s: "float | None"
    """Longest time the current needs for its jump where the motion reverses, L Δi/(V − R i)."""
    price_currency: "str | None"
    """Currency of `price` and `price_at_least`, where the requirement has `[prices]`."""
    price_at_least: "float | None"
    """Price of the parts of which it is known, where the requirement has `[prices]`."""
    thermal_runaway: "bool"
    """Whether the winding has no steady temperature: the copper's resistance rises faster than heat flows off."""
    margins: "Mapping[str, float | None]"
    """Margin of each limit, `1 − demand/limit`, by its name."""
    limits: "Sequence[Mapping[str, Any]]"
    """Each limit in full."""
    not_checked: "Sequence[Mapping[str, Any]]"
    """Limits that could not be checked, and why."""
    assumed: "Sequence[Mapping[str, Any]]"
    """Limits that count as kept, and as far as what holds."""
    estimated: "Sequence[Mapping[str, Any]]"
    """Numbers of the motor that its row lacks and that are estimated."""
    audit_errors: "Sequence[str]"
    """What the audit calls an error in the motor's row."""
    fitted: "Sequence[Mapping[str, Any]] | None"
    """How what was fitted to this motor enters the limits."""
    window: "tuple[float, float]"
    """Feasible ratios about the best one."""
    binds: "Mapping[str, Any]"
    """What ends the window: a limit that is exceeded beyond it, or where `binds_at` has `unjudged`, one that cannot be
    judged there.
    """
    binds_at: "Mapping[str, Any]"
    """The same with the instant at which they do."""
    windows: "Sequence[Mapping[str, Any]]"
    """Every interval of feasible ratios."""
    shadow_prices: "Mapping[str, float | None]"
    """Change of the objective per unit of each limit that binds at the best ratio, SI."""
    sensitivity: "Mapping[str, float | None]"
    """The same relative to both: per cent of the objective per per cent of the limit."""
    certificate: "Mapping[str, Any]"
    """How sure it is that no ratio is better."""
    metrics: "Mapping[str, Any]"
    """Metrics of the bare motor, SI."""
    spring: "Mapping[str, Any] | None"
    """The parallel spring, where the joint asks for one."""
