use super::super::noise::Reading;
use super::super::origin::Channels;
use super::super::steady::noise;
use super::*;
use crate::answer::{Hidden, Target};
use crate::read;
use crate::{Bench, Channel};
use gearwise_model::effects::{EFFECTS, Operating};
use gearwise_model::effects::{FittedEffect, Variable};

/// Columns of a log, in the order of their values.
const COLUMNS: [(&str, Channel); 11] = [
    ("current = { name = \"i\", unit = \"A\", convention = \"q_axis\" }", Channel::Current),
    ("motor_velocity = { name = \"wm\", unit = \"rad/s\" }", Channel::MotorVelocity),
    ("motor_position = { name = \"qm\", unit = \"rad\" }", Channel::MotorPosition),
    ("output_velocity = { name = \"wo\", unit = \"rad/s\" }", Channel::OutputVelocity),
    ("output_position = { name = \"qo\", unit = \"rad\" }", Channel::OutputPosition),
    ("torque = { name = \"tau\", unit = \"N*m\", side = \"output\" }", Channel::Torque),
    ("voltage = { name = \"u\", unit = \"V\", convention = \"q_axis\" }", Channel::Voltage),
    ("winding_temperature = { name = \"temp\", unit = \"degC\" }", Channel::WindingTemperature),
    ("duty = { name = \"d\", unit = \"1\" }", Channel::Duty),
    ("supply = { name = \"v\", unit = \"V\" }", Channel::Supply),
    ("time = { name = \"t\", unit = \"s\" }", Channel::Command),
];

/// A log of a kind with all channels, of which those that are not wanted are taken out.
fn bench(kind: &str, head: &str, wanted: &[Channel]) -> Bench {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: String| std::fs::write(folder.path().join(name), text).expect("it can be written");
    write(
        "motors.csv",
        "id,terminals,current,resistance [ohm],torque_constant [N*m/A],rotor_inertia [kg*m^2],source,source_kind\n\
         m,q_axis,q_axis,0.5,0.1,3e-5,-,derived\n"
            .into(),
    );
    let columns: Vec<&str> = COLUMNS.iter().map(|c| c.0).collect();
    write(
        "bench.toml",
        format!(
            "catalog = [\"motors.csv\"]\nactuator = {{ motor = \"m\", ratio = 6 }}\nkind = \"{kind}\"\n{head}\n[columns]\n{}\n\
             [[log]]\nfile = \"log.csv\"\n",
            columns.join("\n")
        ),
    );
    let mut rows = String::from("i,wm,qm,wo,qo,tau,u,temp,d,v,t\n");
    for k in 0..3000 {
        let t = 1e-3 * f64::from(k);
        let place = k as usize;
        let (w, q) = (60.0 * (3.0 * t).sin() + 25.0 * (7.1 * t).cos(), 12.0 * t + 20.0 * (1.0 - (3.0 * t).cos()));
        let i = 3.0 * (11.0 * t).sin() + 2.0 * (17.3 * t).cos();
        let speed = w + 0.1 * noise(place);
        let values = [
            i + 0.01 * noise(place + 10_000),
            speed,
            q,
            speed / 6.0,
            q / 6.0 + 1e-3 * noise(place + 20_000),
            0.6 * i + 0.01 * noise(place + 30_000),
            0.5 * i + 0.1 * w + 0.01 * noise(place + 40_000),
            25.0 + 20.0 * t,
            (0.5 * i + 0.1 * w) / 48.0,
            48.0 + 0.1 * noise(place + 50_000),
            t,
        ];
        rows += &(values.map(|v| format!("{v:?}")).join(",") + "\n");
    }
    write("log.csv", rows);
    let mut bench = read::read(&folder.path().join("bench.toml")).unwrap_or_else(|e| panic!("{e:?}"));
    bench.logs[0].channels.retain(|c, _| wanted.contains(c));
    bench
}

fn balance(bench: &Bench, target: Target) -> Balance {
    let setting = Setting { corrections: Corrections::none(1), band: Some(60.0), rows: 4000, samples: usize::MAX };
    Balance::new(bench, target, &setting).expect("rows")
}

