//! The picture of an effect: the same experiment simulated with and without the effect.

use figures::{Line, LineRole, Panel, Quantity, Series};
use plant::{Current, EffectId, HidingPlace, Hold, Input, Kind, Model, Plant, State};

use crate::error::Error;
use crate::numbers::significant;
use crate::output_file::OutputFile;

/// Samples of a drawn experiment, enough for a smooth line.
const SAMPLES: usize = 300;
/// Steps of integration between two drawn samples.
const PARTS: usize = 8;
/// Share of the channel's range by which the effect changes it in the picture.
const VISIBLE: f64 = 0.1;
/// Amplitudes that are tried, as powers of two around the effect's first guess.
const POWERS: std::ops::RangeInclusive<i32> = -12..=12;

/// Halvings of the amplitude's interval: to a twentieth of a percent.
const BISECTIONS: usize = 10;

/// An experiment in which effects are drawn.
pub(crate) struct Scene {
    /// The experiment in words.
    pub words: &'static str,
    /// The kind of the experiment: what is held still.
    pub kind: Kind,
    angle_rad: f64,
    wheel_speed_rad_s: f64,
    /// Current in A at a time in s.
    pub current_a: fn(f64) -> f64,
    duration_s: f64,
}

/// Current of the scenes in which the motor is driven, A.
const CURRENT_A: f64 = 0.5;

/// The experiments in which effects are drawn.
pub(crate) const SCENES: [Scene; 5] = [
    Scene {
        words: "a free swing from 20°, the wheel locked",
        kind: Kind::FreeSwing,
        angle_rad: 0.35,
        wheel_speed_rad_s: 0.0,
        current_a: |_| 0.0,
        duration_s: 8.0,
    },
    Scene {
        words: "a free swing from 60°, the wheel locked",
        kind: Kind::FreeSwing,
        angle_rad: 1.05,
        wheel_speed_rad_s: 0.0,
        current_a: |_| 0.0,
        duration_s: 8.0,
    },
    Scene {
        words: "the body clamped, 0.5 A for two seconds and then as much the other way",
        kind: Kind::SpinUp,
        angle_rad: 0.0,
        wheel_speed_rad_s: 0.0,
        current_a: |time_s| if time_s < 2.0 { CURRENT_A } else { -CURRENT_A },
        duration_s: 5.0,
    },
    Scene {
        words: "the body clamped, a coast-down without current",
        kind: Kind::SpinUp,
        angle_rad: 0.0,
        wheel_speed_rad_s: 60.0,
        current_a: |_| 0.0,
        duration_s: 12.0,
    },
    Scene {
        words: "the body hanging free, 0.5 A to and fro every half second",
        kind: Kind::Driven,
        angle_rad: 0.0,
        wheel_speed_rad_s: 0.0,
        current_a: |time_s| {
            if time_s.rem_euclid(1.0) < 0.5 {
                CURRENT_A
            } else {
                -CURRENT_A
            }
        },
        duration_s: 4.0,
    },
];

/// The bench of the pictures: the parameters behind the thesis' matrix 4.4, viscous friction alone.
pub(crate) const BENCH: [(&str, f64); 6] = [
    ("total_inertia", 2.30344e-3),
    ("wheel_inertia", 1.36125e-4),
    ("gravity_torque", 0.245158),
    ("torque_constant", 0.0335),
    ("body_viscous_friction", 2.12e-5),
    ("wheel_viscous_friction", 1.75204e-5),
];

/// Distance from the pivot to the axis of the wheel, m.
pub(crate) const PIVOT_TO_WHEEL_M: f64 = 0.085;
/// Gravity, m/s².
pub(crate) const GRAVITY_M_S2: f64 = 9.81;

/// The same experiment with and without an effect.
#[derive(Clone, Debug, PartialEq)]
pub struct EffectPortrait {
    /// The effect.
    pub effect: String,
    /// The experiment in words.
    pub experiment: String,
    /// The channel that shows the effect best, `angle`, `rate` or `wheel_speed`.
    pub channel: String,
    /// Its unit.
    pub unit: String,
    /// Names and values of the effect's parameters in the picture, SI.
    pub parameters: Vec<(String, f64, String)>,
    /// Time of each sample, s.
    pub time_s: Vec<f64>,
    /// The channel of the base model at each sample, in `unit`.
    pub without: Vec<f64>,
    /// The channel with the effect at each sample, in `unit`; all other parameters are equal.
    pub with: Vec<f64>,
}

