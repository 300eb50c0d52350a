//! Rows that one asks for: `maker=maxon`, `mass<0.5kg`, `kind=planetary`.
//!
//! The one idea: a filter is a column, a comparison and a value with its unit. Of a row whose value is not known nothing can
//! be said, so that such rows are neither kept nor dropped in silence: they are counted.

use super::gear::matches_pattern;
use super::row::{Column, Convention, Field, Holds, MotorRow, Row, States, column_of};
use super::{Catalog, Family, Gear, Module, Motor};
use crate::input::Words;
use crate::units::{self, RATIO};
use crate::words::nearest;

/// How a value is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Comparison {
    Less,
    AtMost,
    More,
    AtLeast,
    Is,
    IsNot,
}

/// Every comparison, the longer ones first.
const COMPARISONS: &[(&str, Comparison)] = &[
    ("<=", Comparison::AtMost),
    (">=", Comparison::AtLeast),
    ("!=", Comparison::IsNot),
    ("<", Comparison::Less),
    (">", Comparison::More),
    ("=", Comparison::Is),
];

/// Numbers that differ by less (relative) are equal: what is left of a unit's conversion.
const SAME: f64 = 1e-9;

/// What is asked of the rows of one kind.
#[derive(Debug, Clone, PartialEq)]
enum Asked {
    Number(&'static str, Comparison, f64, Option<(Convention, &'static str)>),
    Text(&'static str, bool, String),
}

/// A filter as it was written, and what it asks of each kind of row; `None` of a kind that has no such column.
#[derive(Debug, Clone, PartialEq)]
pub struct Filter {
    /// As it was written.
    pub text: String,
    /// The column.
    pub column: String,
    motors: Option<Asked>,
    gears: Option<Asked>,
    modules: Option<Asked>,
}

/// What a filter says of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Says {
    /// The row keeps it.
    Yes,
    /// It does not.
    No,
    /// Its value is not known.
    Unknown,
}

impl Filter {
    /// Reads a filter.
    ///
    /// # Errors
    /// In one line: no comparison, an unknown column, a value that is not one of the column's.
    ///
    /// ```
    /// use gearwise_model::catalog::filter::Filter;
    /// assert!(Filter::read("mass<0.5kg").is_ok());
    /// assert!(Filter::read("mas<0.5kg").unwrap_err().contains("did you mean `mass`"));
    /// assert!(Filter::read("mass<0.5 s").unwrap_err().contains("mass"));
    /// ```
    pub fn read(text: &str) -> Result<Filter, String> {
        let wrong = |why: String| format!("the filter `{text}`: {why}");
        let Some((at, (sign, comparison))) = text
            .char_indices()
            .find_map(|(at, _)| COMPARISONS.iter().find(|(sign, _)| text[at..].starts_with(sign)).map(|c| (at, c)))
        else {
            return Err(wrong("it has no comparison; write it like maker=maxon or mass<0.5kg".into()));
        };
        let (name, value) = (text[..at].trim(), text[at + sign.len()..].trim());
        let column = column_of(name).unwrap_or(name);
        if value.is_empty() {
            return Err(wrong(format!("there is no value after `{sign}`")));
        }
        let motors = asked::<MotorRow>(column, *comparison, value);
        let gears = asked::<Gear>(column, *comparison, value);
        let modules = asked::<Module>(column, *comparison, value);
        let (motors, gears, modules) = match (motors, gears, modules) {
            (None, None, None) => {
                let own = || names::<MotorRow>().chain(names::<Gear>()).chain(names::<Module>());
                let meant = || own().chain(super::row::ALIASES.iter().map(|(alias, _)| *alias));
                let help = match nearest(name, meant()) {
                    Some(near) => format!("did you mean `{near}`?"),
                    None => "docs/formats.md names the columns of motors, gears and modules; mass, diameter, K_T, ratio, peak_torque and maker are some".into(),
                };
                return Err(wrong(format!("there is no column `{name}`; {help}")));
            }
            (motors, gears, modules) => {
                // Of a column that several have, one reading is enough.
                let all = [&motors, &gears, &modules];
                // That of motors has conventions, which have to be said.
                if let Some(Err(why)) = &motors {
                    return Err(wrong(why.clone()));
                }
                let read = all.iter().any(|of| matches!(of, Some(Ok(_))));
                if let Some(why) = all.iter().find_map(|of| of.as_ref()?.as_ref().err()).filter(|_| !read) {
                    return Err(wrong(why.clone()));
                }
                (motors.and_then(Result::ok), gears.and_then(Result::ok), modules.and_then(Result::ok))
            }
        };
        Ok(Filter { text: text.into(), column: column.into(), motors, gears, modules })
    }

