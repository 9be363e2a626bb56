//! The rows of a record as CSV.

use std::f64::consts::{PI, TAU};
use std::fmt::Write;

use plant::Kind;

use super::run::Row;
use super::words::Words;

/// A log with the standard columns and two more: the number of frames lost before the row, and the controller's status.
pub(super) fn log(kind: Kind, rows: &[Row], words: &Words) -> String {
    let mut text = String::from(
        "time_s,angle_rad,rate_rad_s,wheel_speed_rad_s,current_A,lost_frames,status\n",
    );
    for row in rows {
        let from_upright_rad = words.angle_from_upright_rad(&row.frame);
        let angle_rad = match kind {
            // In these experiments the body is upright, because the controller arms only there. The word of the angle
            // jumps by a turn where the body hangs.
            Kind::Balance | Kind::SpinUp => PI + from_upright_rad,
            _ => hanging_angle_rad(from_upright_rad),
        };
        // Writing to a string does not fail.
        let _ = writeln!(
            text,
            "{:.6},{angle_rad:.7},{:.6},{:.5},{:.6},{},{}",
            row.time_s,
            words.rate_rad_s(&row.frame),
            words.wheel_speed_rad_s(&row.frame),
            words.current_a(&row.frame),
            row.lost_before,
            row.frame.status,
        );
    }
    text
}

/// A recording of raw counts for bring-up, with the columns that `[bring_up]` needs on this bench.
pub(super) fn raw_counts(rows: &[Row], has_pivot_encoder: bool) -> String {
    let of_body = match has_pivot_encoder {
        true => "body",
        false => "gx,gy,gz,ax,ay,az",
    };
    let mut text = format!("{of_body},wheel,duty,time_s,lost_frames\n");
    for row in rows {
        let frame = &row.frame;
        let [gx, gy, gz] = frame.gyro;
        let [ax, ay, az] = frame.accel;
        let body = match has_pivot_encoder {
            true => gx.cast_unsigned().to_string(),
            false => format!("{gx},{gy},{gz},{ax},{ay},{az}"),
        };
        let _ = writeln!(
            text,
            "{body},{},{},{:.6},{}",
            frame.wheel, frame.duty, row.time_s, row.lost_before
        );
    }
    text
}

/// The body's angle within ±π of hanging, rad.
pub(super) fn hanging_angle_rad(from_upright_rad: f64) -> f64 {
    let angle_rad = PI + from_upright_rad;
    angle_rad - TAU * (angle_rad / TAU).round()
}

#[cfg(test)]
mod tests {
    use serial_frame::Telemetry;

    use super::*;

    #[test]
    fn hanging_is_zero_from_either_side() {
        for (from_upright, angle) in [(0.0, PI), (-PI, 0.0), (3.0, 3.0 - PI), (-3.0, PI - 3.0)] {
            let got = hanging_angle_rad(from_upright);
            assert!(
                ((got - angle + PI).rem_euclid(TAU) - PI).abs() < 1e-12,
                "{got}"
            );
            assert!(got.abs() <= PI);
        }
    }

    /// The frame holds the 16 bits of the count of an encoder on the pivot. Read as an i16, the largest count is −1.
    #[test]
    fn the_count_of_the_pivot_is_the_column_that_bring_up_reads() {
        let none = serial_frame::NO_FIELD;
        let frame = Telemetry {
            gyro: [-1, none, none],
            accel: [none; 3],
            wheel: 773,
            duty: 32_768,
            ..Telemetry::default()
        };
        let row = Row {
            time_s: 0.001,
            frame,
            lost_before: 2,
        };
        assert_eq!(
            raw_counts(&[row], true),
            "body,wheel,duty,time_s,lost_frames\n65535,773,32768,0.001000,2\n"
        );
    }
}
