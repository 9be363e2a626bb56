//! The inputs of the checks: an experiment with its record, and the stated values of the bench.

use std::f64::consts::PI;

use bench_files::{Bench, Channel, Experiment};
use identify::{FreeDecay, Output, Record, bumps};
use plant::Kind;

use crate::regression::{Ratio, ratio};
use crate::thresholds::bench::{FEWEST_LINES, PERIODS_S};
use crate::thresholds::fit::{FEWEST_POINTS, SHORTEST_BUMP};

/// An experiment and its samples as fits use them.
pub(crate) struct View<'b> {
    pub experiment: &'b Experiment,
    pub record: Record,
    /// Usual sampling interval, s.
    pub step_s: f64,
    /// The decay of a free swing, see [`View::scaled_decay`].
    decay: Option<(FreeDecay, f64)>,
}

impl<'b> View<'b> {
    pub fn new(experiment: &'b Experiment) -> View<'b> {
        let time_s = &experiment.log.time_s;
        let steps = time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let record = Record::from_experiment(experiment);
        View {
            experiment,
            decay: scaled_decay(experiment, &record),
            record,
            step_s: median(steps).unwrap_or(f64::NAN),
        }
    }

    pub fn name(&self) -> &str {
        &self.experiment.name
    }

    /// The decay of a free swing and the factor by which its angle was divided to be at most 1, since the analysis of half
    /// cycles expects radians.
    pub fn scaled_decay(&self) -> Option<&(FreeDecay, f64)> {
        self.decay.as_ref()
    }

    pub fn kind(&self) -> Kind {
        self.experiment.kind
    }

    /// Whether the times are consecutive whole numbers: of lines, perhaps, and not of seconds.
    pub fn counts_lines(&self) -> bool {
        let time_s = &self.experiment.log.time_s;
        time_s.len() >= FEWEST_LINES && time_s.windows(2).all(|pair| pair[1] - pair[0] == 1.0)
    }

    /// The samples of a channel that this kind of experiment uses.
    pub fn samples(&self, channel: Channel) -> Option<&'b [f64]> {
        self.experiment.log.channel(channel)
    }

    /// Standard deviation of the noise of a channel.
    pub fn noise(&self, output: Output) -> f64 {
        let channel = self.record.channel(output);
        channel.map_or(0.0, |channel| channel.noise_std)
    }

    /// Lengths of bumps in s, from the shortest, each twice the previous one, as long as enough of them
    /// fit into the log.
    pub fn bump_lengths_s(&self) -> impl Iterator<Item = f64> {
        let n = self.record.len();
        let mean_step_s = self.experiment.log.duration_s() / n.saturating_sub(1).max(1) as f64;
        std::iter::successors(Some(SHORTEST_BUMP), |samples| Some(2 * samples))
            .take_while(move |samples| FEWEST_POINTS * samples / 2 <= n)
            .map(move |samples| samples as f64 * mean_step_s)
    }

    /// The ratio of `samples` to the derivative of `of`, and the bump length in s with which their correlation is
    /// highest. Shorter bumps leave too much noise, longer ones average the motion away.
    pub fn ratio_to_derivative(&self, of: &[f64], samples: &[f64]) -> Option<(Ratio, f64)> {
        let ratios = self
            .bump_lengths_s()
            .filter_map(|length_s| Some((self.ratio_by_bumps(of, samples, length_s)?, length_s)));
        ratios.max_by(|(a, _), (b, _)| a.correlation.abs().total_cmp(&b.correlation.abs()))
    }

    /// As [`View::ratio_to_derivative`], with bumps of this length.
    pub fn ratio_by_bumps(&self, of: &[f64], samples: &[f64], length_s: f64) -> Option<Ratio> {
        let mut points = vec![];
        bumps(&self.record, length_s, |bump| {
            let area = bump.area();
            let derivative = -bump.integral(of, 1) / area;
            points.push((derivative, bump.integral(samples, 0) / area));
        });
        ratio(&points, FEWEST_POINTS)
    }
}

/// The values that a bench states or that its periods give, if they are known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Facts {
    /// Gravity torque G, N m.
    pub gravity_torque_n_m: Option<f64>,
    /// Torque constant τ, N m/A.
    pub torque_constant: Option<f64>,
    /// Square of the frequency of small swings with the wheel locked, ω₀² = G/Θ, 1/s²; from periods alone.
    pub gravity_over_inertia: Option<f64>,
    /// k² m_w + l² m_b, kg m²: the part of the inertia that masses and lengths give.
    pub steiner_kg_m2: Option<f64>,
    /// The wheel's share of the total inertia, j_w/Θ, where `[known]` or spin-ups without a fault say it.
    pub wheel_share: Option<f64>,
}

