//! GIVEN any layout of a signal WHEN it is decoded or encoded THEN it is what reading the bits one by
//! one, as the DBC format numbers them, gives.

use gripd::dbc::{Database, Signal};
use proptest::prelude::*;

/// A layout within a message.
#[derive(Clone, Debug)]
struct Layout {
    length: usize,
    motorola: bool,
    signed: bool,
    start: usize,
    size: usize,
}

/// Places of the bits as (byte, bit in the byte), most significant first, by walking them.
fn places(layout: &Layout) -> Vec<(usize, usize)> {
    let mut places = Vec::new();
    let (mut byte, mut bit) = (layout.start / 8, layout.start % 8);
    for _ in 0..layout.size {
        places.push((byte, bit));
        if layout.motorola {
            // Down to bit 0, then on at bit 7 of the next byte.
            if bit == 0 { (byte, bit) = (byte + 1, 7) } else { bit -= 1 }
        } else if bit == 7 {
            (byte, bit) = (byte + 1, 0);
        } else {
            bit += 1;
        }
    }
    if !layout.motorola {
        places.reverse();
    }
    places
}

fn read(layout: &Layout, data: &[u8]) -> u64 {
    places(layout).iter().fold(0, |value, (byte, bit)| value << 1 | u64::from(data[*byte] >> bit & 1))
}

fn write(layout: &Layout, data: &mut [u8], value: u64) {
    for (n, (byte, bit)) in places(layout).iter().rev().enumerate() {
        data[*byte] = data[*byte] & !(1 << bit) | ((value >> n & 1) as u8) << bit;
    }
}

fn signal(layout: &Layout) -> Option<Signal> {
    let Layout { length, motorola, signed, start, size } = layout;
    let order = if *motorola { 0 } else { 1 };
    let sign = if *signed { '-' } else { '+' };
    let text = format!("BO_ 1 M: {length} X\n SG_ s : {start}|{size}@{order}{sign} (1,0) [0|0] \"\" X\n");
    let database = Database::parse(text.as_bytes(), "layout").unwrap();
    database.signal("M.s").ok().map(|(_, signal)| signal.clone())
}

fn layouts() -> impl Strategy<Value = Layout> {
    (1_usize..=64, any::<bool>(), any::<bool>(), 1_usize..=64).prop_flat_map(
        |(length, motorola, signed, size)| {
            (0..8 * length).prop_map(move |start| Layout { length, motorola, signed, start, size })
        },
    )
}

fn fits(layout: &Layout) -> bool {
    places(layout).iter().all(|(byte, _)| *byte < layout.length)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    #[test]
    fn decoding_and_encoding_are_bit_by_bit_reading_and_writing(
        layout in layouts(),
        payload in proptest::collection::vec(any::<u8>(), 64),
        bits in any::<u64>(),
        cut in 0_usize..=64,
    ) {
        let Some(signal) = signal(&layout) else {
            prop_assert!(!fits(&layout), "a layout that fits was refused");
            return Ok(());
        };
        prop_assert!(fits(&layout), "a layout that does not fit was accepted");
        let data = &payload[..layout.length];
        let expected = read(&layout, data);
        prop_assert_eq!(signal.bits(data), Some(expected));
        let unused = 64 - layout.size as u32;
        let integer = ((expected << unused) as i64) >> unused;
        let physical = if layout.signed { integer as f64 } else { expected as f64 };
        prop_assert_eq!(signal.decode(data), Some(physical));
        if layout.signed {
            prop_assert_eq!(signal.raw(data), Some(integer));
        }
        // Longer frames than the file says change nothing; shorter ones only where the signal is.
        prop_assert_eq!(signal.bits(&payload), Some(expected));
        let end = places(&layout).iter().map(|(byte, _)| byte + 1).max().unwrap();
        let short = &payload[..cut];
        prop_assert_eq!(signal.bits(short), (cut >= end).then_some(expected));
        // Encoding touches its own bits only, in frames of any length.
        let mask = u64::MAX >> unused;
        for length in [layout.length, end, 64] {
            let mut ours = payload[..length].to_vec();
            let mut naive = ours.clone();
            signal.insert(&mut ours, bits).unwrap();
            write(&layout, &mut naive, bits);
            prop_assert_eq!(&ours, &naive);
            prop_assert_eq!(signal.bits(&ours), Some(bits & mask));
        }
        if end > 0 {
            let mut short = payload[..end - 1].to_vec();
            prop_assert!(signal.insert(&mut short, bits).is_err());
            prop_assert_eq!(&short[..], &payload[..end - 1]);
        }
    }

    #[test]
    fn every_bit_pattern_comes_back_from_its_physical_value(
        layout in layouts().prop_filter("within double precision", |l| l.size <= 50 && fits(l)),
        bits in any::<u64>(),
        factor in prop_oneof![Just(1.0), Just(-0.25), Just(0.01), Just(5.7e-4), Just(-1e3)],
        offset in prop_oneof![Just(0.0), Just(-67.67), Just(1e3)],
    ) {
        let sign = if layout.signed { '-' } else { '+' };
        let order = u8::from(!layout.motorola);
        let text = format!(
            "BO_ 1 M: {} X\n SG_ s : {}|{}@{order}{sign} ({factor},{offset}) [0|0] \"\" X\n",
            layout.length, layout.start, layout.size
        );
        let database = Database::parse(text.as_bytes(), "layout").unwrap();
        let (_, signal) = database.signal("M.s").unwrap();
        let bits = bits & (u64::MAX >> (64 - layout.size));
        // A bit pattern of few bits is lost in the rounding of a large offset only beyond this.
        prop_assume!(layout.size <= 40 || offset == 0.0);
        prop_assert_eq!(signal.bits_from_physical(signal.physical(bits)), Ok(bits));
    }
}
