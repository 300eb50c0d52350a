//! A case of its seed: kind of bench, effects, size, band, and what is unfriendly about it.

use std::f64::consts::TAU;

use super::visible::{Has, Hidden, contributes, visible};
use crate::simulator::{Bench, Channel, Colour, Effect, Kind, Nature, Size, Stale, random::Random};

/// Kinds that are drawn, and how often.
const KINDS: [(Kind, usize); 7] = [
    (Kind::Dynamometer, 4),
    (Kind::Free, 3),
    (Kind::Drag, 2),
    (Kind::RandomTorque, 2),
    (Kind::Electrical, 2),
    (Kind::Servo, 2),
    (Kind::Stall, 1),
];

/// What may be unfriendly about a bench.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Unkind {
    Coloured,
    Blue,
    AntiAlias,
    Quantised,
    HeldLog,
    HeldChannel,
    Stale,
    WrongScale,
    WrongSign,
    WrongAmpere,
    WrongDeclared,
    HighOrder,
    Poor,
}

impl Unkind {
    /// All of them.
    pub const ALL: [Unkind; 13] = [
        Unkind::Coloured,
        Unkind::Blue,
        Unkind::AntiAlias,
        Unkind::Quantised,
        Unkind::HeldLog,
        Unkind::HeldChannel,
        Unkind::Stale,
        Unkind::WrongScale,
        Unkind::WrongSign,
        Unkind::WrongAmpere,
        Unkind::WrongDeclared,
        Unkind::HighOrder,
        Unkind::Poor,
    ];

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Unkind::Coloured => "coloured noise",
            Unkind::Blue => "blue noise",
            Unkind::AntiAlias => "anti-alias filter",
            Unkind::Quantised => "quantised target",
            Unkind::HeldLog => "held log",
            Unkind::HeldChannel => "held channel",
            Unkind::Stale => "stale stretch",
            Unkind::WrongScale => "velocity of wrong scale",
            Unkind::WrongSign => "velocity of wrong sign",
            Unkind::WrongAmpere => "wrong ampere convention",
            Unkind::WrongDeclared => "wrong K_T, J, R",
            Unkind::HighOrder => "orders above the band",
            Unkind::Poor => "one speed and one current",
        }
    }

    /// Whether it is an artefact that must be named.
    pub fn is_artefact(self) -> bool {
        matches!(
            self,
            Unkind::HeldChannel | Unkind::Stale | Unkind::WrongScale | Unkind::WrongSign | Unkind::WrongAmpere
        )
    }

    /// Whether the equation no longer holds with it: then no effect can be told.
    pub fn breaks_the_equation(self) -> bool {
        matches!(self, Unkind::WrongScale | Unkind::WrongSign | Unkind::WrongAmpere)
    }
}

/// A case.
#[derive(Debug, Clone)]
pub struct Case {
    pub seed: u64,
    pub bench: Bench,
    pub effects: Vec<Effect>,
    /// In times of the noise.
    pub size: f64,
    pub band: Option<f64>,
    pub unkind: Vec<Unkind>,
    pub has: Has,
}

impl Case {
    /// Kind of its bench.
    pub fn kind(&self) -> Kind {
        self.bench.kind
    }

    /// Whether each effect can be seen.
    pub fn visible(&self) -> Vec<Result<(), Hidden>> {
        self.effects.iter().map(|e| visible(*e, self.kind(), self.has)).collect()
    }

    /// Whether it has something.
    pub fn is(&self, unkind: Unkind) -> bool {
        self.unkind.contains(&unkind)
    }

    /// Its artefacts.
    pub fn artefacts(&self) -> impl Iterator<Item = Unkind> + '_ {
        self.unkind.iter().copied().filter(|u| u.is_artefact())
    }

    /// Names of its effects.
    pub fn names(&self) -> Vec<&'static str> {
        self.effects.iter().map(|e| e.name()).collect()
    }

    /// What else is true of a machine with its effects: flanks of a gap bend, and of what differs between directions a
    /// part is constant.
    pub fn companions(&self) -> impl Iterator<Item = &'static str> + '_ {
        self.effects.iter().filter_map(|e| match e {
            Effect::Backlash => Some("gear_compliance"),
            Effect::DirectionAsymmetry => Some("torque_offset"),
            _ => None,
        })
    }

    /// What it is, in one line.
    pub fn describe(&self) -> String {
        let unkind: Vec<&str> = self.unkind.iter().map(|u| u.name()).collect();
        format!(
            "{} {} {:?} size {} band {:?} [{}]",
            self.seed,
            self.kind().name(),
            self.effects,
            self.size,
            self.band,
            unkind.join(", ")
        )
    }
}

