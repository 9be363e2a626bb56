//! The open loop over frequency: what Bode's and Nyquist's plots show.
//!
//! L(e^{jωT}) of [`crate::margins`], broken at the plant's input and seen at the samples. The closed loop is stable
//! when L encircles −1 as often, counter-clockwise, as the open loop has unstable poles: once for the pendulum.

use nalgebra::{Complex, DMatrix};
use std::f64::consts::{PI, TAU};

use crate::controller::LinearController;
use crate::error::DesignError;
use crate::late::Lateness;
use crate::margins::OpenLoop;

/// The curve begins this many decades below half of the sampling frequency.
const DECADES: f64 = 4.5;

/// The open loop at one frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopFrequency {
    /// ω, rad/s.
    pub frequency_rad_s: f64,
    /// L(e^{jωT}).
    pub value: Complex<f64>,
    /// Its phase in rad, without jumps from one frequency to the next. The first phase lies between −2π and 0, because
    /// the loop lags.
    pub phase_rad: f64,
}

/// L at `count` frequencies, evenly spaced over the logarithm, up to half of the sampling frequency. The loop is
/// `controller` around ẋ = A x + B u (A n×n, B n×1), with a current that is late by `delay_s` (s).
///
/// # Errors
/// Wrong shapes, entries that are not finite, a sample time that is not positive, a negative delay.
pub fn frequency_response(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    controller: &LinearController,
    sample_time_s: f64,
    delay_s: f64,
    count: usize,
) -> Result<Vec<LoopFrequency>, DesignError> {
    let lateness = Lateness::of_current(delay_s);
    let open = OpenLoop::new(a, b, controller, sample_time_s, &lateness)?;
    let nyquist = PI / sample_time_s;
    let mut curve: Vec<LoopFrequency> = Vec::with_capacity(count);
    for index in 0..count {
        let share = index as f64 / (count.max(2) - 1) as f64;
        let frequency_rad_s = nyquist * 10f64.powf(DECADES * (share - 1.0));
        let Some(value) = open.at(frequency_rad_s) else {
            continue;
        };
        let mut phase_rad = value.arg();
        if phase_rad > 0.0 {
            phase_rad -= TAU;
        }
        if let Some(before) = curve.last() {
            phase_rad += TAU * ((before.phase_rad - phase_rad) / TAU).round();
        }
        curve.push(LoopFrequency {
            frequency_rad_s,
            value,
            phase_rad,
        });
    }
    Ok(curve)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::margins::margins_with_delay;
    use crate::thesis;

    fn curve(delay_s: f64, count: usize) -> Vec<LoopFrequency> {
        let controller = LinearController::state_feedback(&thesis::golden_gains());
        frequency_response(
            &thesis::a(),
            &thesis::b(),
            &controller,
            1e-3,
            delay_s,
            count,
        )
        .unwrap()
    }

    /// Nyquist's criterion: the whole curve, both halves and the point at zero, goes around −1 once, since the
    /// pendulum has one unstable pole and the loop is stable.
    #[test]
    fn the_curve_encircles_minus_one_once() {
        let controller = LinearController::state_feedback(&thesis::golden_gains());
        let (a, b) = (thesis::a(), thesis::b());
        let open = OpenLoop::new(&a, &b, &controller, 1e-3, &Lateness::default()).unwrap();
        let mut points = vec![open.at(0.0).unwrap()];
        points.extend(curve(0.0, 6000).iter().map(|at| at.value));
        let turn: f64 = points
            .windows(2)
            .map(|pair| ((pair[1] + 1.0) / (pair[0] + 1.0)).arg())
            .sum();
        // The upper half makes half of the turn.
        assert!((turn - PI).abs() < 1e-3, "{turn}");
    }

    /// A delay turns L by −ωδ and leaves its size, far below the sampling frequency.
    #[test]
    fn a_delay_only_turns() {
        let (without, with) = (curve(0.0, 300), curve(3.3e-3, 300));
        for (one, other) in without
            .iter()
            .zip(&with)
            .filter(|(one, _)| one.frequency_rad_s < 60.0)
        {
            assert!(
                (other.value.norm() / one.value.norm() - 1.0).abs() < 2e-3,
                "{one:?} {other:?}"
            );
            let turn = (other.value / one.value).arg() + 3.3e-3 * one.frequency_rad_s;
            assert!(turn.abs() < 2e-3, "{one:?} {turn}");
        }
    }

    /// The margins are read off the curve.
    #[test]
    fn the_curve_shows_the_margins() {
        let controller = LinearController::state_feedback(&thesis::golden_gains());
        for delay_s in [0.0, 1e-3, 4.4e-3] {
            let found =
                margins_with_delay(&thesis::a(), &thesis::b(), &controller, 1e-3, delay_s).unwrap();
            let curve = curve(delay_s, 20_000);
            let least = curve
                .iter()
                .map(|at| (at.value + 1.0).norm())
                .fold(f64::INFINITY, f64::min);
            assert!(
                (least / found.modulus_margin - 1.0).abs() < 1e-3,
                "{delay_s}: {least} {found:?}"
            );
            let crossing = curve
                .windows(2)
                .filter(|pair| (pair[0].value.norm() > 1.0) != (pair[1].value.norm() > 1.0))
                .map(|pair| (-pair[0].value).arg().abs())
                .fold(f64::INFINITY, f64::min);
            assert!(
                (crossing - found.phase_margin_rad).abs() < 5e-3,
                "{delay_s}: {crossing} {found:?}"
            );
        }
    }

    /// A delay that the loop already has shortens its delay margin by the same time.
    #[test]
    fn a_delay_comes_off_the_delay_margin() {
        let controller = LinearController::state_feedback(&thesis::golden_gains());
        let margin = |delay_s| {
            margins_with_delay(&thesis::a(), &thesis::b(), &controller, 1e-3, delay_s)
                .map(|found| found.delay_margin_s)
        };
        let whole = margin(0.0).unwrap();
        for delay_s in [0.4e-3, 1e-3, 2.7e-3] {
            assert!((margin(delay_s).unwrap() + delay_s - whole).abs() < 1e-8);
        }
        assert!(matches!(
            margin(1.01 * whole),
            Err(DesignError::UnstableLoop { .. })
        ));
        assert!(margin(-1e-3).is_err());
    }
}
