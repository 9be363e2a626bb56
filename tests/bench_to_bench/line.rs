//! The bench at the other end of a pseudo-terminal: pendulum, sensors, firmware, and a line with faults.

use std::io::{Read, Write};
use std::path::Path;
use std::sync::mpsc::{self, Receiver, Sender, TryRecvError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serialport::{SerialPort, TTYPort};
use simulate::{EncoderOutput, RawSensors};

use super::firmware::Firmware;
use super::hand::{Pendulum, Scene, Truth};

/// The module's sample time, µs.
const SAMPLE_TIME_US: u32 = 1_000;
/// The simulation waits when it is this much ahead of the program's last command. A program that the machine delays
/// must not lose its lease.
const AHEAD: u32 = 400;

/// Ticks that the firmware goes on after the plug was pulled: two seconds, twice the lease of a command.
const UNPLUGGED: u32 = 2_000;
/// The duty without a current.
const ZERO_CURRENT: u16 = 32_768;
/// The encoder's count upright.
pub const UPRIGHT_COUNT: u16 = 773;

/// What the line does to frames, shares of them.
#[derive(Clone, Copy, Debug)]
pub struct Faults {
    /// A byte is another one.
    pub damaged: f64,
    /// The frame does not arrive.
    pub lost: f64,
    /// Its second half does not arrive, so that the frame after it is lost too.
    pub cut: f64,
    pub seed: u64,
}

impl Faults {
    pub const NONE: Faults = Faults {
        damaged: 0.0,
        lost: 0.0,
        cut: 0.0,
        seed: 1,
    };
}

/// A bench that runs in a thread of its own until it is dropped.
pub struct SimulatedBench {
    port: String,
    scenes: Option<Sender<Scene>>,
    is_turned: Receiver<()>,
    thread: Option<JoinHandle<()>>,
    /// This end is kept open, so that the line exists between two records.
    _slave: TTYPort,
}

impl SimulatedBench {
    pub fn start(firmware: &Path, truth: &Truth, faults: Faults) -> SimulatedBench {
        let (master, slave) = TTYPort::pair().expect("a pseudo-terminal");
        let port = slave.name().expect("its name");
        let (scenes, new_scenes) = mpsc::channel();
        let (turned, is_turned) = mpsc::channel();
        let mut firmware = Firmware::start(firmware);
        let mut bench = Running {
            master,
            pendulum: Pendulum::new(truth, Scene::Clamped),
            random: ChaCha8Rng::seed_from_u64(faults.seed),
            sensors: sensors(),
            faults,
            now_us: 0,
            since_command: AHEAD,
            duty: ZERO_CURRENT,
            since_unplugged: 0,
        };
        let thread = thread::spawn(move || {
            loop {
                match new_scenes.try_recv() {
                    Ok(scene) => {
                        bench.pendulum = bench.pendulum.next(scene);
                        while bench.pendulum.is_turned() {
                            bench.tick(&mut firmware, &[]);
                        }
                        // Whoever waits for it may be gone.
                        let _ = turned.send(());
                    }
                    Err(TryRecvError::Empty) => {}
                    Err(TryRecvError::Disconnected) => return,
                }
                bench.step(&mut firmware);
            }
        });
        SimulatedBench {
            port,
            scenes: Some(scenes),
            is_turned,
            thread: Some(thread),
            _slave: slave,
        }
    }

    /// The device that the program opens.
    pub fn port(&self) -> String {
        self.port.clone()
    }

    /// Begins a scene, and returns when the body has its first angle.
    pub fn scene(&self, scene: Scene) {
        if let Some(scenes) = &self.scenes {
            scenes.send(scene).expect("the bench runs");
            self.is_turned.recv().expect("the body is turned");
        }
    }
}

impl Drop for SimulatedBench {
    fn drop(&mut self) {
        drop(self.scenes.take());
        if let Some(thread) = self.thread.take() {
            thread.join().expect("the bench ends well");
        }
    }
}

/// The sensors of the thesis at the pivot, calibrated.
fn sensors() -> RawSensors {
    let mut sensors = RawSensors::of_the_thesis().expect("sensors");
    sensors.lever_arm_m = [0.0, 0.0];
    sensors.gyro.bias_counts = Default::default();
    sensors.accel.bias_counts = Default::default();
    // A module without an encoder does not read it.
    sensors.body = Some(EncoderOutput {
        counts_per_turn: 4096.0,
        bits: 12,
        zero_count: f64::from(UPRIGHT_COUNT),
    });
    sensors
}

struct Running {
    master: TTYPort,
    pendulum: Pendulum,
    random: ChaCha8Rng,
    sensors: RawSensors,
    faults: Faults,
    now_us: u32,
    /// Ticks since the last byte from the program.
    since_command: u32,
    duty: u16,
    /// Ticks since the plug was pulled.
    since_unplugged: u32,
}

impl Running {
    fn step(&mut self, firmware: &mut Firmware) {
        let mut bytes = [0; 200];
        let mut came: &[u8] = &[];
        if self.master.bytes_to_read().unwrap_or(0) > 0
            && let Ok(count) = self.master.read(&mut bytes)
        {
            came = &bytes[..count];
            self.since_command = 0;
        }
        if !self.pendulum.is_plugged() {
            self.unplugged(firmware);
            return;
        }
        self.since_unplugged = 0;
        if self.since_command >= AHEAD {
            thread::sleep(Duration::from_millis(1));
            return;
        }
        self.since_command += 1;
        let mut goes = self.tick(firmware, came);
        if self.random.random_bool(self.faults.lost) {
            goes.clear();
        }
        if !goes.is_empty() && self.random.random_bool(self.faults.damaged) {
            let place = self.random.random_range(0..goes.len() - 1);
            // Another byte than it was, and no end.
            goes[place] = match self.random.next_u32() as u8 | 1 {
                same if same == goes[place] => same ^ 2,
                other => other,
            };
        }
        if self.random.random_bool(self.faults.cut) {
            goes.truncate(goes.len() / 2);
        }
        // A line that nobody reads loses what is sent.
        let _ = self.master.write_all(&goes);
    }

    /// A step without a line: whatever came and goes is lost. When the lease of the last command is over, no current flows.
    fn unplugged(&mut self, firmware: &mut Firmware) {
        if self.since_unplugged == UNPLUGGED {
            assert_eq!(self.duty, ZERO_CURRENT, "a motor that nobody asks for");
            thread::sleep(Duration::from_millis(1));
            return;
        }
        self.since_unplugged += 1;
        self.tick(firmware, &[]);
    }

    /// One sample time: the bytes that go to the line.
    fn tick(&mut self, firmware: &mut Firmware, came: &[u8]) -> Vec<u8> {
        let current_a = self.sensors.current_a(self.duty);
        let acceleration = self.pendulum.acceleration_rad_s2(current_a);
        let sample = self
            .sensors
            .sample(&self.pendulum.state, acceleration, &mut self.random);
        let sample = self.pendulum.bus_works().then_some(&sample);
        let (duty, goes) = firmware
            .tick(self.now_us, sample, came)
            .expect("the firmware runs");
        self.duty = duty;
        let current_a = self.sensors.current_a(duty);
        self.pendulum
            .step(current_a, 1e-6 * f64::from(SAMPLE_TIME_US));
        self.now_us = self.now_us.wrapping_add(SAMPLE_TIME_US);
        goes
    }
}
