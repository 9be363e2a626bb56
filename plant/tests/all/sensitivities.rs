//! The sensitivities that dual numbers carry against finite differences of whole runs.

use plant::{
    Current, Dual, EffectId, Hold, Input, Kind, Model, Plant, Role, Scalar, State, Timing,
};

use crate::VALUES;

/// The command before the log, A; it differs from the first command of the log.
const BEFORE_A: f64 = 0.9;

/// The outputs of a driven run from 0.3 rad, sample after sample.
fn outputs<S: Scalar>(model: &Model, values: &[S], input: &Input, time_s: &[f64]) -> Vec<S> {
    let plant = Plant::new(model, values, Kind::Driven);
    let start = State {
        angle_rad: S::constant(0.3),
        current_a: S::constant(BEFORE_A),
        ..State::rest()
    };
    let current = Current::Recorded(input);
    let mut out = vec![];
    plant.run(start, time_s, 0..time_s.len(), current, None, |_, r, _| {
        out.extend([r.angle_rad, r.rate_rad_s, r.wheel_speed_rad_s]);
    });
    out
}

/// Compares the derivatives with respect to every parameter of an effect with finite differences. The model is the base
/// model with this effect, whose parameters have the values `own`.
pub fn agree_with_finite_differences(effect: EffectId, own: &[f64]) {
    let info = effect.info();
    let time_s: Vec<f64> = (0..400).map(|k| k as f64 * 0.004).collect();
    let current_a: Vec<f64> = time_s.iter().map(|t| 1.2 * (7.0 * t).sin() + 0.3).collect();
    let inputs = [(Hold::Linear, 1), (Hold::Zero, 1), (Hold::Zero, 3)];
    for (hold, step) in inputs {
        let input = Input::new(&time_s, &current_a, hold);
        let time_s: Vec<f64> = time_s.iter().copied().step_by(step).collect();
        let model = Model::base().with(effect);
        let at = model.range_of(effect).expect("just added");
        let mut values = VALUES.to_vec();
        values.resize(model.parameter_count(), 0.0);
        values[at.clone()].copy_from_slice(own);
        for index in at.clone() {
            let name = info.parameters[index - at.start].name;
            let duals: Vec<Dual<1>> = values
                .iter()
                .enumerate()
                .map(|(k, &v)| Dual::variable(v, usize::from(k != index)))
                .collect();
            let exact: Vec<f64> = outputs(&model, &duals, &input, &time_s)
                .iter()
                .map(|output| output.derivatives[0])
                .collect();
            let h = 1e-5 * values[index].abs().max(1e-4);
            let (mut up, mut down) = (values.clone(), values.clone());
            up[index] += h;
            down[index] -= h;
            let difference: Vec<f64> = outputs(&model, &up, &input, &time_s)
                .iter()
                .zip(outputs(&model, &down, &input, &time_s))
                .map(|(a, b)| (a - b) / (2.0 * h))
                .collect();
            let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
            let error: Vec<f64> = exact.iter().zip(&difference).map(|(a, b)| a - b).collect();
            assert!(norm(&exact) > 0.0, "{name} has no trace");
            // The derivative with respect to the delay of a held command acts over the interval before the change of
            // the command, on average half a sample too early. Relative to the tenths of a second of a swing this is
            // small.
            let is_moved = info.timing == Some(Timing::Delay) && hold == Hold::Zero;
            let tolerance = if is_moved { 0.005 * step as f64 } else { 2e-3 };
            assert!(
                norm(&error) < tolerance * norm(&exact),
                "{name}, every {step}: {} of {}",
                norm(&error),
                norm(&exact)
            );
        }
    }
}

/// Values in the middle of the plausible range; for the limit of the supply, values that this run reaches.
fn plausible(effect: EffectId) -> Vec<f64> {
    if effect.info().is_limit {
        return vec![12.0, 8.0];
    }
    let middle = |&(low, high): &(f64, f64)| {
        if low > 0.0 {
            (low * high).sqrt()
        } else {
            0.3 * high
        }
    };
    let infos = effect.info().parameters.iter();
    infos.map(|info| middle(&info.plausible)).collect()
}

#[test]
fn sensitivities_agree_with_finite_differences_for_every_effect() {
    for &effect in EffectId::ALL {
        let own = match (Model::base().position(effect), effect.info().role) {
            (Some(at), Role::Body | Role::Wheel) => vec![VALUES[at]],
            _ => plausible(effect),
        };
        agree_with_finite_differences(effect, &own);
    }
}
