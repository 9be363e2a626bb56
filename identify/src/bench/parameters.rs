//! The parameters of a model on a bench: which are free, in which unit, and where a fit of them starts.

use plant::{
    BASE_PARAMETERS, Driving, EffectId, GRAVITY_TORQUE, Given, Kind, Model, Role, StartFrom,
    TORQUE_CONSTANT, TOTAL_INERTIA, WHEEL_INERTIA,
};

use super::problem::FitProblem;
use crate::fit::{Ratios, base_values, driving_samples, is_of_wheel, ratios};
use crate::records::Record;

impl FitProblem {
    /// The positions of the parameters of `model` that a fit adjusts: neither known nor a whole number, and visible in
    /// at least one experiment.
    pub fn free(&self, model: &Model) -> Vec<usize> {
        let (body, wheel) = self.moved();
        let infos = model.parameters();
        (0..infos.len())
            .filter(|&position| {
                let shown = match position {
                    TOTAL_INERTIA | GRAVITY_TORQUE => body,
                    WHEEL_INERTIA => wheel,
                    TORQUE_CONSTANT => {
                        wheel
                            && self.records.iter().any(|record| {
                                record.kind != Kind::FreeSwing && !record.current_a.is_empty()
                            })
                    }
                    _ if model.effect_at(position).is_some_and(is_of_wheel) => wheel,
                    _ => body,
                };
                // An `angle_zero` may belong to a log that this bench does not have; the fit then leaves it out.
                let has_log = model.range_at(position).is_none_or(|(effect, own)| {
                    let mut records = self.records.iter();
                    records.any(|record| effect.is_of_log(position - own.start, &record.name))
                });
                let given = self.known.get(position).is_some_and(Option::is_some);
                let is_measured = model.range_at(position).is_some_and(|(effect, own)| {
                    let mut given = effect.info().given.iter();
                    given.any(|(at, _)| own.start + at == position)
                });
                shown && !is_measured && has_log && !given && !infos[position].is_whole
            })
            .collect()
    }

    /// The effect for the logs of this bench. An effect with one parameter per log gets a parameter for each log that
    /// has the distorted channel; any other effect is unchanged.
    pub fn made_for_logs(&self, effect: EffectId) -> EffectId {
        let senses = effect.info().senses;
        let shows = |record: &&Record| {
            senses.is_some_and(|output| record.channel(output).is_some())
                && effect.info().shows_in.contains(&record.kind)
        };
        let records = self.records.iter().filter(shows);
        effect.for_logs(
            &records
                .map(|record| record.name.clone())
                .collect::<Vec<_>>(),
        )
    }

    /// The unit of a parameter of `model` on this bench; "… per kg m2" where the scale of its torques is unknown.
    pub fn unit(&self, model: &Model, position: usize) -> String {
        let info = model.parameters()[position];
        let is_wheel = match position {
            TOTAL_INERTIA | GRAVITY_TORQUE => false,
            WHEEL_INERTIA | TORQUE_CONSTANT => true,
            _ => model
                .effect_at(position)
                .is_some_and(|effect| matches!(effect.info().role, Role::Wheel | Role::Motor)),
        };
        let known = if is_wheel {
            self.wheel_scale_known
        } else {
            self.body_scale_known
        };
        if info.is_torque && !known {
            format!("{} per kg m2", info.unit)
        } else {
            info.unit.to_owned()
        }
    }

    /// Start values for a fit of `model`, SI: base parameters from the samples, each effect at the first of its stated
    /// starts.
    pub fn start_values(&self, model: &Model) -> Vec<f64> {
        self.values_from(&ratios(&self.all_records()), model)
    }

    /// As [`FitProblem::start_values`], with base parameters from these ratios.
    pub(crate) fn values_from(&self, ratios: &Ratios, model: &Model) -> Vec<f64> {
        let (base, body_friction, wheel_friction) = base_values(ratios, &self.known);
        let mut values = base.to_vec();
        // The stated starts hold for torques of a bench with Θ ≈ 2e-3 kg m².
        for &effect in model.effects() {
            match (effect.info().start_from, effect.info().role) {
                (StartFrom::Damping, Role::Wheel) => values.push(wheel_friction),
                (StartFrom::Damping, _) => values.push(body_friction),
                _ => values.extend(self.scaled(effect, effect.info().starts[0], &base)),
            }
        }
        values
    }

    /// Parameter sets from which the fit of an effect may start on this bench, beside the base parameters `base`: those
    /// that the effect states, and those that the logs suggest.
    pub fn starts(
        &self,
        records: &[&Record],
        effect: EffectId,
        base: &[f64; BASE_PARAMETERS.len()],
    ) -> Vec<Vec<f64>> {
        let stated = effect.info().starts.iter();
        let mut starts: Vec<Vec<f64>> = stated
            .map(|start| self.scaled(effect, start, base))
            .collect();
        if let StartFrom::Driving(of) = effect.info().start_from {
            starts.extend(of(&Driving {
                samples: driving_samples(records),
                torque_constant: base[TORQUE_CONSTANT],
                ohm: self.scale(Role::Motor, base),
            }));
        }
        starts
    }

    /// A stated start whose torques are scaled to the size of the bench.
    fn scaled(
        &self,
        effect: EffectId,
        start: &[f64],
        base: &[f64; BASE_PARAMETERS.len()],
    ) -> Vec<f64> {
        let info = effect.info();
        let scale = self.scale(info.role, base);
        let parameters = info.parameters.iter().zip(start);
        let mut values: Vec<f64> = parameters
            .map(|(info, value)| {
                if info.is_torque {
                    value * scale
                } else {
                    *value
                }
            })
            .collect();
        for &(at, given) in info.given {
            values[at] = self.given(given).unwrap_or(values[at]);
        }
        values
    }

    /// A measured value of the bench, where it is known.
    pub fn given(&self, given: Given) -> Option<f64> {
        match given {
            Given::Gravity => self.masses.gravity,
            Given::PivotToWheel => self.masses.pivot_to_wheel,
        }
    }

    /// The size of this bench relative to the one for which the library states its starts: Θ = 2.3e-3 kg m² and
    /// j_w = 1.4e-4 kg m² (thesis). A motor's supply voltage does not grow with the wheel. It is scaled only where the
    /// torque constant, which is also the back-EMF constant, is per unit of inertia.
    fn scale(&self, role: Role, base: &[f64; BASE_PARAMETERS.len()]) -> f64 {
        match role {
            Role::Body => base[TOTAL_INERTIA] / 2.3e-3,
            Role::Motor if self.wheel_scale_known => 1.0,
            Role::Wheel | Role::Motor => base[WHEEL_INERTIA] / 1.4e-4,
            Role::Sensor => 1.0,
        }
    }
}
