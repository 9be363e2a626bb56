//! The kind of experiment that a file holds.

use std::f64::consts::PI;

use bench_files::{Channel, Table};
use plant::Kind;

use super::columns::{Mapped, is_index};
use crate::regression::least_squares;
use crate::slips::short;
use crate::thresholds::constant::COMMAND_LEVELS;
use crate::thresholds::propose::{ABOUT_UPRIGHT, FREE, HELD, LOCKED, REST, SHOWS};
use crate::view::{levels, median, range};

/// The question for a log in which a wheel turns and no column is its current.
pub(super) const HELD_AT_WHAT: &str = "the current was not logged: constants = { current = … } says at what it was \
                                       held (0.0 for a coast-down)";

/// The question for a wheel that is driven by a current of many values, as in a log of balancing.
const BODY_CLAMPED: &str = "the file has neither angle nor rate of the body: was it clamped? If it was free, its angle or rate \
                            is needed (kind = \"driven\" or \"balance\")";
/// The question for a log in which everything moves and the angle is not there.
const NO_ANGLE: &str = "the angle was not logged: did the body hang (kind = \"driven\") or balance upright (kind = \
                        \"balance\")?";

/// What is proposed, and why.
pub(super) struct Guess {
    pub kind: Kind,
    pub reason: String,
    pub offset_rad: Option<(f64, String)>,
    pub held_current_a: Option<(f64, String)>,
    pub questions: Vec<String>,
}

pub(super) fn guess(table: &Table, mapped: &[Mapped]) -> Guess {
    let samples = |channel: Channel| -> Option<Vec<f64>> {
        let one = mapped.iter().find(|one| one.channel == channel)?;
        let scale = match one.unit {
            Some("deg" | "deg/s") => PI / 180.0,
            Some("mrad" | "mrad/s" | "mA" | "ms") => 1e-3,
            Some("rpm") => PI / 30.0,
            Some("rev" | "rev/s") => 2.0 * PI,
            _ => 1.0,
        };
        let values = table.columns[one.index].iter().map(|x| scale * x);
        Some(match channel {
            Channel::Angle | Channel::WheelAngle => unwrapped(values),
            _ => values.collect(),
        })
    };
    let angle = samples(Channel::Angle);
    let body = angle.is_some() || samples(Channel::Rate).is_some();
    let wheel = samples(Channel::WheelSpeed).or_else(|| samples(Channel::WheelAngle));
    let current = samples(Channel::Current);
    let is_driven = current.as_deref().is_some_and(moves);
    let mut guess = Guess {
        kind: Kind::FreeSwing,
        reason: String::new(),
        offset_rad: None,
        held_current_a: None,
        questions: vec![],
    };
    if wheel.is_some() && !body {
        guess.kind = Kind::SpinUp;
        guess.reason = "the file has the wheel and not the body".to_owned();
        if current.is_none() {
            guess.questions.push(HELD_AT_WHAT.to_owned());
            let of_column = command(table).or_else(|| which_current(table, mapped));
            guess.questions.extend(of_column);
        } else if current
            .as_deref()
            .is_some_and(|current| levels(current) > COMMAND_LEVELS)
        {
            guess.questions.push(BODY_CLAMPED.to_owned());
        }
        return guess;
    }
    if wheel.is_none() && !body {
        guess.reason = "no name says what moves".to_owned();
        guess.questions.extend(which_motion(table, mapped));
        return guess;
    }
    let time = samples(Channel::Time);
    let is_locked = match (&angle, samples(Channel::WheelSpeed), &time) {
        (Some(angle), Some(speed), Some(time)) => stays_with(angle, &speed, time),
        _ => false,
    };
    if is_locked || (!is_driven && !wheel.as_deref().is_some_and(moves)) {
        guess.reason = match &wheel {
            Some(_) if is_driven => {
                "the body swings and the wheel stands still, whatever the current shows"
            }
            Some(_) => "the body swings and the wheel stands still",
            None => "the file has the body and not the wheel",
        }
        .to_owned();
        if let Some(angle) = &angle {
            rest(angle, &mut guess);
        }
        return guess;
    }
    if let (Some(angle), Some(speed), Some(time)) = (&angle, samples(Channel::WheelSpeed), &time)
        && is_free(angle, &speed, time)
    {
        guess.kind = Kind::Driven;
        guess.reason =
            "the body swings and the wheel keeps its own motion: no current flows".to_owned();
        rest(angle, &mut guess);
        let column = mapped.iter().find(|one| one.channel == Channel::Current);
        match column {
            // A column with the standard name is read, mapped or not.
            Some(one) if one.column == Channel::Current.standard_name() => {
                guess.questions.push(format!(
                    "the wheel does not follow the current of the file: if none flowed, give the column \"{}\" another \
                     name in the file and write constants = {{ current = 0.0 }}",
                    one.column
                ));
            }
            Some(_) => {
                let reason = "the wheel does not follow the file's current, which is left out";
                guess.held_current_a = Some((0.0, reason.to_owned()));
            }
            None => {
                let reason = "the wheel feels no motor";
                guess.held_current_a = Some((0.0, reason.to_owned()));
            }
        }
        return guess;
    }
    upright(
        angle.as_deref(),
        wheel.as_deref(),
        current.as_deref(),
        mapped,
        &mut guess,
    );
    if let Some(current) = &current {
        let usual = median(current.clone()).unwrap_or(0.0);
        let held = current.iter().filter(|value| **value == usual).count();
        if guess.kind == Kind::Driven && held as f64 > HELD * current.len() as f64 && usual != 0.0 {
            guess.questions.push(format!(
                "the current is {} throughout: is it the current that flowed?",
                short(usual)
            ));
        }
    } else if let Some(question) = command(table) {
        guess.questions.push(question);
    } else if let Some(question) = which_current(table, mapped) {
        guess.questions.push(question);
    } else if guess.kind == Kind::Balance {
        guess.questions.push(
            "a body does not balance without a current: columns = { current = … }".to_owned(),
        );
    } else {
        guess.held_current_a = Some((
            0.0,
            "the file has no current; if the motor was not off, correct it".to_owned(),
        ));
    }
    guess
}

