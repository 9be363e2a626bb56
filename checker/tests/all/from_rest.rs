//! The two claims about starts at rest, against a loop that is stepped in floating point and knows nothing of the proof.

use std::f64::consts::TAU;
use std::path::Path;

use checker::certificate::reader::{Certificate, matrix, vector};
use checker::claims::closed_loop_second;
use checker::claims::control_law::EmittedLaw;
use checker::claims::emitted_observer::EmittedObserver;
use checker::claims::loop_from_rest::{self, LoopFromRest};
use checker::prove::{ClaimOutcome, Emitted};
use num_traits::ToPrimitive;

use crate::observer::Observer;
use crate::pivot::{certificate, law, parsed};
use crate::shipped::real;

/// A loop with a converter at the wheel. The body is shown by an encoder of 2^14 counts on the pivot, its window 4,
/// or by an angle and a rate in steps.
pub(crate) struct Stepped {
    a: [[f64; 3]; 3],
    b: [f64; 3],
    gains: [f64; 3],
    t: f64,
    wheel_count: f64,
    unit: f64,
    /// Steps of angle and rate (rad, rad/s); `None` for the encoder.
    steps: Option<[f64; 2]>,
    observer: Option<Observer>,
    pub(crate) is_sine: bool,
    pub(crate) is_rounded: bool,
}

const WINDOW: usize = 4;
const COUNT: f64 = TAU / 16_384.0;

impl Stepped {
    pub(crate) fn of(certificate: &Certificate, law: &EmittedLaw) -> Stepped {
        // The accelerometer's words move by four counts, in which 1024 are gravity; the gyroscope's by one.
        let steps = certificate.hardware.inertial().map(|inertial| {
            let count = real(&inertial.accelerometer.matrix[0][0].value);
            let gravity = real(&inertial.gravity_m_s2.value);
            [
                4.0 * count / gravity,
                real(&inertial.gyroscope.matrix[2][2].value),
            ]
        });
        let wheel = &certificate.hardware.wheel_speed.rad_s_per_count.value;
        Stepped {
            a: matrix(&certificate.plant.a)
                .each_ref()
                .map(|row| row.each_ref().map(real)),
            b: vector(&certificate.plant.b).each_ref().map(real),
            gains: law.gains.each_ref().map(real),
            t: real(&certificate.sample_time_s.value),
            wheel_count: wheel.to_f64().unwrap(),
            unit: real(&law.unit()),
            steps,
            observer: law.observer.as_ref().map(|own| Observer::of(own, true)),
            is_sine: false,
            is_rounded: true,
        }
    }

    fn rate(&self, x: [f64; 3], current: f64) -> [f64; 3] {
        let excess = if self.is_sine { x[0].sin() - x[0] } else { 0.0 };
        let gravity = self.a[1][0] * excess;
        [0, 1, 2].map(|i| {
            let linear: f64 = (0..3).map(|j| self.a[i][j] * x[j]).sum();
            linear + self.b[i] * current + [0.0, gravity, -gravity][i]
        })
    }

    /// The loop with the real numbers of the certificate, without rounding.
    pub(crate) fn exact(certificate: &Certificate, law: &EmittedLaw) -> Stepped {
        let stated = EmittedObserver::stated(certificate);
        Stepped {
            gains: vector(&certificate.gains)
                .each_ref()
                .map(|gain| -real(gain)),
            observer: stated.map(|own| Observer::of(&own, false)),
            is_rounded: false,
            ..Stepped::of(certificate, law)
        }
    }