/// Draws an effect of the library in the experiment that shows it best, at an amplitude that changes the channel by a
/// tenth of its range. `None` for the effects of the base model, which are in every picture, and for effects with one
/// parameter per log, which look in a single log like the effect that they replace.
pub fn effect_portrait(name: &str) -> Option<EffectPortrait> {
    let effect = EffectId::from_name(name)?;
    let info = effect.info();
    let hiding = info.hiding?;
    let base = Model::base();
    let model = base.with(effect);
    let place = HidingPlace {
        total_inertia: BENCH[0].1,
        wheel_inertia: BENCH[1].1,
        gravity_torque: BENCH[2].1,
        torque_constant: BENCH[3].1,
        pivot_to_wheel_m: PIVOT_TO_WHEEL_M,
        top_current_a: CURRENT_A,
        top_wheel_speed_rad_s: 150.0,
        side: 1.0,
        shape: 0.5,
        second: 0.0,
    };
    let range = model.range_of(effect)?;
    let values_with = |amplitude: f64| -> Vec<f64> {
        let mut values = bench_values(&model);
        let own = (hiding.parameters)(amplitude, &place);
        for (value, own) in values[range.clone()].iter_mut().zip(own) {
            *value = own;
        }
        values
    };
    let scenes = SCENES
        .iter()
        .filter(|scene| info.shows_in.contains(&scene.kind));
    let mut best: Option<(f64, EffectPortrait)> = None;
    for scene in scenes {
        let without = record(&base, &bench_values(&base), scene);
        let seen = |amplitude: f64| {
            let with = record(&model, &values_with(amplitude), scene);
            let (channel, share) = most_changed(scene.kind, &without, &with)?;
            Some((channel, share, with))
        };
        let Some(amplitude) = visible_amplitude(hiding.first_guess, |amplitude| {
            seen(amplitude).map(|(_, share, _)| share)
        }) else {
            continue;
        };
        // The experiment in which the smallest amplitude is visible shows the effect best.
        if best.as_ref().is_some_and(|(least, _)| amplitude >= *least) {
            continue;
        }
        let Some((channel, _, with)) = seen(amplitude) else {
            continue;
        };
        let values = values_with(amplitude);
        best = Some((
            amplitude,
            EffectPortrait {
                effect: name.to_owned(),
                experiment: scene.words.to_owned(),
                channel: CHANNELS[channel].0.to_owned(),
                unit: CHANNELS[channel].1.to_owned(),
                parameters: info
                    .parameters
                    .iter()
                    .zip(&values[range.clone()])
                    .map(|(one, value)| (one.name.to_owned(), *value, one.unit.to_owned()))
                    .collect(),
                time_s: times(scene),
                without: without[channel].clone(),
                with: with[channel].clone(),
            },
        ));
    }
    best.map(|(_, portrait)| portrait)
}

impl EffectPortrait {
    /// The picture, named after the effect.
    ///
    /// # Errors
    /// [`Error::Figure`].
    pub fn drawing(&self) -> Result<OutputFile, Error> {
        let change: Vec<f64> = self
            .with
            .iter()
            .zip(&self.without)
            .map(|(with, without)| with - without)
            .collect();
        let line = |name, role, y| Line {
            name,
            role,
            x: &self.time_s,
            y,
        };
        let parameters: Vec<String> = self
            .parameters
            .iter()
            .map(|(name, value, unit)| format!("{name} = {} {unit}", significant(*value, 3)))
            .collect();
        let channel = self.channel.replace('_', " ");
        let text = figures::series(&Series {
            title: &format!("{} in {}", self.effect, self.experiment),
            subtitle: &parameters.join(", "),
            x: Quantity {
                name: "time",
                unit: "s",
            },
            panels: &[
                Panel {
                    quantity: Quantity {
                        name: &channel,
                        unit: &self.unit,
                    },
                    lines: &[
                        line("base model", LineRole::Measurement, &self.without),
                        line("with the effect", LineRole::Model, &self.with),
                    ],
                    ..Panel::default()
                },
                Panel {
                    quantity: Quantity {
                        name: "change",
                        unit: &self.unit,
                    },
                    lines: &[line("with − without", LineRole::Residual, &change)],
                    ..Panel::default()
                },
            ],
            ..Series::default()
        })?;
        Ok(OutputFile::svg(&self.effect, text))
    }
}

/// The channels of a run with their units.
const CHANNELS: [(&str, &str); 3] = [
    ("angle", "rad"),
    ("rate", "rad/s"),
    ("wheel_speed", "rad/s"),
];

