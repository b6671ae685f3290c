//! The interface on bad days: down, gone, not there yet, not CAN.

use super::*;

#[tokio::test]
async fn a_link_that_goes_down_and_up_is_noticed_while_waiting() {
    let Some(interface) = Interface::new("gt_down") else { return };
    let mut bus = interface.bus().await;
    let down = async {
        sleep(Duration::from_millis(50)).await;
        interface.set("down");
    };
    assert_eq!(tokio::join!(next(&mut bus), down).0, Event::Down);
    assert_eq!(bus.try_send(&data(standard(1), &[])), Err(SendError::Down));
    assert!(timeout(Duration::from_millis(300), bus.recv()).await.is_err(), "down is said once");
    interface.set("up");
    assert_eq!(next(&mut bus).await, Event::Up);
    let mut sender = interface.bus().await;
    send(&mut sender, data(standard(1), &[1])).await;
    assert_eq!(next_frame(&mut bus).await.id, standard(1), "the same socket works again");
}

#[tokio::test]
async fn frames_that_waited_while_the_link_went_down_come_and_do_not_say_that_it_is_up() {
    let Some(interface) = Interface::new("gt_queued") else { return };
    let mut bus = interface.bus().await;
    let mut sender = interface.bus().await;
    for number in 1..=3 {
        send(&mut sender, data(standard(number), &[])).await;
    }
    interface.set("down");
    assert_eq!(next(&mut bus).await, Event::Down);
    for number in 1..=3 {
        assert_eq!(next_frame(&mut bus).await.id, standard(number));
    }
    assert!(timeout(Duration::from_millis(300), bus.recv()).await.is_err(), "still down");
    interface.set("up");
    assert_eq!(next(&mut bus).await, Event::Up);
}

#[tokio::test]
async fn a_send_that_meets_the_dead_link_first_does_not_hide_it_from_the_reader() {
    let Some(interface) = Interface::new("gt_eaten") else { return };
    let mut bus = interface.bus().await;
    interface.set("down");
    assert_eq!(bus.try_send(&data(standard(1), &[])), Err(SendError::Down));
    assert_eq!(next(&mut bus).await, Event::Down);
    interface.remove();
    assert_eq!(next(&mut bus).await, Event::Gone);
    assert_eq!(bus.try_send(&data(standard(1), &[])), Err(SendError::Gone));
}

#[tokio::test]
async fn an_interface_that_is_removed_and_made_again_is_picked_up_with_its_filters() {
    let Some(interface) = Interface::new("gt_gone") else { return };
    let ids = Some(vec![standard(5)]);
    let mut bus = interface.bus_with(SocketCanConfig { ids, ..interface.config() }).await;
    let before = interface.index();
    let remove = async {
        sleep(Duration::from_millis(50)).await;
        interface.remove();
    };
    assert_eq!(tokio::join!(next(&mut bus), remove).0, Event::Gone);
    assert_eq!(bus.try_send(&data(standard(1), &[])), Err(SendError::Gone));
    assert!(timeout(Duration::from_millis(200), bus.recv()).await.is_err(), "gone is said once");
    assert!(Interface::create(interface.0));
    assert_ne!(interface.index(), before);
    assert_eq!(next(&mut bus).await, Event::Up);
    let mut sender = interface.bus().await;
    send(&mut sender, data(standard(4), &[])).await;
    send(&mut sender, data(standard(5), &[])).await;
    assert_eq!(next_frame(&mut bus).await.id, standard(5), "4 is still filtered out");
    send(&mut bus, data(standard(6), &[])).await;
    assert_eq!(next_frame(&mut sender).await.id, standard(6));
}

#[tokio::test]
async fn an_interface_that_is_not_there_yet_is_waited_for() {
    let Some(interface) = Interface::new("gt_late") else { return };
    interface.remove();
    let mut bus = SocketCan::open(interface.config()).unwrap();
    assert_eq!(next(&mut bus).await, Event::Gone);
    must("ip", &format!("link add dev {} type vcan", interface.0));
    assert_eq!(next(&mut bus).await, Event::Down);
    interface.set("up");
    assert_eq!(next(&mut bus).await, Event::Up);
}

#[tokio::test]
async fn waiting_is_idle_whatever_the_state_of_the_link() {
    let Some(interface) = Interface::new("gt_idle") else { return };
    for (state, event) in [("up", Event::Up), ("down", Event::Down), ("gone", Event::Gone)] {
        if state == "gone" {
            interface.remove()
        } else {
            interface.set(state)
        }
        let mut bus = SocketCan::open(interface.config()).unwrap();
        assert_eq!(next(&mut bus).await, event);
        let mut polls = 0;
        let mut waiting = pin!(bus.recv());
        let counted = std::future::poll_fn(|context| {
            polls += 1;
            waiting.as_mut().poll(context)
        });
        assert!(timeout(Duration::from_secs(1), counted).await.is_err());
        assert!(polls < 50, "{polls} wake-ups in a second while {state}");
    }
}

#[tokio::test]
async fn what_is_no_can_interface_is_refused() {
    if Interface::new("gt_kind").is_none() {
        return;
    }
    let loopback = SocketCanConfig::new("lo".parse().unwrap());
    assert!(matches!(SocketCan::open(loopback), Err(OpenError::NotCan(_))));
}

#[tokio::test]
async fn an_interface_comes_back_however_often_waiting_for_it_is_cut_short() {
    let Some(interface) = Interface::new("gt_cut") else { return };
    let mut bus = interface.bus().await;
    for (away, back) in [("down", Event::Down), ("gone", Event::Gone)] {
        if away == "down" {
            interface.set("down")
        } else {
            interface.remove()
        }
        assert_eq!(next(&mut bus).await, back);
        if away == "down" {
            interface.set("up");
        } else {
            assert!(Interface::create(interface.0));
        }
        // As beside a busy bus in `select!`: each wait is far shorter than the pause between two looks.
        let found = timeout(PATIENCE, async {
            loop {
                if let Ok(event) = timeout(Duration::from_millis(2), bus.recv()).await {
                    return event;
                }
            }
        });
        assert_eq!(found.await, Ok(Event::Up), "{away}");
    }
}
