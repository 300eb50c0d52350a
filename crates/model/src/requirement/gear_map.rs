//! A family of gears as a table over the ratio: what the gear is at any ratio between two rows.
//!
//! The one idea: between two rows 1/η, η_b, mass and limits go linearly in N², inertia at the input linearly in 1/N², torque
//! without load linearly in 1/N. Then the torque at the shaft keeps its powers of N, and each piece between two rows is the
//! same kind of program as a gear that does not change. Two rows of one ratio are a jump: at the ratio itself the first of
//! them holds, the second from just above it.

use super::gear::GearModel;
use crate::catalog::drag::Friction;

/// A requirement's ratio may lie beyond an end of the map by this share of itself: what rounding does to it.
const ROUNDING: f64 = 1e-9;

/// One row of a map. SI; torques at the output, inertia, torque without load and speed at the input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapRow {
    /// Reduction, N.
    pub ratio: f64,
    /// Mass \[kg\].
    pub mass: Option<f64>,
    /// Inertia at the input \[kg·m²\], J_g.
    pub inertia: Option<f64>,
    /// Input torque per load torque when the motor drives, 1/η.
    pub driving: Option<f64>,
    /// The same when the load drives, η_b.
    pub braking: Option<f64>,
    /// Torque without load at the input \[N·m\].
    pub no_load_torque: Option<f64>,
    /// Largest output torque \[N·m\].
    pub peak_torque: Option<f64>,
    /// Output torque that can be carried for ever \[N·m\].
    pub continuous_torque: Option<f64>,
    /// Largest input speed \[rad/s\].
    pub max_input_speed: Option<f64>,
}

/// The gear between two neighbouring rows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GearPiece {
    rows: [MapRow; 2],
    /// Whether it begins with a jump: its first ratio is not its own.
    after_jump: bool,
    /// Whether it ends with one: its last ratio is not its own.
    before_jump: bool,
}

/// A number of a piece as `constant + per_power · N^p`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// What no ratio changes.
    pub constant: f64,
    /// What goes with the power of the ratio.
    pub per_power: f64,
}

impl Line {
    /// A number that no ratio changes.
    pub fn fixed(constant: f64) -> Line {
        Line { constant, per_power: 0.0 }
    }

    /// Through two values at two places.
    fn through([a, b]: [f64; 2], [x, y]: [f64; 2]) -> Line {
        if a == b {
            return Line::fixed(a);
        }
        let per_power = (b - a) / (y - x);
        Line { constant: a - per_power * x, per_power }
    }
}

/// Between two values, with the share of the second.
fn between([a, b]: [f64; 2], share: f64) -> f64 {
    if a == b { a } else { a * (1.0 - share) + b * share }
}

impl GearPiece {
    /// Its first ratio; one that is its own, next to the row's where the piece begins with a jump.
    pub fn from(&self) -> f64 {
        if self.after_jump { self.rows[0].ratio.next_up() } else { self.rows[0].ratio }
    }

    /// Its last ratio; one that is its own, as the first.
    pub fn to(&self) -> f64 {
        if self.before_jump { self.rows[1].ratio.next_down() } else { self.rows[1].ratio }
    }

    fn both(&self, of: impl Fn(&MapRow) -> Option<f64>) -> Option<[f64; 2]> {
        Some([of(&self.rows[0])?, of(&self.rows[1])?])
    }

    /// A number that is linear in a power of the ratio between both rows; `None` where the map does not say it.
    fn line(&self, power: i32, of: impl Fn(&MapRow) -> Option<f64>) -> Option<Line> {
        Some(Line::through(self.both(of)?, self.rows.map(|row| row.ratio.powi(power))))
    }

    fn at(&self, ratio: f64, power: i32, of: impl Fn(&MapRow) -> Option<f64>) -> Option<f64> {
        let [x, y] = self.rows.map(|row| row.ratio.powi(power));
        Some(between(self.both(of)?, ((ratio.powi(power) - x) / (y - x)).clamp(0.0, 1.0)))
    }

    /// The gear at a ratio of the piece: what the map does not say is that of `base`.
    pub fn gear(&self, base: &GearModel, ratio: f64) -> GearModel {
        let in_square = |of: fn(&MapRow) -> Option<f64>| self.at(ratio, 2, of);
        let no_load = self.at(ratio, -1, |row| row.no_load_torque);
        let mass = in_square(|row| row.mass);
        GearModel {
            efficiency: in_square(|row| row.driving).map_or(base.efficiency, |per_load| 1.0 / per_load),
            backdrive_efficiency: in_square(|row| row.braking).unwrap_or(base.backdrive_efficiency),
            mass: mass.or(base.mass),
            mass_per_stage: base.mass_per_stage.filter(|_| mass.is_none()),
            inertia: self.at(ratio, -2, |row| row.inertia).unwrap_or(base.inertia),
            peak_torque: in_square(|row| row.peak_torque).or(base.peak_torque),
            continuous_torque: in_square(|row| row.continuous_torque).or(base.continuous_torque),
            max_input_speed: in_square(|row| row.max_input_speed).or(base.max_input_speed),
            no_load: Friction { coulomb: no_load.unwrap_or(base.no_load.coulomb), ..base.no_load },
            friction_at_rest: no_load.or(base.friction_at_rest),
            ..*base
        }
    }