/// Whether a seed's case has no effect: a third of them.
pub fn is_clean(seed: u64) -> bool {
    seed.is_multiple_of(3)
}

/// The case of a seed.
pub fn draw(seed: u64) -> Case {
    let mut random = Random::new(seed, "case");
    let kind = kind(&mut random);
    // Clean logs of both sides are as usual as others.
    let has = Has { both_sides: random.chance(0.15), supply: random.chance(0.5) };
    let size = if random.chance(0.5) { 1.5 } else { 5.0 };
    let friendly = random.chance(0.5);
    let mut bench = Bench::new(kind, seed);
    sample(&mut bench, &mut random);
    let (mut effects, has) = if is_clean(seed) { (Vec::new(), has) } else { effects(kind, has, &mut random) };
    let mut unkind = if friendly { Vec::new() } else { unkindness(kind, &effects, &mut random) };
    order(&mut effects, &bench, unkind.contains(&Unkind::HighOrder), &mut random);
    show(&mut bench, has);
    excite(&mut bench, &effects, unkind.contains(&Unkind::HighOrder));
    for unkind in &unkind {
        spoil(&mut bench, *unkind, &mut random);
    }
    let nature = Nature::new(bench.machine.clone(), &effects, &mut Random::new(seed, "nature"));
    for effect in &effects {
        bench = if contributes(*effect, kind) {
            bench.with(*effect, Size::Noise(size))
        } else {
            bench.with(*effect, Size::Value(usual(&nature, *effect)))
        };
    }
    let bands: Vec<f64> = [10.0, 20.0, 40.0, 80.0].into_iter().filter(|b| *b < 0.4 * bench.rate).collect();
    let band = random.chance(0.4).then(|| bands[random.index(bands.len())]);
    unkind.sort_unstable();
    Case { seed, bench, effects, size, band, unkind, has }
}

fn kind(random: &mut Random) -> Kind {
    let total: usize = KINDS.iter().map(|(_, weight)| weight).sum();
    let mut at = random.index(total);
    for (kind, weight) in KINDS {
        if at < weight {
            return kind;
        }
        at -= weight;
    }
    unreachable!("the weights add up")
}

/// How long and how fast the logs are.
fn sample(bench: &mut Bench, random: &mut Random) {
    let rate = [200.0, 200.0, 250.0, 400.0, 500.0][random.index(5)];
    (bench.duration, bench.rate) = match bench.kind {
        Kind::Stall => (20.0, 100.0),
        Kind::Servo => (12.0, 200.0),
        _ => (random.within(12.0, 16.0).round(), rate),
    };
}

/// Mostly one effect that the bench can show, sometimes two, sometimes one that it cannot.
fn effects(kind: Kind, has: Has, random: &mut Random) -> (Vec<Effect>, Has) {
    let rigid = matches!(kind, Kind::RandomTorque | Kind::Servo | Kind::Electrical | Kind::Stall);
    let seen = |effect: Effect, has: Has| visible(effect, kind, has).is_ok();
    // What shows only with both sides or without the supply is drawn with them.
    let fit = |effect: Effect| match effect {
        Effect::GearCompliance | Effect::Backlash => Has { both_sides: true, ..has },
        Effect::SupplySag => Has { supply: false, ..has },
        _ => has,
    };
    let all = || {
        Effect::LIBRARY.into_iter().filter(move |e| !(rigid && matches!(e, Effect::GearCompliance | Effect::Backlash)))
    };
    let visible: Vec<Effect> = all().filter(|e| seen(*e, fit(*e))).collect();
    let hidden: Vec<Effect> = all().filter(|e| !seen(*e, has)).collect();
    if random.chance(0.2) && !hidden.is_empty() {
        return (vec![hidden[random.index(hidden.len())]], has);
    }
    let first = visible[random.index(visible.len())];
    let has = fit(first);
    if random.chance(0.25) {
        let second: Vec<Effect> =
            visible.into_iter().filter(|e| *e != first && seen(*e, has) && !excludes(*e, first)).collect();
        if !second.is_empty() {
            return (vec![first, second[random.index(second.len())]], has);
        }
    }
    (vec![first], has)
}

