//! Whether the loop stays stable for plants that differ from the stated one by no more than a bound, windows of encoders
//! included.
//!
//! The loop at the stated parameters is stable, and its responses are added up over all time ([`Responses`]). Another plant adds to it
//!
//! α̈ by |s − 1| |α̈₀| + |ΔA₁| x + |ΔB₁| |w|,   ψ̈ by |ΔA₂| x + |ΔB₂| |w|,   ψ = α̇ + φ̇,
//!
//! with what the drive holds, w, between samples too. α̈₀ is what the stated plant would do in the same state: another inertia scales
//! all of it by s, and gravity and current nearly cancel in it. Let r bound the states at the samples, w and α̈₀, and let M r be what these additions
//! make of them by the sums. M is linear, and none of its entries is negative. If M r < r in every entry for some r, its powers
//! vanish. The largest late values of a motion are bounded in the weights r, by the largest earlier ones and what the start
//! leaves; they are at most M times themselves, so they are zero. The argument holds for every plant within the bound, even one that
//! changes with time.

use num_rational::BigRational;
use num_traits::{Signed, Zero};

use crate::claims::loop_as_shipped::plant::Loop;
use crate::claims::loop_as_shipped::responses::{ACCELERATIONS, HELD, Responses};
use crate::exact::rational::{integer, power_of_two, short_above as up};

/// The quantities of r: angle, rate, wheel speed, what the drive holds, and the acceleration under it.
const QUANTITIES: [usize; 5] = [0, 1, 2, HELD, ACCELERATIONS[1]];

/// Number of rounds in which r comes near to the direction that M stretches the most, and in which the bounds between two
/// samples are enlarged.
const ROUNDS: usize = 200;

/// How far the accelerations of a plant may be from those of the stated one, for each unit of angle, rate, wheel speed and
/// held current (or voltage over the winding's resistance).
#[derive(Clone, Debug, PartialEq)]
pub struct PlantOff {
    /// |s − 1|, the share by which all of α̈ may be another.
    pub scale: BigRational,
    /// α̈ besides (rad/s²).
    pub body: [BigRational; 4],
    /// ψ̈ (rad/s²).
    pub wheel: [BigRational; 4],
}

/// The factor by which M stretches r the most, below 1 where the loop is stable for every such plant; the smallest that was
/// found. `model` is [`Loop::with_wheel_input`]. `None` if the motion between two samples has no bound.
pub fn gain(model: &Loop, responses: &Responses, off: &PlantOff) -> Option<BigRational> {
    // Rows that the additions do not move at all would be zero in r.
    let mut r: [BigRational; 5] =
        QUANTITIES.map(|row| &responses.sums[1][row] + &responses.sums[2][row]);
    let mut smallest: Option<BigRational> = None;
    for _ in 0..ROUNDS {
        let largest = r.iter().max()?.clone();
        r = r.map(|bound| up(bound / &largest + power_of_two(-40)));
        let next = stretched(model, responses, off, &r)?;
        let ratio = next.iter().zip(&r).map(|(new, old)| new / old).max()?;
        let is_settled = smallest
            .as_ref()
            .is_some_and(|known| &ratio * (integer(1) + power_of_two(-10)) >= *known);
        smallest = match smallest {
            Some(known) if known <= ratio => Some(known),
            _ => Some(up(ratio)),
        };
        if is_settled || next.iter().all(Zero::is_zero) {
            break;
        }
        r = next;
    }
    smallest
}

/// M r.
fn stretched(
    model: &Loop,
    responses: &Responses,
    off: &PlantOff,
    r: &[BigRational; 5],
) -> Option<[BigRational; 5]> {
    let [_, _, _, held, acceleration] = r;
    let added = |weights: &[BigRational; 4], b: &[BigRational; 3]| -> BigRational {
        let of_states = weights.iter().zip(b).map(|(weight, bound)| weight * bound);
        up(of_states.sum::<BigRational>() + &weights[3] * held)
    };
    // As long as the states stay within b, the rows of the plant bound their change in one sample.
    let mut b: [BigRational; 3] = [0, 1, 2].map(|i| r[i].clone());
    for _ in 0..ROUNDS {
        // By how much the state, and so α̈₀, differs from that of the sample.
        let moves = b.iter().zip(r).zip(&model.a[1]);
        let change: BigRational = moves.map(|((b, r), entry)| entry.abs() * (b - r)).sum();
        let scaled = &off.scale * (acceleration + change);
        let (body, wheel) = (up(added(&off.body, &b) + scaled), added(&off.wheel, &b));
        // φ̈ = ψ̈ − α̈.
        let more = [BigRational::zero(), body.clone(), &body + &wheel];
        let reached: [BigRational; 3] = [0, 1, 2].map(|i| {
            let mut rate = model.b[i].abs() * held + &more[i];
            for (entry, bound) in model.a[i].iter().zip(&b) {
                rate += entry.abs() * bound;
            }
            up(&r[i] + &model.t * rate)
        });
        if reached.iter().zip(&b).all(|(new, old)| new <= old) {
            return Some(QUANTITIES.map(|row| {
                up(&responses.sums[1][row] * &body + &responses.sums[2][row] * &wheel)
            }));
        }
        b = reached.map(|value| up(value * (integer(1) + power_of_two(-20))));
    }
    None
}
