//! Emitted controllers, from raw counts to the duty, executed from their source.

use crate::interpreted::words_of;
use crate::law::LawFailure;
use checker::program::Program;
use checker::{Machine, Module};

/// The sensors' readings at one instant, in counts: the input of an emitted controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RawSample {
    /// The encoder on the pivot, where there is one; else zero.
    pub body: u16,
    /// Gyroscope.
    pub gyro: [i16; 3],
    /// Accelerometer.
    pub accel: [i16; 3],
    /// Magnetometer, if there is a new reading.
    pub mag: Option<[i16; 3]>,
    /// The wheel's sensor: counts of a converter or an encoder, or the word of the motor's driver.
    pub wheel: i32,
}

/// A word of the sample that a step takes.
#[derive(Clone, Copy, Debug)]
enum SampleWord {
    Body,
    Gyro(usize),
    Accel(usize),
    HasMag,
    Mag(usize),
    Wheel,
}

impl SampleWord {
    /// The word with this name among the inputs of `Controller::step`.
    fn of(name: &str) -> Option<SampleWord> {
        let axis = (0..3).find(|axis| name.ends_with(&format!("[{axis}]")));
        match (name, axis) {
            (name, Some(axis)) if name.contains(".gyro") => Some(SampleWord::Gyro(axis)),
            (name, Some(axis)) if name.contains(".accel") => Some(SampleWord::Accel(axis)),
            (name, Some(axis)) if name.contains(".mag") => Some(SampleWord::Mag(axis)),
            (name, None) if name.contains(".body_count") => Some(SampleWord::Body),
            (name, None) if name.contains(".mag") => Some(SampleWord::HasMag),
            (name, None) if name.contains(".wheel_") => Some(SampleWord::Wheel),
            _ => None,
        }
    }

    fn in_sample(self, sample: &RawSample) -> i128 {
        match self {
            SampleWord::Body => sample.body.into(),
            SampleWord::Gyro(axis) => sample.gyro[axis].into(),
            SampleWord::Accel(axis) => sample.accel[axis].into(),
            SampleWord::HasMag => sample.mag.is_some().into(),
            SampleWord::Mag(axis) => sample.mag.unwrap_or_default()[axis].into(),
            SampleWord::Wheel => sample.wheel.into(),
        }
    }
}

/// An emitted controller: one step from raw counts to the duty.
pub trait RawController {
    /// Returns to the state after power-up: not aligned, not armed.
    fn reset(&mut self);

    /// Allows the controller to drive the motor from the next step on. Returns whether the controller accepts that.
    ///
    /// # Errors
    /// [`LawFailure`] where the controller cannot be run.
    fn arm(&mut self) -> Result<bool, LawFailure>;

    /// Reports a missed tick or a bus error to the controller.
    ///
    /// # Errors
    /// [`LawFailure`] where the controller cannot be run.
    fn fault(&mut self) -> Result<(), LawFailure>;

    /// The status as the emitted `Status` encodes it: 0 not aligned, 1 ready, 2 running, 3 or more
    /// tripped.
    ///
    /// # Errors
    /// [`LawFailure`] where the controller cannot be run.
    fn status(&self) -> Result<u8, LawFailure>;

    /// Executes one step and returns the duty in counts.
    ///
    /// # Errors
    /// [`LawFailure`] where the emitted code would panic.
    fn step(&mut self, sample: &RawSample) -> Result<u16, LawFailure>;

    /// The angle from upright according to the attitude filter or the encoder, rad.
    ///
    /// # Errors
    /// [`LawFailure`] where the emitted code would panic.
    fn angle_rad(&self) -> Result<f64, LawFailure>;
}

/// The controller of any emitted crate, executed bit for bit from its source.
#[derive(Clone, Debug)]
pub struct InterpretedController {
    step: Program,
    /// The words of a sample, in the order in which a step takes them.
    sample: Vec<SampleWord>,
    angle: Program,
    /// For each word from which the angle is computed (a word of the attitude, or of the controller itself): its index
    /// among the words of the controller.
    attitude: Vec<usize>,
    arm: Program,
    fault: Program,
    status: usize,
    angle_unit: f64,
    start: Vec<i128>,
    words: Vec<i128>,
}