    /// Whether a kind of row has the column.
    pub fn is_of(&self, kind: RowKind) -> bool {
        match kind {
            RowKind::Motor => self.motors.is_some(),
            RowKind::Gear => self.gears.is_some(),
            RowKind::Module => self.modules.is_some(),
            RowKind::Family => false,
        }
    }

    /// Whether it asks for a text.
    pub fn is_text(&self) -> bool {
        [&self.motors, &self.gears, &self.modules].iter().any(|asked| matches!(asked, Some(Asked::Text(..))))
    }

    /// What it says of a motor. Resistance, inductance, constants and currents are compared on the q axis, or in the
    /// convention that the filter states.
    pub fn of_motor(&self, motor: &Motor) -> Says {
        let Some(asked) = &self.motors else { return Says::No };
        asked.says(&MotorRow::of(motor), |field, of| match of {
            Some((convention, word)) => motor.in_convention(convention, word),
            None => motor.comparable(field),
        })
    }

    /// What it says of a gear.
    pub fn of_gear(&self, gear: &Gear) -> Says {
        let Some(asked) = &self.gears else { return Says::No };
        asked.says(gear, |field, _| (field.get)(gear).map(|p| p.value))
    }

    /// What it says of a module: its numbers are compared as printed, at the side and in the convention that its row says.
    pub fn of_module(&self, module: &Module) -> Says {
        let Some(asked) = &self.modules else { return Says::No };
        asked.says(module, |field, _| (field.get)(&module.sheet).map(|p| p.value))
    }
}

/// The columns of a kind of row, but for those of a ±.
pub fn names<R: Row>() -> impl Iterator<Item = &'static str> {
    let others = R::BEFORE.iter().chain(R::AFTER).map(|c| c.name);
    others.chain(R::fields().iter().map(|f| f.name))
}

/// A column of a kind of row that holds no number with a unit.
pub(crate) fn other<R: Row>(name: &str) -> Option<&'static Column<R>> {
    R::BEFORE.iter().chain(R::AFTER).find(|c| c.name == name)
}

/// What a column that holds no number with a unit says in a row; `None` where it is blank.
pub fn text_of<R>(column: &Column<R>, row: &R) -> Option<String> {
    Some(super::row::text(column, row)).filter(|t| !t.is_empty())
}

/// What a filter asks of a kind of row; `None` where that has no such column.
fn asked<R: Row>(name: &str, comparison: Comparison, value: &str) -> Option<Result<Asked, String>> {
    if let Some(field) = R::fields().iter().find(|f| f.name == name) {
        return Some(number(field, comparison, value));
    }
    let column = other::<R>(name)?;
    if let Holds::Count(..) = column.holds {
        let count = units::quantity(value, &RATIO).map_err(|e| e.message(&RATIO));
        return Some(count.map(|count| Asked::Number(column.name, comparison, count, None)));
    }
    let is = match comparison {
        Comparison::Is => true,
        Comparison::IsNot => false,
        _ => return Some(Err(format!("`{name}` is a text, which is compared by = or != only"))),
    };
    if let Holds::Choice(words, ..) = column.holds
        && !value.contains('*')
        && !words.contains(&value.to_lowercase().as_str())
    {
        let near = nearest(value, words.iter().copied()).map(|near| format!("did you mean `{near}`? "));
        return Some(Err(format!("{}`{name}` is one of {}", near.unwrap_or_default(), words.join(", "))));
    }
    Some(Ok(Asked::Text(column.name, is, value.to_lowercase())))
}

fn number<S>(field: &Field<S>, comparison: Comparison, value: &str) -> Result<Asked, String> {
    let words = match field.states {
        States::Convention(convention) => Words { convention: convention.words(), side: &[] },
        _ => Words::NONE,
    };
    let (value, stated) = words.split(value)?;
    let convention = match (field.states, stated.convention) {
        (States::Convention(of), Some(word)) => Some((of, word)),
        (States::Convention(of), None) if !of.words().contains(&"q_axis") => {
            return Err(format!("say of which convention, behind the unit: {}", of.words().join(" or ")));
        }
        _ => None,
    };
    let number = units::quantity(value, field.kind).map_err(|error| {
        let help = error.help(field.kind);
        format!("`{}`: {}; {help}", field.name, error.message(field.kind))
    })?;
    Ok(Asked::Number(field.name, comparison, number, convention))
}

