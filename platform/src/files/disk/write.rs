//! Writes files of users. Each file is complete at any moment. Of several files, either all are changed or
//! none.
//!
//! New content goes into temporary files next to the old files. When all content is on the disk, the
//! temporary files are renamed over the old ones. If a rename fails, the earlier changes are undone. For
//! several files, the helper of this process knows the renames, and completes them if this process is killed.
//! A temporary file is locked by its writer, so that the next writer recognizes the leftovers of a killed
//! one.

mod attributes;
#[cfg(test)]
mod tests;

use std::fs::{File, Metadata, TryLockError};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use dotgen_codegen::disk::{Before, NewContent, WriteError};

use super::SystemDisk;
use crate::process::{self, CleanupGuard, Move};

/// Prefix of the names of temporary files: those with new content, and second names of old files.
const NEW: &str = ".dotgen-new-";
const OLD: &str = ".dotgen-old-";
/// Suffix of the names of temporary files.
const SUFFIX: &str = ".tmp";

/// Maximum number of links in a chain; more than operating systems follow.
const MAX_LINKS: usize = 40;

/// A step of writing. Tests make each of them fail.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Step {
    /// Creates a missing directory.
    MakeDirectory,
    /// Creates a temporary file.
    Create,
    /// Writes the first half of the content.
    Fill,
    /// Writes the second half.
    FillMore,
    /// Syncs the content to the disk.
    Sync,
    /// Gives an old file a second name.
    Remember,
    /// Renames the new file over the old one.
    Replace,
    /// Removes a second name.
    Forget,
    /// Restores an old file.
    PutBack,
}

/// Called before each step; an error makes the step fail.
pub(super) type Hook<'a> = &'a mut dyn FnMut(Step) -> io::Result<()>;

/// Completes a group of moves when this process is killed.
pub(super) trait Finisher {
    /// Sets the moves, in place of the earlier ones.
    fn register_moves(&mut self, moves: Vec<Move>);
}

/// The helper of this process.
#[derive(Default)]
pub(super) struct WatchedMoves(Option<CleanupGuard>);

impl Finisher for WatchedMoves {
    fn register_moves(&mut self, moves: Vec<Move>) {
        // The new moves are registered before the old ones are removed.
        self.0 = if moves.is_empty() { None } else { process::finish(&moves) };
    }
}

/// See `Disk::write`.
pub(super) fn write(
    files: &[NewContent],
    finisher: &mut dyn Finisher,
    hook: Hook<'_>,
) -> Result<(), WriteError> {
    let mut batch = Batch::default();
    let done = batch.stage_all(files, hook).and_then(|()| batch.back_up_all(hook));
    let done = done.and_then(|()| {
        if files.len() > 1 {
            finisher.register_moves(batch.moves());
        }
        batch.replace_all(hook)
    });
    let done = match done {
        Ok(()) => {
            batch.finish(hook);
            Ok(())
        }
        Err((at, reason)) => {
            if files.len() > 1 {
                finisher.register_moves(batch.rollback_moves());
            }
            Err(WriteError {
                path: files.get(at).map(|file| file.path.clone()).unwrap_or_default(),
                reason,
                changed: batch.roll_back(hook),
                of: files.len(),
            })
        }
    };
    finisher.register_moves(Vec::new());
    done
}

/// Index of the file that cannot be written, and the error.
type WriteFailure = (usize, io::Error);

/// Files that are being written.
#[derive(Default)]
struct Batch {
    files: Vec<StagedFile>,
    /// Created directories, outermost first.
    directories: Vec<PathBuf>,
    /// Directories that were searched for leftovers.
    cleaned: Vec<PathBuf>,
}

/// A file that is being written.
struct StagedFile {
    /// The final path, with links followed.
    target: PathBuf,
    content: Content,
    before: Before,
    old: Option<PreviousFile>,
    /// True if the content is at the final path.
    replaced: bool,
}

