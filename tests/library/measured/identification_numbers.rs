//! Every number that identification reports, a second time: benches of steady points whose equation stands on one
//! line, least squares from dense matrices, errors, shares and uncertainties from their definitions.
//!
//! Steady points need no filter, so that what a row of the regression is can be written down: the torque sensor
//! sees `τ = N K_T i − N (friction) + zero of its log + noise`.

use std::fmt::Write;
use std::fs;

use approx::assert_relative_eq;
use gearwise::measured::identify::{ArtefactKind, Options, Report, Verdict, identify};
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::cases::{are_all, few};

const RATIO: f64 = 6.0;
const DECLARED: f64 = 0.1;
const TRUE: f64 = 0.104;
const LOGS: usize = 4;
const SAMPLES: usize = 300;

/// A steady point of a log: motor speed \[rad/s\] and angle \[rad\], current \[A\], torque at the sensor \[N·m\].
#[derive(Clone, Copy)]
struct Point {
    log: usize,
    speed: f64,
    angle: f64,
    current: f64,
    torque: f64,
}

impl Point {
    fn sign(&self) -> f64 {
        self.speed.signum()
    }
}

/// Points of four logs, each with a zero of its own; `drag` is the torque at the motor that the declared constant
/// does not explain.
fn points(seed: u64, noise: f64, drag: impl Fn(&Point) -> f64) -> Vec<Point> {
    let (mut random, mut angles) = (Pcg64::seed_from_u64(seed), Pcg64::seed_from_u64(seed + 1000));
    let mut points = Vec::new();
    for log in 0..LOGS {
        for _ in 0..SAMPLES {
            // The slowest is fast enough for its direction to be known.
            let speed: f64 = random.random_range(1.0..100.0) * if random.random_bool(0.5) { 1.0 } else { -1.0 };
            let current = random.random_range(-5.0..5.0);
            let mut point = Point { log, speed, angle: angles.random_range(0.0..6.3), current, torque: 0.0 };
            let noise: f64 = (0..12).map(|_| random.random_range(-0.5..0.5)).sum::<f64>() * noise;
            point.torque = RATIO * (TRUE * current - drag(&point)) + [0.3, -0.2, 0.1, 0.5][log] + noise;
            points.push(point);
        }
    }
    points
}

/// Identification of points; the last log is held out. `row` are further columns of the motor's row.
fn identified(points: &[Point], columns: &str, row: &str) -> Report {
    with_angles(points, columns, row, false)
}

fn with_angles(points: &[Point], columns: &str, row: &str, angles: bool) -> Report {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    let motors = format!(
        "id,commutation,terminals,current,resistance [ohm],torque_constant [N*m/A],source,source_kind{columns}\n\
         m,brushless,q_axis,q_axis,0.5,{DECLARED},a sheet,datasheet{row}\n"
    );
    write("motors.csv", &motors);
    let mut bench = format!(
        "catalog = [\"motors.csv\"]\nactuator = {{ motor = \"m\", ratio = {RATIO} }}\nkind = \"steady_table\"\n[columns]\n\
         current = {{ name = \"i\", unit = \"A\", convention = \"q_axis\" }}\n\
         velocity = {{ name = \"w\", unit = \"rad/s\", side = \"motor\" }}\n\
         torque = {{ name = \"tau\", unit = \"N*m\", side = \"output\" }}\n{}",
        if angles { "position = { name = \"q\", unit = \"rad\", side = \"motor\" }\n" } else { "" }
    );
    for log in 0..LOGS {
        let mut text = String::from("i,w,q,tau\n");
        for p in points.iter().filter(|p| p.log == log) {
            writeln!(text, "{:?},{:?},{:?},{:?}", p.current, p.speed, p.angle, p.torque).unwrap();
        }
        write(&format!("log{log}.csv"), &text);
        let usage = if log + 1 == LOGS { "held_out" } else { "fit" };
        writeln!(bench, "[[log]]\nfile = \"log{log}.csv\"\nuse = \"{usage}\"").unwrap();
    }
    write("bench.toml", &bench);
    let bench = gearwise::measured::read::read(&folder.path().join("bench.toml")).unwrap_or_else(|e| panic!("{e:?}"));
    identify(&bench, &Options::default()).unwrap_or_else(|e| panic!("{e}")).remove(0)
}

/// A function of a point: a column of a regression.
type Function = Box<dyn Fn(&Point) -> f64>;

/// A regression by hand.
struct Hand<'a> {
    points: &'a [Point],
    /// Columns without the mean of each log.
    columns: Vec<DVector<f64>>,
    target: DVector<f64>,
    coefficients: DVector<f64>,
}

/// A column without the mean of each log: its zero is the log's.
fn centred(points: &[Point], f: impl Fn(&Point) -> f64) -> DVector<f64> {
    let mean = |log: usize| points.iter().filter(|p| p.log == log).map(&f).sum::<f64>() / SAMPLES as f64;
    let means: Vec<f64> = (0..LOGS).map(mean).collect();
    DVector::from_iterator(points.len(), points.iter().map(|p| f(p) - means[p.log]))
}

/// Least squares by an orthogonal decomposition, over the rows that are taken.
fn solved(columns: &[DVector<f64>], target: &DVector<f64>, take: &dyn Fn(usize) -> bool) -> DVector<f64> {
    let rows: Vec<usize> = (0..target.len()).filter(|k| take(*k)).collect();
    let matrix = DMatrix::from_fn(rows.len(), columns.len(), |i, j| columns[j][rows[i]]);
    let right = DVector::from_fn(rows.len(), |i, _| target[rows[i]]);
    matrix.svd(true, true).solve(&right, 1e-12).unwrap()
}

