//! The states of the loop: those of the plant, the current that the drive held, and the readings in the windows of
//! encoders.
//!
//! The state vector z begins with angle, rate, wheel speed and the current that the drive held one step before. It
//! continues with
//!
//! - an encoder on the wheel, whose speed is m/(N T): the turn m of the wheel over the last N steps, and its turns in each of
//!   the last N − 1 steps, the newest first. A step's turn is that of the wheel's angle as a fourth state of the plant.
//! - an encoder on the pivot, whose rate is (y(k) − y(k − M))/(M T) with the angles y that it shows: y(k − 1) to y(k − M).
//!   They are what it showed, errors included. So an error of y(k) acts on angle and rate of its own sample, by the
//!   difference of both in the samples after, and M steps later on the rate alone ([`Layout::reading`]).
//! - an observer of the angle's bias: its state ([`crate::claims::emitted_observer`]).

use std::ops::Range;

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::Zero;

use crate::certificate::reader::Certificate;
use crate::claims::loop_as_shipped::NoBounds;
use crate::exact::grid::{BITS, Grid, on_grid, times};
use crate::exact::rational::integer;

/// Number of states without an encoder: angle, rate, wheel speed, and the current that the drive held one step before.
const PLAIN: usize = 4;

/// Place of the current that the drive held.
const HELD: usize = 3;

/// States of the plant: angle, rate, wheel speed, wheel angle.
pub const PLANT: usize = 4;

/// Longest window of an encoder, in steps.
const WINDOW_MAX: u32 = 16;

/// A square matrix on the grid, row by row.
pub type SquareGrid = Vec<Vec<Grid>>;

/// The windows of the encoders, in steps, `None` where there is no encoder; and whether there is an observer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    wheel: Option<usize>,
    pivot: Option<usize>,
    has_observer: bool,
}

impl Layout {
    /// The layout for a certificate.
    ///
    /// # Errors
    /// [`NoBounds::Unphysical`] for a window that no encoder has, and for an observer beside an encoder on the pivot.
    pub fn of(certificate: &Certificate) -> Result<Layout, NoBounds> {
        let hardware = &certificate.hardware;
        let steps = |window: u32| {
            if (1..=WINDOW_MAX).contains(&window) {
                Ok(window as usize)
            } else {
                Err(NoBounds::Unphysical(format!(
                    "the encoder's window is {window} steps; it is 1 to {WINDOW_MAX}"
                )))
            }
        };
        let wheel = hardware.wheel_speed.encoder.as_ref();
        let pivot = hardware.body_encoder();
        let has_observer = certificate.bias_observer.is_some();
        if has_observer && pivot.is_some() {
            return Err(NoBounds::Unphysical(
                "an observer of the angle's bias belongs to gyroscope and accelerometer".to_owned(),
            ));
        }
        Ok(Layout {
            has_observer,
            wheel: wheel.map(|encoder| steps(encoder.window)).transpose()?,
            pivot: pivot.map(|encoder| steps(encoder.window)).transpose()?,
        })
    }

    /// Number of states.
    pub fn order(&self) -> usize {
        self.angles().end + usize::from(self.has_observer)
    }

    /// Place of the observer's state.
    pub fn observer(&self) -> Option<usize> {
        self.has_observer.then_some(self.angles().end)
    }

    /// Places of the wheel's turns: over the window, and in its single steps.
    pub fn turns(&self) -> Range<usize> {
        PLAIN..PLAIN + self.wheel.unwrap_or(0)
    }

    /// Places of the angles that the encoder on the pivot showed.
    pub fn angles(&self) -> Range<usize> {
        let first = self.turns().end;
        first..first + self.pivot.unwrap_or(0)
    }

    /// A row of gains as a row of z, with the entry of the observer's state where there is one. Rate and wheel speed
    /// are those of the sample, or follow from the windows of the encoders.
    pub fn row(
        &self,
        gains: &[BigRational; 3],
        of_observer: &BigRational,
        t: &BigRational,
    ) -> Vec<BigRational> {
        let [angle, rate, speed] = gains.clone();
        let mut row = vec![BigRational::zero(); self.order()];
        row[0] = angle;
        match self.pivot {
            None => row[1] = rate,
            Some(window) => {
                let slope = rate / (integer(window as i128) * t);
                row[0] += &slope;
                row[self.angles().end - 1] = -slope;
            }
        }
        match self.wheel {
            None => row[2] = speed,
            Some(window) => row[PLAIN] = speed / (integer(window as i128) * t),
        }
        if let Some(place) = self.observer() {
            row[place].clone_from(of_observer);
        }
        row
    }