/// Whether two effects cannot be in one machine: an asymmetry is of the friction that the row declares.
fn excludes(a: Effect, b: Effect) -> bool {
    let of_row = |e: Effect| matches!(e, Effect::ViscousFriction | Effect::CoulombFriction);
    let asymmetry = |e: Effect| e == Effect::DirectionAsymmetry;
    (of_row(a) && asymmetry(b)) || (asymmetry(a) && of_row(b))
}

/// What is unfriendly about it: each at random where the bench can have it, at most one that breaks the equation.
fn unkindness(kind: Kind, effects: &[Effect], random: &mut Random) -> Vec<Unkind> {
    let velocity = !matches!(kind, Kind::Stall | Kind::Servo);
    let current = matches!(kind, Kind::Dynamometer | Kind::Free | Kind::Stall | Kind::Electrical);
    // What shows only where the motion changes would have no size.
    let steady = matches!(kind, Kind::Dynamometer | Kind::Free | Kind::Drag | Kind::Electrical)
        && !effects.iter().any(|e| {
            matches!(
                e,
                Effect::StribeckFriction
                    | Effect::DirectionAsymmetry
                    | Effect::GearCompliance
                    | Effect::Backlash
                    | Effect::LoadDependentFriction
            )
        });
    let ripples = effects
        .iter()
        .any(|e| matches!(e, Effect::Cogging { .. } | Effect::TorqueRipple { .. } | Effect::GearRipple { .. }));
    let mut found: Vec<Unkind> = Vec::new();
    for unkind in Unkind::ALL {
        let chance = match unkind {
            Unkind::WrongScale | Unkind::WrongSign if !velocity => 0.0,
            Unkind::WrongAmpere if !current => 0.0,
            // A servo has its own quantum; the position of a servo is not filtered.
            Unkind::Quantised | Unkind::AntiAlias if kind == Kind::Servo => 0.0,
            Unkind::HighOrder => f64::from(u8::from(ripples)) * 0.5,
            Unkind::WrongDeclared => 0.5,
            Unkind::Coloured | Unkind::AntiAlias | Unkind::Quantised => 0.25,
            Unkind::Blue => 0.15,
            Unkind::Poor => f64::from(u8::from(steady)) * 0.2,
            _ => 0.1,
        };
        let clashes = |other: &Unkind| match unkind {
            Unkind::Blue => *other == Unkind::Coloured,
            Unkind::HeldChannel => *other == Unkind::HeldLog,
            _ => unkind.breaks_the_equation() && other.breaks_the_equation(),
        };
        if random.chance(chance) && !found.iter().any(clashes) {
            found.push(unkind);
        }
    }
    found
}

/// Orders of what ripples: usual ones, or so high that they lie above the band.
fn order(effects: &mut [Effect], bench: &Bench, high: bool, random: &mut Random) {
    for effect in effects {
        match effect {
            Effect::Cogging { order } if high => *order = [36, 60, 84][random.index(3)],
            Effect::TorqueRipple { order } => *order = 6 * bench.machine.pole_pairs * if high { 2 } else { 1 },
            Effect::GearRipple { order } => {
                *order = if high { [68, 136, 204][random.index(3)] } else { [2, 3, 5][random.index(3)] };
            }
            _ => {}
        }
    }
}

/// Channels that are there or not.
fn show(bench: &mut Bench, has: Has) {
    if has.both_sides {
        bench.sensors.hidden.retain(|c| !matches!(c, Channel::OutputPosition | Channel::OutputVelocity));
    }
    if !has.supply {
        bench.sensors.hidden.push(Channel::Supply);
    }
}

