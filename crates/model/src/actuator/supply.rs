//! What the supply makes of the power at a motor's terminals: what is drawn, what of that which comes back is kept, and how
//! far the bus sags.
//!
//! The one idea: with y the bus voltage that a sample needs and P_b what it draws from the bus, a supply of open-circuit
//! voltage V_oc and resistance R_i holds y exactly where `y + R_i P_b/y ≤ V_oc` (with y at least V_oc/2, below which no supply
//! gives more power). So the open-circuit voltage that a sample needs is a number like any other demand. Multiplied out it is
//! `y² + R_i P_b ≤ V_oc y`; the root that y is lies below its tangents in y², and each tangent leaves a sum of |v|² and P_b
//! with weights that are not negative: a row of the kind that the ratio program has.

use super::shaft::{Actuator, FEATURES, Flow};
use crate::numerics::laurent::Laurent;
use crate::requirement::Bus;

/// What power at the terminals costs, and what of it is kept where it comes back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drawn {
    /// Drawn per watt that the motor takes: 1/η_d.
    taken: f64,
    /// Share of what the motor gives back that reaches the bus.
    arrives: f64,
    /// Share of what the motor gives back that is kept, η_r; no more than what reaches the bus.
    kept: f64,
    /// Most that is kept at any instant \[W\].
    most: f64,
}

impl Drawn {
    /// Of a bus.
    pub fn new(bus: &Bus) -> Drawn {
        let kept = bus.regeneration_efficiency.unwrap_or(bus.drive_efficiency);
        // Without a brake what is more is a limit.
        let most = if bus.is_braked() { bus.goes_back() * kept / bus.drive_efficiency } else { f64::INFINITY };
        Drawn { taken: 1.0 / bus.drive_efficiency, arrives: bus.drive_efficiency, kept, most }
    }

    /// What is drawn per power at the terminals, of what is kept without a cap.
    pub fn per_power(&self, power: f64) -> f64 {
        if power > 0.0 { self.taken } else { self.kept }
    }

    /// What is drawn for a power at the terminals \[W\], negative where it is kept, as a straight line that touches it and
    /// is nowhere above it: slope and constant.
    pub fn line(&self, power: f64) -> (f64, f64) {
        if -power * self.kept > self.most { (0.0, -self.most) } else { (self.per_power(power), 0.0) }
    }

    /// Share of what the motor gives back that reaches the bus.
    pub fn arrives(&self) -> f64 {
        self.arrives
    }

    /// Whether what is drawn is what the motor takes, and what it gives back is kept.
    pub fn is_lossless(&self) -> bool {
        self.taken == 1.0 && self.kept == 1.0 && self.most == f64::INFINITY
    }

    /// The same where all that reaches the bus is kept: what the drive alone makes of it.
    #[must_use]
    pub fn by_drive(self) -> Drawn {
        Drawn { kept: self.arrives, most: f64::INFINITY, ..self }
    }
}

/// A supply that sags.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Supply {
    /// Open-circuit voltage, less what is kept in reserve of it \[V\].
    open: f64,
    /// Resistance of the supply and of the leads to the drive \[Ω\].
    resistance: f64,
    /// Voltage on the q-axis circle per bus voltage.
    circle: f64,
    /// Bus voltage that is lost in the drive whatever the modulation \[V\].
    lost: f64,
    /// What is drawn from the bus; of what comes back, what is kept is what lifts it for sure.
    drawn: Drawn,
    /// Whether a brake takes power that comes back, and the most that goes back into the supply then \[W\].
    is_braked: bool,
    goes_back: f64,
    /// Power that the drive takes whatever the motor does \[W\].
    standby: f64,
}

impl Supply {
    /// Of a bus with a resistance to the drive \[Ω\]: the circle's radius is `circle` times its voltage, less `shortfall`
    /// \[V\]; `standby` is what the drive takes \[W\], `reserve` the share of the open-circuit voltage that is not used.
    pub fn new(bus: &Bus, resistance: f64, (circle, shortfall): (f64, f64), standby: f64, reserve: f64) -> Supply {
        Supply {
            open: bus.voltage * (1.0 - reserve),
            resistance,
            circle,
            lost: shortfall / circle,
            drawn: Drawn::new(bus),
            is_braked: bus.is_braked(),
            goes_back: bus.goes_back(),
            standby,
        }
    }

    /// What a sample draws from the bus per power at the terminals \[W/W\]. What a brake takes does not lift the bus for sure.
    fn per_power(&self, power: f64) -> f64 {
        if power <= 0.0 && self.is_braked { 0.0 } else { self.drawn.per_power(power) }
    }

    /// Bus voltage with which a sample is looked at \[V\], for the square of the voltage at the motor \[V²\].
    fn held(&self, voltage_squared: f64) -> f64 {
        (voltage_squared.max(0.0).sqrt() / self.circle + self.lost).max(0.5 * self.open)
    }

    /// Open-circuit voltage that a sample needs \[V\], from the square of its voltage \[V²\] and its power at the terminals
    /// \[W\]. It grows with both.
    #[inline]
    pub fn needed(&self, voltage_squared: f64, power: f64) -> f64 {
        let held = self.held(voltage_squared);
        held + self.resistance * (self.per_power(power) * power + self.standby) / held
    }

