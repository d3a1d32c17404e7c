//! Result directories without write permission.

use super::{Folder, Said, copy_binary, said};
use std::fs::{self, Permissions};
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A result directory without write permission, which is restored at the end.
pub struct ReadOnly {
    folder: PathBuf,
    out: String,
}

impl ReadOnly {
    /// Removes the write permission of a directory and of its files.
    pub fn new(folder: &Folder, out: &str) -> Self {
        copy_binary(&folder.path("bladeoff"));
        set(&folder.path(""), 0o755);
        set(Path::new(out), 0o555);
        for entry in fs::read_dir(out).expect("readable").flatten() {
            set(&entry.path(), 0o444);
        }
        Self { folder: folder.path(""), out: out.to_owned() }
    }

    /// Runs a study there. Because root may write everywhere, another user then runs it with a copy of the program.
    pub fn run(&self, study: &str) -> Said {
        let mut command = Command::new(self.folder.join("bladeoff"));
        command.args(["run", study, "--out", &self.out, "--workers", "1"]).current_dir(&self.folder);
        if fs::metadata("/proc/self").expect("Linux").uid() == 0 {
            command.uid(65_534).gid(65_534);
        }
        said(command.output().expect("it starts"))
    }
}

impl Drop for ReadOnly {
    fn drop(&mut self) {
        set(Path::new(&self.out), 0o755);
    }
}

fn set(path: &Path, mode: u32) {
    fs::set_permissions(path, Permissions::from_mode(mode)).expect("set");
}
