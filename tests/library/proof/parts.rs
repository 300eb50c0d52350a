//! Limits on the parts of an actuator, its size, its price and its lead time, against a count by hand over random rows: what is
//! known of every part is kept or exceeded, and what is not known of one is not kept.

use std::sync::Arc;

use gearwise::actuator::parts::PartKind;
use gearwise::catalog::Catalog;
use gearwise::design::optimize::optimize;
use gearwise::input::Source;
use gearwise::requirement::{self, Robot};

use crate::common::repository;

/// Numbers that look random, the same every time.
struct Dice(u64);

impl Dice {
    fn below(&mut self, most: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (z ^ (z >> 31)) % most
    }

    fn one_in(&mut self, many: u64) -> bool {
        self.below(many) == 0
    }

    /// A whole number, or nothing where it is not known.
    fn known(&mut self, from: u64, to: u64) -> Option<u64> {
        (!self.one_in(6)).then(|| from + self.below(to - from + 1))
    }
}

/// A part as somebody prints it: millimetres, days, and a price with what makes it one.
#[derive(Debug, Clone, Default)]
struct Printed {
    diameter: Option<u64>,
    /// Width and height of a box.
    sides: Option<(u64, u64)>,
    length: Option<u64>,
    price: Option<(u64, &'static str, &'static str, Option<u64>)>,
    days: Option<u64>,
}

/// What one of a currency is in euro, eighths so that sums are exact.
const RATES: [(&str, Option<f64>); 4] = [("EUR", Some(1.0)), ("CNY", Some(0.125)), ("USD", Some(0.875)), ("GBP", None)];
/// Days, and whether they are within two years of 2026-11-01.
const DAYS: [(&str, bool); 6] = [
    ("2026-11-01", true),
    ("2024-11-01", true),
    ("2024-10-31", false),
    ("2019-01-01", false),
    ("2028-11-01", true),
    ("2028-11-02", false),
];
/// So many are bought at once.
const BOUGHT: u64 = 10;

impl Printed {
    fn draw(dice: &mut Dice, boxed: bool) -> Printed {
        let sides = boxed.then(|| dice.known(20, 70).zip(dice.known(20, 70))).flatten();
        let price = dice.known(80, 400).map(|price| {
            let (currency, _) = RATES[if dice.one_in(8) { 3 } else { dice.below(3) as usize }];
            let (day, _) = DAYS[if dice.one_in(4) { dice.below(6) as usize } else { 0 }];
            (
                price,
                currency,
                day,
                [None, Some(1), Some(BOUGHT), Some(BOUGHT + 1)]
                    [if dice.one_in(4) { 3 } else { dice.below(3) as usize }],
            )
        });
        Printed {
            diameter: if boxed { None } else { dice.known(30, 90) },
            sides,
            length: dice.known(15, 60),
            price,
            days: dice.known(3, 60),
        }
    }

    /// What it has across its axis.
    fn across(&self) -> Option<f64> {
        let diagonal = self.sides.map(|(w, h)| ((w * w + h * h) as f64).sqrt());
        self.diameter.map(|d| d as f64).or(diagonal)
    }

    fn euro(&self) -> Option<f64> {
        let (price, currency, day, quantity) = self.price?;
        let rate = RATES.iter().find(|(of, _)| *of == currency)?.1?;
        let fresh = DAYS.iter().any(|(of, fresh)| *of == day && *fresh);
        (fresh && quantity.unwrap_or(1) <= BOUGHT).then_some(price as f64 * rate)
    }

    const HEAD: &'static str =
        "outer_diameter [mm],length [mm],price,price_currency,price_date,price_quantity,lead_time [d]";

    fn cells(&self) -> String {
        let cell = |number: Option<u64>| number.map_or_else(String::new, |n| n.to_string());
        let (price, currency, day, quantity) =
            self.price.map_or((None, "", "", None), |(p, c, d, q)| (Some(p), c, d, q));
        [
            cell(self.diameter),
            cell(self.length),
            cell(price),
            currency.into(),
            day.into(),
            cell(quantity),
            cell(self.days),
        ]
        .join(",")
    }

