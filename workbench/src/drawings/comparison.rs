//! Figures of a model compared with the measurements: one per experiment, and the residuals in which it fails.

use identify::{Output, ResidualBreakdown, ResidualKind};

use crate::comparison::{ComparisonReport, ExperimentCurves};
use crate::error::Error;
use crate::named::Named;
use crate::numbers::{significant, with_prefix};
use crate::output_file::{OutputFile, file_name};
use crate::shading::Shading;
use crate::words::spoken;

/// Largest number of figures of broken-down residuals.
const MOST_BREAKDOWNS: usize = 4;

/// The shaded stretches. They are often many and narrow, so that only the longest has the label.
fn regions_of(shading: &Shading) -> Vec<figures::Region<'_>> {
    let length = |[from, to]: &[f64; 2]| to - from;
    let stretches = &shading.stretches_s;
    let longest = stretches
        .iter()
        .max_by(|a, b| length(a).total_cmp(&length(b)));
    let region = |stretch: &[f64; 2]| figures::Region {
        from: stretch[0],
        until: stretch[1],
        label: match longest {
            Some(longest) if longest == stretch => &shading.text,
            _ => "",
        },
    };
    stretches.iter().map(region).collect()
}

impl ComparisonReport {
    /// Every experiment with prediction and residual on one time axis, and the most significant residuals
    /// over every coordinate.
    ///
    /// # Errors
    /// [`Error::Figure`] if curves of one experiment differ in length.
    pub fn drawings(&self) -> Result<Vec<OutputFile>, Error> {
        let mut files = Vec::new();
        for experiment in &self.curves {
            let name = file_name(&experiment.experiment);
            let svg = self.overlay(experiment)?;
            files.push(OutputFile::svg(&format!("compare-{name}"), svg));
        }
        files.extend(self.residuals());
        Ok(OutputFile::distinct(files))
    }

    fn overlay(&self, experiment: &ExperimentCurves) -> Result<String, Error> {
        let notes: Vec<String> = experiment
            .channels
            .iter()
            .map(|channel| {
                format!(
                    "RMSE {}, fit {} %",
                    with_prefix(channel.rmse, channel.channel.unit()),
                    significant(channel.fit_percent, 4)
                )
            })
            .collect();
        // Where samples are left out (pushes), the model makes no prediction.
        let models: Vec<Vec<f64>> = experiment
            .channels
            .iter()
            .map(|channel| {
                let samples = channel.simulated.iter().zip(&experiment.counts);
                samples
                    .map(|(model, counts)| if *counts { *model } else { f64::NAN })
                    .collect()
            })
            .collect();
        let channels: Vec<figures::OverlayChannel> = experiment
            .channels
            .iter()
            .zip(&models)
            .zip(&notes)
            .map(|((channel, model), note)| figures::OverlayChannel {
                quantity: figures::Quantity {
                    name: spoken(channel.channel.name()),
                    unit: channel.channel.unit(),
                },
                measurement: &channel.measured,
                model,
                sensor_std: channel.noise_std,
                note,
            })
            .collect();
        let pushes = self.pushes.iter();
        let pushes: Vec<(f64, String)> = pushes
            .filter(|push| push.experiment == experiment.experiment)
            .map(|push| (push.time_s, with_prefix(push.impulse_nms, "N m s")))
            .collect();
        let markers: Vec<figures::Marker> = pushes
            .iter()
            .map(|(at, label)| figures::Marker { at: *at, label })
            .collect();
        let shading = self.shading(&experiment.experiment);
        let regions = shading.as_ref().map_or(vec![], regions_of);
        Ok(figures::overlay(&figures::Overlay {
            title: &format!("{}: {}", self.bench, experiment.experiment),
            subtitle: &format!("Model with {}", self.effects.join(", ")),
            time_s: &experiment.time_s,
            channels: &channels,
            regions: &regions,
            markers: &markers,
            zoom_s: None,
        })?)
    }

    /// The most significant residuals, each over every coordinate.
    fn residuals(&self) -> Vec<OutputFile> {
        let mut shown: Vec<(&str, &str, ResidualKind)> = Vec::new();
        for place in self.places.iter().filter(|place| place.significant) {
            let residual = (
                place.experiment.as_str(),
                place.channel.as_str(),
                place.residual,
            );
            if !shown.contains(&residual) && shown.len() < MOST_BREAKDOWNS {
                shown.push(residual);
            }
        }
        shown
            .into_iter()
            .map(|(experiment, channel, quantity)| {
                let parts: Vec<&ResidualBreakdown> = self
                    .breakdowns
                    .iter()
                    .filter(|part| {
                        part.experiment == experiment
                            && part.channel == channel
                            && part.quantity == quantity
                    })
                    .collect();
                let what = quantity.name();
                let name = file_name(&format!("{experiment} {channel} {what}"));
                let svg = self.residual(experiment, channel, what, &parts);
                OutputFile::svg(&format!("where-{name}"), svg)
            })
            .collect()
    }

    fn residual(
        &self,
        experiment: &str,
        channel: &str,
        what: &str,
        parts: &[&ResidualBreakdown],
    ) -> String {
        let bins: Vec<Vec<figures::ResidualBin>> = parts
            .iter()
            .map(|part| {
                // Bins are shared by all experiments; those without values of this experiment are left out.
                let visited = part.bins.iter().filter(|bin| bin.count > 0.0);
                let bins = visited.map(|bin| figures::ResidualBin {
                    from: bin.from,
                    until: bin.to,
                    mean: bin.mean,
                    mean_std: bin.mean_std,
                    share_of_error: bin.share,
                });
                bins.collect()
            })
            .collect();
        let panels: Vec<figures::BreakdownPanel> = parts
            .iter()
            .zip(&bins)
            .map(|(part, bins)| figures::BreakdownPanel {
                coordinate: figures::Quantity {
                    name: spoken(part.coordinate.name()),
                    unit: part.coordinate.unit(),
                },
                residual: figures::Quantity {
                    name: "residual",
                    unit: match part.quantity {
                        ResidualKind::ResidualTorque => self.torque_unit(channel),
                        ResidualKind::Output => {
                            Output::from_name(part.channel).map_or("", Output::unit)
                        }
                    },
                },
                bins,
                sensor_std: part.noise_std,
                note: "",
            })
            .collect();
        figures::breakdown(&figures::Breakdown {
            title: &format!(
                "{}: {what} in {experiment} ({})",
                self.bench,
                spoken(channel)
            ),
            subtitle: "What the model leaves unexplained, over each coordinate",
            panels: &panels,
        })
    }
}