impl Asked {
    fn says<R: Row>(
        &self,
        row: &R,
        number: impl Fn(&Field<R::Numbers>, Option<(Convention, &'static str)>) -> Option<f64>,
    ) -> Says {
        let of = |holds: bool| if holds { Says::Yes } else { Says::No };
        match self {
            Asked::Number(name, comparison, asked, convention) => {
                let field = R::fields().iter().find(|f| f.name == *name);
                let value = match (field, other::<R>(name).map(|c| &c.holds)) {
                    (Some(field), _) => number(field, *convention),
                    (None, Some(Holds::Count(get, _))) => get(row).map(f64::from),
                    _ => None,
                };
                let Some(value) = value else { return Says::Unknown };
                let same = (value - asked).abs() <= SAME * asked.abs();
                of(match comparison {
                    Comparison::Less => value < *asked && !same,
                    Comparison::AtMost => value <= *asked || same,
                    Comparison::More => value > *asked && !same,
                    Comparison::AtLeast => value >= *asked || same,
                    Comparison::Is => same,
                    Comparison::IsNot => !same,
                })
            }
            Asked::Text(name, is, pattern) => match other::<R>(name).and_then(|column| text_of(column, row)) {
                None => Says::Unknown,
                Some(text) => of(matches_pattern(pattern, &text.to_lowercase()) == *is),
            },
        }
    }
}

/// A kind of row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RowKind {
    /// A motor.
    Motor,
    /// A gear.
    Gear,
    /// A module.
    Module,
    /// A family of gears, which has no columns to filter by.
    Family,
}

impl RowKind {
    /// Every kind with its word.
    pub const NAMES: &[(&str, RowKind)] = &[
        ("motor", RowKind::Motor),
        ("gear", RowKind::Gear),
        ("module", RowKind::Module),
        ("gear family", RowKind::Family),
    ];
}

/// Which kinds of row are asked for; none in particular for all.
pub type Kinds = Option<RowKind>;

/// The rows that filters leave.
#[derive(Debug)]
pub struct Found<'c> {
    /// Motors.
    pub motors: Vec<&'c Motor>,
    /// Gears.
    pub gears: Vec<&'c Gear>,
    /// Modules.
    pub modules: Vec<&'c Module>,
    /// Families of gears.
    pub families: Vec<&'c Family>,
    /// Rows that would be there if numbers of theirs that are not known allowed it.
    pub unknown: usize,
    /// Of each filter of which some row does not know the value: its column, and in how many rows.
    pub unknown_by: Vec<(String, usize)>,
}

/// The rows of a catalogue that keep all filters.
pub fn select<'c>(catalog: &'c Catalog, kinds: Kinds, filters: &[Filter]) -> Found<'c> {
    let mut unknown_by: Vec<(String, usize)> = Vec::new();
    for filter in filters.iter().filter(|f| filters.iter().find(|g| g.column == f.column) == Some(f)) {
        unknown_by.push((filter.column.clone(), 0));
    }
    let mut unknown = 0;
    let mut keep = |says: Vec<Says>| {
        if says.contains(&Says::No) {
            return false;
        }
        let open = says.contains(&Says::Unknown);
        unknown += usize::from(open);
        for (column, count) in &mut unknown_by {
            let is_open = filters.iter().zip(&says).any(|(f, says)| f.column == *column && *says == Says::Unknown);
            *count += usize::from(is_open);
        }
        !open
    };
    let (mut motors, mut gears, mut modules) = (Vec::new(), Vec::new(), Vec::new());
    let is = |kind: RowKind| kinds.is_none_or(|asked| asked == kind);
    if is(RowKind::Motor) {
        let all = catalog.motors.iter();
        motors.extend(all.filter(|m| keep(filters.iter().map(|f| f.of_motor(m)).collect())));
    }
    if is(RowKind::Gear) {
        let all = catalog.gears.iter();
        gears.extend(all.filter(|g| keep(filters.iter().map(|f| f.of_gear(g)).collect())));
    }
    if is(RowKind::Module) {
        let all = catalog.modules.iter();
        modules.extend(all.filter(|m| keep(filters.iter().map(|f| f.of_module(m)).collect())));
    }
    let all = catalog.families.iter().filter(|_| is(RowKind::Family) && filters.is_empty());
    unknown_by.retain(|(_, count)| *count > 0);
    Found { motors, gears, modules, families: all.collect(), unknown, unknown_by }
}

