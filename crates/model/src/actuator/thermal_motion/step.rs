//! The exact step over a time of constant heat, and its derivative by heat.

/// `1/(n+1)!`, the coefficients of `φ(z) = (e^z − 1)/z`.
pub(super) const PHI: [f64; 12] = [
    1.0,
    1.0 / 2.0,
    1.0 / 6.0,
    1.0 / 24.0,
    1.0 / 120.0,
    1.0 / 720.0,
    1.0 / 5_040.0,
    1.0 / 40_320.0,
    1.0 / 362_880.0,
    1.0 / 3_628_800.0,
    1.0 / 39_916_800.0,
    1.0 / 479_001_600.0,
];

/// Coefficients of the equations, and how the winding's depend on heat.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rates {
    /// `1/τ_w` \[1/s\], winding to housing, and back.
    pub(super) winding: f64,
    /// `1/(R_wh C_h)` \[1/s\].
    pub(super) housing: f64,
    /// `1/τ_h` \[1/s\].
    pub(super) ambient: f64,
    /// `α/C_w` \[1/(s·W)\].
    pub(super) growth: f64,
    /// `(1 + α (T_a − T_0))/C_w` \[K/(s·W)\].
    pub(super) source: f64,
}

/// Rise of winding and of housing over ambient \[K\].
pub(super) type Rise = [f64; 2];

/// The map `x ↦ x + change x + gain` of rises over a time, or its derivative.
#[derive(Debug, Clone, Copy)]
pub(super) struct Step {
    /// `Φ − I`, rows winding and housing.
    pub(super) change: [[f64; 2]; 2],
    /// What heat adds to no rise \[K\].
    pub(super) gain: Rise,
}

pub(super) fn times(m: &[[f64; 2]; 2], x: Rise) -> Rise {
    [m[0][0] * x[0] + m[0][1] * x[1], m[1][0] * x[0] + m[1][1] * x[1]]
}

impl Step {
    pub(super) const NOTHING: Step = Step { change: [[0.0; 2]; 2], gain: [0.0; 2] };

    /// Rises after the step.
    pub(super) fn apply(&self, x: Rise) -> Rise {
        let change = times(&self.change, x);
        [x[0] + (change[0] + self.gain[0]), x[1] + (change[1] + self.gain[1])]
    }

    /// The row `row Φ`.
    pub(super) fn pull(&self, row: Rise) -> Rise {
        let [winding, housing] = self.change;
        [0, 1].map(|node| row[node] + (row[0] * winding[node] + row[1] * housing[node]))
    }

    /// This step, then another: `(I + B)(I + A) − I = A + B + BA`.
    pub(super) fn then(&self, next: &Step) -> Step {
        let (a, b) = (&self.change, &next.change);
        let entry = |i: usize, j: usize| a[i][j] + b[i][j] + (b[i][0] * a[0][j] + b[i][1] * a[1][j]);
        Step { change: [[entry(0, 0), entry(0, 1)], [entry(1, 0), entry(1, 1)]], gain: next.apply(self.gain) }
    }

    /// Derivative of this step taken twice.
    pub(super) fn twice_slope(&self, slope: &Step) -> Step {
        let (a, s) = (&self.change, &slope.change);
        let entry = |i: usize, j: usize| {
            2.0 * s[i][j] + (a[i][0] * s[0][j] + a[i][1] * s[1][j]) + (s[i][0] * a[0][j] + s[i][1] * a[1][j])
        };
        let (by_gain, by_change) = (times(a, slope.gain), times(s, self.gain));
        Step {
            change: [[entry(0, 0), entry(0, 1)], [entry(1, 0), entry(1, 1)]],
            gain: [2.0 * slope.gain[0] + by_gain[0] + by_change[0], 2.0 * slope.gain[1] + by_gain[1] + by_change[1]],
        }
    }