    /// An upper bound of [`Supply::needed`] over squares of voltages and powers up to these.
    #[inline]
    pub fn needed_at_most(&self, voltage_squared: f64, power: f64) -> f64 {
        // Convex in the held voltage: the larger of both ends.
        let drawn = self.resistance * (self.per_power(power) * power + self.standby);
        let (low, high) = (0.5 * self.open, self.held(voltage_squared));
        (low + drawn / low).max(high + drawn / high)
    }

    /// The weights of |v|² and of the power at the terminals in the row that touches what is needed, and its constant; the
    /// row is at most the open-circuit voltage wherever what is needed is.
    pub fn row(&self, voltage_squared: f64, power: f64) -> [f64; 3] {
        let held = self.held(voltage_squared);
        let least = held - self.lost;
        let open = (self.open - 2.0 * self.lost).max(0.0);
        let share = if open > 0.0 { (1.0 - open / (2.0 * least)).max(0.0) } else { 1.0 };
        let bound = 0.5 * open * least + self.lost * (self.open - self.lost);
        [
            share / (self.circle * self.circle * held),
            self.resistance * self.per_power(power) / held,
            self.open + (self.resistance * self.standby - bound) / held,
        ]
    }

    /// The row as a polynomial of a sample, by its voltage and power there.
    pub(super) fn polynomial(
        &self,
        actuator: &Actuator,
        flow: Flow,
        features: &[f64; FEATURES],
        ratio: f64,
    ) -> Laurent {
        self.touching(self.terminals(actuator, (flow, features), ratio), ratio)
    }

    /// The polynomial that touches the open-circuit voltage at a ratio, from those of squared voltage and power.
    fn touching(&self, (voltage, power): (Laurent, Laurent), ratio: f64) -> Laurent {
        let [of_voltage, of_power, constant] = self.row(voltage.at(ratio), power.at(ratio));
        voltage * of_voltage + power * of_power + Laurent::constant(constant)
    }

    /// Squared voltage \[V²\] and power taken \[W\] of a sample: of the hottest or the coldest winding, whichever needs more at a ratio.
    fn terminals(
        &self,
        actuator: &Actuator,
        (flow, features): (Flow, &[f64; FEATURES]),
        ratio: f64,
    ) -> (Laurent, Laurent) {
        let of = |winding: Actuator| {
            let power = winding.power_near(winding.loss_taken(), flow, features, ratio);
            (winding.voltage_squared_near(flow, features, ratio), power)
        };
        let [hot, cold] = actuator.windings().map(of);
        let needed = |(voltage, power): &(Laurent, Laurent)| self.needed(voltage.at(ratio), power.at(ratio));
        if needed(&cold) > needed(&hot) { cold } else { hot }
    }

    /// The same of a sample at a ratio \[W\], and the polynomial that touches it there; it is nothing or less wherever the sample keeps to
    /// the supply.
    pub fn beyond(
        &self,
        actuator: &Actuator,
        (flow, features): (Flow, &[f64; FEATURES]),
        ratio: f64,
        shared: f64,
    ) -> (f64, Laurent) {
        let terminals = self.terminals(actuator, (flow, features), ratio);
        let row = self.touching(terminals, ratio) + Laurent::constant(-self.open);
        let (beyond, held) = self.asks_beyond((terminals.0.at(ratio), terminals.1.at(ratio)), shared);
        (beyond, row * (held / shared))
    }

    /// By how much power a sample asks for more than there is at the bus voltage that it needs \[W\], as much less than nothing may others
    /// draw, and that voltage \[V\]; from its squared voltage \[V²\] and power \[W\], where others draw through a resistance \[Ω\] too.
    pub fn asks_beyond(&self, (voltage, power): (f64, f64), shared: f64) -> (f64, f64) {
        let held = self.held(voltage);
        ((self.needed(voltage, power) - self.open) * held / shared, held)
    }

    /// Bus voltage \[V\] where so much is drawn at the terminals \[W\]; `None` where the supply cannot give it.
    pub fn voltage(&self, power: f64) -> Option<f64> {
        self.at(self.per_power(power) * power + self.standby)
    }

    /// The highest bus voltage \[V\] where so much comes back at the terminals \[W\], from above.
    pub fn lifted(&self, back: f64) -> f64 {
        self.at(self.through(-back.max(0.0))).unwrap_or(self.open)
    }

    /// Heat in the resistance \[W\], R (P/V)², where so much is taken at the terminals \[W\], negative where it comes back; `None` where the
    /// supply cannot give it.
    pub fn heat(&self, power: f64) -> Option<f64> {
        let through = self.through(power);
        let current = through / self.at(through)?;
        Some(self.resistance * current * current)
    }

    /// What goes through the resistance \[W\] where so much is taken at the terminals \[W\], negative where it goes back: of what comes
    /// back all that reaches the bus and no brake takes for sure.
    fn through(&self, power: f64) -> f64 {
        if power > 0.0 {
            return self.drawn.taken * power + self.standby;
        }
        let most = if self.is_braked { self.goes_back } else { f64::INFINITY };
        (self.standby + self.drawn.arrives * power).max(-most)
    }

    /// Bus voltage where the supply gives so much \[W\].
    fn at(&self, drawn: f64) -> Option<f64> {
        let root = self.open * self.open - 4.0 * self.resistance * drawn;
        (root >= 0.0).then(|| 0.5 * (self.open + root.sqrt()))
    }
}
