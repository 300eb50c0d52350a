use super::{MADE, table};
use crate::actuator::estimate::{LARGEST_SHARE, MISS, builtin_laws};
use crate::catalog::Construction;
use crate::catalog::convention::word;
use crate::words::number;

/// The page of estimates.
pub fn text() -> String {
    let mut out = format!(
        "{MADE}# Estimates\n\nWhat the row of a motor lacks is estimated from the rows of the built-in catalogue that are built alike \
         (`construction`): a regression over one point for each motor (windings of one motor are one). The model computes with the \
         pessimistic end of the prediction interval (one-sided, 90 %), and every table, page, CSV and JSON marks it as `estimated`. \
         `--no-estimates` turns them off: what is not known stays unknown then, and a motor whose heat nobody knows is no choice.\n\n\
         *Missed* are rows that the law of all *other* motors predicts more than a factor of {} off (leave one motor out). A law that \
         misses more than {} % of its rows is not used; its line shows why. A mass more than 1.5 times outside the range of the law, a row \
         without mass, outer diameter (where the law has D) or construction, and the insides of a module get no estimate. Where no row of a \
         construction says the number, the law of the other constructions is used, marked *of others*: only if each of them \
         is predicted by the rest as well, and its end is {} times its middle.\n\n",
        number(MISS),
        number(100.0 * LARGEST_SHARE),
        number(MISS)
    );
    let rows = builtin_laws().iter().map(|law| {
        vec![
            law.of.words().into(),
            word(Construction::NAMES, &law.construction).into(),
            law.formula(),
            format!("×{}", number(law.scatter())),
            match law.masses.1.is_finite() {
                true => format!("{} to {}", number(law.masses.0), number(law.masses.1)),
                false => "any".into(),
            },
            format!("{} ({})", law.motors, law.rows),
            format!("{} ({:.0} %)", law.misses, 100.0 * law.share_of_misses()),
            match (law.is_shipped(), law.of_others) {
                (true, true) => "yes, of others",
                (true, false) => "yes",
                (false, _) => "no",
            }
            .into(),
        ]
    });
    let header =
        ["of", "construction", "law", "one standard deviation", "masses [kg]", "motors (rows)", "missed", "used"];
    out.push_str(&table(&header, rows));
    out.push_str(
        "\nm is the motor's mass, D its outer diameter, R and L the resistance and inductance on the q axis. R_th is the thermal resistance \
         from winding to ambient: that of the row, else what its continuous current or torque leads to at its highest winding \
         temperature, or at 100 degC where the row gives none. T_0 is the torque of the drag without load, K_T times the no-load current, K_M \
         the motor constant; its law is made from brushless rows. Three frameless motors with published drag were looked up as a check: two \
         sheets give T_0/K_M of 0.24 and 0.33 √W at rated speed, within the end of the law; one motor measured on a bench with its bearings \
         has 0.67 √W at 1100 rpm, beyond it.\n\nTwo more things are assumed, and said with each design. Where neither row \
         nor requirement gives a highest winding temperature, it is 100 degC. Where the requirement states one and the row gives a \
         continuous rating but no thermal resistance, the resistance is computed from the rating as if the maker had allowed 155 degC, the \
         highest of any row: an upper bound.\n",
    );
    out
}
