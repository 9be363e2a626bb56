//! Starts of windows of a model with cogging. Cogging pulls the wheel towards a tooth. A window that starts on the wrong
//! side of a tooth is in a local minimum; so is one that starts with the speed that a model without cogging needed.

use std::f64::consts::PI;

use plant::Model;
use rayon::prelude::*;

use super::sensitivity::{normal, window_cost};
use super::unknowns::{Nuisance, Unknowns, Window};
use super::windows::guess;
use crate::records::{BALANCE_WINDOW_S, Output, Record};

/// Wheel angles that are tried for the start of a window, as shares of the largest one.
const TRIED: [f64; 5] = [0.0, -1.0, -0.5, 0.5, 1.0];
/// The largest one in standard deviations of the angle's prior, and as a share of half a tooth: five angles cover a
/// tooth evenly from four fifths of its halves.
const LARGEST_STD: f64 = 2.0;
const LARGEST_SHARE: f64 = 0.8;
/// A smaller change of the cogging's phase, in rad, is no other start.
const LEAST_PHASE_RAD: f64 = 0.05;
/// A window is followed if its χ² exceeds its number of observations by at most this many standard deviations of χ²:
/// of thousands of windows hardly one exceeds them by chance.
const FOLLOWED_STD: f64 = 4.0;
/// Parts of a window over which a start is sought, one after the other, with the starts that are kept after each.
/// Differences at the start grow over a window; in its first quarter the cost is nearly quadratic.
const PARTS: [(usize, usize); 3] = [(4, 4), (2, 2), (1, 1)];
/// Evaluations of a descent over one part.
const EVALUATIONS: usize = 6;
/// A descent ends where a step promises less than this in χ².
const HARDLY_ANYTHING: f64 = 0.1;
/// Longest window in s for which starts are sought by descent. A longer one begins where the wheel's angle is known.
const LONGEST_S: f64 = 2.0 * BALANCE_WINDOW_S;

/// Moves the start of every window that a model with cogging does not follow to where it does. The given start, one
/// guessed from the samples, and both with the wheel turned by parts of a tooth are compared. Windows of a model
/// without cogging are returned unchanged.
pub fn settled(
    records: &[&Record],
    model: &Model,
    values: &[f64],
    windows: Vec<Vec<Window>>,
) -> Vec<Vec<Window>> {
    let order = model
        .find(|info| info.ripple.is_some())
        .and_then(|(effect, at)| Some(values[at + effect.info().ripple?.order]));
    let Some(order) = order else {
        return windows;
    };
    let starts = Starts {
        model,
        values,
        order,
        no_globals: Unknowns::new(model, &[]),
    };
    records
        .iter()
        .zip(windows)
        .map(|(record, list)| {
            let has_wheel = record.channel(Output::WheelSpeed).is_some();
            list.into_par_iter()
                .map(|window| {
                    if has_wheel {
                        starts.settle(record, window)
                    } else {
                        window
                    }
                })
                .collect()
        })
        .collect()
}

/// Starts of windows for a model with its parameters.
struct Starts<'a> {
    model: &'a Model,
    values: &'a [f64],
    /// Teeth in one turn.
    order: f64,
    no_globals: Unknowns,
}

impl Starts<'_> {
    fn cost(&self, record: &Record, window: &Window) -> f64 {
        window_cost(record, window, self.model, self.values)
    }

    fn settle(&self, record: &Record, window: Window) -> Window {
        let given = self.cost(record, &window);
        if given <= expected_of_noise(record, &window) {
            return window;
        }
        let mut tried = self.tried(record, &window);
        let first_s = record.time_s[window.samples.start];
        let span_s = record.time_s[window.samples.end - 1] - first_s;
        if span_s <= LONGEST_S {
            for (parts, kept) in PARTS {
                self.descend(record, &mut tried, parts);
                tried.truncate(kept);
            }
        }
        let costs = tried.into_iter().map(|start| {
            let cost = self.cost(record, &start);
            (start, cost)
        });
        let best = costs.fold(
            (window, given),
            |best, next| {
                if next.1 < best.1 { next } else { best }
            },
        );
        best.0
    }

    /// The starts that are tried for a window.
    fn tried(&self, record: &Record, window: &Window) -> Vec<Window> {
        let guessed = guess(record, self.values, window.samples.clone());
        let mut tried = vec![window.clone(), guessed];
        let nuisances = Nuisance::of(record);
        let angle = nuisances
            .iter()
            .position(|&local| local == Nuisance::WheelAngle);
        let std_rad = Nuisance::WheelAngle.prior_std(record, window.samples.start);
        let (Some(at), Some(std_rad)) = (angle, std_rad) else {
            return tried;
        };
        let largest_rad = (LARGEST_STD * std_rad).min(LARGEST_SHARE * PI / self.order);
        if largest_rad * self.order < LEAST_PHASE_RAD {
            return tried;
        }
        for mut start in tried.clone() {
            tried.extend(TRIED.map(|share| {
                start.nuisances[at] = share * largest_rad;
                start.clone()
            }));
        }
        tried
    }

    /// Lets every start descend over the first of so many parts of the window, and sorts them by the cost there.
    fn descend(&self, record: &Record, tried: &mut Vec<Window>, parts: usize) {
        let mut reached: Vec<(f64, Window)> = tried
            .drain(..)
            .map(|start| {
                let whole = start.samples.clone();
                let part = Window {
                    samples: whole.start..whole.start + whole.len().div_ceil(parts),
                    nuisances: start.nuisances,
                };
                let (cost, part) = self.descended(record, part);
                let samples = whole;
                (cost, Window { samples, ..part })
            })
            .collect();
        reached.sort_by(|(one, _), (other, _)| one.total_cmp(other));
        tried.extend(reached.into_iter().map(|(_, window)| window));
    }

    /// The window with its start where a descent leads (Levenberg–Marquardt), and its cost there.
    fn descended(&self, record: &Record, window: Window) -> (f64, Window) {
        let at = |window: &Window| {
            let unknowns = &self.no_globals;
            normal(record, window, self.model, self.values, unknowns, &[])
        };
        let (mut window, mut damping) = (window, 1e-3);
        let mut here = at(&window);
        for _ in 1..EVALUATIONS {
            let mut matrix = here.hessian.clone();
            for own in 0..matrix.nrows() {
                matrix[(own, own)] *= 1.0 + damping;
            }
            let Some(factor) = matrix.cholesky() else {
                break;
            };
            let step = factor.solve(&here.gradient);
            if step.dot(&here.gradient) < HARDLY_ANYTHING {
                break;
            }
            let mut moved = window.clone();
            for (&local, change) in here.nuisances.iter().zip(step.iter()) {
                moved.nuisances[local] += change;
            }
            let there = at(&moved);
            if there.cost < here.cost {
                (window, here) = (moved, there);
                damping *= 0.1;
            } else {
                damping = 10.0 * f64::max(damping, 1e-2);
            }
        }
        (here.cost, window)
    }
}

/// The χ² of a window up to which it counts as followed.
fn expected_of_noise(record: &Record, window: &Window) -> f64 {
    let counts = |k: &usize| record.weight[*k] > 0.0;
    let samples = window.samples.clone().filter(counts).count();
    let observations = (samples * record.channels.len()) as f64;
    observations + FOLLOWED_STD * (2.0 * observations).sqrt()
}
