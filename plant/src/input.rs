//! The current that a log records, as a function of time.

use crate::Scalar;

/// The course of the current between two samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hold {
    /// A command: held until the next sample.
    Zero,
    /// A measured current: a straight line between samples.
    Linear,
}

/// A sampled current with its running integral, from which the mean over any interval follows exactly.
///
/// In an integration step, the mean of the current is used. It is exact if the step lies between two
/// samples of a held command. It is a continuous function of the motor's delay, so that the derivative
/// with respect to the delay exists although the command has steps.
#[derive(Clone, Debug)]
pub struct Input {
    time_s: Vec<f64>,
    current_a: Vec<f64>,
    charge_as: Vec<f64>,
    hold: Hold,
    /// The times in s at which a held command steps; empty if it steps too often.
    steps_s: Vec<f64>,
}

/// A held command has a step where it changes by at least this share of its largest magnitude.
const STEP_SHARE: f64 = 0.1;
/// Steps are treated one by one only if they are at least this many samples apart on average. A command that
/// changes more often enters through its mean over each integration step alone.
const SAMPLES_PER_STEP: usize = 50;

/// A part of an integration step that is shorter than this share of the step counts as empty. A command step so
/// close to the start or the end of an integration step is not treated as lying inside it.
pub(crate) const LEAST_SHARE: f64 = 1e-6;

impl Input {
    /// Builds the input from samples: `time_s` in s, strictly increasing, and `current_a` in A, of equal length.
    /// A NaN sample takes the value of the sample before it. NaN samples at the start take the first valid value,
    /// or 0 A if no sample is valid.
    pub fn new(time_s: &[f64], current_a: &[f64], hold: Hold) -> Input {
        let mut last = current_a
            .iter()
            .copied()
            .find(|current| current.is_finite())
            .unwrap_or(0.0);
        let current_a: Vec<f64> = current_a
            .iter()
            .map(|&current| {
                if current.is_finite() {
                    last = current;
                }
                last
            })
            .collect();
        let mut charge_as = vec![0.0; time_s.len()];
        for k in 1..time_s.len() {
            let mean = match hold {
                Hold::Zero => current_a[k - 1],
                Hold::Linear => 0.5 * (current_a[k - 1] + current_a[k]),
            };
            charge_as[k] = charge_as[k - 1] + mean * (time_s[k] - time_s[k - 1]);
        }
        let mut steps_s = vec![];
        if hold == Hold::Zero {
            let largest = current_a.iter().fold(0.0f64, |m, i| m.max(i.abs()));
            let pairs = time_s.iter().skip(1).zip(current_a.windows(2));
            let steps = pairs.filter(|(_, pair)| (pair[1] - pair[0]).abs() > STEP_SHARE * largest);
            // The log may begin at a step: the command before the first sample is not known.
            steps_s.extend(time_s.first());
            steps_s.extend(steps.map(|(&time_s, _)| time_s));
            if steps_s.len() * SAMPLES_PER_STEP > time_s.len() {
                steps_s.clear();
            }
        }
        Input {
            time_s: time_s.to_vec(),
            current_a,
            charge_as,
            hold,
            steps_s,
        }
    }

    /// The times in (from_s, to_s) at which a held command steps; empty if it steps too often (see
    /// [`SAMPLES_PER_STEP`]). An integration step that contains such a time is split there. The mean current alone
    /// would give the right speed at the end of the integration step, but a wrong angle.
    pub(crate) fn steps_within(&self, from_s: f64, to_s: f64) -> &[f64] {
        if self.steps_s.is_empty() {
            return &[];
        }
        let least_s = LEAST_SHARE * (to_s - from_s);
        let first = self
            .steps_s
            .partition_point(|&step| step <= from_s + least_s);
        let own = self.steps_s[first..].iter();
        let count = own.take_while(|&&step| step < to_s - least_s).count();
        &self.steps_s[first..first + count]
    }

    /// Time in s and current in A of the first sample, if there is one.
    pub fn first(&self) -> Option<(f64, f64)> {
        self.time_s
            .first()
            .copied()
            .zip(self.current_a.first().copied())
    }

