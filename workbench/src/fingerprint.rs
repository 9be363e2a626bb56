//! The appearance of an effect on a bench: the model without it and with it, each fitted to all experiments.

use identify::{BreakdownBin, Coordinate, Progress, ResidualBreakdown, ResidualKind};

use crate::comparison::ComparisonReport;
use crate::error::Error;
use crate::session::Session;
use crate::swing_decay::SwingDecay;

/// A person can tell two curves apart if they differ, at some place, by more than this many standard errors.
const APART: f64 = 3.0;

/// The coordinates over which the missing torque of a fingerprint is drawn.
const COORDINATES: [Coordinate; 5] = [
    Coordinate::Angle,
    Coordinate::Rate,
    Coordinate::WheelSpeed,
    Coordinate::WheelAngle,
    Coordinate::Current,
];

/// The result of [`Session::fingerprint`].
#[derive(Clone, Debug)]
pub struct EffectFingerprint {
    /// The effect.
    pub effect: String,
    /// The model without it, beside the measurements.
    pub without: ComparisonReport,
    /// The model with it.
    pub with: ComparisonReport,
    /// The decay of the free swings, measured and by the model without the effect.
    pub decay_without: Vec<SwingDecay>,
    /// The decay of the free swings, measured and by the model with the effect.
    pub decay_with: Vec<SwingDecay>,
}

/// A part of a missing torque over a coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TorquePart {
    /// The mean over both directions of the motion: springs, magnets.
    Mean,
    /// The part that changes its sign with the speed, positive along the motion: frictions.
    AlongMotion,
}

impl TorquePart {
    /// Value and standard error of this part in a bin; `None` for a bin without samples.
    pub fn of(self, bin: &BreakdownBin) -> Option<(f64, f64)> {
        let (value, std) = match self {
            TorquePart::Mean => (bin.mean, bin.mean_std),
            TorquePart::AlongMotion => (bin.along_motion, bin.along_motion_std),
        };
        (value.is_finite() && std.is_finite()).then_some((value, std))
    }

    /// The part in which a breakdown stands out most from zero.
    pub fn plainest(breakdown: &ResidualBreakdown) -> TorquePart {
        let size = |part: TorquePart| {
            let bins = breakdown.bins.iter().filter_map(|bin| part.of(bin));
            bins.map(|(value, std)| (value / std).powi(2)).sum::<f64>()
        };
        if size(TorquePart::AlongMotion) > size(TorquePart::Mean) {
            TorquePart::AlongMotion
        } else {
            TorquePart::Mean
        }
    }

    /// A point for every bin with samples: middle of the bin, value, standard error.
    pub fn points(self, breakdown: &ResidualBreakdown) -> Vec<[f64; 3]> {
        let bins = breakdown.bins.iter();
        bins.filter_map(|bin| {
            let (value, std) = self.of(bin)?;
            Some([0.5 * (bin.from + bin.to), value, std])
        })
        .collect()
    }
}

/// The torque that the models without and with an effect lack, over one coordinate.
#[derive(Clone, Debug, PartialEq)]
pub struct TorqueFingerprint {
    /// The experiment in which the effect shows most over this coordinate.
    pub experiment: String,
    /// The channel whose torque it is.
    pub channel: &'static str,
    /// The coordinate.
    pub coordinate: Coordinate,
    /// The part of the torque.
    pub part: TorquePart,
    /// Without the effect: coordinate, torque (N m, or per kg m²: [`ComparisonReport::per_unit_of_inertia`]), and its
    /// standard error.
    pub without: Vec<[f64; 3]>,
    /// With the effect: coordinate, torque and its standard error, as in `without`.
    pub with: Vec<[f64; 3]>,
    /// The distance of the two curves: the sum over all places of (difference / standard error)².
    pub apart: f64,
}

impl EffectFingerprint {
    /// The missing torque over every coordinate that shows the effect, the clearest first. A coordinate shows the
    /// effect if two conditions hold in an experiment: the model without the effect significantly lacks a torque, and
    /// at some place the torques that the two models lack differ by more than three standard errors.
    pub fn torques(&self) -> Vec<TorqueFingerprint> {
        let mut found: Vec<TorqueFingerprint> = COORDINATES
            .into_iter()
            .filter_map(|coordinate| self.torque_over(coordinate))
            .collect();
        found.sort_by(|a, b| b.apart.total_cmp(&a.apart));
        found
    }

    fn torque_over(&self, coordinate: Coordinate) -> Option<TorqueFingerprint> {
        let torques = |of: &ResidualBreakdown| {
            of.quantity == ResidualKind::ResidualTorque && of.coordinate == coordinate
        };
        // In other experiments the effect is not needed, and differences are noise.
        let fails = |of: &ResidualBreakdown| {
            self.without.places.iter().any(|place| {
                place.significant
                    && place.residual == ResidualKind::ResidualTorque
                    && place.experiment == of.experiment
                    && place.channel == of.channel
            })
        };
        let before = self.without.breakdowns.iter();
        let before = before.filter(|of| torques(of) && fails(of));
        let candidates = before.flat_map(|without| {
            let mut after = self.with.breakdowns.iter();
            let with = after.find(|with| {
                torques(with)
                    && with.experiment == without.experiment
                    && with.channel == without.channel
            });
            [TorquePart::Mean, TorquePart::AlongMotion]
                .into_iter()
                .filter_map(move |part| between(without, with?, part))
        });
        candidates.max_by(|a, b| a.apart.total_cmp(&b.apart))
    }
}

/// One part of a missing torque without and with the effect; `None` where they are not apart.
fn between(
    without: &ResidualBreakdown,
    with: &ResidualBreakdown,
    part: TorquePart,
) -> Option<TorqueFingerprint> {
    let (before, after) = (part.points(without), part.points(with));
    let near = |at: f64| {
        let distance = |point: &&[f64; 3]| (point[0] - at).abs();
        after
            .iter()
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))
    };
    let distances: Vec<f64> = before
        .iter()
        .filter_map(|[at, value, std]| {
            let [_, other, _] = near(*at)?;
            (*std > 0.0).then(|| (value - other).abs() / std)
        })
        .collect();
    let is_seen = distances.iter().any(|distance| *distance > APART);
    is_seen.then(|| TorqueFingerprint {
        experiment: without.experiment.clone(),
        channel: without.channel,
        coordinate: without.coordinate,
        part,
        without: before,
        apart: distances.iter().map(|distance| distance.powi(2)).sum(),
        with: after,
    })
}

impl Session {
    /// The session's model without and with the effect of this name. The session's model is not changed.
    ///
    /// # Errors
    /// [`Error::UnknownEffect`]; [`Error::EffectPresent`] if the model has an effect that contains it;
    /// [`Error::Identify`] if no start gives a finite simulation; [`Error::Cancelled`].
    pub fn fingerprint(
        &self,
        effect: &str,
        progress: &Progress,
    ) -> Result<EffectFingerprint, Error> {
        let (mut without, mut with) = (self.clone(), self.clone());
        let is_there = self
            .model()
            .is_some_and(|model| model.effects.iter().any(|one| one.name() == effect));
        if is_there {
            without.remove_effect(effect, progress)?;
        } else {
            with.add_effect(effect, progress)?;
        }
        let decays = |session: &Session| Ok::<_, Error>(session.predictor(progress)?.decays());
        Ok(EffectFingerprint {
            effect: effect.to_owned(),
            decay_without: decays(&without)?,
            decay_with: decays(&with)?,
            without: without.compare(progress)?,
            with: with.compare(progress)?,
        })
    }
}
