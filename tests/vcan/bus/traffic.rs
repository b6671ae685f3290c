//! Frames in and out while the interface is up.

use super::*;

/// A running `candump -L`.
struct Candump(Child, BufReader<std::process::ChildStdout>);

impl Candump {
    /// Starts it and makes sure it listens.
    async fn start(interface: &Interface, sender: &mut SocketCan) -> Self {
        let mut child = Command::new("candump")
            .args(["-L", interface.0])
            .stdout(Stdio::piped())
            .spawn()
            .expect("candump");
        let mut output = BufReader::new(child.stdout.take().unwrap());
        // It says nothing before the first frame; so send, until it writes one.
        let mut first = tokio::task::spawn_blocking(move || {
            let mut line = String::new();
            output.read_line(&mut line).map(|_| output)
        });
        let output = loop {
            send(sender, data(standard(0x7FF), &[])).await;
            match timeout(Duration::from_millis(50), &mut first).await {
                Ok(output) => break output.unwrap().unwrap(),
                Err(_) => continue,
            }
        };
        Self(child, output)
    }

    fn line(&mut self) -> String {
        let mut line = String::new();
        let read = self.1.read_line(&mut line).unwrap();
        assert!(read > 0, "candump has ended");
        line
    }

    /// The next frame with this identifier.
    fn next(&mut self, id: CanId) -> Frame {
        loop {
            let line = std::io::Cursor::new(self.line());
            let frame = Reader::from_read(Box::new(line), "candump").unwrap().next_frame().unwrap();
            if let Some(frame) = frame.filter(|frame| frame.id == id) {
                return frame;
            }
        }
    }
}

