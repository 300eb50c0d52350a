//! The samples of a joint, arranged so that the largest demand over all of them is found without
//! looking at all of them.
//!
//! Torque, voltage and power are functions of a few linear forms in the features of a sample. A
//! tree of bounding boxes in feature space, made once per joint and independent of motor, gear and
//! ratio, bounds each form over a box; a box whose bound cannot beat the largest value found so far
//! is skipped. The result is the exact maximum.

use std::sync::Arc;

use super::fitted::Shortfall;
use super::shaft::{Actuator, FEATURES, Feature, Flow, USUAL_FEATURES};
use super::supply::Supply;
use super::weakening::{self, Parabola};
use crate::numerics::laurent::Laurent;
use crate::numerics::work;

/// Samples in a leaf of the tree.
const LEAF: usize = 8;
/// Features that boxes are divided along; those after them follow from these.
const SPLIT: usize = 8;

/// What is maximised over samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Functional {
    /// `T²` \[N²·m²\].
    TorqueSquared,
    /// `T² + (K_T i_d)²` \[N²·m²\].
    CurrentSquared,
    /// `v_q² + v_d²` \[V²\], of the hottest or of the coldest winding, whichever needs more.
    VoltageSquared,
    /// The least of it with a current against the magnets of at most so much, times the torque constant \[N·m\].
    LeastVoltage(f64),
    /// Terminal power taken \[W\], of the hottest winding.
    Power,
    /// Terminal power returned \[W\], of the coldest winding: where the iron saturates from above, with the loss of `T/K_T`.
    PowerBack,
    /// Open-circuit voltage that a supply needs \[V\].
    OpenVoltage(Supply),
}

/// How many functionals there are.
pub const FUNCTIONALS: usize = 7;

impl Functional {
    /// Its place among all.
    pub fn place(self) -> usize {
        match self {
            Functional::TorqueSquared => 0,
            Functional::VoltageSquared => 1,
            Functional::Power => 2,
            Functional::PowerBack => 3,
            Functional::OpenVoltage(_) => 4,
            Functional::CurrentSquared => 5,
            Functional::LeastVoltage(_) => 6,
        }
    }

    /// True if the polynomial of a sample is the functional at one ratio alone, and nowhere above it.
    pub fn touches(self, actuator: &Actuator) -> bool {
        match self {
            Functional::OpenVoltage(_) => true,
            Functional::VoltageSquared | Functional::Power => actuator.shortfall.saturates(),
            _ => false,
        }
    }

    /// Actuators, each with one winding, of whose values it is the larger: hottest and coldest winding, or the actuator itself.
    pub fn windings(self, actuator: &Actuator) -> Vec<Actuator> {
        match self {
            Functional::VoltageSquared | Functional::LeastVoltage(_) | Functional::OpenVoltage(_) => {
                actuator.windings().to_vec()
            }
            _ => vec![*actuator],
        }
    }

    /// The polynomial of one sample. That of the open-circuit voltage touches it at a ratio; it is at most the supply's own
    /// wherever the sample keeps to that. Of a motor whose iron saturates [`Self::touches`] says which do that too.
    pub fn polynomial(self, actuator: &Actuator, point: &WavePoint, ratio: f64) -> Laurent {
        let WavePoint { flow, features, direct, .. } = point;
        let squared = |per_square: f64| Laurent::constant(per_square * direct * direct);
        match self {
            Functional::OpenVoltage(supply) => supply.polynomial(actuator, *flow, features, ratio),
            Functional::TorqueSquared => actuator.torque_squared(*flow, features),
            Functional::CurrentSquared => actuator.torque_squared(*flow, features) + squared(1.0),
            Functional::VoltageSquared => larger(ratio, actuator, |winding| match *direct {
                0.0 => winding.voltage_squared_near(*flow, features, ratio),
                direct => weakened(winding, point, direct),
            }),
            Functional::LeastVoltage(most) => larger(ratio, actuator, |winding| {
                weakened(winding, point, weakening::parabola(winding, (*flow, features), ratio).lowest(most))
            }),
            Functional::Power => {
                actuator.power_near(actuator.loss_taken(), *flow, features, ratio) + squared(actuator.loss_taken())
            }
            Functional::PowerBack => {
                (actuator.power(actuator.loss_returned(), *flow, features) + squared(actuator.loss_returned())) * -1.0
            }
        }
    }
}

