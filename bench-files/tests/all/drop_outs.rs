//! Lost samples are found, and nothing else is.

use bench_files::{LONGEST_DROP_OUT, drop_outs};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

fn noise(seed: u64, n: usize, sigma: f64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let normal = Normal::new(0.0, sigma).expect("a deviation");
    (0..n).map(|_| normal.sample(&mut rng)).collect()
}

fn times(n: usize, step_s: f64) -> Vec<f64> {
    (0..n).map(|i| i as f64 * step_s).collect()
}

fn added(signal: impl Fn(f64) -> f64, times: &[f64], noise: &[f64]) -> Vec<f64> {
    times
        .iter()
        .zip(noise)
        .map(|(t, e)| signal(*t) + e)
        .collect()
}

fn quantised(values: &[f64], step: f64) -> Vec<f64> {
    values.iter().map(|v| (v / step).round() * step).collect()
}

/// Motions of the bench with the noise of the measurements at hand: time step, noise, signal.
/// Free swing, its rate, a spin-up with its kink at the start, a wheel that reverses fast, a stop
/// against friction, standing still.
type Motion = (&'static str, f64, f64, fn(f64) -> f64);
const MOTIONS: [Motion; 9] = [
    ("swing", 0.004, 1.2e-3, |t| {
        0.9 * (-0.02 * t).exp() * (9.7 * t).cos()
    }),
    ("rate", 0.004, 4e-3, |t| {
        -8.7 * (-0.02 * t).exp() * (9.7 * t).sin()
    }),
    ("swing at 20 Hz", 0.05, 1.2e-3, |t| {
        0.6 * (-0.05 * t).exp() * (9.7 * t).cos()
    }),
    ("rate at 20 Hz", 0.05, 4e-3, |t| {
        -5.8 * (-0.05 * t).exp() * (9.7 * t).sin()
    }),
    ("spin-up", 0.004, 0.6, |t| {
        if t < 1.0 {
            0.0
        } else {
            400.0 * (1.0 - (-(t - 1.0) / 7.8).exp())
        }
    }),
    ("spin-up at 20 Hz", 0.05, 0.3, |t| {
        if t < 1.0 {
            0.0
        } else {
            200.0 * (1.0 - (-(t - 1.0) / 0.8).exp())
        }
    }),
    ("square wave at 20 Hz", 0.05, 0.3, |t| {
        let period = t % 4.0;
        let approach = 1.0 - (-(period % 2.0) / 0.1).exp();
        if period < 2.0 {
            -75.0 + 150.0 * approach
        } else {
            75.0 - 150.0 * approach
        }
    }),
    ("coasting to a stop", 0.004, 0.6, |t| {
        (150.0 - 12.0 * t).max(0.0)
    }),
    ("standing", 0.001, 1.2e-3, |_| 0.0),
];

/// No false alarm in 9 motions × 40 seeds × 5000 samples, with full resolution and quantised, the
/// quantum far below, at and far above the noise.
#[test]
fn clean_logs_have_none() {
    let n = 5000;
    for (name, step_s, sigma, signal) in MOTIONS {
        let t = times(n, step_s);
        for seed in 0..40 {
            let clean = added(signal, &t, &noise(seed, n, sigma));
            for quantum in [0.0, 0.1 * sigma, sigma, 10.0 * sigma] {
                let values = if quantum > 0.0 {
                    quantised(&clean, quantum)
                } else {
                    clean.clone()
                };
                let found = drop_outs(&t, &values);
                assert!(
                    found.is_empty(),
                    "{name}, seed {seed}, quantum {quantum}: {found:?}"
                );
            }
        }
    }
}

/// Noise-free simulations, irregular times, and noise with heavy tails (Student's t with three
/// degrees of freedom is beyond what sensors do; there at most one sample in a thousand may go).
#[test]
fn strange_but_healthy_logs() {
    let n = 5000;
    for (name, step_s, _, signal) in MOTIONS {
        let t = times(n, step_s);
        let found = drop_outs(&t, &added(signal, &t, &vec![0.0; n]));
        assert!(found.is_empty(), "{name} without noise: {found:?}");
    }
    for seed in 0..20 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut t = Vec::with_capacity(n);
        let mut now = 0.0;
        for _ in 0..n {
            now += 0.004 * rng.random_range(0.2..3.0);
            t.push(now);
        }
        let values = added(MOTIONS[0].3, &t, &noise(seed, n, 1.2e-3));
        let found = drop_outs(&t, &values);
        assert!(found.is_empty(), "irregular, seed {seed}: {found:?}");

        let heavy = rand_distr::StudentT::new(3.0).expect("degrees");
        let tails: Vec<f64> = (0..n).map(|_| 1e-3 * heavy.sample(&mut rng)).collect();
        let found = drop_outs(&t, &added(MOTIONS[0].3, &t, &tails));
        assert!(
            found.len() * 1000 <= n,
            "heavy tails, seed {seed}: {found:?}"
        );
    }
}

