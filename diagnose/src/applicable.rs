//! Which effects of the library can be suspects for this bench, before anything is fitted.

use identify::{FitProblem, Record, RecordedCurrent, rate_against_angle};
use plant::{EffectId, Given, Kind, Model, RateFault, Role};

/// Whether at least one record of the bench can show the effect.
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

/// Whether the measured angle clears the gyroscope of this fault. The gyroscope's reading is compared with the
/// derivative of the angle, without any model of the motion. A fault that does not show there would, in a fit,
/// only absorb what the model lacks. `plain_fault` is the number of standard errors at which a fault counts
/// as shown. Returns `false` for other effects, and where the comparison is not possible.
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

/// Powers of the angle whose torque terms (constant, linear, cubic) together can fit any smooth torque that
/// depends on the angle, whatever its cause (a stop, a magnet). All three together fit a curve and
/// explain nothing.
const POWER_SERIES: [u32; 3] = [0, 1, 3];

/// Whether adding the effect would complete [`POWER_SERIES`], whichever of its terms the model has.
pub fn completes_series(model: &Model, effect: EffectId) -> bool {
    let with = model.with(effect);
    let has = |power: &u32| {
        let mut powers = with.effects().iter().map(|one| one.info().angle_power);
        powers.any(|own| own == Some(*power))
    };
    let own = effect.info().angle_power;
    own.is_some_and(|own| POWER_SERIES.contains(&own)) && POWER_SERIES.iter().all(has)
}

/// Whether an effect replaces one that the model has.
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
        // A zero of its own for each log is a constant, too.
        let zero = EffectId::AngleZero;
        let half = Model::base().with(zero).with(EffectId::BodyCableSpring);
        assert!(completes_series(&half, EffectId::BodySofteningSpring));
        assert!(!completes_series(&Model::base(), EffectId::AngleOffset));
    }
}
