//! The wheel's speed and the drive.

use bench_files::{Drive, DriveKind, LineCalibration, WheelSpeedSensor};
use codegen::hardware::{EncoderSpec, HardwareSpec, WINDOW_MAX, WheelSensor};
use codegen::spec::{PwmDrive, VoltageDrive};

use super::{DIFFER, HardwareError, Work};
use crate::numbers::significant;

/// A converter shows only one direction of rotation if its largest speed in the other direction is below this share of
/// its largest speed.
const ONE_WAY: f64 = 0.05;

/// The line of the wheel's sensor, with the ends of its range.
pub(super) struct WheelLine {
    pub(super) sensor: WheelSensor,
    pub(super) slope: f64,
    pub(super) offset: f64,
    pub(super) low: i32,
    pub(super) high: i32,
}

/// Speed at which the motor is switched off, relative to the stated largest speed.
const LARGEST_SHARE: f64 = 1.05;

impl Work<'_> {
    pub(super) fn wheel_speed(
        &mut self,
        drive: Option<&PwmDrive>,
    ) -> Result<Option<WheelLine>, HardwareError> {
        let stated = self.stated.and_then(|stated| stated.wheel_speed.as_ref());
        let is_converter = matches!(stated, Some(WheelSpeedSensor::Converter { .. }) | None);
        if !is_converter && self.calibration.wheel_speed.is_some() {
            self.warnings.push(
                "[calibration.wheel_speed] is the line of a converter, but [hardware.wheel_speed] states another \
                 sensor: the line is not used; remove the one that is wrong"
                    .to_owned(),
            );
        }
        match stated {
            Some(WheelSpeedSensor::Driver {
                scale,
                largest_rad_s,
            }) => self.driver(*scale, *largest_rad_s, drive).map(Some),
            Some(WheelSpeedSensor::Encoder {
                counts_per_turn,
                bits,
                window,
                largest_rad_s,
            }) => {
                let encoder = EncoderSpec {
                    counts_per_turn: *counts_per_turn,
                    bits: *bits,
                    window: *window,
                };
                self.wheel_encoder(encoder, *largest_rad_s, drive).map(Some)
            }
            Some(WheelSpeedSensor::Converter { .. }) | None => self.converter_line(),
        }
    }

    fn driver(
        &mut self,
        scale: f64,
        largest_rad_s: Option<f64>,
        drive: Option<&PwmDrive>,
    ) -> Result<WheelLine, HardwareError> {
        let end = ends(scale, i16::MAX.into(), largest_rad_s, drive)?;
        self.registers.push(format!(
            "wheel speed: the driver's signed 16-bit word, {} rad/s per unit; saturated from {end} units on, {} rad/s",
            significant(scale, 6),
            significant(f64::from(end) * scale.abs(), 6)
        ));
        Ok(WheelLine {
            sensor: WheelSensor::Driver,
            slope: scale,
            offset: 0.0,
            low: -end,
            high: end,
        })
    }

    fn wheel_encoder(
        &mut self,
        encoder: EncoderSpec,
        largest_rad_s: Option<f64>,
        drive: Option<&PwmDrive>,
    ) -> Result<WheelLine, HardwareError> {
        let window = encoder.window;
        if window > WINDOW_MAX {
            return Err(HardwareError::NotEmitted(format!(
                "[hardware.wheel_speed] window = {window}: the emitted module allows at most {WINDOW_MAX} samples, \
                 because the speed is late by half the window; state a shorter window"
            )));
        }
        let slope = encoder.rad_s_per_count(self.sample_time_s);
        let end = ends(slope, encoder.most_counts(), largest_rad_s, drive)?;
        self.registers.push(format!(
            "wheel speed: encoder counts 0 to {}, {} a turn, turned over {window} samples: {} rad/s per count, {} s \
             late; saturated from {} rad/s on",
            encoder.wrap() - 1,
            significant(encoder.counts_per_turn, 6),
            significant(slope, 4),
            significant(0.5 * f64::from(window) * self.sample_time_s, 4),
            significant(f64::from(end) * slope.abs(), 6)
        ));
        Ok(WheelLine {
            sensor: WheelSensor::Encoder(encoder),
            slope,
            offset: 0.0,
            low: -end,
            high: end,
        })
    }

    fn converter_line(&mut self) -> Result<Option<WheelLine>, HardwareError> {
        let thesis = HardwareSpec::thesis_bench();
        let calibrated = self.calibration.wheel_speed;
        let stated = match self.stated.and_then(|stated| stated.wheel_speed.as_ref()) {
            Some(WheelSpeedSensor::Converter {
                slope,
                offset,
                low,
                high,
            }) => Some((slope.zip(*offset), i32::from(*low), i32::from(*high))),
            _ => None,
        };
        let what = "[hardware.wheel_speed]";
        let example = "kind = \"converter\" with slope, offset, low, high; or kind = \"encoder\" with counts_per_turn, \
                       bits, window; or kind = \"driver\" with scale";
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

    fn converter(&mut self, slope: f64, offset: f64, low: i32, high: i32) -> WheelLine {
        let speed = |count: i32| slope * f64::from(count) + offset;
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
        WheelLine {
            sensor: WheelSensor::Converter,
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
                "[calibration.wheel_speed] has a slope of {} rad/s per count, whose sign is opposite to the \
                 expected one: the wheel's speed would be fed back reversed; calibrate the converter again, \
                 or state the slope with this sign under [hardware.wheel_speed]",
                significant(found.slope, 4)
            )));
        }
        if let Some(stated) = stated
            && !(1.0 / DIFFER..=DIFFER).contains(&(found.slope / stated))
        {
            self.warnings.push(format!(
                "[calibration.wheel_speed] has a slope of {} rad/s per count, but [hardware.wheel_speed] states \
                 {}: the calibrated slope is used",
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
            // The zero of a timer with another number of bits lies at another duty.
            let off = f64::from(drive.duty_zero) - f64::from(thesis.duty_zero);
            if off.abs() > (DIFFER - 1.0) * f64::from(thesis.counts()) {
                return Err(HardwareError::Contradiction(format!(
                    "the duty at zero current is {} by [calibration.current], but {} on the bench of the \
                     thesis: the timer is another one, and the preset does not know its range; state \
                     [hardware.drive] with bits, duty_zero, duty_low, duty_high",
                    drive.duty_zero, thesis.duty_zero
                )));
            }
            self.registers.push(drive_register(&drive));
            return Ok(Some(drive));
        };
        if let DriveKind::Voltage {
            supply_v,
            winding_ohm,
        } = stated.kind
        {
            return self.voltage_drive(stated, supply_v, winding_ohm);
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
                     current ({} and {} A per count): with the wrong one, the motor would push the wrong way; \
                     flywheel bring-up finds the right one",
                    significant(1.0 / line.slope, 4),
                    significant(stated, 4)
                )));
            }
            if !(1.0 / DIFFER..=DIFFER).contains(&ratio) {
                self.warnings.push(format!(
                    "[calibration.current] has {} A per count, but [hardware.drive] states {}: the calibrated \
                     value is used",
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
                "the duty at zero current is {zero} by [calibration.current], but {stated} by \
                 [hardware.drive]: the calibrated duty is used"
            ));
        }
        if !(low < zero && zero < high) {
            return Err(HardwareError::Contradiction(format!(
                "the duty at zero current, {zero}, must lie between duty_low = {low} and \
                 duty_high = {high} of [hardware.drive]"
            )));
        }
        Ok(Some(PwmDrive {
            bits: stated.bits,
            duty_zero: zero,
            duty_low: low,
            duty_high: high,
            amperes_per_count: slope,
            voltage: None,
        }))
    }

    /// A voltage drive. The firmware passes the duty to the drive as a voltage. If duties are not stated, zero volts
    /// lie in the middle of the timer's range, and its ends are ± the supply voltage.
    fn voltage_drive(
        &mut self,
        stated: &Drive,
        supply_v: f64,
        winding_ohm: f64,
    ) -> Result<Option<PwmDrive>, HardwareError> {
        let Some(back_emf_v_s) = self.torque_constant else {
            self.missing.push(
                "torque_constant in N m/A, which is also the back-EMF of a motor behind a voltage drive (it follows \
                 from masses and lengths under [known])"
                    .to_owned(),
            );
            return Ok(None);
        };
        let most = ((1_u32 << stated.bits) - 1) as u16;
        let calibrated = self.calibration.duty;
        let zero = match calibrated {
            Some(line) => line.offset.round().clamp(0.0, f64::from(most)) as u16,
            None => stated.duty_zero.unwrap_or(most / 2 + 1),
        };
        let reach = zero.min(most - zero);
        let low = stated.duty_low.unwrap_or(zero - reach);
        let high = stated.duty_high.unwrap_or(zero + reach);
        if !(low < zero && zero < high) {
            return Err(HardwareError::Contradiction(format!(
                "the duty at 0 V, {zero}, must lie between duty_low = {low} and duty_high = {high} of [hardware.drive]"
            )));
        }
        let counts = f64::from((zero - low).min(high - zero));
        let volts_per_count = match (calibrated, stated.amperes_per_count) {
            // The calibration was made at standstill, where V = R i.
            (Some(line), _) => winding_ohm / line.slope,
            (None, Some(stated)) => stated,
            (None, None) => supply_v / counts,
        };
        if !(volts_per_count.is_finite() && volts_per_count != 0.0) {
            return Err(HardwareError::Contradiction(
                "[calibration.current] has a slope of zero".to_owned(),
            ));
        }
        // The number of counts within the supply voltage.
        let within = (supply_v / volts_per_count.abs() * (1.0 + 1e-12)).floor();
        let within = within.clamp(0.0, f64::from(u16::MAX)) as u16;
        if within == 0 {
            return Err(HardwareError::Contradiction(format!(
                "one count of [hardware.drive], {} V, is more than its supply_voltage; correct supply_voltage, \
                 bits or the calibration of the current",
                significant(volts_per_count.abs(), 4)
            )));
        }
        let drive = PwmDrive {
            bits: stated.bits,
            duty_zero: zero,
            duty_low: low.max(zero.saturating_sub(within)),
            duty_high: high.min(zero.saturating_add(within)),
            amperes_per_count: volts_per_count / winding_ohm,
            voltage: Some(VoltageDrive {
                volts_per_count,
                supply_v,
                winding_ohm,
                back_emf_v_s,
            }),
        };
        self.registers.push(format!(
            "drive: voltage, duty {} to {} of {} bits, {} at 0 V, {} V per count; V = {} Ohm u + {} V s/rad \
             w, at most \
             {} V",
            drive.duty_low,
            drive.duty_high,
            drive.bits,
            drive.duty_zero,
            significant(volts_per_count, 6),
            significant(winding_ohm, 6),
            significant(back_emf_v_s, 6),
            significant(supply_v, 6)
        ));
        Ok(Some(drive))
    }
}

