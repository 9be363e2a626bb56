//! The readings of the sensors.

/// Raw counts of one instant. A bench fills in the readings of its sensors; `shape.rs` selects those that the emitted
/// module needs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reading {
    /// Gyroscope x y z.
    pub gyro: [i16; 3],
    /// Accelerometer x y z.
    pub accel: [i16; 3],
    /// Magnetometer x y z, where there is a new reading.
    pub mag: Option<[i16; 3]>,
    /// The count of an encoder on the pivot.
    pub body_count: u16,
    /// The wheel's sensor: counts of a converter, of an encoder, or a signed speed as its bits.
    pub wheel: u16,
}

impl Reading {
    /// Before the first reading.
    pub const NONE: Reading = Reading {
        gyro: [0; 3],
        accel: [0; 3],
        mag: None,
        body_count: 0,
        wheel: 0,
    };
}

/// The sensors of a board.
pub trait Sensors {
    /// The reason why there is no reading.
    type Error;

    /// The latest reading of all sensors.
    ///
    /// # Errors
    /// If a sensor has failed; the controller then receives a fault.
    fn read(&mut self) -> Result<Reading, Self::Error>;
}
