//! Endless, slow, failing and random input.

use super::*;

/// As many bytes as wanted without a newline, and without memory.
fn endless(bytes: u64) -> impl Read + Send {
    io::repeat(b'7').take(bytes)
}

#[test]
fn a_line_of_a_gigabyte_costs_no_memory_and_only_itself() {
    let text = Cursor::new("(1.0) can0 123#00\n")
        .chain(endless(1 << 30))
        .chain(Cursor::new("\n(2.0) can0 124#00\n"));
    let mut reader = Reader::from_read(Box::new(text), "test").unwrap();
    let mut ids = Vec::new();
    while let Some(frame) = reader.next_frame().unwrap() {
        ids.push(frame.id.number());
    }
    assert_eq!(ids, [0x123, 0x124]);
    let stats = reader.stats();
    assert_eq!((stats.lines, stats.skipped_lines), (3, 1));
    assert_eq!((stats.first_skipped[0].line, stats.first_skipped[0].reason), (2, Damage::LongLine));
}

#[test]
fn an_endless_last_line_is_damaged_too() {
    let text = Cursor::new("(1.0) can0 123#00\n").chain(endless(1 << 20));
    let mut reader = Reader::from_read(Box::new(text), "test").unwrap();
    assert!(reader.next_frame().unwrap().is_some());
    assert_eq!(reader.next_frame().unwrap(), None);
    assert_eq!(reader.stats().first_skipped[0].reason, Damage::LongLine);
}

/// Hands out a byte at a time, as a slow pipe may.
struct Trickle(Cursor<Vec<u8>>);
impl Read for Trickle {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = buffer.len().min(1);
        self.0.read(&mut buffer[..count])
    }
}

#[test]
fn frames_come_however_the_bytes_do() {
    let text = "(1.0) can0 123#0011\n\n(2.0) can0 12345678##1AABB\nbad\n(3.0) can0 123#R\n".repeat(20);
    let mut slow = Reader::from_read(Box::new(Trickle(Cursor::new(text.clone().into()))), "test").unwrap();
    let mut frames = Vec::new();
    while let Some(frame) = slow.next_frame().unwrap() {
        frames.push(frame);
    }
    assert_eq!((frames, slow.stats().clone()), read(text));
}

#[test]
fn a_frame_is_delivered_before_more_is_read() {
    /// One line, and then whoever reads on would wait forever.
    struct Live(Option<&'static [u8]>);
    impl Read for Live {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            let line = self.0.take().expect("read on although a line was there");
            let count = line.len().min(buffer.len());
            buffer[..count].copy_from_slice(&line[..count]);
            self.0 = Some(&line[count..]).filter(|rest| !rest.is_empty());
            Ok(count)
        }
    }
    let mut reader = Reader::from_read(Box::new(Live(Some(b"(1.0) can0 123#00\n"))), "test").unwrap();
    assert!(reader.next_frame().unwrap().is_some());
}

#[test]
fn a_source_that_fails_says_where() {
    struct Failing;
    impl Read for Failing {
        fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
            Err(io::Error::from_raw_os_error(5))
        }
    }
    let text = Cursor::new("(1.0) can0 123#00\n(2.0) can0 123#00\n(3.0) can0 123#0").chain(Failing);
    let mut reader = Reader::from_read(Box::new(text), "disk.log").unwrap();
    assert!(reader.next_frame().unwrap().is_some());
    assert!(reader.next_frame().unwrap().is_some());
    let error = reader.next_frame().unwrap_err();
    assert!(matches!(error, LogError::Read { line: 2, .. }), "{error}");
    assert!(error.to_string().starts_with("disk.log: "), "{error}");
    assert_eq!(reader.next_frame().unwrap(), None, "the error comes once");
}

#[test]
fn what_is_no_log_at_all_is_refused_at_once() {
    for (bytes, word) in
        [(&b"LOGG\x90\0\0\0"[..], "BLF"), (b"MDF     4.10", "MDF"), (b"\xFF\xFE(\0", "UTF-16")]
    {
        let Err(error) = Reader::from_read(Box::new(bytes), "x") else { panic!("{word} was taken") };
        assert!(error.to_string().contains(word), "{error}");
    }
    let Err(error) = Reader::open(Path::new("no/such/file.log")) else { panic!() };
    assert!(error.to_string().contains("no/such/file.log"), "{error}");
    assert!(Reader::open(Path::new("/")).is_err(), "a folder");
}

proptest! {
    #[test]
    fn no_bytes_make_it_panic(bytes in proptest::collection::vec(any::<u8>(), 0..4000)) {
        if let Ok(mut reader) = Reader::from_read(Box::new(Cursor::new(bytes)), "x") {
            while let Ok(Some(_)) = reader.next_frame() {}
        }
    }

    #[test]
    fn almost_frames_do_not_make_it_panic(text in r"(\([-0-9.]{0,20}\)? {0,2}[a-z0-9]{0,5} {0,2}[0-9A-F]{0,9}[#R:_.]{0,3}[0-9A-FGR_.:#]{0,140}( [TRX])?\n){0,5}") {
        let (frames, stats) = read(text);
        prop_assert_eq!(stats.lines, stats.frames + stats.skipped_lines + stats.blank_lines + stats.xl_frames);
        prop_assert_eq!(stats.frames, frames.len() as u64);
    }
}
