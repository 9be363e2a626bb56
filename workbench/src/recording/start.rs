//! The time in a log at which its experiment begins.

use super::experiment::{Part, RecordedExperiment};
use super::log_text::hanging_angle_rad;
use super::run::Row;
use super::words::Words;

/// Smallest amplitude of a swing, rad: three degrees.
const SWING_MIN_RAD: f64 = 0.05;

/// The first time of the log to use, s; `None` for the whole log.
pub(super) fn of(part: &Part, rows: &[Row], words: &Words, notes: &mut Vec<String>) -> Option<f64> {
    match part.experiment {
        RecordedExperiment::FreeSwing => {
            let angles: Vec<f64> = rows
                .iter()
                .map(|row| hanging_angle_rad(words.angle_from_upright_rad(&row.frame)))
                .collect();
            let start = free_from(&angles);
            if start.is_none() {
                notes.push(
                    "no moment was found at which the hand let go of the body: look in the log for the \
                     beginning of the swing, and state it as from in bench.toml"
                        .to_owned(),
                );
            }
            start.map(|index| rows[index].time_s)
        }
        RecordedExperiment::CoastDown => {
            let rest = rows
                .iter()
                .position(|row| words.current_a(&row.frame) == 0.0)?;
            Some(rows[rest].time_s)
        }
        _ => None,
    }
}

/// The index of the first turning point after the body has swung through from its largest angle. By then the hand has
/// let go, wherever it did so.
fn free_from(angles_rad: &[f64]) -> Option<usize> {
    let largest = (0..angles_rad.len())
        .max_by(|a, b| angles_rad[*a].abs().total_cmp(&angles_rad[*b].abs()))?;
    if angles_rad[largest].abs() < SWING_MIN_RAD {
        return None;
    }
    let side = angles_rad[largest].signum();
    let crosses = |from: usize, side: f64| {
        (from..angles_rad.len()).find(|index| angles_rad[*index] * side < 0.0)
    };
    let through = crosses(largest, side)?;
    let back = crosses(through, -side)?;
    (through..back).max_by(|a, b| angles_rad[*a].abs().total_cmp(&angles_rad[*b].abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Held for a second at 0.5 rad, then a damped cosine of 10 rad/s.
    fn swing(index: usize) -> f64 {
        let t = index as f64 * 1e-3;
        match t {
            _ if t < 0.4 => 1.25 * t,
            _ if t < 1.0 => 0.5,
            _ => 0.5 * (-0.1 * (t - 1.0)).exp() * (10.0 * (t - 1.0)).cos(),
        }
    }

    #[test]
    fn the_swing_begins_at_the_first_turn_after_the_hand_let_go() {
        let angles: Vec<f64> = (0..5000).map(swing).collect();
        let begins = free_from(&angles).expect("a swing");
        // Half a period after the release, less the damping's share of a hundredth.
        let expected = 1.0 + std::f64::consts::PI / 10.0;
        assert!((begins as f64 * 1e-3 - expected).abs() < 3e-3, "{begins}");
    }

    #[test]
    fn a_body_that_hangs_still_or_is_held_has_no_swing() {
        assert_eq!(free_from(&[0.001; 100]), None);
        assert_eq!(free_from(&[0.4; 100]), None);
        assert_eq!(free_from(&[]), None);
    }
}