/// The larger polynomial at a ratio of the hottest and the coldest winding.
fn larger(ratio: f64, actuator: &Actuator, of: impl Fn(&Actuator) -> Laurent) -> Laurent {
    let [hot, cold] = actuator.windings().map(|winding| of(&winding));
    if cold.at(ratio) > hot.at(ratio) { cold } else { hot }
}

/// `v_q² + v_d²` of a sample with a current along d, as it changes with the ratio.
fn weakened(actuator: &Actuator, point: &WavePoint, direct: f64) -> Laurent {
    let plain = actuator.voltage_squared(point.flow, &point.features);
    if direct == 0.0 {
        return plain;
    }
    let across = Laurent::monomial(actuator.cross_coupling * point.features[Feature::Velocity as usize], 1);
    let along = actuator.resistance_per_torque();
    let quadrature = actuator.voltage_form(point.flow).polynomial(&point.features) + across * direct;
    let own = across * actuator.torque_form(point.flow).polynomial(&point.features) * -1.0;
    quadrature.squared() + (own + Laurent::constant(along * direct)).squared()
}

/// The largest value, and the sample that has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Largest {
    /// The value.
    pub value: f64,
    /// Index into the waveform.
    pub index: usize,
}

#[derive(Debug, Clone)]
struct Node {
    center: [f64; FEATURES],
    radius: [f64; FEATURES],
    start: usize,
    end: usize,
    children: Option<(usize, usize)>,
}

/// One sample of a waveform.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WavePoint {
    /// Its features.
    pub features: [f64; FEATURES],
    /// Which way power flows.
    pub flow: Flow,
    /// The sample of the motion that it belongs to.
    pub origin: usize,
    /// Current along d that weakens the field at a ratio, times the torque constant \[N·m\]; zero before a ratio is chosen.
    pub direct: f64,
}

impl WavePoint {
    /// Torque at a flange that has an inertia of its own \[kg·m²\] to turn \[N·m\]: without loss, at no ratio.
    pub fn flange_torque(&self, inertia: f64) -> f64 {
        self.features[Feature::Load as usize] + inertia * self.features[Feature::Acceleration as usize]
    }
}

/// A set of samples with its trees, one for each direction of power.
#[derive(Debug, Clone, Default)]
pub struct Waveform {
    points: Arc<Points>,
    /// Currents along d, of each point; empty where there are none.
    direct: Vec<f64>,
    /// The points that have one.
    along_d: Vec<usize>,
}

/// The points and the trees over them.
#[derive(Debug, Clone, Default)]
struct Points {
    columns: [Vec<f64>; FEATURES],
    origin: Vec<usize>,
    /// Indices in the order of what they belong to.
    by_origin: Vec<usize>,
    driving: usize,
    nodes: Vec<Node>,
    roots: Vec<(Flow, usize)>,
}

/// What a walk through the trees keeps.
trait Keep {
    /// What is not larger is of no interest.
    fn limit(&self) -> f64;
    /// A point with its value.
    fn see(&mut self, index: usize, value: f64);
}

impl Keep for Largest {
    #[inline(always)]
    fn limit(&self) -> f64 {
        self.value
    }

    #[inline(always)]
    fn see(&mut self, index: usize, value: f64) {
        if value > self.value {
            *self = Largest { value, index };
        }
    }
}

/// All points beyond a bound.
struct Beyond {
    bound: f64,
    found: Vec<usize>,
}

impl Keep for Beyond {
    #[inline(always)]
    fn limit(&self) -> f64 {
        self.bound
    }

    #[inline(always)]
    fn see(&mut self, index: usize, value: f64) {
        if value > self.bound {
            self.found.push(index);
        }
    }
}

/// Coefficients of one actuator at one ratio, for one direction of power.
struct Weights {
    torque: [f64; FEATURES],
    /// Quadrature voltage of the hottest and of the coldest winding.
    voltage: [[f64; FEATURES]; 2],
    direct: f64,
    /// Loss per squared torque of the hottest winding, for power taken, and of the coldest, for power returned.
    copper: [f64; 2],
    emf: f64,
    /// Resistance over torque constant of both windings, for the voltage of currents along d.
    along: [f64; 2],
    /// The current that a torque takes where the iron saturates.
    iron: Option<Shortfall>,
}

/// The hottest winding and the coldest, as places in [`Weights`].
const WINDINGS: [usize; 2] = [HOT, COLD];
const HOT: usize = 0;
const COLD: usize = 1;