enum Content {
    /// A temporary file. The open file keeps its lock.
    File(PathBuf, #[allow(dead_code, reason = "held for its lock")] File),
    /// Bytes for a device or pipe, which is written directly.
    Stream(Vec<u8>),
}

/// The file that existed before.
struct PreviousFile {
    /// Its second name, if it has one now.
    second: Option<PathBuf>,
    /// The open file, which keeps the lock.
    lock: Option<File>,
}

impl Batch {
    fn stage_all(&mut self, files: &[NewContent], hook: Hook<'_>) -> Result<(), WriteFailure> {
        for (at, file) in files.iter().enumerate() {
            let staged = self.stage(file, hook).map_err(|error| (at, error))?;
            self.files.push(staged);
        }
        Ok(())
    }

    fn stage(&mut self, file: &NewContent, hook: Hook<'_>) -> io::Result<StagedFile> {
        if let Some(reason) = file.leads_out(&SystemDisk) {
            return Err(io::Error::new(ErrorKind::PermissionDenied, reason));
        }
        let target = followed(&file.path)?;
        let old = match std::fs::metadata(&target) {
            Ok(metadata) if metadata.is_dir() => return Err(ErrorKind::IsADirectory.into()),
            Ok(metadata) => Some(metadata),
            Err(error) if error.kind() == ErrorKind::NotFound => None,
            Err(error) => return Err(error),
        };
        let staged = |content| StagedFile {
            target: target.clone(),
            content,
            before: file.before.clone(),
            old: old.as_ref().map(|_| PreviousFile { second: None, lock: None }),
            replaced: false,
        };
        if old.as_ref().is_some_and(|metadata| !metadata.is_file()) {
            return Ok(staged(Content::Stream(file.bytes.clone())));
        }
        if old.is_some() {
            may_write(&target)?;
        }
        let directory = directory_of(&target);
        self.make(directory, hook)?;
        if !self.cleaned.iter().any(|path| path == directory) {
            clean(directory);
            self.cleaned.push(directory.to_owned());
        }
        let (path, mut temporary) = create(directory, old.is_some(), hook)
            .map_err(|error| with_context(&error, "no file can be made in", directory))?;
        match fill(&mut temporary, file, &target, old.as_ref(), hook) {
            Ok(()) => Ok(staged(Content::File(path, temporary))),
            Err(error) => {
                let _ = std::fs::remove_file(&path);
                Err(error)
            }
        }
    }

    /// Creates a directory, and stores the created ones.
    fn make(&mut self, directory: &Path, hook: Hook<'_>) -> io::Result<()> {
        let mut missing = Vec::new();
        let mut at = Some(directory);
        while let Some(directory) =
            at.filter(|directory| !directory.as_os_str().is_empty() && !directory.exists())
        {
            missing.push(directory);
            at = directory.parent();
        }
        for path in missing.into_iter().rev() {
            hook(Step::MakeDirectory)?;
            match std::fs::create_dir(path) {
                Ok(()) => self.directories.push(path.to_owned()),
                Err(error) if error.kind() == ErrorKind::AlreadyExists && path.is_dir() => {}
                Err(error) => {
                    return Err(with_context(
                        &error,
                        "there is no folder, and none can be made at",
                        path,
                    ));
                }
            }
        }
        Ok(())
    }

    /// Gives old files second names if several files are changed.
    fn back_up_all(&mut self, hook: Hook<'_>) -> Result<(), WriteFailure> {
        let several = self.files.len() > 1;
        for (at, file) in self.files.iter_mut().enumerate() {
            if let (true, Some(old), Content::File(..)) = (several, &mut file.old, &file.content) {
                old.back_up(&file.target, hook).map_err(|error| (at, error))?;
            }
        }
        Ok(())
    }

    /// The moves that put every file in its place and remove the second names.
    fn moves(&self) -> Vec<Move> {
        let staged = self.files.iter().filter_map(|file| match &file.content {
            Content::File(temporary, _) => {
                Some(Move { from: absolute(temporary), to: Some(absolute(&file.target)) })
            }
            Content::Stream(_) => None,
        });
        let seconds = self.files.iter().filter_map(StagedFile::second);
        staged.chain(seconds.map(removal)).collect()
    }