/// The benches of the table below, with the equation that is looked at.
fn benches() -> Vec<(&'static str, Bench, Target)> {
    use Channel::{
        Current as I, Duty as D, MotorPosition as QM, MotorVelocity as WM, OutputPosition as QO, OutputVelocity as WO,
        Supply as V, Torque as T, Voltage as U, WindingTemperature as H,
    };
    let load = "load = { inertia = \"0.02 kg*m^2\" }";
    let pendulum = "pendulum = { mass = \"1 kg\", length = \"0.1 m\" }";
    let made = |name, kind: &str, head: &str, wanted: &[Channel], target| (name, bench(kind, head, wanted), target);
    vec![
        made("sensor, motor side", "dynamometer", "", &[I, WM, QM, T, H], Target::Torque),
        made("sensor, output side", "dynamometer", "", &[I, WO, QO, T, H], Target::Torque),
        made("known load, motor side", "free", load, &[I, WM, QM, H], Target::Drive),
        made("known load, output side", "free", load, &[I, WO, QO, H], Target::Drive),
        made("pendulum, output side", "free", pendulum, &[I, WO, QO, H], Target::Drive),
        made("voltage and current", "electrical", "", &[I, WM, U, H], Target::Voltage),
        made("duty, supply and current", "electrical", "", &[I, WM, D, V, H], Target::Voltage),
        made("voltage without a current", "electrical", "", &[WM, U, H], Target::Voltage),
        made("open terminals", "backdrive", "", &[WM, U, H], Target::Voltage),
        made("wind-up, sensor", "dynamometer", "", &[I, WM, QM, WO, QO, T], Target::WindUp),
        made("wind-up, load by velocity", "free", load, &[I, WM, QM, WO, QO], Target::WindUp),
        made("wind-up, load by position", "free", load, &[I, QM, QO], Target::WindUp),
    ]
}

/// Every effect on every bench above: `o` it is asked, `r` its regressor is made of the response, `l` of the noise of the known
/// load that stands beside the response, `b` the bench does not show it, `e` it is a term of another equation.
const TABLE: [(&str, &str); 18] = [
    ("torque_offset", "bbooo"),
    ("gravity", "bboob"),
    ("viscous_friction", "ooooo"),
    ("coulomb_friction", "ooooo"),
    ("torque_constant_saturation", "oorrr"),
    ("cogging", "ooooo"),
    ("torque_ripple", "oorrr"),
    ("gear_ripple", "ooooo"),
    ("eddy_drag", "ooooo"),
    ("stribeck_friction", "ooooo"),
    ("load_dependent_friction", "ooooo"),
    ("direction_asymmetry", "ooooo"),
    ("torque_constant_temperature", "oorrr"),
    ("winding_temperature", "eeeeeoorb"),
    ("inverter_dead_time", "eeeeeoorb"),
    ("supply_sag", "eeeeebbbb"),
    ("gear_compliance", "brlll"),
    ("backlash", "eeeee"),
];

/// What stands behind the columns of [`TABLE`] that are cut off: effects of torque have nothing in a voltage, and only a spring
/// and play wind up.
fn expected(name: &str, place: usize) -> char {
    let (_, row) = TABLE.iter().find(|t| t.0 == name).unwrap_or_else(|| panic!("{name} is not in the table"));
    row.chars().nth(place).unwrap_or(match (name, place) {
        ("gear_compliance" | "backlash", 9 | 10) => 'o',
        ("gear_compliance" | "backlash", 11) => 'r',
        _ => 'e',
    })
}

#[test]
fn no_effect_is_asked_whose_regressor_is_made_of_the_response() {
    for (place, (bench_name, bench, target)) in benches().into_iter().enumerate() {
        let balance = balance(&bench, target);
        for effect in EFFECTS {
            let found = match visible(*effect, &balance, &bench.declared) {
                Ok(()) => 'o',
                Err(Hidden::Elsewhere) => 'e',
                Err(Hidden::Lacks(_) | Hidden::Bench(_) | Hidden::LeftOut) => 'b',
                Err(Hidden::Response(by)) => {
                    assert!(!by.is_empty());
                    if effect.needs().iter().any(|v| shares_the_response(&balance, *v)) { 'r' } else { 'l' }
                }
            };
            assert_eq!(found, expected(effect.name(), place), "{} on a bench of {bench_name}", effect.name());
        }
    }
}

fn shares_the_response(balance: &Balance, variable: Variable) -> bool {
    balance.stretches.iter().any(|s| {
        let from = match variable {
            Variable::Current => s.origins.current,
            Variable::Torque => s.origins.torque,
            Variable::TorqueCurvature => s.origins.curvature,
            _ => Channels::NONE,
        };
        from.meets(s.origins.response)
    })
}

/// The same table without any bookkeeping: the response's channels are changed in the log, and the columns of an effect
/// change exactly where they are made of it.
#[test]
fn columns_change_with_the_response_exactly_where_the_table_says() {
    use Channel::*;
    for (place, (bench_name, bench, target)) in benches().into_iter().enumerate() {
        let before = balance(&bench, target);
        let response: &[Channel] = match target {
            Target::Torque => &[Torque],
            Target::Drive => &[Current],
            Target::Voltage => &[Voltage, Duty, Supply],
            _ => &[MotorPosition, OutputPosition],
        };
        let spoilt = |channels: &[Channel]| {
            let mut other = bench.clone();
            for channel in channels {
                for (k, v) in other.logs[0].channels.get_mut(channel).into_iter().flatten().enumerate() {
                    *v *= 1.0 + 1e-3 * noise(k + 70_000);
                }
            }
            balance(&other, target)
        };
        let (of_response, of_load) = (spoilt(response), spoilt(&[MotorVelocity, OutputVelocity]));
        for effect in EFFECTS {
            let wanted = expected(effect.name(), place);
            if !matches!(wanted, 'o' | 'r' | 'l') {
                continue;
            }
            let shape = if effect.shape() == gearwise_model::effects::Shape::Order { 6.0 } else { 2.0 };
            let differs = |other: &Balance| {
                let (a, b) = (before.effect_columns(*effect, shape), other.effect_columns(*effect, shape));
                a.iter().flatten().zip(b.iter().flatten()).any(|(a, b)| (a - b).abs() > 1e-9 * a.abs())
            };
            assert_eq!(differs(&of_response), wanted == 'r', "{} on a bench of {bench_name}", effect.name());
            if wanted == 'l' {
                // With gravity the load has a parameter, and stands among the columns.
                let equation = |b: &Balance| {
                    let base: Vec<Vec<f64>> = (0..b.base.len()).map(|i| b.base_column(i)).collect();
                    (b.target_column(), base)
                };
                assert!(differs(&of_load) && equation(&before) != equation(&of_load), "{}", effect.name());
            }
        }
    }
}

