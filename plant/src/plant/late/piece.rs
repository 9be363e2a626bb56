//! One output over one step of the integration, and the answer of a lag to it.

use crate::Scalar;

/// One output over a stretch of time: the cubic with these values and slopes at its ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece<S> {
    pub from_s: f64,
    pub to_s: f64,
    pub from: S,
    pub from_slope: S,
    pub to: S,
    pub to_slope: S,
}

impl<S: Scalar> Piece<S> {
    fn span_s(&self) -> f64 {
        self.to_s - self.from_s
    }

    /// The value at the start of the piece and its derivatives of order 1 to 3, not divided by factorials.
    fn derivatives(&self) -> [S; 4] {
        let h = self.span_s();
        let rise = (self.to - self.from) * (1.0 / h);
        let second = (rise * 3.0 - self.from_slope * 2.0 - self.to_slope) * (2.0 / h);
        let third = (self.from_slope + self.to_slope - rise * 2.0) * (6.0 / (h * h));
        [self.from, self.from_slope, second, third]
    }

    /// The value `after_s` seconds after the start of the piece.
    pub fn at(&self, after_s: S) -> S {
        let [zeroth, first, second, third] = self.derivatives();
        let cubic = second * 0.5 + after_s * third * (1.0 / 6.0);
        zeroth + after_s * (first + after_s * cubic)
    }

    /// The output of a lag with the time constant `lag_s` while this piece is its input; `start` is its output at the
    /// start of the piece.
    pub fn behind(&self, lag_s: S, start: S) -> Piece<S> {
        let [_, first, second, third] = self.derivatives();
        let h = self.span_s();
        // The input minus the output of the lag at both ends, without the part of the output that decays.
        let behind_from = lag_s * (first - lag_s * (second - lag_s * third));
        let second_to = second + third * h;
        let behind_to = lag_s * (self.to_slope - lag_s * (second_to - lag_s * third));
        let left = if lag_s.value() > 0.0 {
            (S::constant(-h) / lag_s).exp()
        } else {
            S::zero()
        };
        let to = self.to - behind_to + (start - self.from + behind_from) * left;
        let slope = |value: S, behind: S, own: S| {
            if lag_s.value() > 0.0 {
                (value - behind) / lag_s
            } else {
                own
            }
        };
        Piece {
            from: start,
            from_slope: slope(self.from, start, self.from_slope),
            to,
            to_slope: slope(self.to, to, self.to_slope),
            ..*self
        }
    }
}
