//! Pushes on the body that no column records: found, located, sized, and kept out of the fit.
//!
//! The torque on the body follows from the measurements through the first equation of motion
//! (thesis 1.26), f = Θ α̈ + j_w φ̈ + r_b α̇ + G sin α, and, with the motor's torque taken from the
//! command instead of the wheel, from f = (Θ − j_w) α̈ + r_b α̇ + G sin α + τ i − r_w φ̇. Both are
//! evaluated in the weak form: multiplied by a short bump and integrated by parts, so that no
//! measurement is differentiated; the result is f smoothed by the bump, whose integral is that of f.
//! The second has the lower noise, but an error of the motor's model (a lag, a dead zone) looks like
//! a push in it; the first knows no motor. A push is what both show.

use plant::{GRAVITY_TORQUE, Kind, TORQUE_CONSTANT, TOTAL_INERTIA, WHEEL_INERTIA};

use crate::record::{Output, Record};
use crate::start::angle_samples;

/// Half-width of the bump in s: shorter than a push by hand.
const HALF_BUMP_S: f64 = 0.025;
/// Fewest samples on either side of the bump's centre.
const HALF_BUMP_SAMPLES: usize = 4;
/// Threshold in robust standard deviations of the torque estimate. In a minute of log there are
/// some thousand independent values; six Gaussian standard deviations are exceeded by one in 5e8.
const THRESHOLD: f64 = 6.0;
/// A push ends where the torque estimate falls below this many standard deviations,
const FOOT: f64 = 2.0;
/// or below this fraction of its peak: what remains beyond is 1.4 % of the impulse of a Gaussian
/// push, while a friction that the model lacks would go on adding for as long as the body moves.
const FOOT_OF_PEAK: f64 = 0.05;
/// Length of the running median that is taken as the torque's slow part (offsets, drift), in s.
const BASELINE_S: f64 = 2.0;

/// A push on the body.
#[derive(Clone, Debug, PartialEq)]
pub struct Push {
    /// When it acted: the centre of its torque, s.
    pub time_s: f64,
    /// Its impulse ∫ f dt in N m s, positive in the direction of positive angle.
    pub impulse_nms: f64,
    /// Standard error of the impulse from the noise of the sensors, N m s.
    pub impulse_std_nms: f64,
    /// Largest torque of the smoothed estimate, N m.
    pub peak_nm: f64,
    /// First and last instant at which it acted, s.
    pub span_s: (f64, f64),
}

/// Numbers of the model that the search needs, in SI units.
#[derive(Clone, Copy, Debug)]
pub struct PushModel {
    /// Θ, j_w, G, τ (positions of the parameter vector).
    pub base: [f64; 4],
    /// r_b in N m s/rad.
    pub body_friction: f64,
    /// r_w in N m s/rad.
    pub wheel_friction: f64,
}

/// The smoothed torque on the body at every sample, by the momentum of body and wheel (first) and
/// by the command (second); NaN at the ends and where samples are missing.
fn torque_on_body(record: &Record, model: &PushModel) -> Option<(Option<Vec<f64>>, Vec<f64>)> {
    let angle = angle_samples(record)?;
    let rate = record.channel(Output::Rate).map(|c| &c.samples);
    let speed = record.channel(Output::WheelSpeed).map(|c| &c.samples);
    if record.current_a.len() != record.len() || record.len() < 4 * HALF_BUMP_SAMPLES {
        return None;
    }
    let n = record.len();
    let mean_step_s = (record.time_s[n - 1] - record.time_s[0]) / (n - 1) as f64;
    let half = ((HALF_BUMP_S / mean_step_s).round() as usize).max(HALF_BUMP_SAMPLES);
    if n <= 2 * half + 1 {
        return None;
    }
    let [total, wheel, gravity, torque] = [
        model.base[TOTAL_INERTIA],
        model.base[WHEEL_INERTIA],
        model.base[GRAVITY_TORQUE],
        model.base[TORQUE_CONSTANT],
    ];
    let mut momentum = speed.map(|_| vec![f64::NAN; n]);
    let mut command = vec![f64::NAN; n];
    for centre in half..n - half {
        let (a, b) = (record.time_s[centre - half], record.time_s[centre + half]);
        let (mut area, mut by_momentum, mut by_command) = (0.0, 0.0, 0.0);
        for k in centre - half..centre + half {
            // Midpoints: the bump and its derivatives vanish at both ends.
            let (t, step) = (
                0.5 * (record.time_s[k] + record.time_s[k + 1]),
                record.time_s[k + 1] - record.time_s[k],
            );
            let mid = |series: &[f64]| 0.5 * (series[k] + series[k + 1]);
            let (u, v) = (t - a, b - t);
            let bump = u * u * v * v;
            let slope = 2.0 * u * v * (v - u);
            area += bump * step;
            // ∫ψ α̈ = −∫ψ̇ α̇ = ∫ψ̈ α
            let (acceleration, rate) = match rate {
                Some(rate) => (-slope * mid(rate), bump * mid(rate)),
                None => {
                    let curvature = 2.0 * (v * v - 4.0 * u * v + u * u);
                    (curvature * mid(&angle), -slope * mid(&angle))
                }
            };
            let own = gravity * bump * mid(&angle).sin() + model.body_friction * rate;
            let spin = speed.map_or(0.0, |speed| mid(speed));
            by_momentum += step * (total * acceleration - wheel * slope * spin + own);
            // A command holds from its sample to the next.
            let current = if record.current_is_measured {
                mid(&record.current_a)
            } else {
                record.current_a[k]
            };
            by_command += step
                * ((total - wheel) * acceleration
                    + own
                    + bump * (torque * current - model.wheel_friction * spin));
        }
        if let Some(momentum) = &mut momentum {
            momentum[centre] = by_momentum / area;
        }
        command[centre] = by_command / area;
    }
    Some((momentum, command))
}