/// Takes what is known of a variable from an operating point.
type Hide = fn(&mut Operating);

/// What an effect needs is at least what its equation reads.
#[test]
fn an_effect_needs_what_it_reads() {
    let at = Operating {
        speed: 30.0,
        direction: 1.0,
        angle: 0.7,
        output_angle: 0.1,
        current: 7.0,
        torque: 0.6,
        torque_curvature: 3.0,
        winding_rise: 40.0,
        housing_rise: 20.0,
        duty: 0.4,
    };
    let hidden: [(Variable, Hide); 9] = [
        (Variable::Speed, |p| (p.speed, p.direction) = (f64::NAN, f64::NAN)),
        (Variable::Angle, |p| p.angle = f64::NAN),
        (Variable::OutputAngle, |p| p.output_angle = f64::NAN),
        (Variable::Current, |p| p.current = f64::NAN),
        (Variable::Torque, |p| p.torque = f64::NAN),
        (Variable::TorqueCurvature, |p| p.torque_curvature = f64::NAN),
        (Variable::WindingTemperature, |p| p.winding_rise = f64::NAN),
        (Variable::HousingTemperature, |p| p.housing_rise = f64::NAN),
        (Variable::Duty, |p| p.duty = f64::NAN),
    ];
    for effect in EFFECTS {
        for (variable, hide) in hidden {
            let mut point = at;
            hide(&mut point);
            let reads = effect.basis(12.0, &point) != effect.basis(12.0, &at);
            assert!(!reads || effect.needs().contains(&variable), "{} reads {variable:?}", effect.name());
        }
    }
}

/// A declared effect whose regressor is the response stays as declared: it is no term, and it is not dropped either.
#[test]
fn what_is_declared_of_the_response_stays_as_declared() {
    use crate::identify::Work;
    let (_, undeclared, target) = benches().swap_remove(2);
    let plain = Work::new(&undeclared, balance(&undeclared, target));
    let mut bench = undeclared.clone();
    bench.declared.effects.push(FittedEffect::new("torque_constant_saturation", vec![0.05, 4.0]).unwrap());
    let with = Work::new(&bench, balance(&bench, target));
    assert_eq!((with.terms.len(), with.fixed.len(), plain.fixed.len()), (plain.terms.len(), 1, 0));
    let effect = gearwise_model::effects::effect("torque_constant_saturation").unwrap();
    let column = with.balance.function(|at| effect.value(&[0.05, 4.0], at));
    for ((a, b), c) in plain.target.iter().zip(&with.target).zip(&column) {
        assert!((a - b - c).abs() < 1e-12 && column.iter().any(|c| c.abs() > 0.01));
    }
}

#[test]
fn held_channels_and_coarse_ones_are_told_apart() {
    let wild: Vec<f64> = (0..600).map(noise).collect();
    assert_eq!(Reading::new(&wild, 1.0).rows, 1.0);
    let held: Vec<f64> = (0..600).map(|k| noise(k / 15)).collect();
    assert_eq!(Reading::new(&held, 1.0).rows, 15.0);
    let coarse: Vec<f64> = (0..600).map(|k| (10.0 * (0.01 * k as f64).sin()).round() * 0.5).collect();
    let reading = Reading::new(&coarse, -2.0);
    assert_eq!(reading.rows, 1.0);
    assert!((reading.quantum - 1.0).abs() < 1e-9);
    // A drive that is off half of the time is not held.
    let off: Vec<f64> = (0..600).map(|k| if k < 300 { 0.0 } else { noise(k) }).collect();
    assert_eq!(Reading::new(&off, 1.0).rows, 1.0);
    assert_eq!(Reading::new(&[1.0; 9], 1.0), Reading { quantum: 0.0, rows: 1.0 });
    let both = Reading { quantum: 3.0, rows: 2.0 }.and(Reading { quantum: 4.0, rows: 1.0 });
    assert_eq!(both, Reading { quantum: 5.0, rows: 2.0 });
}
