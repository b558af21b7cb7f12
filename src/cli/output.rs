//! The only code that opens files and writes to the terminal.
//!
//! A file is written beside its place and then renamed, so that a reader sees the old file or the new one, never a half.

use crate::exit::{BadData, Usage};
use anyhow::{Context, Result};
use std::fs::{self, File};
use std::io::{self, IsTerminal, Read, Write};
use std::path::{Path, PathBuf};

/// Characters in a line of a report.
pub(crate) const WIDTH: usize = 100;
/// Largest file that is read, bytes.
pub(crate) const MOST_BYTES: u64 = 1 << 30;

/// The bytes of a file, or of standard input for `-`.
pub(crate) fn read(path: &Path) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    if path == Path::new("-") {
        io::stdin().lock().take(MOST_BYTES + 1).read_to_end(&mut bytes).context("standard input cannot be read")?;
    } else {
        let unreadable = || format!("{} cannot be read", path.display());
        let file = File::open(path).with_context(unreadable)?;
        let about = file.metadata().with_context(unreadable)?;
        if about.is_dir() {
            return Err(Usage(format!("{} is a folder; give the name of a file in it", path.display())).into());
        }
        // The limit holds for what has no length too, such as a device.
        file.take(MOST_BYTES + 1).read_to_end(&mut bytes).with_context(unreadable)?;
    }
    if bytes.len() as u64 > MOST_BYTES {
        return Err(BadData(format!("{} is larger than {MOST_BYTES} bytes", path.display())).into());
    }
    Ok(bytes)
}

/// A folder that results go to, known to be writable.
#[derive(Debug)]
pub(crate) struct Folder {
    path: PathBuf,
    /// The folders that were made for it, the innermost first.
    made: Vec<PathBuf>,
}

impl Folder {
    /// Makes the folder if it is missing, and tries to write there, before long work begins.
    pub(crate) fn open(path: &Path) -> Result<Self> {
        let is_missing = |folder: &&Path| !folder.as_os_str().is_empty() && !folder.exists();
        let made = path.ancestors().take_while(is_missing).map(Path::to_owned).collect();
        fs::create_dir_all(path).with_context(|| format!("the folder {} cannot be made", path.display()))?;
        let folder = Self { path: path.to_owned(), made };
        let probe = beside(&path.join("probe"));
        let tried = File::create(&probe).and_then(|_| fs::remove_file(&probe));
        match tried {
            Ok(()) => Ok(folder),
            Err(error) => {
                folder.abandon();
                Err(error).with_context(|| format!("the folder {} cannot be written to", path.display()))
            }
        }
    }

    /// Takes away what was made for nothing; a folder that is not empty stays.
    pub(crate) fn abandon(&self) {
        for folder in &self.made {
            let _ = fs::remove_dir(folder);
        }
    }

    /// Writes all files beside their places, then renames all of them; if one cannot be written, none is replaced. A name may
    /// have a folder in it, which is made.
    pub(crate) fn write(&self, files: &[(String, Vec<u8>)]) -> Result<()> {
        let mut names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
        names.sort_unstable();
        if let Some(pair) = names.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(Usage(format!("two files would have the name {}", pair[0])).into());
        }
        let mut parts = Vec::new();
        let mut inner = Vec::new();
        for (name, bytes) in files {
            let place = self.path.join(name);
            let part = beside(&place);
            if let Some(folder) = place.parent().filter(|folder| !folder.exists()) {
                inner.push(folder.to_owned());
            }
            let made = place.parent().map_or(Ok(()), fs::create_dir_all);
            parts.push((part.clone(), place.clone()));
            if let Err(error) = made.and_then(|()| write_through(&part, bytes)) {
                remove(&parts);
                inner.iter().for_each(|folder| drop(fs::remove_dir(folder)));
                return Err(error).with_context(|| format!("{} cannot be written", place.display()));
            }
        }
        for (part, place) in &parts {
            if let Err(error) = fs::rename(part, place) {
                remove(&parts);
                return Err(error).with_context(|| format!("{} cannot be replaced", place.display()));
            }
        }
        Ok(())
    }

    /// Takes away files of an earlier run that this one does not make.
    pub(crate) fn remove_stale(&self, names: &[String]) {
        for name in names {
            let _ = fs::remove_file(self.path.join(name));
        }
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }
}

/// Writes one file beside its place and renames it; folders on the way are made.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    let unwritable = || format!("{} cannot be written", path.display());
    if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        fs::create_dir_all(folder).with_context(unwritable)?;
    }
    if path.is_dir() {
        return Err(Usage(format!("{} is a folder; give the name of a file in it", path.display())).into());
    }
    // A device, such as /dev/null, is not replaced.
    if path.exists() && !path.is_file() {
        return fs::write(path, bytes).with_context(unwritable);
    }
    let part = beside(path);
    write_through(&part, bytes)
        .and_then(|()| fs::rename(&part, path))
        .inspect_err(|_| {
            let _ = fs::remove_file(&part);
        })
        .with_context(unwritable)
}

fn write_through(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = File::create(path)?;
    file.write_all(bytes)?;
    file.sync_all()
}

/// A name in the same folder that no other run takes.
fn beside(path: &Path) -> PathBuf {
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    path.with_file_name(format!(".{name}.{}.part", std::process::id()))
}

fn remove(parts: &[(PathBuf, PathBuf)]) {
    for (part, _) in parts {
        let _ = fs::remove_file(part);
    }
}

/// Writes to standard output.
pub(crate) fn print(bytes: &[u8]) -> Result<()> {
    let mut out = io::stdout().lock();
    out.write_all(bytes).and_then(|()| out.flush()).context("standard output cannot be written")
}

/// Prints a report; on a terminal its first line is bold.
pub(crate) fn print_report(report: &str) -> Result<()> {
    let styled = io::stdout().is_terminal() && std::env::var_os("NO_COLOR").is_none() && !cfg!(windows);
    match report.split_once('\n') {
        Some((first, rest)) if styled => print(format!("\u{1b}[1m{first}\u{1b}[0m\n{rest}").as_bytes()),
        _ => print(report.as_bytes()),
    }
}

/// Tells of an error or a warning on standard error.
pub(crate) fn complain(message: &str) {
    // There is nobody to tell if standard error is closed.
    let _ = writeln!(io::stderr().lock(), "morpho-fit: {message}");
}
