//! Network interfaces by name: is it there, is it up, is it CAN?

use std::fmt;
use std::str::FromStr;

use nix::errno::Errno;
use nix::ifaddrs::getifaddrs;
use nix::net::if_::{InterfaceFlags, if_nametoindex};

use super::OpenError;

/// `ARPHRD_CAN`, the kernel's hardware type of CAN interfaces.
const CAN_HARDWARE: u16 = 280;

/// A name that an interface can have: 1 to 15 bytes.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct InterfaceName {
    bytes: [u8; Self::LONGEST],
    length: u8,
}

impl InterfaceName {
    /// Most bytes in a name.
    pub const LONGEST: usize = 15;

    /// The name as text.
    pub fn as_str(&self) -> &str {
        // Made from a `str`, so this cannot fail; no need to be unsafe about it.
        str::from_utf8(&self.bytes[..usize::from(self.length)]).unwrap_or_default()
    }

    /// Does the interface with this number still have this name? Allocates nothing. Where the kernel cannot be
    /// asked (no descriptor is left), nothing speaks against it.
    pub(super) fn is_still(&self, index: u32) -> bool {
        match if_nametoindex(self.as_str()) {
            Ok(now) => now == index,
            Err(errno) => errno != Errno::ENODEV,
        }
    }

    /// The longest message of the interface with this number, where it is known. /sys may be of another network
    /// namespace: then it has another interface of that name, or none.
    pub(super) fn mtu(&self, index: u32) -> Option<u32> {
        let number = |what: &str| -> Option<u32> {
            let text = std::fs::read_to_string(format!("/sys/class/net/{self}/{what}")).ok()?;
            text.trim().parse().ok()
        };
        number("ifindex").filter(|found| *found == index).and_then(|_| number("mtu"))
    }

    /// The interface as it is now; `None` when there is none of that name.
    ///
    /// Asks the kernel by netlink, which unlike `/sys` always means the process's own network
    /// namespace. A question for bad days only: it allocates.
    pub(super) fn look_up(&self) -> Option<InterfaceState> {
        getifaddrs().ok()?.find(|entry| entry.interface_name == self.as_str()).map(|entry| {
            let hardware = entry.address.as_ref().and_then(|address| address.as_link_addr());
            InterfaceState {
                is_up: entry.flags.contains(InterfaceFlags::IFF_UP),
                is_can: hardware.is_none_or(|link| link.hatype() == CAN_HARDWARE),
                index: if_nametoindex(self.as_str()).unwrap_or(0),
            }
        })
    }
}

/// What is known of an existing interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct InterfaceState {
    /// Its number, which is new whenever an interface is created; 0 when it vanished just now.
    pub index: u32,
    pub is_up: bool,
    pub is_can: bool,
}

impl FromStr for InterfaceName {
    type Err = OpenError;

    fn from_str(name: &str) -> Result<Self, OpenError> {
        let fits = (1..=Self::LONGEST).contains(&name.len()) && name != "." && name != "..";
        if !fits || name.contains(|c: char| c == '/' || c == ':' || c.is_whitespace() || c.is_control()) {
            return Err(OpenError::BadName(name.to_owned()));
        }
        let mut bytes = [0; Self::LONGEST];
        bytes[..name.len()].copy_from_slice(name.as_bytes());
        Ok(Self { bytes, length: name.len() as u8 })
    }
}

impl fmt::Display for InterfaceName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

impl fmt::Debug for InterfaceName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_follow_the_kernels_rules() {
        assert_eq!("vcan0".parse::<InterfaceName>().unwrap().to_string(), "vcan0");
        for bad in ["", "a/b", "can 0", "can0:1", "..", "sixteen_letters_"] {
            assert!(matches!(bad.parse::<InterfaceName>(), Err(OpenError::BadName(_))), "{bad}");
        }
    }

    #[test]
    fn the_loopback_is_there_and_is_not_can() {
        let Some(lo) = "lo".parse::<InterfaceName>().unwrap().look_up() else {
            return println!("skipped: no loopback interface here");
        };
        assert!(!lo.is_can && lo.index > 0);
        let name: InterfaceName = "lo".parse().unwrap();
        assert!(name.is_still(lo.index) && !name.is_still(lo.index + 1));
        assert!(!"no_such_if".parse::<InterfaceName>().unwrap().is_still(lo.index));
        assert_eq!("no_such_if".parse::<InterfaceName>().unwrap().look_up(), None);
    }
}
