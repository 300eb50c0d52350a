//! Size, price and lead time of an actuator as a user meets them: as limits, as figures, as columns of all three kinds of row. What
//! is not known of a part is never said to be kept.

use std::fs;

use serde_json::Value;
use tempfile::TempDir;

use super::folder::{Ran, run};
use super::json::published;

const ROBOT: &str = r#"name = "leg"
[bus]
voltage = "48 V"

[prices]
currency = "EUR"
rates = { CNY = 0.125 }
date = "2026-11-01"

[[joint]]
name = "knee"
count = 2
ratio = { min = 9, max = 9 }
gear = { efficiency = 0.9, mass = "100 g", outer_diameter = "60 mm", length = "20 mm", price = "400 CNY", lead_time = "7 d" }
objective = "mass"
points = [ { torque = "1 N*m", speed = "1 rad/s", duration = "1 s" } ]
[joint.limits]
outer_diameter = "70 mm"
axial_length = "50 mm"
price = "250 EUR"
lead_time = "30 d"
"#;

/// A motor of 55 mm and 25 mm that costs 180 EUR and is there after 14 days; one like it of which nobody knows that.
const MOTORS: &str = "id,terminals,current,resistance [ohm],torque_constant [N*m/A],rotor_inertia [kg*m^2],mass [kg],continuous_current [A],outer_diameter [mm],length [mm],price,price_currency,price_date,price_quantity,lead_time [d],source,source_kind
known,q_axis,q_axis,0.1,0.1,1e-5,0.5,20,55,25,180,EUR,2026-03-01,,14,a sheet,datasheet
blank,q_axis,q_axis,0.1,0.1,1e-5,0.5,20,,,,,,,,a sheet,datasheet
";

fn folder(robot: &str, motors: &str) -> TempDir {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("leg.toml"), robot).unwrap();
    fs::write(folder.path().join("motors.csv"), motors).unwrap();
    folder
}

fn answer(ran: &Ran) -> Value {
    let answer: Value = serde_json::from_str(&ran.out).unwrap_or_else(|e| panic!("{e}: {}{}", ran.out, ran.err));
    assert!(published().is_valid(&answer));
    answer
}

fn optimized(robot: &str, motors: &str) -> Value {
    answer(&run(&folder(robot, motors), &["optimize", "leg.toml", "--catalog", "motors.csv", "--json"]))
}

