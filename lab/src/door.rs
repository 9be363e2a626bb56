//! The file that opens the page. Command lines can be read by every user of a machine, so the browser is given
//! the path of a file that only its owner can read, and the page in it hands over the key.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::guard::{ENTER, Guard};
use crate::server::Error;

/// The file; gone when this value is.
pub struct Door {
    folder: PathBuf,
    file: PathBuf,
}

impl Door {
    /// Writes the file into a folder of its own.
    pub fn write(guard: &Guard) -> Result<Door, Error> {
        // The runtime folder is the user's own; where there is none, a folder for him alone is made.
        let base = std::env::var_os("XDG_RUNTIME_DIR")
            .map(PathBuf::from)
            .filter(|path| path.is_dir())
            .unwrap_or_else(std::env::temp_dir);
        let folder = base.join(format!("flywheel-lab-{:016x}", rand::random::<u64>()));
        let door = Door {
            file: folder.join("open-lab.html"),
            folder,
        };
        let failed = |source| Error::Door {
            path: door.file.clone(),
            source,
        };
        private_folder(&door.folder).map_err(failed)?;
        let mut file = private_file(&door.file).map_err(failed)?;
        file.write_all(page(guard).as_bytes()).map_err(failed)?;
        Ok(door)
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.file
    }
}

/// Gives the file to the browser of the desktop.
///
/// # Errors
/// What the system said: there may be no desktop.
pub fn open_in_browser(file: &Path) -> io::Result<()> {
    #[cfg(target_os = "macos")]
    let program = "open";
    #[cfg(target_os = "windows")]
    let program = "explorer";
    #[cfg(not(any(target_os = "macos", target_os = "windows")))]
    let program = "xdg-open";
    Command::new(program)
        .arg(file)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .map(drop)
}

impl Drop for Door {
    fn drop(&mut self) {
        // Its key is of no use without the server.
        let _ = fs::remove_file(&self.file);
        let _ = fs::remove_dir(&self.folder);
    }
}

#[cfg(unix)]
fn private_folder(path: &Path) -> io::Result<()> {
    use std::os::unix::fs::DirBuilderExt;
    fs::DirBuilder::new().mode(0o700).create(path)
}

#[cfg(not(unix))]
fn private_folder(path: &Path) -> io::Result<()> {
    fs::create_dir(path)
}

fn private_file(path: &Path) -> io::Result<fs::File> {
    let mut options = fs::OpenOptions::new();
    // Never a file that was there before.
    options.write(true).create_new(true);
    #[cfg(unix)]
    {
        use std::os::unix::fs::OpenOptionsExt;
        options.mode(0o600);
    }
    options.open(path)
}

/// A form that sends itself: a key in an address would stay in the browser's history.
fn page(guard: &Guard) -> String {
    format!(
        "<!doctype html>\n<meta charset=\"utf-8\">\n<title>flywheel lab</title>\n\
         <form method=\"post\" action=\"{}{ENTER}\">\n\
         <input type=\"hidden\" name=\"key\" value=\"{}\">\n\
         <button>Open the lab</button>\n</form>\n\
         <script>document.forms[0].submit()</script>\n",
        guard.address(),
        guard.door_key()
    )
}
