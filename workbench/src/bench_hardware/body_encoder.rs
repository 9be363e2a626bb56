//! The encoder on the pivot that measures the body's angle and rate.

use bench_files::AngleSensor;
use codegen::hardware::{BodyEncoder, EncoderSpec, WINDOW_MAX};

use super::{HardwareError, Work};
use crate::numbers::significant;

/// Largest rate that the word of the rate holds, rad/s: 2000 °/s, the range of the gyroscopes of other benches. A body
/// that falls from upright passes the hanging position at the rate 2 √(G/(Θ − j_w)), about 20 rad/s on the thesis
/// bench.
const LARGEST_RATE_RAD_S: f64 = 34.906_585;

/// If one count of the rate changes the current by more than this share of the largest current, a warning says so.
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
                "[hardware.angle]: a count of {bits} bits starts again at zero within the {} counts of a turn, so \
                 that one count stands for several angles; correct bits or counts_per_turn",
                significant(counts_per_turn.abs(), 6)
            )));
        }
        if wraps.fract() != 0.0 {
            self.warnings.push(format!(
                "[hardware.angle]: the count starts again at zero after {} turns, which is not a whole number: \
                 after that many turns in one direction, the body is upright at another count; keep the body \
                 within half of these turns, or restart the controller",
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
                "[hardware.angle]: one count of the rate changes the current by {} times its limit, and the \
                 motor will rattle; use an encoder with more counts per turn, or a longer sample time",
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