fn flat(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Of a motor: whether it is a choice, and why it cannot be judged.
fn of(answer: &Value, motor: &str) -> Result<Value, Vec<String>> {
    let joint = &answer["joints"][0];
    let find = |list: &str| joint[list].as_array().unwrap().iter().find(|m| m["motor"] == motor).cloned();
    if let Some(found) = find("candidates") {
        return Ok(found);
    }
    let texts = |value: &Value| value.as_str().unwrap().to_string();
    match find("unjudged") {
        Some(found) => Err(found["limits"].as_array().unwrap().iter().map(|limit| texts(&limit["because"])).collect()),
        None => Err(vec![texts(&find("rejected").unwrap()["because"])]),
    }
}

#[test]
fn a_design_says_what_its_parts_come_to_and_whose_number_binds() {
    let found = optimized(ROBOT, MOTORS);
    let known = of(&found, "known").unwrap();
    // 180 + 400 × 0.125, the longer of 14 and 7 days.
    assert_eq!((known["price"].as_f64(), known["price_currency"].as_str()), (Some(230.0), Some("EUR")));
    assert_eq!(known["lead_time_s"].as_f64(), Some(14.0 * 86_400.0));
    let limits = known["limits"].as_array().unwrap();
    let limit = |name: &str| limits.iter().find(|l| l["limit"] == name).unwrap();
    let near = |value: &Value, of: f64| (value.as_f64().unwrap() - of).abs() < 1e-9;
    assert!(near(&limit("outer_diameter")["demand"], 0.06) && limit("outer_diameter")["part"] == "gear");
    assert!(near(&limit("axial_length")["demand"], 0.045) && limit("axial_length").get("part").is_none());
    assert!(near(&limit("price")["margin"], 1.0 - 230.0 / 250.0) && limit("price")["unit"] == "EUR");
    assert!(near(&limit("lead_time")["demand"], 14.0) && limit("lead_time")["part"] == "motor");
    assert_eq!(limit("lead_time")["unit"], "d");
    let because = of(&found, "blank").unwrap_err();
    assert_eq!(because.len(), 4, "{because:?}");
    // In words.
    let ran =
        run(&folder(ROBOT, MOTORS), &["explain", "known", "leg.toml", "--joint", "knee", "--catalog", "motors.csv"]);
    let text = flat(&ran.out);
    for said in ["requirement on the gear", "requirement on the motor", "price 230 EUR", "lead time 14 d"] {
        assert!(text.contains(said), "{said}: {text}");
    }
}

/// What is not known of one part, however little of the limit the other one takes.
#[test]
fn what_is_not_known_of_one_part_is_not_kept() {
    for (from, to, why) in [
        (", outer_diameter = \"60 mm\"", "", "the gear's outer diameter is not known"),
        (", length = \"20 mm\"", "", "the gear's axial length is not known"),
        (", price = \"400 CNY\"", "", "the gear's price is not known"),
        (", lead_time = \"7 d\"", "", "the gear's lead time is not known"),
    ] {
        assert!(ROBOT.contains(from));
        let found = optimized(&ROBOT.replace(from, to), MOTORS);
        assert_eq!(of(&found, "known").unwrap_err(), [why], "{from}");
    }
    for (from, to, why) in [
        ("55,25,", ",25,", "the motor's outer diameter is not known"),
        ("55,25,", "55,,", "the motor's axial length is not known"),
        ("180,EUR,2026-03-01", ",,", "the motor's price is not known"),
        (
            "180,EUR,2026-03-01",
            "180,USD,2026-03-01",
            "the motor's price is in a currency that [prices] has no rate for",
        ),
        (
            "180,EUR,2026-03-01",
            "180,EUR,2024-10-31",
            "the motor's price is more than two years from the date of [prices]",
        ),
        (
            "180,EUR,2026-03-01,",
            "180,EUR,2026-03-01,100",
            "the motor's price is that of more pieces than the quantity of [prices]",
        ),
        (",14,a sheet", ",,a sheet", "the motor's lead time is not known"),
    ] {
        assert!(MOTORS.contains(from));
        let found = optimized(ROBOT, &MOTORS.replacen(from, to, 1));
        assert_eq!(of(&found, "known").unwrap_err(), [why], "{from}");
    }
    // The price of a hundred holds for who buys a hundred.
    let (many, hundred) = (
        MOTORS.replacen("180,EUR,2026-03-01,", "180,EUR,2026-03-01,100", 1),
        ROBOT.replace("[prices]", "[prices]\nquantity = 100"),
    );
    assert!(of(&optimized(&hundred, &many), "known").is_ok());
    // A map of gears over the ratio has no size either.
    let map = folder(
        &ROBOT.replace("efficiency = 0.9, mass = \"100 g\", outer_diameter = \"60 mm\"", "map = \"map.csv\""),
        MOTORS,
    );
    fs::write(map.path().join("map.csv"), "ratio,efficiency,mass [g]\n5,0.9,100\n15,0.9,100\n").unwrap();
    let found = answer(&run(&map, &["optimize", "leg.toml", "--catalog", "motors.csv", "--json"]));
    assert_eq!(of(&found, "known").unwrap_err(), ["the gear's outer diameter is not known"]);
    // Where a part alone is too much, the whole is: it is exceeded, and no matter of knowing.
    for (limit, other, gear) in [
        ("outer_diameter = \"70 mm\"", "outer_diameter = \"50 mm\"", ", outer_diameter = \"60 mm\""),
        ("axial_length = \"50 mm\"", "axial_length = \"20 mm\"", ", length = \"20 mm\""),
        ("price = \"250 EUR\"", "price = \"150 EUR\"", ", price = \"400 CNY\""),
        ("lead_time = \"30 d\"", "lead_time = \"10 d\"", ", lead_time = \"7 d\""),
    ] {
        let robot = ROBOT.replace(limit, other).replace(gear, "");
        // More may be needed: nothing is promised of a limit that the known part alone would keep.
        let ran = run(
            &folder(&robot, MOTORS),
            &["explain", "known", "leg.toml", "--joint", "knee", "--catalog", "motors.csv"],
        );
        assert!(!ran.out.contains("would make it feasible"), "{}", ran.out);
        let found = optimized(&robot, MOTORS);
        let because = of(&found, "known").unwrap_err();
        assert!(because[0].contains("is exceeded"), "{because:?}");
    }
}

/// A gear that the requirement does not describe is an ideal one: only the motor counts, and that is said.
#[test]
fn an_ideal_gear_has_no_size_and_that_is_an_assumption() {
    let gear = ROBOT.lines().find(|line| line.starts_with("gear")).unwrap();
    let assumed = |robot: &str| {
        let known = of(&optimized(robot, MOTORS), "known").unwrap();
        let all = known["assumed"].as_array().unwrap().clone();
        all.into_iter().filter(|a| a["as"].as_str().unwrap().contains("describes no gear")).count()
    };
    assert_eq!(assumed(&ROBOT.replace(gear, "")), 4);
    assert_eq!(assumed(&ROBOT.replace(gear, "").replace("min = 9, max = 9", "min = 1, max = 1")), 0);
    assert_eq!(assumed(ROBOT), 0);
    // Side by side the longer one counts.
    let tight = ROBOT.replace("axial_length = \"50 mm\"", "axial_length = \"30 mm\"");
    assert!(of(&optimized(&tight, MOTORS), "known").is_err());
    let tight = tight.replace("axial_length", "arrangement = \"side_by_side\"\naxial_length");
    assert!(of(&optimized(&tight, MOTORS), "known").is_ok());
}

#[test]
fn modules_count_as_printed_and_the_others_are_said_to_be_without_drive() {
    let robot = ROBOT.replace("count = 2", "count = 2\nmodules = [\"robstride-rs0*\", \"robotis-xm430-w350\"]");
    let robot = robot
        .replace("axial_length = \"50 mm\"\n", "")
        .replace("lead_time = \"30 d\"\n", "")
        .replace("outer_diameter = \"70 mm\"\n", "");
    let folder = folder(&robot, MOTORS);
    let found = answer(&run(&folder, &["optimize", "leg.toml", "--also", "motors.csv", "--json"]));
    let without_drive = |design: &Value| {
        let assumed = design["assumed"].as_array().unwrap();
        assumed.iter().any(|a| a["limit"] == "price" && a["as"].as_str().unwrap().starts_with("drive not inside"))
    };
    // 598 CNY of 26 June 2025.
    let rs00 = of(&found, "robstride-rs00-module").unwrap();
    assert_eq!(rs00["price"].as_f64(), Some(598.0 * 0.125));
    assert!(!without_drive(&rs00) && without_drive(&of(&found, "known").unwrap()));
    // No row of RobStride says the price of its newer kinds.
    let because = of(&found, "robstride-rs02-ip67").unwrap_err();
    assert_eq!(because, ["the module's price is not known"]);
    // A servo of 28.5 mm by 46.5 mm goes through a tube of 54.6 mm, not of 54.5 mm.
    for (diameter, fits) in [("54.6 mm", true), ("54.5 mm", false)] {
        let robot = robot
            .replace("price = \"250 EUR\"", &format!("outer_diameter = \"{diameter}\""))
            .replace("\"1 N*m\"", "\"0.001 N*m\"")
            .replace("48 V", "12 V");
        fs::write(folder.path().join("leg.toml"), robot).unwrap();
        let found = answer(&run(&folder, &["optimize", "leg.toml", "--json"]));
        let said = of(&found, "robotis-xm430-w350");
        let exceeded = said.as_ref().is_err_and(|why| why[0].starts_with("outer_diameter is 1.001 times"));
        assert_eq!(!exceeded, fits, "{said:?}");
    }
}

#[test]
fn the_robot_sums_prices_up_and_says_how_many_are_known() {
    let hip =
        ROBOT[ROBOT.find("[[joint]]").unwrap()..].replace("\"knee\"", "\"hip\"").replace("count = 2", "count = 3");
    let limits = |text: &str| text.replace("price = \"250 EUR\"\n", "");
    let both = format!("{}\n[budget]\nactuator_mass = \"9 kg\"\n", limits(&format!("{ROBOT}{hip}")));
    let sum = |robot: &str| {
        let folder = folder(robot, MOTORS);
        let text = flat(&run(&folder, &["optimize", "leg.toml", "--catalog", "motors.csv"]).out);
        let found = answer(&run(&folder, &["optimize", "leg.toml", "--catalog", "motors.csv", "--json"]));
        (text, found["robot"]["choice"]["best"]["price"].clone())
    };
    let (text, price) = sum(&both);
    assert!(text.contains("3 kg, 1150 EUR, one motor"), "{text}");
    assert_eq!((price["total"].as_f64(), price["actuators"].as_u64()), (Some(1150.0), Some(5)));
    // Of the knee's two gears nobody says a price.
    let (text, price) = sum(&both.replacen(", price = \"400 CNY\"", "", 1));
    assert!(text.contains("at least 1050 EUR (the price of 3 of 5 actuators is known)"), "{text}");
    assert_eq!((price["total"].as_f64(), price["at_least"].as_f64()), (None, Some(1050.0)));
    assert_eq!(price["known_actuators"].as_u64(), Some(3));
    // Without [prices] nobody counts.
    let prices = &both[both.find("[prices]").unwrap()..both.find("[[joint]]").unwrap()];
    let plain = both.replace(prices, "").replace(", price = \"400 CNY\"", "");
    let (text, price) = sum(&plain);
    assert!(!text.contains("EUR") && !text.contains("price") && price.is_null(), "{text}");
}

#[test]
fn filters_search_the_same_columns_in_rows_of_every_kind() {
    let folder = TempDir::new().unwrap();
    let offer = "outer_diameter [mm],length [mm],price,price_currency,price_date,price_quantity,lead_time [d]";
    let row = |head: &str, cells: &str, kind: &str| {
        let rows =
            [("small", "40,20,90,EUR,2026-01-31,,7"), ("large", "80,60,900,CNY,2026-02-28,10,70"), ("blank", ",,,,,,")];
        let rows = rows.map(|(size, offer)| format!("{kind}-{size},{cells},s,derived,{offer}\n"));
        format!("id,{head},source,source_kind,{offer}\n{}", rows.concat())
    };
    let motors = row("terminals,current,resistance [ohm],torque_constant [N*m/A]", "q_axis,q_axis,1,1", "motor");
    let gears = row("kind,ratio", "planetary,9", "gear");
    let modules = row("drive,ratio", "built_in,9", "module");
    for (name, text) in [("motors.csv", motors), ("gears.csv", gears), ("modules.csv", modules)] {
        fs::write(folder.path().join(name), text).unwrap();
    }
    let listed = |filter: &str| {
        let files = ["--catalog", "motors.csv", "gears.csv", "modules.csv", "--json"];
        let ran = run(&folder, &[&["catalog", "list", filter], &files[..]].concat());
        let found = answer(&ran);
        let ids = |list: &str| {
            found[list].as_array().unwrap().iter().map(|r| r["id"].as_str().unwrap().to_string()).collect::<Vec<_>>()
        };
        ([ids("motors"), ids("gears"), ids("modules")].concat(), found["unknown_rows"].as_u64().unwrap())
    };
    let each = |size: &str| ["motor", "gear", "module"].map(|kind| format!("{kind}-{size}")).to_vec();
    for (filter, size, unknown) in [
        ("price<100", "small", 3),
        ("price_currency=CNY", "large", 3),
        ("lead_time<=2 d", "none", 3),
        ("lead_time<=10 d", "small", 3),
        ("outer_diameter>=6 cm", "large", 3),
        ("length<30mm", "small", 3),
        ("price_quantity>=10", "large", 6),
    ] {
        let wanted = if size == "none" { Vec::new() } else { each(size) };
        assert_eq!(listed(filter), (wanted, unknown), "{filter}");
    }
    // Cards say what a price means.
    for (id, said) in [
        ("motor-small", "price: 90 EUR, 2026-01-31"),
        ("gear-large", "price: 900 CNY each of 10, 2026-02-28"),
        ("module-large", "lead time: 70 d"),
        ("gear-blank", "length: a limit on the axial length cannot be judged"),
    ] {
        let ran = run(&folder, &["catalog", "show", id, "--catalog", "motors.csv", "gears.csv", "modules.csv"]);
        assert!(flat(&ran.out).contains(said), "{id}: {}{}", ran.out, ran.err);
    }
    // Prices of one currency and quantity alone are compared.
    let ran = run(&folder, &["compare", "motor-small", "motor-large", "--catalog", "motors.csv"]);
    let text = flat(&ran.out);
    assert!(text.contains("price 90 EUR, 2026-01-31 900 CNY each of 10, 2026-02-28"), "{text}");
    assert!(text.contains("lead time [d] 7 70 10×"), "{text}");
}

#[test]
fn a_row_with_a_price_goes_into_ones_own_catalogue_and_back() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("mine.csv"), "id,kind,ratio,source,source_kind\nfirst,planetary,5,s,derived\n")
        .unwrap();
    let row = "[[gear]]\nid = \"second\"\nkind = \"spur\"\nratio = 3\nouter_diameter = \"4 cm\"\nlength = \"12 mm\"\nprice = 35.5\nprice_currency = \"CHF\"\nprice_date = \"2026-05-05\"\nlead_time = \"2 d\"\nsource = \"s\"\nsource_kind = \"derived\"\n";
    fs::write(folder.path().join("row.toml"), row).unwrap();
    let ran = run(&folder, &["catalog", "add", "row.toml", "--to", "mine.csv"]);
    assert_eq!(ran.status, 0, "{}", ran.err);
    let ran = run(&folder, &["catalog", "show", "second", "--catalog", "mine.csv"]);
    let text = flat(&ran.out);
    for said in ["price: 35.5 CHF, 2026-05-05", "lead time: 2 d", "outer_diameter 40 mm", "length 12 mm"] {
        assert!(text.contains(said), "{said}: {text}");
    }
    let ran = run(
        &folder,
        &[
            "catalog",
            "new",
            "gear",
            "--set",
            "id=a",
            "--set",
            "kind=spur",
            "--set",
            "ratio=3",
            "--set",
            "price=35",
            "--set",
            "source=s",
            "--set",
            "source_kind=derived",
        ],
    );
    assert!(ran.status == 2 && ran.err.contains("`price` is given without `price_currency`"), "{}", ran.err);
}
