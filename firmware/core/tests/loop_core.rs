//! The loop with sensors that are right, late, wrong or silent. `other-sensors` beside this file runs the same tests
//! around modules for other sensors.

use std::convert::Infallible;

use embedded_hal::pwm::{Error, ErrorKind, ErrorType, SetDutyCycle};
use generated::constants::LIMITS;
use generated::{Angle, SAMPLE_TIME_US, Status, ZERO_CURRENT};
use loop_core::{Fault, LoopCore, Reading, Sensors};
use serial_frame::{Command, Frame, NO_FIELD, Receiver, Task, Telemetry};

/// A body that stands upright, with a count of noise on the gyroscope or on the encoder of the pivot.
#[derive(Default)]
struct Upright {
    step: u32,
    fails: bool,
    is_frozen: bool,
}

impl Sensors for Upright {
    type Error = ();

    fn read(&mut self) -> Result<Reading, ()> {
        if self.fails {
            return Err(());
        }
        if !self.is_frozen {
            self.step += 1;
        }
        Ok(Reading {
            gyro: [(self.step % 2) as i16, 0, 0],
            accel: UP,
            mag: None,
            body_count: UPRIGHT + (self.step % 2) as u16,
            wheel: WHEEL_AT_REST,
        })
    }
}

/// The accelerometer's reading on the thesis bench upright, counts: 1 g along the body's x.
const UP: [i16; 3] = [4096, 0, 0];
/// `zero` of the benches with an encoder on the pivot.
const UPRIGHT: u16 = 773;
/// The count of a wheel at rest: 6594.5/8.53108 on the converter of the thesis, any constant count of an encoder.
#[cfg(not(feature = "wheel-driver"))]
const WHEEL_AT_REST: u16 = 773;
#[cfg(feature = "wheel-driver")]
const WHEEL_AT_REST: u16 = 0;

const HAS_PIVOT: bool = cfg!(feature = "pivot-encoder");

#[derive(Default)]
struct Timer {
    duty: u16,
    fails: bool,
}

#[derive(Debug)]
struct Broken;

impl Error for Broken {
    fn kind(&self) -> ErrorKind {
        ErrorKind::Other
    }
}

impl ErrorType for Timer {
    type Error = Broken;
}

impl SetDutyCycle for Timer {
    fn max_duty_cycle(&self) -> u16 {
        u16::MAX
    }

    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Broken> {
        self.duty = duty;
        if self.fails { Err(Broken) } else { Ok(()) }
    }
}

/// A bench with its clock.
#[derive(Default)]
struct Bench {
    core: LoopCore,
    sensors: Upright,
    timer: Timer,
    now_us: u32,
    wish: u8,
    sent: Vec<Telemetry>,
    faults: Vec<Fault>,
}

impl Bench {
    fn run(&mut self, steps: u32) {
        for _ in 0..steps {
            self.now_us = self.now_us.wrapping_add(SAMPLE_TIME_US);
            self.tick();
        }
    }

    fn tick(&mut self) {
        let tick = self
            .core
            .tick(self.now_us, &mut self.sensors, &mut self.timer);
        self.faults.extend(tick.fault);
        self.sent.extend(tick.frame.map(|frame| read(&frame)));
    }

    fn order(&mut self, task: Task, lease_ms: u16) {
        let command = Command {
            task,
            wish: self.wish,
            every: 1,
            lease_ms,
        };
        for byte in command.frame().bytes() {
            self.core.received(*byte, self.now_us);
        }
    }

    fn new_order(&mut self, task: Task) {
        self.wish += 1;
        self.order(task, 60_000);
    }

    /// A bench whose controller has found its attitude and drives the motor.
    fn driven() -> Bench {
        let mut bench = Bench::default();
        bench.new_order(Task::Watch);
        bench.run(600);
        assert_eq!(bench.core.status(), Status::Ready);
        bench.new_order(Task::Drive {
            current_ua: 200_000,
        });
        bench.run(2);
        assert_eq!(bench.core.status(), Status::Running);
        assert!(bench.timer.duty > ZERO_CURRENT);
        bench
    }

    fn assert_still(&self) {
        assert_eq!(self.timer.duty, ZERO_CURRENT);
    }
}

fn read(frame: &Frame) -> Telemetry {
    let mut receiver = Receiver::new();
    let got = frame
        .bytes()
        .iter()
        .filter_map(|byte| receiver.telemetry(*byte));
    got.last().expect("a message").expect("a whole one")
}

#[test]
fn nothing_is_driven_without_an_order() {
    let mut bench = Bench::default();
    bench.run(2_000);
    assert_eq!(bench.core.status(), Status::Ready);
    assert!(bench.sent.iter().all(|frame| frame.duty == ZERO_CURRENT));
    assert_eq!(bench.faults, []);
}

