//! Answers of requests that may be refused.

use super::types::{Error, ErrorCode, Result};

/// An answer, or an error message for the user.
#[derive(Debug)]
pub(crate) struct UserResult<T>(pub(crate) std::result::Result<Option<T>, String>);

impl<T> Default for UserResult<T> {
    fn default() -> UserResult<T> {
        UserResult(Ok(None))
    }
}

impl<T> UserResult<T> {
    /// The response; an error has the code `RequestFailed`.
    pub(crate) fn into_response(self) -> Result<Option<T>> {
        self.0.map_err(|message| Error {
            code: ErrorCode::ServerError(-32803),
            message: message.into(),
            data: None,
        })
    }
}
