//! The simulated car as an FMU (Functional Mock-up Interface, [fmi-standard.org](https://fmi-standard.org), 2.0 and 3.0,
//! co-simulation), and FMUs of other programs.
//!
//! ```text
//! Car ─► variables ─► description ─► export ─► archive: modelDescription.xml, resources/car.toml, binaries/…/gripd.so
//!                                                            │                    │
//! importing program ◄─► abi (this crate as a library) ◄─► instance ◄──────────────┘
//! ```
//!
//! The crate is built twice: as a part of the program, which writes archives, and as the library that lies in every
//! archive. No compiler is needed to export a car: the library finds it in the resources.

pub mod abi;
pub mod car;
pub mod description;
pub mod export;
pub mod foreign;
pub mod instance;
mod quantities;
pub mod variables;
mod version;

pub use version::{MARK, Version};
