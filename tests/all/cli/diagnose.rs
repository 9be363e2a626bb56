//! `flywheel diagnose`: on benches simulated here by other means than the program's own, and on
//! benches and recordings of others where they are at hand.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use super::{bench::noise, contents, done, json_of, parameter};

/// A bench with hidden effects; SI units.
#[derive(Clone, Copy, Default)]
struct Hidden {
    body_coulomb: f64,
    body_drag: f64,
    wheel_coulomb: f64,
    /// What the angle's column shows while the body hangs, rad.
    angle_zero: f64,
    /// Growth of the pivot's dry friction per second, as a share of it.
    friction_growth: f64,
}

const TOTAL_INERTIA: f64 = 2.1e-3;
const WHEEL_INERTIA: f64 = 1.3e-4;
const GRAVITY_TORQUE: f64 = 0.23;
const TORQUE_CONSTANT: f64 = 0.031;
const BODY_FRICTION: f64 = 3e-5;
const WHEEL_FRICTION: f64 = 1.6e-5;
/// Half the width of the noise of angle and wheel speed, which is uniform.
const ANGLE_NOISE: f64 = 2e-3;
const WHEEL_NOISE: f64 = 1.0;
/// Inner steps in a sample; semi-implicit Euler.
const INNER: usize = 200;

impl Hidden {
    fn free_swing(&self, start_rad: f64, duration_s: f64, salt: usize) -> String {
        let mut text = "time_s,angle_rad\n".to_owned();
        let (mut angle, mut rate) = (start_rad, 0.0_f64);
        let samples = (duration_s / 0.005) as usize;
        for sample in 0..samples {
            let seen = angle + self.angle_zero + 2.0 * ANGLE_NOISE * noise(salt + sample);
            let dry = self.body_coulomb * (1.0 + self.friction_growth * 0.005 * sample as f64);
            text.push_str(&format!("{:.3},{seen:.6}\n", 0.005 * sample as f64));
            for _ in 0..INNER {
                let step_s = 0.005 / INNER as f64;
                let torque = BODY_FRICTION * rate
                    + dry * (rate / 0.005).tanh()
                    + self.body_drag * rate * rate.abs()
                    + GRAVITY_TORQUE * angle.sin();
                rate -= step_s * torque / TOTAL_INERTIA;
                angle += step_s * rate;
            }
        }
        text
    }

    fn spin_up(&self, start_rad_s: f64, current_a: f64, duration_s: f64, salt: usize) -> String {
        let mut text = "time_s,wheel_speed_rad_s,current_A\n".to_owned();
        let mut speed = start_rad_s;
        let samples = (duration_s / 0.01) as usize;
        for sample in 0..samples {
            let seen = speed + 2.0 * WHEEL_NOISE * noise(salt + sample);
            let time_s = 0.01 * sample as f64;
            text.push_str(&format!("{time_s:.2},{seen:.4},{current_a}\n"));
            for _ in 0..INNER {
                let torque = TORQUE_CONSTANT * current_a
                    - WHEEL_FRICTION * speed
                    - self.wheel_coulomb * speed.tanh();
                speed += 0.01 / INNER as f64 * torque / WHEEL_INERTIA;
            }
        }
        text
    }

    /// Writes a bench with two swings, spin-ups with these currents, and a coast-down from 300 rad/s
    /// that lasts `coast_s`.
    fn write(&self, folder: &Path, currents_a: &[f64], coast_s: f64) {
        let mut toml = format!(
            "[bench]\nname = \"made here\"\n\n[known]\ntorque_constant = {TORQUE_CONSTANT}\n\
             gravity_torque = {GRAVITY_TORQUE}\n"
        );
        let mut add = |name: &str, kind: &str, text: String| {
            let file = format!("{}.csv", name.replace(' ', "-"));
            toml.push_str(&format!(
                "\n[[experiment]]\nname = \"{name}\"\nkind = \"{kind}\"\nfile = \"{file}\"\n"
            ));
            fs::write(folder.join(file), text).expect("write a log");
        };
        add("swing 20 deg", "free-swing", self.free_swing(0.35, 20.0, 0));
        add(
            "swing 50 deg",
            "free-swing",
            self.free_swing(0.87, 20.0, 10_000),
        );
        for (index, &current_a) in currents_a.iter().enumerate() {
            let text = self.spin_up(0.0, current_a, 5.0, 20_000 + 1000 * index);
            add(&format!("spin-up {current_a} A"), "spin-up", text);
        }
        let text = self.spin_up(300.0, 0.0, coast_s, 40_000);
        add("coast-down", "spin-up", text);
        fs::write(folder.join("bench.toml"), toml).expect("write bench.toml");
    }
}

