//! Where a model fails: its residual over the coordinates in which physics speaks.
//!
//! Two residuals are broken down. The torque that the model lacks ([`crate::missing_torque`]) has no
//! memory, so that it can be asked on what it depends; the residual of the free run is what users see,
//! and where it is large.
//!
//! **The missing torque.** For each coordinate x the torque is taken as a function f(x), constant within
//! each of a few bins, and fitted by least squares. A bump of the weak form sees the mean of f along
//! its path, Σ ψₖ f(xₖ): the regression on these means undoes the smearing, so that a magnet that a
//! swing passes within one bump is found in its place. Where friction is conceivable that depends on
//! place or time, each bin has a second coefficient, f₂(x) sign(speed). One function serves all logs
//! together (in time, and over the turn of a wheel whose angle counts from the start of each log, every
//! log has its own): friction must be the same function of speed everywhere, or speed is not what it
//! depends on.
//!
//! Before that, what mere changes of the parameters explain is taken out: a fit whose model lacks
//! something bends its parameters, and the bending is everywhere.
//!
//! The sum of squares that a coordinate explains is compared with what it would explain of noise
//! alone, tr(P Σ) with P the projection and Σ the known covariance of overlapping bumps; it scatters
//! with 2 tr(P Σ P Σ) (Seber & Lee, *Linear Regression Analysis*, 2003, theorem 1.6). The coordinate
//! that explains most names the place; the shortest run of bins that holds four fifths of it bounds it.
//!
//! **The residual of the free run** grows from its causes with the memory of a pendulum. It is only
//! said where its square is above the sensor's noise.

use nalgebra::{Cholesky, DMatrix, DVector};
use plant::{GRAVITY_TORQUE, Kind, Model, TOTAL_INERTIA};
use rayon::prelude::*;

use crate::fit::Trace;
use crate::missing_torque::{MeasuredMotion, TorqueOn, half_bump};
use crate::record::Record;
use crate::sensitivity::Window;
use crate::whiteness::{SIGNIFICANT, effective_samples, structure, without_rounding};

/// A coordinate over which a residual is broken down.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Coordinate {
    /// Body rate, rad/s, with its sign.
    Rate,
    /// Wheel speed, rad/s, with its sign.
    WheelSpeed,
    /// Body angle, rad.
    Angle,
    /// Motor current, A.
    Current,
    /// Wheel angle within one turn, rad, from where the log began.
    WheelAngle,
    /// Amplitude of the swing, rad: the angle at which the body would stand still with the energy
    /// that it has.
    Amplitude,
    /// Time of the log, s.
    Time,
}

impl Coordinate {
    /// All coordinates. Of several that explain a torque equally well the first is named: a torque
    /// that depends on speed also looks like one that depends on amplitude or time while a swing dies
    /// out, but not the other way round.
    pub const ALL: [Coordinate; 7] = [
        Coordinate::Rate,
        Coordinate::WheelSpeed,
        Coordinate::Angle,
        Coordinate::Current,
        Coordinate::WheelAngle,
        Coordinate::Amplitude,
        Coordinate::Time,
    ];

    /// The name in every report.
    pub fn name(self) -> &'static str {
        match self {
            Coordinate::Time => "time",
            Coordinate::Amplitude => "amplitude",
            Coordinate::Angle => "angle",
            Coordinate::Rate => "rate",
            Coordinate::WheelSpeed => "wheel_speed",
            Coordinate::WheelAngle => "wheel_angle",
            Coordinate::Current => "current",
        }
    }

    /// SI unit.
    pub fn unit(self) -> &'static str {
        match self {
            Coordinate::Time => "s",
            Coordinate::Rate | Coordinate::WheelSpeed => "rad/s",
            Coordinate::Current => "A",
            Coordinate::Amplitude | Coordinate::Angle | Coordinate::WheelAngle => "rad",
        }
    }

    /// Whether a torque as a function of this coordinate is the same in every log.
    fn is_common(self) -> bool {
        !matches!(self, Coordinate::Time | Coordinate::WheelAngle)
    }

    /// Whether a speed is the coordinate itself, so that its sign needs no coefficient of its own.
    fn is_speed(self) -> bool {
        matches!(self, Coordinate::Rate | Coordinate::WheelSpeed)
    }
}

/// What is broken down.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// The torque that the model lacks, N m.
    MissingTorque,
    /// Measured − free run, in the unit of the channel.
    Output,
}

