//! What varies along the road, and what is known of it before any recording.

/// What varies while one drives, and nobody measures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disturbance {
    /// Unit of the course.
    pub unit: &'static str,
    /// Key of its rms (or peak) in the JSON.
    pub rms_name: &'static str,
    /// The name of that number in a sentence.
    pub words: &'static str,
    /// Typical size, in the unit.
    pub size: f64,
    /// Typical duration of a change, s: the correlation length.
    pub length_s: f64,
    /// Only values of this sign can be (`+1`), or both (`0`). Where it is +1 the course is the share of the
    /// road that is another one, and lies in patches.
    pub sign: f64,
    /// Shortest correlation length that a search may give it, s.
    pub shortest_s: f64,
    /// Its peak stands for it in the answer, not its rms: it acts now and then.
    pub is_told_by_its_peak: bool,
    /// Its mean cannot be told from the offset of the sensor, which is an ordinary number.
    pub has_its_mean_in_an_offset: bool,
    /// Of a patch: what the kind's numbers are set to (in their coordinates) while its share is estimated.
    /// One candidate for each: somewhat different, and much.
    pub settings: &'static [&'static [f64]],
    /// Of a patch: wheels may slide there. Where they are seen to slide, a patch is tried.
    pub is_slippery: bool,
}

impl Disturbance {
    /// What most have in common; name, size and length are each one's own.
    pub const USUAL: Self = Self {
        unit: "1",
        rms_name: "",
        words: "",
        size: 1.0,
        length_s: 1.0,
        sign: 0.0,
        shortest_s: 0.2,
        is_told_by_its_peak: false,
        has_its_mean_in_an_offset: false,
        settings: &[],
        is_slippery: false,
    };

    /// What a configured course of it may reach, in its unit.
    pub fn range(&self) -> (f64, f64) {
        let most = MOST_TIMES_USUAL * self.size;
        match self.sign > 0.0 {
            true if self.unit == "1" => (0.0, 1.0),
            true => (0.0, most),
            false => (-most, most),
        }
    }
}

/// Times what is usual that a course may reach: beyond it the unit is wrong.
const MOST_TIMES_USUAL: f64 = 100.0;
