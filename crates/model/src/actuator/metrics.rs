//! Motor metrics that do not depend on the ratio.
//!
//! Every metric is a monomial in a motor's parameters, so its value and the tolerance that it
//! inherits follow from one list of exponents. A new metric is one line in [`METRICS`].

use crate::catalog::estimate::Estimated;
use crate::catalog::{Motor, Printed};

/// A parameter of a motor that metrics are made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parameter {
    /// R \[Ω\].
    Resistance,
    /// L \[H\].
    Inductance,
    /// K_T \[N·m/A\].
    TorqueConstant,
    /// K_B \[V·s/rad\].
    BackEmfConstant,
    /// J_m \[kg·m²\].
    RotorInertia,
    /// m \[kg\].
    Mass,
    /// R_th \[K/W\].
    ThermalResistance,
    /// r_g \[m\].
    GapRadius,
    /// p.
    PolePairs,
}

impl Parameter {
    /// Its symbol.
    fn symbol(self) -> &'static str {
        match self {
            Parameter::Resistance => "R",
            Parameter::Inductance => "L",
            Parameter::TorqueConstant => "K_T",
            Parameter::BackEmfConstant => "K_B",
            Parameter::RotorInertia => "J_m",
            Parameter::Mass => "m",
            Parameter::ThermalResistance => "R_th",
            Parameter::GapRadius => "r_g",
            Parameter::PolePairs => "p",
        }
    }

    /// Value on the q axis \[SI\], and its relative tolerance, where they are known.
    fn of(self, motor: &Motor) -> Option<(f64, Option<f64>)> {
        let with = |value: f64, printed: Option<Printed>| Some((value, printed.and_then(|p| p.relative_tolerance())));
        let sheet = &motor.sheet;
        match self {
            Parameter::Resistance => with(motor.resistance, sheet.resistance),
            Parameter::Inductance => with(motor.inductance?, sheet.inductance),
            Parameter::TorqueConstant => {
                with(motor.torque_constant, sheet.torque_constant.or(sheet.back_emf_constant).or(sheet.speed_constant))
            }
            Parameter::BackEmfConstant => with(
                motor.back_emf_constant,
                // The speed constant counts where it is not below the torque constant.
                match motor.back_emf_constant == motor.torque_constant {
                    false => sheet.back_emf_constant.or(sheet.speed_constant),
                    true => sheet.back_emf_constant.or(sheet.torque_constant).or(sheet.speed_constant),
                },
            ),
            Parameter::RotorInertia => with(motor.rotor_inertia?, sheet.rotor_inertia),
            Parameter::Mass => with(motor.mass?, sheet.mass),
            Parameter::ThermalResistance => {
                let (a, b) = (sheet.thermal_resistance_winding_housing?, sheet.thermal_resistance_housing_ambient?);
                let tolerance = a.tolerance.zip(b.tolerance).map(|(a, b)| a.hypot(b));
                with(a.value + b.value, Some(Printed { value: a.value + b.value, tolerance }))
            }
            Parameter::GapRadius => with(sheet.gap_radius?.value, sheet.gap_radius),
            Parameter::PolePairs => Some((motor.pole_pairs.filter(|p| *p > 0).map(f64::from)?, Some(0.0))),
        }
    }
}

/// A value with what is known of its uncertainty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The value, SI.
    pub value: f64,
    /// Relative tolerance if all ± add up (worst case), where any parameter has one.
    pub worst_case: Option<f64>,
    /// Relative tolerance if the ± are independent (root sum of squares), where any has one.
    pub independent: Option<f64>,
    /// Whether every parameter that the value depends on has a ±.
    pub complete: bool,
}

/// Where a metric is shown without being asked for; ordering by it, JSON and rules have them all.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Shown {
    /// Nowhere.
    WhenAsked,
    /// In the table of `rank`.
    InRank,
    /// There, and `optimize` says how well its order agrees with the task's.
    AsOrder,
}

