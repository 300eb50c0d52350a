//! Where labels stand, so that none covers another label or a point that has one.
//!
//! The one idea: labels are placed one after the other, each at the best of a fixed set of places around its
//! point: first beside it, then farther off with a line that leads to it. What may never happen (two texts
//! over each other, a text over a labelled point) forbids a place; what is only unpleasant (a text over a
//! nameless point or a curve) costs. No chance, no iteration: the same figure has the same places.

/// A rectangle on the page \[px\]: left, top, right, bottom.
pub type Rect = [f64; 4];

/// Whether two rectangles share area.
pub fn overlap(a: &Rect, b: &Rect) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

fn inside(r: &Rect, (x, y): (f64, f64)) -> bool {
    x > r[0] && x < r[2] && y > r[1] && y < r[3]
}

/// A text that wants a place beside a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wanted {
    /// The point \[px\].
    pub at: (f64, f64),
    /// Width and height of the text \[px\].
    pub size: (f64, f64),
}

/// The place that a text was given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placed {
    /// The text's rectangle.
    pub rect: Rect,
    /// From the point's mark to the rectangle, where that is farther than a glance.
    pub leader: Option<[(f64, f64); 2]>,
}

/// Distances from a point to its text that are tried \[px\].
const DISTANCES: [f64; 10] = [8.0, 11.0, 16.0, 24.0, 34.0, 46.0, 60.0, 78.0, 100.0, 130.0];
/// Directions that are tried, the most pleasant first: right, left, above, below, then between.
const DIRECTIONS: [(f64, f64); 16] = [
    (1.0, 0.0),
    (-1.0, 0.0),
    (0.0, -1.0),
    (0.0, 1.0),
    (0.7, -0.7),
    (-0.7, -0.7),
    (0.7, 0.7),
    (-0.7, 0.7),
    (0.9, -0.4),
    (-0.9, -0.4),
    (0.9, 0.4),
    (-0.9, 0.4),
    (0.4, -0.9),
    (-0.4, -0.9),
    (0.4, 0.9),
    (-0.4, 0.9),
];
/// A text this far from its point needs a line that leads to it \[px\].
const GLANCE: f64 = 9.0;
/// Room that is kept around a labelled point \[px\].
const POINT: f64 = 6.5;

/// Places texts within `frame`, in their order of importance. `taken` is forbidden to them all; every point of
/// `crowd` that a text covers costs. `None` where there was no place left.
pub fn place(wanted: &[Wanted], frame: Rect, taken: &[Rect], crowd: &[(f64, f64)]) -> Vec<Option<Placed>> {
    let mut boxes: Vec<Rect> = taken.to_vec();
    let mut leaders: Vec<[(f64, f64); 2]> = Vec::new();
    let around = |(x, y): (f64, f64)| [x - POINT, y - POINT, x + POINT, y + POINT];
    let points: Vec<Rect> = wanted.iter().map(|w| around(w.at)).collect();
    let one = |w: &Wanted| {
        let mut best: Option<(f64, Placed)> = None;
        for (near, distance) in DISTANCES.into_iter().enumerate() {
            for (rank, direction) in DIRECTIONS.into_iter().enumerate() {
                let placed = candidate(w, direction, distance);
                let r = &placed.rect;
                let within = r[0] >= frame[0] && r[1] >= frame[1] && r[2] <= frame[2] && r[3] <= frame[3];
                if !within || boxes.iter().any(|b| overlap(b, r)) || points.iter().any(|p| overlap(p, r)) {
                    continue;
                }
                let covered = crowd.iter().filter(|p| inside(r, **p)).count();
                let struck = leaders.iter().filter(|l| crosses(l, r)).count();
                let strikes = placed.leader.map_or(0, |l| {
                    boxes.iter().filter(|b| crosses(&l, b)).count()
                        + points.iter().zip(wanted).filter(|(p, o)| o.at != w.at && crosses(&l, p)).count()
                        + leaders.iter().filter(|other| meet(&l, other)).count()
                });
                let cost = 9.0 * covered as f64
                    + 150.0 * (struck + strikes) as f64
                    + 1.0 * distance
                    + 0.5 * rank as f64
                    + if near > 1 { 12.0 } else { 0.0 };
                if best.as_ref().is_none_or(|(least, _)| cost < *least) {
                    best = Some((cost, placed));
                }
            }
        }
        let placed = best.map(|(_, placed)| placed);
        if let Some(p) = &placed {
            boxes.push(p.rect);
            leaders.extend(p.leader);
        }
        placed
    };
    wanted.iter().map(one).collect()
}

/// The text's rectangle in a direction from its point.
fn candidate(w: &Wanted, (dx, dy): (f64, f64), distance: f64) -> Placed {
    let ((x, y), (width, height)) = (w.at, w.size);
    let (cx, cy) = (x + dx * distance, y + dy * distance);
    // The corner or side that looks at the point lies at the distance.
    let along = |d: f64, extent: f64| if d.abs() < 0.45 { -0.5 * extent } else { (d.signum() - 1.0) * 0.5 * extent };
    let (left, top) = (cx + along(dx, width), cy + along(dy, height));
    let rect = [left, top, left + width, top + height];
    let near = (x.clamp(rect[0], rect[2]), y.clamp(rect[1], rect[3]));
    let far = f64::hypot(near.0 - x, near.1 - y);
    let leader = (far > GLANCE).then(|| {
        let start = (x + (near.0 - x) * POINT / far, y + (near.1 - y) * POINT / far);
        [start, near]
    });
    Placed { rect, leader }
}

/// Whether a line crosses a rectangle's inside.
fn crosses([a, b]: &[(f64, f64); 2], r: &Rect) -> bool {
    // Clipping: the part of the line within the rectangle has a length.
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for (start, change, low, high) in [(a.0, b.0 - a.0, r[0], r[2]), (a.1, b.1 - a.1, r[1], r[3])] {
        if change.abs() < 1e-12 {
            if start <= low || start >= high {
                return false;
            }
            continue;
        }
        let (p, q) = ((low - start) / change, (high - start) / change);
        from = from.max(p.min(q));
        to = to.min(p.max(q));
    }
    to - from > 1e-9
}

/// Whether two lines cross.
fn meet([a, b]: &[(f64, f64); 2], [c, d]: &[(f64, f64); 2]) -> bool {
    let side = |p: (f64, f64), q: (f64, f64), r: (f64, f64)| (q.0 - p.0) * (r.1 - p.1) - (q.1 - p.1) * (r.0 - p.0);
    side(*a, *b, *c) * side(*a, *b, *d) < 0.0 && side(*c, *d, *a) * side(*c, *d, *b) < 0.0
}
