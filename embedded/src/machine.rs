//! The bare machine: QEMU's `virt` board, RV32IMC. The only file with `unsafe`: registers and
//! entry have no other form. The crate that is measured forbids it.

use core::arch::{asm, global_asm};

global_asm!(
    ".section .text.start",
    ".global _start",
    "_start:",
    "la sp, _stack",
    "jal main",
    "1: j 1b",
    ".text",
);

/// Transmit register of the serial port.
const SERIAL: *mut u8 = 0x1000_0000 as *mut u8;
/// Register that ends the emulation.
const POWER: *mut u32 = 0x10_0000 as *mut u32;
/// The value that ends it well.
const POWER_OFF: u32 = 0x5555;

/// Instructions retired so far; exact where the emulator counts them (`-icount shift=0`).
#[inline(always)]
pub fn instructions() -> u32 {
    let count: u32;
    // SAFETY: reads a counter. It may touch memory as far as the compiler knows, so that nothing
    // that is measured moves across it.
    unsafe { asm!("csrr {}, minstret", out(reg) count) };
    count
}

/// Writes a text to the serial port.
pub fn print(text: &str) {
    for byte in text.bytes() {
        // SAFETY: the board has this register, and a write is all that it takes.
        unsafe { SERIAL.write_volatile(byte) };
    }
}

/// Writes a number to the serial port.
pub fn print_number(number: u32) {
    if number >= 10 {
        print_number(number / 10);
    }
    // SAFETY: as in `print`.
    unsafe { SERIAL.write_volatile(b'0' + (number % 10) as u8) };
}

/// Ends the emulation.
pub fn power_off() -> ! {
    // SAFETY: the board has this register.
    unsafe { POWER.write_volatile(POWER_OFF) };
    loop {
        core::hint::spin_loop();
    }
}