impl<'a> Hand<'a> {
    fn new(points: &'a [Point], functions: &[&dyn Fn(&Point) -> f64]) -> Hand<'a> {
        let columns: Vec<_> = functions.iter().map(|f| centred(points, f)).collect();
        let target = centred(points, |p| p.torque);
        let coefficients = solved(&columns, &target, &|k| points[k].log + 1 < LOGS);
        Hand { points, columns, target, coefficients }
    }

    fn residual(&self) -> DVector<f64> {
        self.columns.iter().zip(self.coefficients.iter()).fold(self.target.clone(), |left, (x, b)| left - x * *b)
    }

    /// Root mean square and variance accounted for \[%\] of a residual, on the logs to fit or on the other.
    fn error(&self, left: &DVector<f64>, fitting: bool) -> (f64, f64) {
        let take = |k: &usize| (self.points[*k].log + 1 < LOGS) == fitting;
        let rows: Vec<usize> = (0..left.len()).filter(take).collect();
        let sum = |v: &DVector<f64>| rows.iter().map(|k| v[*k] * v[*k]).sum::<f64>();
        ((sum(left) / rows.len() as f64).sqrt(), 100.0 * (1.0 - sum(left) / sum(&self.target)))
    }

    /// Block of each row: thirty blocks' length over all, evenly within a log.
    fn block(&self, row: usize) -> usize {
        let length = (LOGS * SAMPLES).div_ceil((LOGS * SAMPLES / 40).clamp(20, 60));
        let blocks = SAMPLES.div_ceil(length);
        self.points[row].log * blocks + row % SAMPLES / SAMPLES.div_ceil(blocks)
    }

    fn blocks_to_fit(&self) -> usize {
        self.block((LOGS - 1) * SAMPLES)
    }

    /// Root mean square of what is left out.
    fn left_out(&self) -> f64 {
        (self.left_out_blocks().iter().sum::<f64>() / ((LOGS - 1) * SAMPLES) as f64).sqrt()
    }

    /// Squared error of each block that is for fitting, left out with its fold of eight.
    fn left_out_blocks(&self) -> Vec<f64> {
        let fits = |k: usize| self.block(k) < self.blocks_to_fit();
        let mut squares = vec![0.0; self.blocks_to_fit()];
        for fold in 0..8 {
            let out = |k: usize| fits(k) && self.block(k) % 8 == fold;
            let beta = solved(&self.columns, &self.target, &|k| fits(k) && !out(k));
            for k in (0..self.target.len()).filter(|k| out(*k)) {
                let model: f64 = self.columns.iter().zip(beta.iter()).map(|(x, b)| x[k] * b).sum();
                squares[self.block(k)] += (self.target[k] - model).powi(2);
            }
        }
        squares
    }

    /// The share of the left-out squared error that another regression takes away, and how many standard errors
    /// between blocks that is.
    fn gain(&self, other: &Hand) -> (f64, f64) {
        let (before, after) = (self.left_out_blocks(), other.left_out_blocks());
        let gain = 1.0 - after.iter().sum::<f64>() / before.iter().sum::<f64>();
        let differences: Vec<f64> = before.iter().zip(&after).map(|(a, b)| a - b).collect();
        let n = differences.len() as f64;
        let mean = differences.iter().sum::<f64>() / n;
        let variance = differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (n - 1.0);
        (gain, mean / (variance / n).sqrt())
    }

    /// Covariance of coefficients from the scatter of the blocks' scores: `(XᵀX)⁻¹ Σ s sᵀ (XᵀX)⁻¹ n/(n − p − 1)`.
    fn covariance(&self, columns: &[DVector<f64>]) -> DMatrix<f64> {
        let (mut left, p, n) = (self.residual(), columns.len(), self.blocks_to_fit());
        // A shape that is not quite the best one leaves a part of its own slope: not an error of the others.
        let rest = solved(columns, &left, &|k| self.block(k) < n);
        columns.iter().zip(rest.iter()).for_each(|(column, b)| left -= column * *b);
        let mut normal = DMatrix::zeros(p, p);
        let mut scores = vec![DVector::zeros(p); n];
        for k in (0..left.len()).filter(|k| self.block(*k) < n) {
            let row = DVector::from_fn(p, |j, _| columns[j][k]);
            normal += &row * row.transpose();
            scores[self.block(k)] += row * left[k];
        }
        let inverse = normal.try_inverse().unwrap();
        let middle = scores.iter().fold(DMatrix::zeros(p, p), |sum, s| sum + s * s.transpose());
        &inverse * middle * &inverse * (n as f64 / (n as f64 - p as f64 - 1.0))
    }
}

fn same(value: f64, expected: f64, what: &str) {
    assert!((value - expected).abs() <= 1e-7 * expected.abs().max(1e-6), "{what}: {value}, by hand {expected}");
}

fn stage_is(report: &Report, name: &str, hand: &Hand, left: &DVector<f64>) {
    let stage = report.stages.iter().find(|s| s.step.name() == name).unwrap_or_else(|| panic!("no stage {name}"));
    let (fit, held) = (hand.error(left, true), hand.error(left, false));
    same(stage.fit, fit.0, name);
    same(stage.fit_vaf, fit.1, name);
    same(stage.held_out.unwrap(), held.0, name);
    same(stage.held_out_vaf.unwrap(), held.1, name);
}

fn current(p: &Point) -> f64 {
    RATIO * p.current
}

#[test]
fn two_kinds_of_friction_are_found_with_all_their_numbers() {
    let (b, c) = (1.5e-3, 0.05);
    let points = points(1, 0.02, |p| b * p.speed + c * p.sign());
    let report = identified(&points, "", "");
    assert_eq!(report.verdict, Verdict::Explained);
    assert_eq!((report.unit, report.band, report.samples), ("N*m", None, (LOGS * SAMPLES, LOGS * SAMPLES)));
    assert!(report.unexplained.is_empty() && report.remarks.is_empty());
    let mut found: Vec<&str> = report.effects.iter().map(|e| e.name()).collect();
    assert_eq!(report.stages.iter().map(|s| s.step.name()).collect::<Vec<_>>(), {
        let mut all = vec!["declared", "artefacts", "refit"];
        all.extend(&found);
        all.push("final");
        all
    });
    let (viscous, coulomb) = (|p: &Point| -RATIO * p.speed, |p: &Point| -RATIO * p.sign());
    let both: [&dyn Fn(&Point) -> f64; 2] = match found[0] {
        "viscous_friction" => [&viscous, &coulomb],
        _ => [&coulomb, &viscous],
    };
    // The story: as declared with the zero of each log in it, without the zeros, refitted, with one effect, with both.
    let last = Hand::new(&points, &[&current, both[0], both[1]]);
    let raw = DVector::from_iterator(points.len(), points.iter().map(|p| p.torque - DECLARED * current(p)));
    stage_is(&report, "declared", &last, &raw);
    let without_zeros = centred(&points, |p| p.torque - DECLARED * current(p));
    stage_is(&report, "artefacts", &last, &without_zeros);
    let refit = Hand::new(&points, &[&current]);
    stage_is(&report, "refit", &refit, &refit.residual());
    let one = Hand::new(&points, &[&current, both[0]]);
    stage_is(&report, found[0], &one, &one.residual());
    stage_is(&report, found[1], &last, &last.residual());
    stage_is(&report, "final", &last, &last.residual());
    same(report.evidence.left, last.left_out(), "left out");
    // Parameters with their uncertainty; the spread of the truth around them is what they say.
    let covariance = last.covariance(&last.columns);
    assert_eq!(report.parameters.len(), 1);
    let constant = &report.parameters[0];
    assert_eq!(
        (constant.name.as_str(), constant.declared, constant.unit),
        ("torque_constant", Some(DECLARED), "N*m/A")
    );
    same(constant.fitted, last.coefficients[0], "torque constant");
    same(constant.standard_error.unwrap(), covariance[(0, 0)].sqrt(), "its error");
    assert!((constant.fitted - TRUE).abs() < 4.0 * constant.standard_error.unwrap());
    for (j, effect) in report.effects.iter().enumerate() {
        let parameter = &effect.parameters[0];
        same(parameter.fitted, last.coefficients[j + 1], effect.name());
        same(effect.instances[0][0], last.coefficients[j + 1], effect.name());
        assert_eq!((effect.instances.len(), effect.instances[0].len(), effect.parameters.len()), (1, 1, 1));
        assert_eq!(parameter.declared, None);
        same(parameter.standard_error.unwrap(), covariance[(j + 1, j + 1)].sqrt(), effect.name());
        let truth = if effect.name() == "viscous_friction" { b } else { c };
        assert!((parameter.fitted - truth).abs() < 4.0 * parameter.standard_error.unwrap(), "{}", effect.name());
        // What it adds, over all rows; the held-out error without it and with it.
        let part = &last.columns[j + 1] * last.coefficients[j + 1];
        same(effect.size, part.norm() / (points.len() as f64).sqrt(), "size");
        let others: Vec<&dyn Fn(&Point) -> f64> = vec![&current, both[1 - j]];
        let without = Hand::new(&points, &others);
        same(effect.held_out_before.unwrap(), without.error(&without.residual(), false).0, "before");
        same(effect.held_out_after.unwrap(), last.error(&last.residual(), false).0, "after");
    }
    for i in 0..3 {
        for j in 0..3 {
            let size = (covariance[(i, i)] * covariance[(j, j)]).sqrt();
            assert!((report.covariance[i][j] - covariance[(i, j)]).abs() < 1e-7 * size);
        }
    }
    assert_eq!(report.fitted_names.len(), 3);
    // The zero of each log: what the model leaves of its mean.
    let zeros: Vec<_> = report.artefacts.iter().filter(|a| a.kind == ArtefactKind::Zero).collect();
    assert_eq!((zeros.len(), report.artefacts.len()), (LOGS, LOGS));
    for (log, zero) in zeros.iter().enumerate() {
        let of_log = points.iter().filter(|p| p.log == log);
        let functions: [&dyn Fn(&Point) -> f64; 3] = [&current, both[0], both[1]];
        let model = |p: &Point| functions.iter().zip(last.coefficients.iter()).map(|(f, b)| b * f(p)).sum::<f64>();
        same(zero.value, of_log.map(|p| p.torque - model(p)).sum::<f64>() / SAMPLES as f64, "zero");
        assert!((zero.value - [0.3, -0.2, 0.1, 0.5][log]).abs() < 0.02);
        assert_eq!((zero.unit, zero.channel.as_str()), ("N*m", format!("torque of log{log}.csv").as_str()));
    }
    // The pictures show every row before and after.
    let after = last.residual();
    for (k, p) in points.iter().enumerate() {
        assert!((report.pictures.after[k] - after[k]).abs() < 1e-9);
        assert!((report.pictures.before[k] - without_zeros[k]).abs() < 1e-9);
        assert_eq!((report.pictures.speed[k], report.pictures.log[k]), (p.speed, p.log));
        assert_relative_eq!(report.pictures.current[k], p.current, max_relative = 1e-12);
    }
    assert!(report.next_runs.iter().any(|r| r.starts_with("friction before or behind the gear")));
    found.sort_unstable();
    assert_eq!(found, ["coulomb_friction", "viscous_friction"]);
    assert!(report.refused.iter().all(|r| !found.contains(&r.name.as_str())));
}

#[test]
fn declared_friction_is_refitted_and_no_effect_is_missing() {
    let (b, c) = (1.5e-3, 0.05);
    let points = points(2, 0.02, |p| b * p.speed + c * p.sign());
    let report = identified(&points, ",viscous_friction [N*m*s/rad],coulomb_friction [N*m]", ",0.0013,0.06");
    // Steady points do not show the instrument's noise: that nothing at all is missing cannot be said.
    assert_eq!(report.verdict, Verdict::NoneOfThese);
    assert_eq!(report.evidence.noise.floor(), None);
    assert!(report.effects.is_empty() && report.unexplained.is_empty() && report.next_runs.is_empty());
    let (viscous, coulomb) = (|p: &Point| -RATIO * p.speed, |p: &Point| -RATIO * p.sign());
    let hand = Hand::new(&points, &[&current, &viscous, &coulomb]);
    let as_declared = |p: &Point| p.torque - DECLARED * current(p) - 0.0013 * viscous(p) - 0.06 * coulomb(p);
    stage_is(&report, "declared", &hand, &DVector::from_iterator(points.len(), points.iter().map(as_declared)));
    stage_is(&report, "artefacts", &hand, &centred(&points, as_declared));
    stage_is(&report, "refit", &hand, &hand.residual());
    stage_is(&report, "final", &hand, &hand.residual());
    let covariance = hand.covariance(&hand.columns);
    let expected = [
        ("torque_constant", DECLARED, "N*m/A"),
        ("viscous_friction.coefficient", 0.0013, "N*m*s/rad"),
        ("coulomb_friction.torque", 0.06, "N*m"),
    ];
    assert_eq!(report.parameters.len(), expected.len());
    for (j, (parameter, (name, declared, unit))) in report.parameters.iter().zip(expected).enumerate() {
        assert_eq!((parameter.name.as_str(), parameter.declared), (name, Some(declared)));
        assert_eq!(parameter.unit, unit);
        same(parameter.fitted, hand.coefficients[j], name);
        same(parameter.standard_error.unwrap(), covariance[(j, j)].sqrt(), name);
    }
    assert_eq!(report.fitted_names, expected.map(|e| e.0));
    // The zeros are what is left with the declared effects in.
    for (log, zero) in report.artefacts.iter().enumerate() {
        let of_log = points.iter().filter(|p| p.log == log);
        let beta = &hand.coefficients;
        let left = of_log.map(|p| p.torque - beta[0] * current(p) - beta[1] * viscous(p) - beta[2] * coulomb(p));
        same(zero.value, left.sum::<f64>() / SAMPLES as f64, "zero");
    }
}

/// A drag that flattens has a shape parameter, whose uncertainty comes with the others'.
#[test]
fn a_shape_parameter_has_its_uncertainty() {
    let (most, knee) = (0.08, 40.0);
    let drag = |w: f64, knee: f64| 2.0 / (w / knee + knee / w);
    let points = points(3, 0.01, |p| most * drag(p.speed, knee));
    let report = identified(&points, "", "");
    assert_eq!(report.effects.iter().map(|e| e.name()).collect::<Vec<_>>(), ["eddy_drag"]);
    assert_eq!(report.verdict, Verdict::Explained);
    let effect = &report.effects[0];
    let [amplitude, speed] = [effect.instances[0][0], effect.instances[0][1]];
    let basis = |p: &Point| -RATIO * drag(p.speed, speed);
    let hand = Hand::new(&points, &[&current, &basis]);
    same(amplitude, hand.coefficients[1], "amplitude");
    // The shape that was found leaves the least error.
    for other in [0.99 * speed, 1.01 * speed] {
        let worse = |p: &Point| -RATIO * drag(p.speed, other);
        let worse = Hand::new(&points, &[&current, &worse]);
        assert!(worse.error(&worse.residual(), true).0 > hand.error(&hand.residual(), true).0);
    }
    // d/dω_k of 2/(ω/ω_k + ω_k/ω) = −2 (1/ω − ω/ω_k²)/(…)², times the amplitude.
    let slope = |p: &Point| {
        let w = p.speed;
        RATIO * amplitude * 2.0 * (1.0 / w - w / (speed * speed)) / (w / speed + speed / w).powi(2)
    };
    let columns = [hand.columns[0].clone(), hand.columns[1].clone(), centred(&points, slope)];
    let covariance = hand.covariance(&columns);
    let errors: Vec<f64> = effect.parameters.iter().map(|p| p.standard_error.unwrap()).collect();
    assert_eq!(effect.parameters.iter().map(|p| p.name.as_str()).collect::<Vec<_>>(), ["torque", "speed"]);
    for (error, j) in [(report.parameters[0].standard_error.unwrap(), 0), (errors[0], 1), (errors[1], 2)] {
        assert_relative_eq!(error, covariance[(j, j)].sqrt(), max_relative = 1e-5);
    }
    assert!((speed - knee).abs() < 4.0 * errors[1] && (amplitude - most).abs() < 4.0 * errors[0]);
}

/// What no effect of the library is like: torque that waves with speed.
#[test]
fn structure_without_a_name_is_told_with_its_share() {
    let wave = |p: &Point| 0.02 * (p.speed.abs() / 12.0).cos();
    let points = points(4, 0.02, wave);
    let report = identified(&points, "", "");
    assert!(report.effects.is_empty(), "{:?}", report.effects);
    assert_eq!(report.verdict, Verdict::UnexplainedStructure);
    let hand = Hand::new(&points, &[&current]);
    let free = Hand::new(&points, &references(&free_of(&points, |p| p.speed)));
    let (share, sure) = hand.gain(&free);
    assert!(share > 0.08 && sure > 3.0);
    let first = &report.unexplained[0];
    assert_eq!(first.depends_on.name(), "speed");
    let told = format!("by {:.0} %", 100.0 * (1.0 - (1.0 - share).sqrt()));
    assert!(first.detail.ends_with(&told), "{} {told}", first.detail);
    same(report.evidence.left, hand.left_out(), "left out");
}

/// The current, a free function of a variable (piecewise linear over nine quantiles) and, for speed, the direction.
fn free_of(points: &[Point], of: fn(&Point) -> f64) -> Vec<Function> {
    let mut sorted: Vec<f64> = points.iter().map(of).collect();
    sorted.sort_by(f64::total_cmp);
    let knot = |k: usize| sorted[((sorted.len() - 1) as f64 * k as f64 / 8.0).round() as usize];
    let knots: Vec<f64> = (0..9).map(knot).collect();
    let mut functions: Vec<Function> = vec![Box::new(current)];
    for k in 0..9 {
        let (knots, middle) = (knots.clone(), knots[k]);
        functions.push(Box::new(move |p| {
            let x = of(p);
            match (x <= middle, k) {
                (true, 0) | (false, 8) => 1.0,
                (true, _) => ((x - knots[k - 1]) / (middle - knots[k - 1])).max(0.0),
                (false, _) => ((knots[k + 1] - x) / (knots[k + 1] - middle)).max(0.0),
            }
        }));
    }
    functions
}

fn references(functions: &[Function]) -> Vec<&dyn Fn(&Point) -> f64> {
    functions.iter().map(AsRef::as_ref).collect()
}

/// Structure is told from a share of 8 % of the left-out squared error on, beyond three standard errors.
#[test]
fn structure_is_told_from_eight_percent_on() {
    let (mut told, mut silent) = (0, 0);
    for seed in 40..70 {
        let size = 6e-4 + 7e-5 * (seed - 40) as f64;
        let points = points(seed, 0.02, |p| size * (p.speed.abs() / 12.0).cos());
        let report = identified(&points, "", "");
        if !report.effects.is_empty() {
            continue;
        }
        let hand = Hand::new(&points, &[&current]);
        for (name, of) in [("speed", (|p: &Point| p.speed) as fn(&Point) -> f64), ("current", |p: &Point| p.current)] {
            let (share, sure) = hand.gain(&Hand::new(&points, &references(&free_of(&points, of))));
            let said = report.unexplained.iter().any(|u| u.depends_on.name() == name);
            assert_eq!(said, share > 0.08 && sure > 3.0, "{seed} {name}: {share} {sure}");
            if said {
                told += 1;
            } else if share > 0.0 && name == "speed" {
                silent += 1;
            }
        }
        same(report.evidence.left, hand.left_out(), "left out");
        assert_eq!(report.verdict == Verdict::UnexplainedStructure, !report.unexplained.is_empty());
    }
    assert!(told > 5 && silent > 5, "{told} {silent}");
}

/// A name is given from 6 % of the left-out squared error on (3 % of the error), beyond 2.5 standard errors; below
/// that the refusal says how much it would have been.
#[test]
fn an_effect_is_named_from_three_percent_on() {
    let (mut named, mut refused) = (0, 0);
    for seed in 80..120 {
        let c = 1e-4 * (seed - 80) as f64 * 0.45;
        let points = points(seed, 0.02, |p| c * p.sign());
        let report = identified(&points, "", "");
        let coulomb = |p: &Point| -RATIO * p.sign();
        let (plain, with) = (Hand::new(&points, &[&current]), Hand::new(&points, &[&current, &coulomb]));
        let (gain, sure) = plain.gain(&with);
        let found = report.effects.iter().any(|e| e.name() == "coulomb_friction");
        let refusal = report.refused.iter().find(|r| r.name == "coulomb_friction");
        assert_eq!(found, refusal.is_none());
        let percent = 100.0 * (1.0 - (1.0 - gain).sqrt());
        if !report.effects.is_empty() && !found {
            // Another name was given by chance: what is said of this one is said beside it.
            continue;
        }
        if gain < 0.04 {
            assert!(!found, "{seed}: {gain} {sure}");
            let reason = &refusal.unwrap().reason;
            if percent < 0.05 {
                assert_eq!(reason, "it would not lower the left-out error");
            } else {
                assert_eq!(reason, &format!("it would lower the left-out error by {percent:.1} %, less than 2 %"));
            }
            refused += 1;
        } else if sure < 2.5 {
            let told = format!("scatter between blocks ({sure:.1} standard errors)");
            assert!(!found && refusal.unwrap().reason.ends_with(&told));
        } else if found {
            named += 1;
            assert_eq!(report.verdict, Verdict::Explained);
        }
    }
    assert!(named > 5 && refused > 10, "{named} {refused}");
}

/// Cogging of two orders is one effect with two instances, each with its amplitudes and their uncertainty.
#[test]
fn cogging_of_two_orders_is_found_with_its_numbers() {
    let (six, twelve) = (|p: &Point| 6.0 * p.angle, |p: &Point| 12.0 * p.angle);
    let points = points(5, 0.02, |p| 0.012 * (six(p) - 0.4).cos() + 0.03 * (twelve(p) + 0.7).cos());
    let report = with_angles(&points, "", "", true);
    assert_eq!((report.verdict, report.effects.len()), (Verdict::Explained, 1));
    let effect = &report.effects[0];
    assert_eq!((effect.name(), effect.instances.len()), ("cogging", 2));
    let steps: Vec<String> = report.stages.iter().map(|s| s.step.name()).collect();
    assert_eq!(steps, ["declared", "artefacts", "refit", "cogging order 12", "cogging order 6", "final"]);
    // The stronger order first; a cosine and a sine each.
    let functions: [Function; 4] = [
        Box::new(move |p| -RATIO * twelve(p).cos()),
        Box::new(move |p| -RATIO * twelve(p).sin()),
        Box::new(move |p| -RATIO * six(p).cos()),
        Box::new(move |p| -RATIO * six(p).sin()),
    ];
    let hand = Hand::new(&points, &[&current, &functions[0], &functions[1], &functions[2], &functions[3]]);
    stage_is(&report, "final", &hand, &hand.residual());
    let covariance = hand.covariance(&hand.columns);
    let names = ["12.cosine", "12.sine", "6.cosine", "6.sine"];
    // (the order itself is a parameter, too, without an error)
    let amplitudes: Vec<_> = effect.parameters.iter().filter(|p| names.contains(&p.name.as_str())).collect();
    for (j, (parameter, name)) in amplitudes.iter().zip(names).enumerate() {
        assert_eq!(parameter.name, name);
        same(parameter.fitted, hand.coefficients[j + 1], name);
        same(parameter.standard_error.unwrap(), covariance[(j + 1, j + 1)].sqrt(), name);
    }
    assert_eq!(amplitudes.len(), 4);
    for (instance, (first, order)) in effect.instances.iter().zip([(1, 12.0), (3, 6.0)]) {
        same(instance[0], hand.coefficients[first], "cosine");
        same(instance[1], hand.coefficients[first + 1], "sine");
        assert_eq!(instance[2], order);
    }
    assert!((effect.instances[0][0].hypot(effect.instances[0][1]) - 0.03).abs() < 1e-3);
    // Orders add up in their squares, and are taken out together.
    let part = |j: usize| &hand.columns[j] * hand.coefficients[j];
    let sizes = [part(1) + part(2), part(3) + part(4)].map(|v| v.norm() / (points.len() as f64).sqrt());
    same(effect.size, sizes[0].hypot(sizes[1]), "size");
    let without = Hand::new(&points, &[&current]);
    same(effect.held_out_before.unwrap(), without.error(&without.residual(), false).0, "before");
    same(effect.held_out_after.unwrap(), hand.error(&hand.residual(), false).0, "after");
    // Angles are unwrapped from log to log's end: the same up to whole turns.
    for (angle, p) in report.pictures.angle.iter().zip(&points) {
        let turns = (angle - p.angle) / std::f64::consts::TAU;
        assert!((turns - turns.round()).abs() < 1e-9);
    }
    // What the orders stand for is not said a second time of the position.
    assert!(report.unexplained.is_empty() && report.refused.iter().all(|r| r.name != "cogging"));
}

/// Iron that saturates: torque falls short of `K_T i` by `k (i − i_s tanh(i/i_s))`.
#[test]
fn saturation_is_found_with_its_numbers() {
    let short = |i: f64, at: f64| i - at * (i / at).tanh();
    let points = points(6, 0.01, |p| TRUE * short(p.current, 4.0));
    let report = identified(&points, "", "");
    assert_eq!(report.effects.iter().map(|e| e.name()).collect::<Vec<_>>(), ["torque_constant_saturation"]);
    let effect = &report.effects[0];
    let [slope, at] = [effect.instances[0][0], effect.instances[0][1]];
    let basis = |p: &Point| -RATIO * short(p.current, at);
    let hand = Hand::new(&points, &[&current, &basis]);
    let covariance = hand.covariance(&hand.columns);
    same(report.parameters[0].fitted, hand.coefficients[0], "torque constant");
    same(slope, hand.coefficients[1], "slope");
    let error = covariance[(1, 1)].sqrt();
    let of = |k: usize| (effect.parameters[k].fitted, effect.parameters[k].standard_error.unwrap());
    assert_eq!(effect.parameters.iter().map(|p| p.name.as_str()).collect::<Vec<_>>(), ["slope", "current"]);
    same(of(0).1, error, "error of the slope");
    // Where saturation is weak only k/i_s² shows: half the relative error.
    same(of(1).1, 0.5 * at * error / slope, "error of the current");
    assert!((of(1).0 / 4.0 - 1.0).abs() < 0.1 && (slope / hand.coefficients[0] - 1.0).abs() < 0.05, "{slope} {at}");
}

/// A sensor that was mounted the wrong way round, and one whose gain was set wrong, are seen in one log each.
#[test]
fn a_wrong_sign_and_a_wrong_gain_are_artefacts_of_their_logs() {
    let plain = points(7, 0.01, |_| 0.0);
    let factors = [1.0, -1.0, 1.4, 1.0];
    let spoilt: Vec<Point> = plain.iter().map(|p| Point { torque: p.torque * factors[p.log], ..*p }).collect();
    let report = identified(&spoilt, "", "");
    assert_eq!(report.verdict, Verdict::NoneOfThese);
    let list: Vec<(&str, &str, f64)> = report
        .artefacts
        .iter()
        .filter(|a| a.kind != ArtefactKind::Zero)
        .map(|a| (a.kind.name(), a.channel.as_str(), a.value))
        .collect();
    assert_eq!(list.len(), 2, "{list:?}");
    assert_eq!((list[0].0, list[0].1, list[0].2), ("sign", "torque of log1.csv", -1.0));
    assert_eq!((list[1].0, list[1].1), ("gain", "torque of log2.csv"));
    assert!((list[1].2 - 1.4).abs() < 0.01, "{}", list[1].2);
    // With both mended the logs say what the plain ones say.
    let (mended, unspoilt) = (&report.parameters[0], &identified(&plain, "", "").parameters[0]);
    assert!((mended.fitted / unspoilt.fitted - 1.0).abs() < 2e-3, "{} {}", mended.fitted, unspoilt.fitted);
    let error = |stage: usize| report.stages[stage].fit;
    assert!(error(0) > 20.0 * error(1), "{} {}", error(0), error(1));
}

#[test]
fn the_usual_gain_is_that_of_most_logs() {
    use gearwise::measured::identify::artefacts::usual_gains;
    let tight = 1e-3;
    let gains = |slopes: &[f64], declared: Option<f64>| {
        usual_gains(&slopes.iter().map(|s| (*s, tight)).collect::<Vec<_>>(), declared)
    };
    assert_eq!(gains(&[], None), [0.0; 0]);
    // One log: its sign can be wrong, its size is the constant itself.
    assert_eq!(gains(&[3.0], Some(1.0)), [1.0]);
    assert_eq!(gains(&[-3.0], Some(1.0)), [-1.0]);
    // Of two the one nearer (by factor) to what is declared is right; without that neither is wrong.
    assert_eq!(gains(&[1.0, 2.0], None), [1.0, 1.0]);
    assert_eq!(gains(&[1.0, 2.0], Some(1.3)), [1.0, 0.5]);
    assert_eq!(gains(&[1.0, 2.0], Some(1.5)), [2.0, 1.0]);
    assert_eq!(gains(&[2.0, -1.0], Some(1.5)), [1.0, -2.0]);
    // Of three the middle one. Up to 12 % is scatter, on either side.
    assert_eq!(gains(&[1.0, 2.0, 1.0], None), [1.0, 0.5, 1.0]);
    assert_eq!(gains(&[1.0, 1.119, 0.881], None), [1.0, 1.0, 1.0]);
    assert_eq!(gains(&[1.0, 1.121, 0.99], None), [1.0, 1.0 / 1.121, 1.0]);
    assert_eq!(gains(&[1.0, 0.879, 1.01], None), [1.0, 1.0 / 0.879, 1.0]);
    // A log that says little is left alone: six standard errors from the others.
    assert_eq!(usual_gains(&[(1.0, 0.01), (1.5, 0.09), (1.01, 0.01)], None), [1.0, 1.0, 1.0]);
    let mended = usual_gains(&[(1.0, 0.01), (1.5, 0.08), (1.01, 0.01)], None);
    assert_relative_eq!(mended.as_slice(), [1.0, 1.01 / 1.5, 1.0].as_slice(), max_relative = 1e-12);
    // Where many logs scatter, more is scatter: three times the spread, which is 1.48 medians of what they differ.
    let wide = [0.9, 0.95, 1.0, 1.05, 1.1];
    assert_eq!(gains(&wide, None), [1.0; 5]);
    assert_eq!(gains(&[0.9, 0.95, 1.0, 1.05, 1.2], None), [1.0; 5]);
    assert_eq!(gains(&[0.9, 0.95, 1.0, 1.05, 1.221], None), [1.0; 5]);
    assert_eq!(gains(&[0.9, 0.95, 1.0, 1.05, 1.223], None), [1.0, 1.0, 1.0, 1.0, 1.0 / 1.223]);
}

/// Logs over time, a kilosample a second for four seconds: `at(log, t)` gives what stands in the columns of current,
/// speed and torque; the noises of speed and torque come on top.
fn over_time(band: Option<f64>, at: impl Fn(usize, f64) -> [f64; 3]) -> Report {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write(
        "motors.csv",
        &format!(
            "id,terminals,current,resistance [ohm],torque_constant [N*m/A],source,source_kind\n\
             m,q_axis,q_axis,0.5,{DECLARED},-,derived\n"
        ),
    );
    let mut bench = format!(
        "catalog = [\"motors.csv\"]\nactuator = {{ motor = \"m\", ratio = {RATIO} }}\nkind = \"dynamometer\"\n[columns]\n\
         time = {{ name = \"t\", unit = \"s\" }}\ncurrent = {{ name = \"i\", unit = \"A\", convention = \"q_axis\" }}\n\
         velocity = {{ name = \"w\", unit = \"rad/s\", side = \"motor\" }}\n\
         torque = {{ name = \"tau\", unit = \"N*m\", side = \"output\" }}\n"
    );
    let mut random = Pcg64::seed_from_u64(9);
    for log in 0..LOGS {
        let mut text = String::from("t,i,w,tau\n");
        for k in 0..4000 {
            let t = f64::from(k) * 1e-3;
            let [current, speed, torque] = at(log, t);
            // An encoder's noise: what is smoother than any encoder has a line wherever one looks.
            let speed = speed + random.random_range(-0.3..0.3);
            let noise: f64 = (0..12).map(|_| random.random_range(-0.5..0.5)).sum::<f64>() * 0.02;
            writeln!(text, "{t:?},{current:?},{speed:?},{:?}", torque + noise).unwrap();
        }
        write(&format!("log{log}.csv"), &text);
        let usage = if log + 1 == LOGS { "held_out" } else { "fit" };
        writeln!(bench, "[[log]]\nfile = \"log{log}.csv\"\nuse = \"{usage}\"").unwrap();
    }
    write("bench.toml", &bench);
    let bench = gearwise::measured::read::read(&folder.path().join("bench.toml")).unwrap_or_else(|e| panic!("{e:?}"));
    identify(&bench, &Options { band }).unwrap_or_else(|e| panic!("{e}")).remove(0)
}

/// A random number between −1 and 1 for each millisecond of each log.
fn wild(log: usize, t: f64) -> f64 {
    Pcg64::seed_from_u64(1_000_000 * log as u64 + (1e3 * t).round() as u64).random_range(-1.0..1.0)
}

/// A random current and a speed that sweeps; `hum` comes on top of the torque, and a line of 31 Hz on the current.
fn humming(hum: impl Fn(usize, f64) -> f64, line: f64) -> Report {
    over_time(Some(60.0), |log, t| {
        let line = line * (std::f64::consts::TAU * 31.0 * t + log as f64).sin();
        let current = 3.0 * wild(log, t) + line;
        [current, 60.0 + 30.0 * (1.3 * t + log as f64).sin(), RATIO * TRUE * current + hum(log, t)]
    })
}

/// A sensor that is late, or early, is put right by as much, fractions of a sample and all. (A late speed is
/// not told from inertia where friction is viscous: `b ω(t − δ) = b ω − b δ α`.)
#[test]
fn a_late_sensor_is_put_right() {
    use std::f64::consts::TAU;
    for late in few(2, [0.0025, -0.0015, 0.0, 0.011]) {
        let report = over_time(None, |log, t| {
            let current = |t: f64| {
                let phase = log as f64;
                2.0 * (TAU * 3.1 * t + phase).sin() + 1.5 * (TAU * 7.3 * t).cos() + (TAU * 13.7 * t + 2.0 * phase).sin()
            };
            let speed = |t: f64| 40.0 * (TAU * 2.3 * t + log as f64).sin() + 25.0 * (TAU * 5.9 * t).cos() + 30.0;
            let torque = |t: f64| RATIO * (TRUE * current(t) - 2e-3 * speed(t));
            [current(t), speed(t), torque(t - late)]
        });
        let lag = report.artefacts.iter().find(|a| a.kind == ArtefactKind::Lag && a.channel == "torque");
        let found = lag.map_or(0.0, |a| a.value);
        assert!((found - late).abs() < 2.5e-4, "{found} of {late}");
        assert!(lag.is_none_or(|a| a.unit == "s"));
        assert_eq!(report.effects.iter().map(|e| e.name()).collect::<Vec<_>>(), ["viscous_friction"], "{late}");
        assert!((report.effects[0].parameters[0].fitted / 2e-3 - 1.0).abs() < 0.02);
    }
}

/// Torque that falls off in the course of each log is a drift, and no friction of any kind.
#[test]
fn a_drift_is_no_effect() {
    let report = over_time(Some(60.0), |log, t| {
        let current = 3.0 * wild(log, t);
        let speed = 50.0 + 20.0 * t;
        [current, speed, RATIO * TRUE * current - 0.2 * (t / 1.5).sin()]
    });
    assert!(report.effects.is_empty(), "{:?}", report.effects);
    assert_eq!(report.verdict, Verdict::UnexplainedStructure);
    assert!(report.unexplained.iter().any(|u| u.depends_on.name() == "time"), "{:?}", report.unexplained);
}

/// A line that no motion has, in most of the logs: its frequency and its share of what is left.
#[test]
fn a_hum_is_told_with_its_frequency() {
    let sine = |hertz: f64, size: f64| {
        move |log: usize, t: f64| size * (std::f64::consts::TAU * hertz * t + 2.0 * log as f64).sin()
    };
    let told = |report: &Report| -> Option<(f64, f64)> {
        let line = report.unexplained.iter().find(|u| u.detail.starts_with("a line at"))?;
        assert_eq!((line.depends_on.name(), report.verdict), ("time", Verdict::UnexplainedStructure));
        let number = |after: &str, before: &str| line.detail.split(after).nth(1)?.split(before).next()?.parse().ok();
        Some((number("a line at ", " Hz")?, number("explains holds ", " %")?))
    };
    // Noise of 0.02 N·m over 500 Hz, of which the filter leaves what is below 60 Hz.
    let noise = 0.02_f64.powi(2) * 60.0 / 500.0;
    for (hertz, size) in few(2, [(31.0, 0.02), (44.0, 0.015), (31.0, 0.01), (20.0, 0.02)]) {
        let report = humming(sine(hertz, size), 0.0);
        let (found, share) = told(&report).unwrap_or_else(|| panic!("no hum at {hertz}: {:?}", report.unexplained));
        assert!((found - hertz).abs() <= 1.0, "{found} {hertz}");
        let power = 0.5 * size * size;
        let expected = 100.0 * power / (power + noise);
        assert!((share - expected).abs() < 12.0, "{share} {expected}");
    }
    assert_eq!(told(&humming(|_, _| 0.0, 0.0)), None);
    // The rest takes some half a minute.
    if !are_all() {
        return;
    }
    // Too small a share of what is left.
    assert_eq!(told(&humming(sine(31.0, 0.0025), 0.0)), None);
    // Of four logs three must have it, at one frequency.
    let own = sine(31.0, 0.02);
    assert!(told(&humming(|log, t| if log < 3 { own(log, t) } else { 0.0 }, 0.0)).is_some());
    assert_eq!(told(&humming(|log, t| if log < 2 { own(log, t) } else { 0.0 }, 0.0)), None);
    let other = sine(45.0, 0.02);
    assert_eq!(told(&humming(|log, t| if log % 2 == 0 { own(log, t) } else { other(log, t) }, 0.0)), None);
    // What moves at the same frequency may be its reason.
    assert_eq!(told(&humming(own, 1.0)), None);
    assert!(told(&humming(other, 1.0)).is_some_and(|(found, _)| (found - 45.0).abs() <= 1.0));
}

/// The same where the band is as wide as the sampling allows: what the filter leaves above it is no measure of a line.
#[test]
fn a_hum_is_told_at_the_widest_band() {
    for hertz in few(1, [50.0, 31.0, 150.0]) {
        let report = over_time(Some(200.0), |log, t| {
            let hum = 0.05 * (std::f64::consts::TAU * hertz * t + 2.0 * log as f64).sin();
            let current = 3.0 * wild(log, t);
            [current, 60.0 + 30.0 * (1.3 * t + log as f64).sin(), RATIO * TRUE * current + hum]
        });
        let line = report.unexplained.iter().find_map(|u| u.detail.strip_prefix("a line at ")?.split(" Hz").next());
        let found: f64 = line.unwrap_or_else(|| panic!("{hertz}: {:?}", report.unexplained)).parse().unwrap();
        assert!((found - hertz).abs() <= 1.0, "{found} {hertz}");
    }
}