    /// 1/η or η_b as it goes with N²: for what drives, and for what brakes.
    pub fn load(&self, base: &GearModel) -> [Line; 2] {
        let fixed = [1.0 / base.efficiency, base.backdrive_efficiency].map(Line::fixed);
        [self.line(2, |row| row.driving).unwrap_or(fixed[0]), self.line(2, |row| row.braking).unwrap_or(fixed[1])]
    }

    /// Inertia at the input \[kg·m²\] as it goes with 1/N².
    pub fn inertia(&self, base: &GearModel) -> Line {
        self.line(-2, |row| row.inertia).unwrap_or(Line::fixed(base.inertia))
    }

    /// Torque without load at the input \[N·m\] as it goes with 1/N.
    pub fn no_load(&self, base: &GearModel) -> Line {
        self.line(-1, |row| row.no_load_torque).unwrap_or(Line::fixed(base.no_load.coulomb))
    }

    /// Mass \[kg\] as it goes with N²; `None` where the map does not say it.
    pub fn mass(&self) -> Option<Line> {
        self.line(2, |row| row.mass)
    }
}

/// A family of gears by rows of rising ratio.
#[derive(Debug, Clone, PartialEq)]
pub struct GearMap {
    pieces: Vec<GearPiece>,
    /// The gears that it goes through, where it is that of a named family.
    points: Vec<FamilyPoint>,
    /// The name of that family.
    family: String,
}

/// A gear that a map goes through.
#[derive(Debug, Clone, PartialEq)]
pub struct FamilyPoint {
    /// Its ratio.
    pub ratio: f64,
    /// Its id.
    pub id: String,
}

/// Where a ratio lies in a named family.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FamilyPlace<'m> {
    /// At one of its points.
    At(&'m FamilyPoint),
    /// Between two.
    Between(&'m FamilyPoint, &'m FamilyPoint),
}

impl GearMap {
    /// Of rows of rising ratio, two of one ratio for a jump; all say the same numbers. `None` where they are less than two, do
    /// not rise, begin or end with a jump, or have three of one ratio.
    pub fn new(rows: &[MapRow]) -> Option<GearMap> {
        let is_jump = |k: usize| rows[k].ratio == rows[k + 1].ratio;
        let last = rows.len().checked_sub(2)?;
        let in_order = rows.windows(2).all(|pair| pair[0].ratio <= pair[1].ratio);
        let double = (0..last).any(|k| is_jump(k) && is_jump(k + 1));
        if !in_order || double || is_jump(0) || is_jump(last) {
            return None;
        }
        let pieces = (0..=last).filter(|k| !is_jump(*k)).map(|k| GearPiece {
            rows: [rows[k], rows[k + 1]],
            after_jump: k > 0 && is_jump(k - 1),
            before_jump: false,
        });
        Some(GearMap { pieces: pieces.collect(), points: Vec::new(), family: String::new() })
    }

    /// Of the points of a named family, by rising ratio: at each ratio of a point it is that gear. Between two the efficiencies are
    /// those of the worse of both, and all else is interpolated as between any two rows. `None` of less than two points.
    pub fn of_points(family: &str, points: &[(MapRow, String)]) -> Option<GearMap> {
        let itself = |row: MapRow| GearPiece { rows: [row, row], after_jump: false, before_jump: false };
        let worse = |[a, b]: [Option<f64>; 2], of: fn(f64, f64) -> f64| Some(of(a?, b?));
        let between = |a: MapRow, b: MapRow| {
            let driving = worse([a.driving, b.driving], f64::max);
            let braking = worse([a.braking, b.braking], f64::min);
            let rows = [a, b].map(|row| MapRow { driving, braking, ..row });
            GearPiece { rows, after_jump: true, before_jump: true }
        };
        let rises = points.windows(2).all(|pair| pair[0].0.ratio < pair[1].0.ratio);
        if points.len() < 2 || !rises {
            return None;
        }
        let mut pieces = vec![itself(points[0].0)];
        for pair in points.windows(2) {
            pieces.extend([between(pair[0].0, pair[1].0), itself(pair[1].0)]);
        }
        let points = points.iter().map(|(row, id)| FamilyPoint { ratio: row.ratio, id: id.clone() }).collect();
        Some(GearMap { pieces, points, family: family.into() })
    }

