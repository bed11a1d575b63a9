//! Output files of commands. A regular file is replaced as a whole or not at all, and never if it is an input
//! of the command. Output to anything but a regular file (a pipe, a terminal, `/dev/null`) is written to it
//! directly.

use std::fs::{File, Metadata, OpenOptions, metadata};
use std::io::{ErrorKind, Write, stdout};
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile};

use crate::command::CommandError;
use crate::command::input::system_path;

/// Maximum number of symbolic links from a name to its file, that of Linux.
const MAX_LINKS: usize = 40;

/// An output file, checked before its content is computed.
pub struct Output {
    /// Path as the user wrote it.
    pub path: PathBuf,
    kind: OutputKind,
}

/// The way in which a target is written.
pub enum OutputKind {
    /// Through standard output, which is the same file.
    Standard,
    /// Through the path, to a pipe or a device.
    Stream,
    /// By a new file at this path, which is not a symbolic link.
    File(PathBuf),
}

impl Output {
    /// Returns the output at `path` of a command that reads `inputs`.
    ///
    /// # Errors
    ///
    /// Returns an error if the path is an input, a folder, a disk, or in a folder that cannot be written.
    pub fn new(path: PathBuf, inputs: &[&Path]) -> Result<Output, CommandError> {
        let kind = OutputKind::of(&path, inputs)?;
        if let OutputKind::File(place) = &kind {
            let refused = |error| refused(&path, error);
            if place.exists() {
                OpenOptions::new().write(true).open(place).map_err(refused)?;
            }
            beside(place).map_err(refused)?;
        }
        Ok(Output { path, kind })
    }

    /// Returns the outputs of a command that reads `inputs`, each to a different file.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Output::new`], and an error for two outputs to one file.
    pub fn all<const N: usize>(
        paths: [Option<PathBuf>; N],
        inputs: &[&Path],
    ) -> Result<[Option<Output>; N], CommandError> {
        let given: Vec<&PathBuf> = paths.iter().flatten().collect();
        for (index, path) in given.iter().enumerate() {
            let replaced = replaced(path);
            if replaced.is_some() && given[..index].iter().any(|other| identity(other) == replaced) {
                return Err(format!(
                    "{}: two outputs of this command go to one file; give each its own",
                    path.display()
                ));
            }
        }
        let mut outputs = [const { None }; N];
        for (output, path) in outputs.iter_mut().zip(paths) {
            *output = path.map(|path| Output::new(path, inputs)).transpose()?;
        }
        Ok(outputs)
    }

    /// Writes the text as the whole content.
    pub fn write(&self, text: &str) -> Result<(), CommandError> {
        let outcome = match &self.kind {
            OutputKind::Standard => stdout().write_all(text.as_bytes()).and_then(|()| stdout().flush()),
            OutputKind::Stream => stream(&self.path).and_then(|mut file| file.write_all(text.as_bytes())),
            OutputKind::File(place) => prepared(place, text.as_bytes())
                .and_then(|file| file.persist(place).map(drop).map_err(|error| error.error)),
        };
        match outcome {
            // A reader that stops reading has enough.
            Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
            outcome => outcome.map_err(|error| refused(&self.path, error)),
        }
    }
}

impl OutputKind {
    /// Returns the way in which a command that reads `inputs` writes the target at `path`.
    pub fn of(path: &Path, inputs: &[&Path]) -> Result<OutputKind, CommandError> {
        let replaced = replaced(path);
        let is_replaced = |input: &&&Path| replaced.is_some() && identity(system_path(input)) == replaced;
        if let Some(input) = inputs.iter().find(is_replaced) {
            let input = input.display();
            return Err(format!(
                "{}: would replace the input {input}; write to another file",
                path.display()
            ));
        }
        match metadata(path) {
            Ok(found) if found.is_dir() => Err(format!("{}: is a folder; name a file", path.display())),
            Ok(found) if is_disk(&found) => Err(format!("{}: is a disk; name a file", path.display())),
            Ok(found) if !found.is_file() => Ok(OutputKind::Stream),
            Ok(_) if identity(Path::new("/dev/stdout")) == replaced => Ok(OutputKind::Standard),
            _ => resolved(path).map(OutputKind::File).map_err(|error| refused(path, error)),
        }
    }
}