#[test]
fn the_current_that_is_asked_for_is_the_duty_of_the_drive() {
    let mut bench = Bench::driven();
    // 0.2 A over the thesis' 2.2 A in 26 214 counts; rounded once in the word and once in the duty.
    let counts = 0.2 / 2.2 * 26_214.0;
    assert!((f64::from(bench.timer.duty) - 32_768.0 - counts).abs() < 1.0);
    bench.order(
        Task::Drive {
            current_ua: -200_000,
        },
        60_000,
    );
    bench.run(1);
    assert!((f64::from(bench.timer.duty) - 32_768.0 + counts).abs() < 1.0);
    // Beyond the limit of 2 A: the limit.
    bench.order(
        Task::Drive {
            current_ua: i32::MAX,
        },
        60_000,
    );
    bench.run(1);
    let limit = 2.0 / 2.2 * 26_214.0;
    assert!((f64::from(bench.timer.duty) - 32_768.0 - limit).abs() < 1.0);
}

#[test]
fn a_silent_line_disarms_and_the_old_order_does_not_arm_again() {
    let mut bench = Bench::driven();
    bench.order(
        Task::Drive {
            current_ua: 200_000,
        },
        100,
    );
    bench.run(100);
    assert_eq!(bench.core.status(), Status::Running);
    bench.run(2);
    assert_eq!(bench.core.status(), Status::Ready);
    bench.assert_still();
    // The line is back with the order that has run out.
    bench.order(
        Task::Drive {
            current_ua: 200_000,
        },
        1000,
    );
    bench.run(10);
    bench.assert_still();
    bench.new_order(Task::Drive {
        current_ua: 200_000,
    });
    bench.run(2);
    assert_eq!(bench.core.status(), Status::Running);
}

/// The supply drops while the motor is driven: the board starts anew, and the program, which has noticed nothing, repeats
/// its order. The body is held upright, so that the controller could be armed.
#[test]
fn a_start_in_the_middle_of_an_order_does_not_arm() {
    for task in [
        Task::Balance,
        Task::Drive {
            current_ua: 200_000,
        },
    ] {
        let mut bench = Bench::driven();
        bench.new_order(task);
        bench.run(100);
        assert_eq!(bench.core.status(), Status::Running);
        bench.core = LoopCore::new();
        bench.sent.clear();
        for _ in 0..30 {
            bench.order(task, 1000);
            bench.run(100);
        }
        assert_eq!(bench.core.status(), Status::Ready);
        assert!(bench.sent.iter().all(|frame| frame.duty == ZERO_CURRENT));
        // Somebody asks anew.
        bench.new_order(task);
        bench.run(2);
        assert_eq!(bench.core.status(), Status::Running);
    }
    // Whichever number the order has: also that of a start, at which nothing was heard yet.
    let mut bench = Bench::default();
    bench.run(600);
    bench.order(Task::Balance, 60_000);
    bench.run(10);
    assert_eq!(bench.wish, 0);
    assert_eq!(bench.core.status(), Status::Ready);
}

/// A sensor's plug comes off while the controller balances: no current from the very step on, and none when it is back,
/// though the order is repeated all the time.
#[test]
fn a_sensor_that_is_unplugged_while_it_balances_trips_at_once() {
    let mut bench = Bench::driven();
    bench.new_order(Task::Balance);
    bench.run(500);
    assert_eq!(bench.core.status(), Status::Running);
    bench.sent.clear();
    for (fails, steps) in [(true, 1), (true, 300), (false, 1_500)] {
        bench.sensors.fails = fails;
        bench.order(Task::Balance, 60_000);
        bench.run(steps);
        assert_eq!(bench.core.status(), Status::TrippedFault);
    }
    assert!(bench.sent.iter().all(|frame| frame.duty == ZERO_CURRENT));
    assert_eq!(bench.faults.len(), 301);
}

#[test]
fn a_late_tick_trips() {
    let mut bench = Bench::driven();
    bench.now_us += SAMPLE_TIME_US + SAMPLE_TIME_US / 2;
    bench.tick();
    assert_eq!(bench.faults, [], "half a sample time is borne");
    bench.now_us += 2 * SAMPLE_TIME_US;
    bench.tick();
    assert_eq!(bench.faults, [Fault::Late]);
    assert_eq!(bench.core.status(), Status::TrippedFault);
    bench.assert_still();
}

#[test]
fn the_clock_may_wrap() {
    let mut bench = Bench {
        now_us: u32::MAX - 300 * SAMPLE_TIME_US,
        ..Bench::default()
    };
    bench.run(600);
    assert_eq!(bench.faults, []);
    assert_eq!(bench.core.status(), Status::Ready);
}

#[test]
fn a_sensor_that_fails_trips_until_a_new_order_and_the_attitude_is_found_anew() {
    let mut bench = Bench::driven();
    bench.sensors.fails = true;
    bench.run(1);
    assert_eq!(bench.faults, [Fault::Sensor]);
    assert_eq!(bench.core.status(), Status::TrippedFault);
    bench.assert_still();
    bench.sensors.fails = false;
    bench.order(
        Task::Drive {
            current_ua: 200_000,
        },
        60_000,
    );
    bench.run(2_000);
    assert_eq!(bench.core.status(), Status::TrippedFault);
    bench.assert_still();
    bench.new_order(Task::Drive {
        current_ua: 200_000,
    });
    bench.run(1);
    assert_eq!(bench.core.status(), Status::NotAligned);
    bench.run(600);
    assert_eq!(bench.core.status(), Status::Running);
}