    /// The change of z for a change of the plant's states. The turn of the wheel enters the window and is the newest
    /// single turn.
    pub fn column(&self, plant: &[Grid; PLANT]) -> Vec<Grid> {
        let [angle, rate, speed, turn] = plant.clone();
        let mut found = vec![angle, rate, speed, Grid::zero()];
        found.resize_with(self.order(), Grid::zero);
        // The window, and the newest of the single turns where there are any.
        for entry in found[self.turns()].iter_mut().take(2) {
            entry.clone_from(&turn);
        }
        found
    }

    /// The state at rest at 1 rad; the encoder on the pivot has shown this angle all the time, and an observer with
    /// this ℓ₁ sees no bias.
    pub fn at_rest(&self, direct: &BigRational) -> Vec<Grid> {
        let one = BigInt::from(1) << BITS;
        let mut found = vec![Grid::zero(); self.order()];
        found[0].clone_from(&one);
        found[self.angles()].fill(one);
        if let Some(place) = self.observer() {
            found[place] = -on_grid(direct);
        }
        found
    }

    /// The change of z for an error of 1 of what one sample shows, or computes. `at_once` is the share of the error in the held
    /// current, `new` the effect of this share in the rest of the sample; `into` the share in the observer's state. The
    /// encoder on the pivot has shown the error too.
    pub fn reading(
        &self,
        new: &[Grid; PLANT],
        at_once: &BigRational,
        into: &BigRational,
    ) -> Vec<Grid> {
        let at_once = on_grid(at_once);
        let mut found = self.column(&new.each_ref().map(|entry| times(entry, &at_once)));
        found[HELD] = at_once;
        if self.pivot.is_some() {
            found[self.angles().start] = BigInt::from(1) << BITS;
        }
        if let Some(place) = self.observer() {
            found[place] = on_grid(into);
        }
        found
    }

    /// The change of z for an error of 1 rad before the start: of the oldest reading in the window of an encoder on
    /// the pivot, or of the observer's state. The error of a younger reading becomes this one later, so that the
    /// errors of all readings before the start act one after another in as many steps as [`Layout::angles`] has.
    /// `None` without either.
    pub fn before_start(&self) -> Option<Vec<Grid>> {
        if self.pivot.is_none() && !self.has_observer {
            return None;
        }
        let mut found = vec![Grid::zero(); self.order()];
        found[self.order() - 1] = BigInt::from(1) << BITS;
        Some(found)
    }

    /// F: the plant under the old input until the delay is over, and under `held` of z afterwards. `own` is the row of the
    /// observer's next state.
    pub fn closed(
        &self,
        ad: &[[Grid; PLANT]; PLANT],
        whole: &[Grid; PLANT],
        new: &[Grid; PLANT],
        held: &[BigRational],
        own: Option<&[BigRational]>,
    ) -> SquareGrid {
        let row: Vec<Grid> = held.iter().map(on_grid).collect();
        let of_plant = |i: usize| -> Vec<Grid> {
            let mut found: Vec<Grid> = row.iter().map(|gain| times(&new[i], gain)).collect();
            for (entry, own) in found.iter_mut().zip(&ad[i][..3]) {
                *entry += own;
            }
            found[HELD] += &whole[i] - &new[i];
            found
        };
        let one = BigInt::from(1) << BITS;
        let unit = |place: usize| -> Vec<Grid> {
            let mut found = vec![Grid::zero(); self.order()];
            found[place].clone_from(&one);
            found
        };
        let mut f = vec![of_plant(0), of_plant(1), of_plant(2), row.clone()];
        for (index, place) in self.turns().enumerate() {
            f.push(match index {
                0 => {
                    // The new turn, and all turns that stay in the window.
                    let mut sum = of_plant(3);
                    for entry in &mut sum[self.turns()][1..] {
                        *entry += &one;
                    }
                    sum
                }
                1 => of_plant(3),
                _ => unit(place - 1),
            });
        }
        for (index, place) in self.angles().enumerate() {
            f.push(unit(if index == 0 { 0 } else { place - 1 }));
        }
        f.extend(own.map(|row| row.iter().map(on_grid).collect::<Vec<Grid>>()));
        f
    }
}
