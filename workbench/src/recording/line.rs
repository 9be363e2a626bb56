//! The serial line: bytes to frames, commands to bytes.

use std::collections::VecDeque;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::Duration;

use serial_frame::{Command, Receiver, Telemetry};
use serialport::{ClearBuffer, SerialPort};

use crate::error::Error;

/// Time for which one reading waits for a byte. It is short, so that Ctrl-C takes effect at once.
const PATIENCE: Duration = Duration::from_millis(20);

/// An open serial line.
pub(super) struct Line {
    port: Box<dyn SerialPort>,
    path: PathBuf,
    receiver: Receiver,
    arrived: VecDeque<Telemetry>,
    /// Number of damaged frames so far: sequences of bytes between two zero bytes that were no valid frame.
    pub damaged: u64,
}

impl Line {
    /// Opens the device.
    pub fn open(path: &Path, baud: u32) -> Result<Line, Error> {
        let failed = |error: serialport::Error| Error::Record {
            port: path.to_path_buf(),
            // A file, a pipe or another device has no line settings.
            reason: match error.kind() {
                serialport::ErrorKind::Io(_) if error.description.contains("typewriter") => {
                    "this is no serial device; name the port of the firmware, such as /dev/ttyUSB0"
                        .to_owned()
                }
                _ => format!("cannot be opened: {}", said(&error.description)),
            },
        };
        let port = serialport::new(path.to_string_lossy(), baud)
            .timeout(PATIENCE)
            .open()
            .map_err(failed)?;
        // Bytes that the system had buffered before are discarded. If that fails, they are read like any others.
        let _ = port.clear(ClearBuffer::Input);
        Ok(Line {
            port,
            path: path.to_path_buf(),
            receiver: Receiver::new(),
            arrived: VecDeque::new(),
            damaged: 0,
        })
    }

    /// The next frame; `None` where none has come within [`PATIENCE`].
    pub fn next(&mut self) -> Result<Option<Telemetry>, Error> {
        if let Some(frame) = self.arrived.pop_front() {
            return Ok(Some(frame));
        }
        let mut bytes = [0; 4096];
        let count = match self.port.read(&mut bytes) {
            Ok(0) => return Err(self.broken("the device has disappeared; check its cable")),
            Ok(count) => count,
            Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) => 0,
            Err(error) => return Err(self.broken(&said(&error.to_string()))),
        };
        for byte in &bytes[..count] {
            match self.receiver.telemetry(*byte) {
                None => {}
                Some(Ok(frame)) => self.arrived.push_back(frame),
                Some(Err(_)) => self.damaged += 1,
            }
        }
        Ok(self.arrived.pop_front())
    }

    /// Sends a command.
    pub fn send(&mut self, command: &Command) -> Result<(), Error> {
        match self.port.write_all(command.frame().bytes()) {
            Ok(()) => Ok(()),
            // If the firmware does not read, the line fills up. The motor is then off, because the lease has ended.
            Err(error) if error.kind() == ErrorKind::TimedOut => Ok(()),
            Err(error) => Err(self.broken(&said(&error.to_string()))),
        }
    }

    /// The error that says what is wrong with the line.
    pub fn broken(&self, reason: &str) -> Error {
        Error::Record {
            port: self.path.clone(),
            reason: reason.to_owned(),
        }
    }
}

/// The system's message without the error code, which only programmers read.
fn said(text: &str) -> String {
    let end = text.find(" (os error").unwrap_or(text.len());
    text[..end].to_owned()
}