/// One bin of a breakdown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bin {
    /// Lower edge in the unit of the coordinate.
    pub from: f64,
    /// Upper edge.
    pub to: f64,
    /// Number of values in it (of bumps, for a torque: a bump that passes through several bins counts
    /// in each with its part).
    pub count: f64,
    /// Mean residual in the bin, in its own unit.
    pub mean: f64,
    /// Standard error of the mean; it accounts for overlapping bumps and for what the coordinate
    /// leaves unexplained.
    pub mean_std: f64,
    /// The part that changes its sign with the speed (positive along the motion), in the same unit;
    /// NaN where it is not asked for.
    pub along_motion: f64,
    /// Standard error of [`Bin::along_motion`].
    pub along_motion_std: f64,
    /// Its share of this record's squared error above the noise, in percent of 1; the shares of a
    /// torque add up to what the coordinate explains, those of an output to 1.
    pub share: f64,
}

/// One residual of one record over one coordinate.
#[derive(Clone, Debug, PartialEq)]
pub struct Breakdown {
    /// The experiment's name.
    pub experiment: String,
    /// The channel's part of "experiment/channel".
    pub channel: &'static str,
    /// Which residual.
    pub quantity: Quantity,
    /// Over which coordinate.
    pub coordinate: Coordinate,
    /// Standard deviation of the noise of one value, in the unit of the residual.
    pub noise_std: f64,
    /// The bins in rising order, without gaps.
    pub bins: Vec<Bin>,
}

/// A place where the model fails.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// The experiment's name.
    pub experiment: String,
    /// The channel's part of "experiment/channel".
    pub channel: &'static str,
    /// In which residual it was seen.
    pub quantity: Quantity,
    /// The coordinate in which the place is given.
    pub coordinate: Coordinate,
    /// Lower end in the unit of the coordinate.
    pub from: f64,
    /// Upper end.
    pub to: f64,
    /// Share of this record's squared error above the noise that lies in it, 0 to 1.
    pub share_of_error: f64,
    /// Squared error above the noise in it, in units of the noise of one value.
    pub size: f64,
    /// Whether there is anything beyond noise at all.
    pub is_significant: bool,
}

/// How much of the missing torque a coordinate explains, over all logs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Explained {
    /// Which torque.
    pub on: TorqueOn,
    /// By which coordinate.
    pub coordinate: Coordinate,
    /// Share of the squared torque above the noise, 0 to 1; 0 where it is not significant.
    pub share: f64,
    /// In standard deviations of what noise alone would seem to show.
    pub significance: f64,
}

/// Everything about where a model fails.
#[derive(Clone, Debug, Default)]
pub struct FailureMap {
    /// Every residual over every coordinate.
    pub breakdowns: Vec<Breakdown>,
    /// How much of each missing torque each coordinate explains.
    pub explained: Vec<Explained>,
    /// The places where the model fails, the plainest first; never empty if there is a sample.
    pub regions: Vec<Region>,
}

/// Most bins for one coordinate.
const MOST_BINS: usize = 32;
/// Fewest values in a bin.
const FEWEST_IN_BIN: usize = 20;
/// Bins for a turn of the wheel: cogging of up to 20 periods in a turn shows.
const TURN_BINS: usize = 60;
/// A region is the shortest run of bins with this part of what the coordinate explains: enough to
/// bound a thing as a whole (a magnet pulls on one side of its place and pushes on the other, each
/// half of it), and not its faint ends.
const REGION_PART: f64 = 0.8;
/// Coordinates whose shares differ by less than this factor explain a torque equally well: a function
/// of steps cannot say more.
const AS_GOOD: f64 = 0.9;
/// Relative uncertainty of a sum of squares that is due to the estimate of the noise itself.
const NOISE_SQUARE_RELATIVE_STD: f64 = 0.06;
/// Uncertainty of a sum of squares in a balance log, as a part of the squared noise. The controller
/// answers to the noise of the sensors, so that the motion depends on it; and dry friction near
/// standstill turns the error of the rate into torque. In 24 simulated logs of the right model the
/// coordinates explained 3 % of the squared noise on average and 8 % at most: four of these.
const FEEDBACK: f64 = 0.02;
/// Structure in an output below this part of its noise is not worth a place: it raises the RMSE by
/// less than 5 % (√(1 + 1/9)), and the noise of a recorded current leaves about as much.
const IMMATERIAL: f64 = 1.0 / 3.0;
/// Most regions that are named.
const MOST_REGIONS: usize = 12;

/// One residual of one record, ready to be broken down.
struct Series {
    record: usize,
    channel: &'static str,
    noise_std: f64,
    /// Values over their noise.
    values: Vec<f64>,
    /// For each value the interval of the log where it begins to look, and its weights from there on.
    looks: Vec<(usize, Vec<f64>)>,
    /// Correlation of the noise of values that follow at 0, 1, 2, … strides.
    noise_correlation: Vec<f64>,
    /// For each value its number in strides, so that gaps are seen.
    position: Vec<usize>,
    /// The speed whose sign the second coefficient takes.
    wheel: bool,
}

