//! The effects of the library that look alike: the experiment in which two of them are confused, and the experiment
//! that tells the two apart.
//!
//! Only the names in [`EffectInfo::confused_with`](plant::EffectInfo) are written by hand; all else is computed. The
//! effect is simulated on the bench of the pictures, its rival is fitted to that log, and the diagnosis names the
//! experiment in which the two fitted models differ most.

use std::fmt::Write as _;

use bench_files::{Bench, FilesInMemory};
use diagnose::{Explanation, tell_apart};
use identify::{Effort, FitProblem, extend, fit_from_scratch};
use plant::{EffectId, Kind, Model};
use serde::{Deserialize, Serialize};

use crate::effect_portrait::{
    BENCH, GRAVITY_M_S2, PIVOT_TO_WHEEL_M, SCENES, Scene, bench_values, effect_portrait, record,
    times,
};

/// Standard deviation of the noise of angle (rad), rate (rad/s) and wheel speed (rad/s): that of a modest encoder and
/// gyroscope.
const NOISE_STD: [f64; 3] = [1e-3, 5e-3, 0.5];

/// A scene counts if the rival lowers χ² of the base model by at least this factor.
const SEEN: f64 = 2.0;

/// Two effects that a log may not tell apart.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct EffectConfusion {
    /// The other effect.
    pub with: String,
    /// The experiment in which the two look most alike.
    pub alike_in: String,
    /// The experiment that tells the two apart, in few words; `None` if none of the usual experiments does.
    pub told_apart_by: Option<String>,
}

/// The effects with which this effect of the library is confused. A rival that imitates the effect in none of the
/// pictures' experiments is left out. The list is empty for an effect that is confused with none, or that has no
/// picture ([`effect_portrait`]).
pub fn effect_confusions(name: &str) -> Vec<EffectConfusion> {
    let Some(effect) = EffectId::from_name(name) else {
        return vec![];
    };
    let rivals = effect.info().confused_with.iter();
    rivals
        .filter_map(|rival| confusion(effect, EffectId::from_name(rival)?))
        .collect()
}

/// The base model with an effect of the size that its picture shows, and the parameter vector.
fn pictured(effect: EffectId) -> Option<(Model, Vec<f64>)> {
    let portrait = effect_portrait(effect.name())?;
    let model = Model::base().with(effect);
    let mut values = bench_values(&model);
    for (parameter, value, _) in &portrait.parameters {
        values[model.position_of(parameter)?] = *value;
    }
    Some((model, values))
}

/// A rival that was fitted to the log of a scene.
struct Imitation<'a> {
    scene: &'a Scene,
    problem: FitProblem,
    model: Model,
    values: Vec<f64>,
    /// χ² of the fit per sample: 1 if the residuals are noise alone.
    left: f64,
}

fn confusion(effect: EffectId, rival: EffectId) -> Option<EffectConfusion> {
    let shows = |scene: &&Scene| {
        let kinds = [effect.info().shows_in, rival.info().shows_in];
        kinds.iter().all(|kinds| kinds.contains(&scene.kind))
    };
    // A rival that contains the effect imitates it exactly. The question is then whether the effect imitates the rival.
    let contains = rival.info().replaces.contains(&effect.name());
    let (true_one, imitator) = if contains {
        (rival, effect)
    } else {
        (effect, rival)
    };
    let (model, values) = pictured(true_one)?;
    let truth = Explanation {
        model: &model,
        values: &values,
    };
    let best = SCENES
        .iter()
        .filter(shows)
        .filter_map(|scene| imitation(truth, imitator, scene))
        .min_by(|a, b| a.left.total_cmp(&b.left))?;
    let imitation = Explanation {
        model: &best.model,
        values: &best.values,
    };
    Some(EffectConfusion {
        with: rival.name().to_owned(),
        alike_in: best.scene.words.to_owned(),
        told_apart_by: tell_apart(&best.problem, &[truth, imitation])
            .recipe
            .map(|recipe| recipe.experiment),
    })
}

