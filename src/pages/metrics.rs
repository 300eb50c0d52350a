use super::{MADE, table};
use crate::actuator::metrics::METRICS;

/// The page of metrics.
pub fn text() -> String {
    let rows = METRICS.iter().map(|m| {
        vec![
            format!("`{}`", m.name),
            m.symbol.into(),
            format!("`{}`", m.formula()),
            m.unit.into(),
            if m.lower_is_better { "less" } else { "more" }.into(),
            m.meaning.into(),
        ]
    });
    format!(
        "{MADE}# Metrics\n\nNumbers of a motor that do not depend on the ratio; they are next to every design, and order with `--sort`. \
         All are of the q-axis equivalent. A ± of the row goes into every metric by the exponents of its formula.\n\n{}\n\
         `optimize` says how well the order by each agrees with the order by the task (Kendall's τ). At matched actuator inertia J_a \
         the actuator's motor constant is √(J_a/S_M), its torque constant √(J_a/S_T): that is why less is better.\n",
        table(&["name", "symbol", "formula", "shown in", "better is", "what it is"], rows)
    )
}
