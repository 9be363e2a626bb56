//! The whole step: the duty, for any sensor readings.

#[cfg(not(voltage_drive))]
use generated::constants::{DUTY_LINE, ZERO_CURRENT};
#[cfg(voltage_drive)]
use generated::constants::{DUTY_PLANE, ZERO_CURRENT};
use generated::{Controller, Duty, Sample, Status};

/// The smallest and the largest duty.
#[cfg(not(voltage_drive))]
const DUTY_ENDS: (i32, i32) = (DUTY_LINE.low, DUTY_LINE.high);
#[cfg(voltage_drive)]
const DUTY_ENDS: (i32, i32) = (DUTY_PLANE.low, DUTY_PLANE.high);

/// Claim `step-total`: the duty is within the drive's ends, and that of zero current unless the
/// controller runs.
///
/// # Panics
/// If the claim does not hold for these readings.
pub fn duty_within_limits(controller: &mut Controller, sample: &Sample, is_armed: bool) {
    if is_armed {
        controller.arm();
    } else {
        controller.disarm();
    }
    let may_flow = controller.status() == Status::Running;
    let Duty(duty) = controller.step(sample);
    assert!(
        (DUTY_ENDS.0..=DUTY_ENDS.1).contains(&i32::from(duty)),
        "the duty is beyond its limits"
    );
    assert!(
        may_flow || duty == ZERO_CURRENT,
        "a current while not running"
    );
    assert!(
        controller.status() == Status::Running || duty == ZERO_CURRENT,
        "a current after a trip"
    );
}
