//! The ratio program solved in pieces: for a family of gears, and where standstill depends on the ratio.
//!
//! The one idea: between two rows of the family torque and voltage have the powers of N that a gear which does not change has,
//! so each piece is an ordinary program on its interval. What limits the gear there (torque, speed, mass, inertia) is
//! monotone in N² or a parabola in N, and cuts the interval in closed form. The best of the pieces is the optimum, the least of
//! their bounds is the bound, and the feasible ratios are the union of theirs.

use super::{
    Bind, Certificate, GAP_TOLERANCE, Infeasible, Limited, Optimum, Outcome, ROW_TOLERANCE, RatioProgram, Refusal,
    ShadowPrice, Unsolved, Window,
};
use crate::evaluate::Prepared;
use gearwise_model::actuator::limits::{Asked, Candidate, Check, LIMITS, Limit};
use gearwise_model::actuator::{Laurent, Load};
use gearwise_model::numerics::roots::parts_below;
use gearwise_model::numerics::work;
use gearwise_model::requirement::{GearMap, GearPiece, MapRow, Quantity};

/// Two ratios that differ by less than this share are neighbours.
const NEXT: f64 = 1e-9;
/// So far beyond an end of a window it is looked at what forbids it.
const BEYOND: f64 = 1e-6;

/// A number of a row.
type Number = fn(&MapRow) -> Option<f64>;

/// The limits whose demand or bound a family of gears changes with the ratio, with the number that does.
const OF_THE_GEAR: &[(&str, Number)] = &[
    ("gear_peak_torque", |row| row.peak_torque),
    ("gear_continuous_torque", |row| row.continuous_torque),
    ("gear_input_speed", |row| row.max_input_speed),
    ("actuator_mass", |row| row.mass),
    ("reflected_inertia", |row| row.inertia),
];

/// A candidate with those of its limits that count.
struct Group<'p> {
    candidate: &'p Candidate<'p>,
    limits: Vec<&'p Asked>,
}

impl Group<'_> {
    fn counts(&self, limit: &str) -> bool {
        self.limits.iter().any(|asked| asked.limit.name == limit)
    }
}

/// A part of a piece that the gear's own limits leave, with the limit that ends it; none where the piece ends itself.
#[derive(Clone)]
struct Span {
    from: f64,
    to: f64,
    low: Option<Bind>,
    high: Option<Bind>,
}

/// A window with its ends: whether they are no more than the ends of its piece.
struct Part {
    window: Window,
    open: [bool; 2],
}

/// What came of one span.
struct Solved {
    outcome: Outcome,
    span: Span,
    /// A number that the objective is nowhere below there, where that is proved.
    bound: Option<f64>,
    /// The piece that it is of.
    piece: (f64, f64),
}

/// How a program is cut into pieces.
struct Cut {
    /// Method of the certificate.
    method: &'static str,
    /// Name of the object that is divided.
    whole: &'static str,
}

const BY_GEAR: Cut = Cut { method: "pieces of the gear map", whole: "the gear map" };
const BY_STANDSTILL: Cut = Cut { method: "pieces of constant standstill", whole: "the range of ratios" };

/// Why nothing of a piece, or of a part of it, keeps all limits.
struct RuledOut {
    why: Infeasible,
    /// Whether that is said of the whole piece.
    whole: bool,
}

/// The candidates of a program, each with its limits; the first is that of the objective.
fn groups<'p>(program: &'p RatioProgram<'p>) -> Vec<Group<'p>> {
    let mut groups = vec![Group { candidate: &program.prepared.candidate, limits: Vec::new() }];
    for Limited { candidate, asked } in &program.limits {
        match groups.iter_mut().find(|group| std::ptr::eq(group.candidate, *candidate)) {
            Some(group) => group.limits.push(asked),
            None => groups.push(Group { candidate, limits: vec![asked] }),
        }
    }
    groups
}

