//! One step of the firmware.

use crate::fields::{Reader, Writer};
use crate::{Frame, VERSION};

/// Bytes of the message with its CRC.
pub const TELEMETRY_BYTES: usize = 44;

/// The value of a component without a reading. In all components of the magnetometer it means that there is no new
/// reading; in gyroscope and accelerometer, that the bench has no such sensor.
pub const NO_FIELD: i16 = i16::MIN;

/// One step of the firmware: its readings, its state, and the duty that it sent to the drive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Telemetry {
    /// Status of the controller after the step, the emitted module's number.
    pub status: u8,
    /// Number of the step. Steps without a frame count, too; wraps.
    pub sequence: u16,
    /// Time at which the sensors were read, µs; wraps.
    pub time_us: u32,
    /// Gyroscope x y z, raw counts; with an encoder on the pivot its count as its bits, and twice [`NO_FIELD`].
    pub gyro: [i16; 3],
    /// Accelerometer x y z, raw counts.
    pub accel: [i16; 3],
    /// Magnetometer x y z, raw counts, where there is a new reading.
    pub mag: Option<[i16; 3]>,
    /// The wheel's sensor: the converter's counts, an encoder's count, or a driver's speed as its bits.
    pub wheel: u16,
    /// Duty that the step returned, counts.
    pub duty: u16,
    /// Body angle from upright, word of the module's `Angle`.
    pub angle: i32,
    /// Body rate, word of the module's `Rate`.
    pub rate: i32,
    /// Wheel speed, word of the module's `WheelSpeed`.
    pub wheel_speed: i32,
}

impl Telemetry {
    /// The message as a frame. A magnetometer reading of [`NO_FIELD`] in all components, which no part
    /// gives, is sent as none.
    pub fn frame(&self) -> Frame {
        let mut message = Writer::new();
        message.put(&[VERSION, self.status]);
        message.put(&self.sequence.to_le_bytes());
        message.put(&self.time_us.to_le_bytes());
        let mag = self.mag.unwrap_or([NO_FIELD; 3]);
        for axis in [self.gyro, self.accel, mag].as_flattened() {
            message.put(&axis.to_le_bytes());
        }
        message.put(&self.wheel.to_le_bytes());
        message.put(&self.duty.to_le_bytes());
        for word in [self.angle, self.rate, self.wheel_speed] {
            message.put(&word.to_le_bytes());
        }
        Frame::of(message)
    }

    /// Reads a message that was received whole: its length and its CRC are right.
    pub(crate) fn read(bytes: &[u8]) -> Option<Telemetry> {
        if bytes.len() != TELEMETRY_BYTES {
            return None;
        }
        let mut fields = Reader::new(bytes);
        if fields.byte() != VERSION {
            return None;
        }
        Some(Telemetry {
            status: fields.byte(),
            sequence: u16::from_le_bytes(fields.take()),
            time_us: u32::from_le_bytes(fields.take()),
            gyro: fields.axes(),
            accel: fields.axes(),
            mag: Some(fields.axes()).filter(|axes| *axes != [NO_FIELD; 3]),
            wheel: u16::from_le_bytes(fields.take()),
            duty: u16::from_le_bytes(fields.take()),
            angle: i32::from_le_bytes(fields.take()),
            rate: i32::from_le_bytes(fields.take()),
            wheel_speed: i32::from_le_bytes(fields.take()),
        })
    }
}