    /// The same as keys of `[joint.gear]`, whose price is an amount of today.
    fn keys(&self) -> String {
        let mut keys = Vec::new();
        keys.extend(self.diameter.map(|d| format!("outer_diameter = \"{d} mm\"")));
        keys.extend(self.length.map(|l| format!("length = \"{l} mm\"")));
        keys.extend(self.price.map(|(price, currency, ..)| format!("price = \"{price} {currency}\"")));
        keys.extend(self.days.map(|d| format!("lead_time = \"{d} d\"")));
        keys.join(", ")
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// A motor with a gear of the catalogue.
    Catalogue,
    /// A motor with a gear that the requirement describes.
    Described,
    /// A motor with a gear of the catalogue that is none.
    Direct,
    /// A motor, and no word of a gear.
    Alone,
    /// A module, round or boxed.
    Module,
}

const KINDS: [Kind; 5] = [Kind::Catalogue, Kind::Described, Kind::Direct, Kind::Alone, Kind::Module];

#[derive(Debug)]
struct Case {
    kind: Kind,
    parts: Vec<Printed>,
    side_by_side: bool,
    /// Bounds on diameter, length, price and lead time, where they are asked for: never a whole number.
    bounds: [Option<f64>; 4],
    /// What of each is kept in reserve.
    reserve: f64,
}

impl Case {
    fn draw(dice: &mut Dice) -> Case {
        let kind = KINDS[dice.below(5) as usize];
        let boxed = kind == Kind::Module && dice.one_in(2);
        let mut parts = vec![Printed::draw(dice, boxed)];
        if matches!(kind, Kind::Catalogue | Kind::Described) {
            let mut gear = Printed::draw(dice, false);
            if kind == Kind::Described {
                gear.price = gear
                    .price
                    .map(|(price, ..)| (price, if dice.one_in(2) { "EUR" } else { "CNY" }, "2026-11-01", None));
            }
            parts.push(gear);
        }
        let around = [(30, 100), (20, 110), (60, 600), (3, 70)];
        let bounds = around.map(|(from, to)| (!dice.one_in(3)).then(|| (from + dice.below(to - from)) as f64 + 0.37));
        let reserve = if dice.one_in(4) { 0.25 } else { 0.0 };
        Case { kind, parts, side_by_side: dice.one_in(3), bounds, reserve }
    }

    /// What the parts say of one of the four.
    fn of(&self, which: usize) -> Vec<Option<f64>> {
        let one = |part: &Printed| match which {
            0 => part.across(),
            1 => part.length.map(|l| l as f64),
            2 => part.euro(),
            _ => part.days.map(|d| d as f64),
        };
        self.parts.iter().map(one).collect()
    }

    /// What is known of one of the four, and whether that is all.
    fn counted(&self, which: usize) -> (f64, bool) {
        let numbers = self.of(which);
        let known: Vec<f64> = numbers.iter().flatten().copied().collect();
        let adds_up = which == 2 || which == 1 && !self.side_by_side;
        let number = if adds_up { known.iter().sum() } else { known.iter().copied().fold(0.0, f64::max) };
        (number, known.len() == numbers.len())
    }

    fn robot(&self) -> Robot {
        let units = ["mm", "mm", "EUR", "d"];
        let names = ["outer_diameter", "axial_length", "price", "lead_time"];
        let mut limits = String::new();
        for ((name, unit), bound) in names.iter().zip(units).zip(self.bounds) {
            limits.extend(bound.map(|bound| format!("{name} = \"{bound} {unit}\"\n")));
        }
        if self.side_by_side && self.bounds[1].is_some() {
            limits.push_str("arrangement = \"side_by_side\"\n");
        }
        if self.reserve > 0.0 {
            let each = names.map(|name| format!("{name} = {}", self.reserve));
            limits.push_str(&format!("reserve = {{ {} }}\n", each.join(", ")));
        }
        let what = match self.kind {
            Kind::Catalogue | Kind::Direct => "gears = [\"*\"]".to_string(),
            Kind::Described => {
                format!("ratio = {{ min = 9, max = 9 }}\ngear = {{ efficiency = 0.9, {} }}", self.parts[1].keys())
            }
            Kind::Alone => "ratio = { min = 9, max = 9 }".into(),
            Kind::Module => "modules = [\"*\"]".into(),
        };
        let rates: Vec<String> =
            RATES[1..].iter().filter_map(|(of, rate)| Some(format!("{of} = {}", (*rate)?))).collect();
        let text = format!(
            "name = \"x\"\nbus = {{ voltage = \"48 V\" }}\n[prices]\ncurrency = \"EUR\"\nrates = {{ {} }}\ndate = \"2026-11-01\"\nquantity = {BOUGHT}\n\
             [[joint]]\nname = \"j\"\nobjective = \"mass\"\n{what}\npoints = [{{ torque = \"0.5 N*m\", speed = \"1 rad/s\", duration = \"1 s\" }}]\n\
             [joint.limits]\n{limits}",
            rates.join(", ")
        );
        requirement::read_source(&Source::new("x.toml", text.clone()).into())
            .unwrap_or_else(|e| panic!("{}\n{text}", e[0]))
    }

