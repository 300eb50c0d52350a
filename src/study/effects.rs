//! What each parameter of the grid does to a joint's first choice.
//!
//! The one idea: points are compared that differ in one parameter alone. A plain mean over all points with
//! 24 V against all with 48 V would compare the easy cases that 24 V can do with all cases. So each value is
//! set against the parameter's first value at the same other values, and only where both have a design.
//! One requirement's points wait in a file, so that nothing grows with their number.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::StudyError;
use super::plan::Plan;

/// What a value does, against the first value of its parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Effect {
    /// The parameter.
    pub parameter: String,
    /// Its first value.
    pub reference: String,
    /// Its value.
    pub value: String,
    /// The joint.
    pub joint: String,
    /// Pairs of points with a design at both.
    pub pairs: u64,
    /// Geometric mean of the ratio of the first choice's losses.
    pub loss_ratio: Option<f64>,
    /// Pairs whose first choice is another motor.
    pub other_first_choice: u64,
    /// Pairs that have a design at this value only.
    pub gained: u64,
    /// Pairs that have a design at the first value only.
    pub lost: u64,
}

/// The first choice of one joint at one point: its loss, in watts, and its motor; not finite where there is none.
#[derive(Debug, Clone, Copy)]
pub struct FirstChoice {
    /// Loss \[W\].
    pub loss: f64,
    /// The motor's number in the catalogue.
    pub motor: u32,
}

impl FirstChoice {
    /// No design.
    pub const NONE: FirstChoice = FirstChoice { loss: f64::NAN, motor: u32::MAX };

    /// The robot could not be read: nothing is known of a design.
    const UNREAD: FirstChoice = FirstChoice { loss: f64::NAN, motor: u32::MAX - 1 };

    fn is_unread(&self) -> bool {
        self.motor == FirstChoice::UNREAD.motor
    }
}

/// Bytes of a first choice in the file.
const SIZE: usize = 12;

#[derive(Debug, Clone, Copy, Default)]
struct Tally {
    pairs: u64,
    logs: f64,
    with_loss: u64,
    other: u64,
    gained: u64,
    lost: u64,
}

/// Gathers the effects of a study's grid, requirement by requirement.
#[derive(Debug)]
pub struct Effects {
    path: PathBuf,
    file: BufWriter<File>,
    points: u64,
    written: u64,
    joints: Vec<String>,
    tallies: BTreeMap<(String, usize, usize), Tally>,
}

impl Effects {
    /// Begins, with a file in this folder.
    ///
    /// # Errors
    /// The file cannot be made.
    pub fn new(out: &Path, plan: &Plan) -> Result<Effects, StudyError> {
        let path = out.join(".effects.part");
        let file = File::options().read(true).write(true).create(true).truncate(true).open(&path);
        let file = file.map_err(|e| StudyError::file("write", &path, &e))?;
        let file = BufWriter::new(file);
        Ok(Effects { path, file, points: plan.points(), written: 0, joints: Vec::new(), tallies: BTreeMap::new() })
    }

    /// Adds a point of the current requirement: the first choice of each joint; none where the robot is
    /// broken. Points come in order; the last one closes the requirement.
    ///
    /// # Errors
    /// The file cannot be written or read.
    pub fn point(&mut self, plan: &Plan, joints: &[(String, FirstChoice)]) -> Result<(), StudyError> {
        if self.points < 2 {
            return Ok(());
        }
        if self.joints.is_empty() && !joints.is_empty() {
            self.joints = joints.iter().map(|(name, _)| name.clone()).collect();
            for _ in 0..self.written {
                self.write(&[])?;
            }
        }
        if !self.joints.is_empty() {
            self.write(joints)?;
        }
        self.written += 1;
        if self.written == self.points { self.close(plan) } else { Ok(()) }
    }