/// What a lab would do to see them: slow turns for what ripples, slow passages for Stribeck friction.
fn excite(bench: &mut Bench, effects: &[Effect], high: bool) {
    // Share of half the sampling rate that the fastest tooth reaches.
    let share = if high { 0.8 } else { 0.25 };
    for effect in effects {
        let (order, side) = match effect {
            Effect::Cogging { order } | Effect::TorqueRipple { order } => (*order, 1.0),
            Effect::GearRipple { order } => (*order, bench.machine.ratio),
            _ => continue,
        };
        let fastest = share * 0.5 * bench.rate * TAU * side / f64::from(order);
        bench.excitation.speed = bench.excitation.speed.min(fastest / bench.machine.peak_speed);
    }
    for effect in effects {
        match effect {
            Effect::StribeckFriction => (bench.excitation.slow, bench.excitation.slow_level) = (0.5, 0.1),
            Effect::ViscousFriction => bench.declared.viscous = None,
            Effect::CoulombFriction => bench.declared.coulomb = None,
            _ => {}
        }
    }
}

/// Puts one of them into the bench.
fn spoil(bench: &mut Bench, unkind: Unkind, random: &mut Random) {
    let target = bench.kind.target_channel();
    let measured: Vec<Channel> = bench
        .kind
        .channels()
        .iter()
        .copied()
        .filter(|c| !bench.sensors.hidden.contains(c))
        .filter(|c| {
            matches!(c, Channel::Position | Channel::Velocity | Channel::Current | Channel::Torque | Channel::Voltage)
        })
        .collect();
    let ratio = bench.machine.ratio;
    let unfriendly = &mut bench.sensors.unfriendly;
    match unkind {
        Unkind::Coloured => {
            let (share, time) = (random.within(0.3, 0.9), random.log_within(0.005, 0.1));
            unfriendly.colour = Some(Colour { share, time, blue: false });
        }
        Unkind::Blue => {
            unfriendly.colour = Some(Colour { share: random.within(0.5, 0.9), time: 0.0, blue: true });
        }
        Unkind::AntiAlias => unfriendly.anti_alias = Some(random.within(0.2, 0.4) * bench.rate),
        Unkind::Quantised => unfriendly.quantum = Some(random.within(1.0, 3.0)),
        Unkind::HeldLog => unfriendly.held_log = Some(2 + random.index(14)),
        Unkind::HeldChannel => {
            let channel = measured[random.index(measured.len())];
            // A driver that gives a new value every 10 to 40 ms.
            let rows = (random.within(0.01, 0.04) * bench.rate).round().max(2.0) as usize;
            unfriendly.held_channel = Some((channel, rows));
        }
        Unkind::Stale => {
            let channel = if random.chance(0.5) { target } else { measured[random.index(measured.len())] };
            let log = random.index(bench.logs - 1);
            let (from, length) = (random.within(0.1, 0.85), random.log_within(0.06, 1.0));
            unfriendly.stale = Some(Stale { channel, log, from, length });
        }
        Unkind::WrongScale => {
            let turns = 60.0 / TAU;
            unfriendly.velocity_scale = Some([ratio, 1.0 / ratio, turns, 1.0 / turns][random.index(4)]);
        }
        Unkind::WrongSign => bench.sensors.wrong_sign = Some(Channel::Velocity),
        Unkind::WrongAmpere => {
            // Phase amplitude, and root mean square of a phase, of the power-invariant q axis.
            let amplitude = (2.0_f64 / 3.0).sqrt();
            unfriendly.ampere = Some([amplitude, amplitude / 2.0_f64.sqrt()][random.index(2)]);
        }
        Unkind::WrongDeclared => {
            bench.declared.torque_constant = random.within(0.85, 1.15);
            bench.declared.inertia = random.within(0.85, 1.15);
            bench.declared.resistance = random.within(0.85, 1.15);
        }
        Unkind::Poor => bench.excitation.poor = true,
        Unkind::HighOrder => {}
    }
}

/// An amplitude that a machine may well have.
fn usual(nature: &Nature, effect: Effect) -> f64 {
    let least = nature.smallest(effect);
    if least > 0.0 { least } else { 0.3 * nature.largest(effect) }
}
