//! `read(write(x)) == x`, over random rows with every column, unit, ± and text.

use proptest::option::of;
use proptest::prelude::*;
use proptest::sample::{Index, select};

use super::{gears, motors};
use crate::catalog::about::{About, Construction, PeakTorqueOf};
use crate::catalog::convention::{
    BackEmfConvention, Commutation, CurrentConvention, SpeedConstantConvention, Terminals, Winding,
};
use crate::catalog::row::{Field, MotorRow, Row, csv_text, toml_text};
use crate::catalog::sheet::{Conventions, FIELDS, OwnConventions, Printed, Sheet, SourceKind};
use crate::catalog::{ContinuousTorque, Currency, GEAR_FIELDS, Gear, GearKind, LifeQuantile, Motor, Offer};
use crate::input::Range;
use crate::input::csv::Content;

fn any_of<T: Copy + std::fmt::Debug + 'static>(names: &'static [(&'static str, T)]) -> impl Strategy<Value = T> {
    select(names).prop_map(|(_, value)| value)
}

/// A text as a reader gives it: without blanks at its ends.
fn text() -> impl Strategy<Value = String> {
    let odd =
        select(&["=1+1", "-left", "'quoted'", "a, \"b\"", "# no comment", "x\ny", "1e5", "[N*m]", "±", "a;b"][..]);
    prop_oneof![any::<String>().prop_map(|t| t.trim().to_string()), odd.prop_map(str::to_string), Just(String::new())]
}

fn listed() -> impl Strategy<Value = Vec<String>> {
    proptest::collection::vec("[a-z*.-]{1,8}", 0..3)
}

/// A number of a range, of any size, with as many digits as there may be.
fn number(range: Range) -> impl Strategy<Value = f64> {
    (1.0..10.0_f64, -8..8_i32, any::<bool>()).prop_map(move |(digits, power, negative)| {
        let size = digits * 10.0_f64.powi(power);
        match range {
            Range::Fraction => 1.0 / (1.0 + size.min(1e5)),
            Range::AtLeastOne => 1.0 + size.min(1e5),
            Range::Any if negative => -size,
            Range::NonNegative if power == 0 => 0.0,
            _ => size,
        }
    })
}

/// An offer as a row can have it: a price has its currency and its day.
fn sold(offer: &mut Offer, (currency, day): (Currency, u8)) {
    if offer.price.is_some() {
        (offer.price_currency, offer.price_date) = (currency.to_string(), format!("2026-01-{day:02}"));
    } else {
        offer.price_quantity = None;
    }
}

fn currency() -> impl Strategy<Value = (Currency, u8)> {
    (select(&["EUR", "CNY", "USD"][..]).prop_map(|code| Currency::of(code).unwrap()), 1..32_u8)
}

/// Each number of a row, with or without ±.
fn numbers<S: 'static>(fields: &'static [Field<S>]) -> impl Strategy<Value = Vec<Option<Printed>>> {
    let one = |field: &'static Field<S>| {
        // Not at the very bounds of its kind, which another unit may round over.
        let [least, most] = field.kind.bounds();
        let printed = move |(value, tolerance): (f64, Option<f64>)| Printed {
            value: value.clamp(least.max(least * 1.01), most * 0.99),
            tolerance: tolerance.filter(|_| field.tolerance.is_some()),
        };
        of((number(field.range), of(number(Range::NonNegative))).prop_map(printed))
    };
    fields.iter().map(one).collect::<Vec<_>>()
}

prop_compose! {
    fn own()(
        resistance in of(any_of(Terminals::NAMES)), inductance in of(any_of(Terminals::NAMES)),
        torque_constant in of(any_of(CurrentConvention::NAMES)),
        continuous_current in of(any_of(CurrentConvention::NAMES)),
        peak_current in of(any_of(CurrentConvention::NAMES)),
    ) -> OwnConventions {
        OwnConventions { resistance, inductance, torque_constant, continuous_current, peak_current }
    }
}

prop_compose! {
    fn conventions()(
        commutation in any_of(Commutation::NAMES), terminals in any_of(Terminals::NAMES),
        winding in any_of(Winding::NAMES), said in any::<bool>(), current in any_of(CurrentConvention::NAMES),
        back_emf in any_of(BackEmfConvention::NAMES), speed_constant in any_of(SpeedConstantConvention::NAMES),
        own in own(),
    ) -> Conventions {
        let brushed = commutation == Commutation::Brushed;
        let of_winding = [Some(terminals), own.resistance, own.inductance].contains(&Some(Terminals::Winding));
        Conventions {
            commutation, terminals,
            winding: Some(winding).filter(|_| said || of_winding),
            current: if brushed { CurrentConvention::Dc } else { current },
            back_emf: Some(back_emf), speed_constant: Some(speed_constant),
            own: if brushed { OwnConventions { resistance: own.resistance, inductance: own.inductance, ..OwnConventions::default() } } else { own },
        }
    }
}