impl InterpretedController {
    /// The controller in `module`.
    ///
    /// # Errors
    /// [`LawFailure`] where the crate has no such controller.
    pub fn new(module: &Module) -> Result<Self, LawFailure> {
        let failure = |message: String| LawFailure { message };
        let find = |name: &str| {
            module
                .function(name)
                .ok_or_else(|| failure(format!("the emitted crate has no function `{name}`")))
        };
        let step = find("Controller::step")?.clone();
        let (angle, owner) = match module.function("Attitude::angle") {
            Some(angle) => (angle.clone(), "self.attitude."),
            None => (find("Controller::angle")?.clone(), "self."),
        };
        let place = |name: &str| {
            step.inputs
                .iter()
                .position(|input| input == name)
                .ok_or_else(|| failure(format!("`Controller::step` has no `{name}`")))
        };
        let attitude = angle
            .inputs
            .iter()
            .map(|name| place(&name.replacen("self.", owner, 1)))
            .collect::<Result<Vec<_>, _>>()?;
        let status = place("self.status")?;
        let arm = find("Controller::arm")?.clone();
        let fault = find("Controller::fault")?.clone();
        let start = Machine::new(find("Controller::new")?)
            .call(&[])
            .map_err(|trap| failure(trap.to_string()))?
            .to_vec();
        let bits = match angle.result_types.as_slice() {
            [checker::program::Type::Fixed(bits)] => *bits,
            _ => {
                return Err(failure(
                    "the angle of the emitted crate is no fixed-point word".to_owned(),
                ));
            }
        };
        let sample = step.inputs.iter().skip(start.len()).map(|name| {
            SampleWord::of(name)
                .ok_or_else(|| failure(format!("no sensor of the simulation shows `{name}`")))
        });
        let sample = sample.collect::<Result<Vec<_>, _>>()?;
        Ok(InterpretedController {
            sample,
            angle,
            attitude,
            arm,
            fault,
            status,
            angle_unit: 2.0_f64.powi(-(bits as i32)),
            words: start.clone(),
            start,
            step,
        })
    }
}

impl RawController for InterpretedController {
    fn reset(&mut self) {
        self.words.clone_from(&self.start);
    }

    fn arm(&mut self) -> Result<bool, LawFailure> {
        let results = words_of(&self.arm, &self.words)?;
        let (is_armed, state) = results.split_at(1);
        let is_armed = is_armed[0] == 1;
        self.words = state.to_vec();
        Ok(is_armed)
    }

    fn fault(&mut self) -> Result<(), LawFailure> {
        self.words = words_of(&self.fault, &self.words)?;
        Ok(())
    }

    fn status(&self) -> Result<u8, LawFailure> {
        u8::try_from(self.words[self.status]).map_err(|_| LawFailure {
            message: "the status is no 8-bit word".to_owned(),
        })
    }

    fn step(&mut self, sample: &RawSample) -> Result<u16, LawFailure> {
        let mut arguments = self.words.clone();
        arguments.extend(self.sample.iter().map(|word| word.in_sample(sample)));
        let results = words_of(&self.step, &arguments)?;
        let (duty, state) = results.split_at(1);
        self.words.clear();
        self.words.extend_from_slice(state);
        u16::try_from(duty[0]).map_err(|_| LawFailure {
            message: format!("the duty {} is no 16-bit word", duty[0]),
        })
    }

    fn angle_rad(&self) -> Result<f64, LawFailure> {
        let words: Vec<i128> = self
            .attitude
            .iter()
            .map(|place| self.words[*place])
            .collect();
        let results = words_of(&self.angle, &words)?;
        Ok(results[0] as f64 * self.angle_unit)
    }
}
