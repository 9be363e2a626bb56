//! The stretches of an experiment's time that a figure shades, because the model fails most in them.

use identify::{BreakdownBin, Coordinate, ResidualKind};

use crate::comparison::{ChannelCurves, ComparisonReport, ExperimentCurves};
use crate::numbers::significant;
use crate::words;

/// A model fails in a channel if its root mean square error exceeds the noise of the sensor by this factor: then the
/// noise makes up less than half of the squared error (1/1.5² = 0.44).
pub const FAILS_OVER_NOISE: f64 = 1.5;
/// Largest share of an experiment's time that a shaded place may cover. Otherwise the shading would not stand out.
const MOST_SHADED: f64 = 0.5;
/// Share of the squared error in the shaded time. A place is shaded only if it holds at least this share of its
/// residual. If there is no such place, the shaded time holds just this share.
const SHADED_ERROR: f64 = 0.5;

/// The shaded part of an experiment.
#[derive(Clone, Debug, PartialEq)]
pub struct Shading {
    /// Stretches of the log's time, first and last instant, s, in rising order.
    pub stretches_s: Vec<[f64; 2]>,
    /// The shaded place in words: "angle 0.1 to 0.2 rad, with 71 % of the error of the rate".
    pub text: String,
}

impl Shading {
    /// The shaded time, s.
    pub fn duration_s(&self) -> f64 {
        self.stretches_s.iter().map(|[from, to]| to - from).sum()
    }
}

impl ChannelCurves {
    /// Root mean square error in units of the sensor's noise.
    pub fn over_noise(&self) -> f64 {
        self.rmse / self.noise_std
    }
}

impl ComparisonReport {
    /// Where the model fails most in an experiment, as stretches of its time.
    ///
    /// This is the most significant place that holds at least half of the error of its residual and covers at most
    /// half of the time. A model that fails everywhere has no such place; then it is the shortest time that holds half
    /// of the squared error in the channel with the largest error over noise. `None` if the model does not fail in
    /// this experiment.
    pub fn shading(&self, experiment: &str) -> Option<Shading> {
        let mut curves = self.curves.iter();
        let curves = curves.find(|one| one.experiment == experiment)?;
        self.shaded_place(curves)
            .or_else(|| self.shaded_error(curves))
    }

    fn shaded_place(&self, curves: &ExperimentCurves) -> Option<Shading> {
        let duration_s = curves.time_s.last()? - curves.time_s.first()?;
        let own = self.places.iter().filter(|place| {
            place.significant
                && place.experiment == curves.experiment
                && place.share_of_error >= SHADED_ERROR
        });
        own.map(|place| Shading {
            stretches_s: place.stretches_s.clone(),
            text: format!(
                "{}, with {} % of the {}",
                words::place(place),
                significant(100.0 * place.share_of_error, 2),
                match place.residual {
                    ResidualKind::ResidualTorque => "missing torque".to_owned(),
                    ResidualKind::Output => {
                        format!("error of the {}", words::spoken(&place.channel))
                    }
                }
            ),
        })
        .find(|shading| {
            let shaded_s = shading.duration_s();
            shaded_s > 0.0 && shaded_s <= MOST_SHADED * duration_s
        })
    }

    fn shaded_error(&self, curves: &ExperimentCurves) -> Option<Shading> {
        let failing = curves
            .channels
            .iter()
            .filter(|channel| channel.over_noise() > FAILS_OVER_NOISE);
        let worst = failing.max_by(|a, b| a.over_noise().total_cmp(&b.over_noise()))?;
        let name = worst.channel.name();
        let over_time = self.breakdowns.iter().find(|part| {
            part.experiment == curves.experiment
                && part.channel == name
                && part.quantity == ResidualKind::Output
                && part.coordinate == Coordinate::Time
        })?;
        Some(Shading {
            stretches_s: shortest_time(&over_time.bins, SHADED_ERROR),
            text: format!(
                "the shortest time with half of the squared error of the {}",
                words::spoken(name)
            ),
        })
    }
}

/// The bins of time with the most error per second which together hold a share of the error, as stretches: neighbours
/// are one stretch.
fn shortest_time(bins: &[BreakdownBin], goal: f64) -> Vec<[f64; 2]> {
    let density = |bin: &BreakdownBin| bin.share / (bin.to - bin.from);
    let mut order: Vec<&BreakdownBin> = bins.iter().collect();
    order.sort_by(|a, b| density(b).total_cmp(&density(a)));
    let mut held = 0.0;
    let mut taken: Vec<[f64; 2]> = vec![];
    for bin in order {
        if held >= goal {
            break;
        }
        held += bin.share;
        taken.push([bin.from, bin.to]);
    }
    taken.sort_by(|a, b| a[0].total_cmp(&b[0]));
    taken.dedup_by(|next, before| {
        let touches = next[0] <= before[1];
        if touches {
            before[1] = next[1];
        }
        touches
    });
    taken
}

