//! The changes in the controller that another model of the same bench makes: gains, poles, recovery angle.

use bench_files::ModelFile;
use serde::{Deserialize, Serialize};

use crate::control_design::ControlDesign;
use crate::error::Error;

/// The designs from two models of one bench.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DesignChange {
    /// From the earlier model.
    pub before: DesignSummary,
    /// From the new one.
    pub after: DesignSummary,
}

/// The main numbers of a controller.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DesignSummary {
    /// K in A/rad, A s/rad, A s/rad.
    pub gains: [f64; 3],
    /// Real and imaginary part of the eigenvalues of A, 1/s.
    pub open_loop_poles: Vec<[f64; 2]>,
    /// Eigenvalues λ of Ad − Bd K as continuous equivalents ln(λ)/T, 1/s.
    pub closed_loop_poles_per_s: Vec<[f64; 2]>,
    /// asin(τ u_max/G): the largest angle at which the motor is stronger than gravity.
    pub recovery_angle_rad: f64,
}

impl DesignChange {
    /// Designs from both models.
    ///
    /// # Errors
    /// The reason why one of the models gives no controller.
    pub fn between(before: ModelFile, after: ModelFile) -> Result<DesignChange, Error> {
        Ok(DesignChange {
            before: DesignSummary::of(&ControlDesign::of(before)?),
            after: DesignSummary::of(&ControlDesign::of(after)?),
        })
    }
}

impl DesignSummary {
    /// The main numbers of a design.
    pub fn of(designed: &ControlDesign) -> DesignSummary {
        let design = designed.design();
        DesignSummary {
            gains: designed.gains(),
            open_loop_poles: design
                .open_loop_poles
                .iter()
                .map(|pole| [pole.value.re, pole.value.im])
                .collect(),
            closed_loop_poles_per_s: design
                .closed_loop_poles_per_s()
                .iter()
                .map(|pole| [pole.re, pole.im])
                .collect(),
            recovery_angle_rad: design.recovery_angle_rad,
        }
    }
}
