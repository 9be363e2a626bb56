//! Claim `supervisor` in random runs where an encoder shows the body: sequences of counts with faults are compared word by
//! word with the second implementation, and each condition alone must end the current within its number of steps.

use crate::claims::functions::{Functions, same};
use crate::claims::random::Random;
use crate::claims::supervisor::body::{
    BodySample, BodySupervisor, CURRENT, FROZEN_BACK, SATURATED, STILL, WHEEL,
};
use crate::claims::supervisor::runs::WheelReadings;
use crate::claims::supervisor::second::{
    RUNNING, TRIPPED_ANGLE, TRIPPED_CURRENT, TRIPPED_FAULT, TRIPPED_FROZEN, TRIPPED_WHEEL_SPEED,
};
use crate::language::module::Module;

/// Runs `cases` samples, and every count.
///
/// # Errors
/// The first sample for which source and second statement differ, or after which a current flows where none may.
pub(crate) fn run(module: &Module, cases: usize, seed: u64) -> Result<usize, String> {
    let f = Functions(module);
    let second = BodySupervisor::read(module)?;
    every_count(&f, &second)?;
    let zero = f.constant("constants", "ZERO_CURRENT")?[0];
    let (low, high) = (second.limit("wheel_low")?, second.limit("wheel_high")?);
    let still = second.limit("still_steps")?;
    let mut random = Random::new(seed);
    let status = second.status();
    let mut words = f.call_for_words("Controller::new", &[], second.words())?;
    same(
        "Controller::default",
        &[],
        &f.call("Controller::default", &[])?,
        &words,
    )?;
    let mut wheel = WheelReadings::of(module, low, high)?;
    let (mut done, mut armed) = (0, 0);
    // Where the body is, in counts from upright.
    let mut place = 0;
    while done < cases {
        let roll = random.choice(8);
        if roll == 0 {
            place = random.count(second.body.wrap as f64 / 2.0);
        } else if roll < 4 {
            place = random.count(20.0);
        }
        let (is_fixed, is_stuck) = (roll == 1 || roll == 5, roll == 2);
        let sway = if roll == 3 { 12.0 } else { 1.0 };
        // Sometimes long enough to be at rest for the stated time.
        let most = if random.choice(6) == 0 {
            2 * still as u64 + 40
        } else {
            60
        };
        let length = 1 + random.choice(most) as usize;
        let asks = random.choice(3) == 0;
        for _ in 0..length.min(cases - done) {
            if !is_fixed {
                place += random.count(sway);
            }
            let wrong = if random.choice(300) == 0 {
                second.body.wrap / 3
            } else {
                0
            };
            let any = random.choice(500) == 0;
            let body = match any {
                true => random.choice(1 << 16) as i128,
                false => (second.zero + place + wrong).rem_euclid(second.body.wrap),
            };
            let sample = BodySample {
                body,
                wheel: wheel.next(&mut random, is_stuck),
            };
            let current = (asks || random.choice(16) == 0).then(|| random.word());
            let (duty, wanted) = second.step(&words, &sample, current)?;
            let mut arguments = [&words[..], &[sample.body, sample.wheel]].concat();
            let name = match current {
                Some(current) => {
                    arguments.push(current);
                    "Controller::step_with_current"
                }
                None => "Controller::step",
            };
            let found = f.call(name, &arguments)?;
            same(name, &arguments, &found, &[&[duty], &wanted[..]].concat())?;
            if wanted[status] != RUNNING && duty != zero {
                return Err(format!("{name}: duty {duty} while it does not run"));
            }
            words = wanted;
            done += 1;
        }
        methods(&f, &second, &words)?;
        let (may, next) = second.armed(&words)?;
        armed += usize::from(may);
        words = match random.choice(12) {
            0 => second.tripped(&words, TRIPPED_FAULT),
            _ if may => next,
            // The state of a body that stood at rest, which random runs rarely reach.
            1..=6 => {
                let mut at_rest = words.clone();
                at_rest[status + STILL] = still;
                at_rest
            }
            _ => words,
        };
    }
    if cases >= 5000 && armed == 0 {
        return Err("in none of the runs the controller was armed".to_owned());
    }
    each_condition(&f, &second, zero)?;
    Ok(done)
}

/// Every count of the encoder gives the angle of the shorter way round, and every turn over the window its rate.
fn every_count(f: &Functions, second: &BodySupervisor) -> Result<(), String> {
    for count in -1..=second.body.wrap {
        let wanted = second.angle_of(count);
        same(
            "body_angle",
            &[count],
            &f.call("body_angle", &[count])?,
            &[wanted],
        )?;
    }
    let most = second.body.wrap / 2 * second.body.window;
    let step = (most / 4096).max(1) as usize;
    for turned in (-most..=most).step_by(step) {
        let wanted = second.rate_of(turned);
        same(
            "body_rate",
            &[turned],
            &f.call("body_rate", &[turned])?,
            &[wanted],
        )?;
    }
    Ok(())
}