    /// Where a ratio lies among the points of a named family; `None` where it is none, or beyond its ends.
    pub fn place(&self, ratio: f64) -> Option<FamilyPlace<'_>> {
        let same = |point: &FamilyPoint| (ratio / point.ratio - 1.0).abs() <= ROUNDING;
        if let Some(point) = self.points.iter().find(|point| same(point)) {
            return Some(FamilyPlace::At(point));
        }
        let above = self.points.iter().position(|point| ratio < point.ratio)?;
        Some(FamilyPlace::Between(self.points.get(above.checked_sub(1)?)?, &self.points[above]))
    }

    /// The points of its family; none where it has none.
    pub fn points(&self) -> &[FamilyPoint] {
        &self.points
    }

    /// The name of its family; empty where it has none.
    pub fn family(&self) -> &str {
        &self.family
    }

    /// Whether it is that of a named family.
    pub fn is_named(&self) -> bool {
        !self.points.is_empty()
    }

    /// The pieces, from the smallest ratio to the largest.
    pub fn pieces(&self) -> &[GearPiece] {
        &self.pieces
    }

    /// The smallest and the largest ratio.
    pub fn range(&self) -> (f64, f64) {
        (self.pieces[0].rows[0].ratio, self.pieces[self.pieces.len() - 1].to())
    }

    /// Whether it says anything of a ratio.
    pub fn covers(&self, ratio: f64) -> bool {
        let (first, last) = self.range();
        first * (1.0 - ROUNDING) <= ratio && ratio <= last * (1.0 + ROUNDING)
    }

    /// The gear at a ratio; at one that it does not cover that of its nearest row. What the map does not say is that of
    /// `base`.
    pub fn gear(&self, base: &GearModel, ratio: f64) -> GearModel {
        let piece = self.pieces.iter().find(|piece| ratio <= piece.to());
        let piece = piece.unwrap_or(&self.pieces[self.pieces.len() - 1]);
        let (first, last) = self.range();
        piece.gear(base, ratio.clamp(first, last))
    }

    /// Whether its rows say a number.
    pub fn says(&self, of: impl Fn(&MapRow) -> Option<f64>) -> bool {
        of(&self.pieces[0].rows[0]).is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(ratio: f64, driving: f64, inertia: f64) -> MapRow {
        MapRow {
            ratio,
            driving: Some(driving),
            braking: Some(2.0 - driving),
            inertia: Some(inertia),
            no_load_torque: Some(0.3 / ratio),
            mass: Some(ratio),
            peak_torque: None,
            continuous_torque: None,
            max_input_speed: None,
        }
    }

    #[test]
    fn rows_are_met_and_what_lies_between_goes_with_its_power() {
        let map = GearMap::new(&[row(2.0, 1.1, 4e-6), row(4.0, 1.3, 1e-6), row(4.0, 1.2, 3e-6), row(9.0, 1.25, 2e-6)]);
        let map = map.expect("rows that rise");
        let base = GearModel { peak_torque: Some(7.0), ..GearModel::IDEAL };
        for (ratio, driving, inertia) in [(2.0, 1.1, 4e-6), (4.0, 1.3, 1e-6), (9.0, 1.25, 2e-6)] {
            let gear = map.gear(&base, ratio);
            assert_eq!((1.0 / gear.efficiency, gear.inertia), (1.0 / (1.0 / driving), inertia));
            assert_eq!((gear.mass, gear.peak_torque), (Some(ratio), Some(7.0)));
        }
        // Just above a jump the second row holds; both rows of it have one torque without load.
        let above = map.gear(&base, 4.0_f64.next_up());
        assert!((above.efficiency * 1.2 - 1.0).abs() < 1e-12 && (above.inertia / 3e-6 - 1.0).abs() < 1e-12);
        assert_eq!(
            map.pieces().iter().map(|p| (p.from(), p.to())).collect::<Vec<_>>(),
            [(2.0, 4.0), (4.0_f64.next_up(), 9.0)]
        );
        let piece = &map.pieces()[0];
        let (n, gear) = (3.0, map.gear(&base, 3.0));
        let near = |a: f64, b: f64| assert!((a - b).abs() <= 1e-12 * b.abs(), "{a} {b}");
        let [driving, braking] = piece.load(&base);
        near(1.0 / gear.efficiency, driving.constant + driving.per_power * n * n);
        near(gear.backdrive_efficiency, braking.constant + braking.per_power * n * n);
        near(gear.inertia, piece.inertia(&base).constant + piece.inertia(&base).per_power / (n * n));
        near(gear.no_load.coulomb, 0.1);
        near(gear.no_load.coulomb, piece.no_load(&base).constant + piece.no_load(&base).per_power / n);
        near(gear.inertia, 4e-6 + (1e-6 - 4e-6) * (1.0 / 4.0 - 1.0 / 9.0) / (1.0 / 4.0 - 1.0 / 16.0));
        assert!(map.covers(9.0) && !map.covers(9.1) && !map.covers(1.9));
    }

    #[test]
    fn rows_that_make_no_map() {
        let ratios =
            |list: &[f64]| GearMap::new(&list.iter().map(|n| row(*n, 1.1, 1e-6)).collect::<Vec<_>>()).is_some();
        assert!(ratios(&[2.0, 3.0]) && ratios(&[2.0, 3.0, 3.0, 4.0]));
        for bad in
            [&[2.0][..], &[], &[3.0, 2.0], &[2.0, 2.0], &[2.0, 2.0, 3.0], &[2.0, 3.0, 3.0], &[2.0, 3.0, 3.0, 3.0, 4.0]]
        {
            assert!(!ratios(bad), "{bad:?}");
        }
    }
}