    /// The moves that undo everything.
    fn rollback_moves(&self) -> Vec<Move> {
        let mut moves = Vec::new();
        for file in &self.files {
            match (file.replaced, file.second(), &file.content) {
                (true, Some(second), _) => {
                    moves.push(Move { from: absolute(second), to: Some(absolute(&file.target)) });
                }
                (true, None, Content::File(..)) if file.old.is_none() => {
                    moves.push(removal(&file.target));
                }
                (false, second, Content::File(temporary, _)) => {
                    moves.push(removal(temporary));
                    moves.extend(second.map(removal));
                }
                _ => {}
            }
        }
        moves
    }

    fn replace_all(&mut self, hook: Hook<'_>) -> Result<(), WriteFailure> {
        // Files that cannot be restored come last.
        for stream in [false, true] {
            for (at, file) in self.files.iter_mut().enumerate() {
                if stream == matches!(file.content, Content::Stream(_)) {
                    file.replace(hook).map_err(|error| (at, error))?;
                }
            }
        }
        Ok(())
    }

    /// Ends a successful write: removes second names, and syncs the renames to the disk.
    fn finish(self, hook: Hook<'_>) {
        for second in self.files.iter().filter_map(StagedFile::second) {
            if hook(Step::Forget).is_ok() {
                let _ = std::fs::remove_file(second);
            }
        }
        for directory in &self.cleaned {
            // Some systems cannot sync a directory.
            let _ = File::open(directory).and_then(|file| file.sync_all());
        }
    }

    /// Undoes everything. Returns the files that remain changed, with the error.
    fn roll_back(self, hook: Hook<'_>) -> Vec<(PathBuf, io::Error)> {
        let mut stuck = Vec::new();
        for file in self.files.iter().rev() {
            let second = file.second();
            if file.replaced {
                let undone = hook(Step::PutBack).and_then(|()| match (&file.old, second) {
                    (Some(_), Some(second)) => std::fs::rename(second, &file.target),
                    (Some(_), None) => Err(io::Error::other("it cannot be taken back")),
                    (None, _) => std::fs::remove_file(&file.target),
                });
                if let Err(error) = undone {
                    let error = match second {
                        Some(path) => with_context(&error, "what it was is in", path),
                        None => error,
                    };
                    stuck.push((file.target.clone(), error));
                }
                continue;
            }
            if let Content::File(temporary, _) = &file.content {
                let _ = std::fs::remove_file(temporary);
            }
            if let Some(second) = second {
                let _ = std::fs::remove_file(second);
            }
        }
        for directory in self.directories.iter().rev() {
            // The directory stays if it is no longer empty.
            let _ = std::fs::remove_dir(directory);
        }
        stuck
    }
}

impl StagedFile {
    /// The second name of the old file.
    fn second(&self) -> Option<&PathBuf> {
        self.old.as_ref().and_then(|file| file.second.as_ref())
    }

    fn replace(&mut self, hook: Hook<'_>) -> io::Result<()> {
        hook(Step::Replace)?;
        match &self.content {
            Content::File(temporary, _) => {
                is_as_read(&self.target, &self.before)?;
                std::fs::rename(temporary, &self.target)?;
            }
            Content::Stream(bytes) => {
                let mut stream = File::options().write(true).open(&self.target)?;
                stream.write_all(bytes)?;
            }
        }
        self.replaced = true;
        Ok(())
    }
}

impl PreviousFile {
    /// Gives the file a second name, so that restoring it needs no space.
    fn back_up(&mut self, target: &Path, hook: Hook<'_>) -> io::Result<()> {
        hook(Step::Remember)?;
        let directory = directory_of(target);
        self.lock = File::open(target).ok().filter(|file| file.try_lock_shared().is_ok());
        let named =
            tempfile::Builder::new().prefix(OLD).suffix(SUFFIX).make_in(directory, |second| {
                match std::fs::hard_link(target, second) {
                    // Some file systems do not support hard links.
                    Err(error) if error.kind() != ErrorKind::AlreadyExists => {
                        std::fs::copy(target, second).map(|_| ())
                    }
                    done => done,
                }
            })?;
        self.second = Some(named.into_temp_path().keep().map_err(|error| error.error)?);
        Ok(())
    }
}

/// Creates a temporary file next to the file that a path points to, which it can replace.
pub(super) fn beside(path: &Path) -> io::Result<(PathBuf, PathBuf, File)> {
    let target = followed(path)?;
    may_write(&target)?;
    let directory = directory_of(&target);
    clean(directory);
    let (temporary, file) = create(directory, false, &mut |_| Ok(()))?;
    Ok((temporary, target, file))
}

/// The target of a path, with links followed; the target need not exist.
fn followed(path: &Path) -> io::Result<PathBuf> {
    let mut path = path.to_owned();
    for _ in 0..MAX_LINKS {
        match std::fs::read_link(&path) {
            Ok(to) => path = directory_of(&path).join(to),
            // The path does not exist, or is not a link.
            Err(_) => return Ok(path),
        }
    }
    Err(io::Error::other("too many links that lead to links"))
}

/// An absolute path, because the helper has another working directory.
fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}

