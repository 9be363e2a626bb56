//! What another model of the same bench changes in the controller: gains, poles, recovery angle.

use std::path::Path;

use bench_files::ModelFile;
use serde::Serialize;

use crate::model_design::ModelDesign;
use crate::report::numbers::{complex, significant};
use crate::report::table::{Align, Table};

/// The designs from two models of one bench.
#[derive(Serialize)]
pub struct DesignChange {
    before: Summary,
    after: Summary,
}

#[derive(Serialize)]
struct Summary {
    gains: [f64; 3],
    /// 1/s.
    open_loop_poles: Vec<[f64; 2]>,
    /// Eigenvalues of Ad − Bd K as continuous equivalents ln(λ)/T, 1/s.
    closed_loop_poles_per_s: Vec<[f64; 2]>,
    recovery_angle_rad: f64,
}

impl DesignChange {
    /// Designs from both models; the error says why no controller can be had from one of them.
    pub fn new(before: ModelFile, after: ModelFile, path: &Path) -> Result<DesignChange, String> {
        let design = |file| match ModelDesign::of(file, path) {
            Ok(designed) => Ok(Summary::of(&designed)),
            Err(failure) => Err(failure.to_string()),
        };
        Ok(DesignChange {
            before: design(before)?,
            after: design(after)?,
        })
    }

    /// The table of what was and what is.
    pub fn text(&self) -> String {
        let mut table = Table::new(&[
            ("", Align::Left),
            ("before", Align::Left),
            ("after", Align::Left),
        ]);
        let gains = |summary: &Summary| {
            let gains = summary.gains.map(|gain| significant(gain, 6));
            gains.join(", ")
        };
        let poles = |poles: &[[f64; 2]]| {
            let poles: Vec<String> = poles.iter().map(|[re, im]| complex(*re, *im)).collect();
            poles.join(", ")
        };
        let angle = |summary: &Summary| format!("{:.2}°", summary.recovery_angle_rad.to_degrees());
        let (before, after) = (&self.before, &self.after);
        table.row(["gains K".to_owned(), gains(before), gains(after)]);
        table.row([
            "open-loop poles, 1/s".to_owned(),
            poles(&before.open_loop_poles),
            poles(&after.open_loop_poles),
        ]);
        table.row([
            "closed-loop poles, 1/s".to_owned(),
            poles(&before.closed_loop_poles_per_s),
            poles(&after.closed_loop_poles_per_s),
        ]);
        table.row(["recovery angle".to_owned(), angle(before), angle(after)]);
        format!(
            "\nWhat the new model changes in the design\n{}",
            table.text()
        )
    }
}

impl Summary {
    fn of(designed: &ModelDesign) -> Summary {
        let design = &designed.design;
        Summary {
            gains: [0, 1, 2].map(|index| design.gains[index]),
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
