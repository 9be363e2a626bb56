//! The firmware on an ESP32-C3: clock, pins and bus; the loop is the crate `loop-core`.
//!
//! | what | pin |
//! |---|---|
//! | I²C data, sensors and converter | GPIO 4 |
//! | I²C clock | GPIO 5 |
//! | duty to the drive | GPIO 6 |
//! | serial line | the chip's USB |
#![no_std]
#![no_main]

mod outbox;

use core::cell::RefCell;
use core::panic::PanicInfo;

#[cfg(not(feature = "pivot-encoder"))]
use bench_sensors::InertialBench;
#[cfg(feature = "pivot-encoder")]
use bench_sensors::PivotBench;
#[cfg(feature = "wheel-driver")]
use bench_sensors::YourWheel as Wheel;
use embedded_hal_bus::i2c::RefCellDevice;
use esp_hal::clock::CpuClock;
#[cfg(not(feature = "pivot-encoder"))]
use esp_hal::delay::Delay;
use esp_hal::gpio::DriveMode;
use esp_hal::i2c::master::{Config as I2cConfig, I2c};
use esp_hal::ledc::channel::{self, ChannelIFace};
use esp_hal::ledc::timer::{self, TimerIFace};
use esp_hal::ledc::{LSGlobalClkSource, Ledc, LowSpeed};
use esp_hal::time::{Instant, Rate};
use esp_hal::usb::usb_serial_jtag::UsbSerialJtag;
use generated::SAMPLE_TIME_US;
use loop_core::LoopCore;
#[cfg(not(any(feature = "wheel-encoder", feature = "wheel-driver")))]
use sensor_drivers::Ads1015 as Wheel;
#[cfg(feature = "wheel-encoder")]
use sensor_drivers::As5600 as Wheel;

use crate::outbox::Outbox;

esp_bootloader_esp_idf::esp_app_desc!();

#[cfg(all(feature = "pivot-encoder", feature = "wheel-encoder"))]
compile_error!(
    "two AS5600 have one address and this chip one bus: another sensor for the wheel, or a part that switches the \
     bus, with its `WheelPart` in firmware/benches/src/wheel.rs"
);

/// Frequency of the duty. The drive's input accepts 10 Hz to 5 kHz; a higher frequency delays the command less.
const DUTY_KHZ: u32 = 4;
/// The sensors' fastest common clock.
const BUS_KHZ: u32 = 400;
/// Time in ms after which a failed part is started again. The controller has tripped by then.
const RETRY_MS: u32 = 500;

#[esp_hal::main]
fn main() -> ! {
    let peripherals = esp_hal::init(esp_hal::Config::default().with_cpu_clock(CpuClock::max()));

    // The drive comes first, with no current: the duty that the emitted module uses for zero current is half of the
    // range.
    let mut ledc = Ledc::new(peripherals.LEDC);
    ledc.set_global_slow_clock(LSGlobalClkSource::APBClk);
    let mut clock = ledc.timer::<LowSpeed>(timer::Number::Timer0);
    let settings = timer::config::Config {
        duty: timer::config::Duty::Duty14Bit,
        clock_source: timer::LSClockSource::APBClk,
        frequency: Rate::from_khz(DUTY_KHZ),
    };
    let clock_runs = clock.configure(settings);
    let mut duty = ledc.channel(channel::Number::Channel0, peripherals.GPIO6);
    let duty_runs = duty.configure(channel::config::Config {
        timer: &clock,
        duty_pct: 50,
        drive_mode: DriveMode::PushPull,
    });

    let bus = I2c::new(
        peripherals.I2C0,
        I2cConfig::default().with_frequency(Rate::from_khz(BUS_KHZ)),
    );
    let mut usb = UsbSerialJtag::new(peripherals.USB_DEVICE);
    // A frequency that the chip cannot make is a mistake in this file. Without duty or bus nothing may run.
    let (Ok(()), Ok(()), Ok(bus)) = (clock_runs, duty_runs, bus) else {
        panic!("frequency of duty or bus out of the chip's range");
    };
    let bus = RefCell::new(bus.with_sda(peripherals.GPIO4).with_scl(peripherals.GPIO5));
    #[cfg(not(feature = "pivot-encoder"))]
    let mut bench = InertialBench::<_, _, Wheel>::new(RefCellDevice::new(&bus), Delay::new());
    #[cfg(feature = "pivot-encoder")]
    let mut bench = PivotBench::<_, Wheel>::new(RefCellDevice::new(&bus));

    let mut core = LoopCore::new();
    let mut outbox = Outbox::new();
    let mut next_us = now_us().wrapping_add(SAMPLE_TIME_US);
    let mut retry_us = now_us();
    loop {
        // Between two ticks the loop serves the serial line, one byte at a time.
        while !has_come(next_us) {
            if let Ok(byte) = usb.read_byte() {
                core.received(byte, now_us());
            }
            if let Some(byte) = outbox.first()
                && usb.write_byte_nb(byte).is_ok()
            {
                outbox.took_first();
                if outbox.first().is_none() {
                    // Bytes that wait in the chip go with the next packet. The loop does not wait for them.
                    let _ = usb.flush_tx_nb();
                }
            }
        }
        let tick = core.tick(now_us(), &mut bench, &mut duty);
        if let Some(frame) = tick.frame {
            outbox.offer(frame.bytes());
        }
        next_us = next_us.wrapping_add(SAMPLE_TIME_US);
        // A missing part is started again while nothing is driven, because that takes longer than a tick.
        if !bench.is_complete() && has_come(retry_us) {
            bench.begin();
            retry_us = now_us().wrapping_add(1000 * RETRY_MS);
        }
        // After any delay the ticks continue from now. The loop notices the delay by its clock.
        if has_come(next_us.wrapping_add(SAMPLE_TIME_US)) {
            next_us = now_us();
        }
    }
}

/// The clock in µs; wraps after 71 minutes.
fn now_us() -> u32 {
    Instant::now().duration_since_epoch().as_micros() as u32
}

/// Whether this time is over. It must lie less than half a period of the clock away.
fn has_come(time_us: u32) -> bool {
    now_us().wrapping_sub(time_us) < u32::MAX / 2
}

/// A bug must not leave the last duty on the pin. The chip restarts, and the pin then has no signal, which the drive
/// does not accept as a set value.
#[panic_handler]
fn begin_anew(_: &PanicInfo) -> ! {
    esp_hal::system::software_reset()
}
