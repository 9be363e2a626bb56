//! From the minimum of a model to that of a larger one.

use plant::{EffectId, Model, StartFrom};

use crate::bench::FitProblem;
use crate::fit::{Effort, Minimum, cogging_start, fit_from_scratch, refit};
use crate::records::Record;
use crate::shape_search::shaped_start;

/// Parameter values of `model` that continue those of `from`. Shared parameters keep their values, an effect that
/// replaces another takes over the parameters that they share, and the others take their values from `start`.
pub fn carry_over(from: &Model, values: &[f64], model: &Model, start: &[f64]) -> Vec<f64> {
    model
        .parameters()
        .iter()
        .enumerate()
        .map(|(position, info)| match from.position_of(info.name) {
            Some(at) => values[at],
            None => replaced(from, model, position).map_or(start[position], |at| values[at]),
        })
        .collect()
}

/// Where `from` has what the parameter of a log takes the place of.
fn replaced(from: &Model, model: &Model, position: usize) -> Option<usize> {
    let effect = model.effect_at(position)?;
    from.position_of(effect.info().per_log?)
}

/// Fits `model`, starting from a minimum of the smaller model `from`. Every stated start of the new effects is tried,
/// and the best fit is kept. `effort` is that of the last fit.
pub fn extend(
    problem: &FitProblem,
    records: &[&Record],
    from: &Model,
    minimum: &Minimum,
    model: &Model,
    effort: Effort,
) -> Minimum {
    let free = problem.free(model);
    let base = [0, 1, 2, 3].map(|position| minimum.values[position]);
    let starts = |effect: EffectId| -> Vec<Vec<f64>> {
        match effect.info().start_from {
            StartFrom::Ripple => cogging_start(records, from, minimum)
                .map(|start| start.parameters_of(effect))
                .into_iter()
                .collect(),
            _ => {
                let mut starts = problem.starts(records, effect, &base);
                if let (EffectId::External(_), Some(stated)) = (effect, starts.first()) {
                    starts.extend(shaped_start(records, from, minimum, effect, stated));
                }
                starts
            }
        }
    };
    let new: Vec<EffectId> = model
        .effects()
        .iter()
        .copied()
        .filter(|&effect| !from.has(effect))
        .collect();
    let starts: Vec<(EffectId, Vec<Vec<f64>>)> = new
        .into_iter()
        .map(|effect| (effect, starts(effect)))
        .collect();
    let is_outsider = starts
        .iter()
        .any(|(effect, _)| matches!(effect, EffectId::External(_)));
    let tries = starts.iter().map(|(_, starts)| starts.len()).max();
    let tries = tries.unwrap_or(1).max(1);
    let mut best: Option<Minimum> = None;
    for attempt in 0..tries {
        if attempt > 0 && (effort.cancelled)() {
            break;
        }
        let mut start = vec![0.0; model.parameter_count()];
        for (effect, starts) in &starts {
            let at = model.position(*effect).unwrap_or(0);
            if let Some(chosen) = starts.get(attempt).or(starts.last()) {
                start[at..at + chosen.len()].copy_from_slice(chosen);
            }
        }
        let values = carry_over(from, &minimum.values, model, &start);
        if is_outsider {
            // The minimum of such an effect is hard to locate, and the cost over whole logs has many local minima. The fit
            // therefore begins with short windows, over which the cost is nearly quadratic, and lengthens them.
            let rough = Effort::ROUGH.until(effort.cancelled);
            let grown = fit_from_scratch(records, model, values.clone(), &free, rough);
            if best.as_ref().is_none_or(|best| grown.cost < best.cost) {
                best = Some(grown);
            }
        }
        let look = if tries == 1 && !is_outsider {
            effort
        } else {
            Effort::ROUGH.until(effort.cancelled)
        };
        let candidate = refit(records, model, values, minimum.windows.clone(), &free, look);
        if best.as_ref().is_none_or(|best| candidate.cost < best.cost) {
            best = Some(candidate);
        }
    }
    match best {
        Some(best) if tries > 1 || is_outsider => {
            refit(records, model, best.values, best.windows, &free, effort)
        }
        Some(best) => best,
        None => minimum.clone(),
    }
}
