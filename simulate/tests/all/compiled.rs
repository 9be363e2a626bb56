//! The committed crate `generated` as the compiler sees it: the library runs emitted code from its source and
//! does not depend on it.

use simulate::{Law, LawFailure, Measured, RawController, RawSample, WordFormats, WordLaw};

/// The emitted fixed-point law of the thesis bench.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CompiledLaw;

impl Law for CompiledLaw {
    fn name(&self) -> &str {
        "emitted law"
    }

    fn command_a(&mut self, measured: &Measured) -> Result<f64, LawFailure> {
        let state = measured.vector();
        if state.iter().any(|value| !value.is_finite()) {
            return Err(LawFailure {
                message: "a measured value is not finite".to_owned(),
            });
        }
        let current = generated::control(
            generated::Angle::saturating_from_num(state[0]),
            generated::Rate::saturating_from_num(state[1]),
            generated::WheelSpeed::saturating_from_num(state[2]),
        );
        Ok(current.to_num::<f64>())
    }
}

/// The words of the compiled law, called through the interface that interpreted laws use.
pub fn word_law() -> impl Law {
    let formats = WordFormats {
        state: [
            generated::Angle::FRAC_NBITS,
            generated::Rate::FRAC_NBITS,
            generated::WheelSpeed::FRAC_NBITS,
        ],
        current: generated::Current::FRAC_NBITS,
    };
    WordLaw::new("words", formats, |[angle, rate, wheel_speed]| {
        Ok(generated::control(
            generated::Angle::from_bits(angle),
            generated::Rate::from_bits(rate),
            generated::WheelSpeed::from_bits(wheel_speed),
        )
        .to_bits())
    })
}

/// The emitted controller of the thesis bench, from raw counts to the duty.
pub struct CompiledController(generated::Controller);

impl CompiledController {
    /// A controller that is not aligned and not armed.
    pub fn new() -> CompiledController {
        CompiledController(generated::Controller::new())
    }
}

impl RawController for CompiledController {
    fn reset(&mut self) {
        *self = CompiledController::new();
    }

    fn arm(&mut self) -> Result<bool, LawFailure> {
        Ok(self.0.arm())
    }

    fn fault(&mut self) -> Result<(), LawFailure> {
        self.0.fault();
        Ok(())
    }

    fn status(&self) -> Result<u8, LawFailure> {
        Ok(self.0.status() as u8)
    }

    fn step(&mut self, sample: &RawSample) -> Result<u16, LawFailure> {
        let sample = generated::Sample {
            gyro: sample.gyro,
            accel: sample.accel,
            mag: sample.mag,
            wheel_adc: u16::try_from(sample.wheel).expect("counts of a converter"),
        };
        Ok(self.0.step(&sample).0)
    }

    fn angle_rad(&self) -> Result<f64, LawFailure> {
        Ok(self.0.attitude().angle().to_num())
    }
}
