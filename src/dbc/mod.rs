//! A loaded, validated DBC file, compiled to decoders and encoders.
