//! The bench as the controller meets it: the current reaches the plant late, and the sensors are late and filtered.
//!
//! The difference equation is exact. A sensor's low-pass filter, T ẏ = v − y, is a state of the plant. A delay
//! consists of whole samples and a fraction of a sample. The current at the plant changes once in a sample interval,
//! after the fraction of its delay, and the hold is split at that time ([`zero_order_hold_delayed`]). A late sensor
//! shows the plant at an instant between two samples; the same split hold gives the state at that instant from the
//! sample before. Whole samples of a delay are shift states (Åström and Wittenmark, "Computer-Controlled Systems", 3rd
//! ed., section 2.3). The result is
//!
//! ```text
//! x⁺ = Ad x + Bp u₋₍d₊₁₎ + Bn u₋d,   yᵢ = z^−mᵢ (Cᵢ x + Pᵢ u₋₍d₊₁₎ + Nᵢ u₋d)
//! ```
//!
//! with u₋d the current that was commanded d samples before; d and mᵢ are whole numbers of samples.

use crate::error::DesignError;
use crate::matrix::check_shape;
use crate::zero_order_hold::{DelayedDiscrete, held_for, zero_order_hold_delayed};
use nalgebra::{Complex, DMatrix};

/// Filter and delay of one sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SensorLateness {
    /// Time constant of its low-pass filter in s; zero for none.
    pub lag_s: f64,
    /// Delay behind the filter in s: transport, and the age of a reading.
    pub delay_s: f64,
}

/// The delay of the current, and the filters and delays of the sensors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lateness {
    /// Time from a sample to the change of the current at the plant, in s.
    pub current_s: f64,
    /// Lateness of the sensors of angle, rate and wheel speed, in this order.
    pub sensors: [SensorLateness; 3],
}

impl Lateness {
    /// A bench whose current is late by `current_s` (s) and whose sensors are not.
    pub fn of_current(current_s: f64) -> Lateness {
        Lateness {
            current_s,
            ..Lateness::default()
        }
    }

    pub(crate) fn check(&self) -> Result<(), DesignError> {
        let sensors = self.sensors.iter().flat_map(|one| [one.lag_s, one.delay_s]);
        for value in sensors.chain([self.current_s]) {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(DesignError::NotPositive {
                    what: "a delay or a filter's time constant in s (where zero is allowed too)",
                    value,
                });
            }
        }
        Ok(())
    }
}

/// A delay, divided into whole samples and a fraction.
pub(crate) struct Delay {
    /// Whole samples.
    pub(crate) whole: usize,
    /// The remaining fraction of a sample, in s.
    pub(crate) part_s: f64,
}

impl Delay {
    pub(crate) fn new(delay_s: f64, sample_time_s: f64) -> Self {
        let whole = (delay_s / sample_time_s).floor().max(0.0);
        Delay {
            whole: whole as usize,
            part_s: (delay_s - whole * sample_time_s).clamp(0.0, sample_time_s),
        }
    }
}

/// The sampled plant from the commanded current to the readings of the sensors.
pub(crate) struct LatePlant {
    plant: DelayedDiscrete,
    /// d, whole samples of the current's delay.
    whole: usize,
    /// Whether the current is late at all.
    is_late: bool,
    outputs: Vec<LateOutput>,
}

/// One sensor i, with the symbols of the equation above.
struct LateOutput {
    /// mᵢ, whole samples of its delay.
    shifts: usize,
    /// Cᵢ (1×n).
    from_state: DMatrix<f64>,
    /// Pᵢ, per A of u₋₍d₊₁₎.
    from_previous: f64,
    /// Nᵢ, per A of u₋d.
    from_new: f64,
}

/// x⁺ = `state` x + `input` u, y = `output` x.
pub(crate) struct Augmented {
    pub(crate) state: DMatrix<f64>,
    pub(crate) input: DMatrix<f64>,
    pub(crate) output: DMatrix<f64>,
}