/// The count from which on the wheel's speed counts as unknown. It lies at 105 % of the largest speed, but not beyond
/// the end of the sensor's range. The largest speed is the stated one, or else the speed at which the back-EMF equals
/// the supply of a voltage drive.
fn ends(
    rad_s_per_count: f64,
    sensor_end: i32,
    largest_rad_s: Option<f64>,
    drive: Option<&PwmDrive>,
) -> Result<i32, HardwareError> {
    let of_drive = drive.and_then(|drive| drive.voltage);
    let of_drive = of_drive.map(|voltage| voltage.supply_v / voltage.back_emf_v_s);
    let Some(largest) = largest_rad_s.or(of_drive) else {
        return Ok(sensor_end);
    };
    let counts = (LARGEST_SHARE * largest / rad_s_per_count.abs()).floor();
    if counts < 2.0 {
        return Err(HardwareError::Contradiction(format!(
            "[hardware.wheel_speed]: one count is {} rad/s, too coarse for a wheel that turns at {} rad/s at most; \
             correct the scale, use a longer window, or an encoder with more counts per turn",
            significant(rad_s_per_count.abs(), 4),
            significant(largest, 4)
        )));
    }
    Ok(counts.min(f64::from(sensor_end)) as i32)
}

/// The drive of `preset` with the calibrated line from current to duty.
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