/// What to decide where no name says which column is the current: a driven wheel without one is most unlikely.
fn which_current(table: &Table, mapped: &[Mapped]) -> Option<String> {
    let names = moving(table, mapped);
    names.first()?;
    let names = one_of(&names);
    Some(format!(
        "no column is the current by its name: is it {names} (columns = {{ current = … }}), or was the motor off \
         (constants = {{ current = 0.0 }})?"
    ))
}

/// What to decide where no name says which column is the motion.
fn which_motion(table: &Table, mapped: &[Mapped]) -> Option<String> {
    let names = moving(table, mapped);
    let first = names.first()?;
    Some(format!(
        "no column is an angle, a rate or the wheel's speed by its name: is it {}? columns = {{ angle = {first} }} names it; \
         of a sensor that counts, scale = {{ angle = … }} is its rad per count (2 pi / counts a turn, or pi/180 times degrees \
         a count), and offset what it shows hanging",
        one_of(&names)
    ))
}

/// The columns that change, have no use yet and are no index, in quotation marks.
fn moving(table: &Table, mapped: &[Mapped]) -> Vec<String> {
    let is_free = |index: &usize| {
        let values = &table.columns[*index];
        let changes = range(values).is_some_and(|(low, high)| low < high);
        changes && !is_index(values) && !mapped.iter().any(|one| one.index == *index)
    };
    (0..table.names.len())
        .filter(is_free)
        .map(|index| format!("\"{}\"", table.names[index]))
        .collect()
}

/// "\"a\"", or "one of \"a\", \"b\"".
fn one_of(names: &[String]) -> String {
    match names {
        [one] => one.clone(),
        _ => format!("one of {}", names.join(", ")),
    }
}

/// Parts of names of a motor's command that is no current.
const COMMANDS: [&str; 6] = ["pwm", "duty", "volt", "throttle", "cmd", "command"];