/// What a source says of its day.
fn days() -> impl Strategy<Value = &'static str> {
    prop::sample::select(vec!["", "2026", "2026-11", "2026-02-28"])
}

prop_compose! {
    fn motor_row()(
        manufacturer in text(), model in text(), source in text(), note in text(), accepted_findings in listed(),
        source_kind in any_of(SourceKind::NAMES), construction in of(any_of(Construction::NAMES)),
        peak_torque_of in of(any_of(PeakTorqueOf::NAMES)),
        only_inside in text(), same_as in text(), conventions in conventions(), pole_pairs in of(1..1_000_000_u32),
        printed in numbers(FIELDS), resistance in number(Range::Positive), torque_constant in number(Range::Positive),
        price in currency(), source_date in days(),
    ) -> MotorRow {
        let mut sheet = Sheet::default();
        for (field, printed) in FIELDS.iter().zip(printed) {
            if let Some(printed) = printed {
                (field.set)(&mut sheet, printed);
            }
        }
        sold(&mut sheet.offer, price);
        sheet.resistance.get_or_insert(Printed::exact(resistance));
        sheet.torque_constant.get_or_insert(Printed::exact(torque_constant));
        // A peak that is less than what may last is refused; so far apart they are in order in all conventions.
        if let (Some(continuous), Some(peak)) = (&sheet.continuous_current, &mut sheet.peak_current) {
            peak.value = peak.value.max(3.0 * continuous.value);
        }
        MotorRow {
            id: String::new(), manufacturer, model,
            source: if source.is_empty() { "a sheet".into() } else { source },
            source_date: source_date.into(), source_kind, note, accepted_findings,
            about: About { construction, peak_torque_of, only_inside, same_as },
            pole_pairs: pole_pairs.filter(|_| conventions.commutation == Commutation::Brushless),
            conventions, sheet,
        }
        .without_what_no_number_states()
    }
}

impl MotorRow {
    /// Without the conventions of numbers that the row does not have.
    fn without_what_no_number_states(mut self) -> MotorRow {
        let (own, sheet) = (&mut self.conventions.own, &self.sheet);
        own.inductance = own.inductance.filter(|_| sheet.inductance.is_some());
        own.continuous_current = own.continuous_current.filter(|_| sheet.continuous_current.is_some());
        own.peak_current = own.peak_current.filter(|_| sheet.peak_current.is_some());
        self
    }
}

prop_compose! {
    fn gear()(
        manufacturer in text(), model in text(), source in text(), note in text(), fits in listed(),
        source_kind in any_of(SourceKind::NAMES), kind in any_of(GearKind::NAMES), stages in of(1..1_000_000_u32),
        printed in numbers(GEAR_FIELDS), ratio in number(Range::Positive),
        life_quantile in of(0..2_usize), continuous_torque_is in of(0..2_usize), price in currency(), source_date in days(),
    ) -> Gear {
        let mut gear = Gear {
            manufacturer, model, note, fits, source_date: source_date.into(), source_kind, kind, stages,
            source: if source.is_empty() { "a sheet".into() } else { source },
            ..Gear::blank()
        };
        for (field, printed) in GEAR_FIELDS.iter().zip(printed) {
            if let Some(printed) = printed {
                (field.set)(&mut gear, printed);
            }
        }
        sold(&mut gear.offer, price);
        gear.ratio = ratio;
        gear.backdrive_efficiency = gear.backdrive_efficiency.map(|b| b.min(1.0));
        gear.peak_torque = gear.peak_torque.map(|peak| peak.max(gear.continuous_torque.unwrap_or(0.0)));
        gear.ratings.life_quantile = life_quantile.map(|k| LifeQuantile::NAMES[k].1);
        gear.ratings.continuous_torque_is = continuous_torque_is.map(|k| ContinuousTorque::NAMES[k].1);
        // What goes together is there together, and leaves the load an efficiency.
        if [gear.no_load_torque, gear.no_load_torque_speed, gear.efficiency_speed, gear.efficiency_torque].contains(&None) {
            (gear.no_load_torque, gear.no_load_torque_speed) = (None, None);
        }
        if gear.load_efficiency().is_some_and(|efficiency| !(0.0..=1.0).contains(&efficiency)) {
            (gear.starting_torque, gear.no_load_torque, gear.no_load_torque_speed) = (None, None, None);
        }
        gear
    }
}

fn toml<R: Row>(table: &str, rows: &[R]) -> String {
    rows.iter().map(|row| format!("[[{table}]]\n{}\n", toml_text(row))).collect()
}

/// In the order of their ids, which a catalogue has.
fn named<R>(rows: Vec<R>, name: impl Fn(&mut R, String)) -> Vec<R> {
    let mut rows = rows;
    rows.iter_mut().enumerate().for_each(|(k, row)| name(row, format!("row-{k}")));
    rows
}

