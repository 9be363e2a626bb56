//! The words with which the compiled crate is called, and the reader's results for them.
//!
//! For each function, these are random words, ends of ranges, and the numbers in its source with their
//! neighbours. Then follow pairs of arguments that take different branches. The boundary between them is located
//! by halving, and both of its sides become points. A function of one short word is run on every value of the word.
//! Objects are run near upright, as they are used, with odd and even counts, and occasionally with arbitrary counts.

use crate::claims::encoder_exact::second::EncoderWords;
use crate::claims::filter_exact::draw::Draw;
use crate::claims::random::Random;
use crate::claims::upright::Upright;
use crate::compiled::harness::{Call, Harness};
use crate::domains::machine::Machine;
use crate::language::contracts::stated;
use crate::language::module::Module;
use crate::program::steps::Program;

/// One call, with the words that the reader computes for it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Point {
    /// Number of the call in the harness.
    pub call: usize,
    /// Words of the arguments, without those of the object.
    pub arguments: Vec<i128>,
    /// Expected words.
    pub expected: Vec<i128>,
}

/// Largest number of located branch boundaries per function.
const BOUNDARIES: usize = 60;
/// Functions with at most this many different arguments are run on all of them.
const ALL: i128 = 1 << 16;
/// Number of steps in one run of an object; alignment and arming need far fewer.
const RUN: usize = 400;

/// Points for every call; `cases` random ones for each function and as many steps of each object.
pub fn points(module: &Module, harness: &Harness, cases: usize, seed: u64) -> Vec<Point> {
    let mut draw = Draw::new(seed);
    let mut points = Vec::new();
    for (number, call) in harness.calls.iter().enumerate() {
        if let (None, Some(program)) = (call.object, module.program(call.function)) {
            let ranges = ranges(module, call, program);
            of_function(number, program, &ranges, cases, &mut draw, &mut points);
        }
    }
    let mut objects: Vec<usize> = harness
        .calls
        .iter()
        .filter_map(|call| call.object)
        .collect();
    objects.sort_unstable();
    objects.dedup();
    for object in objects {
        let upright = Upright::find(module);
        let wheel = EncoderWords::read(module, "WHEEL_ENCODER");
        let wheel_wrap = wheel.ok().flatten().map(|encoder| encoder.wrap);
        let body = EncoderWords::read(module, "BODY_ENCODER").ok().flatten();
        let zero = module.constant("constants", "BODY_ZERO");
        let zero = zero.and_then(|words| words.first().copied());
        let body = zero.zip(body.map(|encoder| encoder.wrap));
        for run in 0..cases.div_ceil(RUN) {
            let run = Run {
                module,
                harness,
                object,
                upright,
                wheel_wrap,
                body,
                is_near: run % 4 != 3,
            };
            run.points(&mut draw.0, &mut points);
        }
    }
    points
}

/// The ranges of the arguments: the contract, or every word of the types.
fn ranges(module: &Module, call: &Call, program: &Program) -> Vec<(i128, i128)> {
    let contract = stated(module, call.function).unwrap_or_default();
    let types = program.argument_types.iter().enumerate();
    types
        .map(|(word, type_)| {
            let required = contract.requires.iter().filter(|range| range.word == word);
            required.fold(type_.range(), |(low, high), range| {
                (low.max(range.low), high.min(range.high))
            })
        })
        .collect()
}

fn of_function(
    call: usize,
    program: &Program,
    ranges: &[(i128, i128)],
    cases: usize,
    draw: &mut Draw,
    points: &mut Vec<Point>,
) {
    let mut machine = Machine::new(program);
    // Arguments that overflow are outside of the contract, and are left out.
    let mut add = |machine: &mut Machine, arguments: &[i128]| {
        if let Ok(expected) = machine.call(arguments).map(<[i128]>::to_vec) {
            let arguments = arguments.to_vec();
            points.push(Point {
                call,
                arguments,
                expected,
            });
        }
    };
    if let [(low, high)] = ranges
        && high - low < ALL
    {
        (*low..=*high).for_each(|word| add(&mut machine, &[word]));
        return;
    }
    let constants = program.initial.iter().zip(&program.is_constant);
    let corners: Vec<i128> = constants
        .filter_map(|(word, is_constant)| is_constant.then_some(*word))
        .collect();
    let drawn = |draw: &mut Draw| -> Vec<i128> {
        let words = ranges.iter();
        words
            .map(|&(low, high)| draw.at_corners(low, high, &corners))
            .collect()
    };
    for _ in 0..cases {
        let arguments = drawn(draw);
        add(&mut machine, &arguments);
    }
    if ranges.is_empty() {
        return;
    }
    for _ in 0..BOUNDARIES {
        let one = drawn(draw);
        let word = draw.0.choice(ranges.len() as u64) as usize;
        let mut other = one.clone();
        other[word] = drawn(draw)[word];
        for arguments in boundary(&mut machine, one, other, word) {
            add(&mut machine, &arguments);
        }
    }
}

