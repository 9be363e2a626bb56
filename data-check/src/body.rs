//! The body of a log in which everything is free: its acceleration, and gravity on it as a function of its angle.

use std::f64::consts::{PI, TAU};

use bench_files::Channel;
use identify::{WeakForm, bumps};
use plant::Kind;

use crate::regression::{LeastSquares, least_squares, ratio};
use crate::thresholds::fit::FEWEST_ROWS;
use crate::thresholds::momentum::{EQUAL, OWN_MOTION};
use crate::view::View;

/// The body's motion, from its angle or from its rate alone.
pub(crate) struct Body<'v> {
    view: &'v View<'v>,
    rate: Option<&'v [f64]>,
    /// The angle as read, or the integral of the rate from the equilibrium on.
    angle: Vec<f64>,
    /// The channel that a wrong unit would be in.
    pub channel: Channel,
    equilibrium: f64,
}

/// What accelerates the body beside gravity.
pub(crate) enum Cause<'v> {
    /// The wheel, by its acceleration: no torque of the motor enters.
    Wheel(&'v [f64]),
    /// The motor, by its current, with the friction of the wheel (its speed) or of the pivot (`None`).
    Current(&'v [f64], Option<&'v [f64]>),
}

impl<'v> Body<'v> {
    /// `None` for kinds that hold a joint still, and without angle and rate.
    pub fn of(view: &'v View<'v>) -> Option<Body<'v>> {
        let equilibrium = match view.kind() {
            Kind::Balance => PI,
            Kind::Driven => 0.0,
            Kind::FreeSwing | Kind::SpinUp => return None,
        };
        let rate = view.samples(Channel::Rate);
        let (angle, channel) = match (view.samples(Channel::Angle), rate) {
            (Some(angle), _) => (angle.to_vec(), Channel::Angle),
            (None, Some(rate)) => {
                let time_s = &view.experiment.log.time_s;
                let mut angle = equilibrium;
                let mut angles = vec![angle];
                for k in 1..rate.len() {
                    let step = 0.5 * (rate[k] + rate[k - 1]) * (time_s[k] - time_s[k - 1]);
                    angle += if step.is_finite() { step } else { 0.0 };
                    angles.push(angle);
                }
                (angles, Channel::Rate)
            }
            (None, None) => return None,
        };
        Some(Body {
            view,
            rate,
            angle,
            channel,
            equilibrium,
        })
    }

    /// The best fit α̈ = c₀ · cause + c₁ sin α (+ c₂ · friction, or + c₂ cos α), if the true angle is that of the
    /// channel divided by `scale`. Columns in this order. The length of the bumps is the one that explains most.
    pub fn fit(&self, cause: &Cause, scale: f64) -> Option<LeastSquares> {
        let (angle, rate) = (&self.angle, self.rate);
        let true_angle = |angle: &f64| self.equilibrium + (angle - self.equilibrium) / scale;
        let (sine, cosine): (Vec<f64>, Vec<f64>) = angle
            .iter()
            .map(|angle| true_angle(angle).sin_cos())
            .unzip();
        let fits = self.view.bump_lengths_s().filter_map(|length_s| {
            let mut rows = vec![];
            bumps(&self.view.record, length_s, |bump| {
                let acceleration = self.acceleration(bump);
                let gravity = bump.integral(&sine, 0);
                let (cause, third) = match cause {
                    // Where gravity is zero is not known for a rate that was integrated, and told for an angle.
                    Cause::Wheel(speed) => (-bump.integral(speed, 1), bump.integral(&cosine, 0)),
                    Cause::Current(current, wheel_speed) => (
                        bump.integral(current, 0),
                        match (wheel_speed, rate) {
                            (Some(speed), _) => bump.integral(speed, 0),
                            (None, Some(rate)) => bump.integral(rate, 0),
                            (None, None) => -bump.integral(angle, 1),
                        },
                    ),
                };
                rows.push(([cause, gravity, third], acceleration));
            });
            // Neighbouring bumps overlap by half.
            least_squares(&rows, 2.0)
        });
        let fits = fits.filter(|fit| fit.rows >= FEWEST_ROWS);
        fits.max_by(|a, b| a.explained.total_cmp(&b.explained))
    }

    /// The best fit α̈ = c₀ sin α + c₁ cos α, of a body on which gravity acts alone.
    pub fn fit_gravity(&self) -> Option<LeastSquares> {
        let (sine, cosine): (Vec<f64>, Vec<f64>) = self.angle.iter().map(|a| a.sin_cos()).unzip();
        let fits = self.view.bump_lengths_s().filter_map(|length_s| {
            let mut rows = vec![];
            bumps(&self.view.record, length_s, |bump| {
                let gravity = [bump.integral(&sine, 0), bump.integral(&cosine, 0)];
                rows.push((gravity, self.acceleration(bump)));
            });
            least_squares(&rows, 2.0)
        });
        let fits = fits.filter(|fit| fit.rows >= FEWEST_ROWS);
        fits.max_by(|a, b| a.explained.total_cmp(&b.explained))
    }

    /// Whether the wheel keeps its own motion, as one that no torque reaches: φ̈ = −α̈. Wheel and gravity are then one
    /// function of the log, and nothing can be told of either.
    pub fn leaves_the_wheel(&self, speed: &[f64]) -> bool {
        let ratios = self.view.bump_lengths_s().filter_map(|length_s| {
            let mut points = vec![];
            bumps(&self.view.record, length_s, |bump| {
                points.push((self.acceleration(bump), -bump.integral(speed, 1)));
            });
            ratio(&points, FEWEST_ROWS)
        });
        let best = ratios.max_by(|a, b| a.correlation.abs().total_cmp(&b.correlation.abs()));
        best.is_some_and(|best| best.correlation < -OWN_MOTION && (best.factor + 1.0).abs() < EQUAL)
    }

    /// ∫ α̈ ψ dt under a bump.
    fn acceleration(&self, bump: &WeakForm) -> f64 {
        match self.rate {
            Some(rate) => -bump.integral(rate, 1),
            None => {
                // A constant has no acceleration, but the trapezoidal rule leaves a part of it.
                let middle = bump.integral(&self.angle, 0) / bump.area();
                bump.integral_of(|k| self.angle[k] - middle, 2)
            }
        }
    }

    /// How many turns the angle covers, as read.
    pub fn turns(&self) -> f64 {
        crate::view::range(&self.angle).map_or(0.0, |(low, high)| (high - low) / TAU)
    }
}