impl Drop for Candump {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[tokio::test]
async fn kernel_stamps_are_those_of_candump() {
    let Some(interface) = Interface::new("gt_stamps") else { return };
    let mut bus =
        interface.bus_with(SocketCanConfig { ids: Some(vec![standard(1)]), ..interface.config() }).await;
    let mut sender = interface.bus().await;
    let mut candump = Candump::start(&interface, &mut sender).await;
    // The kernel begins to stamp frames some time after the first socket has asked for it, in a work queue; until then
    // each socket stamps what it reads.
    let begins = async {
        loop {
            send(&mut sender, data(standard(1), &[])).await;
            if next_frame(&mut bus).await == candump.next(standard(1)) {
                break;
            }
            sleep(Duration::from_millis(50)).await;
        }
    };
    timeout(Duration::from_secs(60), begins).await.expect("stamps that are the same");
    for number in 0..50 {
        send(&mut sender, data(standard(1), &[number])).await;
        sleep(Duration::from_millis(2)).await;
    }
    for _ in 0..50 {
        let recorded = candump.next(standard(1));
        assert_eq!(next_frame(&mut bus).await, recorded, "identifier, data and time to the microsecond");
    }
}

#[tokio::test]
async fn classic_and_fd_frames_come_through_one_socket() {
    let Some(interface) = Interface::new("gt_fd") else { return };
    let (mut bus, mut sender) = (interface.bus().await, interface.bus().await);
    let frames = [
        data(standard(0x100), &[1, 2, 3]),
        fd(&[7; 64]),
        data(extended(0x1ABC_DEF0), &[]),
        fd(&[]),
        Frame::remote(Micros(0), standard(0x101), 8).unwrap(),
    ];
    for frame in frames {
        send(&mut sender, frame).await;
        let received = next_frame(&mut bus).await;
        assert!(same(&received, &frame), "{received:?} is not {frame:?}");
        assert!(received.time > Micros::from_seconds(1.6e9), "time of day: {received:?}");
    }
}

#[tokio::test]
async fn fd_frames_are_not_sent_where_they_must_not_be() {
    let Some(interface) = Interface::new("gt_nofd") else { return };
    let mut classic = interface.bus_with(SocketCanConfig { fd: false, ..interface.config() }).await;
    assert_eq!(classic.try_send(&fd(&[1])), Err(SendError::NoFd), "fd = false");
    interface.set("down");
    interface.set("mtu 16");
    interface.set("up");
    let mut bus = interface.bus().await;
    assert_eq!(bus.try_send(&fd(&[1])), Err(SendError::NoFd), "a classic interface");
    assert_eq!(bus.try_send(&data(standard(1), &[1])), Ok(()));
}

#[tokio::test]
async fn the_kernel_passes_only_what_is_wanted() {
    let Some(interface) = Interface::new("gt_filter") else { return };
    let ids = Some(vec![standard(0x123), extended(0x456)]);
    let mut bus = interface.bus_with(SocketCanConfig { ids, ..interface.config() }).await;
    let mut nothing = interface.bus_with(SocketCanConfig { ids: Some(vec![]), ..interface.config() }).await;
    let mut sender = interface.bus().await;
    let remote = Frame::remote(Micros(0), standard(0x123), 4).unwrap();
    let wanted = [data(standard(0x123), &[1]), data(extended(0x456), &[2]), remote];
    for unwanted in [extended(0x123), standard(0x456), standard(0x124), extended(0x1000_0456)] {
        send(&mut sender, data(unwanted, &[9])).await;
    }
    for frame in wanted {
        send(&mut sender, frame).await;
        let received = next_frame(&mut bus).await;
        assert!(same(&received, &frame), "{received:?} is not {frame:?}");
    }
    assert!(timeout(Duration::from_millis(100), nothing.recv()).await.is_err(), "no identifier is wanted");
}

#[tokio::test]
async fn error_frames_are_heard_whatever_the_filters() {
    let Some(interface) = Interface::new("gt_error") else { return };
    let mut bus = interface.bus_with(SocketCanConfig { ids: Some(vec![]), ..interface.config() }).await;
    must("cansend", &format!("{} 20000040#0000000000000000", interface.0));
    must("cansend", &format!("{} 20000204#001000000000087F", interface.0));
    let Event::Error(off) = next(&mut bus).await else { panic!("no error report") };
    assert_eq!((off.class, off.bus_state()), (ErrorClass::BUS_OFF, Some(BusState::Off)));
    let Event::Error(passive) = next(&mut bus).await else { panic!("no error report") };
    assert_eq!((passive.bus_state(), passive.counters()), (Some(BusState::Passive), Some((8, 127))));
    let forged = Frame::new(Micros(0), extended(0x40), FrameKind::Error, &[0; 8]).unwrap();
    assert_eq!(bus.try_send(&forged), Err(SendError::ErrorFrame));
}

#[tokio::test]
async fn own_frames_do_not_come_back_but_others_see_them() {
    let Some(interface) = Interface::new("gt_own") else { return };
    let (mut bus, mut other) = (interface.bus().await, interface.bus().await);
    send(&mut bus, data(standard(1), &[1])).await;
    send(&mut other, data(standard(2), &[2])).await;
    assert_eq!(next_frame(&mut bus).await.id, standard(2));
    assert_eq!(next_frame(&mut other).await.id, standard(1));
}

#[tokio::test]
async fn lost_frames_are_counted() {
    let Some(interface) = Interface::new("gt_drops") else { return };
    let config = SocketCanConfig { receive_buffer: Some(1), ..interface.config() };
    let (mut bus, mut sender) = (interface.bus_with(config).await, interface.bus().await);
    const FLOOD: u32 = 500;
    for number in 0..FLOOD {
        send(&mut sender, data(standard(1), &number.to_be_bytes())).await;
    }
    let (mut received, mut lost) = (0, 0);
    // The kernel tells of a loss with the next frame that it does not lose.
    while received + lost < FLOOD + 1 {
        match timeout(Duration::from_millis(200), bus.recv()).await {
            Ok(Event::Frame(frame)) => {
                received += 1;
                if frame.id == standard(2) {
                    break;
                }
            }
            Ok(Event::Dropped(count)) => lost += count,
            Ok(event) => panic!("{event:?}"),
            Err(_) => send(&mut sender, data(standard(2), &[])).await,
        }
    }
    assert_eq!(received + lost, FLOOD + 1);
    assert!(lost > 100, "only {lost} lost in a buffer of {:?} bytes", bus.receive_buffer());
}

#[tokio::test]
async fn a_larger_receive_buffer_is_one() {
    let Some(interface) = Interface::new("gt_buffer") else { return };
    let size = async |bytes| {
        let config = SocketCanConfig { receive_buffer: bytes, ..interface.config() };
        interface.bus_with(config).await.receive_buffer().unwrap()
    };
    assert!(size(Some(4 << 20)).await > size(None).await);
}

#[tokio::test]
async fn a_full_queue_is_said_to_be_full() {
    let Some(interface) = Interface::new("gt_full") else { return };
    if !run("tc", &format!("qdisc replace dev {} root tbf rate 8kbit burst 100 limit 300", interface.0)) {
        return println!("skipped: no tc, or a kernel without its token bucket filter");
    }
    let mut bus = interface.bus().await;
    let result = (0..1000).find_map(|_| bus.try_send(&data(standard(1), &[0; 8])).err());
    assert_eq!(result, Some(SendError::Busy));
    assert!(timeout(Duration::from_millis(50), bus.recv()).await.is_err(), "that is no news of the link");
}

#[tokio::test]
async fn a_cancelled_receive_loses_nothing() {
    let Some(interface) = Interface::new("gt_cancel") else { return };
    let (mut bus, mut sender) = (interface.bus().await, interface.bus().await);
    const FRAMES: u16 = 300;
    let sending = async {
        for number in 0..FRAMES {
            send(&mut sender, data(standard(1), &number.to_be_bytes())).await;
            tokio::task::yield_now().await;
        }
    };
    let receiving = async {
        let mut expected = 0;
        while expected < FRAMES {
            tokio::select! {
                event = bus.recv() => {
                    let Event::Frame(frame) = event else { panic!("{event:?}") };
                    assert_eq!(frame.data(), expected.to_be_bytes());
                    expected += 1;
                }
                () = tokio::task::yield_now() => {}
            }
        }
    };
    timeout(PATIENCE, async { tokio::join!(sending, receiving) }).await.expect("frames were lost");
}

#[tokio::test]
async fn a_flood_does_not_starve_the_other_tasks() {
    let Some(interface) = Interface::new("gt_flood") else { return };
    let (mut bus, mut sender) = (interface.bus().await, interface.bus().await);
    for _ in 0..2000 {
        send(&mut sender, data(standard(1), &[])).await;
    }
    let mut turns = 0;
    let other = async {
        loop {
            turns += 1;
            tokio::task::yield_now().await;
        }
    };
    let reader = async {
        for _ in 0..2000 {
            next_frame(&mut bus).await;
        }
    };
    tokio::select! { () = reader => {}, () = other => {} }
    assert!(turns > 5, "{turns} turns during 2000 frames");
}