/// What to decide about a column that may be the motor's command without being a current.
fn command(table: &Table) -> Option<String> {
    let is_command = |name: &&String| {
        let lower = name.to_lowercase();
        COMMANDS.iter().any(|part| lower.contains(part))
    };
    let name = table.names.iter().find(is_command)?;
    Some(format!(
        "column \"{name}\" may be the motor's command and is no current: columns = {{ current = \"{name}\" }} with units = \
         {{ current = \"1\" }} takes it as a command without unit (a drive that sets voltage then shows as wheel friction); \
         or state the current that was held, constants = {{ current = … }}"
    ))
}

/// An angle in rad without the jumps of a sensor that starts again after a turn: between two samples the shorter way is
/// taken.
fn unwrapped(angle_rad: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut turns = 0.0;
    let mut before: Option<f64> = None;
    angle_rad
        .map(|angle| {
            if angle.is_finite() {
                let step = before.map_or(0.0, |before| angle - before);
                turns -= (step / (2.0 * PI)).round();
                before = Some(angle);
            }
            angle + 2.0 * PI * turns
        })
        .collect()
}

/// Whether the wheel (speed in rad/s) is locked to a body that moves: a wheel that is free keeps its own motion while
/// the body turns, so that it travels against the body about as far as the body itself.
fn stays_with(angle_rad: &[f64], wheel_speed_rad_s: &[f64], time_s: &[f64]) -> bool {
    let finite = |x: f64| if x.is_finite() { x } else { 0.0 };
    let steps = || {
        1..angle_rad
            .len()
            .min(wheel_speed_rad_s.len())
            .min(time_s.len())
    };
    let of_body: f64 = steps()
        .map(|k| finite(angle_rad[k] - angle_rad[k - 1]).abs())
        .sum();
    let of_wheel: f64 = steps()
        .map(|k| finite(wheel_speed_rad_s[k] * (time_s[k] - time_s[k - 1])).abs())
        .sum();
    of_wheel < LOCKED * of_body && moves(angle_rad)
}

/// Whether the wheel (speed in rad/s) is free on a body that swings. Without a torque between them the wheel keeps its
/// own motion, φ̈ = −α̈: twice differenced over an eighth of a swing, so that a steady speed and its slow decay fall
/// out, the wheel's angle is minus the body's. A motor with the gains of any law that balances turns it far more, and
/// a locked wheel not at all. Upright, a body without current falls and does not swing.
fn is_free(angle_rad: &[f64], wheel_speed_rad_s: &[f64], time_s: &[f64]) -> bool {
    let count = angle_rad
        .len()
        .min(wheel_speed_rad_s.len())
        .min(time_s.len());
    let Some(middle) = median(angle_rad.to_vec()) else {
        return false;
    };
    let crossings = (1..count)
        .filter(|k| (angle_rad[k - 1] < middle) != (angle_rad[*k] < middle))
        .count();
    if crossings < 4 || !moves(angle_rad) {
        return false;
    }
    let mut wheel_angle = vec![0.0; count];
    for k in 1..count {
        let mean = 0.5 * (wheel_speed_rad_s[k] + wheel_speed_rad_s[k - 1]);
        let turn = mean * (time_s[k] - time_s[k - 1]);
        wheel_angle[k] = wheel_angle[k - 1] + if turn.is_finite() { turn } else { 0.0 };
    }
    let step = (count / (4 * crossings)).max(1);
    let second = |x: &[f64], k: usize| x[k + step] - 2.0 * x[k] + x[k - step];
    let rows: Vec<([f64; 2], f64)> = (step..count.saturating_sub(step))
        .map(|k| ([second(angle_rad, k), 1.0], second(&wheel_angle, k)))
        .collect();
    least_squares(&rows, step as f64).is_some_and(|found| {
        (found.coefficients[0] + 1.0).abs() < FREE && found.explained > 1.0 - FREE
    })
}

/// Whether a series moves by more than noise and single lost samples. Between its fifth and ninety-fifth
/// percentiles, noise alone covers 3.3 standard deviations.
fn moves(samples: &[f64]) -> bool {
    let mut finite: Vec<f64> = samples.iter().copied().filter(|x| x.is_finite()).collect();
    finite.sort_by(f64::total_cmp);
    let Some(last) = finite.len().checked_sub(1) else {
        return false;
    };
    let at = |share: f64| finite[(last as f64 * share) as usize];
    let usual = at(0.95) - at(0.05);
    // A constant current has no noise to compare with, but still drives the motor.
    usual > 10.0 * identify::noise_std(samples) || (usual == 0.0 && at(0.5) != 0.0)
}

