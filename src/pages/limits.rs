use super::{MADE, table};
use crate::actuator::Load;
use crate::actuator::limits::{Check, LIMITS, Limit, Verdict};
use crate::catalog::Catalog;
use crate::design::Mount;
use crate::input::Source;
use crate::requirement;

/// The page of limits.
pub fn text() -> String {
    let mut out = format!(
        "{MADE}# Limits\n\nWhat a design must keep. Sweep, ratio program, `explain` and the design rules read this one list. T is the \
         torque at the motor's shaft, τ the load's at the output, both at every instant of the motion; see [the model](model.md). A limit \
         that nobody asks for is not checked; one that should be but cannot be is listed as *not checked* with every design. Heat \
         and what the requirement itself states (a mass, a size, a price, an inertia, a winding temperature, a torque bandwidth, a life, a backlash, a budget) have to be judged: \
         a motor of which they cannot be is listed apart as *cannot be judged* and is never a choice. Continuous current, continuous torque \
         and thermal resistances are witnesses of one limit, heat: one of them judges it. What a row lacks is [estimated](estimates.md) \
         where rows built alike say it.\n\n{}\n\n",
        crate::report::currents::Q_AXIS
    );
    let missing = missing();
    let rows = LIMITS.iter().map(|limit| {
        let needs = missing.iter().filter(|(name, _)| *name == limit.name).map(|(_, why)| *why);
        let needs: Vec<&str> = needs.collect();
        let needs = if needs.is_empty() { "what it compares is not given".into() } else { needs.join("; ") };
        vec![
            format!("`{}`", limit.name),
            format!("`{}`", limit.formula),
            limit.unit.into(),
            limit.class.words().into(),
            needs,
        ]
    });
    out.push_str(&table(&["limit", "keeps", "unit", "leaves", "not checked where"], rows));
    out.push_str(
        "\nConvex holds while the shaft's torque has no term of power zero in N: with motor Coulomb friction or a constant torque the \
         same limit goes to branch and bound. `safety` multiplies demanded torque and current, not heat.\n",
    );
    out
}

/// What keeps a limit from being checked: asked of the limits themselves, with a row that says nothing beyond
/// what it must, and with operating points without durations.
fn missing() -> Vec<(&'static str, &'static str)> {
    const BARE: &str = "b,q_axis,q_axis,1,,0.1,1e-5,,,,,,,,,,,,";
    const FULL: &str = "f,q_axis,q_axis,1,1e-3,0.1,1e-5,1,7,5,20,400,2,0.1,0.1,0.1,EUR,2026-11-01,1";
    const HEAD: &str =
        "id,kind,ratio,efficiency,inertia [kg*m^2],source,source_kind,average_torque [N*m],average_input_speed [rpm]\n";
    const GEARS: [&str; 2] = ["g,strain_wave,9,0.9,1e-6,s,derived,,\n", "g,strain_wave,9,0.9,1e-6,s,derived,1,1\n"];
    let mut found: Vec<(&'static str, &'static str)> = Vec::new();
    for ((row, duration), gear) in [(BARE, ", duration = \"1 s\""), (FULL, "")].into_iter().zip(GEARS) {
        let motors = format!(
            "id,terminals,current,resistance [ohm],inductance [H],torque_constant [N*m/A],rotor_inertia [kg*m^2],mass [kg],pole_pairs,\
             continuous_current [A],peak_current [A],max_winding_temperature [K],thermal_resistance_winding_housing [K/W],\
             outer_diameter [m],length [m],price,price_currency,price_date,lead_time [d],source,source_kind\n\
             {row},s,derived\n"
        );
        let robot = format!(
            "name = \"x\"\nbus = {{ voltage = \"48 V\" }}\n[[joint]]\nname = \"j\"\ngears = [\"*\"]\n\
             points = [ {{ torque = \"1 N*m\", speed = \"0 rad/s\"{duration} }} ]\n[joint.limits]\nactuator_mass = \"1 kg\"\nouter_diameter = \"1 m\"\naxial_length = \"1 m\"\n\
             reflected_inertia = \"1 kg*m^2\"\nwinding_temperature = \"110 degC\"\n\
             torque_bandwidth = {{ frequency = \"1 Hz\", amplitude = \"1 N*m\" }}\nshock_torque = \"1 N*m\"\nlife = \"1 h\"\nmax_backlash = \"1 deg\"\n\
             min_stiffness = \"1 N*m/rad\"\nmax_backdriving_torque = \"1 N*m\"\nprice = \"1 EUR\"\nlead_time = \"1 d\"\n[prices]\ncurrency = \"EUR\"\ndate = \"2026-11-01\"\n"
        );
        let sources =
            vec![Source::new("motors.csv", motors).into(), Source::new("gears.csv", format!("{HEAD}{gear}")).into()];
        let (Ok(catalog), Ok(robot)) =
            (Catalog::from_sources(sources), requirement::read_source(&Source::new("x.toml", robot).into()))
        else {
            continue;
        };
        let joint = &robot.joints[0];
        let load = Load::new(&joint.motion, joint.ripple());
        let Ok(candidate) =
            Mount::new(&robot, joint, &load, &catalog.motors[0]).with_gear(Some(&catalog.gears[0])).candidate()
        else {
            continue;
        };
        let unknown = |limit: &'static Limit| match limit.check(&candidate) {
            Check::Unknown(why) => Some((limit.name, why)),
            Check::AtRatio(judge) => match judge(&candidate, 1.0) {
                Verdict::Unknown(why) => Some((limit.name, why)),
                Verdict::Kept | Verdict::Assumed(_) => None,
            },
            _ => None,
        };
        for one in LIMITS.iter().filter_map(unknown) {
            if !found.contains(&one) {
                found.push(one);
            }
        }
    }
    found
}
