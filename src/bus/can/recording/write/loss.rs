//! What of a frame a format cannot hold.

use std::fmt;

/// Why a frame is not in a recording, or not with all that it was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Loss {
    /// Left out: it is older than what the recording's times count from.
    BeforeStart,
    /// Left out: the format has no date for its time.
    NoDate,
    /// Left out: there are more interfaces than the format has numbers for.
    ManyInterfaces,
    /// Written, but of an error frame only that there was one.
    ErrorClass,
    /// Written, but without the interface.
    Interface,
    /// Written, but without the marks of an FD frame: of up to 8 bytes it reads as a classic one, of more as one
    /// without its flags.
    FdMarks,
}

impl Loss {
    /// Is the frame not there at all?
    pub fn is_left_out(self) -> bool {
        matches!(self, Self::BeforeStart | Self::NoDate | Self::ManyInterfaces)
    }
}

impl fmt::Display for Loss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::BeforeStart => {
                "left out: older by more than half a second than the first frame, from which the format's times count"
            }
            Self::NoDate => "left out: the format has no date for its time",
            Self::ManyInterfaces => "left out: beyond the 255 interfaces that the format has numbers for",
            Self::ErrorClass => "written without its class: of an error frame the format has only that there was one",
            Self::Interface => "written without its interface: the format has none",
            Self::FdMarks => "written without the marks of an FD frame: the format has none",
        })
    }
}

/// What was written.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Written {
    /// Frames that were to be written.
    pub frames: u64,
    /// How many of them were left out, or lost something, for each reason.
    pub losses: Vec<(Loss, u64)>,
    /// Interfaces that read back under another name, for the format has numbers only: what they were, what they become.
    pub renamed: Vec<(String, String)>,
}

impl Written {
    /// Frames that are not there.
    pub fn left_out(&self) -> u64 {
        self.losses.iter().filter(|(loss, _)| loss.is_left_out()).map(|(_, count)| count).sum()
    }

    pub(super) fn lost(&mut self, loss: Loss) {
        match self.losses.iter_mut().find(|(known, _)| *known == loss) {
            Some((_, count)) => *count += 1,
            None => self.losses.push((loss, 1)),
        }
    }
}
