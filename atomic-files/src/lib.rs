//! Writing files so that a reader never sees half of one. The content goes into a new file beside the old one; this new
//! file is then renamed to the old name. An interrupted write leaves the old file as it was. A symbolic link is
//! followed, and the permissions of an old file are kept. A device or a pipe is written to directly.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

/// Writes `content` to `path`, whose folder must be there.
///
/// # Errors
/// The system's error. The old file is then unchanged.
pub fn write(path: &Path, content: &[u8]) -> io::Result<()> {
    staged(path, content)?.place()
}

/// Writes several files, and makes missing folders. The first file is renamed only when all are on the disk, so that a
/// missing permission or a full disk leaves every old file as it was.
///
/// # Errors
/// The file or folder, and what the system said about it.
pub fn write_all<'a>(
    files: impl IntoIterator<Item = (&'a Path, &'a [u8])>,
) -> Result<(), (PathBuf, io::Error)> {
    let mut all = Vec::new();
    for (path, content) in files {
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).map_err(|error| (folder.to_path_buf(), error))?;
        }
        let staged = staged(path, content).map_err(|error| (path.to_path_buf(), error))?;
        all.push((path, staged));
    }
    for (path, staged) in all {
        staged
            .place()
            .map_err(|error| (path.to_path_buf(), error))?;
    }
    Ok(())
}

/// Largest number of links that are followed to a file that does not exist yet. The system's own limit is similar.
const MOST_LINKS: usize = 40;

/// Where links that end at no file lead to.
fn end_of_links(path: &Path) -> PathBuf {
    let mut end = path.to_path_buf();
    for _ in 0..MOST_LINKS {
        let Ok(next) = fs::read_link(&end) else {
            break;
        };
        end = match end.parent() {
            Some(folder) => folder.join(next),
            None => next,
        };
    }
    end
}

/// Whether files can be written into a folder that exists or can be made. The test creates a temporary file in the
/// folder (or in the nearest existing folder above it) and removes it.
///
/// # Errors
/// What the system said.
pub fn can_write_into(folder: &Path) -> io::Result<()> {
    let here = Path::new(".");
    let there = folder.ancestors().find(|folder| folder.exists());
    let there = there
        .filter(|folder| !folder.as_os_str().is_empty())
        .unwrap_or(here);
    tempfile::tempfile_in(there).map(|_| ())
}

/// Whether a file of this name can be written, in a folder that exists or can be made. Nothing is left there.
///
/// # Errors
/// What the system said.
pub fn can_write(path: &Path) -> io::Result<()> {
    let target = target_of(path);
    if is_stream(&target) {
        return Ok(());
    }
    if target.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    can_write_into(target.parent().unwrap_or(Path::new(".")))
}

/// The file that is written for this path. Renaming to the name of a link would replace the link, not the file to which it
/// points.
fn target_of(path: &Path) -> PathBuf {
    fs::canonicalize(path).unwrap_or_else(|_| end_of_links(path))
}

/// What is ready to be written.
enum Staged {
    /// A file that is on the disk, but does not have its name yet. If it is dropped, the file is removed.
    File {
        file: NamedTempFile,
        target: PathBuf,
    },
    /// A device or a pipe, which receives the content directly. Renaming a file to its name would destroy it for all
    /// users.
    Stream { target: PathBuf, content: Vec<u8> },
}

impl Staged {
    fn place(self) -> io::Result<()> {
        match self {
            Staged::File { file, target } => {
                file.persist(&target)?;
                Ok(())
            }
            Staged::Stream { target, content } => {
                let mut stream = fs::OpenOptions::new().write(true).open(target)?;
                stream.write_all(&content)
            }
        }
    }
}

/// Whether the path names something that is neither a file nor a folder, such as `/dev/null` or a pipe.
fn is_stream(target: &Path) -> bool {
    fs::metadata(target).is_ok_and(|found| !found.is_file() && !found.is_dir())
}

