//! Recordings of real rigs: figures that independent fits gave.

use bench_files::Bench;
use identify::{FitProblem, FreeDecay, decay, identify};
use plant::{EffectId, Model};

use crate::simulated::data;

/// The columns of most recordings.
const STANDARD: &str = "columns = { time = \"t_s\", angle = \"angle_rad\" }";

/// A bench of one recorded free swing.
fn bench(file: &str, extra: &str) -> FitProblem {
    let path = data(&format!("real/{file}"));
    let folder = tempfile::tempdir().expect("a temporary folder");
    let text = format!(
        "[[experiment]]\nname = \"swing\"\nkind = \"free-swing\"\nfile = \"{}\"\n{extra}\n",
        path.canonicalize().expect("a path").display()
    );
    std::fs::write(folder.path().join("bench.toml"), text).expect("written");
    let bench = Bench::load(folder.path()).unwrap_or_else(|error| panic!("{error}"));
    FitProblem::new(&bench).expect("records")
}

fn decay_of(problem: &FitProblem) -> FreeDecay {
    let found = decay(&problem.records[0]).expect("a swing");
    let (first, last) = (
        found.small_swing_periods[0],
        found.small_swing_periods[found.small_swing_periods.len() - 1],
    );
    eprintln!(
        "{} half cycles, {:.4} s at {:.3} rad to {:.4} ± {:.4} s at {:.3} rad, drift {:?}",
        found.amplitudes.len(),
        first.value,
        first.amplitude_rad,
        last.value,
        last.std,
        last.amplitude_rad,
        found.period_drift_percent
    );
    for law in &found.laws {
        eprintln!(
            "  {:?} {:?} rms {:.3e} relative {:.3e} criterion {:.1}",
            law.has,
            law.coefficients.map(|e| (e.value, e.std)),
            law.rms_rad,
            law.relative_rms,
            law.criterion
        );
    }
    found
}

#[test]
#[cfg_attr(not(have_recordings), ignore = "needs the recordings")]
fn the_period_of_the_thesis_swing_falls_by_four_percent() {
    let problem = bench("orig_freeswing_reibung.csv", STANDARD);
    let found = decay_of(&problem);
    let drift = found.period_drift_percent;
    assert!((drift.value + 3.9).abs() < 2.0 * drift.std, "{drift:?}");
    assert!(drift.value < -6.0 * drift.std, "{drift:?}");
}

#[test]
#[cfg_attr(not(have_recordings), ignore = "needs the recordings")]
fn the_cart_pendulum_dies_out_by_dry_friction_and_quadratic_drag() {
    let problem = bench(
        "bookip_cdip_freeswing_1kHz.csv",
        &format!("{STANDARD}\nfrom = 8.5"),
    );
    let found = decay_of(&problem);
    assert_eq!(found.laws[0].has, [true, false, true]);
    // Relative to the first amplitude, as the independent envelope fit states it: 0.074 % against
    // 0.72 % for dry and viscous friction.
    let relative = |has: [bool; 3]| {
        let law = found.laws.iter().find(|law| law.has == has);
        law.map_or(f64::INFINITY, |law| law.rms_rad / found.amplitudes[0].value)
    };
    assert!(relative([true, false, true]) < 1e-3);
    assert!(relative([true, true, false]) > 5e-3);
}

#[test]
#[cfg_attr(not(have_recordings), ignore = "needs the recordings")]
fn the_cubli_swing_dies_out_by_dry_friction() {
    let extra = "columns = { time = \"t_s\", angle = \"angle_rad_from_pot_scale\" }\n\
                 offset = { angle = -0.72 }";
    let problem = bench("aau_cubli_freeswing_00.csv", extra);
    let found = decay_of(&problem);
    assert!(found.laws[0].has[0], "{:?}", found.laws[0]);
}

#[test]
#[cfg_attr(not(have_recordings), ignore = "needs the recordings")]
fn the_other_reaction_wheel_pendulum_dies_out_by_dry_friction_and_quadratic_drag() {
    let extra = "columns = { time = \"t_s\", angle = \"pend_rad\" }";
    let problem = bench("tud_rwp_freeswing_A_20Hz.csv", extra);
    let found = decay_of(&problem);
    assert_eq!(found.laws[0].has, [true, false, true]);
}

#[test]
#[cfg_attr(not(have_recordings), ignore = "needs the recordings")]
fn the_thesis_swing_is_fitted_as_well_as_an_independent_program_did() {
    let problem = bench("orig_freeswing_reibung.csv", STANDARD);
    // mrad; independent fits gave 22.3, 19.1 and 8.4.
    for (effect, limit) in [
        (None, 22.3),
        (Some(EffectId::BodyCoulombFriction), 19.1),
        (Some(EffectId::BodyPreslidingFriction), 8.5),
    ] {
        let model = effect.map_or(Model::base(), |effect| Model::base().with(effect));
        let found = identify(&problem, &model, None).expect("a fit");
        let rmse_mrad = 1e3 * found.traces[0][0].rmse;
        eprintln!("{effect:?}: {rmse_mrad:.2} mrad");
        assert!(rmse_mrad < limit + 0.05, "{effect:?}: {rmse_mrad}");
    }
}
