//! A bench with a magnet near the path of the body, simulated independently of the program: two swings at 250 Hz.

use std::fmt::Write;

const TOTAL: f64 = 2.30344e-3;
const GRAVITY: f64 = 0.245158;
const VISCOUS: f64 = 2.12e-5;

/// The torque of the magnet, N m, positive towards positive angles.
pub fn torque(angle_rad: f64) -> f64 {
    let z = (angle_rad - 0.15) / 0.06;
    0.006 * z * (-z * z).exp()
}

pub const BENCH: &str = r#"
[bench]
name = "magnet"

[known]
gravity_torque = 0.245158

[[experiment]]
name = "swing 20 deg"
kind = "free-swing"
file = "swing-20.csv"

[[experiment]]
name = "swing 52 deg"
kind = "free-swing"
file = "swing-52.csv"
"#;

/// Its files.
pub fn files() -> Vec<(&'static str, String)> {
    files_with_dry_friction(0.0)
}

/// Its files if the pivot also has dry friction of this torque, N m.
pub fn files_with_dry_friction(dry_nm: f64) -> Vec<(&'static str, String)> {
    files_of(torque, dry_nm)
}

/// The files of a bench with this torque over the angle in the place of the magnet's, N m.
pub fn files_of(pull: fn(f64) -> f64, dry_nm: f64) -> Vec<(&'static str, String)> {
    vec![
        ("bench.toml", BENCH.to_owned()),
        ("swing-20.csv", swing(20.0, pull, dry_nm, 1)),
        ("swing-52.csv", swing(52.0, pull, dry_nm, 2)),
    ]
}

/// A swing of 30 s, Runge–Kutta of order 4 with half a millisecond, and the noise of the thesis' sensors.
fn swing(degrees: f64, pull: fn(f64) -> f64, dry_nm: f64, seed: u64) -> String {
    let acceleration = |angle: f64, rate: f64| {
        let friction = VISCOUS * rate + dry_nm * (rate / 0.01).tanh();
        (pull(angle) - GRAVITY * angle.sin() - friction) / TOTAL
    };
    let mut state = seed;
    let mut noise = || -> f64 {
        let sum: f64 = (0..12)
            .map(|_| {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                (state >> 11) as f64 / (1u64 << 53) as f64
            })
            .sum();
        sum - 6.0
    };
    let (mut angle, mut rate) = (degrees.to_radians(), 0.0);
    let mut text = String::from("time_s,angle_rad,rate_rad_s\n");
    let h = 5e-4;
    for sample in 0..7500 {
        let _ = writeln!(
            text,
            "{:.3},{:.6},{:.6}",
            f64::from(sample) * 4e-3,
            angle + 1.2e-3 * noise(),
            rate + 4e-3 * noise()
        );
        for _ in 0..8 {
            let k1 = (rate, acceleration(angle, rate));
            let at = |k: (f64, f64), h: f64| {
                let (angle, rate) = (angle + h * k.0, rate + h * k.1);
                (rate, acceleration(angle, rate))
            };
            let k2 = at(k1, h / 2.0);
            let k3 = at(k2, h / 2.0);
            let k4 = at(k3, h);
            angle += h / 6.0 * (k1.0 + 2.0 * k2.0 + 2.0 * k3.0 + k4.0);
            rate += h / 6.0 * (k1.1 + 2.0 * k2.1 + 2.0 * k3.1 + k4.1);
        }
    }
    text
}
