//! Functions for all drivers: registers of one byte, words of two bytes.

use embedded_hal::i2c::I2c;

use crate::Error;

/// Writes registers one after another.
pub(crate) fn write_all<B: I2c>(
    bus: &mut B,
    address: u8,
    registers: &[(u8, u8)],
) -> Result<(), Error<B::Error>> {
    for (register, value) in registers {
        bus.write(address, &[*register, *value])?;
    }
    Ok(())
}

/// Reads the identity of the part at `address` and compares it.
pub(crate) fn identify<B: I2c>(
    bus: &mut B,
    address: u8,
    register: u8,
    expected: u8,
) -> Result<(), Error<B::Error>> {
    let mut found = [0];
    bus.write_read(address, &[register], &mut found)?;
    if found == [expected] {
        Ok(())
    } else {
        Err(Error::WrongDevice {
            found: u16::from(found[0]),
            expected: u16::from(expected),
        })
    }
}

/// Three words, the high byte first.
pub(crate) fn axes(bytes: [u8; 6]) -> [i16; 3] {
    let [xh, xl, yh, yl, zh, zl] = bytes;
    [
        i16::from_be_bytes([xh, xl]),
        i16::from_be_bytes([yh, yl]),
        i16::from_be_bytes([zh, zl]),
    ]
}
