//! Figures of a diagnosis: the errors after each step, the suspects, the decays, and the last model.

use crate::diagnosis::DiagnosisReport;
use crate::error::Error;
use crate::output_file::OutputFile;

impl DiagnosisReport {
    /// The error after each step, the suspects, the decay of the swings, and the last model compared with
    /// the measurements.
    ///
    /// # Errors
    /// [`Error::Figure`].
    pub fn drawings(&self) -> Result<Vec<OutputFile>, Error> {
        let mut files = vec![
            OutputFile::svg("staircase", self.staircase()?),
            OutputFile::svg("suspects", self.suspects_figure()),
        ];
        if let Some(missing) = &self.missing_torque {
            files.push(OutputFile::svg(
                "missing-torque",
                missing.drawing(&self.bench),
            ));
        }
        for decay in &self.decay {
            files.extend(decay.drawing(&self.bench)?);
        }
        files.extend(self.last.drawings()?);
        Ok(OutputFile::distinct(files))
    }

    fn staircase(&self) -> Result<String, Error> {
        let names: Vec<String> = self.steps.iter().map(|step| step.name()).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let mut lines: Vec<(String, bool, Vec<f64>)> = Vec::new();
        for (series, noise) in self.sensor_noise.iter() {
            let over_noise = |value: Option<f64>| value.map_or(f64::NAN, |rmse| rmse / noise);
            let seen = self
                .steps
                .iter()
                .map(|step| over_noise(step.rmse.of(series)));
            lines.push((series.to_string(), false, seen.collect()));
            let unseen = self
                .steps
                .iter()
                .map(|step| over_noise(step.validation_rmse.of(series)));
            let unseen: Vec<f64> = unseen.collect();
            if unseen.iter().any(|ratio| ratio.is_finite()) {
                lines.push((series.to_string(), true, unseen));
            }
        }
        let traces: Vec<figures::StaircaseTrace> = lines
            .iter()
            .map(|(name, held_out, ratios)| figures::StaircaseTrace {
                name,
                held_out: *held_out,
                rmse_over_floor: ratios,
            })
            .collect();
        Ok(figures::staircase(&figures::Staircase {
            title: &format!("{}: the error after each added effect", self.bench),
            subtitle: &self.sentence,
            steps: &names,
            traces: &traces,
        })?)
    }

    fn suspects_figure(&self) -> String {
        let suspects: Vec<figures::SuspectBar> = self
            .suspects
            .iter()
            .map(|suspect| figures::SuspectBar {
                name: &suspect.effect,
                probability: suspect.probability,
                evidence: &suspect.fingerprint,
            })
            .collect();
        figures::suspects(&figures::Suspects {
            title: &format!("{}: what the model lacks", self.bench),
            subtitle: &self.sentence,
            suspects: &suspects,
        })
    }
}