/// Solves a program whose gear is one of a family.
pub(super) fn solve(program: &RatioProgram, map: &GearMap) -> Outcome {
    let (min, max) = program.range;
    if !map.covers(min) || !map.covers(max) {
        return Err(Refusal::NotSolved(Unsolved::OutsideMap));
    }
    let groups = groups(program);
    let made: Vec<Load>;
    let loads = match program.prepared.candidate.load.pieces() {
        known if known.len() == map.pieces().len() => known,
        _ => {
            let candidate = &program.prepared.candidate;
            made = map.pieces().iter().map(|piece| candidate.load.on_piece(piece, &candidate.gear)).collect();
            &made
        }
    };
    let (mut solved, mut ruled_out): (Vec<Solved>, Vec<RuledOut>) = Default::default();
    for (piece, load) in map.pieces().iter().zip(loads) {
        let last = std::ptr::eq(piece, &map.pieces()[map.pieces().len() - 1]);
        let first = std::ptr::eq(piece, &map.pieces()[0]);
        // What rounding made of the ends of the range belongs to the first and the last piece.
        let from = if first { min } else { piece.from().max(min) };
        let to = if last { max } else { piece.to().min(max) };
        if from > to {
            continue;
        }
        match spans(&groups, map, piece, (from, to)) {
            Ok(spans) => solved.extend(spans.into_iter().map(|span| {
                let (outcome, bound) = solve_span(program, &groups, &Piece::OfGears(map, piece, load), &span);
                Solved { outcome, span, bound, piece: (piece.from(), piece.to()) }
            })),
            Err(why) => ruled_out.push(why),
        }
    }
    combined(program, &groups, solved, ruled_out, &BY_GEAR)
}

/// Solves a program at ratios between which the degree changes to which slow samples are at standstill.
///
/// The degree falls as the ratio rises. Whatever the limits forbid with the degrees of the largest ratio they forbid, whatever they
/// allow with those of the smallest they allow. Where both come to the same that is the answer. Else pieces of constant degrees are
/// solved one by one where the two differ, and what is below and above them at once.
pub(super) fn solve_standing(program: &RatioProgram) -> Outcome {
    let groups = groups(program);
    let (min, max) = program.range;
    let changes = groups.iter().flat_map(|group| group.candidate.standing_changes((min, max)));
    let mut ends: Vec<f64> = changes.filter(|n| min < *n && *n < max).collect();
    ends.extend([min, max]);
    ends.sort_by(f64::total_cmp);
    ends.dedup_by(|b, a| *b <= *a * (1.0 + NEXT));
    if let [only] = ends[..] {
        ends.push(only);
    }
    let mut solved = Vec::new();
    // Spans, the last one first, each with why nothing is possible in it, where that is known with less standstill, and true where
    // standstill does not matter.
    let mut open: Vec<(usize, usize, Option<Infeasible>, bool)> = vec![(0, ends.len() - 1, None, false)];
    while let Some((first, last, ruled_out, is_alike)) = open.pop() {
        if let Some(why) = ruled_out.as_ref().filter(|_| work::is_spent()) {
            let span = Span { from: ends[first], to: ends[last], low: None, high: None };
            let outcome = Err(Refusal::Infeasible(why.clone()));
            solved.push(Solved { outcome, piece: (span.from, span.to), span, bound: Some(f64::INFINITY) });
            continue;
        }
        // Once the work is done, all that is left is one piece.
        let last = if work::is_spent() { ends.len() - 1 } else { last };
        let (from, to) = (ends[first], ends[last]);
        let span = Span { from, to, low: None, high: None };
        let at = |ratio: f64| solve_span(program, &groups, &Piece::StandingAt(ratio), &span);
        let (mut outcome, bound) = at(ends[last - 1]);
        if let Err(Refusal::Infeasible(Infeasible::Never { bind, ratio, .. })) = &outcome
            && last - first > 1
            && let Some(least) = least_of_pieces(program, &groups, &ends[first..=last], bind.limit, *ratio)
        {
            outcome = Err(Refusal::Infeasible(least));
        }
        if work::is_spent() && last - first > 1 {
            // A ratio that is feasible with the most standstill is feasible; the least standstill bounds the objective.
            let safe = at(from).0;
            let outcome = match (outcome, safe) {
                (Err(Refusal::Infeasible(why)), _) => Err(Refusal::Infeasible(why)),
                (_, Ok(safe)) => {
                    Ok(Optimum { certificate: Certificate::ended(f64::INFINITY, f64::NEG_INFINITY), ..safe })
                }
                _ => Err(Refusal::NotSolved(Unsolved::NothingRuledOut)),
            };
            solved.push(Solved { outcome, span, bound, piece: (from, to) });
            if last == ends.len() - 1 {
                break;
            }
            continue;
        }
        let is_settled = is_alike
            || last - first == 1
            || match &outcome {
                // Every ratio that is allowed is beyond the last change.
                Ok(optimum) => optimum.windows.iter().all(|window| window.min >= ends[last - 1]),
                Err(Refusal::Infeasible(why)) => !matches!(why, Infeasible::Nowhere { .. }),
                Err(_) => false,
            }
            || !program.limits.iter().any(|limited| limited.asked.depends_on_standing());
        let safe = (!is_settled).then(|| at(from).0);
        if safe.as_ref().is_none_or(|safe| comes_to_the_same(safe, &outcome)) {
            if first == 0 && last == ends.len() - 1 {
                return outcome;
            }
            solved.push(Solved { outcome, span, bound, piece: (from, to) });
            continue;
        }
        let (below, above) = match (&outcome, &safe) {
            (Ok(outcome), Some(Ok(safe))) => difference(&outcome.windows, &safe.windows),
            (Ok(outcome), _) => difference(&outcome.windows, &[]),
            _ => (from, to),
        };
        // The pieces in which they differ, and the others on both sides.
        let low = ends[first..last].partition_point(|end| *end <= below * (1.0 + NEXT)).max(1) - 1 + first;
        let high = (ends[first..=last].partition_point(|end| *end < above * (1.0 - NEXT)) + first).clamp(low + 1, last);
        let why = match outcome {
            Err(Refusal::Infeasible(why)) => Some(why),
            _ => None,
        };
        open.extend((high < last).then(|| (high, last, why.clone(), true)));
        open.extend((low..high).rev().map(|k| (k, k + 1, why.clone(), false)));
        open.extend((first < low).then_some((first, low, why, true)));
    }
    combined(program, &groups, solved, Vec::new(), &BY_STANDSTILL)
}

