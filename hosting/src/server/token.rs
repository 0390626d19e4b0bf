//! The token of a TCP port. Every user of the machine may connect to the port, but only this user can read
//! the file with the token, which a client sends first.

use std::fmt::Write as _;
use std::fs::{File, OpenOptions};
use std::io::{self, Read as _, Write as _};
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::sockets;
use dotgen_platform::files::disk::TemporaryFile;

/// See the [module](self).
pub(super) struct Token {
    text: String,
    path: PathBuf,
}

impl Token {
    /// Creates a new token for a port, and its file of mode 0600.
    ///
    /// # Errors
    /// The folder of this user's runs, or the file, cannot be created.
    pub(super) fn new(port: u16) -> io::Result<(Token, TemporaryFile)> {
        let mut bytes = [0; 16];
        File::open("/dev/urandom")?.read_exact(&mut bytes)?;
        let text = bytes.iter().fold(String::new(), |mut text, byte| {
            let _ = write!(text, "{byte:02x}");
            text
        });
        let path = sockets::token(port)?;
        // A run that was killed leaves its file behind, but not its port.
        let _ = std::fs::remove_file(&path);
        let mut options = OpenOptions::new();
        let mut file = options.write(true).create_new(true).mode(0o600).open(&path)?;
        file.write_all(text.as_bytes())?;
        let file = TemporaryFile::new(path.clone());
        Ok((Token { text, path }, file))
    }

    /// The path of the file.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Returns true if the request is `{"token": "…"}` with this token.
    pub(super) fn is_in(&self, request: &Value) -> bool {
        request.get("token").and_then(Value::as_str) == Some(&self.text)
    }
}