    /// The index of the last sample at or before `time_s`; `hint` is the index of a sample nearby.
    fn index(&self, time_s: f64, hint: usize) -> usize {
        let near = |k: usize| {
            k < self.time_s.len()
                && self.time_s[k] <= time_s
                && self.time_s.get(k + 1).is_none_or(|&next| time_s < next)
        };
        // The current can have more samples than the log that is read: then `hint` counts other samples.
        let first_s = self.time_s.first().copied().unwrap_or(0.0);
        let span_s = self.time_s.last().copied().unwrap_or(0.0) - first_s;
        let even = (time_s - first_s) / span_s * self.time_s.len().saturating_sub(1) as f64;
        let even = even as usize;
        for k in [
            hint,
            hint + 1,
            hint.wrapping_sub(1),
            even,
            even + 1,
            even.wrapping_sub(1),
        ] {
            if near(k) {
                return k;
            }
        }
        self.time_s
            .partition_point(|&t| t <= time_s)
            .saturating_sub(1)
    }

    /// The index of the first sample after `time_s`; `hint` is the index of a sample nearby.
    fn next(&self, time_s: f64, hint: usize) -> usize {
        let is_before_all = self.time_s.first().is_some_and(|&first_s| time_s < first_s);
        if is_before_all {
            0
        } else {
            self.index(time_s, hint) + 1
        }
    }

    /// ∫ i dt up to `time_s` in A s, and i at that time in A. Before the first sample, the first value holds.
    fn charge(&self, time_s: f64, hint: usize) -> (f64, f64) {
        let (Some(&first_s), Some(&first_a)) = (self.time_s.first(), self.current_a.first()) else {
            return (0.0, 0.0);
        };
        if time_s <= first_s {
            return (first_a * (time_s - first_s), first_a);
        }
        let k = self.index(time_s, hint);
        let since = time_s - self.time_s[k];
        let current = match (self.hold, self.current_a.get(k + 1)) {
            (Hold::Linear, Some(&next)) => {
                let span = self.time_s[k + 1] - self.time_s[k];
                self.current_a[k] + (next - self.current_a[k]) * since / span
            }
            _ => self.current_a[k],
        };
        let mean = match self.hold {
            Hold::Zero => current,
            Hold::Linear => 0.5 * (self.current_a[k] + current),
        };
        (self.charge_as[k] + mean * since, current)
    }

    /// The instant within (from_s, to_s) at which a held command that is delayed by `delay_s` changes,
    /// if there is one; `hint` is the index of a sample nearby.
    pub fn change_within(&self, from_s: f64, to_s: f64, delay_s: f64, hint: usize) -> Option<f64> {
        if self.hold != Hold::Zero {
            return None;
        }
        let next = self.time_s.get(self.next(from_s - delay_s, hint))? + delay_s;
        let least_s = LEAST_SHARE * (to_s - from_s);
        (next > from_s + least_s && next < to_s - least_s).then_some(next)
    }

    /// The mean time in s for which a sample is held; `None` if the current is not a held command.
    pub fn held_s(&self) -> Option<f64> {
        let span_s = self.time_s.last()? - self.time_s.first()?;
        let steps = self.time_s.len() - 1;
        (self.hold == Hold::Zero && steps > 0).then(|| span_s / steps as f64)
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// The parts of (from_s, to_s) between the samples of a current that is delayed by `delay_s`;
    /// `hint` is the index of a sample nearby.
    pub fn stretches(
        &self,
        from_s: f64,
        to_s: f64,
        delay_s: f64,
        hint: usize,
    ) -> impl Iterator<Item = (f64, f64)> {
        let next = self.next(from_s - delay_s, hint);
        let least_s = LEAST_SHARE * (to_s - from_s);
        let within = self.time_s[next.min(self.time_s.len())..]
            .iter()
            .map(move |time_s| time_s + delay_s)
            .skip_while(move |&time_s| time_s <= from_s + least_s)
            .take_while(move |&time_s| time_s < to_s - least_s);
        let mut before = from_s;
        within.chain([to_s]).map(move |time_s| {
            let stretch = (before, time_s);
            before = time_s;
            stretch
        })
    }

    /// Mean of i(t − delay) over [from_s, to_s], in A; `hint` is the index of a sample nearby.
    #[inline]
    pub fn mean<S: Scalar>(&self, from_s: f64, to_s: f64, delay_s: Option<S>, hint: usize) -> S {
        let span = to_s - from_s;
        match delay_s {
            None => {
                if self.hold == Hold::Zero
                    && self.time_s[hint] <= from_s
                    && self.time_s.get(hint + 1).is_none_or(|&next| to_s <= next)
                {
                    return S::constant(self.current_a[hint]);
                }
                let (before, _) = self.charge(from_s, hint);
                let (after, _) = self.charge(to_s, hint);
                S::constant((after - before) / span)
            }
            Some(delay) => {
                let (before, start) = self.charge(from_s - delay.value(), hint);
                let (after, end) = self.charge(to_s - delay.value(), hint);
                delay.chain((after - before) / span, -(end - start) / span)
            }
        }
    }
}