/// The methods that take no sample.
fn methods(f: &Functions, second: &BodySupervisor, words: &[i128]) -> Result<(), String> {
    let status = second.status();
    let call = |name: &str| f.call(name, words);
    let angle = second.angle_of(words[1]);
    let turns: i128 = words[3..].iter().take(second.body.window as usize).sum();
    same(
        "Controller::status",
        words,
        &call("Controller::status")?,
        &words[status..=status],
    )?;
    same(
        "Controller::angle",
        words,
        &call("Controller::angle")?,
        &[angle],
    )?;
    same(
        "Controller::rate",
        words,
        &call("Controller::rate")?,
        &[second.rate_of(turns)],
    )?;
    let (may, next) = second.armed(words)?;
    let armed = [&[i128::from(may)], &next[..]].concat();
    same("arm", words, &call("Controller::arm")?, &armed)?;
    let mut wanted = words.to_vec();
    if wanted[status] == RUNNING {
        wanted[status] = 1;
    }
    same("disarm", words, &call("Controller::disarm")?, &wanted)?;
    let wanted = second.tripped(words, TRIPPED_FAULT);
    same("fault", words, &call("Controller::fault")?, &wanted)
}

/// Tests each condition alone, starting from a controller that runs upright: no current flows after the stated number
/// of steps.
fn each_condition(f: &Functions, second: &BodySupervisor, zero: i128) -> Result<(), String> {
    let status = second.status();
    let (low, high) = (second.limit("wheel_low")?, second.limit("wheel_high")?);
    let middle = (low + high) / 2;
    let mut start = f.call_for_words("Controller::new", &[], second.words())?;
    start[0] = 2;
    start[1] = second.zero;
    start[status] = RUNNING;
    let all = second.current_limit;
    let wrap = second.body.wrap;
    let far = wrap / 2;
    // The count at a step, the wheel's reading at that step, the current, and the word in which the first count starts.
    type At = fn(i128) -> i128;
    let standing: At = |_| 0;
    let swaying: At = |step| step % 2;
    let conditions: [(&str, i128, At, i128, usize, i128); 4] = [
        ("frozen_steps", TRIPPED_FROZEN, standing, all, CURRENT, all),
        (
            "frozen_steps",
            TRIPPED_FROZEN,
            standing,
            -all,
            CURRENT,
            -all,
        ),
        (
            "saturated_steps",
            TRIPPED_CURRENT,
            swaying,
            all,
            SATURATED,
            second.limit("saturated_steps")? - 3,
        ),
        (
            "wheel_steps",
            TRIPPED_WHEEL_SPEED,
            swaying,
            0,
            WHEEL,
            second.limit("wheel_steps")? - 3,
        ),
    ];
    for (limit, why, at, current, word, from) in conditions {
        let mut words = start.clone();
        words[status + word] = from
            .max(0)
            .min(if word == CURRENT { all } else { i128::MAX });
        if word == CURRENT {
            words[status + CURRENT] = from;
            words[status + FROZEN_BACK] = 0;
        }
        let is_wheel = limit == "wheel_steps";
        let mut count = 0;
        if let (Some(encoder), true) = (&second.wheel, is_wheel) {
            // The wheel turns at the end of its range and goes on turning.
            words[19..status].copy_from_slice(&encoder.turning(-low / encoder.window + 1));
        }
        let steps = second.limit(limit)? + 1;
        let mut ended = None;
        for step in 1..=steps {
            let wheel = match (&second.wheel, is_wheel) {
                (Some(encoder), true) => {
                    count = (count - low / encoder.window + 1).rem_euclid(encoder.wrap);
                    count
                }
                (Some(_), false) => 0,
                (None, true) => low,
                (None, false) => middle,
            };
            let body = (second.zero + at(step)).rem_euclid(wrap);
            let arguments = [&words[..], &[body, wheel, current]].concat();
            let length = 1 + second.words();
            let found = f.call_for_words("Controller::step_with_current", &arguments, length)?;
            words.copy_from_slice(&found[1..]);
            if words[status] != RUNNING {
                ended = Some((words[status], found[0]));
                break;
            }
        }
        if ended != Some((why, zero)) {
            return Err(format!(
                "{limit}: after {steps} steps the controller is {ended:?}, not {:?}",
                (why, zero)
            ));
        }
    }
    // Two conditions end the current at once: a body beyond its largest angle, and a count that no motion can cause.
    for (why, before) in [(TRIPPED_ANGLE, far), (TRIPPED_FAULT, 0)] {
        let mut words = start.clone();
        words[1] = (second.zero + before).rem_euclid(wrap);
        let wheel = if second.wheel.is_some() { 0 } else { middle };
        let arguments = [&words[..], &[(second.zero + far).rem_euclid(wrap), wheel]].concat();
        let found = f.call_for_words("Controller::step", &arguments, 1 + second.words())?;
        if (found[1 + status], found[0]) != (why, zero) {
            return Err(format!(
                "a count half a wrap away leads to the status {}, not {why}",
                found[1 + status]
            ));
        }
    }
    Ok(())
}
