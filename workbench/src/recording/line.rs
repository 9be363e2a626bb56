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
    /// Whole frames that were not asked for yet, each with the number of damaged frames before it.
    arrived: VecDeque<(Telemetry, u64)>,
    /// Number of damaged frames that have arrived: sequences of bytes between two zero bytes that were no valid frame.
    arrived_damaged: u64,
    /// Number of damaged frames before the frame that [`Line::next`] returned last.
    pub damaged: u64,
}

impl Line {
    /// Opens the device.
    pub fn open(path: &Path, baud: u32) -> Result<Line, Error> {
        let failed = |error: serialport::Error| Error::Record {
            port: path.to_path_buf(),
            reason: cannot_be_opened(&error),
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
            arrived_damaged: 0,
            damaged: 0,
        })
    }

    /// The next frame; `None` where none has come within [`PATIENCE`].
    pub fn next(&mut self) -> Result<Option<Telemetry>, Error> {
        if let Some(frame) = self.taken() {
            return Ok(Some(frame));
        }
        let mut bytes = [0; 4096];
        let count = match self.port.read(&mut bytes) {
            Ok(0) => return Err(self.disappeared()),
            Ok(count) => count,
            Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) => 0,
            Err(_) => return Err(self.disappeared()),
        };
        for byte in &bytes[..count] {
            match self.receiver.telemetry(*byte) {
                None => {}
                Some(Ok(frame)) => self.arrived.push_back((frame, self.arrived_damaged)),
                Some(Err(_)) => self.arrived_damaged += 1,
            }
        }
        Ok(self.taken())
    }

    /// The next frame of those that have arrived.
    fn taken(&mut self) -> Option<Telemetry> {
        let (frame, damaged) = self.arrived.pop_front()?;
        self.damaged = damaged;
        Some(frame)
    }

    /// Whether bytes came that were no valid frame.
    pub fn has_damage(&self) -> bool {
        self.arrived_damaged > 0
    }

    /// Sends a command.
    pub fn send(&mut self, command: &Command) -> Result<(), Error> {
        match self.port.write_all(command.frame().bytes()) {
            Ok(()) => Ok(()),
            // If the firmware does not read, the line fills up. The motor is then off, because the lease has ended.
            Err(error) if error.kind() == ErrorKind::TimedOut => Ok(()),
            Err(_) => Err(self.disappeared()),
        }
    }

    /// The error of a line that was open and can no longer be read or written: whatever the system calls it ("Broken pipe",
    /// "Input/output error"), the device is gone.
    fn disappeared(&self) -> Error {
        self.broken("the device has disappeared; check its cable")
    }

    /// The error that says what is wrong with the line.
    pub fn broken(&self, reason: &str) -> Error {
        Error::Record {
            port: self.path.clone(),
            reason: reason.to_owned(),
        }
    }
}

/// Why a port cannot be opened, and what to do.
fn cannot_be_opened(error: &serialport::Error) -> String {
    use serialport::ErrorKind as Kind;
    let text = error.description.as_str();
    let end = text.find(" (os error").unwrap_or(text.len());
    let text = &text[..end];
    // A file, a pipe or another device has no line settings: the system says that it is no typewriter.
    if text.contains("typewriter") || text.contains("directory") && error.kind() == Kind::Unknown {
        return "this is no serial device; name the port of the firmware, such as /dev/ttyUSB0"
            .to_owned();
    }
    let advice = match error.kind() {
        // What is said of a port that is locked.
        Kind::NoDevice if text.contains("lock") || text.contains("busy") => {
            "; another program has it: a serial monitor, the lab, another record? Close it there"
        }
        Kind::Io(ErrorKind::NotFound) => "; is the cable plugged in, and the name right?",
        Kind::Io(ErrorKind::PermissionDenied) => {
            "; on Linux your user must be in the group of the device, often dialout"
        }
        _ => "",
    };
    format!("cannot be opened: {text}{advice}")
}
