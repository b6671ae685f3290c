//! Kalman filters, change detection and discretization.
