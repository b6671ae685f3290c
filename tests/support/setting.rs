//! Settings of those tests that people run.

/// A setting from the environment.
pub fn setting<T: std::str::FromStr>(name: &str, usual: T) -> T {
    match std::env::var(name) {
        Ok(text) => text.parse().unwrap_or_else(|_| panic!("{name}={text}: not a value")),
        Err(_) => usual,
    }
}
