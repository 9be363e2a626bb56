//! Pushes on the body that no column records: found, located, sized, and left out of the fit.
//!
//! A push is a torque on the body that the model lacks. [`super::residual_torque`] gives two estimates of it: from
//! the momentum of body and wheel, and from the command. The second has less noise, but an error of the motor's
//! model (a lag, a dead zone) looks like a push in it. The first does not involve the motor.
//! A push is reported if one estimate shows it and the other does not contradict it.
//!
//! In a log that is sampled more slowly than the controller responds, current and angle between two samples are
//! unknown. The model's torques of motor and gravity are then wrong by a large share, and the response to
//! every push looks like further pushes ("echoes"). In such a log, a push is reported only if it exceeds the shares of
//! motor and gravity that are missing over the whole log. The others are left out of the fit as well, but not
//! reported.

use nalgebra::{Matrix2, Vector2};
use plant::{GRAVITY_TORQUE, Kind, Model, TORQUE_CONSTANT};

use super::residual_torque::{MeasuredMotion, TorqueOn, residual_torque};
use crate::records::{BALANCE_WINDOW_S, Output, Record, half_samples, median};

/// Half-width of the bump in s; shorter than a push by hand.
const HALF_BUMP_S: f64 = 0.025;
/// Half-width of the bump in s for a log without a rate; about as long as a push by hand. There the angle is
/// differentiated twice, and the noise of the torque falls with the width to the power 5/2.
const HALF_BUMP_OF_ANGLE_S: f64 = 0.06;
/// Threshold in robust standard deviations of the torque estimate. A minute of log has about a thousand independent
/// values; a Gaussian value exceeds six standard deviations once in 5e8.
const THRESHOLD: f64 = 6.0;
/// A push ends where the torque estimate falls below this many standard deviations.
const FOOT: f64 = 2.0;
/// A push also ends where the estimate falls below this share of its peak. The cut loses 1.4 % of the impulse of a
/// Gaussian push; without it, a friction that the model lacks would add impulse as long as the body moves.
const FOOT_OF_PEAK: f64 = 0.05;
/// Length in s of the running median that is subtracted as the slow part of the torque (offsets, drift).
const BASELINE_S: f64 = 2.0;

/// A push on the body.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundPush {
    /// Time of the push, s: the centre of its torque.
    pub time_s: f64,
    /// Its impulse ∫ f dt in N m s, positive in the direction of positive angle.
    pub impulse_nms: f64,
    /// Standard error of the impulse from the noise of the sensors, N m s.
    pub impulse_std_nms: f64,
    /// Largest torque of the smoothed estimate, N m.
    pub peak_nm: f64,
    /// First and last instant of the push, s.
    pub span_s: (f64, f64),
}

/// The parameters of the model that the search needs, in SI units.
#[derive(Clone, Copy, Debug)]
pub struct PushModel {
    /// Θ, j_w, G, τ (positions of the parameter vector).
    pub base: [f64; 4],
    /// r_b in N m s/rad.
    pub body_friction: f64,
    /// r_w in N m s/rad.
    pub wheel_friction: f64,
}

impl PushModel {
    /// The parameters of a model; a friction that the model does not have is zero.
    pub fn of(model: &Model, values: &[f64]) -> PushModel {
        let friction = |name: &str| model.position_of(name).map_or(0.0, |at| values[at]);
        PushModel {
            base: [0, 1, 2, 3].map(|position| values[position]),
            body_friction: friction("body_viscous_friction"),
            wheel_friction: friction("wheel_viscous_friction"),
        }
    }
}

fn half_bump_s(record: &Record) -> f64 {
    match record.channel(Output::Rate) {
        Some(_) => HALF_BUMP_S,
        None => HALF_BUMP_OF_ANGLE_S,
    }
}

/// The smoothed torque on the body at every sample, N m: from the momentum of body and wheel (first) and from
/// the command (second). NaN at the ends and where samples are missing.
fn torque_on_body(record: &Record, model: &PushModel) -> Option<(Option<Vec<f64>>, Vec<f64>)> {
    if record.current_a.len() != record.len() || record.is_empty() {
        return None;
    }
    let half = half_samples(record, half_bump_s(record));
    let mut values = model.base.to_vec();
    values.extend([model.body_friction, model.wheel_friction]);
    let base = Model::base();
    let motion = MeasuredMotion::new(record, &[], &base, &values, half)?;
    let series = |on: TorqueOn| -> Option<Vec<f64>> {
        // All samples are used: those that a push spoils are the ones to be found.
        let found = residual_torque(record, &[], &motion, &base, &values, on, (half, 1))?;
        let mut series = vec![f64::NAN; record.len()];
        for (centre, torque) in found.centres.iter().zip(&found.torque_nm) {
            series[*centre] = *torque;
        }
        Some(series)
    };
    Some((series(TorqueOn::Body), series(TorqueOn::BodyByCommand)?))
}

