//! The row of a gear.

use super::{Column, Field, Holds, Need, Row, Side, States, find, identity, listed};
use crate::catalog::convention::word;
use crate::catalog::gear::{ContinuousTorque, GEAR_FIELDS, Gear, GearKind, LifeQuantile};
use crate::catalog::offer::Sold;
use crate::catalog::sheet::{Printed, SourceKind};
use crate::input::Stated;

impl Row for Gear {
    type Numbers = Gear;

    const REQUIRED: &'static [&'static str] = &["ratio"];

    const BEFORE: &'static [Column<Gear>] = &[
        identity!(id),
        identity!(manufacturer),
        identity!(model),
        Column {
            name: "kind",
            about: "how it reduces",
            need: Need::Must("\"planetary\""),
            holds: Holds::Choice(
                GearKind::WORDS,
                |r| Some(word(GearKind::NAMES, &r.kind)),
                |r, text| r.kind = find(GearKind::NAMES, text).unwrap_or(r.kind),
            ),
        },
        Column {
            name: "stages",
            about: "number of stages",
            need: Need::May,
            holds: Holds::Count(|r| r.stages, |r, count| r.stages = Some(count)),
        },
        identity!(price_currency),
        identity!(price_date),
    ];

    const AFTER: &'static [Column<Gear>] = &[
        Column {
            name: "life_quantile",
            about: "what `rated_life` is: nine in ten gears last longer, or half of them",
            need: Need::May,
            holds: Holds::Choice(
                LifeQuantile::WORDS,
                |r| r.ratings.life_quantile.map(|quantile| word(LifeQuantile::NAMES, &quantile)),
                |r, text| r.ratings.life_quantile = find(LifeQuantile::NAMES, text),
            ),
        },
        Column {
            name: "continuous_torque_is",
            about: "what `continuous_torque` is a limit of: that of the rated life, or of heat",
            need: Need::May,
            holds: Holds::Choice(
                ContinuousTorque::WORDS,
                |r| r.ratings.continuous_torque_is.map(|is| word(ContinuousTorque::NAMES, &is)),
                |r, text| r.ratings.continuous_torque_is = find(ContinuousTorque::NAMES, text),
            ),
        },
        Column {
            name: "fits",
            about: "motor ids or patterns, separated by blanks or `;`; blank where nothing is said",
            need: Need::May,
            holds: Holds::Text(|r| r.fits.join(";"), |r, text| r.fits = listed(&text)),
        },
        identity!(source),
        identity!(source_date),
        identity!(source_kind),
        identity!(note),
    ];

    fn fields() -> &'static [Field<Gear>] {
        GEAR_FIELDS
    }

    fn numbers(&self) -> &Gear {
        self
    }

    fn numbers_mut(&mut self) -> &mut Gear {
        self
    }

    fn source_date(&self) -> &str {
        &self.source_date
    }

    fn take(&mut self, field: &Field<Gear>, stated: Stated, number: Printed) -> Result<Printed, (String, String)> {
        let (States::Side { kept, power }, Some(side)) = (field.states, stated.side) else { return Ok(number) };
        if side == kept.word() {
            return Ok(number);
        }
        match power {
            Some(power) => Ok(Printed { value: number.value * self.ratio.powi(power), ..number }),
            None => Err((
                format!("`{}` cannot be given at the side `{side}`", field.name),
                match kept {
                    Side::Output => "what arrives at the output depends on the loss in the gear: give it there",
                    Side::Motor => "it is that at the input: give it there",
                }
                .into(),
            )),
        }
    }

    fn states(&self, _field: &Field<Gear>) -> Stated {
        Stated::default()
    }
}