/// The report of a limit that no ratio keeps, of pieces each with its own degrees of standstill: by how much at best.
///
/// With the degrees of the last piece the demand is nowhere larger, and has one valley, at `valley`: from there on outwards no piece is
/// looked at that cannot be better than the best one.
fn least_of_pieces(
    program: &RatioProgram,
    groups: &[Group],
    ends: &[f64],
    limit: &str,
    valley: f64,
) -> Option<Infeasible> {
    let pieces = ends.len() - 1;
    let piece = |k: usize| {
        let range = (ends[k], ends[k + 1]);
        on_span(program, groups, &Piece::StandingAt(range.0), range, |own| own.never_of(limit))
    };
    let least_standing = Piece::StandingAt(ends[pieces - 1]);
    on_span(program, groups, &least_standing, (ends[0], ends[pieces]), |lower| {
        let middle = ends.partition_point(|end| *end <= valley).clamp(1, pieces) - 1;
        let mut best = piece(middle)?;
        let below = (0..middle).rev().map(|k| (k, ends[k + 1])).collect::<Vec<_>>();
        let above = (middle + 1..pieces).map(|k| (k, ends[k])).collect();
        for side in [above, below] {
            for (k, nearest) in side {
                if lower.demand_of(limit, nearest)? >= best.0 {
                    break;
                }
                best = piece(k).filter(|own| own.0 < best.0).unwrap_or(best);
            }
        }
        Some(best.1)
    })
}

/// True if two numbers differ by rounding alone.
fn near(x: f64, y: f64) -> bool {
    (x - y).abs() <= 1e-12 * x.abs().max(y.abs())
}