    /// `(I − Φ)⁻¹`, `None` where the spectral radius of Φ is not below one: for Φ ≥ 0 it is below one
    /// exactly where `I − Φ` has positive diagonal and determinant (a nonsingular M-matrix).
    pub(super) fn sum_of_powers(&self) -> Option<[[f64; 2]; 2]> {
        let [[a, b], [c, d]] = self.change;
        let determinant = a * d - b * c;
        (a < 0.0 && d < 0.0 && determinant > 0.0)
            .then(|| [[-d / determinant, b / determinant], [c / determinant, -a / determinant]])
    }
}

impl Rates {
    /// The step over a time at constant heat, and its derivative by heat.
    ///
    /// `φ(B) = (e^B − 1)/B = u I + v B` for `B = hA`, as `B² = tr(B) B − det(B) I` (Cayley and
    /// Hamilton); then `e^B − I = B φ(B)` and `∫₀ʰ e^{tA} dt = h φ(B)`.
    #[inline(always)]
    pub(super) fn expand(&self, duration: f64, heat: f64) -> (Step, Step) {
        let stiffness = 2.0 * (self.winding + self.housing) + self.ambient + self.growth * heat;
        let size = duration * stiffness;
        if size <= 1.0 / 512.0 { self.series::<5>(duration, heat) } else { self.doubled(duration, heat, size) }
    }

    /// The same, of a long time: halved until the series is short, and doubled again.
    #[inline(always)]
    pub(super) fn doubled(&self, duration: f64, heat: f64, size: f64) -> (Step, Step) {
        let (mut part, mut doublings) = (1.0, 0);
        // Heat beyond all numbers must not halve for ever.
        while size * part > 0.25 && doublings < 1000 {
            part *= 0.5;
            doublings += 1;
        }
        let (mut step, mut slope) = self.series::<12>(duration * part, heat);
        for _ in 0..doublings {
            slope = step.twice_slope(&slope);
            step = step.then(&step);
        }
        (step, slope)
    }

    /// The first terms of the series.
    #[inline(always)]
    pub(super) fn series<const TERMS: usize>(&self, h: f64, heat: f64) -> (Step, Step) {
        let Rates { winding, housing, ambient, growth, source } = *self;
        // B, its trace and determinant; their derivatives by heat.
        let (b_ww, b_wh, b_hw, b_hh) =
            (h * (growth * heat - winding), h * winding, h * housing, -h * (housing + ambient));
        let trace = b_ww + b_hh;
        let determinant = h * h * (winding * ambient - growth * heat * (housing + ambient));
        let trace_slope = h * growth;
        let determinant_slope = trace_slope * b_hh;
        let (mut u, mut v) = (PHI[TERMS - 1], 0.0);
        let (mut u_slope, mut v_slope) = (0.0, 0.0);
        for n in (0..TERMS - 1).rev() {
            (u_slope, v_slope) =
                (-(v_slope * determinant + v * determinant_slope), u_slope + v_slope * trace + v * trace_slope);
            (u, v) = (PHI[n] - v * determinant, u + v * trace);
        }
        // B φ = (u + v tr) B − v det I.
        let (along, across) = (u + v * trace, v * determinant);
        let along_slope = u_slope + v_slope * trace + v * trace_slope;
        let across_slope = v_slope * determinant + v * determinant_slope;
        // b = (source q, 0): its first column of h φ.
        let column = [h * (u + v * b_ww), h * v * b_hw];
        let column_slope = [h * (u_slope + v_slope * b_ww + v * trace_slope), h * v_slope * b_hw];
        let gain = source * heat;
        (
            Step {
                change: [[along * b_ww - across, along * b_wh], [along * b_hw, along * b_hh - across]],
                gain: [gain * column[0], gain * column[1]],
            },
            Step {
                change: [
                    [along_slope * b_ww + along * trace_slope - across_slope, along_slope * b_wh],
                    [along_slope * b_hw, along_slope * b_hh - across_slope],
                ],
                gain: [source * column[0] + gain * column_slope[0], source * column[1] + gain * column_slope[1]],
            },
        )
    }

    /// The step over a time \[s\] at constant heat \[W\].
    #[inline(always)]
    pub(super) fn step(&self, duration: f64, heat: f64) -> Step {
        self.expand(duration, heat).0
    }
}
