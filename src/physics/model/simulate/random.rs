//! Where chance comes from: a generator for each thing that is random.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

/// Places in the seed's space, so that a change of one random thing leaves the others as they were.
#[derive(Clone, Copy)]
pub(super) enum Stream {
    Steering = 1,
    Drive,
    Brake,
    Pressure,
    Speed,
    Noise,
    Teeth,
    Jitter,
    Shake,
}

/// The generator of one thing of its kind.
pub(super) fn random(seed: u64, stream: Stream, index: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(((stream as u64) << 40) | (index & 0xFF_FFFF_FFFF));
    rng
}