impl Series {
    /// Squared values above the noise.
    fn excess(&self) -> f64 {
        self.values.iter().map(|value| value * value - 1.0).sum()
    }
}

/// The value of every coordinate in the middle of every interval of a record; empty where the
/// record does not have it.
fn coordinates(record: &Record, motion: &MeasuredMotion, values: &[f64]) -> Vec<Vec<f64>> {
    let swings = matches!(record.kind, Kind::FreeSwing | Kind::Driven);
    let moves_body = record.kind != Kind::SpinUp;
    let moves_wheel = record.kind != Kind::FreeSwing && motion.wheel_speed_measured;
    let has_current = record.kind != Kind::FreeSwing && !record.current_a.is_empty();
    let stiffness = values[GRAVITY_TORQUE] / values[TOTAL_INERTIA];
    Coordinate::ALL
        .iter()
        .map(|coordinate| {
            let states = motion.state.iter();
            match coordinate {
                Coordinate::Rate if moves_body => states.map(|state| state.rate_rad_s).collect(),
                Coordinate::Angle if moves_body => states.map(|state| state.angle_rad).collect(),
                Coordinate::Amplitude if swings => states
                    .map(|state| {
                        // 1 − cos A = 1 − cos α + Θ α̇²/(2 G)
                        let half_height = (0.5 * state.angle_rad).sin().powi(2)
                            + 0.25 * state.rate_rad_s.powi(2) / stiffness;
                        2.0 * half_height.min(1.0).sqrt().asin()
                    })
                    .collect(),
                Coordinate::WheelSpeed if moves_wheel => {
                    states.map(|state| state.wheel_speed_rad_s).collect()
                }
                Coordinate::WheelAngle if moves_wheel => states
                    .map(|state| state.wheel_angle_rad.rem_euclid(std::f64::consts::TAU))
                    .collect(),
                Coordinate::Current if has_current => states.map(|state| state.current_a).collect(),
                Coordinate::Time => motion.time_s.clone(),
                _ => vec![],
            }
        })
        .collect()
}

/// Edges of bins of equal count; one of them is at zero speed, and the wheel's turn is cut evenly.
fn edges(coordinate: Coordinate, mut values: Vec<f64>, count: usize) -> Option<Vec<f64>> {
    values.retain(|value| value.is_finite());
    values.sort_by(f64::total_cmp);
    let (first, last) = (*values.first()?, *values.last()?);
    if last - first <= 1e-9 * first.abs().max(last.abs()).max(1e-9) {
        return None;
    }
    if coordinate == Coordinate::WheelAngle {
        let turn = std::f64::consts::TAU;
        return Some(
            (0..=TURN_BINS)
                .map(|k| turn * k as f64 / TURN_BINS as f64)
                .collect(),
        );
    }
    let bins = (count / FEWEST_IN_BIN).clamp(2, MOST_BINS);
    let mut edges: Vec<f64> = (0..=bins)
        .map(|k| values[(k * (values.len() - 1)) / bins])
        .collect();
    if coordinate.is_speed() && first < 0.0 && last > 0.0 {
        let nearest =
            (1..edges.len() - 1).min_by(|&a, &b| edges[a].abs().total_cmp(&edges[b].abs()));
        if let Some(nearest) = nearest {
            edges[nearest] = 0.0;
        }
    }
    edges.dedup();
    (edges.len() > 2).then_some(edges)
}

fn bin_of(edges: &[f64], value: f64) -> Option<usize> {
    value.is_finite().then(|| {
        edges
            .partition_point(|edge| *edge <= value)
            .clamp(1, edges.len() - 1)
            - 1
    })
}

/// A least-squares fit of a step function to one or several series.
struct StepFit {
    /// Coefficients: the bins' constants, then (if asked for) their parts along the motion.
    beta: DVector<f64>,
    /// Standard error of each.
    std: DVector<f64>,
    /// Sum of squares that the function explains, in units of the noise.
    explained: f64,
    /// What it would explain of noise alone, and the variance of that.
    of_noise: (f64, f64),
    /// For each series the explained squares in each bin above those of noise.
    energy: Vec<Vec<f64>>,
    /// For each series what noise alone would explain in each bin; it was subtracted.
    noise_energy: Vec<Vec<f64>>,
    /// For each series the number of values in each bin.
    count: Vec<Vec<f64>>,
}