/// Diagnoses a bench whose folder stays as it is.
fn diagnosis(bench: &Path) -> Value {
    let other = tempfile::tempdir().expect("a folder");
    let before = contents(bench);
    let json = json_of([
        "diagnose".as_ref(),
        bench.as_os_str(),
        "--model".as_ref(),
        other.path().join("model.toml").as_os_str(),
        "--out".as_ref(),
        other.path().join("out").as_os_str(),
        "--json".as_ref(),
        "-".as_ref(),
    ]);
    assert_eq!(
        before,
        contents(bench),
        "the bench folder is left as it was"
    );
    // A base model that follows nothing is written nowhere.
    let has_failed = json["has_failed_at_first"] == true;
    assert_eq!(other.path().join("model.toml").exists(), !has_failed);
    for figure in json["figures"].as_array().expect("figures") {
        let path = Path::new(figure.as_str().expect("a path"));
        assert!(path.exists(), "{} is missing", path.display());
    }
    json
}

/// The effects that were added for certain.
fn added(json: &Value) -> Vec<&str> {
    let steps = json["steps"].as_array().expect("steps");
    assert_eq!(steps[0]["effect"], Value::Null, "the model as it was");
    let mut effects: Vec<&str> = steps[1..]
        .iter()
        .filter(|step| step.get("provisional").is_none())
        .map(|step| step["effect"].as_str().expect("an effect"))
        .collect();
    effects.sort_unstable();
    effects
}

fn assert_verdict(json: &Value, verdict: &str, effects: &[&str]) {
    assert_eq!(json["verdict"], verdict, "{}", json["sentence"]);
    assert_eq!(added(json), effects, "{}", json["sentence"]);
    assert!(
        !json["where"].as_array().expect("where").is_empty(),
        "where is always filled"
    );
}

/// The sets that tie, sorted.
fn ties(json: &Value) -> Vec<Vec<&str>> {
    let sets = json["ambiguous_between"].as_array().expect("sets");
    let mut sets: Vec<Vec<&str>> = sets
        .iter()
        .map(|set| {
            let set = set.as_array().expect("a set").iter();
            set.map(|effect| effect.as_str().expect("a name")).collect()
        })
        .collect();
    sets.sort();
    sets
}

#[test]
fn nothing_is_missing_where_nothing_is_hidden() {
    let folder = tempfile::tempdir().expect("a folder");
    Hidden::default().write(folder.path(), &[0.3, 0.6, -0.4], 5.0);
    let json = diagnosis(folder.path());
    assert_verdict(&json, "nothing-missing", &[]);
}

#[test]
fn apply_adds_what_is_missing_and_the_error_falls_to_the_noise() {
    let folder = tempfile::tempdir().expect("a folder");
    let hidden = Hidden {
        body_drag: 3e-5,
        ..Hidden::default()
    };
    hidden.write(folder.path(), &[0.3, 0.6, -0.4], 5.0);
    let bench = folder.path().as_os_str();
    let json = json_of([
        "diagnose".as_ref(),
        bench,
        "--apply".as_ref(),
        "--json".as_ref(),
        "-".as_ref(),
    ]);
    assert_verdict(&json, "explained", &["body-quadratic-drag"]);

    let last = &json["steps"][1];
    let (drag, std) = parameter(last, "body_quadratic_drag");
    let std = std.expect("a standard error");
    assert!(
        (drag - hidden.body_drag).abs() < 4.0 * std,
        "{drag} ± {std}"
    );
    assert!(std < 0.1 * hidden.body_drag, "± {std}");
    // The noise is uniform: its standard deviation is the half width over √3.
    let floor = ANGLE_NOISE / 3.0_f64.sqrt();
    let rmse = |step: usize| {
        let rmse = &json["steps"][step]["rmse"]["swing 50 deg/angle"];
        rmse.as_f64().expect("an error")
    };
    assert!(rmse(0) > 2.0 * floor, "the misfit shows: {}", rmse(0));
    assert!(rmse(1) < 1.05 * floor, "down to the noise: {}", rmse(1));

    let change = &json["design_change"];
    assert_ne!(change["before"]["gains"], change["after"]["gains"]);
    let model = fs::read_to_string(folder.path().join("model.toml")).expect("model.toml");
    assert!(model.contains("\"body-quadratic-drag\""), "{model}");
    // What was added stays added, and nothing more is missing.
    let again = json_of(["diagnose".as_ref(), bench, "--json".as_ref(), "-".as_ref()]);
    assert_verdict(&again, "nothing-missing", &[]);
    let text = done(["compare".as_ref(), bench]);
    assert!(text.contains("body-quadratic-drag"), "{text}");
}

