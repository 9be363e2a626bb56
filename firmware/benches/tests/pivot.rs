//! A bench with an AS5600 on the pivot and an ADS1015 for the wheel. The simulated bus answers according to the data
//! sheets, fails, reports a wrong magnet, or has another part at the address.

use bench_sensors::{Failed, PivotBench, YourWheel};
use embedded_hal::i2c::{ErrorKind, NoAcknowledgeSource};
use embedded_hal_mock::eh1::i2c::{Mock, Transaction};
use loop_core::{Reading, Sensors};
use sensor_drivers::Ads1015;

const ENCODER: u8 = 0x36;
const CONVERTER: u8 = 0x48;
const STATUS: u8 = 0x0b;
const RAW_ANGLE: u8 = 0x0c;
/// STATUS of a magnet of the right strength.
const MAGNET: u8 = 0x20;
/// Number of readings of the angle between two checks of the magnet.
const CHECK_EVERY: usize = 64;

fn asked(address: u8, register: u8, answer: &[u8]) -> Transaction {
    Transaction::write_read(address, vec![register], answer.to_vec())
}

fn silent(address: u8, register: u8, length: usize) -> Transaction {
    let nobody = ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address);
    asked(address, register, &vec![0; length]).with_error(nobody)
}

fn encoder_begins() -> Transaction {
    asked(ENCODER, STATUS, &[MAGNET])
}

fn converter_begins() -> Vec<Transaction> {
    vec![
        Transaction::write(CONVERTER, vec![0x01, 0x42, 0xc3]),
        asked(CONVERTER, 0x01, &[0xc2, 0xc3]),
    ]
}

fn begin() -> Vec<Transaction> {
    let mut transfers = vec![encoder_begins()];
    transfers.extend(converter_begins());
    transfers
}

fn angle(count: u16) -> Transaction {
    asked(ENCODER, RAW_ANGLE, &count.to_be_bytes())
}

/// 773 counts, as the ADS1015 sends them: at the upper end of the word.
fn wheel() -> Transaction {
    asked(CONVERTER, 0x00, &(773_u16 << 4).to_be_bytes())
}

fn reading(body_count: u16) -> Reading {
    Reading {
        body_count,
        wheel: 773,
        ..Reading::NONE
    }
}

/// Runs `work` with a bench on a bus that expects exactly these transfers.
fn on(transfers: Vec<Transaction>, work: impl FnOnce(&mut PivotBench<Mock, Ads1015>)) {
    let mut bus = Mock::new(&transfers);
    let mut bench = PivotBench::new(bus.clone());
    work(&mut bench);
    bus.done();
}

#[test]
fn both_counts_are_those_of_one_step() {
    let mut transfers = begin();
    transfers.extend([angle(0x0abc), wheel(), angle(0), wheel()]);
    on(transfers, |bench| {
        assert!(bench.is_complete());
        assert_eq!(bench.read(), Ok(reading(0x0abc)));
        assert_eq!(bench.read(), Ok(reading(0)));
    });
}

#[test]
fn a_bus_that_fails_is_a_fault_until_the_part_is_begun_again() {
    let mut transfers = begin();
    transfers.push(silent(ENCODER, RAW_ANGLE, 2));
    // A part that is missing is not asked.
    transfers.push(encoder_begins());
    transfers.extend([angle(5), wheel()]);
    on(transfers, |bench| {
        assert_eq!(bench.read(), Err(Failed));
        assert!(!bench.is_complete());
        assert_eq!(bench.read(), Err(Failed));
        bench.begin();
        assert!(bench.is_complete());
        assert_eq!(bench.read(), Ok(reading(5)));
    });
}

#[test]
fn a_converter_that_is_silent_is_a_fault_too() {
    let mut transfers = begin();
    transfers.extend([angle(5), silent(CONVERTER, 0x00, 2)]);
    on(transfers, |bench| {
        assert_eq!(bench.read(), Err(Failed));
        assert!(!bench.is_complete());
    });
}

#[test]
fn a_magnet_that_is_gone_too_weak_or_too_strong_is_a_fault_within_64_readings() {
    for status in [0x00, 0x30, 0x28] {
        // From the start.
        let mut transfers = vec![asked(ENCODER, STATUS, &[status])];
        transfers.extend(converter_begins());
        on(transfers, |bench| {
            assert!(!bench.is_complete(), "{status:#x}");
            assert_eq!(bench.read(), Err(Failed));
        });
        // While it runs.
        let mut transfers = begin();
        for _ in 1..CHECK_EVERY {
            transfers.extend([angle(256), wheel()]);
        }
        transfers.push(asked(ENCODER, STATUS, &[status]));
        on(transfers, |bench| {
            assert!((1..CHECK_EVERY).all(|_| bench.read() == Ok(reading(256))));
            assert_eq!(bench.read(), Err(Failed), "{status:#x}");
            assert!(!bench.is_complete());
        });
    }
}

#[test]
fn another_part_at_the_encoders_address_is_not_begun() {
    let mut transfers = vec![asked(ENCODER, STATUS, &[0xff])];
    transfers.extend(converter_begins());
    on(transfers, |bench| assert!(!bench.is_complete()));
}

#[test]
fn a_wheel_that_nobody_reads_is_a_fault() {
    let mut bus = Mock::new(&[encoder_begins(), angle(5)]);
    let mut bench = PivotBench::<_, YourWheel>::new(bus.clone());
    assert_eq!(bench.read(), Err(Failed));
    bus.done();
}
