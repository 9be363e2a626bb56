//! Where the angle of a log is counted from.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use plant::Kind;

use super::{ExperimentPlan, find};
use crate::channel::Channel;
use crate::error::{Error, Problem};
use crate::log::{LoadReport, Log, Note};
use crate::toml_section::Section;

/// Range of an angle, in rad, that no free swing has about any zero (judgement: ten turns; a hand throws a body round
/// once or twice, and degrees within one turn cover 57).
const MOST_SWING_RAD: f64 = 10.0 * TAU;

impl ExperimentPlan {
    /// Checks where the angle is counted from. Balance logs stay around the upright position, free swings around the
    /// hanging one. An angle that is counted from elsewhere would make all later results wrong.
    pub(super) fn check_upright(
        &self,
        section: &Section,
        log: &mut Log,
        report: &mut LoadReport,
    ) -> Result<(), Error> {
        let expected = match self.kind {
            Kind::Balance => PI,
            Kind::FreeSwing => 0.0,
            Kind::SpinUp | Kind::Driven => return Ok(()),
        };
        let Some(angle) = &mut log.angle_rad else {
            return Ok(());
        };
        let (Some(median_rad), Some(low), Some(high)) = (
            quantile(angle, 0.5),
            quantile(angle, 0.01),
            quantile(angle, 0.99),
        ) else {
            return Ok(());
        };
        // No zero explains so wide a swing: the angle has another unit, and the data check says which.
        if self.kind == Kind::FreeSwing && high - low > MOST_SWING_RAD {
            return Ok(());
        }
        let key = if find(&self.offsets, Channel::Angle).is_some() {
            "offset"
        } else {
            "file"
        };
        // Around its equilibrium, the body does not turn over. (For a free swing, the data check finds the
        // factor by which the angle is too large.)
        let farthest_rad = (low - expected).abs().max((high - expected).abs());
        if self.kind == Kind::Balance && farthest_rad > 2.0 * TAU {
            return Err(section.error_at(
                key,
                Problem::AngleTooLarge {
                    kind: self.kind.name(),
                    farthest_rad,
                },
            ));
        }
        // A sensor with a range of one turn may report −π for upright.
        let turns = ((expected - median_rad) / TAU).round();
        let added_rad = turns * TAU;
        if (median_rad + added_rad - expected).abs() > FRAC_PI_2 {
            let old = find(&self.offsets, Channel::Angle).map_or(0.0, |offset| offset.value);
            return Err(section.error_at(
                key,
                Problem::WrongUpright {
                    kind: self.kind.name(),
                    median_rad,
                    has_unit: find(&self.units, Channel::Angle).is_some(),
                    offset: old + ((expected - median_rad) / PI).round() * PI,
                },
            ));
        }
        if turns != 0.0 {
            for value in angle.iter_mut() {
                *value += added_rad;
            }
            report.notes.push(Note::AngleTurned { added_rad });
        }
        Ok(())
    }
}

/// The value below which this share of the finite values lies.
fn quantile(values: &[f64], share: f64) -> Option<f64> {
    let mut finite: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    if finite.is_empty() {
        return None;
    }
    let index = ((finite.len() - 1) as f64 * share).round() as usize;
    Some(*finite.select_nth_unstable_by(index, f64::total_cmp).1)
}
