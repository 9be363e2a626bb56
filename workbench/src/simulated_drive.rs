//! The drive of the simulation: the one that `[hardware.drive]` states, or that of the thesis.

use codegen::spec::PwmDrive;
use plant::{EffectId, Model};
use simulate::Actuator;

use crate::control_design::ControlDesign;

/// The drive between command and current: the ends of its range, and the current of one count of its timer. A voltage
/// drive has no limit of its own for the current; [`supplied`] has its supply.
pub(crate) fn actuator_of(drive: &PwmDrive) -> Actuator {
    let zero = f64::from(drive.duty_zero);
    let step_a = drive.amperes_per_count.abs();
    let forward = f64::from(drive.duty_high) - zero;
    let backward = zero - f64::from(drive.duty_low);
    let range_a = step_a * forward.min(backward);
    let limit_a = match drive.voltage {
        None => range_a,
        Some(voltage) => (voltage.supply_v / voltage.winding_ohm).max(range_a),
    };
    Actuator { limit_a, step_a }
}

/// The model and its parameters with the supply of a voltage drive: a fast wheel gets only the current that the supply
/// drives against the back-EMF. A model that has the effect `back-emf-limit` keeps its own supply.
pub(crate) fn supplied(model: &Model, values: &[f64], drive: &PwmDrive) -> (Model, Vec<f64>) {
    let limit = EffectId::BackEmfLimit;
    let Some(voltage) = drive.voltage.filter(|_| !model.has(limit)) else {
        return (model.clone(), values.to_vec());
    };
    let with = model.with(limit);
    let mut start = vec![0.0; with.parameter_count()];
    if let Some(at) = with.position(limit) {
        start[at] = voltage.supply_v;
        start[at + 1] = voltage.winding_ohm;
    }
    let values = identify::carry_over(model, values, &with, &start);
    (with, values)
}

impl ControlDesign {
    /// The drive that is stated, for runs that need nothing else of the hardware; that of the thesis if none can be
    /// read.
    pub(crate) fn drive_for_simulation(&self) -> PwmDrive {
        self.hardware_for_simulation()
            .map_or(PwmDrive::THESIS_BENCH, |hardware| hardware.drive)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use codegen::spec::VoltageDrive;
    use plant::TORQUE_CONSTANT;

    /// The supply drives (V − k_e w)/R at most.
    #[test]
    fn a_fast_wheel_gets_what_the_supply_leaves() {
        let drive = PwmDrive {
            amperes_per_count: 12.0 / 2.0 / 26_214.0,
            voltage: Some(VoltageDrive {
                volts_per_count: 12.0 / 26_214.0,
                supply_v: 12.0,
                winding_ohm: 2.0,
                back_emf_v_s: 0.03,
            }),
            ..PwmDrive::THESIS_BENCH
        };
        assert!((actuator_of(&drive).limit_a - 6.0).abs() < 1e-9);
        let base = Model::base();
        let mut plain = vec![1.0; base.parameter_count()];
        plain[TORQUE_CONSTANT] = 0.03;
        let (model, values) = supplied(&base, &plain, &drive);
        let at = model.position(EffectId::BackEmfLimit).expect("there");
        assert_eq!(values[at..at + 2], [12.0, 2.0]);
        assert_eq!(values[TORQUE_CONSTANT], 0.03);
    }

    #[test]
    fn a_current_drive_changes_no_model() {
        let drive = PwmDrive::THESIS_BENCH;
        let actuator = actuator_of(&drive);
        assert!((actuator.limit_a - 2.2).abs() < 1e-9, "{actuator:?}");
        let base = Model::base();
        let values = vec![1.0; base.parameter_count()];
        assert_eq!(supplied(&base, &values, &drive), (base, values));
    }
}
