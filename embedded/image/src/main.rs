//! The emitted module's entries under fixed names, for the static analysis of the linked image.
#![no_std]
#![no_main]

use core::panic::PanicInfo;

use generated::{Angle, Attitude, Controller, Rate, Sample, WheelSpeed, control};

/// One step of the whole controller.
#[unsafe(no_mangle)]
pub extern "C" fn step(controller: &mut Controller, sample: &Sample) -> u16 {
    controller.step(sample).0
}

/// The law alone.
#[unsafe(no_mangle)]
pub extern "C" fn law(angle: i32, rate: i32, wheel_speed: i32) -> i32 {
    control(
        Angle::from_bits(angle),
        Rate::from_bits(rate),
        WheelSpeed::from_bits(wheel_speed),
    )
    .to_bits()
}

/// The filter's step on six axes with its angle.
#[unsafe(no_mangle)]
pub extern "C" fn six_axes(attitude: &mut Attitude, sample: &Sample) -> i32 {
    attitude.update_imu(sample.gyro, sample.accel);
    attitude.angle().to_bits()
}

/// The filter's step on nine axes with its angle.
#[unsafe(no_mangle)]
pub extern "C" fn nine_axes(attitude: &mut Attitude, sample: &Sample) -> i32 {
    attitude.update_marg(sample.gyro, sample.accel, sample.mag.unwrap_or_default());
    attitude.angle().to_bits()
}

/// Size of the controller's state in bytes. The analysis reads it from the image's symbol table.
#[unsafe(no_mangle)]
pub static STATE_BYTES: [u8; size_of::<Controller>()] = [0; size_of::<Controller>()];

/// Nothing in the module panics. If this handler is in the image, `../count` fails.
#[panic_handler]
fn never(_: &PanicInfo) -> ! {
    loop {}
}
