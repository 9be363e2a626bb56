//! The readings of the sensors, and their conversion to a sample of the emitted module. For a bench with other sensors
//! (encoders, a drive that tells the speed) this file is the one to change.

use generated::Sample;

/// Raw counts of one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reading {
    /// Gyroscope x y z.
    pub gyro: [i16; 3],
    /// Accelerometer x y z.
    pub accel: [i16; 3],
    /// Magnetometer x y z, where there is a new reading.
    pub mag: Option<[i16; 3]>,
    /// The wheel's sensor: counts of a converter, of an encoder, or a signed speed as its bits.
    pub wheel: u16,
}

impl Reading {
    /// Before the first reading.
    pub const NONE: Reading = Reading {
        gyro: [0; 3],
        accel: [0; 3],
        mag: None,
        wheel: 0,
    };

    /// The sample of a module for inertial sensors and a converter.
    pub(crate) fn sample(&self) -> Sample {
        Sample {
            gyro: self.gyro,
            accel: self.accel,
            mag: self.mag,
            wheel_adc: self.wheel,
        }
    }
}

/// The sensors of a board.
pub trait Sensors {
    /// Why there is no reading.
    type Error;

    /// The latest reading of all sensors.
    ///
    /// # Errors
    /// A sensor that failed; the controller is told of a fault.
    fn read(&mut self) -> Result<Reading, Self::Error>;
}