impl Waveform {
    /// Arranges points.
    pub fn new(points: &[WavePoint]) -> Waveform {
        let mut order: Vec<usize> = (0..points.len()).collect();
        order.sort_by_key(|i| points[*i].flow as usize);
        let driving = points.iter().filter(|p| p.flow == Flow::Driving).count();
        // Features are compared in units of their spread, so that no unit is preferred.
        let spread = |f: usize| {
            let (low, high) =
                points.iter().fold((f64::MAX, f64::MIN), |(l, h), p| (l.min(p.features[f]), h.max(p.features[f])));
            if high > low { high - low } else { f64::INFINITY }
        };
        let spreads: [f64; FEATURES] = std::array::from_fn(spread);
        let mut all = Points { driving, ..Points::default() };
        for (flow, start, end) in [(Flow::Driving, 0, driving), (Flow::Braking, driving, points.len())] {
            if start < end {
                let root = all.grow(points, &mut order, start, end, &spreads);
                all.roots.push((flow, root));
            }
        }
        for f in 0..FEATURES {
            all.columns[f] = order.iter().map(|i| points[*i].features[f]).collect();
        }
        all.origin = order.iter().map(|i| points[*i].origin).collect();
        all.by_origin = (0..points.len()).collect();
        all.by_origin.sort_by_key(|k| all.origin[*k]);
        Waveform { points: Arc::new(all), ..Waveform::default() }
    }
}

impl Points {
    fn grow(
        &mut self,
        points: &[WavePoint],
        order: &mut [usize],
        start: usize,
        end: usize,
        spreads: &[f64; FEATURES],
    ) -> usize {
        let mut low = [f64::MAX; FEATURES];
        let mut high = [f64::MIN; FEATURES];
        for i in &order[start..end] {
            for f in 0..FEATURES {
                low[f] = low[f].min(points[*i].features[f]);
                high[f] = high[f].max(points[*i].features[f]);
            }
        }
        let node = self.nodes.len();
        self.nodes.push(Node {
            center: std::array::from_fn(|f| 0.5 * (low[f] + high[f])),
            radius: std::array::from_fn(|f| 0.5 * (high[f] - low[f])),
            start,
            end,
            children: None,
        });
        if end - start > LEAF {
            let widest = (0..SPLIT)
                .max_by(|a, b| ((high[*a] - low[*a]) / spreads[*a]).total_cmp(&((high[*b] - low[*b]) / spreads[*b])))
                .unwrap_or(0);
            let middle = (end - start) / 2;
            // Ties are broken by the place in the motion, so that the tree is one and the same.
            order[start..end].select_nth_unstable_by(middle, |a, b| {
                points[*a].features[widest].total_cmp(&points[*b].features[widest]).then(a.cmp(b))
            });
            let left = self.grow(points, order, start, start + middle, spreads);
            let right = self.grow(points, order, start + middle, end, spreads);
            self.nodes[node].children = Some((left, right));
        }
        node
    }

    fn without_tree(&self) -> Points {
        let mut points = Points {
            columns: self.columns.clone(),
            origin: self.origin.clone(),
            by_origin: self.by_origin.clone(),
            driving: self.driving,
            ..Points::default()
        };
        for (flow, start, end) in [(Flow::Driving, 0, self.driving), (Flow::Braking, self.driving, self.origin.len())] {
            if start < end {
                points.roots.push((flow, points.nodes.len()));
                points.nodes.push(Node {
                    center: [0.0; FEATURES],
                    radius: [f64::INFINITY; FEATURES],
                    start,
                    end,
                    children: None,
                });
            }
        }
        points
    }
}

