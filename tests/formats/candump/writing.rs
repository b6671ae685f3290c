//! Lines and files as the writer makes them.

use super::*;

fn line_of(frame: &Frame) -> String {
    let mut text = Vec::new();
    write_line(&mut text, "can0", frame);
    String::from_utf8(text).unwrap()
}

#[test]
fn lines_are_those_of_candump() {
    for line in [
        "(1760000000.000584) can0 123#1122334455667788",
        "(46408.584930) can0 00A#",
        "(0.000000) can0 7FF#AB",
        "(9999999999.999999) can0 18FEF100#0011",
        "(1.000000) can0 123#R",
        "(1.000000) can0 12345678#R8",
        "(1.000000) can0 123##7112233",
        "(1.000000) can0 00000001##4",
        "(1.000000) can0 20000204#0008000000006000",
    ] {
        assert_eq!(line_of(&one(line)), format!("{line}\n"));
    }
    assert_eq!(line_of(&one("(1.0) can0 123##3AA")), "(1.000000) can0 123##7AA\n", "marked as FD");
}

fn any_frame() -> impl Strategy<Value = Frame> {
    let time = -10_i64.pow(12)..10_i64.pow(17);
    let id = prop_oneof![(0..=0x7FF_u32).prop_map(standard), (0..=0x1FFF_FFFF_u32).prop_map(extended)];
    let length =
        prop_oneof![0..=8_usize, Just(12), Just(16), Just(20), Just(24), Just(32), Just(48), Just(64)];
    let bytes = length.prop_flat_map(|length| proptest::collection::vec(any::<u8>(), length));
    (time, id, bytes, 0..4_u8, any::<bool>(), any::<bool>()).prop_map(|(time, id, bytes, kind, brs, esi)| {
        let time = Micros(time);
        let classic = &bytes[..bytes.len().min(8)];
        match kind {
            0 => Frame::data_frame(time, id, classic),
            1 => Frame::remote(time, id, classic.len()),
            2 => Frame::new(time, id, fd(brs, esi), &bytes),
            // An error frame has a class, which is written like an extended identifier.
            _ => Frame::new(time, extended(id.number()), FrameKind::Error, classic),
        }
        .unwrap()
    })
}

proptest! {
    #[test]
    fn what_is_written_is_read_back(frames in proptest::collection::vec(any_frame(), 0..50)) {
        let mut text = Vec::new();
        for frame in &frames {
            write_line(&mut text, "vcan0", frame);
        }
        let (back, stats) = read(text);
        prop_assert_eq!(back, frames);
        prop_assert_eq!(stats.skipped_lines, 0);
    }
}

#[derive(Clone, Default)]
struct Shared(Arc<Mutex<Vec<u8>>>);
impl Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap().write(bytes)
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn frames_of_several_interfaces() {
    let (shared, frame) = (Shared::default(), one("(1.0) x 123#00"));
    let mut writer = Writer::new(shared.clone(), "can0");
    writer.write(&frame).unwrap();
    writer.write_as("can1", &frame).unwrap();
    writer.flush().unwrap();
    assert_eq!(*shared.0.lock().unwrap(), b"(1.000000) can0 123#00\n(1.000000) can1 123#00\n");
    writer.finish().unwrap();
}

fn files_in(folder: &Path) -> Vec<String> {
    let names = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name());
    names.map(|name| name.into_string().unwrap()).collect()
}

#[test]
fn a_file_appears_when_it_is_complete_and_not_before() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.log");
    fs::write(&path, "precious").unwrap();
    let frame = one("(1.0) can0 123#00");

    let mut unfinished = Writer::create(&path, "can0").unwrap();
    unfinished.write(&frame).unwrap();
    unfinished.flush().unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "precious");
    drop(unfinished);
    assert_eq!(fs::read_to_string(&path).unwrap(), "precious");
    assert_eq!(files_in(folder.path()), ["out.log"], "nothing is left lying about");

    let mut writer = Writer::create(&path, "can0").unwrap();
    writer.write(&frame).unwrap();
    writer.finish().unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "(1.000000) can0 123#00\n");
    assert_eq!(files_in(folder.path()), ["out.log"]);
}

#[test]
fn links_are_followed_and_devices_are_not_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let (link, target) = (folder.path().join("latest.log"), folder.path().join("drive.log"));
    fs::write(&target, "").unwrap();
    std::os::unix::fs::symlink("drive.log", &link).unwrap();
    let mut writer = Writer::create(&link, "can0").unwrap();
    writer.write(&one("(1.0) can0 123#00")).unwrap();
    writer.finish().unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(fs::read_to_string(&target).unwrap(), "(1.000000) can0 123#00\n");

    let null = folder.path().join("null");
    std::os::unix::fs::symlink("/dev/null", &null).unwrap();
    Writer::create(&null, "can0").unwrap().finish().unwrap();
    assert!(fs::symlink_metadata("/dev/null").unwrap().file_type().is_char_device());
}

#[test]
fn the_name_says_how_to_pack() {
    let folder = tempfile::tempdir().unwrap();
    for (name, expected) in
        [("a.log.gz", Compression::Gzip), ("a.log.zst", Compression::Zstd), ("a.log", Compression::None)]
    {
        let path = folder.path().join(name);
        let mut writer = Writer::create(&path, "can0").unwrap();
        for _ in 0..1000 {
            writer.write(&one("(1.0) can0 123#00")).unwrap();
        }
        writer.finish().unwrap();
        let mut reader = Reader::open(&path).unwrap();
        while reader.next_frame().unwrap().is_some() {}
        assert_eq!((reader.compression(), reader.stats().frames), (expected, 1000));
    }
}

#[test]
fn where_nothing_can_be_written_the_message_names_the_file() {
    let Err(error) = Writer::create(Path::new("/no/such/folder/out.log"), "can0") else { panic!() };
    assert!(error.to_string().contains("/no/such/folder/out.log"), "{error}");
    assert!(Writer::create(Path::new("/"), "can0").is_err());
}
