//! A candidate at one ratio, where something of it has to be evaluated there.

use super::along_d::Needs;
use super::candidate::Candidate;
use super::fitted;
use super::shaft::Flow;

impl Candidate<'_> {
    /// The candidate at one ratio, with the effects that have to be evaluated there in its samples.
    pub fn at_ratio<T>(&self, ratio: f64, look: impl FnOnce(&Candidate) -> T) -> T {
        if self.by_ratio.is_some() {
            return self.standing_at(ratio).at_ratio(ratio, look);
        }
        if let Some(map) = self.whole_map() {
            return look(&Candidate { folded: true, ..self.with_gear(map.gear(&self.gear, ratio), None) });
        }
        if !self.has_evaluated_effects() {
            return Candidate { folded: true, ..*self }.weakened(ratio, look);
        }
        let form = self.actuator.torque_form(Flow::Driving);
        let load = self.load.folded(|velocity, towards, acceleration| {
            fitted::folded(self.motor, form, ratio, velocity, towards, acceleration)
        });
        let other = self.other.map(|other| other.folded());
        Candidate { load: &load, actuator: self.actuator.folded(), other, folded: true, ..*self }.weakened(ratio, look)
    }

    /// The same with the least currents against the magnets that do at a ratio what they are for: keep the voltage, with the
    /// winding at its hottest, or burn power that comes back. At the end of the motor's drag that asks for more.
    fn weakened<T>(&self, ratio: f64, look: impl FnOnce(&Candidate) -> T) -> T {
        match self.needs_along_d(ratio).and_then(|needs| self.load.weakened(needs)) {
            Some(load) => look(&Candidate { load: &load, ..*self }),
            None => look(self),
        }
    }

    /// What currents along d are for at a ratio; `None` where there are none.
    pub fn needs_along_d(&self, ratio: f64) -> Option<Needs> {
        let voltages = ["voltage", "torque_bandwidth_voltage"].map(|limit| self.voltage_squared(limit));
        Some(Needs::new(self.along_d()?, (self.actuator, self.other), ratio, voltages))
    }
}
