//! What is asked of a gear beside its limits: what arrives of the power at a usual and at the largest load, what turns it from its
//! output, how long it lasts.
//!
//! The one idea: an efficiency is that of the load alone, η_∞, and the torque without load T_0 = c_g + b_g n at the input; at an output
//! torque τ they make 1/η = 1/η_∞ + N T_0/|τ|. Where either is not known nothing is said.

use super::candidate::Candidate;
use super::limits::backdriving_torque;
use crate::catalog::Gear;

/// Figures of a gear at a ratio; each `None` where a number of it is not known.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct GearFigures {
    /// Efficiency when the motor drives, at the mean of the load's torque and of the speed over the time that is not at standstill.
    pub efficiency_at_mean: Option<f64>,
    /// The same at the largest load torque of the motion, and the speed there.
    pub efficiency_at_peak: Option<f64>,
    /// Torque at the output that sets motor and gear going without current \[N·m\], with the motor's Coulomb friction at its worse
    /// end; infinite where the gear locks.
    pub backdriving_torque: Option<f64>,
    /// L10 life in this motion \[s\], with its pauses.
    pub life: Option<f64>,
}

impl Candidate<'_> {
    /// Figures of the gear at a ratio.
    pub fn gear_figures(&self, ratio: f64) -> GearFigures {
        let load = self.load;
        let [mean, peak] = [load.running_load, load.at_peak_torque()];
        GearFigures {
            efficiency_at_mean: load.has_durations.then(|| self.gear_efficiency(ratio, mean)).flatten(),
            efficiency_at_peak: self.gear_efficiency(ratio, peak),
            backdriving_torque: backdriving_torque(self, ratio),
            life: self.gear_life(ratio),
        }
    }

    /// Efficiency at a torque \[N·m\] and a speed \[rad/s\] of the output; `None` where the efficiency of the load or the torque without
    /// load is not known, and where there is no load.
    fn gear_efficiency(&self, ratio: f64, (torque, speed): (f64, f64)) -> Option<f64> {
        let gear = &self.gear;
        let is_whole = self.catalog_gear.is_some_and(Gear::loss_is_in_efficiency);
        // A requirement that says no efficiency has one of 1.
        let says = self.catalog_gear.is_some() || gear.efficiency != 1.0;
        gear.friction_at_rest.filter(|_| says && !is_whole && torque > 0.0)?;
        let without_load = gear.no_load.coulomb + gear.no_load.viscous * ratio * speed;
        Some(1.0 / (1.0 / gear.efficiency + ratio * without_load / torque))
    }

    /// L10 \[s\] from L_10 (n_N/n_av)(T_N/T_av)³; `None` where nothing is known of it, nothing moves under load, or a spring is chosen,
    /// whose torque the gear's wear does not have.
    fn gear_life(&self, ratio: f64) -> Option<f64> {
        let rated = self.gear.ratings.rated(self.gear.continuous_torque).ok()?;
        let load = self.load;
        let wears = load.has_durations && load.mean_wear > 0.0 && self.joint.limits.spring.is_none();
        wears.then(|| rated.life * rated.speed * rated.torque.powi(3) / (ratio * load.mean_wear))
    }
}