/// Fits the rival to the log that the true effect gives in a scene.
fn imitation<'a>(truth: Explanation, rival: EffectId, scene: &'a Scene) -> Option<Imitation<'a>> {
    let files = log_of(truth, scene);
    let problem = FitProblem::new(&Bench::from_files(&files).ok()?).ok()?;
    let records = problem.all_records();
    let base = Model::base();
    let free = problem.free(&base);
    let start = bench_values(&base);
    let alone = fit_from_scratch(&records, &base, start, &free, Effort::FULL);
    let model = base.with(rival);
    let fitted = extend(&problem, &records, &base, &alone, &model, Effort::FULL);
    let samples: usize = records
        .iter()
        .map(|record| record.len() * record.channels.len())
        .sum();
    // A scene in which the rival helps little hardly shows the effect.
    let is_seen = alone.cost > SEEN * fitted.cost;
    let (values, left) = (fitted.values, fitted.cost / samples.max(1) as f64);
    drop(records);
    (is_seen && left.is_finite()).then_some(Imitation {
        scene,
        problem,
        model,
        values,
        left,
    })
}

/// The files of a bench with one log: the readings of the sensors in a scene, with their noise.
fn log_of(truth: Explanation, scene: &Scene) -> FilesInMemory {
    let (kind, columns, channels): (_, _, &[usize]) = match scene.kind {
        Kind::FreeSwing => ("free-swing", "angle_rad,rate_rad_s", &[0, 1]),
        Kind::SpinUp => ("spin-up", "wheel_speed_rad_s", &[2]),
        Kind::Balance => (
            "balance",
            "angle_rad,rate_rad_s,wheel_speed_rad_s",
            &[0, 1, 2],
        ),
        Kind::Driven => (
            "driven",
            "angle_rad,rate_rad_s,wheel_speed_rad_s",
            &[0, 1, 2],
        ),
    };
    let has_current = scene.kind != Kind::FreeSwing;
    let readings = record(truth.model, truth.values, scene);
    let mut log = format!("time_s,{columns}");
    log.push_str(if has_current { ",current_A\n" } else { "\n" });
    let mut noise = Noise(1);
    for (k, time_s) in times(scene).into_iter().enumerate() {
        let _ = write!(log, "{time_s:.6}");
        for &channel in channels {
            let reading = readings[channel][k] + NOISE_STD[channel] * noise.next();
            let _ = write!(log, ",{reading:.9}");
        }
        if has_current {
            let _ = write!(log, ",{}", (scene.current_a)(time_s));
        }
        log.push('\n');
    }
    let known = |wanted: &str| {
        let found = BENCH.iter().find(|(name, _)| *name == wanted);
        found.map_or(0.0, |(_, value)| *value)
    };
    let bench = format!(
        "[known]\ngravity = {GRAVITY_M_S2}\npivot_to_wheel = {PIVOT_TO_WHEEL_M}\ngravity_torque = {}\n\
         torque_constant = {}\ntotal_inertia = {}\nwheel_inertia = {}\n\n[[experiment]]\nname = \"log\"\nkind = \"{kind}\"\nfile = \"log.csv\"\n",
        known("gravity_torque"),
        known("torque_constant"),
        known("total_inertia"),
        known("wheel_inertia"),
    );
    [("bench.toml", bench), ("log.csv", log)]
        .into_iter()
        .collect()
}

/// Noise of mean 0 and standard deviation 1, the same in every run: the sum of twelve uniform numbers less 6.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        let uniform = |state: &mut u64| {
            // The linear congruential generator of Knuth's MMIX.
            *state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (*state >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..12).map(|_| uniform(&mut self.0)).sum::<f64>() - 6.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The experiment that tells two effects apart.
    fn told_apart_by(name: &str, with: &str) -> String {
        let all = effect_confusions(name);
        let found = all.into_iter().find(|one| one.with == with);
        let found = found.unwrap_or_else(|| panic!("{name} is not confused with {with}"));
        found.told_apart_by.expect("an experiment")
    }

    /// On a wheel that coasts in one direction, dry friction and an offset of the current are the same torque. A run in
    /// the other direction shows the difference.
    #[test]
    fn dry_friction_of_the_wheel_reverses_with_its_speed() {
        let words = told_apart_by("wheel-coulomb-friction", "current-offset");
        assert!(
            ["reversed", "coast-down", "square wave"]
                .iter()
                .any(|one| words.contains(one)),
            "{words}"
        );
    }

    /// With the body clamped, a late current and a late reading of the wheel are the same function of time: only a free
    /// body tells them apart.
    #[test]
    fn a_late_sensor_is_told_from_a_late_motor_by_a_free_body() {
        let words = told_apart_by("motor-lag", "wheel-speed-lag");
        assert!(words.contains("hanging free"), "{words}");
    }
}