/// A metric of a motor.
#[derive(Debug)]
pub struct Metric {
    /// Name, also in `--sort` and JSON.
    pub name: &'static str,
    /// Symbol for people.
    pub symbol: &'static str,
    /// Unit in which it is shown.
    pub unit: &'static str,
    /// SI unit as a suffix of JSON keys.
    pub si_suffix: &'static str,
    /// Whether less is better.
    pub lower_is_better: bool,
    /// Where it is shown.
    pub shown: Shown,
    /// What it is.
    pub meaning: &'static str,
    exponents: &'static [(Parameter, f64)],
}

use Parameter::{
    BackEmfConstant, GapRadius, Inductance, Mass, PolePairs, Resistance, RotorInertia, ThermalResistance,
    TorqueConstant,
};

/// Every metric.
pub const METRICS: &[Metric] = &[
    Metric {
        name: "s_m",
        symbol: "S_M",
        unit: "ms",
        si_suffix: "s",
        lower_is_better: true,
        shown: Shown::AsOrder,
        meaning: "responsiveness J_m/K_M²: the mechanical time constant for L = 0 (Urs et al., eq. 11)",
        exponents: &[(RotorInertia, 1.0), (Resistance, 1.0), (TorqueConstant, -1.0), (BackEmfConstant, -1.0)],
    },
    Metric {
        name: "s_t",
        symbol: "S_T",
        unit: "g*(A/N)^2",
        si_suffix: "kgm2a2_per_nm2",
        lower_is_better: true,
        shown: Shown::AsOrder,
        meaning: "torque-specific inertia J_m/K_T² (Urs et al., eq. 12)",
        exponents: &[(RotorInertia, 1.0), (TorqueConstant, -2.0)],
    },
    Metric {
        name: "mass_s_m",
        symbol: "m·S_M",
        unit: "g*ms",
        si_suffix: "kgs",
        lower_is_better: true,
        shown: Shown::AsOrder,
        meaning: "responsiveness weighted by mass",
        exponents: &[
            (Mass, 1.0),
            (RotorInertia, 1.0),
            (Resistance, 1.0),
            (TorqueConstant, -1.0),
            (BackEmfConstant, -1.0),
        ],
    },
    Metric {
        name: "mass_s_t",
        symbol: "m·S_T",
        unit: "kg*g*(A/N)^2",
        si_suffix: "kg2m2a2_per_nm2",
        lower_is_better: true,
        shown: Shown::AsOrder,
        meaning: "torque-specific inertia weighted by mass",
        exponents: &[(Mass, 1.0), (RotorInertia, 1.0), (TorqueConstant, -2.0)],
    },
    Metric {
        name: "k_m",
        symbol: "K_M",
        unit: "N*m/W^0.5",
        si_suffix: "nm_per_sqrt_w",
        lower_is_better: false,
        shown: Shown::AsOrder,
        meaning: "motor constant √(K_T K_B/R)",
        exponents: &[(TorqueConstant, 0.5), (BackEmfConstant, 0.5), (Resistance, -0.5)],
    },
    Metric {
        name: "k_t",
        symbol: "K_T",
        unit: "N*m/A",
        si_suffix: "nm_per_a",
        lower_is_better: false,
        shown: Shown::WhenAsked,
        meaning: "torque constant, q axis",
        exponents: &[(TorqueConstant, 1.0)],
    },
    Metric {
        name: "k_t_per_mass",
        symbol: "K_T/m",
        unit: "N*m/(A*kg)",
        si_suffix: "nm_per_a_kg",
        lower_is_better: false,
        shown: Shown::InRank,
        meaning: "torque density",
        exponents: &[(TorqueConstant, 1.0), (Mass, -1.0)],
    },
    Metric {
        name: "k_ts",
        symbol: "K_ts",
        unit: "N*m/(kg*K^0.5)",
        si_suffix: "nm_per_kg_sqrt_k",
        lower_is_better: false,
        shown: Shown::AsOrder,
        meaning: "thermal specific torque (K_T/m) √(1/(R_th R)) (Kenneally et al.)",
        exponents: &[(TorqueConstant, 1.0), (Mass, -1.0), (ThermalResistance, -0.5), (Resistance, -0.5)],
    },
    Metric {
        name: "gap_radius",
        symbol: "r_g",
        unit: "mm",
        si_suffix: "m",
        lower_is_better: false,
        shown: Shown::AsOrder,
        meaning: "gap radius, the traditional criterion",
        exponents: &[(GapRadius, 1.0)],
    },
    Metric {
        name: "rotor_inertia",
        symbol: "J_m",
        unit: "g*cm^2",
        si_suffix: "kgm2",
        lower_is_better: true,
        shown: Shown::WhenAsked,
        meaning: "rotor inertia",
        exponents: &[(RotorInertia, 1.0)],
    },
    Metric {
        name: "mass",
        symbol: "m",
        unit: "g",
        si_suffix: "kg",
        lower_is_better: true,
        shown: Shown::WhenAsked,
        meaning: "mass",
        exponents: &[(Mass, 1.0)],
    },
    Metric {
        name: "electrical_time_constant",
        symbol: "L/R",
        unit: "ms",
        si_suffix: "s",
        lower_is_better: true,
        shown: Shown::InRank,
        meaning: "electrical time constant",
        exponents: &[(Inductance, 1.0), (Resistance, -1.0)],
    },
    Metric {
        name: "characteristic_current",
        symbol: "I_ch",
        unit: "A",
        si_suffix: "a",
        lower_is_better: true,
        shown: Shown::InRank,
        meaning: "characteristic current ψ/L, q axis: against the magnets it takes their field away (Soong and Miller)",
        exponents: &[(BackEmfConstant, 1.0), (PolePairs, -1.0), (Inductance, -1.0)],
    },
];

