//! Fitted values that the cause of an effect cannot have: the term then imitates something else.

use bench_files::numbers::significant;
use identify::{Fit, FitProblem, Minimum, Record, finish};
use plant::{EffectId, Model, PhysicalRange};

/// A fitted value outside the range that the cause of its effect bounds.
#[derive(Clone, Debug, PartialEq)]
pub struct Unphysical {
    /// The effect.
    pub effect: EffectId,
    /// The range that the value leaves, with the reason for it.
    pub range: PhysicalRange,
    /// The value, or the ratio of two.
    pub value: f64,
    /// Its standard error; `None` if it is not determined, as for a value on a bound of the fit.
    pub std: Option<f64>,
}

impl Unphysical {
    /// How many standard errors the value lies outside the range; infinite if it has none.
    pub fn sigmas(&self) -> f64 {
        let std = self.std.unwrap_or(0.0);
        self.range.beyond(self.value) / std
    }

    /// What is bounded, and its unit.
    fn quantity(&self) -> (String, &'static str) {
        let infos = self.effect.info().parameters;
        let name = infos[self.range.parameter].name;
        match self.range.over {
            Some(over) => (format!("{name} / {}", infos[over].name), ""),
            None => (name.to_owned(), infos[self.range.parameter].unit),
        }
    }

    /// Why the effect is no explanation, in one sentence.
    pub fn sentence(&self) -> String {
        let name = self.effect.name();
        format!(
            "{name} would fit best, but with {}. Something else acts like it.",
            self.why()
        )
    }

    /// The value, and what the cause of the effect allows: a part of a sentence.
    pub fn why(&self) -> String {
        let (quantity, unit) = self.quantity();
        let with_unit = |value: f64| {
            format!("{} {unit}", significant(value, 3))
                .trim_end()
                .to_owned()
        };
        let (low, high) = self.range.range;
        let allowed = if self.value < low {
            format!("at least {}", with_unit(low))
        } else {
            format!("at most {}", with_unit(high))
        };
        format!(
            "{quantity} = {}, and its cause allows {allowed}: {}",
            with_unit(self.value),
            self.range.reason,
        )
    }
}

/// The values of the `added` effects that lie outside their physical range.
pub fn unphysical(
    problem: &FitProblem,
    records: &[&Record],
    (model, added): (&Model, &[EffectId]),
    minimum: &Minimum,
) -> Vec<Unphysical> {
    let mut found: Vec<(usize, Unphysical)> = vec![];
    for &effect in added {
        let Some(at) = model.position(effect) else {
            continue;
        };
        for &range in effect.info().physical {
            let value = range.of(&minimum.values[at..]);
            if range.beyond(value) > 0.0 {
                let one = Unphysical {
                    effect,
                    range,
                    value,
                    std: None,
                };
                found.push((at, one));
            }
        }
    }
    if !found.is_empty() {
        // Standard errors take time, and nearly no candidate needs them.
        let fit = finish(records, model, &problem.free(model), minimum.clone());
        for (at, one) in &mut found {
            one.std = std(&fit, *at, one);
        }
    }
    found.into_iter().map(|(_, one)| one).collect()
}

/// Below this share of its terms, the variance of a ratio is the rounding of a covariance whose scale is not determined.
const CANCELLED: f64 = 1e-9;

/// The standard error of the value, or of the ratio, of an effect whose parameters begin `at` this position.
fn std(fit: &Fit, at: usize, one: &Unphysical) -> Option<f64> {
    let (top, over) = (
        at + one.range.parameter,
        one.range.over.map(|over| at + over),
    );
    let Some(over) = over else {
        return fit.std(top);
    };
    let index = |position: usize| fit.unknowns.free.iter().position(|&free| free == position);
    let (top, bottom) = (index(top)?, index(over)?);
    let covariance = fit.covariance.as_ref()?;
    let ratio = one.value;
    // var(a/b) b² = var a − 2 (a/b) cov(a, b) + (a/b)² var b
    let variance = covariance[(top, top)] - 2.0 * ratio * covariance[(top, bottom)]
        + ratio * ratio * covariance[(bottom, bottom)];
    let size = covariance[(top, top)] + ratio * ratio * covariance[(bottom, bottom)];
    (variance > CANCELLED * size).then(|| variance.sqrt() / fit.values[over].abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_that_the_noise_may_have_moved_outside_is_not_far_outside() {
        let range = EffectId::MotorLag.info().physical[0];
        let of = |value, std| Unphysical {
            effect: EffectId::MotorLag,
            range,
            value,
            std,
        };
        let high = range.range.1;
        assert!((of(high + 0.02, Some(0.01)).sigmas() - 2.0).abs() < 1e-9);
        // A value that runs against the bound of the fit has no standard error.
        assert_eq!(of(10.0, None).sigmas(), f64::INFINITY);
        let sentence = of(2.5, Some(0.1)).sentence();
        assert!(
            sentence.contains("motor-lag") && sentence.contains("2.5"),
            "{sentence}"
        );
    }
}
