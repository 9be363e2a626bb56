//! Frames on a line that loses, changes and inserts bytes.

use proptest::prelude::*;
use serial_frame::{
    Command, FRAME_BYTES_MAX, Receiver, Refusal, TELEMETRY_BYTES, Task, Telemetry, crc16,
};

fn telemetry() -> impl Strategy<Value = Telemetry> {
    let inertial = (
        any::<[i16; 3]>(),
        any::<[i16; 3]>(),
        proptest::option::of(any::<[i16; 3]>().prop_filter("means none", |a| *a != [i16::MIN; 3])),
    );
    let rest = (any::<(u8, u16, u32, u16, u16)>(), any::<[i32; 3]>());
    (inertial, rest).prop_map(|((gyro, accel, mag), (heads, words))| {
        let (status, sequence, time_us, wheel, duty) = heads;
        let [angle, rate, wheel_speed] = words;
        Telemetry {
            status,
            sequence,
            time_us,
            gyro,
            accel,
            mag,
            wheel,
            duty,
            angle,
            rate,
            wheel_speed,
        }
    })
}

fn command() -> impl Strategy<Value = Command> {
    let task = prop_oneof![
        Just(Task::Watch),
        Just(Task::Balance),
        any::<i32>().prop_map(|current_ua| Task::Drive { current_ua }),
    ];
    (task, any::<(u8, u8, u16)>()).prop_map(|(task, (wish, every, lease_ms))| Command {
        task,
        wish,
        every,
        lease_ms,
    })
}

/// All messages and refusals that a receiver gives for these bytes.
fn received(bytes: impl IntoIterator<Item = u8>) -> Vec<Result<Telemetry, Refusal>> {
    let mut receiver = Receiver::new();
    bytes
        .into_iter()
        .filter_map(|byte| receiver.telemetry(byte))
        .collect()
}

/// The check value of the catalogue of parametrised CRC algorithms (R. Cook), CRC-16/IBM-3740.
#[test]
fn the_crc_is_ccitt_false() {
    assert_eq!(crc16(b"123456789"), 0x29b1);
    assert_eq!(crc16(&[]), 0xffff);
}

/// The layout, byte by byte, from the contract; COBS undone by hand.
#[test]
fn a_frame_has_the_stated_layout() {
    let sent = Telemetry {
        status: 2,
        sequence: 0x0403,
        time_us: 0x0807_0605,
        gyro: [0x0a09, 0x0c0b, 0x0e0d],
        accel: [0x100f, 0x1211, -2],
        mag: None,
        wheel: 0x2221,
        duty: 0x2423,
        angle: 0x2827_2625,
        rate: -1,
        wheel_speed: 0x302f_2e2d,
    };
    let mut message = vec![1, 2, 3, 4, 5, 6, 7, 8];
    message.extend([0x09, 0x0a, 0x0b, 0x0c, 0x0d, 0x0e]);
    message.extend([0x0f, 0x10, 0x11, 0x12, 0xfe, 0xff]);
    message.extend([0x00, 0x80, 0x00, 0x80, 0x00, 0x80]);
    message.extend([0x21, 0x22, 0x23, 0x24, 0x25, 0x26, 0x27, 0x28]);
    message.extend([0xff, 0xff, 0xff, 0xff, 0x2d, 0x2e, 0x2f, 0x30]);
    let crc = crc16(&message);
    message.extend(crc.to_le_bytes());
    assert_eq!(message.len(), TELEMETRY_BYTES);
    // Each zero becomes the distance to the next one; the first byte is the distance to the first.
    let mut stuffed = vec![0];
    let mut last_zero = 0;
    for byte in message {
        stuffed.push(byte);
        if byte == 0 {
            stuffed[last_zero] = (stuffed.len() - 1 - last_zero) as u8;
            last_zero = stuffed.len() - 1;
        }
    }
    stuffed[last_zero] = (stuffed.len() - last_zero) as u8;
    stuffed.push(0);
    assert_eq!(sent.frame().bytes(), stuffed);
}

#[test]
fn what_is_no_message_is_named() {
    let command = Command {
        task: Task::Balance,
        wish: 1,
        every: 1,
        lease_ms: 500,
    };
    // A whole frame of the other direction.
    assert_eq!(
        received(command.frame().bytes().to_vec()),
        [Err(Refusal::Unknown)]
    );
    let endless = vec![7; 10 * FRAME_BYTES_MAX];
    assert_eq!(
        received(endless.into_iter().chain([0])),
        [Err(Refusal::TooLong)]
    );
    assert_eq!(received([0, 0, 0]), []);
    assert_eq!(received([1, 0]), [Err(Refusal::Damaged)]);
}

proptest! {
    #[test]
    fn telemetry_comes_back(sent in telemetry()) {
        let frame = sent.frame();
        prop_assert!(frame.bytes().len() <= FRAME_BYTES_MAX);
        let zeros = frame.bytes().iter().filter(|byte| **byte == 0).count();
        prop_assert_eq!(zeros, 1);
        prop_assert_eq!(received(frame.bytes().to_vec()), [Ok(sent)]);
    }

    #[test]
    fn commands_come_back(sent in command()) {
        let mut receiver = Receiver::new();
        let got: Vec<_> = sent
            .frame()
            .bytes()
            .iter()
            .filter_map(|byte| receiver.command(*byte))
            .collect();
        prop_assert_eq!(got, [Ok(sent)]);
    }

    /// Bytes are lost, changed or inserted at one place. All other frames arrive in order, and no frame arrives that
    /// was not sent. One burst of errors destroys at most the frames that it touches and the frame after them.
    #[test]
    fn the_line_is_right_again_after_a_burst(
        sent in prop::collection::vec(telemetry(), 4..12),
        at in any::<prop::sample::Index>(),
        lost in 0_usize..60,
        put_in in prop::collection::vec(any::<u8>(), 0..4),
    ) {
        let frames: Vec<Vec<u8>> = sent.iter().map(|one| one.frame().bytes().to_vec()).collect();
        let whole: Vec<u8> = frames.concat();
        let from = at.index(whole.len());
        let to = (from + lost).min(whole.len());
        let mut line = whole.clone();
        line.splice(from..to, put_in);
        let got: Vec<Telemetry> = received(line).into_iter().filter_map(Result::ok).collect();

        let mut begin = 0;
        let mut untouched = Vec::new();
        let mut is_after = false;
        for (one, frame) in sent.iter().zip(&frames) {
            let end = begin + frame.len();
            if end <= from {
                untouched.push(*one);
            } else if begin >= to {
                // The frame that follows the burst may have lost the zero before it.
                if is_after {
                    untouched.push(*one);
                }
                is_after = true;
            }
            begin = end;
        }
        let mut rest = got.iter();
        prop_assert!(untouched.iter().all(|one| rest.any(|other| other == one)), "{got:?}");
        prop_assert!(got.iter().all(|one| sent.contains(one)), "{got:?}");
    }

    #[test]
    fn noise_is_no_message(noise in prop::collection::vec(any::<u8>(), 0..2000)) {
        // By chance one in 65 536 of the frames of the right length passes the CRC; among so few none
        // has the right length, version and CRC.
        prop_assert!(received(noise).iter().all(Result::is_err));
    }
}