/// A potentiometer whose zero is anywhere: the swing does not even cross zero.
#[test]
fn a_swing_around_a_zero_of_its_own_is_fitted_there() {
    let bench = tempfile::tempdir().expect("a folder");
    let hidden = Hidden {
        body_coulomb: 4e-4,
        angle_zero: 0.93,
        ..Hidden::default()
    };
    hidden.write(bench.path(), &[0.2, 0.5], 12.0);
    let json = diagnosis(bench.path());
    assert_verdict(
        &json,
        "explained",
        &["angle-offset", "body-coulomb-friction"],
    );
    let (zero, std) = parameter(&json["steps"][2], "angle_offset");
    let std = std.expect("a standard error");
    assert!(
        (zero - 0.93).abs() < 4.0 * std && std < 1e-3,
        "{zero} {std}"
    );
}

/// Friction that grows with time is in nobody's library: dry friction is named, which is most of it, and
/// nothing that would only soak up the rest.
#[test]
fn what_remains_of_an_unknown_cause_is_not_laid_at_the_door_of_others() {
    let bench = tempfile::tempdir().expect("a folder");
    let hidden = Hidden {
        body_coulomb: 2e-4,
        friction_growth: 0.1,
        ..Hidden::default()
    };
    hidden.write(bench.path(), &[0.2, 0.5], 12.0);
    let json = diagnosis(bench.path());
    assert_verdict(&json, "unexplained", &["body-coulomb-friction"]);
    assert!(!json["where"].as_array().expect("where").is_empty());
}

/// The names in a list.
fn texts(list: &Value) -> Vec<&str> {
    let list = list.as_array().expect("a list").iter();
    list.map(|text| text.as_str().expect("a text")).collect()
}

/// The effects of the last model beside viscous friction.
fn last_model(json: &Value) -> Vec<&str> {
    let mut effects = texts(&json["final"]["effects"]);
    effects.retain(|effect| !effect.contains("viscous"));
    effects
}

/// With all currents forward and no standstill, dry friction of the wheel takes away the same torque
/// at every instant: so does an offset of the current.
#[test]
fn a_tie_is_declared_and_the_experiment_that_breaks_it_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let hidden = Hidden {
        wheel_coulomb: 1.2e-3,
        ..Hidden::default()
    };
    hidden.write(folder.path(), &[0.3, 0.5, 0.7], 3.0);
    let json = diagnosis(folder.path());
    assert_verdict(&json, "ambiguous", &[]);
    assert_eq!(
        ties(&json),
        [["current-offset"], ["wheel-coulomb-friction"]]
    );
    // The more usual of them predicts until then.
    let last = json["steps"].as_array().expect("steps").last();
    let last = last.expect("a step");
    assert_eq!(last["effect"], "wheel-coulomb-friction");
    assert_eq!(last["provisional"], true);
    assert_eq!(last_model(&json), ["wheel-coulomb-friction"]);
    let next = json["next_experiment"].as_str().expect("a sentence");
    assert!(
        next.contains("reversed") || next.contains("coast-down"),
        "{next}"
    );

    // The experiment is made, and the tie is gone.
    let settled = tempfile::tempdir().expect("a folder");
    hidden.write(settled.path(), &[0.3, 0.5, 0.7, -0.5], 3.0);
    let json = diagnosis(settled.path());
    assert_verdict(&json, "explained", &["wheel-coulomb-friction"]);
}