fn same_motors(rows: &[MotorRow], read: &[Motor]) {
    let back: Vec<MotorRow> = read.iter().map(MotorRow::of).collect();
    assert_eq!(rows, back);
    let made: Vec<Motor> = rows.iter().map(|row| row.clone().motor().unwrap()).collect();
    assert_eq!(format!("{made:?}"), format!("{read:?}"));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn motors_are_read_as_they_were_written(rows in proptest::collection::vec(motor_row(), 1..5)) {
        let rows = named(rows, |row, id| row.id = id);
        same_motors(&rows, &motors("rows.csv", &csv_text(&rows, &[])));
        same_motors(&rows, &motors("rows.csv", &csv_text(&rows, &["note", "stall_torque"])));
        same_motors(&rows, &motors("rows.toml", &toml("motor", &rows)));
    }

    #[test]
    fn gears_are_read_as_they_were_written(rows in proptest::collection::vec(gear(), 1..5)) {
        let rows = named(rows, |row, id| row.id = id);
        prop_assert_eq!(&rows, &gears("rows.csv", &csv_text(&rows, &[])));
        prop_assert_eq!(&rows, &gears("rows.toml", &toml("gear", &rows)));
    }

    #[test]
    fn a_file_of_both_kinds_holds_both(row in motor_row(), gear in gear()) {
        let (rows, boxes) = (named(vec![row], |r, id| r.id = id), named(vec![gear], |g, id| g.id = id));
        let text = format!("# gearwise catalogue 1\n{}{}", toml("gear", &boxes), toml("motor", &rows));
        same_motors(&rows, &motors("rows.toml", &text));
        prop_assert_eq!(boxes, gears("rows.toml", &text));
    }

    /// A number in any unit of its kind is the number of its SI unit.
    #[test]
    fn a_unit_changes_nothing(value in number(Range::Positive), tolerance in number(Range::Positive), at in any::<Index>()) {
        const UNITS: &[(&str, &str, f64)] = &[
            ("mass", "g", 1e-3), ("mass", "lb", 0.453_592_37), ("length", "mm", 1e-3), ("max_speed", "rpm", 0.104_719_755_119_659_77),
            ("rotor_inertia", "g*cm^2", 1e-7), ("inductance", "mH", 1e-3), ("peak_torque", "mN*m", 1e-3),
        ];
        let (column, unit, scale) = *at.get(UNITS);
        let text = format!(
            "id,terminals,current,resistance [ohm],torque_constant [N*m/A],{column} [{unit}],{column}_tolerance [{unit}],source,source_kind\n\
             a,q_axis,q_axis,1,1,{value},{tolerance},x,derived\n"
        );
        let motor = motors("a.csv", &text).remove(0);
        let field = FIELDS.iter().find(|f| f.name == column).unwrap();
        let read = (field.get)(&motor.sheet).unwrap();
        let near = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-14;
        prop_assert!(near(read.value, value * scale) && near(read.tolerance.unwrap(), tolerance * scale), "{read:?}");
    }
}

#[test]
fn temperatures_are_written_as_people_know_them_where_that_is_exact() {
    let row = |kelvin: f64| {
        let mut row = MotorRow { id: "a".into(), source: "x".into(), ..MotorRow::default() };
        row.sheet.resistance = Some(Printed::exact(1.0));
        row.sheet.torque_constant = Some(Printed::exact(1.0));
        row.sheet.max_winding_temperature = Some(Printed { value: kelvin, tolerance: Some(2.0) });
        row
    };
    for (kelvin, written) in [(398.15, "\"125 degC\""), (398.151_515_151_515_2, "\"398.15151515151")] {
        let text = toml("motor", &[row(kelvin)]);
        assert!(text.contains(&format!("max_winding_temperature = {written}")), "{text}");
        assert_eq!(text.contains("degC"), written.ends_with("degC\""), "{text}");
        same_motors(&[row(kelvin)], &motors("a.toml", &text));
    }
}

/// Every column of a kind of row is declared once, and each that may have a ± has its column.
#[test]
fn names_of_columns_are_unique() {
    for columns in [crate::catalog::motor_columns(), crate::catalog::gear_columns()] {
        let mut names: Vec<&str> = columns.iter().map(|c| c.name.as_str()).collect();
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count);
        for column in &columns {
            if let Content::Tolerance(kind) = column.content {
                let of = column.name.strip_suffix("_tolerance").unwrap();
                let found = columns.iter().find(|c| c.name == of).unwrap();
                let (Content::Quantity(k, _) | Content::Stated(k, ..)) = found.content else { panic!("{of}") };
                assert!(std::ptr::eq(k, kind) || *k == *kind, "{of}");
            }
        }
    }
}