/// Fits f(x) with these edges; `at` gives the coordinate and the speed for series and interval.
/// `is_turn`: the coordinate goes round; a bump in which the wheel turns by half a turn or more says
/// nothing of any angle.
fn fit_steps(
    series: &[&Series],
    edges: &[f64],
    (with_sign, is_turn): (bool, bool),
    at: &dyn Fn(usize, usize) -> (f64, f64),
) -> Option<StepFit> {
    let bins = edges.len() - 1;
    let columns = if with_sign { 2 * bins } else { bins };
    let most = if is_turn { bins / 2 } else { columns };
    let mut square = DMatrix::<f64>::zeros(columns, columns);
    let mut noise = DMatrix::<f64>::zeros(columns, columns);
    let mut right = DVector::<f64>::zeros(columns);
    let mut total = 0.0;
    let mut values = 0usize;
    // Rows are short lists: a bump passes a few bins only.
    let mut rows: Vec<Vec<Vec<(usize, f64)>>> = vec![];
    for (index, one) in series.iter().enumerate() {
        let scale = 1.0 / one.noise_std;
        let mut own = vec![];
        for ((start, weights), value) in one.looks.iter().zip(&one.values) {
            let mut row = vec![0.0; columns];
            for (offset, weight) in weights.iter().enumerate() {
                let (x, speed) = at(index, start + offset);
                if let Some(bin) = bin_of(edges, x) {
                    row[bin] += weight * scale;
                    if with_sign {
                        row[bins + bin] += weight * scale * speed.signum();
                    }
                }
            }
            let mut row: Vec<(usize, f64)> = row
                .into_iter()
                .enumerate()
                .filter(|(_, weight)| *weight != 0.0)
                .collect();
            if row.len() > most {
                row.clear();
            }
            for &(a, left) in &row {
                right[a] += left * value;
                for &(b, other) in &row {
                    square[(a, b)] += left * other;
                }
            }
            total += value * value;
            values += 1;
            own.push(row);
        }
        for (k, row) in own.iter().enumerate() {
            for (later, other) in own.iter().enumerate().skip(k) {
                let lag = one.position[later] - one.position[k];
                let Some(&correlation) = one.noise_correlation.get(lag) else {
                    break;
                };
                for &(a, left) in row {
                    for &(b, right) in other {
                        noise[(a, b)] += correlation * left * right;
                        if later > k {
                            noise[(b, a)] += correlation * left * right;
                        }
                    }
                }
            }
        }
        rows.push(own);
    }
    let mean_diagonal = square.trace() / columns as f64;
    for index in 0..columns {
        // Keeps bins that no value tells apart from growing without bound.
        square[(index, index)] += 1e-6 * mean_diagonal.max(1e-300);
    }
    let inverse = Cholesky::new(square)?.inverse();
    let beta = &inverse * &right;
    let explained = beta.dot(&right);
    let of_noise = &inverse * &noise;
    let mean = of_noise.trace();
    let variance =
        2.0 * (&of_noise * &of_noise).trace() + (NOISE_SQUARE_RELATIVE_STD * mean).powi(2);
    // What the coordinate leaves unexplained stands for noise as well.
    let left = ((total - explained) / (values as f64 - mean).max(1.0)).max(1.0);
    let spread = &of_noise * &inverse;
    let std = DVector::from_fn(columns, |k, _| (left * spread[(k, k)].max(0.0)).sqrt());
    let mut energy = vec![vec![0.0; bins]; series.len()];
    let mut noise_energy = vec![vec![0.0; bins]; series.len()];
    let mut count = vec![vec![0.0; bins]; series.len()];
    for (index, own) in rows.iter().enumerate() {
        for row in own {
            let fitted: f64 = row.iter().map(|&(k, weight)| weight * beta[k]).sum();
            for &(k, weight) in row {
                energy[index][k % bins] += fitted * weight * beta[k];
                if k < bins {
                    count[index][k] += weight * series[index].noise_std;
                }
            }
        }
    }
    // The noise's own part, shared out by how many values each series has in the bin.
    for bin in 0..bins {
        let all: f64 = count.iter().map(|count| count[bin]).sum();
        let mut own = of_noise[(bin, bin)];
        if with_sign {
            own += of_noise[(bins + bin, bins + bin)];
        }
        for (index, count) in count.iter().enumerate() {
            noise_energy[index][bin] = own * count[bin] / all.max(1e-300);
            energy[index][bin] -= noise_energy[index][bin];
        }
    }
    Some(StepFit {
        beta,
        std,
        explained,
        of_noise: (mean, variance),
        energy,
        noise_energy,
        count,
    })
}

/// The shortest run of bins that holds [`REGION_PART`] of what is positive, as first and last index.
fn shortest_run(energy: &[f64], edges: &[f64]) -> Option<(usize, usize)> {
    let positive: Vec<f64> = energy.iter().map(|value| value.max(0.0)).collect();
    let goal = REGION_PART * positive.iter().sum::<f64>();
    if goal <= 0.0 {
        return None;
    }
    let mut best: Option<(usize, usize)> = None;
    for from in 0..positive.len() {
        let mut sum = 0.0;
        for to in from..positive.len() {
            sum += positive[to];
            if sum >= goal {
                let width = edges[to + 1] - edges[from];
                if best.is_none_or(|(a, b)| width < edges[b + 1] - edges[a]) {
                    best = Some((from, to));
                }
                break;
            }
        }
    }
    best
}

