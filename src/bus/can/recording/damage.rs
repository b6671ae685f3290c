//! What can be wrong with a line of a text, an object of a BLF file or a record of an MF4 file.

use thiserror::Error;

/// Why a line (an object, a record) could not be understood.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum Damage {
    /// It does not begin with a stamp.
    #[error("no time stamp `(seconds.fraction)` at the start; record with `candump -L` or `-l`")]
    NoStamp,
    /// The stamp is no number of seconds.
    #[error("the time stamp is not `(seconds.fraction)`; record with `candump -L` or `-l`")]
    BadStamp,
    /// The line ends before the frame.
    #[error("the line ends before interface and frame")]
    Incomplete,
    /// The frame has no `#`, as in candump's screen output.
    #[error("no `identifier#data`; record with `candump -L` or `-l`, not as shown on the screen")]
    NoFrame,
    /// The identifier is not hexadecimal or has the wrong number of digits.
    #[error("the identifier is not of 3 (standard) or 8 (extended) hexadecimal digits")]
    BadId,
    /// The identifier is too large for its kind.
    #[error("the identifier is above 7FF (3 digits) or 1FFFFFFF (8 digits)")]
    IdTooLarge,
    /// The data are not pairs of hexadecimal digits.
    #[error("the data are not pairs of hexadecimal digits")]
    BadData,
    /// More bytes than the kind of frame carries.
    #[error("more than 8 (classic) or 64 (FD) bytes of data")]
    TooLong,
    /// FD cannot carry that many bytes.
    #[error("no FD frame has that many bytes (0–8, 12, 16, 20, 24, 32, 48, 64)")]
    NotAnFdLength,
    /// The FD flags are missing or not hexadecimal.
    #[error("no hexadecimal flags digit after `##`")]
    BadFlags,
    /// A remote request with something else than a length of 0 to 8.
    #[error("the length of a remote request is not a digit from 0 to 8")]
    BadRemote,
    /// Something follows the frame that is no direction.
    #[error("unexpected text after the frame (only ` T` or ` R` may follow)")]
    Trailing,
    /// The interface name is not text.
    #[error("the interface name is not text")]
    BadInterface,
    /// No end of line within the reader's buffer.
    #[error("the line is longer than {} bytes", super::LONGEST_LINE)]
    LongLine,
    /// A `DROPCOUNT` line without its number.
    #[error("a DROPCOUNT line without a number")]
    BadDropCount,
    /// Another format: the last line has no end, so that nobody knows whether it is whole.
    #[error("the last line has no line end: the file was cut off")]
    NoEnd,
    /// Another format: the line is of no kind that the format has.
    #[error("this is no line of this format")]
    UnknownLine,
    /// Another format: the line has too few columns for a frame.
    #[error("the line ends before the frame does")]
    FewColumns,
    /// Another format: the time is no number, or beyond any clock.
    #[error("the time is not a number of seconds or milliseconds")]
    BadTime,
    /// Another format: the identifier is no number, or above 7FF or 1FFFFFFF for its kind.
    #[error("the identifier is not a number, or too large for its kind (standard 7FF, extended 1FFFFFFF)")]
    BadNumber,
    /// Another format: a length that no frame has.
    #[error("the length is not one that a frame can have")]
    BadLength,
    /// Another format: other bytes than the length says.
    #[error("the data are not as many bytes as the length says")]
    BadBytes,
    /// BLF: an object is shorter than its fields.
    #[error("the object ends before its fields do")]
    ShortObject,
    /// BLF: bytes between two objects that are neither.
    #[error("bytes that are no object; went on at the next one")]
    NoObject,
    /// BLF: a container that cannot be unpacked.
    #[error("the container cannot be unpacked: its compression is unknown or its data are corrupt")]
    BadContainer,
    /// MF4: the frame's data are not where the record says.
    #[error("the data of the frame are not in the file")]
    NoData,
}
