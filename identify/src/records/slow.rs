//! Where a wheel is so slow that the teeth of its motor decide where it goes.

use plant::Kind;

use super::{BALANCE_WINDOW_S, Output, Record};

/// Speed in rad/s below which a tooth may hold the wheel or turn it back. Cogging a sin(nφ) has a crest of 2a/n in energy,
/// so it holds a wheel of inertia j below 2 √(a/(n j)): at 7 rad/s for 10 mN m, six teeth and 1.4e-4 kg m². What is
/// faster passes every tooth.
const HELD_RAD_S: f64 = 8.0;
/// Time in s at the start of a log during which a slow wheel is followed in one piece: its angle is known there, and
/// a wheel that a current drives has left its tooth by then.
const AT_START_S: f64 = 0.5;

impl Record {
    /// Cuts a spin-up into windows of [`BALANCE_WINDOW_S`] where its wheel is slow, and returns whether there is anything to
    /// cut. A slow wheel with cogging comes to rest at one tooth or the next depending on differences that no sensor
    /// shows, and everything after that depends on the tooth. A fast wheel is followed in one piece.
    pub(crate) fn cut_where_slow(&mut self) -> bool {
        let Some(channel) = self.channel(Output::WheelSpeed) else {
            return false;
        };
        if self.kind != Kind::SpinUp || !self.cuts_s.is_empty() || self.is_empty() {
            return false;
        }
        let pieces = self.windows(BALANCE_WINDOW_S);
        let is_slow = |samples: &std::ops::Range<usize>| {
            let finite = channel.samples[samples.clone()]
                .iter()
                .filter(|speed| speed.is_finite());
            let mean_rad_s = finite.clone().sum::<f64>() / finite.count().max(1) as f64;
            mean_rad_s.abs() < HELD_RAD_S
        };
        let slow: Vec<bool> = pieces.iter().map(is_slow).collect();
        let leaves = slow.iter().position(|slow| !slow).unwrap_or(slow.len());
        let start_s = pieces
            .get(leaves)
            .map_or(f64::INFINITY, |piece| self.time_s[piece.start])
            - self.time_s[0];
        let first = if start_s <= AT_START_S { leaves + 1 } else { 1 };
        let cuts_s: Vec<f64> = (first..pieces.len())
            .filter(|&at| slow[at] || slow[at - 1])
            .map(|at| self.time_s[pieces[at].start])
            .collect();
        self.cuts_s = cuts_s;
        !self.cuts_s.is_empty()
    }

    /// Lets at most `most` of the windows of [`BALANCE_WINDOW_S`] count, evenly spread over the log, beside all that are
    /// longer.
    pub(crate) fn keep_short_windows(&mut self, most: usize) {
        let is_short = |samples: &std::ops::Range<usize>| {
            self.time_s[samples.end - 1] - self.time_s[samples.start] <= BALANCE_WINDOW_S
        };
        let mut short = self.windows(self.window_s);
        short.retain(is_short);
        let count = short.len();
        for (at, samples) in short.into_iter().enumerate() {
            // Of the first window more is known than of any other: it is kept.
            let is_kept = at == 0 || at * most / count != (at - 1) * most / count;
            if count > most && !is_kept {
                self.weight[samples].fill(0.0);
            }
        }
    }
}
