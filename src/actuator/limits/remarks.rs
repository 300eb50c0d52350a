//! What the limits of a candidate assume.

use super::heat::STANDSTILL;
use super::limit::{Asked, Remark};
use crate::actuator::candidate::{Candidate, hot_winding, hottest};

impl Candidate<'_> {
    /// What the limits that are asked of this candidate assume at every ratio.
    pub fn assumptions(&self, asked: &[Asked]) -> Vec<Remark> {
        let mut assumed = Vec::new();
        let resistance = match (
            hottest(self.motor, self.joint),
            hot_winding(self.motor, self.joint, self.robot.ambient),
        ) {
            (Some(_), _) => None,
            (None, Some(_)) => Some(
                "no highest winding temperature is known: its resistance is that of the temperature at which the continuous current settles, and the motion may heat it further for a while",
            ),
            (None, None) => {
                Some("no temperature of the winding is known: its resistance is taken at the reference temperature")
            }
        };
        let power = [("bus_power", self.robot.bus.power), ("bus_current", self.robot.bus.current)];
        let takes = power.into_iter().filter(|(_, bound)| bound.is_some()).map(|(name, _)| name);
        assumed.extend(std::iter::once("voltage").chain(takes).filter_map(|name| Some((name, resistance?))));
        let heat = |asked: &&Asked| super::heat::LIMITS.iter().any(|limit| limit.name == asked.limit.name);
        let stated = self.joint.limits.winding_temperature.is_some() && self.motor.max_winding_temperature.is_none();
        if let (true, Some(of_heat)) = (stated, asked.iter().find(heat)) {
            assumed.push((
                of_heat.limit.name,
                "the motor's own highest temperature is not known: only that of the requirement counts",
            ));
        }
        if asked.iter().any(|a| a.limit.name == STANDSTILL) && self.share_of_winding().is_none() {
            assumed.push((
                STANDSTILL,
                "which part of the thermal resistance is the winding's own is not known: all of it counts as the winding's",
            ));
        }
        assumed
    }
}