/// What one record shows.
struct Seen {
    motion: Option<MeasuredMotion>,
    /// For each coordinate its value in every interval.
    places: Vec<Vec<f64>>,
    /// The missing torques with their slopes.
    torques: Vec<(TorqueOn, Series, Vec<Vec<f64>>)>,
    outputs: Vec<Series>,
}

fn seen(
    index: usize,
    record: &Record,
    windows: &[Window],
    traces: &[Trace],
    model: &Model,
    values: &[f64],
) -> Seen {
    let half = if record.len() > 1 {
        half_bump(record, values)
    } else {
        1
    };
    let Some(motion) = MeasuredMotion::new(record, windows, model, values, half) else {
        return Seen {
            motion: None,
            places: vec![vec![]; Coordinate::ALL.len()],
            torques: vec![],
            outputs: vec![],
        };
    };
    let torques = motion
        .missing_torques(record, model, values, half)
        .into_iter()
        .map(|missing| {
            let slopes = motion.parameter_slopes(record, model, values, &missing);
            (missing.on, torque_series(index, record, &missing), slopes)
        })
        .collect();
    Seen {
        places: coordinates(record, &motion, values),
        torques,
        outputs: output_series(index, record, traces),
        motion: Some(motion),
    }
}

/// Breaks the residuals of a model down. `windows` and `traces` are those of the fit, in the order of
/// the records.
pub fn breakdown(
    records: &[Record],
    windows: &[Vec<Window>],
    traces: &[Vec<Trace>],
    model: &Model,
    values: &[f64],
) -> FailureMap {
    let mut map = FailureMap::default();
    let mut places: Vec<Vec<Vec<f64>>> = vec![];
    let mut motions: Vec<Option<MeasuredMotion>> = vec![];
    let mut torques: Vec<(TorqueOn, Series)> = vec![];
    let mut slopes: Vec<Vec<Vec<f64>>> = vec![];
    let mut outputs: Vec<Series> = vec![];
    let seen: Vec<Seen> = (0..records.len())
        .into_par_iter()
        .map(|index| {
            let (windows, traces) = (&windows[index], &traces[index]);
            seen(index, &records[index], windows, traces, model, values)
        })
        .collect();
    for one in seen {
        motions.push(one.motion);
        places.push(one.places);
        for (on, series, own_slopes) in one.torques {
            torques.push((on, series));
            slopes.push(own_slopes);
        }
        outputs.extend(one.outputs);
    }
    for on in [TorqueOn::Body, TorqueOn::BodyByCommand, TorqueOn::Wheel] {
        let mut group: Vec<(&mut Series, &[Vec<f64>])> = torques
            .iter_mut()
            .zip(&slopes)
            .filter(|((which, _), _)| *which == on)
            .map(|((_, series), slopes)| (series, slopes.as_slice()))
            .collect();
        adjust(&mut group, values.len());
    }
    let context = Context {
        records,
        places: &places,
        motions: &motions,
    };
    for on in [TorqueOn::Body, TorqueOn::BodyByCommand, TorqueOn::Wheel] {
        let group: Vec<&Series> = torques
            .iter()
            .filter(|(which, _)| *which == on)
            .map(|(_, series)| series)
            .collect();
        if !group.is_empty() {
            context.break_torque_down(on, &group, &mut map);
        }
    }
    plainest_first(&mut map.regions);
    let mut of_outputs: Vec<Region> = outputs
        .iter()
        .filter_map(|series| context.break_output_down(series, &mut map.breakdowns))
        .collect();
    plainest_first(&mut of_outputs);
    map.regions.extend(of_outputs);
    if map.regions.iter().any(|region| region.is_significant) {
        map.regions.retain(|region| region.is_significant);
    }
    map.regions.truncate(MOST_REGIONS);
    map
}

fn plainest_first(regions: &mut [Region]) {
    regions.sort_by(|a, b| {
        let significant = b.is_significant.cmp(&a.is_significant);
        significant.then(b.size.total_cmp(&a.size))
    });
}

