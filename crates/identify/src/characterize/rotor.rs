//! Rotor inertia from its geometry: a thin ring, `J = m r²`.

use super::estimate::{Combination, Estimate, combine, thin_ring, thin_ring_slopes};
use super::{Finding, Outcome, Quantity, Test, Weight, find};
use crate::bench::Bench;
use gearwise_model::words::number;

/// The test.
pub struct Rotor;

impl Test for Rotor {
    fn name(&self) -> &'static str {
        "rotor"
    }

    fn run(&self, bench: &Bench, before: &[Outcome]) -> Option<Outcome> {
        let r = bench.readings.rotor?;
        let (mass, radius) =
            (Estimate::stated(r.mass, r.mass_tolerance), Estimate::stated(r.radius, r.radius_tolerance));
        let ring = thin_ring(mass, radius);
        let [by_mass, by_radius] = thin_ring_slopes(r.mass, r.radius);
        let linear = combine(Combination::Linear, &[(by_mass, r.mass_tolerance), (by_radius, r.radius_tolerance)]);
        let mut outcome = Outcome {
            method: vec![format!(
                "thin ring, J = m r², all mass at the radius given; ± by root sum square {}, by linear sum {} kg*m^2",
                number(ring.half_width()),
                number(linear)
            )],
            ..Outcome::default()
        };
        let measured = find(before, "rotor_inertia");
        outcome.quantities.push(Quantity {
            name: if measured.is_some() { "rotor_inertia_thin_ring" } else { "rotor_inertia" },
            estimate: ring,
            unit: "kg*m^2",
            remark: "of the geometry".into(),
        });
        outcome.quantities.push(Quantity {
            name: "rotor_mass",
            estimate: mass,
            unit: "kg",
            remark: "as weighed".into(),
        });
        if let Some(measured) = measured {
            let share = 100.0 * (measured.value / ring.value - 1.0);
            let apart = (measured.value - ring.value).abs() > measured.half_width().hypot(ring.half_width());
            outcome.findings.push(if apart {
                Finding::new(
                    "inertia_against_ring",
                    Weight::Note,
                    format!(
                        "the random-torque inertia is {} % off the thin ring's, beyond both ±: shaft, arbor and bearing \
                         races turn with the rotor but are no ring",
                        number(share)
                    ),
                )
            } else {
                let text = format!("the random-torque inertia is {} % off the thin ring's, within their ±", number(share));
                Finding::new("inertia_against_ring", Weight::Good, text)
            });
        }
        Some(outcome)
    }
}