/// The ratios between which two lists of windows differ.
fn difference(a: &[Window], b: &[Window]) -> (f64, f64) {
    let ends = |windows: &[Window]| windows.iter().flat_map(|w| [w.min, w.max]).collect::<Vec<f64>>();
    let (a, b) = (ends(a), ends(b));
    let lone = |of: &[f64], other: &[f64]| -> Vec<f64> {
        of.iter().copied().filter(|end| !other.iter().any(|o| near(*end, *o))).collect()
    };
    let lone: Vec<f64> = [lone(&a, &b), lone(&b, &a)].concat();
    match lone.is_empty() {
        // The same windows, with another optimum.
        true => (0.0, f64::INFINITY),
        false => lone.into_iter().fold((f64::INFINITY, 0.0), |(low, high), end| (low.min(end), high.max(end))),
    }
}

/// True if two programs have the same feasible ratios and optimum.
fn comes_to_the_same(a: &Outcome, b: &Outcome) -> bool {
    match (a, b) {
        (Ok(a), Ok(b)) => {
            let pairs = a.windows.iter().zip(&b.windows);
            a.windows.len() == b.windows.len()
                && pairs.into_iter().all(|(a, b)| near(a.min, b.min) && near(a.max, b.max))
                && near(a.objective, b.objective)
                && near(a.ratio, b.ratio)
        }
        _ => false,
    }
}

/// The program with slow samples at standstill as at its largest ratio: nothing is possible that is not possible there.
pub(super) fn with_least_standing<T>(program: &RatioProgram, look: impl FnOnce(&RatioProgram) -> T) -> T {
    let (from, to) = program.range;
    on_span(program, &groups(program), &Piece::StandingAt(to), (from, to), look)
}

/// A piece of a program.
enum Piece<'p> {
    /// Between two rows of a family of gears, with the load there.
    OfGears(&'p GearMap, &'p GearPiece, &'p Load),
    /// From a ratio on, with slow samples at standstill as there.
    StandingAt(f64),
}

