//! The wheel's speed and the drive.

use bench_files::{Drive, DriveKind, LineCalibration, WheelSpeedSensor};
use codegen::hardware::HardwareSpec;
use codegen::spec::PwmDrive;

use super::{DIFFER, HardwareError, Work};
use crate::numbers::significant;

/// If the range of a converter ends closer to zero than this share of its highest speed, it shows only one direction of
/// rotation.
const ONE_WAY: f64 = 0.05;

/// The line of a converter, with the ends of its range.
pub(super) struct Converter {
    pub(super) slope: f64,
    pub(super) offset: f64,
    pub(super) low: u16,
    pub(super) high: u16,
}

impl Work<'_> {
    pub(super) fn wheel_speed(&mut self) -> Result<Option<Converter>, HardwareError> {
        let thesis = HardwareSpec::thesis_bench();
        let calibrated = self.calibration.wheel_speed;
        let stated = match self.stated.and_then(|stated| stated.wheel_speed.as_ref()) {
            None => None,
            Some(WheelSpeedSensor::Converter {
                slope,
                offset,
                low,
                high,
            }) => Some((slope.zip(*offset), *low, *high)),
            Some(WheelSpeedSensor::Encoder { .. } | WheelSpeedSensor::Driver { .. }) => {
                return Err(HardwareError::NotEmitted(
                    "[hardware.wheel_speed]: this generator emits kind = \"converter\" only"
                        .to_owned(),
                ));
            }
        };
        let what = "[hardware.wheel_speed]";
        let example = "kind = \"converter\" with slope, offset, low, high";
        let stated_line = stated.and_then(|(line, _, _)| line);
        let line = match (calibrated, stated_line) {
            (Some(found), stated) => {
                self.compare_slopes(&found, stated)?;
                Some((found.slope, found.offset))
            }
            (None, Some(line)) => Some(line),
            (None, None) => None,
        };
        let ends = stated.map(|(_, low, high)| (low, high));
        let (Some((slope, offset)), Some((low, high))) = (line, ends) else {
            let from_preset = match (line.is_some(), ends.is_some()) {
                (false, false) => "ADS1015 at an ESCON 24/2, rpm = 8.53108 count − 6594.5",
                (true, _) => "the converter ends at 0 and 1546 counts",
                (false, true) => "rpm = 8.53108 count − 6594.5",
            };
            if !self.fill(what, from_preset, example) {
                return Ok(None);
            }
            let (slope, offset) =
                line.unwrap_or((thesis.wheel_speed_per_count, thesis.wheel_speed_at_zero));
            let (low, high) = ends.unwrap_or((thesis.wheel_low, thesis.wheel_high));
            return Ok(Some(self.converter(slope, offset, low, high)));
        };
        Ok(Some(self.converter(slope, offset, low, high)))
    }

    fn converter(&mut self, slope: f64, offset: f64, low: u16, high: u16) -> Converter {
        let speed = |count: u16| slope * f64::from(count) + offset;
        let (first, last) = (speed(low), speed(high));
        let (least, most) = (first.min(last), first.max(last));
        if least > -ONE_WAY * most || most < -ONE_WAY * least {
            self.warnings.push(format!(
                "this converter cannot show a {} speed: between its ends it reads {} to {} rad/s, and \
                 the wheel turns both ways; shift its line so that it ends on both sides of zero",
                if least > -ONE_WAY * most { "negative" } else { "positive" },
                significant(least, 3),
                significant(most, 3)
            ));
        }
        self.registers.push(format!(
            "wheel speed: converter counts {low} to {high}, {} to {} rad/s",
            significant(first, 6),
            significant(last, 6)
        ));
        Converter {
            slope,
            offset,
            low,
            high,
        }
    }

    /// Compares the calibrated slope with the stated one: the sign must be equal, the size nearly so. Without a
    /// statement, a rising count must mean a rising speed.
    fn compare_slopes(
        &mut self,
        found: &LineCalibration,
        stated: Option<(f64, f64)>,
    ) -> Result<(), HardwareError> {
        let stated = stated.map(|(slope, _)| slope);
        if found.slope * stated.unwrap_or(1.0) <= 0.0 {
            return Err(HardwareError::Contradiction(format!(
                "[calibration.wheel_speed] has a slope of {} rad/s per count, against the sign that \
                 is expected: with it the wheel's speed would be fed back reversed; calibrate the \
                 converter again, or state the negative slope under [hardware.wheel_speed]",
                significant(found.slope, 4)
            )));
        }
        if let Some(stated) = stated
            && !(1.0 / DIFFER..=DIFFER).contains(&(found.slope / stated))
        {
            self.warnings.push(format!(
                "[calibration.wheel_speed] has {} rad/s per count, [hardware.wheel_speed] {}: the \
                 calibrated one is used",
                significant(found.slope, 4),
                significant(stated, 4)
            ));
        }
        Ok(())
    }

    pub(super) fn drive(&mut self) -> Result<Option<PwmDrive>, HardwareError> {
        let thesis = PwmDrive::THESIS_BENCH;
        let calibrated = self.calibration.duty;
        let Some(stated) = self.stated.and_then(|stated| stated.drive.as_ref()) else {
            let from_preset = match calibrated {
                None => "ESCON 24/2, 16-bit timer, duty 6554 to 58982 for ∓2.2 A",
                Some(_) => "16-bit timer, duty 6554 to 58982",
            };
            let example = "kind = \"current\" with bits, duty_zero, duty_low, duty_high, \
                           amperes_per_count";
            if !self.fill("[hardware.drive]", from_preset, example) {
                return Ok(None);
            }
            let drive = match calibrated {
                None => thesis,
                Some(line) => calibrated_drive(&line, &thesis)?,
            };
            // A timer with another number of bits has its zero elsewhere.
            let off = f64::from(drive.duty_zero) - f64::from(thesis.duty_zero);
            if off.abs() > (DIFFER - 1.0) * f64::from(thesis.counts()) {
                return Err(HardwareError::Contradiction(format!(
                    "[calibration.current] has no current at a duty of {}, the bench of the thesis at \
                     {}: that is another timer, whose range the preset does not know; state \
                     [hardware.drive] with bits, duty_zero, duty_low, duty_high",
                    drive.duty_zero, thesis.duty_zero
                )));
            }
            self.registers.push(drive_register(&drive));
            return Ok(Some(drive));
        };
        if let DriveKind::Voltage { .. } = stated.kind {
            return Err(HardwareError::NotEmitted(
                "[hardware.drive] kind = \"voltage\": this generator emits current drives only"
                    .to_owned(),
            ));
        }
        let drive = self.stated_drive(stated, calibrated, &thesis)?;
        if let Some(drive) = &drive {
            self.registers.push(drive_register(drive));
        }
        Ok(drive)
    }

    fn stated_drive(
        &mut self,
        stated: &Drive,
        calibrated: Option<LineCalibration>,
        thesis: &PwmDrive,
    ) -> Result<Option<PwmDrive>, HardwareError> {
        let mut duty = |key: &str, stated: Option<u16>, preset: u16| {
            stated.or_else(|| {
                let what = format!("{key} of [hardware.drive]");
                self.fill(&what, &preset.to_string(), "counts of the timer")
                    .then_some(preset)
            })
        };
        let low = duty("duty_low", stated.duty_low, thesis.duty_low);
        let high = duty("duty_high", stated.duty_high, thesis.duty_high);
        let zero_found = calibrated.map(|line| line.offset.round());
        let zero = match zero_found {
            Some(found) => Some(found.clamp(0.0, 65_535.0) as u16),
            None => duty("duty_zero", stated.duty_zero, thesis.duty_zero),
        };
        let slope = match calibrated {
            Some(line) => Some(1.0 / line.slope),
            None => stated.amperes_per_count.or_else(|| {
                let what = "amperes_per_count of [hardware.drive]";
                let example = "8.39246e-5: the range of the current over that of the duty";
                self.fill(what, "2.2 A over 26214 counts", example)
                    .then_some(thesis.amperes_per_count)
            }),
        };
        let (Some(low), Some(high), Some(zero), Some(slope)) = (low, high, zero, slope) else {
            return Ok(None);
        };
        if let (Some(line), Some(stated)) = (calibrated, stated.amperes_per_count) {
            let ratio = 1.0 / (line.slope * stated);
            if ratio <= 0.0 || ratio.is_nan() {
                return Err(HardwareError::Contradiction(format!(
                    "[calibration.current] and [hardware.drive] disagree about the sign of the \
                     current ({} and {} A per count): the motor would push the wrong way; flywheel \
                     bring-up settles which is right",
                    significant(1.0 / line.slope, 4),
                    significant(stated, 4)
                )));
            }
            if !(1.0 / DIFFER..=DIFFER).contains(&ratio) {
                self.warnings.push(format!(
                    "[calibration.current] has {} A per count, [hardware.drive] {}: the calibrated \
                     one is used",
                    significant(1.0 / line.slope, 4),
                    significant(stated, 4)
                ));
            }
        }
        if let Some(stated) = stated.duty_zero
            && f64::from(stated.abs_diff(zero))
                > (DIFFER - 1.0) * f64::from(high.abs_diff(low)) / 2.0
        {
            self.warnings.push(format!(
                "[calibration.current] has no current at a duty of {zero}, [hardware.drive] at \
                 {stated}: the calibrated one is used"
            ));
        }
        if !(low < zero && zero < high) {
            return Err(HardwareError::Contradiction(format!(
                "the duty without current, {zero}, does not lie between duty_low = {low} and \
                 duty_high = {high} of [hardware.drive]"
            )));
        }
        Ok(Some(PwmDrive {
            bits: stated.bits,
            duty_zero: zero,
            duty_low: low,
            duty_high: high,
            amperes_per_count: slope,
        }))
    }
}

/// `preset` with the calibrated line.
fn calibrated_drive(line: &LineCalibration, preset: &PwmDrive) -> Result<PwmDrive, HardwareError> {
    if !line.slope.is_finite() || line.slope == 0.0 {
        return Err(HardwareError::Contradiction(
            "[calibration.current] has a slope of zero".to_owned(),
        ));
    }
    Ok(PwmDrive {
        duty_zero: line.offset.round().clamp(0.0, 65_535.0) as u16,
        amperes_per_count: 1.0 / line.slope,
        ..*preset
    })
}

fn drive_register(drive: &PwmDrive) -> String {
    format!(
        "drive: duty {} to {} of a timer of {} bits, {} without current, {} A per count",
        drive.duty_low,
        drive.duty_high,
        drive.bits,
        drive.duty_zero,
        significant(drive.amperes_per_count, 6)
    )
}
