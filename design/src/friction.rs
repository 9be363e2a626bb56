//! The loop at both extremes of Coulomb friction.
//!
//! A design may include Coulomb friction in the linear model as a viscous term μ/ι, with a
//! smoothing speed ι. That is a choice, not physics: at speeds well above ι, the damping is
//! smaller, and where the pivot sticks, it is larger. A design is therefore checked at both extremes:
//! with all of μ/ι, and with none of it.
//!
//! The two extremes have different consequences. Without the damping that it counted on, an unstable loop falls.
//! With too much damping near rest, it cannot fall, because friction damps a faster motion less.
//! Instead it *hunts*: a slow oscillation with constant amplitude. For an oscillation with rate amplitude
//! V, dry friction of torque μ acts like the viscous friction 4μ/(πV) (its describing function;
//! A. Gelb and W. Vander Velde, "Multiple-Input Describing Functions", 1968, table B.1). The
//! loop therefore hunts with the V whose equivalent friction makes it marginally stable.

use crate::controller::LinearController;
use crate::error::DesignError;
use crate::margins::{Margins, margins};
use crate::matrix::{check_positive, of_model};
use crate::poles::eigenvalues;
use crate::zero_order_hold::zero_order_hold;
use nalgebra::{Complex, RowVector3};
use plant::LinearModel;

/// The same bench, linearised with none and with all of its Coulomb friction as damping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrictionExtremes {
    /// No Coulomb friction at all.
    pub none: LinearModel,
    /// All Coulomb friction, as the viscous term μ/ι.
    pub all: LinearModel,
    /// The smoothing speed ι of that term, in rad/s.
    pub smoothing_speed_rad_s: f64,
}

impl FrictionExtremes {
    /// The bench with viscous friction of `share` times μ/ι.
    fn with_share(&self, share: f64) -> LinearModel {
        LinearModel {
            state: self.none.state + (self.all.state - self.none.state) * share,
            input: self.none.input,
        }
    }
}

/// An oscillation around upright that dry friction maintains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hunting {
    /// Amplitude of the body rate in rad/s.
    pub rate_rad_s: f64,
    /// Amplitude of the angle in rad.
    pub angle_rad: f64,
    /// Frequency in rad/s.
    pub frequency_rad_s: f64,
}

/// The designed loop at one of the extremes.
#[derive(Clone, Debug, PartialEq)]
pub struct ExtremeCheck {
    /// Continuous equivalents of the closed loop's poles, in 1/s.
    pub closed_loop_poles_per_s: Vec<Complex<f64>>,
    /// Largest modulus of the discrete poles.
    pub spectral_radius: f64,
    /// Margins of the loop; `None` if it is unstable.
    pub margins: Option<Margins>,
}

impl ExtremeCheck {
    /// Whether the loop is stable at this extreme.
    pub fn is_stable(&self) -> bool {
        self.spectral_radius < 1.0
    }
}

/// The designed loop at both extremes.
#[derive(Clone, Debug, PartialEq)]
pub struct FrictionCheck {
    /// Without Coulomb friction.
    pub none: ExtremeCheck,
    /// With all Coulomb friction as damping.
    pub all: ExtremeCheck,
    /// The oscillation that unsmoothed friction maintains; `None` if no amount of damping
    /// makes the loop unstable.
    pub hunting: Option<Hunting>,
}

/// The loop of `gains` sampled at `sample_time_s`, at both extremes.
///
/// # Errors
/// Entries that are not finite, a sample time that is not positive. An unstable loop is a result,
/// not an error.
pub fn friction_check(
    extremes: &FrictionExtremes,
    gains: &RowVector3<f64>,
    sample_time_s: f64,
) -> Result<FrictionCheck, DesignError> {
    Ok(FrictionCheck {
        none: check(&extremes.none, gains, sample_time_s)?,
        all: check(&extremes.all, gains, sample_time_s)?,
        hunting: hunting(extremes, gains, sample_time_s)?,
    })
}

/// The smallest friction that makes the loop marginally stable, as the oscillation with that equivalent friction.
fn hunting(
    extremes: &FrictionExtremes,
    gains: &RowVector3<f64>,
    sample_time_s: f64,
) -> Result<Option<Hunting>, DesignError> {
    check_positive(
        "the speed of the friction's linearisation in rad/s",
        extremes.smoothing_speed_rad_s,
    )?;
    let poles_at = |share: f64| -> Result<Vec<Complex<f64>>, DesignError> {
        let (a, b) = of_model(&extremes.with_share(share))?;
        let hold = zero_order_hold(&a, &b, sample_time_s)?;
        let controller = LinearController::state_feedback(gains);
        eigenvalues(&controller.closed_loop(&hold.state, &hold.input)?)
    };
    let is_stable = |share: f64| -> Result<bool, DesignError> {
        Ok(poles_at(share)?.iter().all(|pole| pole.norm() < 1.0))
    };
    if !is_stable(0.0)? {
        return Ok(None);
    }
    // In steps of 10 %, from friction that hardly matters to oscillations whose rate is a
    // millionth of ι.
    let (mut stable, mut unstable) = (0.0, 1e-3);
    while is_stable(unstable)? {
        stable = unstable;
        unstable *= 1.1;
        if unstable > 1e6 {
            return Ok(None);
        }
    }
    for _ in 0..60 {
        let middle = 0.5 * (stable + unstable);
        if is_stable(middle)? {
            stable = middle;
        } else {
            unstable = middle;
        }
    }
    let marginal = poles_at(unstable)?
        .into_iter()
        .max_by(|left, right| left.norm().total_cmp(&right.norm()));
    // A real pole at 1 is no oscillation.
    Ok(marginal
        .map(|pole| pole.arg().abs() / sample_time_s)
        .filter(|frequency| *frequency > 0.0)
        .map(|frequency_rad_s| {
            let rate_rad_s =
                4.0 * extremes.smoothing_speed_rad_s / (std::f64::consts::PI * unstable);
            Hunting {
                rate_rad_s,
                angle_rad: rate_rad_s / frequency_rad_s,
                frequency_rad_s,
            }
        }))
}