impl<'p> Piece<'p> {
    fn candidate(&self, of: &Candidate<'p>) -> Candidate<'p> {
        match *self {
            Piece::OfGears(_, piece, load) => of.on_piece(piece, load),
            Piece::StandingAt(ratio) => of.standing_at(ratio),
        }
    }

    /// True if a limit cuts the piece in closed form and is no part of the piece's own program.
    fn cuts(&self, limit: &str) -> bool {
        match self {
            Piece::OfGears(map, ..) => OF_THE_GEAR.iter().any(|(name, of)| *name == limit && map.says(of)),
            Piece::StandingAt(_) => false,
        }
    }
}

/// Looks at the program on a part of a piece.
fn on_span<'p, T>(
    program: &RatioProgram<'p>,
    groups: &[Group<'p>],
    piece: &Piece<'p>,
    range: (f64, f64),
    look: impl FnOnce(&RatioProgram) -> T,
) -> T {
    let prepared: Vec<Prepared> = groups
        .iter()
        .map(|group| {
            let mut own = Prepared::new(piece.candidate(group.candidate)).stopping(program.prepared.stop);
            let counts =
                |asked: &Asked| group.limits.iter().any(|a| a.limit.name == asked.limit.name && a.end == asked.end);
            own.asked.retain(|asked| !piece.cuts(asked.limit.name) && counts(asked));
            own
        })
        .collect();
    let limits = prepared
        .iter()
        .flat_map(|own| own.asked.iter().map(|asked| Limited { candidate: &own.candidate, asked }))
        .collect();
    look(&RatioProgram { prepared: &prepared[0], objective: program.objective, range, limits })
}

/// The program on a part of a piece, and a number that its objective is nowhere below.
fn solve_span<'p>(
    program: &RatioProgram<'p>,
    groups: &[Group<'p>],
    piece: &Piece<'p>,
    span: &Span,
) -> (Outcome, Option<f64>) {
    on_span(program, groups, piece, (span.from, span.to), |own| {
        let outcome = own.solve();
        let bound = match &outcome {
            Ok(Optimum { certificate: Certificate::Certified { lower_bound, .. }, .. }) => Some(*lower_bound),
            Err(Refusal::Infeasible(_)) => Some(f64::INFINITY),
            _ => own.lower_bound(),
        };
        (outcome, bound)
    })
}

/// The parts of a piece that the gear's own limits leave of an interval.
///
/// # Errors
/// What leaves none.
fn spans(groups: &[Group], map: &GearMap, piece: &GearPiece, (from, to): (f64, f64)) -> Result<Vec<Span>, RuledOut> {
    let mut spans = vec![Span { from, to, low: None, high: None }];
    for (name, _) in OF_THE_GEAR.iter().filter(|(_, of)| map.says(of)) {
        let Some(limit) = LIMITS.iter().find(|limit| limit.name == *name) else { continue };
        for group in groups.iter().filter(|group| group.counts(name)) {
            let Some(kept) = kept(group.candidate, limit, piece, (from, to)) else { continue };
            let Kept { parts, bind, nearest } = kept;
            if parts.is_empty() {
                return Err(RuledOut { why: nearest, whole: true });
            }
            let mut left = Vec::new();
            for span in &spans {
                for (a, b) in &parts {
                    let mut part = span.clone();
                    if *a > part.from {
                        (part.from, part.low) = (*a, Some(bind.clone()));
                    }
                    if *b < part.to {
                        (part.to, part.high) = (*b, Some(bind.clone()));
                    }
                    if part.from <= part.to {
                        left.push(part);
                    }
                }
            }
            if left.is_empty() {
                // Each of two limits leaves what the other forbids.
                return Err(RuledOut { why: nowhere(groups, (from * to).sqrt()).unwrap_or(nearest), whole: false });
            }
            spans = left;
        }
    }
    Ok(spans)
}

/// What a limit of the gear leaves of an interval.
struct Kept {
    /// The parts on which it is kept.
    parts: Vec<(f64, f64)>,
    /// The limit.
    bind: Bind,
    /// How near it comes to being kept.
    nearest: Infeasible,
}

/// Where a limit of the gear is kept on an interval of a piece, what it is, and how near it comes; `None` where it does not
/// count.
fn kept(candidate: &Candidate, limit: &'static Limit, piece: &GearPiece, (a, b): (f64, f64)) -> Option<Kept> {
    let at = |ratio: f64| {
        let here = Candidate { folded: true, ..candidate.with_gear(piece.gear(&candidate.gear, ratio), None) };
        match limit.check(&here) {
            Check::Asked(asked) => Some((asked, asked.raw_demand(&here, ratio))),
            _ => None,
        }
    };
    let [(asked, (raw, sample)), (other, (raw_other, _))] = [at(a)?, at(b)?];
    let (bound, bound_other) = (asked.raw_bound(), other.raw_bound());
    // Demand less bound: both are linear in N², but for a speed, which is linear in N.
    let line = |x: f64, y: f64| match b > a {
        true => (y - x) / (b * b - a * a),
        false => 0.0,
    };
    let difference = match limit.name {
        "gear_input_speed" => {
            let rise = line(bound, bound_other);
            Laurent::monomial(raw / a, 1) + Laurent::monomial(-rise, 2) + Laurent::constant(rise * a * a - bound)
        }
        _ => {
            let rise = line(raw - bound, raw_other - bound_other);
            Laurent::monomial(rise, 2) + Laurent::constant(raw - bound - rise * a * a)
        }
    };
    let slack = ROW_TOLERANCE * bound.abs().max(bound_other.abs());
    let parts = parts_below(&difference, slack, a, b);
    let share = |asked: &Asked, raw: f64| asked.natural(raw) / asked.bound;
    let (least, ratio, allowed) = match share(&asked, raw) <= share(&other, raw_other) {
        true => (share(&asked, raw), a, asked.bound),
        false => (share(&other, raw_other), b, other.bound),
    };
    let bind = Bind::of(limit.name, sample);
    let nearest = Infeasible::Never { bind: bind.clone(), least, allowed, ratio };
    Some(Kept { parts, bind, nearest })
}

/// The answer of all pieces.
fn combined(
    program: &RatioProgram,
    groups: &[Group],
    solved: Vec<Solved>,
    ruled_out: Vec<RuledOut>,
    cut: &Cut,
) -> Outcome {
    let best = solved.iter().filter_map(|s| Some((s, s.outcome.as_ref().ok()?))).min_by(|(_, a), (_, b)| {
        let loss = |o: &Optimum| program.prepared.at(o.ratio).loss;
        let of_mass = program.objective.sole() == Some(Quantity::Mass);
        let tie = || if of_mass { loss(a).total_cmp(&loss(b)) } else { std::cmp::Ordering::Equal };
        a.objective.total_cmp(&b.objective).then_with(tie)
    });
    let Some((of_best, best)) = best else { return Err(none(groups, solved, ruled_out)) };
    let value = best.objective;
    let clamp = |ratio: f64, span: &Span| ratio.clamp(span.from, span.to);
    let certificate = certificate(best, &solved, cut);
    let ends = program.range;
    let own = [
        of_best.span.low.is_none() && of_best.span.from <= ends.0,
        of_best.span.high.is_none() && of_best.span.to >= ends.1,
    ];
    // What is priced is a limit, or an end of the range; not that a piece ends.
    // Nothing is known beyond the ends of a named family, which nobody set.
    let is_named = program.prepared.candidate.joint.family_map().is_some();
    let is_priced = |price: &ShadowPrice| match price.limit {
        "ratio_min" | "ratio_max" if is_named => false,
        "ratio_min" => own[0],
        "ratio_max" => own[1],
        _ => true,
    };
    let mut windows = Vec::new();
    for Solved { outcome, span, .. } in &solved {
        let Ok(optimum) = outcome else { continue };
        for window in &optimum.windows {
            let mut part = Part { window: window.clone(), open: [false; 2] };
            part.window.min = clamp(window.min, span);
            part.window.max = clamp(window.max, span);
            if window.low.limit == "ratio_min" {
                part.open[0] = span.low.is_none() && span.from > ends.0;
                part.window.low = span.low.clone().unwrap_or_else(|| window.low.clone());
            }
            if window.high.limit == "ratio_max" {
                part.open[1] = span.high.is_none() && span.to < ends.1;
                part.window.high = span.high.clone().unwrap_or_else(|| window.high.clone());
            }
            windows.push(part);
        }
    }
    Ok(Optimum {
        ratio: clamp(best.ratio, &of_best.span),
        objective: value,
        windows: united(groups, windows),
        certificate,
        shadow_prices: best.shadow_prices.iter().filter(|price| is_priced(price)).cloned().collect(),
    })
}

/// The proof of the best: that no piece has anything below it.
fn certificate(best: &Optimum, solved: &[Solved], cut: &Cut) -> Certificate {
    let value = best.objective;
    let own_gap = match &best.certificate {
        Certificate::Certified { gap, .. } => *gap,
        _ if work::is_spent() => {
            let bound = solved.iter().map(|part| part.bound.unwrap_or(f64::NEG_INFINITY)).fold(f64::INFINITY, f64::min);
            let gap = ((value - bound) / value.abs()).max(0.0);
            return match gap <= GAP_TOLERANCE {
                true => Certificate::Certified { lower_bound: bound.min(value), gap, method: cut.method },
                false => Certificate::ended(gap, bound.min(value)),
            };
        }
        not => return not.clone(),
    };
    let mut bound = f64::INFINITY;
    for part in solved {
        let Some(own) = part.bound.filter(|bound| !bound.is_nan()) else {
            let [from, to] = [part.piece.0, part.piece.1].map(gearwise_model::words::number);
            return Certificate::NotCertified(format!("{} is not proved from {from} to {to}", cut.whole).into());
        };
        bound = bound.min(own);
    }
    let gap = match value == 0.0 {
        true => own_gap,
        false => own_gap.max((value - bound) / value.abs()),
    };
    if gap > GAP_TOLERANCE || (value == 0.0 && bound < 0.0 && own_gap > GAP_TOLERANCE) {
        return Certificate::NotCertified(format!("the bounds of the pieces of {} did not meet", cut.whole).into());
    }
    Certificate::Certified { lower_bound: bound.min(value), gap, method: cut.method }
}

/// Windows of neighbouring pieces that touch are one; where a window ends with its piece and the next one has none, what
/// forbids the ratios beyond is looked for.
fn united(groups: &[Group], mut parts: Vec<Part>) -> Vec<Window> {
    parts.sort_by(|a, b| a.window.min.total_cmp(&b.window.min));
    let mut united: Vec<Part> = Vec::new();
    for part in parts {
        match united.last_mut() {
            Some(before) if before.open[1] && part.open[0] && part.window.min <= before.window.max * (1.0 + NEXT) => {
                (before.window.max, before.window.high, before.open[1]) =
                    (part.window.max, part.window.high, part.open[1]);
            }
            _ => united.push(part),
        }
    }
    united
        .into_iter()
        .map(|Part { mut window, open }| {
            if open[0] {
                window.low = forbids(groups, window.min * (1.0 - BEYOND)).unwrap_or(window.low);
            }
            if open[1] {
                window.high = forbids(groups, window.max * (1.0 + BEYOND)).unwrap_or(window.high);
            }
            window
        })
        .collect()
}

/// The limit that is most exceeded at a ratio: demand over limit, the limit, and what it is.
fn worst(groups: &[Group], ratio: f64) -> Option<(f64, f64, Bind)> {
    let all = groups.iter().filter(|group| !group.limits.is_empty()).flat_map(|group| {
        group.candidate.at_ratio(ratio, |here| {
            let names: Vec<&str> = group.limits.iter().map(|asked| asked.limit.name).collect();
            let own = Prepared::new(*here);
            let asked = own.asked.iter().filter(|asked| names.contains(&asked.limit.name));
            let told = asked.map(|asked| {
                let (raw, sample) = asked.raw_demand(&own.candidate, ratio);
                let told = (asked.natural(raw) / asked.bound, asked.bound, Bind::of(asked.limit.name, sample));
                (asked.margin(&own.candidate, ratio, raw), told)
            });
            told.collect::<Vec<_>>()
        })
    });
    all.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, told)| told)
}