impl Facts {
    pub fn of(bench: &Bench, views: &[View]) -> Facts {
        let known = &bench.known;
        let periods = views.iter().filter_map(small_swing_period_s);
        let period_s = median(periods.map(|(period_s, _)| period_s).collect());
        let products = [
            (known.wheel_mass, known.pivot_to_wheel),
            (known.body_mass, known.pivot_to_com),
        ]
        .map(|(mass, length)| Some(mass? * length? * length?));
        Facts {
            gravity_torque_n_m: known.gravity_torque().ok(),
            torque_constant: known.torque_constant,
            gravity_over_inertia: period_s.map(|period| (std::f64::consts::TAU / period).powi(2)),
            steiner_kg_m2: match products {
                [Some(wheel), Some(body)] => Some(wheel + body),
                _ => None,
            },
            wheel_share: None,
        }
    }

    /// Total inertia Θ = G/ω₀², kg m².
    pub fn total_inertia(&self) -> Option<f64> {
        Some(self.gravity_torque_n_m? / self.gravity_over_inertia?)
    }
}

/// As [`View::scaled_decay`], of an experiment with this record.
fn scaled_decay(experiment: &Experiment, record: &Record) -> Option<(FreeDecay, f64)> {
    if experiment.kind != Kind::FreeSwing {
        return None;
    }
    let log = &experiment.log;
    let scale = match &log.angle_rad {
        Some(angle) => {
            let (low, high) = range(angle)?;
            (0.5 * (high - low)).max(1.0)
        }
        None => travel(&log.time_s, log.rate_rad_s.as_deref()?),
    };
    if scale == 1.0 {
        return Some((identify::decay(record)?, scale));
    }
    let scaled = |samples: &Vec<f64>| samples.iter().map(|x| x / scale).collect();
    let angle = log.angle_rad.as_ref().map(scaled);
    let rate = match &angle {
        Some(_) => log.rate_rad_s.clone(),
        None => log.rate_rad_s.as_ref().map(scaled),
    };
    let record = Record::new(
        "",
        Kind::FreeSwing,
        log.time_s.clone(),
        [angle, rate, None],
        None,
        false,
    );
    Some((identify::decay(&record)?, scale))
}

/// Half of the range of the integral of a rate about its median, at least 1.
fn travel(time_s: &[f64], rate: &[f64]) -> f64 {
    let middle = median(rate.to_vec()).unwrap_or(0.0);
    let mut angle = 0.0;
    let angles: Vec<f64> = (1..rate.len())
        .map(|k| {
            let step = (rate[k] - middle) * (time_s[k] - time_s[k - 1]);
            angle += if step.is_finite() { step } else { 0.0 };
            angle
        })
        .collect();
    range(&angles).map_or(1.0, |(low, high)| (0.5 * (high - low)).max(1.0))
}

/// The period of small swings in a free swing, s, with its standard error, if a bench can have such a period. It is
/// taken from the swings above half of the largest amplitude: springs and presliding change those of the smallest ones.
pub(crate) fn small_swing_period_s(view: &View) -> Option<(f64, f64)> {
    let (decay, scale) = view.scaled_decay()?;
    let amplitudes = decay.periods.iter().map(|point| point.amplitude_rad);
    let largest = amplitudes.fold(0.0, f64::max);
    let large = decay
        .periods
        .iter()
        .filter(|point| 2.0 * point.amplitude_rad >= largest);
    let small: Vec<(f64, f64)> = large
        .map(|point| {
            // An angle that would go over the top is in another unit, and is not corrected.
            let amplitude = scale * point.amplitude_rad;
            let factor = match amplitude < 0.99 * PI {
                true => agm(1.0, (0.5 * amplitude).cos()),
                false => 1.0,
            };
            (factor * point.value, factor * point.std)
        })
        .collect();
    let std = median(small.iter().map(|(_, std)| *std).collect())? / (small.len() as f64).sqrt();
    let period_s = median(small.into_iter().map(|(value, _)| value).collect())?;
    PERIODS_S.contains(&period_s).then_some((period_s, std))
}

/// Arithmetic-geometric mean; the period of a pendulum is T₀/agm(1, cos(A/2)).
pub(crate) fn agm(mut a: f64, mut b: f64) -> f64 {
    for _ in 0..20 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    a
}

/// A channel as sentences name it.
pub(crate) fn spoken(channel: Channel) -> String {
    channel.key().replace('_', " ")
}

/// The median of the finite values; `None` if there is none.
pub(crate) fn median(mut values: Vec<f64>) -> Option<f64> {
    values.retain(|value| value.is_finite());
    if values.is_empty() {
        return None;
    }
    let middle = values.len() / 2;
    Some(*values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// Smallest and largest finite value.
pub(crate) fn range(values: &[f64]) -> Option<(f64, f64)> {
    let finite = values.iter().copied().filter(|value| value.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
        (low.min(x), high.max(x))
    });
    (low <= high).then_some((low, high))
}

/// Largest absolute finite value.
pub(crate) fn largest(values: &[f64]) -> f64 {
    let finite = values.iter().filter(|value| value.is_finite());
    finite.fold(0.0, |most, value| most.max(value.abs()))
}

/// Number of different finite values.
pub(crate) fn levels(values: &[f64]) -> usize {
    let mut finite: Vec<f64> = values.iter().copied().filter(|x| x.is_finite()).collect();
    finite.sort_unstable_by(f64::total_cmp);
    finite.dedup();
    finite.len()
}
