//! Texts that come over the border, and places of resources.

use std::borrow::Cow;
use std::ffi::{CStr, OsString, c_char};
use std::os::unix::ffi::OsStringExt;
use std::path::PathBuf;

/// A text of C; nothing where there is none.
///
/// # Safety
/// `text` is null, or ends in a zero and outlives the result.
pub(super) unsafe fn text<'a>(text: *const c_char) -> Option<Cow<'a, str>> {
    // SAFETY: as promised to this function.
    (!text.is_null()).then(|| unsafe { CStr::from_ptr(text) }.to_string_lossy())
}

/// The folder of a `file:` URI, or of a path.
pub(super) fn folder(location: &str) -> PathBuf {
    let Some(rest) = location.strip_prefix("file:") else { return PathBuf::from(location) };
    // file:/path, file:///path, file://host/path: of this machine all of them.
    let path = match rest.strip_prefix("//") {
        Some(with_host) => with_host.find('/').map_or("/", |at| &with_host[at..]),
        None => rest,
    };
    let bytes = path.as_bytes();
    let mut decoded = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while let Some(byte) = bytes.get(at) {
        let escape = bytes.get(at + 1..at + 3).filter(|_| *byte == b'%');
        let code = escape.and_then(|hex| u8::from_str_radix(std::str::from_utf8(hex).ok()?, 16).ok());
        decoded.push(code.unwrap_or(*byte));
        at += if code.is_some() { 3 } else { 1 };
    }
    PathBuf::from(OsString::from_vec(decoded))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_location_is_a_folder() {
        for (location, path) in [
            ("file:///tmp/a%20b/resources", "/tmp/a b/resources"),
            ("file:/tmp/r", "/tmp/r"),
            ("file://localhost/tmp/r", "/tmp/r"),
            ("/tmp/100%/r/", "/tmp/100%/r/"),
            ("file:///tmp/100%/%zz", "/tmp/100%/%zz"),
            ("file:///caf%C3%A9", "/café"),
        ] {
            assert_eq!(folder(location), PathBuf::from(path), "{location}");
        }
    }
}
