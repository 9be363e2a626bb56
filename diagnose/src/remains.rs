//! How large the residual of a model is: against the noise, against the signal, and as a torque.

use identify::{Discrepancy, NoisySeries, Output, Record, TorqueOn, residual_torques};
use parallel::parallel_map;

use crate::candidate::Candidate;
use crate::remainder::residual;

/// The size of the residual.
#[derive(Clone, Debug, PartialEq)]
pub struct Remains {
    /// The largest structured remainder over all series, in units of its sensor's noise.
    pub over_noise: f64,
    /// The same remainder relative to the standard deviation of the measured series.
    pub over_signal: f64,
    /// The series with this remainder, and the random process that describes its residual best; `None` if nothing
    /// remains.
    pub discrepancy: Option<SeriesDiscrepancy>,
    /// The largest torque that the model lacks; `None` if the logs show none.
    pub torque: Option<RemainingTorque>,
}

/// What a model does not explain in one series.
#[derive(Clone, Debug, PartialEq)]
pub struct SeriesDiscrepancy {
    /// The experiment.
    pub experiment: String,
    /// The measured channel.
    pub output: Output,
    /// Its size, in the unit of the channel, with its correlation time and frequency.
    pub process: Discrepancy,
}

/// A torque that a model lacks.
#[derive(Clone, Debug, PartialEq)]
pub struct RemainingTorque {
    /// The body on which it acts.
    pub on: TorqueOn,
    /// The experiment in which it is largest.
    pub experiment: String,
    /// Its root mean square in that experiment, after the part that comes from sensor noise has been subtracted, in
    /// N m (in N m per kg m² if the scale of the torques is unknown). The torque is averaged over a sixteenth of a
    /// period to either side.
    pub rms_nm: f64,
}

/// Computes the size of a candidate's residual over these records.
pub fn remains(records: &[&Record], candidate: &Candidate) -> Remains {
    let (mut over_noise, mut over_signal) = (0.0, 0.0);
    let mut largest = None;
    for (at, (record, left)) in records.iter().zip(&candidate.remainders).enumerate() {
        for (index, (channel, &left)) in record.channels.iter().zip(left).enumerate() {
            if left > over_noise {
                largest = Some((at, index));
                let samples = channel.samples.iter().copied();
                let samples: Vec<f64> = samples.filter(|sample| sample.is_finite()).collect();
                let n = samples.len().max(1) as f64;
                let mean = samples.iter().sum::<f64>() / n;
                let squares = samples.iter().map(|sample| (sample - mean).powi(2));
                let signal_std = (squares.sum::<f64>() / n).sqrt();
                over_noise = left;
                over_signal = left * channel.noise_std / signal_std;
            }
        }
    }
    let discrepancy = largest.map(|(at, index)| {
        let (record, channel) = (records[at], &records[at].channels[index]);
        let predicted = &candidate.traces[at][index].predicted;
        SeriesDiscrepancy {
            experiment: record.name.clone(),
            output: channel.output,
            process: Discrepancy::of(&NoisySeries {
                residual: &residual(&channel.samples, predicted),
                time_s: &record.time_s,
                weight: &record.weight,
                noise_std: channel.noise_std,
            }),
        }
    });
    let minimum = &candidate.minimum;
    let torques = parallel_map(records.iter().zip(&minimum.windows), |(record, windows)| {
        let found = residual_torques(record, windows, &candidate.model, &minimum.values);
        let of_record = found.into_iter().filter_map(|torque| {
            let n = torque.torque_nm.len() as f64;
            let square = torque.torque_nm.iter().map(|one| one * one).sum::<f64>() / n;
            let beyond = square - torque.noise_std_nm.powi(2);
            (beyond > 0.0).then(|| RemainingTorque {
                on: torque.on,
                experiment: record.name.clone(),
                rms_nm: beyond.sqrt(),
            })
        });
        of_record.collect::<Vec<RemainingTorque>>()
    });
    let torques = torques.into_iter().flatten();
    Remains {
        over_noise,
        over_signal,
        discrepancy,
        torque: torques.max_by(|a, b| a.rms_nm.total_cmp(&b.rms_nm)),
    }
}