#[cfg(test)]
mod tests {
    use identify::Output;

    use super::*;
    use crate::comparison::FailurePlace;

    const NAME: &str = "swing";

    /// Ten seconds of a swing whose angle has this error over its noise.
    fn report(over_noise: f64, places: Vec<FailurePlace>, shares: &[f64]) -> ComparisonReport {
        let time_s: Vec<f64> = (0..=100).map(|k| f64::from(k) * 0.1).collect();
        let samples = vec![0.0; time_s.len()];
        let width = 10.0 / shares.len() as f64;
        let bins = shares.iter().enumerate().map(|(k, &share)| BreakdownBin {
            from: k as f64 * width,
            to: (k + 1) as f64 * width,
            count: 20.0,
            mean: 0.0,
            mean_std: 0.0,
            along_motion: f64::NAN,
            along_motion_std: f64::NAN,
            share,
        });
        ComparisonReport {
            places,
            curves: vec![ExperimentCurves {
                experiment: NAME.to_owned(),
                counts: vec![true; time_s.len()],
                channels: vec![ChannelCurves {
                    channel: Output::Angle,
                    measured: samples.clone(),
                    simulated: samples,
                    noise_std: 1e-3,
                    rmse: over_noise * 1e-3,
                    fit_percent: 90.0,
                }],
                time_s,
            }],
            breakdowns: vec![identify::ResidualBreakdown {
                experiment: NAME.to_owned(),
                channel: "angle",
                quantity: ResidualKind::Output,
                coordinate: Coordinate::Time,
                noise_std: 1e-3,
                bins: bins.collect(),
            }],
            ..ComparisonReport::default()
        }
    }

    fn place(coordinate: Coordinate, stretches_s: Vec<[f64; 2]>) -> FailurePlace {
        FailurePlace {
            experiment: NAME.to_owned(),
            channel: "angle".to_owned(),
            coordinate,
            from: 0.1,
            to: 0.2,
            stretches_s,
            share_of_error: 0.714,
            residual: ResidualKind::Output,
            significant: true,
        }
    }

    const EVEN: [f64; 5] = [0.2; 5];

    #[test]
    fn a_place_by_amplitude_is_shaded() {
        let places = vec![place(Coordinate::Amplitude, vec![[6.0, 9.0]])];
        let found = report(3.0, places, &EVEN).shading(NAME).expect("shaded");
        assert_eq!(found.stretches_s, [[6.0, 9.0]]);
        let text = "amplitude 0.1 to 0.2 rad, with 71 % of the error of the angle";
        assert_eq!(found.text, text);
    }

    /// All logs share a region of a missing torque; in some logs the region holds only a small part of their error.
    #[test]
    fn a_place_with_little_of_the_error_is_not_shaded() {
        let mut little = place(Coordinate::Rate, vec![[6.0, 9.0]]);
        little.share_of_error = 0.3;
        let shares = [0.6, 0.1, 0.1, 0.1, 0.1];
        let found = report(3.0, vec![little], &shares).shading(NAME);
        assert_eq!(found.expect("shaded").stretches_s, [[0.0, 2.0]]);
    }

    #[test]
    fn a_place_that_covers_nearly_everything_gives_way() {
        let places = vec![
            place(Coordinate::Rate, vec![[0.0, 9.0]]),
            place(Coordinate::Angle, vec![[1.0, 2.0], [3.0, 4.0]]),
        ];
        let found = report(3.0, places, &EVEN).shading(NAME).expect("shaded");
        assert_eq!(found.stretches_s, [[1.0, 2.0], [3.0, 4.0]]);
    }

    /// A swing that fails at its beginning and its end: no single region holds the error, but something is shaded, and
    /// never more than half of the time and a bin.
    #[test]
    fn a_model_that_fails_everywhere_is_shaded_where_it_fails_most() {
        let places = vec![place(Coordinate::Rate, vec![[0.0, 9.0]])];
        let shares = [0.28, 0.2, 0.04, 0.2, 0.28];
        let failing = report(3.0, places.clone(), &shares);
        let found = failing.shading(NAME).expect("shaded");
        assert_eq!(found.stretches_s, [[0.0, 2.0], [8.0, 10.0]]);
        assert!(
            found
                .text
                .contains("half of the squared error of the angle")
        );
        let neighbours = report(3.0, vec![], &[0.1, 0.3, 0.3, 0.2, 0.1]);
        let found = neighbours.shading(NAME).expect("shaded");
        assert_eq!(found.stretches_s, [[2.0, 6.0]]);
        // With the noise of the sensor alone nothing is shaded.
        assert_eq!(report(1.02, places, &shares).shading(NAME), None);
    }
}