impl Waveform {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.points.origin.len()
    }

    /// Whether there is no point.
    pub fn is_empty(&self) -> bool {
        self.points.origin.is_empty()
    }

    /// The sample of the motion that a point belongs to.
    pub fn origin(&self, index: usize) -> usize {
        self.points.origin[index]
    }

    fn flow(&self, index: usize) -> Flow {
        if index < self.points.driving { Flow::Driving } else { Flow::Braking }
    }

    /// The points that belong to a sample of the motion, as indices.
    pub fn of_sample(&self, sample: usize) -> &[usize] {
        let by = &self.points.by_origin;
        let first = by.partition_point(|k| self.origin(*k) < sample);
        &by[first..by.partition_point(|k| self.origin(*k) <= sample)]
    }

    /// The samples of the motion that have points, in their order.
    pub fn samples(&self) -> impl Iterator<Item = usize> {
        let mut last = None;
        self.points.by_origin.iter().map(|k| self.origin(*k)).filter(move |k| last.replace(*k) != Some(*k))
    }

    /// A point as it went in.
    pub fn point(&self, index: usize) -> WavePoint {
        WavePoint {
            features: std::array::from_fn(|f| self.points.columns[f][index]),
            flow: self.flow(index),
            origin: self.origin(index),
            direct: self.direct.get(index).copied().unwrap_or(0.0),
        }
    }

    /// The exact largest value of a functional over all points at a ratio.
    ///
    /// # Panics
    /// If there is no point.
    pub fn largest(&self, functional: Functional, actuator: &Actuator, ratio: f64) -> Largest {
        self.largest_above(functional, actuator, ratio, f64::NEG_INFINITY)
    }

    /// The largest value and its index, if the value exceeds a floor; else the floor and any index.
    pub fn largest_above(&self, functional: Functional, actuator: &Actuator, ratio: f64, floor: f64) -> Largest {
        let mut largest = Largest { value: floor, index: 0 };
        self.walk(functional, actuator, ratio, &mut largest);
        largest
    }

    /// The points at which a functional is more than so much at a ratio, as indices.
    pub fn beyond(&self, functional: Functional, actuator: &Actuator, ratio: f64, bound: f64) -> Vec<usize> {
        let mut beyond = Beyond { bound, found: Vec::new() };
        self.walk(functional, actuator, ratio, &mut beyond);
        beyond.found
    }

    fn walk(&self, functional: Functional, actuator: &Actuator, ratio: f64, keep: &mut impl Keep) {
        // Most motors have no effect that needs the last features: they are not multiplied with zero.
        if actuator.has_unusual_features() {
            self.walk_over::<FEATURES>(functional, actuator, ratio, keep);
        } else {
            self.walk_over::<USUAL_FEATURES>(functional, actuator, ratio, keep);
        }
    }

    fn walk_over<const D: usize>(&self, functional: Functional, actuator: &Actuator, ratio: f64, keep: &mut impl Keep) {
        let voltage =
            |weights: &Weights, node: &Node| of_windings(|winding| bound_voltage::<D>(weights, winding, node));
        match functional {
            Functional::TorqueSquared => self.search::<D>(actuator, ratio, bound_torque::<D>, value_torque::<D>, keep),
            Functional::CurrentSquared => {
                self.search::<D>(actuator, ratio, bound_torque::<D>, value_current::<D>, keep);
            }
            Functional::LeastVoltage(most) => {
                let value = |weights: &Weights, x: &[f64; FEATURES], _| {
                    of_windings(|winding| value_least_voltage::<D>(weights, winding, x, most))
                };
                self.search::<D>(actuator, ratio, voltage, value, keep);
            }
            Functional::VoltageSquared => {
                let value = |weights: &Weights, x: &[f64; FEATURES], direct| {
                    of_windings(|winding| value_voltage::<D>(weights, winding, x, direct))
                };
                self.search::<D>(actuator, ratio, voltage, value, keep);
            }
            Functional::Power => {
                let value = |weights: &Weights, x: &[f64; FEATURES], direct| value_power::<D>(weights, HOT, x, direct);
                let bound = |weights: &Weights, node: &Node| bound_power::<D>(weights, HOT, node);
                self.search::<D>(actuator, ratio, bound, value, keep);
            }
            Functional::PowerBack => {
                self.search::<D>(actuator, ratio, bound_power_back::<D>, value_power_back::<D>, keep);
            }
            Functional::OpenVoltage(supply) => self.search::<D>(
                actuator,
                ratio,
                |weights, node| {
                    of_windings(|winding| {
                        let power = bound_power::<D>(weights, winding, node);
                        supply.needed_at_most(bound_voltage::<D>(weights, winding, node), power)
                    })
                },
                |weights, x, direct| {
                    of_windings(|winding| {
                        let power = value_power::<D>(weights, winding, x, direct);
                        supply.needed(value_voltage::<D>(weights, winding, x, direct), power)
                    })
                },
                keep,
            ),
        }
    }

    /// Its points at a ratio, one by one.
    pub fn at(&self, actuator: &Actuator, ratio: f64) -> AtRatio<'_> {
        let weights = [Flow::Driving, Flow::Braking].map(|flow| Weights::new(actuator, flow, ratio));
        AtRatio { points: &self.points, direct: &self.direct, weights }
    }

    /// The same points with some of their features changed, for one ratio: without a tree.
    pub fn changed(&self, change: impl Fn(&mut [f64; FEATURES])) -> Waveform {
        let mut points = self.points.without_tree();
        for i in 0..self.len() {
            let mut features = std::array::from_fn(|f| points.columns[f][i]);
            change(&mut features);
            for (column, value) in points.columns.iter_mut().zip(features) {
                column[i] = value;
            }
        }
        Waveform { points: Arc::new(points), ..self.clone() }
    }

    /// The same points with currents along d, for one ratio.
    pub fn weakened(&self, direct: Vec<f64>) -> Waveform {
        let along_d = (0..direct.len()).filter(|k| direct[*k] != 0.0).collect();
        Waveform { points: Arc::clone(&self.points), direct, along_d }
    }

    /// Whether its points have currents along d.
    pub fn is_weakened(&self) -> bool {
        !self.direct.is_empty()
    }

    /// What the largest current is read from.
    pub fn of_current(&self) -> Functional {
        if self.is_weakened() { Functional::CurrentSquared } else { Functional::TorqueSquared }
    }

    #[inline(always)]
    fn search<const D: usize>(
        &self,
        actuator: &Actuator,
        ratio: f64,
        bound: impl Fn(&Weights, &Node) -> f64 + Copy,
        value: impl Fn(&Weights, &[f64; FEATURES], f64) -> f64 + Copy,
        keep: &mut impl Keep,
    ) {
        let mut stack: [(usize, f64); 64] = [(0, 0.0); 64];
        for (flow, root) in &self.points.roots {
            let weights = Weights::new(actuator, *flow, ratio);
            // The bounds of boxes are those without a current along d: points that have one are looked at by themselves.
            for k in self.along_d.iter().copied().filter(|k| self.flow(*k) == *flow) {
                let features = std::array::from_fn(|f| if f < D { self.points.columns[f][k] } else { 0.0 });
                keep.see(k, value(&weights, &features, self.direct[k]));
            }
            let mut depth = 1;
            stack[0] = (*root, f64::INFINITY);
            while depth > 0 {
                depth -= 1;
                let (node, limit) = stack[depth];
                if limit <= keep.limit() {
                    continue;
                }
                let node = &self.points.nodes[node];
                let Some((left, right)) = node.children else {
                    self.scan::<D>(node.start, node.end, &weights, value, keep);
                    continue;
                };
                let (a, b) = (bound(&weights, &self.points.nodes[left]), bound(&weights, &self.points.nodes[right]));
                // The more promising child is looked at first: it is pushed last.
                let (first, second) = if a >= b { ((left, a), (right, b)) } else { ((right, b), (left, a)) };
                stack[depth] = second;
                stack[depth + 1] = first;
                depth += 2;
            }
        }
    }

    #[inline(always)]
    fn scan<const D: usize>(
        &self,
        start: usize,
        end: usize,
        weights: &Weights,
        value: impl Fn(&Weights, &[f64; FEATURES], f64) -> f64,
        keep: &mut impl Keep,
    ) {
        work::count(end - start);
        let columns: [&[f64]; FEATURES] = std::array::from_fn(|f| &self.points.columns[f][start..end]);
        #[expect(clippy::needless_range_loop, reason = "the columns are walked together")]
        for i in 0..end - start {
            let features = std::array::from_fn(|f| if f < D { columns[f][i] } else { 0.0 });
            if self.direct.is_empty() || self.direct[start + i] == 0.0 {
                keep.see(start + i, value(weights, &features, 0.0));
            }
        }
    }
}