/// The arguments on both sides of a place between `one` and `other`, which differ only in `word`,
/// at which the taken branch changes.
fn boundary(
    machine: &mut Machine,
    mut one: Vec<i128>,
    mut other: Vec<i128>,
    word: usize,
) -> Vec<Vec<i128>> {
    let mut way = |arguments: &[i128]| {
        let result = machine.call(arguments).is_ok();
        result.then(|| machine.path())
    };
    let (Some(first), Some(last)) = (way(&one), way(&other)) else {
        return Vec::new();
    };
    if first == last {
        return Vec::new();
    }
    while (one[word] - other[word]).abs() > 1 {
        let mut middle = one.clone();
        middle[word] = (one[word] + other[word]) >> 1;
        if way(&middle) == Some(first) {
            one = middle;
        } else {
            other = middle;
        }
    }
    vec![one, other]
}

/// A run of one object from its start.
struct Run<'a> {
    module: &'a Module,
    harness: &'a Harness,
    object: usize,
    upright: Option<Upright>,
    /// Where the count of the wheel's encoder begins again at zero.
    wheel_wrap: Option<i128>,
    /// Count upright and wrap of the encoder on the pivot, where there is one.
    body: Option<(i128, i128)>,
    /// Whether the body stays near upright.
    is_near: bool,
}

impl Run<'_> {
    fn points(&self, random: &mut Random, points: &mut Vec<Point>) {
        let mut calls: Vec<(usize, &Call, Machine)> = Vec::new();
        for (number, call) in self.harness.calls.iter().enumerate() {
            if call.object == Some(self.object)
                && let Some(program) = self.module.program(call.function)
            {
                calls.push((number, call, Machine::new(program)));
            }
        }
        let Some((number, _, machine)) = calls.iter_mut().find(|(_, call, _)| call.is_new) else {
            return;
        };
        let Ok(start) = machine.call(&[]).map(<[i128]>::to_vec) else {
            return;
        };
        points.push(Point {
            call: *number,
            arguments: Vec::new(),
            expected: start.clone(),
        });
        let mut state = start;
        let (mut lean, mut rate) = (random.real() * 0.01, 0.0);
        for step in 0..RUN {
            // A slow sway with noise of a few counts, so that odd and even counts occur.
            rate = 0.98 * rate + 0.002 * random.real();
            lean = (lean + rate * 0.1) * 0.999;
            for (number, call, machine) in &mut calls {
                let function = &self.module.declarations().functions[call.function];
                let name = function.name.rsplit("::").next().unwrap_or_default();
                // Disarming is rare, and the state is not read after every step.
                let is_due = match name {
                    "disarm" | "fault" => step % 97 == 96,
                    "arm" => step % 9 == 8,
                    _ => call.shows_object || step % 5 == 0,
                };
                if call.is_new || !is_due {
                    continue;
                }
                let Some(program) = self.module.program(call.function) else {
                    continue;
                };
                let own = state.len();
                let words: Vec<i128> = program.inputs[own..]
                    .iter()
                    .zip(&program.argument_types[own..])
                    .map(|(name, type_)| {
                        let (low, high) = type_.range();
                        self.word(name, lean, random)
                            .unwrap_or_else(|| random.count(high as f64).max(low))
                            .clamp(low, high)
                    })
                    .collect();
                let Ok(result) = machine.call(&[&state[..], &words].concat()) else {
                    continue;
                };
                let expected = result.to_vec();
                if call.shows_object {
                    state = expected[expected.len() - own..].to_vec();
                }
                points.push(Point {
                    call: *number,
                    arguments: words,
                    expected,
                });
            }
        }
    }

    /// The count of a sensor on a body near upright; `None` if any count is suitable.
    fn word(&self, name: &str, lean: f64, random: &mut Random) -> Option<i128> {
        if !self.is_near {
            return None;
        }
        let axis = |index: usize| name.ends_with(&format!("[{index}]"));
        let noise = random.count(4.0);
        if name.contains("body_count") {
            let (zero, wrap) = self.body?;
            let counts = lean / std::f64::consts::TAU * wrap as f64;
            Some((zero + counts.round() as i128 + noise / 3).rem_euclid(wrap))
        } else if name.contains("accel") {
            let upright = self.upright?;
            let index = (0..3).find(|index| axis(*index))?;
            Some(upright.leaning(lean)[index].round() as i128 + noise)
        } else if name.contains("gyro") {
            Some(random.count(40.0))
        } else if name.contains("mag") && !name.ends_with("is_some") {
            Some(random.count(400.0))
        } else if name.contains("adc") {
            // About the converter's middle, where the wheel is slow.
            Some(773 + random.count(300.0))
        } else if name.contains("wheel_speed") && name.starts_with("sample") {
            Some(random.count(300.0))
        } else if name.contains("wheel_count") {
            // A wheel that is slow, on both sides of the wrap.
            Some(random.count(3.0).rem_euclid(self.wheel_wrap.unwrap_or(1)))
        } else {
            None
        }
    }
}
