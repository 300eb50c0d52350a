//! A joint's demand on a piece of a family of gears.
//!
//! The one idea: which way power flows at a sample does not depend on the ratio. So what a gear's numbers make of the load is
//! folded into the samples once: (φ₀ τ + J₁ α + t₁ sgn ω)/N in place of the load, and φ₁ τ N in place of a feature that no
//! catalogue row has. Every equation keeps its powers of the ratio.

use super::{FEATURES, Feature, Flow, Laurent, Load, WavePoint, Waveform};
use crate::requirement::{GearMap, GearModel, GearPiece, Line};

impl Load {
    /// The same with itself on each piece of a family of gears; what that does not say is that of `base`.
    #[must_use]
    pub fn with_pieces(self, map: &GearMap, base: &GearModel) -> Load {
        let pieces = map.pieces().iter().map(|piece| self.on_piece(piece, base)).collect();
        Load { pieces, ..self }
    }

    /// The load on each piece of the family of gears, where it was made with one.
    pub fn pieces(&self) -> &[Load] {
        &self.pieces
    }

    /// On a piece of a family of gears: what its efficiency takes of the power that goes through it, and its torque without
    /// load that falls with the ratio \[W\].
    pub(crate) fn gear_loss(&self) -> Option<Laurent> {
        self.gear_loss
    }

    /// The same on a piece of a family of gears. Its feature `Load` is what comes with 1/N, gear included, and `Speed` and
    /// `SpeedRate` what of the load comes with N. The gear's own limits stay on the torque at its output.
    pub fn on_piece(&self, piece: &GearPiece, base: &GearModel) -> Load {
        let [driving, braking] = piece.load(base);
        let (inertia, no_load) = (piece.inertia(base).per_power, piece.no_load(base).per_power);
        let through = |flow: Flow| match flow {
            Flow::Driving => driving,
            Flow::Braking => braking,
            Flow::Holding => Line::fixed(1.0),
        };
        let changed = |point: WavePoint| {
            let mut x = point.features;
            let of = |feature: Feature| point.features[feature as usize];
            let Line { constant, per_power } = through(point.flow);
            x[Feature::Load as usize] =
                constant * of(Feature::Load) + inertia * of(Feature::Acceleration) + no_load * of(Feature::Sign);
            x[Feature::LoadRate as usize] = constant * of(Feature::LoadRate) + inertia * of(Feature::Jerk);
            x[Feature::Speed as usize] = per_power * of(Feature::Load);
            x[Feature::SpeedRate as usize] = per_power * of(Feature::LoadRate);
            WavePoint { features: x, ..point }
        };
        let wave = |wave: &Waveform| {
            let points: Vec<WavePoint> = (0..wave.len()).map(|k| changed(wave.point(k))).collect();
            Waveform::new(&points)
        };
        let samples: Vec<WavePoint> = self.samples.iter().map(|sample| changed(*sample)).collect();
        let mut loss = Laurent::default();
        for flow in Flow::ALL {
            let Line { constant, per_power } = through(flow);
            let mean = |feature: Feature| self.mean[flow as usize][feature as usize][Feature::Velocity as usize];
            loss = loss
                + Laurent::constant((constant - 1.0) * mean(Feature::Load) + no_load * mean(Feature::Sign))
                + Laurent::monomial(per_power * mean(Feature::Load), 2);
        }
        Load { gear_loss: Some(loss), ..self.with_points(samples, wave) }
    }
}

const _: () = assert!(FEATURES == 9, "every feature that a piece uses is made above");
