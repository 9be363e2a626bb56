//! The file that opens the page. Every user of a machine can read command lines. The browser therefore gets
//! the path of a file that only its owner can read; the page in that file sends the key to the server.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::error::Error;
use crate::guard::{ENTER, Guard};

/// The file; it is deleted when this value is dropped.
pub struct Door {
    folder: PathBuf,
    file: PathBuf,
}

impl Door {
    /// Writes the file into a folder of its own.
    pub fn write(guard: &Guard) -> Result<Door, Error> {
        // The runtime folder belongs to the user; if there is none, a folder for this user alone is created.
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

    /// Path of the file.
    pub fn path(&self) -> &Path {
        &self.file
    }
}

/// Opens the file in the browser of the desktop.
///
/// # Errors
/// The system's error: there may be no desktop.
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
        // The key is useless without the server, so an error does not matter.
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
    // An existing file is never used.
    options.write(true).create_new(true);
    #[cfg(unix)]
    {
        use std::os::unix::fs::OpenOptionsExt;
        options.mode(0o600);
    }
    options.open(path)
}

/// A page with a form that submits itself: a key in an address would stay in the browser's history.
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