fn check(
    model: &LinearModel,
    gains: &RowVector3<f64>,
    sample_time_s: f64,
) -> Result<ExtremeCheck, DesignError> {
    let (a, b) = of_model(model)?;
    let controller = LinearController::state_feedback(gains);
    let hold = zero_order_hold(&a, &b, sample_time_s)?;
    let poles = eigenvalues(&controller.closed_loop(&hold.state, &hold.input)?)?;
    let spectral_radius = poles.iter().map(|pole| pole.norm()).fold(0.0, f64::max);
    Ok(ExtremeCheck {
        closed_loop_poles_per_s: poles
            .into_iter()
            .map(|pole| pole.ln() / sample_time_s)
            .collect(),
        spectral_radius,
        margins: if spectral_radius < 1.0 {
            Some(margins(&a, &b, &controller, sample_time_s)?)
        } else {
            None
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lqr::continuous_regulator;
    use crate::thesis;

    const COULOMB_TORQUE: f64 = 4.485e-4;
    const VISCOUS: f64 = 2.12e-5;

    fn bench(smoothing_speed: Option<f64>) -> LinearModel {
        let mut parameters = thesis::PARAMETERS;
        parameters[4] = VISCOUS + smoothing_speed.map_or(0.0, |speed| COULOMB_TORQUE / speed);
        thesis::model_of(parameters)
    }

    /// The smaller ι, the more damping the design assumes, and the worse its loop balances a bench whose friction is
    /// only viscous. The expected numbers were computed independently and have two digits.
    #[test]
    fn believing_in_friction_costs_damping() {
        for (speed, gains, pole) in [
            (0.0846768, [-24.5, -2.15], (-12.0, 6.0)),
            (0.01, [-33.6, -1.45], (-7.5, 18.0)),
            (0.001, [-163.0, -0.83], (-3.3, 49.0)),
        ] {
            let regulator = continuous_regulator(&bench(Some(speed)), &thesis::weights()).unwrap();
            for (gain, golden) in regulator.gains.iter().zip(gains) {
                assert!(
                    (gain - golden).abs() < 0.006 * golden.abs(),
                    "{gain} at {speed}"
                );
            }
            // A short sample time stands for the continuous loop.
            let none = bench(None);
            let result = check(&none, &regulator.gains, 1e-5).unwrap();
            let upper = result
                .closed_loop_poles_per_s
                .iter()
                .find(|pole| pole.im > 1.0)
                .unwrap();
            assert!((upper.re - pole.0).abs() < 0.5, "{upper} at {speed}");
            assert!((upper.im - pole.1).abs() < 0.5, "{upper} at {speed}");
            assert!(result.is_stable() && result.margins.is_some());
        }
    }

    #[test]
    fn both_extremes_are_reported() {
        let extremes = FrictionExtremes {
            none: bench(None),
            all: bench(Some(0.01)),
            smoothing_speed_rad_s: 0.01,
        };
        let result = friction_check(&extremes, &thesis::golden_gains(), 1e-3).unwrap();
        assert!(result.none.is_stable());
        assert!(result.none.spectral_radius != result.all.spectral_radius);
        let reversed = friction_check(&extremes, &-thesis::golden_gains(), 1e-3).unwrap();
        assert!(!reversed.none.is_stable() && reversed.none.margins.is_none());
    }

    /// The amplitude follows from μ alone, however the friction was linearised.
    #[test]
    fn hunting_does_not_depend_on_the_linearisation() {
        let at = |speed: f64| {
            let extremes = FrictionExtremes {
                none: bench(None),
                all: bench(Some(speed)),
                smoothing_speed_rad_s: speed,
            };
            hunting(&extremes, &thesis::golden_gains(), 1e-3)
                .unwrap()
                .unwrap()
        };
        let (one, other) = (at(0.01), at(0.2));
        assert!((one.rate_rad_s / other.rate_rad_s - 1.0).abs() < 1e-9);
        assert!((one.frequency_rad_s / other.frequency_rad_s - 1.0).abs() < 1e-9);
        // The equivalent friction 4μ/(πV) makes the loop marginal.
        let equivalent = 4.0 * COULOMB_TORQUE / (std::f64::consts::PI * one.rate_rad_s);
        let marginal = bench(Some(COULOMB_TORQUE / equivalent));
        let radius = check(&marginal, &thesis::golden_gains(), 1e-3)
            .unwrap()
            .spectral_radius;
        assert!((radius - 1.0).abs() < 1e-9, "{radius}");
    }
}