/// The metric with this name.
pub fn metric(name: &str) -> Option<&'static Metric> {
    METRICS.iter().find(|m| m.name == name)
}

impl Metric {
    /// The monomial that it is, as in `J_m R / (K_T K_B)`.
    pub fn formula(&self) -> String {
        // A root of everything is written once.
        let root = self.exponents.iter().all(|(_, e)| e.abs() == 0.5);
        let power = |(parameter, exponent): &(Parameter, f64)| match exponent.abs() {
            _ if root => parameter.symbol().to_string(),
            1.0 => parameter.symbol().to_string(),
            0.5 => format!("√{}", parameter.symbol()),
            2.0 => format!("{}²", parameter.symbol()),
            other => format!("{}^{other}", parameter.symbol()),
        };
        let part = |above: bool| {
            let factors = self.exponents.iter().filter(|(_, e)| (*e > 0.0) == above).map(power);
            factors.collect::<Vec<_>>()
        };
        let (above, below) = (part(true), part(false));
        let formula = match below.len() {
            0 => above.join(" "),
            1 => format!("{}/{}", above.join(" "), below[0]),
            _ => format!("{}/({})", above.join(" "), below.join(" ")),
        };
        if root { format!("√({formula})") } else { formula }
    }

    /// The metric of a motor, with `default_tolerance` (relative) in place of every missing ±;
    /// `None` where a parameter is unknown.
    pub fn of_with_tolerance(&self, motor: &Motor, default_tolerance: Option<f64>) -> Option<Estimate> {
        let mut value = 1.0;
        let mut terms: Vec<(Parameter, f64, Option<f64>)> = Vec::new();
        for (parameter, exponent) in self.exponents {
            // Where one of torque and back-EMF constant was taken from the other they are one number.
            // A back-EMF constant that the speed constant says is a number of its own.
            let printed = motor.sheet.back_emf_constant.is_some() && motor.sheet.torque_constant.is_some();
            let same = *parameter == BackEmfConstant && !printed && motor.back_emf_constant == motor.torque_constant;
            let parameter = if same { TorqueConstant } else { *parameter };
            let (number, tolerance) = parameter.of(motor)?;
            value *= number.powf(*exponent);
            let tolerance = tolerance.or(default_tolerance);
            match terms.iter_mut().find(|(p, ..)| *p == parameter) {
                Some((_, sum, _)) => *sum += exponent,
                None => terms.push((parameter, *exponent, tolerance)),
            }
        }
        // What is counted has no ±.
        let measured = terms.iter().filter(|(parameter, ..)| *parameter != PolePairs);
        let known: Vec<f64> = measured.filter_map(|(_, e, t)| t.map(|t| e.abs() * t)).collect();
        let any = !known.is_empty();
        Some(Estimate {
            value,
            worst_case: any.then(|| known.iter().sum()),
            independent: any.then(|| known.iter().map(|t| t * t).sum::<f64>().sqrt()),
            complete: terms.iter().all(|(.., t)| t.is_some()),
        })
    }

