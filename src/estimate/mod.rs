//! The estimators, and the pipeline that runs them on a sample.
