//! The currents along d that the samples of a joint need at a ratio.

use super::shaft::Actuator;
use super::waveform::{Functional, Waveform};
use super::weakening::{AlongD, Parabola};

/// What currents along d are for, at a ratio.
#[derive(Debug, Clone, Copy)]
pub struct Needs {
    along: AlongD,
    /// The equations at one end of the motor's drag, and at the other where there is one.
    first: Actuator,
    other: Option<Actuator>,
    ratio: f64,
    /// Squared voltage that is kept, and that with the bandwidth torque on top \[V²\].
    voltages: [f64; 2],
}

impl Needs {
    /// Of equations at one or both ends of the motor's drag.
    pub(crate) fn new(
        along: AlongD,
        (first, other): (Actuator, Option<Actuator>),
        ratio: f64,
        voltages: [f64; 2],
    ) -> Needs {
        Needs { along, first, other, ratio, voltages }
    }

    fn ends(&self) -> impl Iterator<Item = &Actuator> {
        std::iter::once(&self.first).chain(&self.other)
    }

    /// The needs of each end alone, where the motor's drag has two and a current that burns returned power differs between them: it is no
    /// current that lowers the voltage of the other end. A field is weakened by what the voltage asks for, at either end.
    pub(crate) fn of_each_end(&self) -> Vec<Needs> {
        match self.along {
            AlongD::Braking { .. } if self.other.is_some() => {
                self.ends().map(|end| Needs { first: *end, other: None, ..*self }).collect()
            }
            _ => Vec::new(),
        }
    }

    /// Points need one where so much of a functional is more than its bound; `rippled` with the bandwidth torque on top.
    fn asks(&self, rippled: bool) -> (Functional, f64) {
        match self.along {
            // A hair less than there is, so that rounding does not break what is met with equality.
            AlongD::Weakening(_) => (Functional::VoltageSquared, self.voltages[usize::from(rippled)] * (1.0 - 1e-13)),
            AlongD::Braking { beyond, .. } => (Functional::PowerBack, beyond),
        }
    }

    /// Whether some point of a waveform needs one, at either end of the drag.
    pub(crate) fn any(&self, waveform: &Waveform, rippled: bool) -> bool {
        let (functional, bound) = self.asks(rippled);
        self.ends().any(|end| waveform.largest(functional, end, self.ratio).value > bound)
    }

    /// The points of a waveform that need one, at either end of the drag, as indices in their order.
    pub fn points(&self, waveform: &Waveform) -> Vec<usize> {
        let (functional, bound) = self.asks(false);
        let beyond = |end| waveform.beyond(functional, end, self.ratio, bound);
        let mut points: Vec<usize> = self.ends().flat_map(beyond).collect();
        points.sort_unstable();
        points.dedup();
        points
    }

    /// The same with the least current that each needs at an end of the drag, times the torque constant \[N·m\], < 0, in no order; it
    /// is the largest of both ends'. `rippled` with the bandwidth torque on top.
    pub(crate) fn currents(&self, waveform: &Waveform, rippled: bool) -> Vec<(usize, f64)> {
        let (functional, bound) = self.asks(rippled);
        let of_end = |end: &Actuator| {
            let here = waveform.at(end, self.ratio);
            let current = |k: usize| match self.along {
                AlongD::Weakening(most) => {
                    let least = |parabola: Parabola| parabola.least(bound, most * end.torque_constant);
                    here.parabolas(k).map(least).into_iter().fold(0.0, f64::min)
                }
                AlongD::Braking { beyond, most } => {
                    // A hair more than there is, for the same reason.
                    let (back, size) = here.power_back(k);
                    let square = (back - beyond + 1e-14 * size) / end.loss_returned();
                    -square.max(0.0).sqrt().min(most * end.torque_constant)
                }
            };
            let points = waveform.beyond(functional, end, self.ratio, bound).into_iter();
            points.map(|k| (k, current(k))).filter(|(_, d)| *d < 0.0).collect::<Vec<(usize, f64)>>()
        };
        self.ends().flat_map(of_end).collect()
    }

    /// No current along d is larger, times the torque constant \[N·m\].
    pub(crate) fn most(&self) -> f64 {
        let (AlongD::Weakening(most) | AlongD::Braking { most, .. }) = self.along;
        most * self.first.torque_constant
    }
}