/// Opens a target that is not a regular file.
pub fn stream(path: &Path) -> std::io::Result<File> {
    OpenOptions::new().write(true).open(path)
}

/// Returns a temporary file with this content, and the owner and mode of the file at `place`, ready to
/// replace it.
pub fn prepared(place: &Path, content: &[u8]) -> std::io::Result<NamedTempFile> {
    let mut file = beside(place)?;
    // The mode is set before the content is written, which others may not be allowed to read.
    if let Ok(old) = metadata(place) {
        keep_owner(file.as_file(), &old);
        file.as_file().set_permissions(old.permissions())?;
    }
    file.write_all(content)?;
    // The content must be on the disk before the file has its name.
    file.as_file().sync_all()?;
    Ok(file)
}

/// Creates a temporary file in the folder of `place`, which is deleted unless it replaces the file there.
fn beside(place: &Path) -> std::io::Result<NamedTempFile> {
    let mut builder = Builder::new();
    builder.prefix(".truefeed-").suffix(".part").append(true);
    // The file gets the mode of any new file; temporary files by default are readable only by the owner.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder_of(place))
}

/// Returns the identity of the file that an output to `path` replaces; `None` if the output is written
/// directly.
fn replaced(path: &Path) -> Option<Identity> {
    let is_regular = metadata(path).map_or(true, |found| found.is_file());
    is_regular.then(|| identity(path)).flatten()
}

/// The identity of a file.
#[derive(PartialEq, Eq)]
enum Identity {
    /// Device and inode.
    #[cfg(unix)]
    Node(u64, u64),
    /// The canonical path, of a missing file, or if files have no inodes.
    Path(PathBuf),
}

/// Returns the identity of the file at `path`; `None` if it has none.
fn identity(path: &Path) -> Option<Identity> {
    match metadata(path) {
        #[cfg(unix)]
        Ok(found) => Some(node(&found)),
        #[cfg(not(unix))]
        Ok(_) => path.canonicalize().ok().map(Identity::Path),
        Err(_) => {
            let place = resolved(path).ok()?;
            Some(Identity::Path(folder_of(&place).canonicalize().ok()?.join(place.file_name()?)))
        }
    }
}

#[cfg(unix)]
fn node(found: &Metadata) -> Identity {
    use std::os::unix::fs::MetadataExt;
    Identity::Node(found.dev(), found.ino())
}

/// Returns `true` if an open file is still the one at `path`. Without inodes, an open file cannot be
/// replaced.
pub fn is_at(file: &File, path: &Path) -> std::io::Result<bool> {
    #[cfg(unix)]
    return Ok(Some(node(&file.metadata()?)) == identity(path));
    #[cfg(not(unix))]
    Ok(true)
}

/// Returns the path behind symbolic links; a file need not exist there.
fn resolved(path: &Path) -> std::io::Result<PathBuf> {
    let mut path = path.to_path_buf();
    for _ in 0..MAX_LINKS {
        if !path.is_symlink() {
            return Ok(path);
        }
        path = folder_of(&path).join(path.read_link()?);
    }
    Err(std::io::Error::other("too many symbolic links"))
}

fn folder_of(path: &Path) -> &Path {
    let parent = path.parent().unwrap_or(path);
    if parent == Path::new("") { Path::new(".") } else { parent }
}

/// Gives a file the owner and group of another. Only the superuser may do so; for other users the owner and
/// group of the file do not change.
fn keep_owner(file: &File, old: &Metadata) {
    #[cfg(unix)]
    {
        use std::os::unix::fs::{MetadataExt, fchown};
        let _ = fchown(file, Some(old.uid()), Some(old.gid()));
    }
    #[cfg(not(unix))]
    let _ = (file, old);
}

/// Returns `true` for a disk or a part of one.
fn is_disk(found: &Metadata) -> bool {
    #[cfg(unix)]
    return std::os::unix::fs::FileTypeExt::is_block_device(&found.file_type());
    #[cfg(not(unix))]
    {
        let _ = found;
        false
    }
}

fn refused(path: &Path, error: std::io::Error) -> CommandError {
    format!("{}: {error}", path.display())
}
