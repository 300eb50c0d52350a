use super::super::steady::noise as random;
use super::*;

const BAND: f64 = 40.0;

/// White noise of deviation one, nearly normal.
fn white(place: usize, count: usize) -> Vec<f64> {
    (0..count).map(|k| (0..12).map(|j| random(12 * (place + k) + j)).sum::<f64>() / 2.0).collect()
}

/// What is left of twenty seconds at a kilosample a second; the machine stands in the first third.
fn stretch(left: Vec<f64>) -> Unfiltered {
    let n = left.len();
    Unfiltered {
        step: 1e-3,
        left,
        columns: Vec::new(),
        stands: (0..n).map(|k| 3 * k < n).collect(),
        reading: Reading { quantum: 0.0, rows: 1.0 },
    }
}

/// Root mean square in the band, by the filter itself.
fn in_band(values: &[f64]) -> f64 {
    let filtered = LowPass::new(BAND * 1e-3).apply(values);
    (filtered.iter().map(|v| v * v).sum::<f64>() / filtered.len() as f64).sqrt()
}

/// Of the ways that need no motion.
fn values(noise: &Noise) -> Vec<Option<f64>> {
    noise.estimates.iter().take(3).map(|e| e.value.ok()).collect()
}

#[test]
fn white_noise_is_found_three_times() {
    let left = white(0, 20_000);
    let noise = of_stretches(&[stretch(left.clone())], BAND);
    for estimate in &noise.estimates[..3] {
        let value = estimate.value.unwrap_or_else(|why| panic!("{:?}: {why}", estimate.method));
        assert!((value / in_band(&left) - 1.0).abs() < 0.1, "{:?} {value} {}", estimate.method, in_band(&left));
    }
    assert!(noise.line.is_none());
    assert!((noise.floor().unwrap() / in_band(&left) - 1.0).abs() < 0.1);
    // Two logs are one instrument.
    let two = of_stretches(&[stretch(left.clone()), stretch(white(50_000, 9000))], BAND);
    assert!((two.floor().unwrap() / in_band(&left) - 1.0).abs() < 0.1);
}

/// What stands in the band beside the noise is not in the floor.
#[test]
fn a_disturbance_in_the_band_is_no_noise() {
    let plain = white(1000, 20_000);
    let size = 1.5 * in_band(&plain);
    let swing = |k: usize| size * 2.0_f64.sqrt() * (std::f64::consts::TAU * 3.0e-3 * k as f64).sin();
    // Only while something moves.
    let left: Vec<f64> =
        plain.iter().enumerate().map(|(k, v)| if 3 * k < 20_000 { *v } else { v + swing(k) }).collect();
    let noise = of_stretches(&[stretch(left.clone())], BAND);
    let floor = noise.floor().expect("three ways see it");
    assert!((floor / in_band(&plain) - 1.0).abs() < 0.12, "{floor} {}", in_band(&plain));
    assert!(in_band(&left) > 1.15 * floor);
}

/// Noise that rises or falls with frequency says nothing of the band.
#[test]
fn coloured_noise_is_not_read_from_above_the_band() {
    let plain = white(2000, 20_001);
    let blue: Vec<f64> = plain.windows(2).map(|w| w[1] - w[0]).collect();
    let mut last = 0.0;
    let red: Vec<f64> = plain
        .iter()
        .map(|v| {
            last = 0.97 * last + v;
            last
        })
        .collect();
    for (name, coloured) in [("blue", blue), ("red", red)] {
        let mut one = stretch(coloured);
        one.stands.fill(false);
        let noise = of_stretches(&[one], BAND);
        assert_eq!(values(&noise), [None; 3], "{name}");
        assert_eq!((noise.floor(), noise.told()), (None, Err("nothing in these logs shows it")), "{name}");
    }
}

/// Behind an anti-alias filter second differences read far too little; the spectrum just above the band is right.
#[test]
fn second_differences_do_not_count_behind_a_filter() {
    let left = LowPass::new(0.2).apply(&white(3000, 20_000));
    let noise = of_stretches(&[stretch(left.clone())], BAND);
    let [still, above, second] = values(&noise)[..] else { panic!() };
    assert_eq!(second, None);
    let wrong = crate::signals::noise_level(&left) * LowPass::new(BAND * 1e-3).noise_gain().sqrt();
    assert!(wrong < 0.6 * in_band(&left), "{wrong}");
    for value in [still, above] {
        assert!((value.unwrap() / in_band(&left) - 1.0).abs() < 0.1, "{value:?}");
    }
}

