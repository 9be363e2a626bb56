//! Claim `encoder-exact` in runs: every difference of two counts, and axes that turn at random, also across the wrap.

use crate::certificate::reader::Certificate;
use crate::claims::encoder_exact::second::{EncoderWords, WORDS};
use crate::claims::encoder_exact::words::encoders;
use crate::claims::functions::{Functions, same};
use crate::claims::random::Random;
use crate::language::module::Module;

/// Number of samples after which an axis starts anew at another place.
const RUN: usize = 300;

/// Runs every encoder of the module.
///
/// # Errors
/// The first count for which source and second statement differ, or from which the turn does not follow.
pub fn run(
    certificate: &Certificate,
    module: &Module,
    cases: usize,
    seed: u64,
) -> Result<usize, String> {
    let f = Functions(module);
    let mut done = 0;
    for (name, ..) in encoders(certificate) {
        let words = EncoderWords::read(module, name)?;
        let words = words.ok_or_else(|| format!("src/constants.rs has no {name}"))?;
        done += every_difference(&f, &words)?;
        done += turning_axes(&f, &words, cases, seed)?;
    }
    Ok(done)
}

/// For every difference of two counts, the turn is the shorter way round.
fn every_difference(f: &Functions, words: &EncoderWords) -> Result<usize, String> {
    let differences = 1 - words.wrap..words.wrap;
    for difference in differences.clone() {
        let arguments = [difference, words.wrap];
        let found = f.call("within_half", &arguments)?;
        same(
            "within_half",
            &arguments,
            &found,
            &[words.short(difference)],
        )?;
    }
    Ok(differences.count())
}

/// Axes that turn by less than half a wrap in a step. The turn over the window is then the difference of the two
/// positions, however often the count wraps between them.
fn turning_axes(
    f: &Functions,
    words: &EncoderWords,
    cases: usize,
    seed: u64,
) -> Result<usize, String> {
    let numbers = [words.wrap, words.window, words.jump];
    let start = f.call("Encoder::new", &[])?;
    same("Encoder::new", &[], &start, &[0; WORDS])?;
    let mut random = Random::new(seed);
    let mut state = start.clone();
    let mut places: Vec<i128> = Vec::new();
    for _ in 0..cases {
        if places.len() == RUN {
            places.clear();
            state.clone_from(&start);
        }
        // Small turns are as frequent as large ones.
        let most = words.wrap / 2 - 1;
        let turn = random.word().clamp(-most, most) >> random.choice(8);
        let place = places.last().map_or(random.word(), |last| last + turn);
        places.push(place);
        let count = place.rem_euclid(words.wrap);
        let (wanted, has_jumped) = words.update(&state, count);
        let arguments = [&state[..], &[count], &numbers].concat();
        let found = f.call("Encoder::update", &arguments)?;
        same("Encoder::update", &arguments, &found, &wanted)?;
        state = found;
        let shown = f.call("Encoder::has_jumped", &state)?;
        same("has_jumped", &state, &shown, &[i128::from(has_jumped)])?;
        same(
            "count",
            &state,
            &f.call("Encoder::count", &state)?,
            &[count],
        )?;
        let turned = f.call("Encoder::turned", &[&state[..], &numbers].concat())?;
        let window = usize::try_from(words.window).unwrap_or(usize::MAX);
        let before = places.len().saturating_sub(window + 1);
        same(
            "Encoder::turned",
            &state,
            &turned,
            &[place - places[before]],
        )?;
    }
    Ok(cases)
}
