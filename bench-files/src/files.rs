//! The source of a bench's files: the disk, or memory.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, Cursor, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::mpsc;
use std::thread;

use crate::error::{Error, Problem};
use crate::write::reason;

/// The files of a bench in memory: `bench.toml`, the logs that it lists, and
/// `model.toml` if there is one. Names are as bench.toml writes them.
///
/// ```
/// let files: bench_files::FilesInMemory =
///     [("bench.toml", "[bench]\nname = \"mine\"\n"), ("swing.csv", "time_s,angle_rad\n")]
///         .into_iter()
///         .collect();
/// assert!(files.contains("swing.csv"));
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FilesInMemory(BTreeMap<PathBuf, Vec<u8>>);

impl FilesInMemory {
    /// Whether there is a file of this name.
    pub fn contains(&self, name: impl AsRef<Path>) -> bool {
        self.0.contains_key(name.as_ref())
    }

    /// Adds a file; a file with the same name is replaced.
    pub fn insert(&mut self, name: impl Into<PathBuf>, content: impl Into<Vec<u8>>) {
        self.0.insert(name.into(), content.into());
    }
}

impl<N: Into<PathBuf>, C: Into<Vec<u8>>> FromIterator<(N, C)> for FilesInMemory {
    fn from_iter<I: IntoIterator<Item = (N, C)>>(files: I) -> FilesInMemory {
        let files = files.into_iter();
        FilesInMemory(
            files
                .map(|(name, content)| (name.into(), content.into()))
                .collect(),
        )
    }
}

/// Receives the progress of reading files, and can cancel it.
#[derive(Clone, Copy)]
pub struct ReadingWatch<'w> {
    /// Called with the file, the bytes read so far and its size in bytes, after every [`WATCHED_BYTES`]; always from the
    /// caller's own thread. Several files are read at the same time.
    pub read: &'w dyn Fn(&Path, u64, u64),
    /// Called as often, from any thread. If it returns `true`, the reading ends with an error.
    pub cancelled: &'w (dyn Fn() -> bool + Sync),
}

/// A [`ReadingWatch`] as the threads see it that read.
#[derive(Clone, Copy)]
pub(crate) struct SharedWatch<'w> {
    pub read: &'w (dyn Fn(&Path, u64, u64) + Sync),
    pub cancelled: &'w (dyn Fn() -> bool + Sync),
}

impl ReadingWatch<'_> {
    /// Does `work` on another thread, and passes what it tells its watch to this one.
    pub(crate) fn over<T: Send>(self, work: impl FnOnce(SharedWatch) -> T + Send) -> T {
        let (told, heard) = mpsc::channel::<(PathBuf, u64, u64)>();
        let cancelled = self.cancelled;
        thread::scope(|scope| {
            let working = scope.spawn(move || {
                let read = |file: &Path, read, of| {
                    // The other end hears until this one is gone.
                    let _ = told.send((file.to_path_buf(), read, of));
                };
                work(SharedWatch {
                    read: &read,
                    cancelled,
                })
            });
            for (file, read, of) in heard {
                (self.read)(&file, read, of);
            }
            working
                .join()
                .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        })
    }
}

/// Number of bytes between two calls of a [`ReadingWatch`]: some ten milliseconds of reading.
pub const WATCHED_BYTES: u64 = 1 << 20;

/// Where files are opened.
#[derive(Clone, Copy)]
pub(crate) enum Files<'f> {
    /// On the disk.
    Disk,
    /// On the disk, with progress reports.
    Watched(SharedWatch<'f>),
    /// In memory only.
    Memory(&'f FilesInMemory),
}

/// An open file.
pub(crate) enum Content<'f> {
    Disk(File),
    Watched(WatchedFile<'f>),
    Memory(Cursor<&'f [u8]>),
}

impl<'f> Files<'f> {
    /// Opens a file. On the disk, a folder, a device or a pipe (which may never end) is refused.
    pub fn open(self, path: &Path) -> Result<Content<'f>, Error> {
        match self {
            Files::Memory(FilesInMemory(files)) => match files.get(path) {
                Some(bytes) => Ok(Content::Memory(Cursor::new(bytes))),
                None => Err(Error::in_file(path, Problem::NotFound)),
            },
            Files::Disk => open_regular(path).map(Content::Disk),
            Files::Watched(watch) => {
                let file = open_regular(path)?;
                let length = file.metadata().map_or(0, |metadata| metadata.len());
                Ok(Content::Watched(WatchedFile {
                    file,
                    path: path.to_path_buf(),
                    length,
                    read: 0,
                    watch,
                }))
            }
        }
    }
}

impl Files<'_> {
    /// The TOML files in a folder; none if the folder does not exist.
    pub fn toml_files_in(self, folder: &Path) -> Result<Vec<PathBuf>, Error> {
        let is_toml = |path: &Path| path.extension().is_some_and(|ending| ending == "toml");
        match self {
            Files::Memory(FilesInMemory(files)) => {
                let inside = files.keys().filter(|path| path.parent() == Some(folder));
                Ok(inside.filter(|path| is_toml(path)).cloned().collect())
            }
            Files::Disk | Files::Watched(_) => {
                let entries = match fs::read_dir(folder) {
                    Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(vec![]),
                    entries => entries,
                };
                let unreadable =
                    |error: io::Error| Error::in_file(folder, Problem::Unreadable(reason(&error)));
                let mut paths = vec![];
                for entry in entries.map_err(unreadable)? {
                    paths.push(entry.map_err(unreadable)?.path());
                }
                paths.retain(|path| is_toml(path));
                Ok(paths)
            }
        }
    }
}

impl Content<'_> {
    /// Number of bytes.
    pub fn length(&self) -> io::Result<u64> {
        match self {
            Content::Disk(file) => Ok(file.metadata()?.len()),
            Content::Watched(watched) => Ok(watched.length),
            Content::Memory(bytes) => Ok(bytes.get_ref().len() as u64),
        }
    }
}

impl Read for Content<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self {
            Content::Disk(file) => file.read(buffer),
            Content::Watched(watched) => watched.read(buffer),
            Content::Memory(bytes) => bytes.read(buffer),
        }
    }
}

impl Seek for Content<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match self {
            Content::Disk(file) => file.seek(to),
            Content::Watched(watched) => watched.file.seek(to),
            Content::Memory(bytes) => bytes.seek(to),
        }
    }
}

/// A file on the disk whose reading is reported.
pub(crate) struct WatchedFile<'w> {
    file: File,
    path: PathBuf,
    length: u64,
    read: u64,
    watch: SharedWatch<'w>,
}

impl Read for WatchedFile<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.file.read(buffer)?;
        let before = self.read;
        self.read += count as u64;
        if before == 0 || before / WATCHED_BYTES != self.read / WATCHED_BYTES {
            (self.watch.read)(&self.path, self.read, self.length);
            if (self.watch.cancelled)() {
                return Err(io::Error::other("called off"));
            }
        }
        Ok(count)
    }
}

fn open_regular(path: &Path) -> Result<File, Error> {
    let unreadable = |error: &io::Error| Problem::Unreadable(reason(error));
    let metadata = fs::metadata(path).map_err(|error| {
        let problem = match error.kind() {
            io::ErrorKind::NotFound => Problem::NotFound,
            _ => unreadable(&error),
        };
        Error::in_file(path, problem)
    })?;
    if !metadata.is_file() {
        let found = if metadata.is_dir() {
            "a folder"
        } else {
            "a device or a pipe"
        };
        return Err(Error::in_file(path, Problem::NotAFile { found }));
    }
    File::open(path).map_err(|error| Error::in_file(path, unreadable(&error)))
}