#[test]
fn an_open_tie_stays_open_until_the_user_or_an_experiment_decides() {
    let folder = tempfile::tempdir().expect("a folder");
    let hidden = Hidden {
        wheel_coulomb: 1.2e-3,
        ..Hidden::default()
    };
    hidden.write(folder.path(), &[0.3, 0.5, 0.7], 3.0);
    let bench = folder.path().as_os_str();
    let diagnose = |apply: bool| {
        let mut arguments = vec!["diagnose".as_ref(), bench, "--json".as_ref(), "-".as_ref()];
        if apply {
            arguments.push("--apply".as_ref());
        }
        json_of(arguments)
    };
    let add = |effect: &str| {
        json_of([
            "add".as_ref(),
            effect.as_ref(),
            "--bench".as_ref(),
            bench,
            "--json".as_ref(),
            "-".as_ref(),
        ])
    };
    let model = || fs::read_to_string(folder.path().join("model.toml")).expect("model.toml");
    diagnose(true);
    assert!(model().contains("provisional = [\"wheel-coulomb-friction\"]"));
    assert!(model().contains("rivals = [[\"current-offset\"]]"));
    // What is provisional predicts, and yet the tie is found again.
    let compared = json_of(["compare".as_ref(), bench, "--json".as_ref(), "-".as_ref()]);
    let predicted = compared["rmse"]["coast-down/wheel_speed"].as_f64();
    let floor = WHEEL_NOISE / 3.0_f64.sqrt();
    assert!(predicted.expect("an error") < 1.1 * floor);
    let again = diagnose(false);
    assert_verdict(&again, "ambiguous", &[]);
    assert_eq!(ties(&again).len(), 2);

    // The rival takes its place, provisionally; named once more it is confirmed.
    let swapped = add("current-offset");
    assert_eq!(texts(&swapped["provisional"]), ["current-offset"]);
    assert!(model().contains("provisional = [\"current-offset\"]"));
    assert!(model().contains("rivals = [[\"wheel-coulomb-friction\"]]"));
    let confirmed = add("current-offset");
    assert!(texts(&confirmed["provisional"]).is_empty());
    assert!(!model().contains("provisional") && !model().contains("rivals"));
    assert!(model().contains("\"current-offset\""));
}

/// The same bench, whatever the model has to begin with.
#[test]
fn the_end_does_not_depend_on_the_effects_at_the_start() {
    let folder = tempfile::tempdir().expect("a folder");
    let hidden = Hidden {
        body_coulomb: 3e-4,
        body_drag: 2e-5,
        ..Hidden::default()
    };
    hidden.write(folder.path(), &[0.3, -0.5], 3.0);
    let from_base = diagnosis(folder.path());
    let expected = ["body-coulomb-friction", "body-quadratic-drag"];
    assert_verdict(&from_base, "explained", &expected);
    for (start, verdict) in [
        (&["body-softening-spring"][..], "explained"),
        (&["body-quadratic-drag"], "explained"),
        (&expected, "nothing-missing"),
    ] {
        fs::remove_file(folder.path().join("model.toml")).ok();
        let bench = folder.path().as_os_str();
        for effect in start {
            done(["add".as_ref(), effect.as_ref(), "--bench".as_ref(), bench]);
        }
        let json = json_of(["diagnose".as_ref(), bench, "--json".as_ref(), "-".as_ref()]);
        assert_eq!(json["verdict"], verdict, "{start:?}: {}", json["sentence"]);
        assert_eq!(last_model(&json), expected, "from {start:?}");
        let rmse = |json: &Value| json["final"]["rmse"]["swing 50 deg/angle"].as_f64();
        let (one, other) = (rmse(&json), rmse(&from_base));
        let (one, other) = (one.expect("an error"), other.expect("an error"));
        assert!((one / other - 1.0).abs() < 1e-3, "{one} {other}");
    }
}

/// A wheel of another lab, of which nothing is known, coasts down; its friction is dry, and wanders by a fifth.
/// The decisive effect is there however much remains.
#[test]
fn what_takes_nearly_all_of_an_error_is_added_although_something_remains() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut log = "time_s,wheel_speed_rad_s\n".to_owned();
    let (mut speed, step_s) = (120.0_f64, 0.02);
    let mut sample = 0;
    while speed > 0.5 {
        let time_s = step_s * sample as f64;
        let seen = speed + 0.02 * noise(sample);
        log.push_str(&format!("{time_s:.2},{seen:.5}\n"));
        for inner in 0..20 {
            let time_s = time_s + step_s * inner as f64 / 20.0;
            let dry = 0.5 * (1.0 + 0.2 * (time_s / 11.0).sin());
            speed -= step_s / 20.0 * (0.004 * speed + dry);
        }
        sample += 1;
    }
    fs::write(folder.path().join("coast.csv"), log).expect("a log");
    let toml = "[bench]\nname = \"coasting\"\n\n[[experiment]]\nname = \"coast\"\n\
                kind = \"spin-up\"\nfile = \"coast.csv\"\nconstants = { current = 0.0 }\n";
    fs::write(folder.path().join("bench.toml"), toml).expect("bench.toml");
    let json = diagnosis(folder.path());
    assert_verdict(&json, "unexplained", &[]);
    assert_eq!(last_model(&json), ["wheel-coulomb-friction"]);
    let rmse = |of: &Value| of["rmse"]["coast/wheel_speed"].as_f64().expect("an error");
    let (before, after) = (rmse(&json["steps"][0]), rmse(&json["final"]));
    assert!(after < 0.3 * before, "{after} {before}");
    // An offset of the current is the same torque where nothing reverses.
    assert!(ties(&json).contains(&vec!["wheel-coulomb-friction"]));
    // One log: its second half is predicted by its first.
    assert_eq!(json["held_out_by"], "second-halves");
    assert!(json["remains"]["over_noise"].as_f64().expect("a number") > 3.0);
    let suspect = &json["suspects"][0];
    let share = suspect["takes_away"]["coast/wheel_speed"].as_f64();
    assert!(share.expect("a share") > 0.7);
    let probability = suspect["probability"].as_f64().expect("a number");
    assert!(probability > 0.3, "{probability}");
}