impl LatePlant {
    /// ẋ = A x + B u (A n×n, B n×1) sampled at `sample_time_s`. Every state is measured, the first three by the sensors
    /// of `lateness`, any further ones at once.
    ///
    /// # Errors
    /// Wrong shapes; a sample time that is not positive; a negative delay.
    pub(crate) fn new(
        a: &DMatrix<f64>,
        b: &DMatrix<f64>,
        sample_time_s: f64,
        lateness: &Lateness,
    ) -> Result<LatePlant, DesignError> {
        lateness.check()?;
        let n = a.nrows();
        check_shape("the state matrix A", a, n, n)?;
        check_shape("the input matrix B", b, n, 1)?;
        // One more state for each filter: its output, which is measured in place of the filtered state.
        let filtered: Vec<usize> = (0..lateness.sensors.len().min(n))
            .filter(|sensor| lateness.sensors[*sensor].lag_s > 0.0)
            .collect();
        let states = n + filtered.len();
        let (mut whole_a, mut whole_b) =
            (DMatrix::zeros(states, states), DMatrix::zeros(states, 1));
        whole_a.view_mut((0, 0), (n, n)).copy_from(a);
        whole_b.view_mut((0, 0), (n, 1)).copy_from(b);
        let mut shown: Vec<usize> = (0..n).collect();
        for (index, sensor) in filtered.into_iter().enumerate() {
            let (own, lag_s) = (n + index, lateness.sensors[sensor].lag_s);
            whole_a[(own, sensor)] = 1.0 / lag_s;
            whole_a[(own, own)] = -1.0 / lag_s;
            shown[sensor] = own;
        }
        let current = Delay::new(lateness.current_s, sample_time_s);
        let plant = zero_order_hold_delayed(&whole_a, &whole_b, sample_time_s, current.part_s)?;
        let output = |(sensor, state): (usize, usize)| -> Result<LateOutput, DesignError> {
            let delay_s = lateness.sensors.get(sensor).map_or(0.0, |one| one.delay_s);
            let delay = Delay::new(delay_s, sample_time_s);
            let pick = DMatrix::from_fn(1, states, |_, column| f64::from(column == state));
            if delay.part_s == 0.0 {
                return Ok(LateOutput {
                    shifts: delay.whole,
                    from_state: pick,
                    from_previous: 0.0,
                    from_new: 0.0,
                });
            }
            // The instant lies this long after the sample before it.
            let after_s = sample_time_s - delay.part_s;
            let change_s = current.part_s.min(after_s);
            let early = held_for(&whole_a, &whole_b, change_s)?;
            let late = held_for(&whole_a, &whole_b, after_s - change_s)?;
            Ok(LateOutput {
                shifts: delay.whole + 1,
                from_state: &pick * &late.state * &early.state,
                from_previous: (&pick * &late.state * &early.input)[0],
                from_new: (&pick * &late.input)[0],
            })
        };
        let outputs = shown.into_iter().enumerate().map(output);
        Ok(LatePlant {
            plant,
            whole: current.whole,
            is_late: lateness.current_s > 0.0,
            outputs: outputs.collect::<Result<_, _>>()?,
        })
    }

    /// This plant with its delays as states: (x, filters, u₋₁ … u₋₍d₊₁₎, the shifted readings of each sensor).
    pub(crate) fn augmented(&self) -> Augmented {
        let n = self.plant.state.nrows();
        let past = if self.is_late { self.whole + 1 } else { 0 };
        let shifts: usize = self.outputs.iter().map(|one| one.shifts).sum();
        let size = n + past + shifts;
        let mut state = DMatrix::zeros(size, size);
        let mut input = DMatrix::zeros(size, 1);
        let mut output = DMatrix::zeros(self.outputs.len(), size);
        state.view_mut((0, 0), (n, n)).copy_from(&self.plant.state);
        // A row that takes `factor` of u₋₍d₊₁₎ and of u₋d.
        let mut takes = |state: &mut DMatrix<f64>, row: usize, previous: f64, new: f64| {
            if past > 0 {
                state[(row, n + past - 1)] += previous;
            }
            if self.whole == 0 {
                input[(row, 0)] += new;
            } else {
                state[(row, n + past - 2)] += new;
            }
        };
        for row in 0..n {
            let (previous, new) = (self.plant.previous_input[row], self.plant.new_input[row]);
            takes(&mut state, row, previous, new);
        }
        let mut next = n + past;
        for (sensor, one) in self.outputs.iter().enumerate() {
            if one.shifts == 0 {
                output
                    .view_mut((sensor, 0), (1, n))
                    .copy_from(&one.from_state);
                continue;
            }
            state.view_mut((next, 0), (1, n)).copy_from(&one.from_state);
            takes(&mut state, next, one.from_previous, one.from_new);
            for shift in 1..one.shifts {
                state[(next + shift, next + shift - 1)] = 1.0;
            }
            next += one.shifts;
            output[(sensor, next - 1)] = 1.0;
        }
        if past > 0 {
            input[(n, 0)] = 1.0;
        }
        for index in 1..past {
            state[(n + index, n + index - 1)] = 1.0;
        }
        Augmented {
            state,
            input,
            output,
        }
    }

