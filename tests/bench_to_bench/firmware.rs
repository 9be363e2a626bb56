//! The firmware's loop as a program of the host, compiled with an emitted module.

use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use simulate::RawSample;

/// Compiles `firmware/on-host` with the crate in `module` and the features of its sensors; `name` keeps two of them apart.
pub fn compiled(module: &Path, name: &str, features: &str) -> PathBuf {
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR")).join("firmware/Cargo.toml");
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("firmware");
    let built = target.join("debug/on-host");
    let kept = target.join(format!("on-host-{name}-{}", std::process::id()));
    // Tests of one process run side by side: one compiles at a time, and keeps what it has compiled.
    static ONE: std::sync::Mutex<()> = std::sync::Mutex::new(());
    let _one = ONE
        .lock()
        .unwrap_or_else(std::sync::PoisonError::into_inner);
    let output = Command::new(env!("CARGO"))
        .args([
            "build",
            "--quiet",
            "--package",
            "on-host",
            "--manifest-path",
        ])
        .arg(manifest)
        .arg("--target-dir")
        .arg(&target)
        .arg("--config")
        .arg(format!("paths=[{module:?}]"))
        .args(["--features", features])
        .output()
        .expect("cargo starts");
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{message}");
    std::fs::copy(built, &kept).expect("copied");
    kept
}

/// What the program is told of a tick: what the sensors say (`None`: the bus fails) and the bytes that came.
pub fn message(now_us: u32, sample: Option<&RawSample>, came: &[u8]) -> Vec<u8> {
    let mut message = now_us.to_le_bytes().to_vec();
    message.push(u8::from(sample.is_some()));
    let none = [i16::MIN; 3];
    let (gyro, accel) = sample.map_or(([0; 3], [0; 3]), |sample| (sample.gyro, sample.accel));
    let (wheel, body) = sample.map_or((0, 0), |sample| (sample.wheel as u16, sample.body));
    for word in [gyro, accel, none].as_flattened() {
        message.extend(word.to_le_bytes());
    }
    message.extend(wheel.to_le_bytes());
    message.extend(body.to_le_bytes());
    message.push(came.len() as u8);
    message.extend(came);
    message
}

/// The running program.
pub struct Firmware {
    child: Child,
    input: ChildStdin,
    output: ChildStdout,
}

impl Firmware {
    pub fn start(program: &Path) -> Firmware {
        let mut child = Command::new(program)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("the firmware starts");
        Firmware {
            input: child.stdin.take().expect("its input"),
            output: child.stdout.take().expect("its output"),
            child,
        }
    }

    /// One tick: what the sensors say (`None`: the bus fails) and the bytes that came, to the duty and the
    /// bytes that go.
    pub fn tick(
        &mut self,
        now_us: u32,
        sample: Option<&RawSample>,
        came: &[u8],
    ) -> std::io::Result<(u16, Vec<u8>)> {
        self.input.write_all(&message(now_us, sample, came))?;
        self.input.flush()?;
        let mut head = [0; 3];
        self.output.read_exact(&mut head)?;
        let [low, high, count] = head;
        let mut goes = vec![0; usize::from(count)];
        self.output.read_exact(&mut goes)?;
        Ok((u16::from_le_bytes([low, high]), goes))
    }
}

impl Drop for Firmware {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