    /// Whether the metric of a motor is made from a number that no row says.
    pub fn rests_on_estimate(&self, motor: &Motor) -> bool {
        self.exponents.iter().any(|(parameter, _)| match parameter {
            Parameter::RotorInertia => motor.is_estimated(Estimated::RotorInertia),
            Parameter::Inductance => motor.is_estimated(Estimated::Inductance),
            Parameter::ThermalResistance => motor.is_estimated(Estimated::ThermalResistance),
            _ => false,
        })
    }

    /// The metric of a motor.
    pub fn of(&self, motor: &Motor) -> Option<Estimate> {
        self.of_with_tolerance(motor, None)
    }

    /// The value alone.
    pub fn value(&self, motor: &Motor) -> Option<f64> {
        self.of(motor).map(|e| e.value)
    }

    /// Probability that `a` is better than `b`, reading every ± as the 95 % interval (two standard
    /// deviations) of an independent normal error of the logarithm. `None` unless every parameter
    /// of both has a ±. Only with the feature `measured`, which brings the normal distribution.
    pub fn probability_ahead(&self, a: &Estimate, b: &Estimate) -> Option<f64> {
        use statrs::distribution::{ContinuousCDF, Normal};
        if !(a.complete && b.complete && a.value > 0.0 && b.value > 0.0) {
            return None;
        }
        let deviation = |e: &Estimate| e.independent.map(|t| t / 2.0);
        let sigma = deviation(a)?.hypot(deviation(b)?);
        let lead = (b.value / a.value).ln() * if self.lower_is_better { 1.0 } else { -1.0 };
        if sigma == 0.0 {
            return Some(if lead > 0.0 {
                1.0
            } else if lead < 0.0 {
                0.0
            } else {
                0.5
            });
        }
        Normal::new(0.0, 1.0).ok().map(|normal| normal.cdf(lead / sigma))
    }
}

/// `K_Ta` and `K_Ma` of a motor whose actuator inertia is matched to `inertia` \[kg·m²\] by the
/// ratio: `N = √(J_a/J_m)`, `K_Ta = √(J_a/S_T)`, `K_Ma = √(J_a/S_M)` (massless gear without loss).
pub fn at_matched_inertia(motor: &Motor, inertia: f64) -> Option<MatchedInertia> {
    let rotor = motor.rotor_inertia?;
    let ratio = (inertia / rotor).sqrt();
    let motor_constant = (motor.torque_constant * motor.back_emf_constant / motor.resistance).sqrt();
    Some(MatchedInertia {
        ratio,
        torque_constant: ratio * motor.torque_constant,
        motor_constant: ratio * motor_constant,
    })
}

/// An actuator whose inertia was matched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MatchedInertia {
    /// The ratio that does it.
    pub ratio: f64,
    /// Actuator torque constant K_Ta \[N·m/A\].
    pub torque_constant: f64,
    /// Actuator motor constant K_Ma \[N·m/√W\].
    pub motor_constant: f64,
}