/// The points of a waveform at a ratio.
pub struct AtRatio<'a> {
    points: &'a Points,
    direct: &'a [f64],
    weights: [Weights; 2],
}

impl AtRatio<'_> {
    fn point(&self, index: usize) -> (&Weights, [f64; FEATURES]) {
        let weights = &self.weights[usize::from(index >= self.points.driving)];
        (weights, std::array::from_fn(|f| self.points.columns[f][index]))
    }

    /// The voltage of a point as a parabola in the current along d, of the hottest winding and of the coldest.
    pub fn parabolas(&self, index: usize) -> [Parabola; 2] {
        let (weights, x) = self.point(index);
        WINDINGS.map(|winding| parabola::<FEATURES>(weights, winding, &x))
    }

    /// The squared voltage \[V²\] of a point and the power that it takes \[W\], with the currents along d that it has, of the hottest
    /// winding and of the coldest.
    pub fn terminals(&self, index: usize) -> [(f64, f64); 2] {
        let (weights, x) = self.point(index);
        let direct = self.direct.get(index).copied().unwrap_or(0.0);
        WINDINGS.map(|winding| {
            let power = value_power::<FEATURES>(weights, winding, &x, direct);
            (value_voltage::<FEATURES>(weights, winding, &x, direct), power)
        })
    }

    /// Power that a point returns at its terminals, with the coldest winding \[W\]; less than zero where it takes some.
    pub fn given_back(&self, index: usize) -> f64 {
        let (weights, x) = self.point(index);
        value_power_back::<FEATURES>(weights, &x, self.direct.get(index).copied().unwrap_or(0.0))
    }

    /// Power that a point gives back without a current along d \[W\], and the size of the terms whose difference it is.
    pub fn power_back(&self, index: usize) -> (f64, f64) {
        let (weights, x) = self.point(index);
        let torque = dot::<FEATURES>(&weights.torque, &x);
        let (heat, work) = (weights.copper[COLD] * torque * torque, weights.emf * x[VELOCITY] * torque);
        (-(heat + work), heat + work.abs())
    }
}