fn removal(path: impl AsRef<Path>) -> Move {
    Move { from: absolute(path.as_ref()), to: None }
}

fn directory_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Fails for a file that a rename must not replace: it is read-only, or has other names.
fn may_write(path: &Path) -> io::Result<()> {
    attributes::has_one_name(path, &|name| name.starts_with(OLD) && name.ends_with(SUFFIX))?;
    match File::options().write(true).open(path) {
        Err(error)
            if matches!(
                error.kind(),
                ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem
            ) =>
        {
            Err(error)
        }
        _ => Ok(()),
    }
}

/// Fails if a file is no longer as it was read: another program has changed it since.
fn is_as_read(target: &Path, before: &Before) -> io::Result<()> {
    let same = match (before, crate::files::read_regular(target)) {
        (Before::Any, _) => true,
        (Before::Bytes(bytes), Ok(now)) => *bytes == now,
        (Before::Missing, Err(error)) => error.kind() == ErrorKind::NotFound,
        _ => false,
    };
    if same {
        Ok(())
    } else {
        Err(io::Error::other(
            "it was changed by another program meanwhile and is left as it is; run the command again",
        ))
    }
}

/// Creates a temporary file and locks it. A file that replaces another one is private at first.
fn create(directory: &Path, private: bool, hook: Hook<'_>) -> io::Result<(PathBuf, File)> {
    hook(Step::Create)?;
    loop {
        let named =
            tempfile::Builder::new().prefix(NEW).suffix(SUFFIX).make_in(directory, |path| {
                let mut options = File::options();
                options.write(true).create_new(true);
                #[cfg(unix)]
                if private {
                    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
                }
                options.open(path)
            })?;
        let (file, path) = named.into_parts();
        let locked = file.try_lock();
        let path = path.keep().map_err(|error| error.error)?;
        // Before the file is locked, another writer may take it for a leftover and remove it.
        if !matches!(locked, Err(TryLockError::WouldBlock)) && path.exists() {
            return Ok((path, file));
        }
    }
}

fn fill(
    file: &mut File,
    content: &NewContent,
    target: &Path,
    old: Option<&Metadata>,
    hook: Hook<'_>,
) -> io::Result<()> {
    let (first, second) = content.bytes.split_at(content.bytes.len() / 2);
    hook(Step::Fill)?;
    file.write_all(first)?;
    hook(Step::FillMore)?;
    file.write_all(second)?;
    attributes::set(file, content.mode, target, old)?;
    hook(Step::Sync)?;
    file.sync_all()
}

/// Removes temporary files of writers that have ended.
fn clean(directory: &Path) {
    let entries = std::fs::read_dir(directory).into_iter().flatten().flatten();
    for entry in entries {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        let ours = (name.starts_with(NEW) || name.starts_with(OLD)) && name.ends_with(SUFFIX);
        if !ours || !entry.file_type().is_ok_and(|file_type| file_type.is_file()) {
            continue;
        }
        // Opened without blocking or changing anything. A live writer holds the lock. It is kept until the
        // file is removed: a writer that has just made it takes another one.
        if let Ok(file) = File::open(entry.path())
            && file.try_lock().is_ok()
        {
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

fn with_context(error: &io::Error, what: &str, path: &Path) -> io::Error {
    let reason = crate::files::reason(error);
    io::Error::new(error.kind(), format!("{what} `{}`: {reason}", path.display()))
}