/// The smallest amplitude at which an effect changes the channel by [`VISIBLE`] of its range; `share` gives that
/// share. `None` where no amplitude that is tried does.
fn visible_amplitude(first_guess: f64, share: impl Fn(f64) -> Option<f64>) -> Option<f64> {
    let is_visible = |amplitude: f64| share(amplitude).is_some_and(|share| share >= VISIBLE);
    let mut high = POWERS
        .map(|power| first_guess * 2_f64.powi(power))
        .find(|amplitude| is_visible(*amplitude))?;
    let mut low = 0.5 * high;
    for _ in 0..BISECTIONS {
        let middle = (low * high).sqrt();
        if is_visible(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    Some(high)
}

/// The bench's values in the order of a model's parameters; those of further effects are zero.
pub(crate) fn bench_values(model: &Model) -> Vec<f64> {
    model
        .parameters()
        .iter()
        .map(|parameter| {
            BENCH
                .iter()
                .find(|(name, _)| *name == parameter.name)
                .map_or(0.0, |(_, value)| *value)
        })
        .collect()
}

/// Times of the samples, s.
pub(crate) fn times(scene: &Scene) -> Vec<f64> {
    (0..SAMPLES)
        .map(|k| scene.duration_s * k as f64 / (SAMPLES - 1) as f64)
        .collect()
}

/// The readings of the sensors in a scene: angle, rate and wheel speed at [`SAMPLES`] times.
pub(crate) fn record(model: &Model, values: &[f64], scene: &Scene) -> [Vec<f64>; 3] {
    let steps = (SAMPLES - 1) * PARTS + 1;
    let fine: Vec<f64> = (0..steps)
        .map(|k| scene.duration_s * k as f64 / (steps - 1) as f64)
        .collect();
    let current: Vec<f64> = fine.iter().map(|&time| (scene.current_a)(time)).collect();
    let input = Input::new(&fine, &current, Hold::Zero);
    let plant = Plant::new(model, values, scene.kind);
    let start = State {
        angle_rad: scene.angle_rad,
        wheel_speed_rad_s: scene.wheel_speed_rad_s,
        ..State::rest()
    };
    let mut out = [vec![], vec![], vec![]];
    plant.run(
        start,
        &fine,
        0..steps,
        Current::Recorded(&input),
        None,
        |k, reading, _| {
            if k % PARTS == 0 {
                out[0].push(reading.angle_rad);
                out[1].push(reading.rate_rad_s);
                out[2].push(reading.wheel_speed_rad_s);
            }
        },
    );
    out
}

/// The channel that changes most, and the change as a share of the channel's range.
fn most_changed(kind: Kind, without: &[Vec<f64>; 3], with: &[Vec<f64>; 3]) -> Option<(usize, f64)> {
    let channels = match kind {
        Kind::FreeSwing => 0..2,
        Kind::SpinUp => 2..3,
        Kind::Balance | Kind::Driven => 0..3,
    };
    channels
        .filter_map(|channel| {
            let (low, high) = without[channel]
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                    (low.min(*value), high.max(*value))
                });
            let change = without[channel]
                .iter()
                .zip(&with[channel])
                .map(|(a, b)| (a - b).abs())
                .try_fold(0.0, |most: f64, one| one.is_finite().then(|| most.max(one)))?;
            (high > low).then(|| (channel, change / (high - low)))
        })
        .max_by(|a, b| a.1.total_cmp(&b.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every effect beside the base model has a picture in which it is plainly seen and does not hide the motion.
    #[test]
    fn each_effect_is_visible_in_its_picture() {
        for effect in EffectId::ALL {
            let Some(portrait) = effect_portrait(effect.name()) else {
                // In a single log an effect of each log is the effect that it replaces.
                assert!(
                    Model::base().has(*effect) || effect.info().per_log.is_some(),
                    "{} has no picture",
                    effect.name()
                );
                continue;
            };
            let range = portrait
                .without
                .iter()
                .fold(0.0_f64, |most, one| most.max(one.abs()));
            let change = portrait
                .with
                .iter()
                .zip(&portrait.without)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max);
            assert!(
                change > 0.02 * range && change < range,
                "{}: {change} of {range}",
                effect.name()
            );
        }
    }

    /// Dry friction takes the same amount of every cycle: the swing is over at a finite time.
    #[test]
    fn the_picture_of_dry_friction_is_of_dry_friction() {
        let Some(portrait) = effect_portrait("body-coulomb-friction") else {
            panic!("no picture");
        };
        let peak = |from: usize, to: usize, values: &[f64]| {
            values[from..to]
                .iter()
                .fold(0.0_f64, |most, one| most.max(one.abs()))
        };
        let third = SAMPLES / 3;
        let early = peak(0, third, &portrait.without) - peak(0, third, &portrait.with);
        let late =
            peak(2 * third, SAMPLES, &portrait.without) - peak(2 * third, SAMPLES, &portrait.with);
        assert!(late > 1.5 * early, "{early} {late}");
    }
}