impl Weights {
    fn new(actuator: &Actuator, flow: Flow, ratio: f64) -> Weights {
        let torque = actuator.torque_form(flow).weights(ratio);
        let hot = actuator.voltage_form(flow).weights(ratio);
        let cooler = actuator.cooler();
        Weights {
            torque,
            voltage: [hot, std::array::from_fn(|f| hot[f] - cooler * torque[f])],
            direct: actuator.cross_coupling * ratio,
            copper: [actuator.loss_taken(), actuator.loss_returned()],
            emf: actuator.back_emf_constant / actuator.torque_constant * ratio,
            along: [actuator.resistance_per_torque(), actuator.cold_resistance_per_torque()],
            iron: Some(actuator.shortfall).filter(Shortfall::saturates),
        }
    }

    /// `K_T i` at a torque ≥ 0 \[N·m\].
    #[inline(always)]
    fn without_saturation(&self, torque: f64) -> f64 {
        self.iron.as_ref().map_or(torque, |iron| iron.without_saturation(torque).0)
    }

    /// Quadrature voltage \[V\], the larger in magnitude of the values with and without the additional ohmic drop of saturation.
    #[inline(always)]
    fn with_saturation(&self, winding: usize, quadrature: f64, torque: f64) -> f64 {
        if self.iron.is_none() {
            return quadrature;
        }
        let more = self.along[winding] * (self.without_saturation(torque.abs()) - torque.abs());
        let with = quadrature + more.copysign(torque);
        if with.abs() > quadrature.abs() { with } else { quadrature }
    }
}

/// The larger value of the hottest winding and of the coldest.
#[inline(always)]
fn of_windings(value: impl Fn(usize) -> f64) -> f64 {
    value(HOT).max(value(COLD))
}

#[inline(always)]
fn dot<const D: usize>(weights: &[f64; FEATURES], features: &[f64; FEATURES]) -> f64 {
    weights[..D].iter().zip(&features[..D]).map(|(w, x)| w * x).sum()
}

/// Centre and half-width of a linear form over a box; the half-width is widened by what rounding
/// can do, so that a bound never falls below a value.
#[inline(always)]
fn interval<const D: usize>(weights: &[f64; FEATURES], node: &Node) -> (f64, f64) {
    let (mut center, mut radius, mut size) = (0.0, 0.0, 0.0);
    for ((weight, middle), half) in weights[..D].iter().zip(&node.center[..D]).zip(&node.radius[..D]) {
        let term = weight * middle;
        center += term;
        size += term.abs();
        radius += weight.abs() * half;
    }
    (center, radius + 1e-14 * (size + radius))
}

#[inline(always)]
fn largest_magnitude<const D: usize>(weights: &[f64; FEATURES], node: &Node) -> f64 {
    let (center, radius) = interval::<D>(weights, node);
    center.abs() + radius
}

#[inline(always)]
fn value_torque<const D: usize>(weights: &Weights, features: &[f64; FEATURES], _: f64) -> f64 {
    let torque = dot::<D>(&weights.torque, features);
    torque * torque
}

