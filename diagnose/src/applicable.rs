//! Which effects of the library are suspects at all, before anything is fitted.

use identify::{FitProblem, Record, RecordedCurrent, rate_against_angle};
use plant::{EffectId, Given, Kind, Model, RateFault, Role};

/// Whether any record of the bench can show the effect at all.
pub fn applicable(problem: &FitProblem, effect: EffectId) -> bool {
    let info = effect.info();
    // Without the distance between pivot and wheel an unbalance cannot be told for a body that moves. Gravity is
    // that of the earth where nothing else is said.
    let is_unknown =
        |(_, given): &(usize, Given)| *given != Given::Gravity && problem.given(*given).is_none();
    if info.given.iter().any(is_unknown) {
        return false;
    }
    problem.records.iter().any(|record| {
        let commanded = matches!(record.current, RecordedCurrent::Known(_));
        let sees = match info.role {
            Role::Body => record.kind != Kind::SpinUp,
            Role::Wheel => record.kind != Kind::FreeSwing,
            Role::Motor => {
                record.kind != Kind::FreeSwing
                    && commanded
                    && !(info.is_electrical && record.current_is_measured)
            }
            Role::Sensor => {
                let distorted = |output| record.channel(output).is_some();
                // Alone and undriven, a channel that comes late is one that begins at another time.
                let has_clock =
                    record.channels.len() > 1 || (commanded && record.kind != Kind::FreeSwing);
                info.senses.is_some_and(distorted) && (info.sensor_timing.is_none() || has_clock)
            }
        };
        sees && info.shows_in.contains(&record.kind)
    })
}

/// Whether the measured angle itself, without any model of the motion, speaks against this fault of the
/// gyroscope: what the model lacks would only be laid at its door. `plain_fault` is the number of standard
/// errors by which a fault must show.
pub fn is_cleared(records: &[&Record], effect: EffectId, plain_fault: f64) -> bool {
    let Some(found) = rate_against_angle(records) else {
        return false;
    };
    let (fault, std) = match effect.info().rate_fault {
        Some(RateFault::Scale) => (found.scale_error, found.scale_error_std),
        Some(RateFault::Bias) => (found.bias_rad_s, found.bias_std_rad_s),
        None => return false,
    };
    fault.abs() < plain_fault * std
}

/// The powers of the angle whose terms (a constant, a linear and a cubic torque) together fit any smooth torque
/// that depends on the angle, whatever it comes from (a stop, a magnet); that is a curve through the
/// measurements and no explanation of them.
const POWER_SERIES: [u32; 3] = [0, 1, 3];

/// Whether an effect would complete the series in a model, whatever of it stood there before.
pub fn completes_series(model: &Model, effect: EffectId) -> bool {
    let with = model.with(effect);
    let has = |power: &u32| {
        let mut powers = with.effects().iter().map(|one| one.info().angle_power);
        powers.any(|own| own == Some(*power))
    };
    let own = effect.info().angle_power;
    own.is_some_and(|own| POWER_SERIES.contains(&own)) && POWER_SERIES.iter().all(has)
}

/// Whether an effect takes the place of one that the model has.
pub fn refines(effect: EffectId, model: &Model) -> bool {
    let present = model.effects().iter();
    let names = effect.info().replaces;
    present
        .map(|one| one.name())
        .any(|name| names.contains(&name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_series_is_not_completed_step_by_step() {
        let half = Model::base()
            .with(EffectId::AngleOffset)
            .with(EffectId::BodyCableSpring);
        assert!(completes_series(&half, EffectId::BodySofteningSpring));
        assert!(!completes_series(&half, EffectId::BodyQuadraticDrag));
        assert!(!completes_series(&Model::base(), EffectId::AngleOffset));
    }
}