/// A value that is repeated fifteen times, and one of few bits.
#[test]
fn held_and_coarse_channels_are_not_taken_for_quiet_ones() {
    let fresh = white(4000, 2000);
    let mut held = stretch((0..20_000).map(|k| fresh[k / 15]).collect());
    held.reading.rows = 15.0;
    held.stands.fill(false);
    assert_eq!(values(&of_stretches(&[held], BAND)), [None; 3]);
    // A slow wave rounded to a tenth of its size, and noise of a hundredth of that.
    let exact: Vec<f64> = (0..20_000).map(|k| (2e-3 * k as f64).sin()).collect();
    let left = exact.iter().map(|v| (v * 10.0).round() / 10.0 - v).collect();
    let mut coarse = stretch(left);
    coarse.reading.quantum = 0.1;
    assert_eq!(of_stretches(&[coarse], BAND).floor(), None);
    // Standing, it shows one value: less than the last digit.
    let mut still = stretch(vec![0.03; 20_000]);
    still.reading.quantum = 0.1;
    let noise = of_stretches(&[still], BAND);
    assert_eq!(values(&noise), [None; 3]);
}

#[test]
fn a_line_above_the_band_is_told_and_spoils_the_spectrum() {
    let mut left = white(5000, 20_000);
    for (k, v) in left.iter_mut().enumerate() {
        *v += 2.0 * (std::f64::consts::TAU * 0.09 * k as f64).sin();
    }
    let mut one = stretch(left);
    one.stands.fill(false);
    let noise = of_stretches(&[one], BAND);
    assert_eq!(values(&noise), [None; 3]);
    assert!((noise.line.unwrap() - 90.0).abs() < 3.0, "{:?}", noise.line);
}

/// A resonance that noise excites rises above the usual density, and over its neighbours not as a line does.
#[test]
fn the_top_of_a_broad_hump_is_no_line() {
    let (radius, angle) = (0.95_f64, std::f64::consts::TAU * 0.15);
    let (mut one, mut two) = (0.0, 0.0);
    let left = white(7000, 20_000).into_iter().map(|v| {
        (one, two) = (2.0 * radius * angle.cos() * one - radius * radius * two + v, one);
        one
    });
    let mut of = stretch(left.collect());
    of.stands.fill(false);
    let noise = of_stretches(&[of], BAND);
    assert_eq!(noise.line, None);
    assert_eq!(values(&noise), [None; 3]);
}

/// An instrument that is quiet while the machine stands and loud while it runs.
#[test]
fn ways_that_contradict_each_other_say_nothing() {
    let left: Vec<f64> =
        white(6000, 30_000).iter().enumerate().map(|(k, v)| if k < 10_000 { 0.1 * v } else { *v }).collect();
    let noise = of_stretches(&[stretch(left)], BAND);
    assert!(values(&noise).iter().flatten().count() >= 2, "{noise:?}");
    assert_eq!(noise.told(), Err("the ways to find it are more than a factor of two apart"));
    assert_eq!(noise.floor(), None);
}

/// What the declared model makes of a current that changes while the machine stands is no noise.
#[test]
fn standing_still_the_declared_columns_are_taken_out() {
    let current: Vec<f64> = (0..20_000).map(|k| (5e-3 * k as f64).sin() + (2.3e-2 * k as f64).cos()).collect();
    let plain = white(7000, 20_000);
    let mut one = stretch(plain.iter().zip(&current).map(|(v, i)| v + 3.0 * i).collect());
    let blind = of_stretches(std::slice::from_ref(&one), BAND).estimates[0].value.unwrap();
    one.columns.push(current);
    let told = of_stretches(&[one], BAND).estimates[0].value.unwrap();
    assert!((told / in_band(&plain) - 1.0).abs() < 0.12 && blind > 1.5 * told, "{told} {blind}");
}

#[test]
fn short_logs_and_wide_bands_say_nothing() {
    let mut short = stretch(white(8000, 300));
    short.stands.fill(true);
    assert_eq!(values(&of_stretches(&[short], BAND)), [None; 3]);
    let mut wide = stretch(white(9000, 20_000));
    wide.stands.fill(false);
    assert_eq!(values(&of_stretches(&[wide], 300.0)), [None; 3]);
    assert_eq!(of_stretches(&[], BAND).floor(), None);
}

/// A motion that repeats shows the noise beside whatever the model lacks, which repeats with it; one that does not repeat, or a
/// constant one, shows none.
#[test]
fn what_differs_where_the_motion_repeats_is_noise() {
    let plain = white(200_000, 20_000);
    let of = |motion: &dyn Fn(f64) -> f64, lack: f64| {
        let motion: Vec<f64> = (0..plain.len()).map(|k| motion(1e-3 * k as f64)).collect();
        let left = plain.iter().zip(&motion).map(|(v, m)| v + lack * m * m).collect();
        let stretch = Unfiltered { columns: vec![motion], ..stretch(left) };
        of_stretches(&[stretch], BAND).estimates.into_iter().find(|e| e.method == Method::Repeats).unwrap().value
    };
    let periodic = |t: f64| (4.1 * t).sin() + 0.4 * (8.2 * t).cos();
    for lack in [0.0, 2.0] {
        let told = of(&periodic, lack).unwrap();
        assert!((told / in_band(&plain) - 1.0).abs() < 0.1, "{lack}: {told} {}", in_band(&plain));
    }
    assert!(of(&|t| (4.1 * t).sin() + (0.7 * t * t).sin(), 2.0).is_err());
    assert!(of(&|_| 3.0, 0.0).is_err());
}