/// The position of rest of the body: the middle between its turning points, late in the log.
fn rest(angle: &[f64], guess: &mut Guess) {
    let Some((low, high)) = range(angle) else {
        return;
    };
    let late = &angle[angle.len() / 2..];
    let Some((mut lowest, mut highest)) = range(late) else {
        return;
    };
    let mut middle = 0.5 * (lowest + highest);
    // Only whole swings between crossings are used; a part of a swing would shift the mean.
    let crossings: Vec<usize> = (1..late.len())
        .filter(|k| late[k - 1] < middle && late[*k] >= middle)
        .collect();
    if let (Some(first), Some(last)) = (crossings.first(), crossings.last())
        && last > first
    {
        let whole = &late[*first..*last];
        middle = whole.iter().sum::<f64>() / whole.len() as f64;
        (lowest, highest) = range(whole).unwrap_or((lowest, highest));
    }
    // If the swing has ended, the rest position is exact; otherwise it is known to a part of the amplitude.
    let unsure = 0.25 * (highest - lowest);
    if middle.abs() > (REST * 0.5 * (high - low)).max(unsure) {
        guess.offset_rad = Some((
            -middle,
            format!(
                "the body comes to rest at {}, which is hanging: 0",
                short(middle)
            ),
        ));
    }
}

/// Upright or hanging: from the angle, or, if both are counted from 0, from whether the body accelerates away from its
/// middle.
fn upright(
    angle: Option<&[f64]>,
    wheel: Option<&[f64]>,
    current: Option<&[f64]>,
    mapped: &[Mapped],
    guess: &mut Guess,
) {
    guess.kind = Kind::Driven;
    guess.reason = "wheel and body move".to_owned();
    let Some(angle) = angle else {
        guess.questions.push(NO_ANGLE.to_owned());
        return;
    };
    let middle = median(angle.to_vec()).unwrap_or(0.0);
    if (middle.abs() - PI).abs() < ABOUT_UPRIGHT {
        guess.kind = Kind::Balance;
        guess.reason = format!("the angle stays about {}, upright", short(middle));
        return;
    }
    let (Some((low, high)), Some(wheel), Some(_)) = (range(angle), wheel, current) else {
        return;
    };
    let time = mapped.iter().find(|one| one.channel == Channel::Time);
    if high - low > 2.0 * ABOUT_UPRIGHT || middle.abs() > ABOUT_UPRIGHT || time.is_none() {
        guess.reason = format!(
            "the angle goes from {} to {} about hanging",
            short(low),
            short(high)
        );
        return;
    }
    // α̈ = ∓ω² α − ε φ̈: second differences of the angle over a few samples, regressed on angle and wheel acceleration.
    let step = (angle.len() / 400).clamp(1, 8);
    let mut rows = vec![];
    for k in step..angle.len().saturating_sub(step) {
        let second = |x: &[f64]| x[k + step] - 2.0 * x[k] + x[k - step];
        let change = wheel[k + step] - wheel[k - step];
        rows.push(([angle[k] - middle, change, 1.0], second(angle)));
    }
    let found = least_squares(&rows, step as f64);
    match found {
        Some(fit) if fit.coefficients[0] > SHOWS * fit.std[0] => {
            guess.kind = Kind::Balance;
            guess.reason = "the body accelerates away from the middle of its angles and is brought back: it balances".to_owned();
            let reason = format!("the angle is counted from upright, where it must be pi ({} to {})", short(low), short(high));
            guess.offset_rad = Some((PI, reason));
        }
        Some(fit) if fit.coefficients[0] < -SHOWS * fit.std[0] => {
            guess.reason = "wheel and body move, and gravity brings the body back: it hangs".to_owned();
        }
        _ => guess.questions.push(
            "the angle stays about 0: does the body hang there (kind = \"driven\"), or does it balance upright \
             (kind = \"balance\", offset = { angle = 3.14159265 })?"
                .to_owned(),
        ),
    }
}
