//! Seconds that own the error of all logs.
//!
//! The one idea: what a machine does it does again. A second in which a driver hung or a bench was bumped happens once,
//! weighs more than all others together, and says nothing of the actuator.

use std::ops::Range;

use crate::answer::Pictures;
use crate::signals;

/// A window is this many times the median's mean square.
const TIMES: f64 = 25.0;
/// Share of the squared error that such windows own, and the largest share of the time that they may be.
const OWN: (f64, f64) = (0.25, 0.05);
/// Most events: what comes more often belongs to the machine.
const EVENTS: usize = 3;
/// Least and largest length of a window \[s\].
const WINDOW: (f64, f64) = (0.1, 1.0);
/// Fewest windows.
const FEWEST: usize = 20;

/// The log, the time from its start and the share of the squared error of the few stretches that own much of what is left.
pub fn seconds(pictures: &Pictures, fits: impl Fn(usize) -> bool) -> Vec<(usize, Range<f64>, f64)> {
    let known: Vec<usize> = (0..pictures.after.len()).filter(|k| fits(pictures.log[*k])).collect();
    let logs = known.iter().map(|k| pictures.log[*k]).max().map_or(0, |l| l + 1);
    let length: f64 = (0..logs)
        .map(|log| known.iter().filter(|k| pictures.log[**k] == log).map(|k| pictures.time[*k]).fold(0.0, f64::max))
        .sum();
    let width = (length / 100.0).clamp(WINDOW.0, WINDOW.1);
    // Squared error and rows of each window.
    let mut windows: Vec<(usize, usize, f64, f64)> = Vec::new();
    let mut total = 0.0;
    for k in known {
        let (log, at) = (pictures.log[k], (pictures.time[k] / width) as usize);
        let square = pictures.after[k].powi(2);
        total += square;
        match windows.last_mut() {
            Some(w) if (w.0, w.1) == (log, at) => {
                w.2 += square;
                w.3 += 1.0;
            }
            _ => windows.push((log, at, square, 1.0)),
        }
    }
    let usual = signals::median(windows.iter().map(|w| w.2 / w.3).collect()).unwrap_or(0.0);
    if windows.len() < FEWEST || usual <= 0.0 || total <= 0.0 {
        return Vec::new();
    }
    let mut events: Vec<(usize, Range<usize>, f64)> = Vec::new();
    for (log, at, square, rows) in &windows {
        if square / rows < TIMES * usual {
            continue;
        }
        match events.last_mut() {
            Some(e) if e.0 == *log && e.1.end + 1 >= *at => {
                e.1.end = at + 1;
                e.2 += square;
            }
            _ => events.push((*log, *at..at + 1, *square)),
        }
    }
    let owned: f64 = events.iter().map(|e| e.2).sum();
    let time: usize = events.iter().map(|e| e.1.len()).sum();
    let few = events.len() <= EVENTS && (time as f64) < OWN.1 * windows.len() as f64;
    if !few || owned < OWN.0 * total {
        return Vec::new();
    }
    events
        .into_iter()
        .map(|(log, span, square)| (log, span.start as f64 * width..span.end as f64 * width, square / total))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::steady::noise;
    use super::*;

    /// What is left of two logs of 50 s, with so much more in some windows of one second.
    fn pictures(wild: &[(usize, usize)]) -> Pictures {
        let place = |log: usize, k: usize| (log, k as f64 * 0.05, 1000 * log + k);
        let rows: Vec<(usize, f64, usize)> = (0..2).flat_map(|log| (0..1000).map(move |k| place(log, k))).collect();
        let size = |log: usize, t: f64| if wild.contains(&(log, t as usize)) { 40.0 } else { 1.0 };
        Pictures {
            time: rows.iter().map(|r| r.1).collect(),
            log: rows.iter().map(|r| r.0).collect(),
            after: rows.iter().map(|r| size(r.0, r.1) * noise(r.2)).collect(),
            ..Pictures::default()
        }
    }

    #[test]
    fn one_bad_second_owns_the_error_and_what_comes_again_does_not() {
        assert_eq!(seconds(&pictures(&[]), |_| true), []);
        let one = seconds(&pictures(&[(1, 27)]), |_| true);
        let [(log, span, share)] = &one[..] else { panic!("{one:?}") };
        assert!(*log == 1 && span.contains(&27.5) && span.end - span.start < 2.0 && *share > 0.8, "{one:?}");
        // Of a log that only judges nothing is taken.
        assert_eq!(seconds(&pictures(&[(1, 27)]), |log| log == 0), []);
        // Five events are no accident, and belong to the machine.
        assert_eq!(seconds(&pictures(&[(0, 5), (0, 15), (0, 25), (1, 10), (1, 30)]), |_| true), []);
    }
}