    /// The transfer function from the current to the readings at z, one row for each sensor; `None` at a pole.
    pub(crate) fn transfer(&self, z: Complex<f64>) -> Option<DMatrix<Complex<f64>>> {
        let plant = &self.plant;
        let input =
            plant.new_input.map(Complex::from) + plant.previous_input.map(Complex::from) / z;
        let state = resolvent(&plant.state, z, &input)?;
        let late = z.powu(u32::try_from(self.whole).ok()?);
        let mut shown = DMatrix::zeros(self.outputs.len(), 1);
        for (sensor, one) in self.outputs.iter().enumerate() {
            let direct = Complex::from(one.from_new) + Complex::from(one.from_previous) / z;
            let value = (one.from_state.map(Complex::from) * &state)[0] + direct;
            shown[sensor] = value / (late * z.powu(u32::try_from(one.shifts).ok()?));
        }
        Some(shown)
    }
}

/// (zI − M)⁻¹ right.
pub(crate) fn resolvent(
    matrix: &DMatrix<f64>,
    z: Complex<f64>,
    right: &DMatrix<Complex<f64>>,
) -> Option<DMatrix<Complex<f64>>> {
    let n = matrix.nrows();
    if n == 0 {
        return Some(right.clone());
    }
    DMatrix::from_fn(n, n, |row, column| {
        let entry = Complex::from(-matrix[(row, column)]);
        if row == column { z + entry } else { entry }
    })
    .lu()
    .solve(right)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::thesis;
    use proptest::prelude::*;

    const T: f64 = 1e-3;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]
        /// Shift states and powers of z give the same transfer function, and a delay that all sensors share acts like
        /// the same delay of the current.
        #[test]
        fn states_and_transfer_agree(
            current in 0.0..4.0_f64,
            delays in prop::array::uniform3(0.0..4.0_f64),
            lags in prop::array::uniform3(0.0..4.0_f64),
            whole in prop::array::uniform4(any::<bool>()),
            phase in 0.01..3.1_f64,
        ) {
            let time = |value: f64, whole: bool| T * if whole { value.round() } else { value };
            let lateness = Lateness {
                current_s: time(current, whole[3]),
                sensors: [0, 1, 2].map(|index| SensorLateness {
                    lag_s: if lags[index] < 1.0 { 0.0 } else { T * lags[index] },
                    delay_s: time(delays[index], whole[index]),
                }),
            };
            let plant = LatePlant::new(&thesis::a(), &thesis::b(), T, &lateness).unwrap();
            let z = Complex::from_polar(1.0, phase);
            let by_powers = plant.transfer(z).unwrap();
            let states = plant.augmented();
            let inner = resolvent(&states.state, z, &states.input.map(Complex::from)).unwrap();
            let by_states = states.output.map(Complex::from) * inner;
            let error = (&by_powers - &by_states).norm();
            prop_assert!(error < 1e-9 * by_powers.norm(), "{lateness:?}: {error:e}");

            let shared = Lateness {
                current_s: 0.0,
                sensors: [SensorLateness { lag_s: 0.0, delay_s: lateness.current_s }; 3],
            };
            let sensors = LatePlant::new(&thesis::a(), &thesis::b(), T, &shared).unwrap();
            let current = Lateness::of_current(lateness.current_s);
            let current = LatePlant::new(&thesis::a(), &thesis::b(), T, &current).unwrap();
            let (left, right) = (sensors.transfer(z).unwrap(), current.transfer(z).unwrap());
            prop_assert!((&left - &right).norm() < 1e-9 * right.norm());
        }
    }

    #[test]
    fn a_negative_delay_is_refused() {
        let early = Lateness::of_current(-1e-3);
        assert!(LatePlant::new(&thesis::a(), &thesis::b(), T, &early).is_err());
    }
}