/// Takes out of a torque what wrong parameters explain, by least squares over all logs. A fit whose
/// model lacks something bends its parameters, and the torque that then seems to be missing is the
/// lack and, everywhere else, the bending.
fn adjust(group: &mut [(&mut Series, &[Vec<f64>])], parameters: usize) {
    let mut square = DMatrix::<f64>::zeros(parameters, parameters);
    let mut right = DVector::<f64>::zeros(parameters);
    for (series, slopes) in group.iter() {
        for (value, slope) in series.values.iter().zip(slopes.iter()) {
            for row in 0..parameters {
                right[row] += slope[row] / series.noise_std * value;
                for column in 0..parameters {
                    square[(row, column)] +=
                        slope[row] * slope[column] / (series.noise_std * series.noise_std);
                }
            }
        }
    }
    // Parameters have many units; one without trace, or in step with another, stays out.
    let scale = DVector::from_fn(parameters, |k, _| match square[(k, k)] {
        own if own > 0.0 => 1.0 / own.sqrt(),
        _ => 0.0,
    });
    let scaled = DMatrix::from_fn(parameters, parameters, |row, column| {
        let ridge = if row == column { 1e-9 } else { 0.0 };
        square[(row, column)] * scale[row] * scale[column] + ridge
    });
    let Some(cholesky) = Cholesky::new(scaled) else {
        return;
    };
    let change = cholesky
        .solve(&right.component_mul(&scale))
        .component_mul(&scale);
    for (series, slopes) in group.iter_mut() {
        let noise_std = series.noise_std;
        for (value, slope) in series.values.iter_mut().zip(slopes.iter()) {
            let explained: f64 = slope.iter().zip(change.iter()).map(|(a, b)| a * b).sum();
            *value -= explained / noise_std;
        }
    }
}

fn torque_series(
    index: usize,
    record: &Record,
    missing: &crate::missing_torque::MissingTorque,
) -> Series {
    Series {
        record: index,
        channel: missing.on.channel(),
        noise_std: missing.noise_std_nm,
        values: missing
            .torque_nm
            .iter()
            .map(|torque| torque / missing.noise_std_nm)
            .collect(),
        looks: missing
            .centres
            .iter()
            .map(|&centre| (centre - missing.half, missing.weights(record, centre)))
            .collect(),
        noise_correlation: missing.noise_correlation.clone(),
        position: missing
            .centres
            .iter()
            .map(|centre| centre / missing.stride)
            .collect(),
        wheel: missing.on == TorqueOn::Wheel,
    }
}

/// The residuals of the channels of a record, without the rounding that the model foresees.
fn output_series(index: usize, record: &Record, traces: &[Trace]) -> Vec<Series> {
    record
        .channels
        .iter()
        .zip(traces)
        .map(|(channel, trace)| {
            let residual = match channel.quantum {
                Some(quantum) => without_rounding(
                    &channel.samples,
                    &trace.predicted,
                    channel.noise_std,
                    quantum,
                ),
                None => channel
                    .samples
                    .iter()
                    .zip(&trace.predicted)
                    .map(|(measured, model)| measured - model)
                    .collect(),
            };
            let counted: Vec<usize> = (0..record.len() - 1)
                .filter(|&k| residual[k].is_finite() && record.weight[k] > 0.0)
                .collect();
            Series {
                record: index,
                channel: channel.output.name(),
                noise_std: channel.noise_std,
                values: counted
                    .iter()
                    .map(|&k| residual[k] / channel.noise_std)
                    .collect(),
                looks: counted.iter().map(|&k| (k, vec![1.0])).collect(),
                noise_correlation: vec![1.0],
                position: counted,
                wheel: channel.output == crate::record::Output::WheelSpeed,
            }
        })
        .collect()
}

/// What came of explaining a torque by one coordinate.
struct Attempt {
    explained: Explained,
    breakdowns: Vec<Breakdown>,
    regions: Vec<Region>,
}

struct Context<'a> {
    records: &'a [Record],
    /// For each record, each coordinate: its value in every interval.
    places: &'a [Vec<Vec<f64>>],
    motions: &'a [Option<MeasuredMotion>],
}