/// Subtracts the running median, and returns the robust standard deviation of the rest.
fn centre(series: &mut [f64], time_s: &[f64]) -> f64 {
    let n = series.len();
    let step_s = (time_s[n - 1] - time_s[0]) / (n - 1).max(1) as f64;
    let half = ((0.5 * BASELINE_S / step_s) as usize).max(8);
    // The median changes slowly. It is computed at intervals and held between.
    let stride = (half / 8).max(1);
    let original = series.to_vec();
    for block in (0..n).step_by(stride) {
        let from = block.saturating_sub(half);
        let to = (block + half).min(n);
        if let Some(base) = median(original[from..to].iter().copied()) {
            for value in &mut series[block..(block + stride).min(n)] {
                *value -= base;
            }
        }
    }
    // The factor 1.4826 converts the median absolute deviation of a Gaussian to its standard deviation.
    1.4826 * median(series.iter().map(|value| value.abs())).unwrap_or(0.0)
}

/// Whether a log has too few samples to follow the controller's response to a push: windows of
/// [`BALANCE_WINDOW_S`] hold fewer samples than a window needs.
pub(crate) fn is_slow(record: &Record) -> bool {
    // `Record::windows` makes no window shorter than this.
    let least = record.windows(0.0).first().map_or(0, |window| window.len());
    record.kind == Kind::Balance && samples_in_window(record) < least as f64
}

/// Number of samples in [`BALANCE_WINDOW_S`].
pub(crate) fn samples_in_window(record: &Record) -> f64 {
    let span_s = record.time_s.last().unwrap_or(&0.0) - record.time_s.first().unwrap_or(&0.0);
    BALANCE_WINDOW_S * (record.len().max(1) - 1) as f64 / span_s.max(1e-300)
}

/// The pushes in a balance log; none in other kinds. In a slow log, only pushes that exceed the possible error of motor
/// and gravity while they acted.
pub fn find_pushes(record: &Record, model: &PushModel) -> Vec<FoundPush> {
    let mut pushes = find_disturbances(record, model);
    if !pushes.is_empty()
        && is_slow(record)
        && let Some((_, missing_nm)) = torque_on_body(record, model)
    {
        let own_nm = own_torques_nm(record, model);
        let shares = wrong_shares(&missing_nm, &own_nm);
        pushes.retain(|push| {
            push.impulse_nms.abs() > own_impulse_nms(record, &own_nm, &shares, push)
        });
    }
    pushes
}

/// The torques of motor and gravity at every sample of a record, N m. The current is taken relative to the median of the
/// log, which contains the sensor's offset and the current that holds the body where it leans.
fn own_torques_nm(record: &Record, model: &PushModel) -> Vec<Vector2<f64>> {
    let middle = median(record.current_a.iter().copied()).unwrap_or(0.0);
    let angle = record.channel(Output::Angle);
    // A missing sample gives no information about the torque.
    let known = |torque: f64| if torque.is_finite() { torque } else { 0.0 };
    (0..record.len())
        .map(|k| {
            let motor = model.base[TORQUE_CONSTANT] * (record.current_a[k] - middle);
            let gravity = angle.map_or(0.0, |angle| {
                model.base[GRAVITY_TORQUE] * angle.samples[k].sin()
            });
            Vector2::new(known(motor), known(gravity))
        })
        .collect()
}

/// The shares of motor and gravity that best explain a missing torque, by least squares: the relative errors of
/// both in this log. Real pushes increase the shares, so fewer pushes are reported.
fn wrong_shares(missing_nm: &[f64], own_nm: &[Vector2<f64>]) -> Vector2<f64> {
    let (mut normal, mut right) = (Matrix2::zeros(), Vector2::zeros());
    let rows = missing_nm.iter().zip(own_nm);
    for (missing, own) in rows.filter(|(missing, _)| missing.is_finite()) {
        normal += own * own.transpose();
        right += own * *missing;
    }
    let shares = normal
        .try_inverse()
        .map_or(Vector2::repeat(1.0), |inverse| inverse * right);
    shares.abs()
}

/// Impulse in N m s that the errors of motor and gravity may have caused while a push acted.
fn own_impulse_nms(
    record: &Record,
    own_nm: &[Vector2<f64>],
    shares: &Vector2<f64>,
    push: &FoundPush,
) -> f64 {
    let first = record.time_s.partition_point(|time| *time < push.span_s.0);
    let end = record.time_s.partition_point(|time| *time <= push.span_s.1);
    (first.max(1)..end)
        .map(|k| {
            let size = (own_nm[k - 1].abs() + own_nm[k].abs()).dot(shares);
            0.5 * size * (record.time_s[k] - record.time_s[k - 1])
        })
        .sum()
}