    fn catalog(&self, robot: &Robot) -> Catalog {
        let head = Printed::HEAD;
        let motor = format!(
            "id,terminals,current,resistance [ohm],torque_constant [N*m/A],rotor_inertia [kg*m^2],mass [kg],continuous_current [A],source,source_kind,{head}\n\
             m,q_axis,q_axis,0.1,0.1,1e-5,0.5,20,s,derived,{}\n",
            self.parts[0].cells()
        );
        let gear = |kind: &str, ratio: u32, cells: &str| {
            format!(
                "id,kind,ratio,efficiency,mass [kg],source,source_kind,{head}\ng,{kind},{ratio},0.9,0.1,s,derived,{cells}\n"
            )
        };
        let (width, height) =
            self.parts[0].sides.map_or((String::new(), String::new()), |(w, h)| (w.to_string(), h.to_string()));
        let module = format!(
            "id,drive,ratio,peak_torque [N*m],rated_torque [N*m],no_load_speed [rad/s],voltage [V],min_voltage [V],max_voltage [V],driving_curve [rad/s : N*m],\
             armature [kg*m^2],armature_side,mass [g],source,source_kind,width [mm],height [mm],{head}\n\
             m,built_in,9,60,50,100,48,20,60,0:60 90:60 100:0,0.002,output,500,s,derived,{width},{height},{}\n",
            self.parts[0].cells()
        );
        let texts = match self.kind {
            Kind::Module => vec![module],
            Kind::Catalogue => vec![motor, gear("planetary", 9, &self.parts[1].cells())],
            Kind::Direct => vec![motor, gear("direct", 1, ",,,,,,")],
            Kind::Described | Kind::Alone => vec![motor],
        };
        let sources = texts.into_iter().map(|text| Arc::new(Source::new("rows.csv", text))).collect();
        Catalog::from_sources(sources)
            .unwrap_or_else(|e| panic!("{}", e[0]))
            .with_modules(robot.modules(), |module| module)
    }
}

#[test]
fn what_all_parts_say_is_kept_or_exceeded_and_what_one_does_not_say_is_neither() {
    let mut dice = Dice(7);
    let mut seen = [[0; 3]; 4];
    for round in 0..1500 {
        let case = Case::draw(&mut dice);
        let robot = case.robot();
        let catalog = case.catalog(&robot);
        let result = optimize(&robot, &catalog);
        let joint = &result.joints[0];
        // 0 kept, 1 exceeded, 2 not known.
        let verdicts: Vec<Option<usize>> = (0..4)
            .map(|which| {
                let bound = case.bounds[which]? * (1.0 - case.reserve);
                let (number, whole) = case.counted(which);
                let verdict = if number > bound { 1 } else { usize::from(!whole) * 2 };
                seen[which][verdict] += 1;
                Some(verdict)
            })
            .collect();
        let has = |verdict: usize| verdicts.contains(&Some(verdict));
        let counts = (joint.candidates.len(), joint.unjudged.len(), joint.rejected.len());
        let wanted = match (has(1), has(2)) {
            (true, _) => (0, 0, 1),
            (false, true) => (0, 1, 0),
            (false, false) => (1, 0, 0),
        };
        assert_eq!(counts, wanted, "{round}: {case:?} {:?}", joint.rejected.first().map(|r| &r.reason));
        let unjudged = joint.unjudged.first().map(|u| &u.because).into_iter().flatten();
        for (limit, why) in unjudged {
            let part = ["motor", "gear", "module"].iter().position(|part| why.contains(part));
            assert!(
                ["outer_diameter", "axial_length", "price", "lead_time"].contains(limit) && part.is_some(),
                "{limit}: {why}"
            );
        }
        let Some(design) = joint.candidates.first() else { continue };
        let e = &design.evaluation;
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-12 * b.abs();
        let (price, all) = case.counted(2);
        let cost = e.price.unwrap();
        assert!(near(cost.whole.known, price) && cost.whole.missing.is_none() == all, "{case:?}");
        assert_eq!(cost.currency.code(), "EUR");
        let (days, all) = case.counted(3);
        assert!(near(e.lead_time.known, days * 86_400.0) && e.lead_time.missing.is_none() == all, "{case:?}");
        // What binds is that of the part which has it.
        for (name, which) in [("outer_diameter", 0), ("lead_time", 3)] {
            let Some(margin) = e.margins.iter().find(|m| m.limit == name) else { continue };
            let numbers = case.of(which);
            let largest = numbers.iter().flatten().copied().fold(0.0, f64::max);
            let of = numbers.iter().position(|n| *n == Some(largest)).unwrap();
            let kind = if case.kind == Kind::Module { PartKind::Module } else { [PartKind::Motor, PartKind::Gear][of] };
            assert_eq!(margin.parts.unwrap().part, Some(kind), "{case:?}");
        }
        let modules = case.kind == Kind::Module;
        let assumes = design.assumed.iter().any(|(name, what)| *name == "price" && what.contains("no gear"));
        assert_eq!(assumes, case.kind == Kind::Alone && case.bounds[2].is_some());
        assert!(!design.assumed.iter().any(|(_, what)| what.starts_with("drive not inside")) || modules);
    }
    // Each verdict of each limit was met often enough to mean something.
    assert!(seen.iter().flatten().all(|count| *count >= 60), "{seen:?}");
}

/// A direct drive of which nothing is described has nothing to add, and nothing is assumed of it.
#[test]
fn a_direct_drive_has_nothing_to_add() {
    let text = "name = \"x\"\nbus = { voltage = \"48 V\" }\n[[joint]]\nname = \"j\"\nobjective = \"mass\"\nratio = { min = 1, max = 1 }\n\
                points = [{ torque = \"0.5 N*m\", speed = \"1 rad/s\", duration = \"1 s\" }]\n[joint.limits]\nouter_diameter = \"50 mm\"\n";
    let robot = requirement::read_source(&Source::new("x.toml", text).into()).unwrap();
    let motor = format!(
        "id,terminals,current,resistance [ohm],torque_constant [N*m/A],rotor_inertia [kg*m^2],mass [kg],continuous_current [A],source,source_kind,{}\n\
         m,q_axis,q_axis,0.1,0.1,1e-5,0.5,20,s,derived,50,,,,,,\n",
        Printed::HEAD
    );
    let catalog = Catalog::from_sources(vec![Arc::new(Source::new("rows.csv", motor))]).unwrap();
    let result = optimize(&robot, &catalog);
    let design = &result.joints[0].candidates[0];
    let margin = design.evaluation.margins.iter().find(|m| m.limit == "outer_diameter").unwrap();
    assert_eq!((margin.demand, margin.margin), (0.05, 0.0));
    assert!(!design.assumed.iter().any(|(name, _)| *name == "outer_diameter"));
    // Without [prices] no price is counted.
    assert!(design.evaluation.price.is_none());
}

/// The size of a module is its own, also where rows say what is inside it.
#[test]
fn a_module_counts_as_printed_and_not_by_the_motor_inside() {
    let catalog = Catalog::read(&[repository("catalogs")]).unwrap_or_else(|e| panic!("{}", e[0]));
    let pattern = ["*".to_string()];
    let all = catalog.clone().with_modules(pattern.iter(), |module| module);
    let mut compared = 0;
    for module in &catalog.modules {
        let motor = all.motors.iter().find(|m| m.id == module.id).unwrap();
        let sheet = &module.sheet;
        let value = |p: Option<gearwise::catalog::Printed>| p.map(|p| p.value);
        let box_of = value(sheet.width).zip(value(sheet.height)).map(|(w, h)| (w * w + h * h).sqrt());
        let (found, wanted) = (value(motor.sheet.outer_diameter), value(sheet.outer_diameter).or(box_of));
        assert_eq!(found.is_some(), wanted.is_some(), "{}", module.id);
        assert!(found.zip(wanted).is_none_or(|(a, b)| (a / b - 1.0).abs() < 1e-12), "{}", module.id);
        assert_eq!(value(motor.sheet.length), value(sheet.length), "{}", module.id);
        assert_eq!(motor.sheet.offer, sheet.offer);
        compared += 1;
    }
    assert!(compared > 100);
}