/// Subtracts the running median and returns the robust standard deviation of what is left.
fn centre(series: &mut [f64], time_s: &[f64]) -> f64 {
    let n = series.len();
    let step_s = (time_s[n - 1] - time_s[0]) / (n - 1).max(1) as f64;
    let half = ((0.5 * BASELINE_S / step_s) as usize).max(8);
    // The median moves slowly: it is computed at intervals and interpolated as a staircase.
    let stride = (half / 8).max(1);
    let original = series.to_vec();
    let median = |mut values: Vec<f64>| -> Option<f64> {
        values.retain(|value| value.is_finite());
        if values.is_empty() {
            return None;
        }
        let middle = values.len() / 2;
        Some(*values.select_nth_unstable_by(middle, f64::total_cmp).1)
    };
    for block in (0..n).step_by(stride) {
        let from = block.saturating_sub(half);
        let to = (block + half).min(n);
        if let Some(base) = median(original[from..to].to_vec()) {
            for value in &mut series[block..(block + stride).min(n)] {
                *value -= base;
            }
        }
    }
    let absolute: Vec<f64> = series.iter().map(|value| value.abs()).collect();
    // 1.4826 makes the median absolute deviation of a Gaussian its standard deviation.
    1.4826 * median(absolute).unwrap_or(0.0)
}

/// The pushes in a balance log; none in other kinds.
pub fn find_pushes(record: &Record, model: &PushModel) -> Vec<Push> {
    if record.kind != Kind::Balance {
        return vec![];
    }
    let Some((mut momentum, mut command)) = torque_on_body(record, model) else {
        return vec![];
    };
    let time_s = &record.time_s;
    let command_std = centre(&mut command, time_s).max(1e-12);
    let momentum_std = momentum
        .as_mut()
        .map(|series| centre(series, time_s).max(1e-12));
    let n = command.len();
    let step_s = |k: usize| {
        if k + 1 < n {
            time_s[k + 1] - time_s[k]
        } else {
            time_s[k] - time_s[k - 1]
        }
    };
    let mut pushes = vec![];
    let mut k = 0;
    while k < n {
        // A NaN compares as false and is passed over.
        if !(command[k].abs() > THRESHOLD * command_std) {
            k += 1;
            continue;
        }
        let sign = command[k].signum();
        let end = (k..n)
            .find(|&k| !(sign * command[k] > FOOT * command_std))
            .unwrap_or(n);
        let top = (k..end)
            .max_by(|&a, &b| (sign * command[a]).total_cmp(&(sign * command[b])))
            .unwrap_or(k);
        let foot = (FOOT * command_std).max(FOOT_OF_PEAK * sign * command[top]);
        let above = |k: usize| sign * command[k] > foot;
        let (mut from, mut to) = (top, top);
        while from > 0 && above(from - 1) {
            from -= 1;
        }
        while to + 1 < n && above(to + 1) {
            to += 1;
        }
        let sum = |series: &[f64]| -> f64 { (from..=to).map(|k| series[k] * step_s(k)).sum() };
        let impulse = sum(&command);
        let moment: f64 = (from..=to)
            .map(|k| command[k] * step_s(k) * time_s[k])
            .sum();
        let peak = command[top];
        let span = time_s[to] - time_s[from] + 2.0 * HALF_BUMP_S;
        // Values closer than a bump are one value: the noise of the sum.
        let independent = (span / HALF_BUMP_S).max(1.0);
        let std_of = |std: f64| std * span / independent.sqrt();
        let confirmed = match (&momentum, momentum_std) {
            (Some(series), Some(std)) => {
                let other = sum(series);
                let ratio = other / impulse;
                other.abs() > 3.0 * std_of(std) && (0.5..2.0).contains(&ratio)
            }
            _ => true,
        };
        if confirmed {
            pushes.push(Push {
                time_s: moment / impulse,
                impulse_nms: impulse,
                impulse_std_nms: std_of(command_std),
                peak_nm: peak,
                span_s: (time_s[from] - HALF_BUMP_S, time_s[to] + HALF_BUMP_S),
            });
        }
        // What is left of this push beyond its foot is no push of its own.
        k = end.max(to + 1);
    }
    pushes
}

/// Gives weight 0 to every window of `window_s` that a push touches, and weight 1 to all others.
pub fn leave_out(record: &mut Record, pushes: &[Push], window_s: f64) {
    for window in record.windows(window_s) {
        let (from, to) = (
            record.time_s[window.start],
            record.time_s[window.end.saturating_sub(1)],
        );
        let touched = pushes
            .iter()
            .any(|push| push.span_s.0 <= to && push.span_s.1 >= from);
        record.weight[window].fill(if touched { 0.0 } else { 1.0 });
    }
}
