//! What sensors do comes back from logs: late channels, filtered ones, zeros of single logs.

use crate::common::{fitted, parameter, short_bench};
use crate::simulated::{Physics, problem};
use identify::{Output, Record};
use plant::{EffectId, Kind};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Changes the samples of an output in every record that has it; `change` gets the samples and the interval in s.
fn changed(records: &mut [Record], output: Output, change: impl Fn(&mut Vec<f64>, f64)) {
    for record in records {
        let step_s = record.time_s[1] - record.time_s[0];
        let channels = record.channels.iter_mut();
        for channel in channels.filter(|channel| channel.output == output) {
            change(&mut channel.samples, step_s);
        }
    }
}

/// Late by whole samples; before the log the first one holds.
fn late(samples: &mut Vec<f64>, count: usize) {
    let before = vec![samples[0]; count];
    samples.splice(0..0, before);
    samples.truncate(samples.len() - count);
}

#[test]
fn a_delay_of_a_sensor_is_found_to_its_error() {
    for (effect, output, seed) in [
        (EffectId::RateDelay, Output::Rate, 71),
        (EffectId::AngleDelay, Output::Angle, 72),
        (EffectId::WheelSpeedDelay, Output::WheelSpeed, 73),
    ] {
        let mut records = short_bench(&Physics::base(), seed);
        let delay_s = 0.02;
        changed(&mut records, output, |samples, step_s| {
            late(samples, (delay_s / step_s).round() as usize);
        });
        let found = fitted(&problem(records), &[effect]);
        let name = effect.info().parameters[0].name;
        let (value, std) = parameter(&found, name);
        // The logs begin at rest or in motion; which of both is an unknown of each.
        assert!(
            (value - delay_s).abs() < 5.0 * std + 1e-4,
            "seed {seed} {name}: {value} ± {std}"
        );
    }
}

#[test]
fn a_lag_of_a_sensor_is_found() {
    for (effect, output, seed) in [
        (EffectId::RateLag, Output::Rate, 81),
        (EffectId::WheelSpeedLag, Output::WheelSpeed, 82),
    ] {
        // The noise of the filtered sensor comes behind its filter.
        let quiet = Physics {
            noise: [1.2e-3, 0.0, 0.0, 2e-3],
            ..Physics::base()
        };
        let lag_s = 0.03;
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut records = short_bench(&quiet, seed);
        for record in &mut records {
            let step_s = record.time_s[1] - record.time_s[0];
            let outputs = Output::ALL.map(|one| {
                let mut samples = record.channel(one)?.samples.clone();
                if one == output {
                    follow(&mut samples, lag_s, step_s);
                }
                let std = match one {
                    Output::Angle => 0.0,
                    Output::Rate => 4e-3,
                    Output::WheelSpeed => 0.6,
                };
                for sample in &mut samples {
                    let noise: f64 = StandardNormal.sample(&mut random);
                    *sample += std * noise;
                }
                Some(samples)
            });
            let (time_s, current) = (record.time_s.clone(), record.current_a.clone());
            let current = (!current.is_empty()).then_some(current);
            *record = Record::new(&record.name, record.kind, time_s, outputs, current, false);
        }
        let found = fitted(&problem(records), &[effect]);
        let name = effect.info().parameters[0].name;
        let (value, std) = parameter(&found, name);
        assert!(
            (value - lag_s).abs() < 5.0 * std && std < 0.03 * lag_s,
            "seed {seed} {name}: {value} ± {std}"
        );
    }
}

/// The exact answer of T ẏ = v − y to straight lines between the samples, y = v at the first.
fn follow(samples: &mut [f64], lag_s: f64, step_s: f64) {
    let left = (-step_s / lag_s).exp();
    let (mut before, mut said) = (samples[0], samples[0]);
    for sample in samples {
        let behind = lag_s * (*sample - before) / step_s;
        said = *sample - behind + (said - before + behind) * left;
        before = *sample;
        *sample = said;
    }
}

#[test]
fn every_log_may_have_a_zero_of_its_own() {
    let seed = 91;
    let mut records = short_bench(&Physics::base(), seed);
    let zeros = |record: &Record| match record.kind {
        Kind::Balance => 0.02,
        _ if record.name.contains("20") => 0.05,
        _ => -0.03,
    };
    for record in &mut records {
        let zero = zeros(record);
        let channels = record.channels.iter_mut();
        for channel in channels.filter(|channel| channel.output == Output::Angle) {
            channel.samples.iter_mut().for_each(|angle| *angle += zero);
        }
    }
    let problem = problem(records);
    let effect = problem.made_for_logs(EffectId::AngleZero);
    assert_eq!(effect.info().parameters.len(), 3);
    let found = fitted(&problem, &[effect]);
    for record in &problem.records {
        if record.channel(Output::Angle).is_none() {
            continue;
        }
        let (value, std) = parameter(&found, &format!("angle_zero/{}", record.name));
        let truth = zeros(record);
        assert!(
            (value - truth).abs() < 5.0 * std,
            "seed {seed} {}: {value} ± {std}",
            record.name
        );
    }
}
