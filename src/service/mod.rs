//! The daemon: receive, estimate, publish.