/// A gyroscope without noise; a count of the pivot that stands still under a current which moves the body: a bus or an
/// AS5600 that gives the same word for ever.
#[test]
fn a_frozen_sensor_of_the_body_trips() {
    let mut bench = Bench::driven();
    bench.sensors.is_frozen = true;
    // The current exceeds the current against gravity by more than half of the limit, which moves a body that is free.
    let task = Task::Drive {
        current_ua: 1_500_000,
    };
    bench.order(task, 60_000);
    bench.run(LIMITS.frozen_steps.unsigned_abs() - 2);
    assert_eq!(bench.core.status(), Status::Running);
    bench.run(4);
    assert_eq!(bench.core.status(), Status::TrippedFrozen);
    bench.assert_still();
}

#[test]
fn a_timer_that_fails_trips() {
    let mut bench = Bench::driven();
    bench.timer.fails = true;
    bench.run(1);
    assert_eq!(bench.faults, [Fault::Timer]);
    bench.timer.fails = false;
    bench.run(1);
    assert_eq!(bench.core.status(), Status::TrippedFault);
    bench.assert_still();
}

#[test]
fn every_step_has_its_number_and_its_words() {
    let mut bench = Bench::driven();
    assert!(
        bench
            .sent
            .windows(2)
            .all(|two| two[1].sequence == two[0].sequence.wrapping_add(1))
    );
    assert!(
        bench
            .sent
            .windows(2)
            .all(|two| two[1].time_us - two[0].time_us == SAMPLE_TIME_US)
    );
    let last = bench.sent.last().expect("frames");
    assert_eq!(last.status, Status::Running as u8);
    assert_eq!(last.accel, if HAS_PIVOT { [NO_FIELD; 3] } else { UP });
    assert_eq!(last.duty, bench.timer.duty);
    // Upright and at rest: below 1 mrad, or within the encoder's count of noise.
    let angle_rad = f64::from(last.angle) / f64::from(1 << Angle::FRAC_NBITS);
    let count_rad = std::f64::consts::TAU / 4096.0;
    let off_rad = if HAS_PIVOT { 1.01 * count_rad } else { 1e-3 };
    assert!(angle_rad.abs() < off_rad, "{angle_rad}");
    if HAS_PIVOT {
        let count = last.gyro[0].cast_unsigned();
        assert!((UPRIGHT..=UPRIGHT + 1).contains(&count), "{count}");
        let counted_rad = f64::from(count - UPRIGHT) * count_rad;
        assert!((angle_rad - counted_rad).abs() < 1e-6, "{angle_rad}");
    }
    // From now on, a telemetry frame every five steps.
    let before = bench.sent.len();
    let command = Command {
        task: Task::Watch,
        wish: bench.wish,
        every: 5,
        lease_ms: 0,
    };
    for byte in command.frame().bytes() {
        bench.core.received(*byte, bench.now_us);
    }
    bench.run(100);
    assert_eq!(bench.sent.len() - before, 20);
}

#[test]
fn noise_on_the_line_is_no_order() {
    let mut bench = Bench::default();
    bench.run(600);
    // Marsaglia's xorshift, so that the bytes are the same each time.
    let mut word = 0x1234_5678_u32;
    for step in 0..100_000_u32 {
        word ^= word << 13;
        word ^= word >> 17;
        word ^= word << 5;
        bench.core.received(word as u8, bench.now_us);
        if step % 100 == 0 {
            bench.run(1);
        }
    }
    assert_eq!(bench.core.status(), Status::Ready);
    bench.assert_still();
}

/// Timers of other ranges than the 16 bits of the module: 14 bits, as the LEDC of the ESP32-C3 has them at 5 kHz, an Uno's
/// 8, and one whose range is no power of two. The share at zero current is a half, and that of a current within a count of
/// the timer.
#[test]
fn another_timer_gets_the_same_share() {
    struct Coarse {
        most: u16,
        duty: u16,
    }
    impl ErrorType for Coarse {
        type Error = Infallible;
    }
    impl SetDutyCycle for Coarse {
        fn max_duty_cycle(&self) -> u16 {
            self.most
        }
        fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Infallible> {
            self.duty = duty;
            Ok(())
        }
    }
    for most in [255, 1_023, 4_095, 9_999, 16_383, u16::MAX] {
        let mut bench = Bench::driven();
        let share = f64::from(bench.timer.duty) / 65_536.0;
        let mut timer = Coarse { most, duty: 0 };
        bench.now_us += SAMPLE_TIME_US;
        bench
            .core
            .tick(bench.now_us, &mut bench.sensors, &mut timer);
        let wanted = share * (f64::from(most) + 1.0);
        let off = wanted - f64::from(timer.duty);
        assert!((0.0..1.0).contains(&off), "{most}: {off}");
        let (mut core, mut timer) = (LoopCore::new(), Coarse { most, duty: 0 });
        core.tick(0, &mut Upright::default(), &mut timer);
        assert_eq!(u32::from(timer.duty), u32::from(most).div_ceil(2), "{most}");
    }
}
