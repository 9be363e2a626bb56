//! InvenSense MPU-6050, gyroscope and accelerometer. Register names and values: RM-MPU-6000A-00 rev. 4.2.

use embedded_hal::delay::DelayNs;
use embedded_hal::i2c::I2c;

use crate::Error;
use crate::freshness::Freshness;
use crate::registers::{axes, identify, write_all};

/// With AD0 low.
const ADDRESS: u8 = 0x68;
const SMPLRT_DIV: u8 = 0x19;
const CONFIG: u8 = 0x1a;
const GYRO_CONFIG: u8 = 0x1b;
const ACCEL_CONFIG: u8 = 0x1c;
const INT_ENABLE: u8 = 0x38;
const INT_STATUS: u8 = 0x3a;
const PWR_MGMT_1: u8 = 0x6b;
const WHO_AM_I: u8 = 0x75;
const IDENTITY: u8 = 0x68;
/// The bit DATA_RDY_INT of INT_STATUS; reading the register clears it.
const NEW_READING: u8 = 0x01;
/// Time in ms after a reset during which the part ignores its registers.
const RESET_MS: u32 = 100;

/// The gyroscope at ±2000 °/s and the accelerometer at ±8 g, each 1000 readings a second.
#[derive(Debug)]
pub struct Mpu6050 {
    freshness: Freshness,
}

/// One reading of both.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GyroAndAccel {
    /// Rate x y z, 16.4 counts to the °/s.
    pub gyro: [i16; 3],
    /// Specific force x y z, 4096 counts to the g.
    pub accel: [i16; 3],
}

impl Mpu6050 {
    /// Compares the identity, resets and starts the part.
    ///
    /// # Errors
    /// [`Error::Bus`], [`Error::WrongDevice`].
    pub fn new<B: I2c>(bus: &mut B, delay: &mut impl DelayNs) -> Result<Self, Error<B::Error>> {
        identify(bus, ADDRESS, WHO_AM_I, IDENTITY)?;
        write_all(bus, ADDRESS, &[(PWR_MGMT_1, 0x80)])?;
        delay.delay_ms(RESET_MS);
        let registers = [
            // Awake, on the gyroscope's clock.
            (PWR_MGMT_1, 0x01),
            // Low-pass filter at 188 Hz, which makes the gyroscope's rate 1 kHz.
            (CONFIG, 0x01),
            (SMPLRT_DIV, 0x00),
            // FS_SEL = 3: ±2000 °/s.
            (GYRO_CONFIG, 0x18),
            // AFS_SEL = 2: ±8 g.
            (ACCEL_CONFIG, 0x10),
            // DATA_RDY_EN: INT_STATUS then says whether a reading is new.
            (INT_ENABLE, 0x01),
        ];
        write_all(bus, ADDRESS, &registers)?;
        Ok(Mpu6050 {
            freshness: Freshness::default(),
        })
    }

    /// The latest reading.
    ///
    /// # Errors
    /// [`Error::Bus`], [`Error::Stuck`].
    pub fn read<B: I2c>(&mut self, bus: &mut B) -> Result<GyroAndAccel, Error<B::Error>> {
        let mut bytes = [0; 15];
        bus.write_read(ADDRESS, &[INT_STATUS], &mut bytes)?;
        // The temperature lies between the two.
        let [status, x0, x1, x2, x3, x4, x5, _, _, gyro @ ..] = bytes;
        self.freshness.judge(status & NEW_READING != 0)?;
        Ok(GyroAndAccel {
            gyro: axes(gyro),
            accel: axes([x0, x1, x2, x3, x4, x5]),
        })
    }
}