fn forbids(groups: &[Group], ratio: f64) -> Option<Bind> {
    worst(groups, ratio).map(|(.., bind)| bind)
}

/// The limit that is most exceeded at a ratio, as a reason.
fn nowhere(groups: &[Group], ratio: f64) -> Option<Infeasible> {
    worst(groups, ratio).map(|(least, allowed, bind)| Infeasible::Nowhere { bind, least, allowed, ratio })
}

/// A contradiction on a part of a piece: what ends that part is the gear's own limit.
fn ended_by(why: Infeasible, span: &Span) -> Infeasible {
    let named = |bind: Bind, range: &str, cut: &Option<Bind>| match cut {
        Some(cut) if bind.limit == range => cut.clone(),
        _ => bind,
    };
    match why {
        Infeasible::Contradiction { low, at_least, high, at_most } => Infeasible::Contradiction {
            low: named(low, "ratio_min", &span.low),
            at_least,
            high: named(high, "ratio_max", &span.high),
            at_most,
        },
        why => why,
    }
}

/// Why no piece has a ratio that keeps all limits.
fn none(groups: &[Group], solved: Vec<Solved>, mut ruled_out: Vec<RuledOut>) -> Refusal {
    for Solved { outcome, span, .. } in solved {
        match outcome {
            Err(Refusal::Infeasible(why)) => {
                let whole = span.low.is_none() && span.high.is_none();
                ruled_out.push(RuledOut { why: ended_by(why, &span), whole });
            }
            Err(other) => return other,
            Ok(_) => {}
        }
    }
    let is_never = |why: &Infeasible| matches!(why, Infeasible::Never { .. });
    if let [RuledOut { why, whole }] = &ruled_out[..]
        && (*whole || !is_never(why))
    {
        return Refusal::Infeasible(why.clone());
    }
    let never = |out: &RuledOut| match &out.why {
        Infeasible::Never { bind, least, .. } if out.whole => Some((bind.limit, *least)),
        _ => None,
    };
    let limits: Vec<Option<(&str, f64)>> = ruled_out.iter().map(never).collect();
    let same = limits.iter().all(|limit| limit.is_some() && limit.map(|l| l.0) == limits[0].map(|l| l.0));
    let least = |out: &RuledOut| never(out).map_or(f64::INFINITY, |(_, least)| least);
    if same {
        let nearest = ruled_out.into_iter().min_by(|a, b| least(a).total_cmp(&least(b)));
        return nearest.map_or(Refusal::NotSolved(Unsolved::NothingRuledOut), |out| Refusal::Infeasible(out.why));
    }
    // One limit here and another there: the ratio that comes nearest.
    let near = ruled_out.iter().filter_map(|out| match &out.why {
        Infeasible::Never { ratio, .. } | Infeasible::Nowhere { ratio, .. } => nowhere(groups, *ratio),
        Infeasible::Contradiction { at_least, at_most, .. } => nowhere(groups, (at_least * at_most).sqrt()),
    });
    let told = |why: &Infeasible| match why {
        Infeasible::Nowhere { least, .. } => *least,
        _ => f64::INFINITY,
    };
    let nearest = near.min_by(|a, b| told(a).total_cmp(&told(b)));
    nearest.map_or(Refusal::NotSolved(Unsolved::NothingRuledOut), Refusal::Infeasible)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn optimum(objective: f64, certificate: Certificate) -> Optimum {
        let bind = Bind::of("ratio_min", None);
        let window = Window { min: 2.0, max: 3.0, low: bind.clone(), high: bind };
        Optimum { ratio: 2.5, objective, windows: vec![window], certificate, shadow_prices: Vec::new() }
    }

    fn row(ratio: f64) -> MapRow {
        MapRow {
            ratio,
            mass: Some(1.0),
            inertia: None,
            driving: None,
            braking: None,
            no_load_torque: None,
            peak_torque: None,
            continuous_torque: None,
            max_input_speed: None,
        }
    }

    /// Proved is only what all pieces prove: one without a bound, or with one below the best, takes the proof away.
    #[test]
    fn one_piece_without_proof_is_none() {
        let map = GearMap::new(&[row(2.0), row(3.0), row(4.0)]).expect("a map");
        let proved = || Certificate::Certified { lower_bound: 5.0, gap: 0.0, method: "a test" };
        let best = optimum(5.0, proved());
        let solved = |k: usize, outcome: Outcome, bound: Option<f64>| {
            let piece = &map.pieces()[k];
            let (from, to) = (piece.from(), piece.to());
            Solved { outcome, bound, piece: (from, to), span: Span { from, to, low: None, high: None } }
        };
        let other = |bound: Option<f64>| {
            let not = Err(Refusal::NotSolved(Unsolved::NothingRuledOut));
            certificate(&best, &[solved(0, Ok(best.clone()), Some(5.0)), solved(1, not, bound)], &BY_GEAR)
        };
        assert!(matches!(other(None), Certificate::NotCertified(why) if why.to_string().contains("from 3 to 4")));
        assert!(matches!(other(Some(f64::NAN)), Certificate::NotCertified(_)));
        assert!(matches!(other(Some(4.9)), Certificate::NotCertified(_)));
        let certified = |certificate: Certificate| match certificate {
            Certificate::Certified { lower_bound, gap, .. } => Some((lower_bound, gap)),
            Certificate::NotCertified(_) => None,
        };
        assert_eq!(certified(other(Some(7.0))), Some((5.0, 0.0)));
        assert_eq!(certified(other(Some(f64::INFINITY))), Some((5.0, 0.0)));
        let (bound, gap) = certified(other(Some(5.0 - 2e-6))).expect("within the tolerance");
        assert!(bound < 5.0 && gap > 0.0 && gap <= GAP_TOLERANCE);
        // The best itself is not proved.
        let open = optimum(5.0, Certificate::NotCertified("why".into()));
        let all = [solved(0, Ok(open.clone()), Some(5.0))];
        assert_eq!(certificate(&open, &all, &BY_GEAR), Certificate::NotCertified("why".into()));
    }
}