#[inline(always)]
fn value_current<const D: usize>(weights: &Weights, features: &[f64; FEATURES], direct: f64) -> f64 {
    value_torque::<D>(weights, features, 0.0) + direct * direct
}

#[inline(always)]
fn bound_torque<const D: usize>(weights: &Weights, node: &Node) -> f64 {
    let torque = largest_magnitude::<D>(&weights.torque, node);
    torque * torque
}

const VELOCITY: usize = Feature::Velocity as usize;

#[inline(always)]
fn value_voltage<const D: usize>(weights: &Weights, winding: usize, features: &[f64; FEATURES], direct: f64) -> f64 {
    let across = weights.direct * features[VELOCITY];
    let torque = dot::<D>(&weights.torque, features);
    let mut quadrature = dot::<D>(&weights.voltage[winding], features) + across * direct;
    if direct == 0.0 {
        quadrature = weights.with_saturation(winding, quadrature, torque);
    }
    let own = weights.along[winding] * direct - across * torque;
    quadrature * quadrature + own * own
}

#[inline(always)]
fn parabola<const D: usize>(weights: &Weights, winding: usize, features: &[f64; FEATURES]) -> Parabola {
    let quadrature = dot::<D>(&weights.voltage[winding], features);
    let torque = dot::<D>(&weights.torque, features);
    Parabola::new(quadrature, torque, weights.direct * features[VELOCITY], weights.along[winding])
}

#[inline(always)]
fn value_least_voltage<const D: usize>(
    weights: &Weights,
    winding: usize,
    features: &[f64; FEATURES],
    most: f64,
) -> f64 {
    let parabola = parabola::<D>(weights, winding, features);
    parabola.at(parabola.lowest(most)).max(0.0)
}

#[inline(always)]
fn bound_voltage<const D: usize>(weights: &Weights, winding: usize, node: &Node) -> f64 {
    let torque = largest_magnitude::<D>(&weights.torque, node);
    let more = weights.along[winding] * (weights.without_saturation(torque) - torque);
    let quadrature = largest_magnitude::<D>(&weights.voltage[winding], node) + more.max(0.0);
    let speed = node.center[VELOCITY].abs() + node.radius[VELOCITY];
    let direct = weights.direct * speed * torque;
    (quadrature * quadrature + direct * direct) * (1.0 + 1e-14)
}

#[inline(always)]
fn value_power<const D: usize>(weights: &Weights, winding: usize, features: &[f64; FEATURES], direct: f64) -> f64 {
    let torque = dot::<D>(&weights.torque, features);
    let without = weights.without_saturation(torque.abs());
    weights.copper[winding] * (without * without + direct * direct) + weights.emf * features[VELOCITY] * torque
}

#[inline(always)]
fn value_power_back<const D: usize>(weights: &Weights, features: &[f64; FEATURES], direct: f64) -> f64 {
    let torque = dot::<D>(&weights.torque, features);
    -(weights.copper[COLD] * (torque * torque + direct * direct) + weights.emf * features[VELOCITY] * torque)
}

/// Largest and smallest product of speed and torque over a box.
#[inline(always)]
fn mechanical<const D: usize>(weights: &Weights, node: &Node) -> (f64, f64, f64) {
    let (center, radius) = interval::<D>(&weights.torque, node);
    let (t0, t1) = (center - radius, center + radius);
    let (w0, w1) = (node.center[VELOCITY] - node.radius[VELOCITY], node.center[VELOCITY] + node.radius[VELOCITY]);
    let products = [t0 * w0, t0 * w1, t1 * w0, t1 * w1];
    let low = products.iter().copied().fold(f64::INFINITY, f64::min);
    let high = products.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let slack = 1e-13 * low.abs().max(high.abs());
    (low - slack, high + slack, center.abs() + radius)
}

#[inline(always)]
fn bound_power<const D: usize>(weights: &Weights, winding: usize, node: &Node) -> f64 {
    let (_, high, torque) = mechanical::<D>(weights, node);
    let without = weights.without_saturation(torque);
    weights.copper[winding] * without * without + weights.emf * high
}

