//! All code that depends on the sensors of the emitted module. Features of this crate name the sensors; without a
//! feature they are gyroscope, accelerometer and a converter. `esp32c3/link` derives the features from the module.

use generated::{Controller, Sample, wheel_speed};
#[cfg(feature = "wheel-encoder")]
use generated::{constants::WHEEL_ENCODER, encoder::Encoder};
#[cfg(feature = "pivot-encoder")]
use serial_frame::NO_FIELD;

use crate::Reading;

#[cfg(all(feature = "wheel-encoder", feature = "wheel-driver"))]
compile_error!("wheel-encoder and wheel-driver: the module has one sensor of the wheel");

/// The sample of the emitted module.
pub(crate) fn sample(reading: &Reading) -> Sample {
    Sample {
        #[cfg(feature = "pivot-encoder")]
        body_count: reading.body_count, // `Sample` lacks it? Build without pivot-encoder.
        #[cfg(not(feature = "pivot-encoder"))]
        gyro: reading.gyro, // `Sample` lacks it? Build with the feature pivot-encoder.
        #[cfg(not(feature = "pivot-encoder"))]
        accel: reading.accel,
        #[cfg(not(feature = "pivot-encoder"))]
        mag: reading.mag,
        #[cfg(feature = "wheel-encoder")]
        wheel_count: reading.wheel, // `Sample` lacks it? Build without wheel-encoder.
        #[cfg(feature = "wheel-driver")]
        wheel_speed: reading.wheel.cast_signed(), // `Sample` lacks it? Build without wheel-driver.
        #[cfg(not(any(feature = "wheel-encoder", feature = "wheel-driver")))]
        wheel_adc: reading.wheel, // `Sample` lacks it? Build with wheel-encoder or wheel-driver.
    }
}

/// Words of the body's angle from upright and of its rate.
pub(crate) fn body_words(controller: &Controller) -> [i32; 2] {
    #[cfg(feature = "pivot-encoder")]
    let body = controller;
    #[cfg(not(feature = "pivot-encoder"))]
    let body = controller.attitude();
    [body.angle().to_bits(), body.rate().to_bits()]
}

/// The words of a frame in the fields of the gyroscope and of the accelerometer.
pub(crate) fn inertial_words(reading: &Reading) -> [[i16; 3]; 2] {
    #[cfg(feature = "pivot-encoder")]
    {
        let count = reading.body_count.cast_signed();
        [[count, NO_FIELD, NO_FIELD], [NO_FIELD; 3]]
    }
    #[cfg(not(feature = "pivot-encoder"))]
    [reading.gyro, reading.accel]
}

/// The wheel's speed for the frames. The controller does not publish the turns of an encoder, so they are counted here
/// once more.
#[derive(Clone, Debug)]
pub(crate) struct WheelSpeed {
    #[cfg(feature = "wheel-encoder")]
    encoder: Encoder,
    /// Its word.
    word: i32,
}

impl WheelSpeed {
    /// Before the first reading.
    pub(crate) const fn new() -> WheelSpeed {
        WheelSpeed {
            #[cfg(feature = "wheel-encoder")]
            encoder: Encoder::new(),
            word: 0,
        }
    }

    /// Receives a reading; to be called once in each step.
    pub(crate) fn take(&mut self, reading: &Reading) {
        #[cfg(feature = "wheel-encoder")]
        self.encoder.update(reading.wheel, &WHEEL_ENCODER);
        #[cfg(feature = "wheel-encoder")]
        let counts = self.encoder.turned(&WHEEL_ENCODER);
        #[cfg(feature = "wheel-driver")]
        let counts = reading.wheel.cast_signed();
        #[cfg(not(any(feature = "wheel-encoder", feature = "wheel-driver")))]
        let counts = reading.wheel;
        self.word = wheel_speed(counts).to_bits();
    }

    /// The word of the speed by the last reading.
    pub(crate) fn word(&self) -> i32 {
        self.word
    }
}
