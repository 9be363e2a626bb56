//! A simulated bench, made here and by other means than the program's own: semi-implicit Euler in
//! very small steps for Θ α̈ + r α̇ + μ sign α̇ + G sin α = 0, and the exact solution of
//! j φ̈ + r_w φ̇ = τ u, with a little deterministic noise.

use std::fs;
use std::path::Path;

pub const TOTAL_INERTIA: f64 = 2.3e-3;
pub const WHEEL_INERTIA: f64 = 1.36e-4;
pub const GRAVITY_TORQUE: f64 = 0.245;
pub const TORQUE_CONSTANT: f64 = 0.0335;
pub const BODY_FRICTION: f64 = 2e-5;
pub const COULOMB_TORQUE: f64 = 4.5e-4;
pub const WHEEL_FRICTION: f64 = 1.75e-5;

/// A number in (−0.5, 0.5) that depends on `index` alone (a hash; no generator needed).
pub fn noise(index: usize) -> f64 {
    let mut x = index as u64 + 0x9e37_79b9_7f4a_7c15;
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (x >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
}

fn free_swing(start_rad: f64) -> String {
    let mut text = "t_ms,pend_deg\n".to_owned();
    let (mut angle, mut rate) = (start_rad, 0.0_f64);
    for sample in 0..6000 {
        let seen = angle.to_degrees() + 0.2 * noise(sample);
        text.push_str(&format!("{},{seen:.4}\n", sample * 4));
        for _ in 0..400 {
            let torque = -BODY_FRICTION * rate
                - COULOMB_TORQUE * (rate / 0.01).tanh()
                - GRAVITY_TORQUE * angle.sin();
            rate += 1e-5 * torque / TOTAL_INERTIA;
            angle += 1e-5 * rate;
        }
    }
    text
}

fn spin_up(current: f64) -> String {
    let mut text = "time_s,wheel_speed_rad_s,current_A\n".to_owned();
    for sample in 0..800 {
        let time = 0.01 * sample as f64;
        let fall = (-WHEEL_FRICTION / WHEEL_INERTIA * time).exp();
        let speed = TORQUE_CONSTANT * current / WHEEL_FRICTION * (1.0 - fall);
        let seen = speed + 2.0 * noise(sample);
        text.push_str(&format!("{time},{seen:.5},{current}\n"));
    }
    text
}

/// Sensors and drive, which every command that writes a model copies into it.
const HARDWARE: &str = "[hardware.gyroscope]\npart = \"MPU-6050\"\naxes = [\"x\", \"y\", \"z\"]\n\n\
    [hardware.accelerometer]\npart = \"MPU-6050\"\naxes = [\"x\", \"y\", \"z\"]\n\n\
    [hardware.wheel_speed]\nkind = \"converter\"\nslope = 0.4\noffset = -819.2\nlow = 0\nhigh = 4095\n\n\
    [hardware.drive]\npart = \"ESCON 24/2\"\namperes_per_count = 8.4e-5\n\n";

/// Writes the bench into a folder.
pub fn write(folder: &Path) {
    let toml = format!(
        "[bench]\nname = \"made here\"\n\n[known]\ntorque_constant = {TORQUE_CONSTANT}\n\
         gravity_torque = {GRAVITY_TORQUE}\n\n{HARDWARE}\
         [[experiment]]\nname = \"swing\"\nkind = \"free-swing\"\nfile = \"swing.csv\"\n\
         columns = {{ time = \"t_ms\", angle = \"pend_deg\" }}\n\
         units = {{ time = \"ms\", angle = \"deg\" }}\n\n\
         [[experiment]]\nname = \"spin-up 0.5 A\"\nkind = \"spin-up\"\nfile = \"up.csv\"\n\n\
         [[experiment]]\nname = \"spin-up -0.5 A\"\nkind = \"spin-up\"\nfile = \"down.csv\"\n"
    );
    for (name, text) in [
        ("bench.toml", toml),
        ("swing.csv", free_swing(0.35)),
        ("up.csv", spin_up(0.5)),
        ("down.csv", spin_up(-0.5)),
    ] {
        fs::write(folder.join(name), text).expect("write the bench");
    }
}
