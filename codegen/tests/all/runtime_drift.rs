//! The estimate of the gyroscope's drift, in words and in double precision: the known drift is found,
//! and both agree.

use std::f64::consts::PI;

use attitude::{AttitudeSpec, RawFilter, wrap_angle};
use codegen::attitude::derive;
use codegen::helpers::filter::{START, align, step_tracked};
use codegen::helpers::pivot_angle::pivot_angle;
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Sways about upright by some degrees at half a hertz and drifts: rad/s about the sensor's axes.
struct Sway {
    spec: AttitudeSpec,
    random: ChaCha8Rng,
    angle_rad: f64,
}

impl Sway {
    fn sample(&mut self, time_s: f64, drift: &Vector3<f64>) -> ([i16; 3], [i16; 3]) {
        let swing = 2.0 * PI * 0.5;
        self.angle_rad = 0.05 * (swing * time_s).sin();
        let rate = Vector3::new(0.0, 0.0, 0.05 * swing * (swing * time_s).cos()) + drift;
        let mut noise = || -> f64 { StandardNormal.sample(&mut self.random) };
        let mut noises = |std: f64| Vector3::from_fn(|_, _| std * noise());
        let (sin, cos) = self.angle_rad.sin_cos();
        let up = Vector3::new(cos, -sin, 0.0) * self.spec.gravity_m_s2 + noises(0.03);
        let count = |value: Vector3<f64>| [0, 1, 2].map(|axis| value[axis].round() as i16);
        let gyro = (rate + noises(0.01)) / self.spec.gyro.matrix[(0, 0)];
        (count(gyro), count(up / self.spec.accel.matrix[(0, 0)]))
    }
}

/// Ten minutes with a drift of 0.5 °/s that grows by 1 °/s: what is followed is the true drift, across
/// the vertical, to a tenth of a degree a second and the lag of a minute; the words follow the
/// equations.
#[test]
fn a_growing_drift_is_followed() {
    let spec = AttitudeSpec::thesis();
    let constants = derive(&spec).expect("the thesis' filter");
    let unit = 2.0 / spec.sample_time_s * 2f64.powi(-32 - constants.drift.shift as i32);
    for seed in [3, 4] {
        let mut sway = Sway {
            spec,
            random: ChaCha8Rng::seed_from_u64(seed),
            angle_rad: 0.0,
        };
        let mut reference = RawFilter::new(&spec);
        let (mut state, _) = align(&START, [4096, 0, 0], &constants);
        reference.align([4096, 0, 0]);
        let mut drift = [0; 3];
        let (mut apart_rad_s, mut apart_rad) = (0.0_f64, 0.0_f64);
        let mut worst_rad = 0.0_f64;
        let direction = Vector3::new(1.0, -1.0, 1.0);
        let steps = 600_000;
        for step in 0..steps {
            let time_s = f64::from(step) * spec.sample_time_s;
            let true_drift = direction * (0.5 + time_s / 600.0).to_radians();
            let (gyro, accel) = sway.sample(time_s, &true_drift);
            (state, drift) = step_tracked(&state, drift, gyro, accel, &constants);
            reference.update_imu_tracked(gyro, accel);
            let found = Vector3::from(drift.map(|word| f64::from(word) * unit));
            apart_rad_s = apart_rad_s.max((found - reference.drift_rad_s()).amax());
            let angle = f64::from(pivot_angle(state.quaternion, 0)) * 2f64.powi(-28);
            apart_rad = apart_rad.max(wrap_angle(angle - reference.angle_rad()).abs());
            if step > 120_000 {
                worst_rad = worst_rad.max((angle - sway.angle_rad).abs());
            }
        }
        let found = reference.drift_rad_s();
        println!(
            "seed {seed}: drift {:?} °/s of 1.5, words apart by {:.1e} °/s and {:.1e} rad, angle off by {:.3}°",
            (found * (180.0 / PI)).as_slice(),
            apart_rad_s.to_degrees(),
            apart_rad,
            worst_rad.to_degrees()
        );
        // About the vertical (the sensor's x axis here) six axes show nothing.
        for axis in [1, 2] {
            let error = found[axis] - direction[axis] * 1.5_f64.to_radians();
            assert!(
                error.to_degrees().abs() < 0.25,
                "seed {seed}: axis {axis} off by {error}"
            );
        }
        assert!(
            found[0].to_degrees().abs() < 0.1,
            "seed {seed}: {}",
            found[0]
        );
        assert!(
            apart_rad_s.to_degrees() < 0.02,
            "seed {seed}: {apart_rad_s}"
        );
        assert!(apart_rad < 5e-4, "seed {seed}: {apart_rad}");
        assert!(worst_rad.to_degrees() < 0.5, "seed {seed}: {worst_rad}");
    }
}

/// A drift beyond the stated largest one is followed up to it, and no further.
#[test]
fn the_estimate_stays_within_its_limit() {
    let spec = AttitudeSpec {
        drift_limit_rad_s: 0.5_f64.to_radians(),
        drift_time_s: 5.0,
        ..AttitudeSpec::thesis()
    };
    let constants = derive(&spec).expect("the thesis' filter");
    let mut sway = Sway {
        spec,
        random: ChaCha8Rng::seed_from_u64(8),
        angle_rad: 0.0,
    };
    let (mut state, _) = align(&START, [4096, 0, 0], &constants);
    let mut drift = [0; 3];
    for step in 0..60_000 {
        let true_drift = Vector3::new(0.0, 0.0, 1.0_f64.to_radians());
        let (gyro, accel) = sway.sample(f64::from(step) * 1e-3, &true_drift);
        (state, drift) = step_tracked(&state, drift, gyro, accel, &constants);
    }
    assert_eq!(drift[2], constants.drift.limit);
}
