//! Claim `stable-for-parameters` with the windows of encoders, against loops of other parameters that are stepped in floating point.

use checker::certificate::reader::Certificate;
use checker::claims::control_law::EmittedLaw;
use checker::claims::stable_for_parameters::{RegionFailure, check_region};
use num_traits::ToPrimitive;
use serde_json::Value;

use crate::{held_input, pivot, stability};

/// Every parameter with a standard error of this share of its value.
fn uncertain(mut certificate: Value, share: f64) -> Certificate {
    for parameter in certificate["parameters"].as_array_mut().unwrap() {
        let value: f64 = parameter["value"].as_str().unwrap().parse().unwrap();
        parameter["std"] = format!("{:e}", value * share).into();
    }
    pivot::parsed(&certificate)
}

/// The linear loop of a pendulum with windows.
struct Windowed {
    /// As `stability::nominal` orders them.
    parameters: [f64; 6],
    gains: [f64; 3],
    period: f64,
    pivot: Option<usize>,
    wheel: Option<usize>,
    /// Stated back-EMF over resistance, and the resistance, of a voltage drive (A s/rad, Ohm).
    drive: Option<(f64, f64)>,
}

impl Windowed {
    fn of(certificate: &Certificate, law: &EmittedLaw, parameters: [f64; 6]) -> Windowed {
        let hardware = &certificate.hardware;
        let body = hardware.body_encoder();
        let wheel = hardware.wheel_speed.encoder.as_ref();
        Windowed {
            parameters,
            gains: [0, 1, 2].map(|i| law.gains[i].to_f64().unwrap()),
            period: certificate.sample_time_s.value.to_f64().unwrap(),
            pivot: body.map(|encoder| encoder.window as usize),
            wheel: wheel.map(|encoder| encoder.window as usize),
            drive: certificate.drive.voltage.as_ref().map(|voltage| {
                let ohm = voltage.winding_ohm.value.to_f64().unwrap();
                (voltage.back_emf_v_s.value.to_f64().unwrap() / ohm, ohm)
            }),
        }
    }

    /// Largest angle in the last second of a run of 15 s over the largest in the first, from a push.
    fn what_is_left(&self) -> f64 {
        let [theta, wheel, gravity, torque, friction, drag] = self.parameters;
        let d = theta - wheel;
        let derivative = |x: [f64; 4], held: f64| {
            let current = held - self.drive.map_or(0.0, |(_, ohm)| torque / ohm) * x[2];
            let body = (gravity * x[0] - friction * x[1] - torque * current + drag * x[2]) / d;
            [
                x[1],
                body,
                (torque * current - drag * x[2]) / wheel - body,
                x[2],
            ]
        };
        let mut x = [0.01, 0.0, 0.0, 0.0];
        let longest = self.pivot.max(self.wheel).unwrap_or(1);
        let mut before = vec![(x[0], x[3]); longest];
        let second = (1.0 / self.period) as usize;
        let (mut first, mut last) = (0.0_f64, 0.0_f64);
        for step in 0..15 * second {
            let over = |window: usize| window as f64 * self.period;
            let rate = self
                .pivot
                .map_or(x[1], |n| (x[0] - before[n - 1].0) / over(n));
            let speed = self
                .wheel
                .map_or(x[2], |n| (x[3] - before[n - 1].1) / over(n));
            before.rotate_right(1);
            before[0] = (x[0], x[3]);
            let shown = [x[0], rate, speed];
            let asked: f64 = (0..3).map(|i| self.gains[i] * shown[i]).sum();
            let held = asked + self.drive.map_or(0.0, |(back_emf, _)| back_emf) * speed;
            for _ in 0..8 {
                let h = self.period / 8.0;
                let half = derivative(x, held);
                let middle = [0, 1, 2, 3].map(|i| x[i] + 0.5 * h * half[i]);
                let slope = derivative(middle, held);
                x = [0, 1, 2, 3].map(|i| x[i] + h * slope[i]);
            }
            if step < second {
                first = first.max(x[0].abs());
            } else if step >= 14 * second {
                last = last.max(x[0].abs());
            }
            if !x[0].is_finite() {
                return f64::INFINITY;
            }
        }
        last / first
    }
}

/// The share to which a standard error may grow before the argument ends; and every corner of the box of that share is stable.
fn largest_share(certificate: &Value, law: &EmittedLaw) -> f64 {
    let shares = [0.02, 0.01, 0.005, 0.002, 0.001];
    let found = shares
        .into_iter()
        .find(|share| check_region(&uncertain(certificate.clone(), *share), law).is_ok());
    let share = found.expect("a tenth of a percent is allowed");
    let certificate = uncertain(certificate.clone(), share);
    let middle = stability::nominal(&certificate);
    for corner in 0..64 {
        let mut parameters = middle;
        for (index, value) in parameters.iter_mut().enumerate() {
            let sign = if corner >> index & 1 == 1 { 1.0 } else { -1.0 };
            // 3.75 standard errors for seven parameters.
            *value *= 1.0 + sign * share * 3.75;
        }
        let left = Windowed::of(&certificate, law, parameters).what_is_left();
        assert!(left < 1e-2, "{parameters:?}: {left}");
    }
    share
}

#[test]
fn every_corner_of_what_is_called_stable_dies_away() {
    let law = pivot::law();
    let on_the_pivot = pivot::certificate(14, 4);
    let on_the_wheel = held_input::certificate(24.0);
    for (name, certificate) in [("pivot", on_the_pivot), ("wheel, voltage", on_the_wheel)] {
        let share = largest_share(&certificate, &law);
        println!("{name}: each parameter with a standard error of {share}");
        // Beyond what the argument covers nothing is called unstable.
        let wide = check_region(&uncertain(certificate, 0.15), &law);
        assert!(
            matches!(&wide, Err(RegionFailure::Undecided(why)) if why.contains("factor")),
            "{wide:?}"
        );
    }
}

/// The same gains with a window of 16 steps, in longer and longer steps: the rate is 32 ms old, and then 48 ms. What is called
/// stable dies away, and what grows is not called stable.
#[test]
fn a_loop_that_its_window_destroys_is_not_shown() {
    let law = pivot::law();
    for (period, is_stable) in [("0.004", true), ("0.006", false)] {
        let mut certificate = pivot::certificate(14, 16);
        certificate["sample_time_s"] = period.into();
        let stated = uncertain(certificate, 0.0);
        let windowed = Windowed::of(&stated, &law, stability::nominal(&stated));
        let left = windowed.what_is_left();
        assert_eq!(left < 1.0, is_stable, "{period} s: {left}");
        let found = check_region(&stated, &law);
        match found {
            Ok(_) => assert!(is_stable, "{period} s"),
            Err(RegionFailure::Undecided(why)) => {
                assert!(
                    !is_stable && why.contains("not stable"),
                    "{period} s: {why}"
                );
            }
            Err(other) => panic!("{period} s: {other:?}"),
        }
    }
}
