//! The encoder on the pivot that shows the body.

use bench_files::AngleSensor;
use codegen::hardware::{BodyEncoder, EncoderSpec, WINDOW_MAX};

use super::{HardwareError, Work};
use crate::numbers::significant;

/// Largest rate that is shown, rad/s: 2000 °/s, as by the gyroscopes of other benches. A body that falls from upright
/// swings through below with twice its rate constant, 20 rad/s for that of the thesis.
const LARGEST_RATE_RAD_S: f64 = 34.906_585;

/// Share of the largest current from which the change by one count of the rate is told.
const COARSE_SHARE: f64 = 0.25;

impl Work<'_> {
    /// The encoder that shows the body; `None` where gyroscope and accelerometer do.
    pub(super) fn body_encoder(&mut self) -> Result<Option<BodyEncoder>, HardwareError> {
        let stated = self.stated.and_then(|stated| stated.angle.as_ref());
        let Some(&AngleSensor::Encoder {
            counts_per_turn,
            bits,
            zero,
        }) = stated
        else {
            return Ok(None);
        };
        let needs = self.needs;
        let mut encoder = EncoderSpec {
            counts_per_turn,
            bits,
            window: 1,
        };
        encoder.window = needs.window(encoder.rad_per_count());
        let wraps = f64::from(encoder.wrap()) / counts_per_turn.abs();
        if wraps < 1.0 {
            return Err(HardwareError::Contradiction(format!(
                "[hardware.angle]: a count of {bits} bits begins again before the {} counts of a turn are over: \
                 one count would stand for several angles",
                significant(counts_per_turn.abs(), 6)
            )));
        }
        if wraps.fract() != 0.0 {
            self.warnings.push(format!(
                "[hardware.angle]: the count begins again after {} turns, which is not a whole number: \
                 after that many turns in one direction, the body is upright at another count; keep the body \
                 within half of that, or restart the controller",
                significant(wraps, 6)
            ));
        }
        if self
            .stated
            .is_some_and(|stated| stated.gyroscope.is_some() || stated.accelerometer.is_some())
        {
            self.warnings.push(
                "[hardware.angle] is an encoder: gyroscope and accelerometer are not used"
                    .to_owned(),
            );
        }
        let rate_rad_s = encoder.rad_s_per_count(self.sample_time_s).abs();
        let share = needs.rate_gain.abs() * rate_rad_s / needs.current_limit_a;
        let late_s = 0.5 * f64::from(encoder.window) * self.sample_time_s;
        if share > COARSE_SHARE {
            self.warnings.push(format!(
                "[hardware.angle]: one count of the rate changes the current by {} of its limit, and the \
                 motor will rattle; \
                 an encoder with more counts a turn, or another sample time, would be better",
                significant(share, 2)
            ));
        }
        self.registers.push(format!(
            "body angle: encoder counts 0 to {}, {} a turn, {zero} upright: {} rad per count",
            encoder.wrap() - 1,
            significant(counts_per_turn, 6),
            significant(encoder.rad_per_count().abs(), 4)
        ));
        self.registers.push(format!(
            "body rate: the encoder's turn over {} samples (at most {WINDOW_MAX}): {} rad/s per count, \
             which changes the current by \
             {} A; {} s late, where the loop tolerates {} s",
            encoder.window,
            significant(rate_rad_s, 4),
            significant(share * needs.current_limit_a, 2),
            significant(late_s, 4),
            significant(needs.delay_margin_s, 3)
        ));
        Ok(Some(BodyEncoder {
            encoder,
            zero,
            largest_rate_rad_s: LARGEST_RATE_RAD_S,
        }))
    }
}