#[inline(always)]
fn bound_power_back<const D: usize>(weights: &Weights, node: &Node) -> f64 {
    let (low, ..) = mechanical::<D>(weights, node);
    -weights.emf * low
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::Catalog;
    use crate::requirement::GearModel;

    /// Samples without any pattern, from a linear congruential sequence.
    fn points(count: usize) -> Vec<WavePoint> {
        let mut state = 12_345_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / f64::from(u32::MAX >> 1) - 1.0
        };
        let size = [20.0, 800.0, 100.0, 9_000.0, 10.0, 1.0, 10.0, 1.0, 100.0];
        (0..count)
            .map(|origin| {
                let features: [f64; FEATURES] = std::array::from_fn(|f| size[f] * next());
                WavePoint { features, flow: Flow::of(features[0], features[4]), origin, direct: 0.0 }
            })
            .collect()
    }

    /// Every functional at ratios; the supply holds the voltage of its sample of most power at half of its own.
    fn with_ratios(actuator: &Actuator, points: &[WavePoint]) -> Vec<(Functional, f64)> {
        let bus = crate::requirement::read_source(&std::sync::Arc::new(crate::input::Source::new(
            "robot.toml",
            "name='r'\nbus={voltage='48 V',drive_efficiency=0.9}\njoint=[{name='j',ratio={min=1,max=2},points=[{torque='1 N*m',speed='1 rad/s'}]}]",
        )))
        .unwrap()
        .bus;
        let with = |ratio: f64| {
            let most =
                |f: Functional| points.iter().map(|p| f.polynomial(actuator, p, ratio).at(ratio)).fold(0.0, f64::max);
            let voltage = most(Functional::VoltageSquared).sqrt();
            let bus = crate::requirement::Bus { voltage, ..bus };
            let resistance = 0.1 * voltage * voltage / most(Functional::Power).max(1e-9);
            let supply = Supply::new(&bus, resistance, (0.7, 0.01 * voltage), 1.0, 0.0);
            [
                Functional::TorqueSquared,
                Functional::VoltageSquared,
                Functional::Power,
                Functional::PowerBack,
                Functional::OpenVoltage(supply),
            ]
            .map(|functional| (functional, ratio))
        };
        [0.5, 3.0, 17.0, 140.0].into_iter().flat_map(with).collect()
    }

    #[test]
    fn the_largest_is_the_largest_over_all_points() {
        let catalog = Catalog::builtin().unwrap();
        let gear = GearModel { efficiency: 0.8, backdrive_efficiency: 0.75, inertia: 1e-6, ..GearModel::IDEAL };
        for count in [1, 7, 8, 9, 1000] {
            let points = points(count);
            let wave = Waveform::new(&points);
            assert_eq!(wave.len(), count);
            for id in [
                "t-motor-ri50",
                "faulhaber-3274g024bp4",
                "maxon-ec-90-flat-323772",
                "tq-robodrive-ilm-e70x18-star-parallel",
            ] {
                let motor = catalog.motor(id).unwrap();
                let actuator = Actuator::new(motor, motor.rotor_inertia.unwrap(), &gear);
                assert_eq!(actuator.shortfall.saturates(), id.starts_with("tq-"));
                for (functional, ratio) in with_ratios(&actuator, &points) {
                    let found = wave.largest(functional, &actuator, ratio);
                    // Independent of the search: the polynomial of every point.
                    let at = |p: &WavePoint| functional.polynomial(&actuator, p, ratio).at(ratio);
                    let all = points.iter().map(at).fold(f64::NEG_INFINITY, f64::max);
                    let size = points.iter().map(|p| at(p).abs()).fold(0.0, f64::max);
                    assert!(
                        (found.value - all).abs() <= 1e-9 * size,
                        "{id} {functional:?} {ratio}: {} {all}",
                        found.value
                    );
                    assert!((at(&wave.point(found.index)) - all).abs() <= 1e-9 * size);
                    // At other ratios the polynomial is the functional, or below it.
                    let point = wave.point(found.index);
                    for other in [0.3, 0.8, 1.5, 4.0].map(|times| times * ratio) {
                        let (row, own) = (
                            functional.polynomial(&actuator, &point, ratio),
                            functional.polynomial(&actuator, &point, other),
                        );
                        let more = row.at(other) - own.at(other);
                        let is_row = functional.touches(&actuator) || more >= -1e-9 * own.size(other);
                        let kept = !matches!(functional, Functional::OpenVoltage(_));
                        assert!(
                            !kept || is_row && more <= 1e-9 * (own.size(other) + row.size(other)),
                            "{id} {functional:?} {ratio} {other}: {more}"
                        );
                    }
                }
            }
        }
    }
}