/// A file of the recordings that are no part of the project; only for tests that need them.
fn recordings(path: &str) -> PathBuf {
    Path::new(env!("FLYWHEEL_RECORDINGS")).join(path)
}

#[test]
#[cfg_attr(not(have_recordings), ignore = "needs the recordings")]
fn benches_of_an_independent_simulator() {
    for (name, verdict, effects) in [
        ("a-viscous-only", "nothing-missing", &[][..]),
        ("b-dry-pivot", "explained", &["body-coulomb-friction"]),
        ("c-air-drag", "explained", &["body-quadratic-drag"]),
        ("d-dry-wheel", "explained", &["wheel-coulomb-friction"]),
        (
            "e-dry-pivot-and-drag",
            "explained",
            &["body-coulomb-friction", "body-quadratic-drag"],
        ),
        (
            "f-unknown-magnet",
            "unexplained",
            &["body-coulomb-friction"],
        ),
    ] {
        let json = diagnosis(&recordings(&format!("hidden/{name}")));
        assert_verdict(&json, verdict, effects);
        if verdict == "unexplained" {
            let place = &json["where"][0];
            assert_eq!(place["coordinate"], "angle", "{place}");
            let (from, to) = (&place["from"], &place["to"]);
            let (from, to) = (from.as_f64().expect("from"), to.as_f64().expect("to"));
            assert!(
                from < 0.15 && 0.15 < to && to - from < 0.2,
                "{from} to {to}"
            );
        }
    }
}

/// The diagnosis of one recorded free swing.
fn real_swing(file: &str, mapping: &str) -> Value {
    let log = recordings(&format!("real/{file}"));
    let folder = tempfile::tempdir().expect("a folder");
    let log = log.canonicalize().expect("a path");
    let toml = format!(
        "[bench]\nname = \"real\"\n[[experiment]]\nname = \"swing\"\nkind = \"free-swing\"\n\
         file = {log:?}\n{mapping}\n"
    );
    fs::write(folder.path().join("bench.toml"), toml).expect("write");
    diagnosis(folder.path())
}

/// Presliding takes a little of what drag causes and drag a little of what presliding causes: each alone is
/// stuck far from the minimum of both.
#[test]
#[cfg_attr(not(have_recordings), ignore = "needs the recordings")]
fn real_swings_with_dry_friction_and_drag_are_fitted() {
    // In the second log, which is short and has twenty samples a second, drag is common to two explanations that tie: it
    // is added although either leaves more than noise.
    for (file, mapping, limit_mrad) in [
        (
            "bookip_cdip_freeswing_1kHz.csv",
            "columns = { time = \"t_s\", angle = \"angle_rad\" }\nfrom = 8.5",
            2.0,
        ),
        (
            "tud_rwp_freeswing_A_20Hz.csv",
            "columns = { time = \"t_s\", angle = \"pend_rad\" }\nfrom = 2.0",
            0.55,
        ),
    ] {
        let json = real_swing(file, mapping);
        let steps = json["steps"].as_array().expect("steps");
        let names: Vec<&str> = steps
            .iter()
            .filter_map(|step| step["effect"].as_str())
            .collect();
        for effect in ["body-coulomb-friction", "body-quadratic-drag"] {
            assert!(names.contains(&effect), "{file}: {names:?}");
        }
        let rmse = &steps[steps.len() - 1]["rmse"]["swing/angle"];
        let rmse_mrad = 1e3 * rmse.as_f64().expect("a number");
        assert!(rmse_mrad < limit_mrad, "{file}: {rmse_mrad} mrad");
    }
}

#[test]
#[cfg_attr(not(have_recordings), ignore = "needs the recordings")]
fn the_free_swing_of_the_thesis_stays_undecided() {
    let json = real_swing("orig_freeswing_reibung.csv", "columns = { time = \"t_s\" }");
    assert_eq!(json["verdict"], "ambiguous", "{}", json["sentence"]);
    let ties = ties(&json);
    for effect in ["body-presliding-friction", "body-softening-spring"] {
        assert!(
            ties.iter().any(|set| set.contains(&effect)),
            "{effect} is not in {ties:?}"
        );
    }
}
