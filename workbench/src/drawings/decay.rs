//! Decay rate and small-swing period of a free swing over its amplitude.

use figures::{DecayPanel, DecayPoint, Quantity};
use identify::{AtAmplitude, FreeDecay};

use crate::error::Error;
use crate::numbers::with_uncertainty;
use crate::output_file::{OutputFile, file_name};
use crate::swing_decay::{SwingDecay, over_amplitude};
use crate::words::amplitude_law;

impl SwingDecay {
    /// The swing's decay, measured and according to the model; `None` if the curves are not available.
    ///
    /// # Errors
    /// [`Error::Figure`].
    pub fn drawing(&self, bench: &str) -> Result<Option<OutputFile>, Error> {
        let Some(measured) = &self.measured else {
            return Ok(None);
        };
        let svg = self.figure(bench, measured)?;
        let name = format!("decay-{}", file_name(&self.experiment));
        Ok(Some(OutputFile::svg(&name, svg)))
    }

    fn figure(&self, bench: &str, measured: &FreeDecay) -> Result<String, Error> {
        let points = |series: &[AtAmplitude]| -> Vec<DecayPoint> {
            let points = series.iter().map(|at| DecayPoint {
                amplitude: at.amplitude_rad,
                value: at.value,
                std: at.std,
            });
            points.collect()
        };
        let model = self.simulated.as_ref();
        let rates = points(&measured.rates);
        let periods = points(&measured.small_swing_periods);
        let rate_line = over_amplitude(model.map_or(&[], |model| &model.rates));
        let period_line = over_amplitude(model.map_or(&[], |model| &model.small_swing_periods));
        let law = self.laws.first().map_or(String::new(), amplitude_law);
        let drift = format!(
            "drift {} %",
            with_uncertainty(
                self.period_drift_percent,
                Some(self.period_drift_percent_std)
            )
        );
        Ok(figures::decay(&figures::Decay {
            title: &format!("{bench}: how {} dies out", self.experiment),
            subtitle: "Constant over A: viscous. Rising towards small swings: dry friction. Rising with A: drag",
            amplitude: Quantity {
                name: "amplitude",
                unit: "rad",
            },
            panels: &[
                DecayPanel {
                    quantity: Quantity {
                        name: "decay rate −Ȧ/A",
                        unit: "1/s",
                    },
                    points: &rates,
                    model_amplitude: &rate_line.0,
                    model: &rate_line.1,
                    note: &law,
                },
                DecayPanel {
                    quantity: Quantity {
                        name: "period, large-angle effect taken out",
                        unit: "s",
                    },
                    points: &periods,
                    model_amplitude: &period_line.0,
                    model: &period_line.1,
                    note: &drift,
                },
            ],
        })?)
    }
}