    fn write(&mut self, joints: &[(String, FirstChoice)]) -> Result<(), StudyError> {
        for k in 0..self.joints.len() {
            let choice = joints.get(k).map_or(FirstChoice::UNREAD, |(_, c)| *c);
            let written = self.file.write_all(&choice.loss.to_le_bytes());
            let written = written.and_then(|()| self.file.write_all(&choice.motor.to_le_bytes()));
            written.map_err(|e| StudyError::file("write", &self.path, &e))?;
        }
        Ok(())
    }

    /// Compares the points of a requirement, and begins the next.
    fn close(&mut self, plan: &Plan) -> Result<(), StudyError> {
        if !self.joints.is_empty() {
            self.compare(plan).map_err(|e| StudyError::file("read", &self.path, &e))?;
        }
        self.written = 0;
        self.joints.clear();
        let file = self.file.get_mut();
        let cleared = file.set_len(0).and_then(|()| file.seek(SeekFrom::Start(0)));
        cleared.map(|_| ()).map_err(|e| StudyError::file("write", &self.path, &e))
    }

    fn compare(&mut self, plan: &Plan) -> std::io::Result<()> {
        self.file.flush()?;
        let file = self.file.get_mut();
        let size = SIZE * self.joints.len();
        let mut read = |point: u64| -> std::io::Result<Vec<FirstChoice>> {
            let mut bytes = vec![0; size];
            file.seek(SeekFrom::Start(point * size as u64))?;
            file.read_exact(&mut bytes)?;
            let choice = |chunk: &[u8]| FirstChoice {
                loss: f64::from_le_bytes(chunk[..8].try_into().expect("eight bytes")),
                motor: u32::from_le_bytes(chunk[8..].try_into().expect("four bytes")),
            };
            Ok(bytes.chunks_exact(SIZE).map(choice).collect())
        };
        for parameter in 0..plan.grid.len() {
            let (stride, values) = (plan.stride(parameter), plan.grid[parameter].values.len() as u64);
            for first in (0..self.points).filter(|p| plan.value(parameter, *p) == 0) {
                let reference = read(first)?;
                for value in 1..values {
                    let choices = read(first + value * stride)?;
                    for ((name, a), b) in self.joints.iter().zip(&reference).zip(&choices) {
                        if a.is_unread() || b.is_unread() {
                            continue;
                        }
                        let tally = self.tallies.entry((name.clone(), parameter, value as usize)).or_default();
                        tally.add(a, b);
                    }
                }
            }
        }
        Ok(())
    }

    /// The effects, by parameter, value and joint.
    pub fn finish(self, plan: &Plan) -> Vec<Effect> {
        let mut effects: Vec<((usize, usize), Effect)> = Vec::new();
        for ((joint, parameter, value), tally) in &self.tallies {
            let of = &plan.grid[*parameter];
            let loss_ratio = (tally.with_loss > 0).then(|| (tally.logs / tally.with_loss as f64).exp());
            let effect = Effect {
                parameter: of.key.clone(),
                reference: of.values[0].clone(),
                value: of.values[*value].clone(),
                joint: joint.clone(),
                pairs: tally.pairs,
                loss_ratio,
                other_first_choice: tally.other,
                gained: tally.gained,
                lost: tally.lost,
            };
            effects.push(((*parameter, *value), effect));
        }
        effects.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.joint.cmp(&b.1.joint)));
        effects.into_iter().map(|(_, effect)| effect).collect()
    }
}

impl Drop for Effects {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.path);
    }
}

impl Tally {
    fn add(&mut self, a: &FirstChoice, b: &FirstChoice) {
        match (a.motor != u32::MAX, b.motor != u32::MAX) {
            (true, true) => {
                self.pairs += 1;
                self.other += u64::from(a.motor != b.motor);
                if a.loss > 0.0 && b.loss > 0.0 {
                    self.with_loss += 1;
                    self.logs += (b.loss / a.loss).ln();
                }
            }
            (true, false) => self.lost += 1,
            (false, true) => self.gained += 1,
            (false, false) => {}
        }
    }
}
