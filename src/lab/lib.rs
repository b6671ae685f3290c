//! Recording against simulation: what the car's numbers are, what physics is missing, and the pages that say so.

pub mod chance;
pub mod explain;
pub mod pages;
pub mod report;
pub mod reproduce;