/// All disturbances in a balance log that look like a push, including the echoes in a slow log.
pub(crate) fn find_disturbances(record: &Record, model: &PushModel) -> Vec<FoundPush> {
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
    let mut pushes = pushes_in(record, &command, command_std, |push, sum| {
        match (&momentum, momentum_std) {
            (Some(series), Some(std)) => {
                let error = push.std_of(std).hypot(push.std_of(command_std));
                agrees(sum(series), push.impulse_nms, error)
            }
            _ => true,
        }
    });
    // Where the command is unreliable (cogging of the wheel moves it all the time), the momentum alone may show a push,
    // or show it better. It counts if the command does not contradict it. Slow logs are excluded: there, every push
    // has echoes.
    if let (Some(series), Some(std), false) = (&momentum, momentum_std, is_slow(record)) {
        let others = pushes_in(record, series, std, |push, sum| {
            let error = push.std_of(std).hypot(push.std_of(command_std));
            agrees(sum(&command), push.impulse_nms, error)
        });
        for other in others {
            let overlaps = |push: &FoundPush| {
                push.span_s.0 <= other.span_s.1 && other.span_s.0 <= push.span_s.1
            };
            let is_known = pushes
                .iter()
                .any(|push| overlaps(push) && push.impulse_std_nms <= other.impulse_std_nms);
            if !is_known {
                pushes.retain(|push| !overlaps(push));
                pushes.push(other);
            }
        }
        pushes.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    }
    pushes
}

/// Whether another estimate of an impulse agrees with it: within a factor of two or, if noise hides the push in the other
/// estimate, without a contradiction.
fn agrees(other_nms: f64, impulse_nms: f64, error_nms: f64) -> bool {
    (0.5..2.0).contains(&(other_nms / impulse_nms))
        || (error_nms > impulse_nms.abs() && (other_nms - impulse_nms).abs() < 3.0 * error_nms)
}

/// A push as one of the torque estimates shows it.
struct Shown {
    impulse_nms: f64,
    /// Duration of the push, s, and the number of bumps of the estimate in it.
    span_s: f64,
    independent: f64,
}

impl Shown {
    /// Standard error of an impulse over the same duration, from the standard deviation of the torque. Values closer than
    /// one bump count as one value.
    fn std_of(&self, torque_std_nm: f64) -> f64 {
        torque_std_nm * self.span_s / self.independent.sqrt()
    }
}

/// The pushes in a centred estimate of the torque on the body (N m) with standard deviation `std_nm`, if `is_confirmed`
/// accepts them. That function receives the push, and a function that integrates any other estimate over the same time.
fn pushes_in(
    record: &Record,
    torque_nm: &[f64],
    std_nm: f64,
    is_confirmed: impl Fn(&Shown, &dyn Fn(&[f64]) -> f64) -> bool,
) -> Vec<FoundPush> {
    let time_s = &record.time_s;
    let half_s = half_bump_s(record);
    let n = torque_nm.len();
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
        // A NaN compares as false: it is skipped here, and ends a push below.
        let exceeds = torque_nm[k].abs() > THRESHOLD * std_nm;
        if !exceeds {
            k += 1;
            continue;
        }
        let sign = torque_nm[k].signum();
        let end = (k..n)
            .take_while(|&k| sign * torque_nm[k] > FOOT * std_nm)
            .last()
            .map_or(k, |last| last + 1);
        let top = (k..end)
            .max_by(|&a, &b| (sign * torque_nm[a]).total_cmp(&(sign * torque_nm[b])))
            .unwrap_or(k);
        let foot = (FOOT * std_nm).max(FOOT_OF_PEAK * sign * torque_nm[top]);
        let above = |k: usize| sign * torque_nm[k] > foot;
        let (mut from, mut to) = (top, top);
        while from > 0 && above(from - 1) {
            from -= 1;
        }
        while to + 1 < n && above(to + 1) {
            to += 1;
        }
        let sum = |series: &[f64]| -> f64 { (from..=to).map(|k| series[k] * step_s(k)).sum() };
        let moment: f64 = (from..=to)
            .map(|k| torque_nm[k] * step_s(k) * time_s[k])
            .sum();
        let span_s = time_s[to] - time_s[from] + 2.0 * half_s;
        let shown = Shown {
            impulse_nms: sum(torque_nm),
            span_s,
            independent: (span_s / half_s).max(1.0),
        };
        if is_confirmed(&shown, &sum) {
            pushes.push(FoundPush {
                time_s: moment / shown.impulse_nms,
                impulse_nms: shown.impulse_nms,
                impulse_std_nms: shown.std_of(std_nm),
                peak_nm: torque_nm[top],
                span_s: (time_s[from] - half_s, time_s[to] + half_s),
            });
        }
        // The tail of this push is not a push of its own.
        k = end.max(to + 1);
    }
    pushes
}

/// Sets the weight of every window of `window_s` that a push touches to 0, and that of all others to 1.
pub fn leave_out(record: &mut Record, pushes: &[FoundPush], window_s: f64) {
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