fn staged(path: &Path, content: &[u8]) -> io::Result<Staged> {
    let target = target_of(path);
    if is_stream(&target) {
        let content = content.to_vec();
        return Ok(Staged::Stream { target, content });
    }
    let folder = match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".flywheel-").suffix(".tmp");
    // Temporary files are private by default; this one becomes an ordinary file.
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let permissions = match fs::metadata(&target) {
            Ok(old) => old.permissions(),
            Err(_) => fs::Permissions::from_mode(0o666),
        };
        builder.permissions(permissions);
    }
    let mut file = builder.tempfile_in(folder)?;
    file.write_all(content)?;
    file.as_file().sync_all()?;
    Ok(Staged::File { file, target })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_written_whole_or_not_at_all() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = |name: &str| folder.path().join(name);
        let list = || fs::read_dir(folder.path()).expect("a list").count();
        write(&path("a"), b"one").expect("written");
        write(&path("a"), b"two").expect("written again");
        assert_eq!(fs::read(path("a")).expect("there"), b"two");
        assert_eq!(list(), 1, "nothing temporary is left");
        assert!(write(folder.path(), b"x").is_err(), "a folder is no file");

        // The second has a file where its folder should be: the first stays as it was.
        let (a, under_a) = (path("a"), path("a/b"));
        let files: [(&Path, &[u8]); 2] = [(&a, b"three"), (&under_a, b"four")];
        let (place, _) = write_all(files).expect_err("a is no folder");
        assert_eq!(place, a);
        assert_eq!(fs::read(&a).expect("there"), b"two");
        assert_eq!(list(), 1, "nothing temporary is left");

        let deep = path("new/folder/c");
        write_all([(deep.as_path(), &b"five"[..])]).expect("folders are made");
        assert_eq!(fs::read(deep).expect("there"), b"five");
    }

    #[cfg(unix)]
    #[test]
    fn links_and_permissions_stay() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().expect("a folder");
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        fs::write(&file, "old").expect("written");
        fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).expect("set");
        symlink(&file, &link).expect("a link");
        write(&link, b"new").expect("written");
        assert!(fs::symlink_metadata(&link).expect("there").is_symlink());
        assert_eq!(fs::read(&file).expect("there"), b"new");
        let mode = fs::metadata(&file).expect("there").permissions().mode();
        assert_eq!(mode & 0o777, 0o640);

        // A link to a file that is not there yet, by way of another.
        let far = folder.path().join("far");
        let (first, second) = (folder.path().join("first"), folder.path().join("second"));
        symlink("second", &first).expect("a link");
        symlink(&far, &second).expect("a link");
        write(&first, b"there").expect("written");
        assert!(fs::symlink_metadata(&first).expect("there").is_symlink());
        assert_eq!(fs::read(&far).expect("there"), b"there");
    }

    #[cfg(unix)]
    #[test]
    fn a_device_stays_what_it_is() {
        let null = Path::new("/dev/null");
        let ready = staged(null, b"nothing").expect("ready");
        assert!(matches!(ready, Staged::Stream { .. }));
        ready.place().expect("written");
        assert!(is_stream(null));
    }

    #[test]
    fn a_folder_that_takes_no_files_is_known_beforehand() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("file");
        fs::write(&file, "old").expect("written");
        assert!(can_write_into(folder.path()).is_ok());
        assert!(can_write_into(&folder.path().join("new/deep")).is_ok());
        assert!(can_write_into(&file).is_err());
        assert!(can_write_into(&file.join("out")).is_err());
        assert_eq!(fs::read_dir(folder.path()).expect("a list").count(), 1);
    }

    #[test]
    fn a_file_that_cannot_be_written_is_known_beforehand() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("file");
        fs::write(&file, "old").expect("written");
        assert!(can_write(&file).is_ok());
        assert!(can_write(&folder.path().join("new/deep.json")).is_ok());
        assert!(can_write(folder.path()).is_err());
        assert!(can_write(&file.join("out.json")).is_err());
        assert_eq!(fs::read_to_string(&file).expect("read"), "old");
    }
}