    /// The states, and the command, at every sample.
    pub(crate) fn run(&self, start: f64, steps: usize) -> Vec<[f64; 4]> {
        let in_steps = |value: f64, step: f64| match self.is_rounded {
            true => (value / step).round() * step,
            false => value,
        };
        let shown = |angle: f64| in_steps(angle, self.steps.map_or(COUNT, |steps| steps[0]));
        let mut observer = self.observer;
        if let Some(observer) = &mut observer {
            observer.waits([shown(start), 0.0, 0.0]);
        }
        let mut x = [start, 0.0, 0.0];
        let mut before = [shown(start); WINDOW];
        let mut seen = Vec::new();
        for _ in 0..steps {
            let angle = shown(x[0]);
            let speed = in_steps(x[2], self.wheel_count);
            let rate = match self.steps {
                Some([_, step]) => in_steps(x[1], step),
                None => (angle - before[WINDOW - 1]) / (WINDOW as f64 * self.t),
            };
            before.rotate_right(1);
            before[0] = angle;
            let states = [angle, rate, speed];
            let bias = observer.map_or(0.0, |observer| observer.estimate(states));
            let wished =
                self.gains[0] * (angle - bias) + self.gains[1] * rate + self.gains[2] * speed;
            let current = in_steps(wished, self.unit);
            if let Some(observer) = &mut observer {
                observer.advance(states, current);
            }
            seen.push([x[0], x[1], x[2], current]);
            // Runge and Kutta, eight steps a sample.
            let h = self.t / 8.0;
            for _ in 0..8 {
                let along = |x: [f64; 3], k: [f64; 3], h: f64| [0, 1, 2].map(|i| x[i] + h * k[i]);
                let k1 = self.rate(x, current);
                let k2 = self.rate(along(x, k1, h / 2.0), current);
                let k3 = self.rate(along(x, k2, h / 2.0), current);
                let k4 = self.rate(along(x, k3, h), current);
                x = [0, 1, 2].map(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
            }
        }
        seen
    }
}

pub(crate) fn largest(runs: impl Iterator<Item = [f64; 4]>) -> [f64; 4] {
    runs.fold([0.0; 4], |most, now| {
        [0, 1, 2, 3].map(|i| f64::max(most[i], now[i].abs()))
    })
}

#[test]
fn the_two_loops_of_the_linear_model_stay_together() {
    stay_together(&parsed(&certificate(14, WINDOW as u32)), &law());
}

/// The emitted loop and the one in real numbers, from starts up to the proved one: each within its bounds, and the
/// difference within its own.
pub(crate) fn stay_together(certificate: &Certificate, law: &EmittedLaw) {
    let shown = LoopFromRest::of(certificate, law).unwrap();
    let found = shown.for_all_time(certificate, law).unwrap();
    let start = real(&found.start);
    println!("from {start:.4} rad");
    assert!(start > 0.02, "{start}");
    let emitted = Stepped::of(certificate, law);
    let exact = Stepped::exact(certificate, law);
    let mut most = [0.0; 4];
    for share in [-1.0, -0.31, 0.5, 0.77, 1.0] {
        let both = emitted.run(share * start, 4_000).into_iter();
        let both: Vec<_> = both.zip(exact.run(share * start, 4_000)).collect();
        let apart = both
            .iter()
            .map(|(one, other)| [0, 1, 2, 3].map(|i| one[i] - other[i]));
        most = [most, largest(apart)]
            .into_iter()
            .fold([0.0; 4], |most, now| {
                [0, 1, 2, 3].map(|i| f64::max(most[i], now[i]))
            });
        let own = largest(both.iter().map(|(one, _)| *one));
        for (i, bound) in found
            .bounds
            .states
            .iter()
            .chain([&found.bounds.command])
            .enumerate()
        {
            assert!(
                own[i] <= real(bound),
                "quantity {i}: {} of {}",
                own[i],
                real(bound)
            );
        }
    }
    let bounds = found
        .difference
        .states
        .iter()
        .chain([&found.difference.command]);
    for (i, bound) in bounds.enumerate() {
        println!("{i}: {:.3e} of {:.3e}", most[i], real(bound));
        assert!(most[i] <= real(bound), "quantity {i}");
        // The bound is for the worst of all roundings; those of a run are some of them.
        assert!(most[i] > 0.02 * real(bound), "quantity {i}");
    }
}

#[test]
fn from_the_region_the_pendulum_comes_to_the_inner_bounds() {
    comes_to_the_inner_bounds(&parsed(&certificate(14, WINDOW as u32)), &law());
}

/// The pendulum, from starts within the region: within the outer bounds, and late within the inner ones.
pub(crate) fn comes_to_the_inner_bounds(certificate: &Certificate, law: &EmittedLaw) {
    let shown = LoopFromRest::of(certificate, law).unwrap();
    let found = shown.from_rest(certificate).unwrap();
    let start = real(&found.start);
    println!("from {start:.4} rad");
    let pendulum = Stepped {
        is_sine: true,
        ..Stepped::of(certificate, law)
    };
    for share in [-1.0, 0.4, 1.0] {
        let run = pendulum.run(share * start, 12_000);
        let (whole, late) = (
            largest(run.iter().copied()),
            largest(run[8_000..].iter().copied()),
        );
        let outer = found.bounds.states.iter().chain([&found.bounds.command]);
        let inner = found.kept.states.iter().chain([&found.kept.command]);
        for (i, (outer, inner)) in outer.zip(inner).enumerate() {
            println!(
                "{i}: {:.3e} of {:.3e}, late {:.3e} of {:.3e}",
                whole[i],
                real(outer),
                late[i],
                real(inner)
            );
            assert!(whole[i] <= real(outer), "quantity {i}");
            assert!(late[i] <= real(inner), "quantity {i}");
        }
        if share == 1.0 {
            assert!(whole[0] > 0.25 * real(&found.bounds.states[0]));
        }
    }
}

/// A coarse encoder is not proved; an ellipsoid of three states is no statement about such a loop.
#[test]
fn what_is_not_shown_is_said() {
    let (for_all_time, region) =
        loop_from_rest::by_exact_arithmetic(&parsed(&certificate(8, 14)), &law());
    for outcome in [for_all_time, region] {
        assert!(
            matches!(&outcome, ClaimOutcome::NotRun(why) if why.contains("even from upright")),
            "{outcome:?}"
        );
    }
    let mut with_set = certificate(14, WINDOW as u32);
    let text = std::fs::read_to_string("../generated/certificate.json").unwrap();
    let whole: serde_json::Value = serde_json::from_str(&text).unwrap();
    with_set["closed_loop"] = whole["closed_loop"].clone();
    let (for_all_time, _) = loop_from_rest::by_exact_arithmetic(&parsed(&with_set), &law());
    assert!(
        matches!(&for_all_time, ClaimOutcome::Failed(why) if why.contains("three states")),
        "{for_all_time:?}"
    );
}

/// The committed crate with an encoder on its pivot, altered at some places of its certificate.
fn emitted(changes: &[(&str, serde_json::Value)]) -> Emitted {
    let mut emitted = Emitted::read(Path::new("../generated")).unwrap();
    let mut altered = certificate(14, WINDOW as u32);
    for (place, value) in changes {
        *altered.pointer_mut(place).unwrap() = value.clone();
    }
    emitted.certificate = altered.to_string();
    emitted
}

/// The second checker, which shares nothing with the first, finds the same of both claims.
#[test]
fn the_second_checker_agrees_from_rest() {
    agree_from_rest(
        &emitted(&[]),
        &parsed(&certificate(14, WINDOW as u32)),
        &law(),
    );
}

/// What both checkers find, where Python is.
pub(crate) fn agree_from_rest(emitted: &Emitted, stated: &Certificate, law: &EmittedLaw) {
    let (for_all_time, region) = closed_loop_second::from_rest_by_python(emitted);
    if let ClaimOutcome::NotRun(why) = &for_all_time {
        assert!(why.contains("python3 is not installed"), "{why}");
        eprintln!("not run: {why}");
        return;
    }
    let shown = LoopFromRest::of(stated, law).unwrap();
    let both = shown.for_all_time(stated, law).unwrap();
    let from_rest = shown.from_rest(stated).unwrap();
    let values = |start, parts: [&[_; 3]; 2], commands: [_; 2]| -> Vec<f64> {
        let mut found = vec![real(start)];
        for (states, command) in parts.into_iter().zip(commands) {
            found.extend(states.iter().chain([command]).map(real));
        }
        found
    };
    let own = [
        values(
            &both.start,
            [&both.bounds.states, &both.difference.states],
            [&both.bounds.command, &both.difference.command],
        ),
        values(
            &from_rest.start,
            [&from_rest.bounds.states, &from_rest.kept.states],
            [&from_rest.bounds.command, &from_rest.kept.command],
        ),
    ];
    for (outcome, own) in [for_all_time, region].iter().zip(own) {
        let ClaimOutcome::Proved(said) = outcome else {
            panic!("{outcome:?}");
        };
        let theirs: Vec<f64> = said
            .split(|c: char| !(c.is_ascii_digit() || c == '.'))
            .filter_map(|word| word.parse().ok())
            .collect();
        assert_eq!(theirs.len(), own.len(), "{said}");
        for (own, theirs) in own.iter().zip(theirs) {
            assert!((own - theirs).abs() < 1e-3 * own, "{own} {theirs}: {said}");
        }
    }
}

/// Numbers that contradict each other are refused by the second checker alone, before it adds up anything.
#[test]
fn the_second_checker_refuses_a_falsified_certificate() {
    let alterations: [(&str, serde_json::Value); 10] = [
        ("/plant/A/1/0", "100.0".into()),
        ("/plant/A/1/1", "-0.5".into()),
        ("/plant/Ad/0/1", "0.00101".into()),
        ("/plant/B/1", "-14.0".into()),
        ("/plant/Bd/2", "0.2".into()),
        ("/gains/1", "-2.1".into()),
        ("/constants/2/raw", 184_025_801.into()),
        ("/parameters/2/value", "0.2".into()),
        ("/parameters/1/value", "0.005".into()),
        ("/hardware/body_encoder/window", 17.into()),
    ];
    for change in alterations {
        let crate_ = emitted(std::slice::from_ref(&change));
        let (for_all_time, region) = closed_loop_second::from_rest_by_python(&crate_);
        for outcome in [for_all_time, region] {
            match outcome {
                ClaimOutcome::Failed(_) => {}
                ClaimOutcome::NotRun(why) if why.contains("python3 is not installed") => {}
                other => panic!("{change:?}: {other:?}"),
            }
        }
    }
}