/// Zeros, near zeros and spikes of one to three samples, put into every motion where it is far
/// from zero: at least 99 in 100 are found, and nothing beside them.
#[test]
fn lost_samples_are_found_exactly() {
    let n = 4000;
    let (mut put, mut hit) = (0, 0);
    for (name, step_s, sigma, signal) in MOTIONS {
        if name == "standing" {
            continue;
        }
        let t = times(n, step_s);
        for seed in 0..20 {
            let mut values = added(signal, &t, &noise(seed, n, sigma));
            let mut rng = ChaCha8Rng::seed_from_u64(1000 + seed);
            let largest = values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            let mut lost: Vec<usize> = Vec::new();
            for _ in 0..12 {
                let length = rng.random_range(1..=LONGEST_DROP_OUT);
                let at = rng.random_range(30..n - 30);
                let run = at..at + length;
                // Apart from each other, and where a zero is seen at all.
                let near = lost.iter().any(|&j| j.abs_diff(at) < 20);
                let visible = (at - 3..at + length + 3).all(|j| values[j].abs() > 0.7 * largest);
                if near || !visible {
                    continue;
                }
                let value = match rng.random_range(0..3) {
                    0 => 0.0,
                    1 => 0.3 * sigma,
                    _ => -10.0 * largest,
                };
                for j in run {
                    values[j] = value;
                    lost.push(j);
                }
            }
            lost.sort_unstable();
            let found = drop_outs(&t, &values);
            let extra: Vec<usize> = found
                .iter()
                .copied()
                .filter(|i| !lost.contains(i))
                .collect();
            assert!(
                extra.is_empty(),
                "{name}, seed {seed}: {extra:?} are healthy ({lost:?} lost)"
            );
            put += lost.len();
            hit += found.len();
        }
    }
    println!("{hit} of {put} lost samples found");
    assert!(put > 500, "the test must put enough in: {put}");
    assert!(100 * hit >= 99 * put, "{hit} of {put} found");
}

/// A wheel that slows down, passes through zero and stays there for a few samples has lost nothing.
#[test]
fn zero_crossings_are_no_drop_outs() {
    for seed in 0..40 {
        let t = times(2000, 0.05);
        let mut values = added(|t| 20.0 * (0.4 * t).sin(), &t, &noise(seed, 2000, 0.05));
        // The dead band of a speed estimator: small speeds read as zero.
        for value in &mut values {
            if value.abs() < 1.0 {
                *value = 0.0;
            }
        }
        assert_eq!(drop_outs(&t, &values), [0_usize; 0], "seed {seed}");
    }
}

#[test]
fn hopeless_columns() {
    assert!(drop_outs(&[], &[]).is_empty());
    let t = times(20, 0.1);
    assert!(drop_outs(&t, &[5.0; 20]).is_empty(), "constant");
    assert!(
        drop_outs(&t[..4], &[1.0, 0.0, 1.0, 1.0]).is_empty(),
        "too short to judge"
    );
}

/// The real reaction-wheel rig: its wheel speed drops to (almost) zero for one sample twice.
#[test]
#[cfg_attr(not(have_recordings), ignore = "needs the recordings")]
fn the_real_rig() {
    let cases = [
        ("tud_rwp_wheel_step_20Hz", "driven", &[36.05][..]),
        ("tud_rwp_wheel_square_20Hz", "driven", &[4.45]),
        ("tud_rwp_chirp_20Hz", "driven", &[]),
        ("tud_rwp_balance_LQR_20Hz", "balance", &[]),
    ];
    for (name, kind, expected_s) in cases {
        let folder = crate::common::Folder::new();
        let file = crate::common::recordings(&format!("real/{name}.csv"));
        folder.write(
            "bench.toml",
            format!(
                "[[experiment]]\nname = \"one\"\nkind = \"{kind}\"\nfile = {:?}\n\
                 columns = {{ time = \"t_s\", angle = \"pend_rad\", wheel_speed = \"wheel_rad_s\", current = \"current_A\" }}\n\
                 offset = {{ angle = {} }}\n",
                file.display().to_string(),
                if kind == "balance" { std::f64::consts::PI } else { 0.0 },
            )
            .as_bytes(),
        );
        let bench = bench_files::Bench::load(folder.path()).unwrap_or_else(|e| panic!("{e}"));
        let experiment = &bench.experiments[0];
        let found: Vec<f64> = experiment
            .report
            .notes
            .iter()
            .flat_map(|note| match note {
                bench_files::Note::DropOuts { times_s, .. } => times_s.clone(),
                _ => Vec::new(),
            })
            .collect();
        println!("{name}: {:?}", experiment.report.notes);
        assert_eq!(found, expected_s, "{name}");
        let speed = experiment.log.wheel_speed_rad_s.as_ref().expect("speed");
        assert_eq!(
            speed.iter().filter(|v| v.is_nan()).count(),
            expected_s.len()
        );
    }
}