/// What a search compares: letters and digits alone.
fn plain(text: &str) -> String {
    text.to_lowercase().replace(|c: char| !c.is_alphanumeric(), "")
}

/// The rows whose id, model or maker has a text in it: each of its words.
pub fn search<'c>(catalog: &'c Catalog, text: &str) -> Found<'c> {
    let wanted: Vec<String> = text.split_whitespace().map(plain).filter(|w| !w.is_empty()).collect();
    let has = |texts: [&str; 3]| {
        let texts = texts.map(plain);
        !wanted.is_empty() && wanted.iter().all(|word| texts.iter().any(|t| t.contains(word)))
    };
    Found {
        motors: catalog.motors.iter().filter(|m| has([&m.id, &m.model, &m.manufacturer])).collect(),
        gears: catalog.gears.iter().filter(|g| has([&g.id, &g.model, &g.manufacturer])).collect(),
        modules: catalog.modules.iter().filter(|m| has([&m.id, &m.model, &m.manufacturer])).collect(),
        families: catalog.families.iter().filter(|f| has([&f.name, &f.gear.note, &f.gear.manufacturer])).collect(),
        unknown: 0,
        unknown_by: Vec::new(),
    }
}

/// Up to five ids, models and makers that are like a text, the nearest first.
pub fn like<'c>(catalog: &'c Catalog, text: &str) -> Vec<&'c str> {
    let motors = catalog.motors.iter().flat_map(|m| [&m.id, &m.model, &m.manufacturer]);
    let gears = catalog.gears.iter().flat_map(|g| [&g.id, &g.model, &g.manufacturer]);
    let modules = catalog.modules.iter().flat_map(|m| [&m.id, &m.model, &m.manufacturer]);
    let families = catalog.families.iter().map(|f| &f.name);
    let mut names: Vec<&str> =
        motors.chain(gears).chain(modules).chain(families).map(String::as_str).filter(|n| !n.is_empty()).collect();
    names.sort_unstable();
    names.dedup();
    let mut found = Vec::new();
    while found.len() < 5 {
        let Some(near) = nearest(text, names.iter().copied()) else { break };
        names.retain(|name| *name != near);
        found.push(near);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ids(filters: &[&str]) -> (Vec<String>, usize) {
        let catalog = Catalog::builtin().unwrap();
        let filters: Vec<Filter> = filters.iter().map(|f| Filter::read(f).unwrap()).collect();
        let found = select(&catalog, Some(RowKind::Motor), &filters);
        (found.motors.iter().map(|m| m.id.clone()).collect(), found.unknown)
    }

    #[test]
    fn kept_dropped_and_unknown_are_all_rows() {
        let count = Catalog::builtin().unwrap().motors.len();
        let (light, unknown) = ids(&["mass<0.5kg"]);
        let (heavy, same) = ids(&["mass>=500 g"]);
        assert_eq!(unknown, same);
        assert!(unknown > 0 && light.len() + heavy.len() + unknown == count);
        assert_eq!(ids(&["mass<0.5kg", "mass>=0.5kg"]), (Vec::new(), unknown));
    }

    #[test]
    fn constants_are_compared_in_one_convention() {
        let catalog = Catalog::builtin().unwrap();
        for motor in &catalog.motors {
            let k = motor.torque_constant;
            let says = |text: String| Filter::read(&text).unwrap().of_motor(motor);
            assert_eq!(says(format!("Kt>={} N*m/A", 0.999 * k)), Says::Yes);
            assert_eq!(says(format!("Kt>{} N*m/A", 1.001 * k)), Says::No);
            if motor.conventions.commutation == crate::catalog::convention::Commutation::Brushless {
                let rms = 3.0_f64.sqrt() * k;
                assert_eq!(says(format!("Kt={rms} N*m/A rms")), Says::Yes);
                assert_eq!(says(format!("Kt={rms} N*m/A")), Says::No);
            }
        }
        assert!(Filter::read("KV>100rpm/V").unwrap_err().contains("line_to_line_peak or dc"));
    }

    #[test]
    fn a_filter_of_one_kind_keeps_none_of_the_other() {
        let catalog = Catalog::builtin().unwrap();
        let filter = Filter::read("ratio>=5").unwrap();
        assert!(filter.is_of(RowKind::Gear) && !filter.is_of(RowKind::Motor));
        assert!(select(&catalog, None, &[filter]).motors.is_empty());
    }
}