impl Context<'_> {
    fn speed(&self, series: &Series, interval: usize) -> f64 {
        self.motions[series.record].as_ref().map_or(0.0, |motion| {
            let state = &motion.state[interval];
            if series.wheel {
                state.wheel_speed_rad_s
            } else {
                state.rate_rad_s
            }
        })
    }

    /// What the motion seems to explain of noise alone because a controller makes motion of noise.
    fn feedback(&self, series: &Series) -> f64 {
        match self.records[series.record].kind {
            Kind::Balance => FEEDBACK * series.values.len() as f64,
            _ => 0.0,
        }
    }

    /// Where the values of a series lie in a coordinate.
    fn seen(&self, series: &Series, coordinate: usize) -> Vec<f64> {
        let place = &self.places[series.record][coordinate];
        series
            .looks
            .iter()
            .map(|(start, weights)| place[start + weights.len() / 2])
            .collect()
    }

    fn break_torque_down(&self, on: TorqueOn, group: &[&Series], map: &mut FailureMap) {
        let all_excess: f64 = group.iter().map(|series| series.excess()).sum();
        let coordinates: Vec<usize> = (0..Coordinate::ALL.len())
            .filter(|&index| {
                // A wheel's friction does not know how the body hangs.
                let of_body = matches!(
                    Coordinate::ALL[index],
                    Coordinate::Rate | Coordinate::Angle | Coordinate::Amplitude
                );
                on != TorqueOn::Wheel || !of_body
            })
            .collect();
        let mut attempts: Vec<Attempt> = coordinates
            .par_iter()
            .map(|&index| self.attempt(index, on, group, all_excess))
            .collect();
        for attempt in &mut attempts {
            map.explained.push(attempt.explained);
            map.breakdowns.append(&mut attempt.breakdowns);
        }
        let best = attempts
            .iter()
            .map(|attempt| attempt.explained.share)
            .fold(0.0, f64::max);
        let chosen = attempts
            .iter_mut()
            .find(|attempt| best > 0.0 && attempt.explained.share >= AS_GOOD * best);
        if let Some(chosen) = chosen {
            map.regions.append(&mut chosen.regions);
        }
    }

    /// Explains the torque of a group of series by one coordinate.
    fn attempt(&self, index: usize, on: TorqueOn, group: &[&Series], all_excess: f64) -> Attempt {
        let coordinate = Coordinate::ALL[index];
        let having: Vec<&Series> = group
            .iter()
            .copied()
            .filter(|series| !self.places[series.record][index].is_empty())
            .collect();
        let sets: Vec<Vec<&Series>> = if coordinate.is_common() {
            vec![having]
        } else {
            having.into_iter().map(|series| vec![series]).collect()
        };
        let (mut explained, mut mean, mut variance) = (0.0, 0.0, 0.0);
        let (mut breakdowns, mut regions) = (vec![], vec![]);
        for set in sets.iter().filter(|set| !set.is_empty()) {
            let seen: Vec<Vec<f64>> = set.iter().map(|series| self.seen(series, index)).collect();
            let all: Vec<f64> = seen.concat();
            let count = all.len();
            let Some(edges) = edges(coordinate, all, count) else {
                continue;
            };
            let at = |series: usize, interval: usize| {
                let series = set[series];
                (
                    self.places[series.record][index][interval],
                    self.speed(series, interval),
                )
            };
            let form = (!coordinate.is_speed(), coordinate == Coordinate::WheelAngle);
            let Some(fit) = fit_steps(set, &edges, form, &at) else {
                continue;
            };
            explained += fit.explained;
            mean += fit.of_noise.0;
            variance += fit.of_noise.1
                + set
                    .iter()
                    .map(|series| self.feedback(series).powi(2))
                    .sum::<f64>();
            // The place is one for all logs that share the function.
            let pooled: Vec<f64> = (0..edges.len() - 1)
                .map(|bin| fit.energy.iter().map(|energy| energy[bin]).sum())
                .collect();
            let run = shortest_run(&pooled, &edges);
            for (number, series) in set.iter().enumerate() {
                let excess = series.excess().max(1e-300);
                let experiment = self.records[series.record].name.clone();
                breakdowns.push(Breakdown {
                    experiment: experiment.clone(),
                    channel: series.channel,
                    quantity: Quantity::MissingTorque,
                    coordinate,
                    noise_std: series.noise_std,
                    bins: bins_of(&fit, number, &edges, excess),
                });
                let energy = &fit.energy[number];
                let Some((from, to)) = run else {
                    continue;
                };
                let sum: f64 = energy[from..=to].iter().sum();
                if sum <= 0.0 {
                    continue;
                }
                // A square of Gaussian noise has twice its squared mean as variance.
                let scatter: f64 = fit.noise_energy[number]
                    .iter()
                    .zip(&fit.count[number])
                    .filter(|(_, count)| **count > 0.0)
                    .map(|(own, _)| 2.0 * own.max(1.0).powi(2))
                    .sum();
                // A bin may be wider than what this log has seen of it.
                let finite = || seen[number].iter().copied().filter(|x| x.is_finite());
                let lowest = finite().fold(f64::INFINITY, f64::min);
                let highest = finite().fold(f64::NEG_INFINITY, f64::max);
                regions.push(Region {
                    experiment,
                    channel: series.channel,
                    quantity: Quantity::MissingTorque,
                    coordinate,
                    from: edges[from].max(lowest),
                    to: edges[to + 1].min(highest),
                    share_of_error: (sum / excess).clamp(0.0, 1.0),
                    size: sum,
                    is_significant: energy.iter().sum::<f64>()
                        > SIGNIFICANT * scatter.sqrt().hypot(self.feedback(series)),
                });
            }
        }
        let gain = explained - mean;
        let significance = gain / variance.sqrt().max(1e-300);
        Attempt {
            explained: Explained {
                on,
                coordinate,
                share: if significance > SIGNIFICANT {
                    gain / all_excess.max(gain)
                } else {
                    0.0
                },
                significance,
            },
            breakdowns,
            regions,
        }
    }

    /// Breaks one output down and returns the place where it is worst: of all coordinates the one
    /// in which four fifths of the excess lie in the smallest part of the samples.
    fn break_output_down(&self, series: &Series, out: &mut Vec<Breakdown>) -> Option<Region> {
        let n = series.values.len();
        if n == 0 {
            return None;
        }
        let mut best: Option<(f64, Region)> = None;
        let found = structure(&series.values, 1.0, &[]);
        let is_significant = found.is_significant() && found.rms_over_noise > IMMATERIAL;
        let all: f64 = series.excess();
        // Values follow each other: neighbours within a bin are worth as much as the whole series is.
        let worth = effective_samples(&series.values, &[]) / n as f64;
        for (index, &coordinate) in Coordinate::ALL.iter().enumerate() {
            let place = &self.places[series.record][index];
            // What acts within a turn is integrated away on its way to the output.
            if place.is_empty() || coordinate == Coordinate::WheelAngle {
                continue;
            }
            let Some(edges) = edges(coordinate, self.seen(series, index), n) else {
                continue;
            };
            let bins = edges.len() - 1;
            let (mut count, mut sum, mut squares) =
                (vec![0.0; bins], vec![0.0; bins], vec![0.0; bins]);
            for ((k, _), value) in series.looks.iter().zip(&series.values) {
                if let Some(bin) = bin_of(&edges, place[*k]) {
                    count[bin] += 1.0;
                    sum[bin] += value;
                    squares[bin] += value * value;
                }
            }
            let energy: Vec<f64> = squares.iter().zip(&count).map(|(s, n)| s - n).collect();
            let positive: f64 = energy.iter().map(|value| value.max(0.0)).sum();
            out.push(Breakdown {
                experiment: self.records[series.record].name.clone(),
                channel: series.channel,
                quantity: Quantity::Output,
                coordinate,
                noise_std: series.noise_std,
                bins: (0..bins)
                    .map(|bin| {
                        let mean = sum[bin] / count[bin];
                        let variance = (squares[bin] / count[bin] - mean * mean).max(0.0);
                        Bin {
                            from: edges[bin],
                            to: edges[bin + 1],
                            count: count[bin],
                            mean: mean * series.noise_std,
                            mean_std: (variance / (count[bin] * worth).max(1.0)).sqrt()
                                * series.noise_std,
                            along_motion: f64::NAN,
                            along_motion_std: f64::NAN,
                            share: energy[bin].max(0.0) / positive.max(1e-300),
                        }
                    })
                    .collect(),
            });
            if let Some((from, to)) = shortest_run(&energy, &edges) {
                let size: f64 = energy[from..=to].iter().map(|value| value.max(0.0)).sum();
                let part = count[from..=to].iter().sum::<f64>() / n as f64;
                let region = Region {
                    experiment: self.records[series.record].name.clone(),
                    channel: series.channel,
                    quantity: Quantity::Output,
                    coordinate,
                    from: edges[from],
                    to: edges[to + 1],
                    share_of_error: (size / all.max(positive).max(1e-300)).clamp(0.0, 1.0),
                    size,
                    is_significant,
                };
                if best.as_ref().is_none_or(|(least, _)| part < *least) {
                    best = Some((part, region));
                }
            }
        }
        best.map(|(_, region)| region)
    }
}

fn bins_of(fit: &StepFit, series: usize, edges: &[f64], excess: f64) -> Vec<Bin> {
    let bins = edges.len() - 1;
    let signed = fit.beta.len() > bins;
    (0..bins)
        .map(|bin| {
            let seen = fit.count[series][bin] > 0.0;
            let of = |values: &DVector<f64>, k: usize| if seen { values[k] } else { f64::NAN };
            Bin {
                from: edges[bin],
                to: edges[bin + 1],
                count: fit.count[series][bin],
                mean: of(&fit.beta, bin),
                mean_std: of(&fit.std, bin),
                along_motion: if signed {
                    of(&fit.beta, bins + bin)
                } else {
                    f64::NAN
                },
                along_motion_std: if signed {
                    of(&fit.std, bins + bin)
                } else {
                    f64::NAN
                },
                share: (fit.energy[series][bin] / excess).clamp(0.0, 1.0),
            }
        })
        .collect()
}
