//! Each driver on a simulated bus that answers according to the data sheet, that fails, that has another part at the
//! address, or whose part gives no new readings.

use embedded_hal::i2c::{ErrorKind, NoAcknowledgeSource};
use embedded_hal_mock::eh1::delay::NoopDelay;
use embedded_hal_mock::eh1::i2c::{Mock, Transaction};
use sensor_drivers::{
    AccelAndField, Ads1015, As5600, Error, Fxas21002, Fxos8700, GyroAndAccel, Mpu6050, STALE_MAX,
};

const NOBODY: ErrorKind = ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address);

fn asked(address: u8, register: u8, answer: &[u8]) -> Transaction {
    Transaction::write_read(address, vec![register], answer.to_vec())
}

fn written(address: u8, bytes: &[u8]) -> Transaction {
    Transaction::write(address, bytes.to_vec())
}

/// Runs `work` on a bus that expects exactly these transfers.
fn on<T>(transfers: Vec<Transaction>, work: impl FnOnce(&mut Mock) -> T) -> T {
    let mut bus = Mock::new(&transfers);
    let result = work(&mut bus);
    bus.done();
    result
}

fn fxas_start() -> Vec<Transaction> {
    vec![
        asked(0x21, 0x0c, &[0xd7]),
        written(0x21, &[0x13, 0x00]),
        written(0x21, &[0x0d, 0x00]),
        written(0x21, &[0x13, 0x02]),
    ]
}

fn fxos_start() -> Vec<Transaction> {
    let mut transfers = vec![asked(0x1f, 0x0d, &[0xc7])];
    for pair in [
        [0x2a, 0x00],
        [0x0e, 0x02],
        [0x2b, 0x02],
        [0x5b, 0x1f],
        [0x5c, 0x20],
        [0x2a, 0x01],
    ] {
        transfers.push(written(0x1f, &pair));
    }
    transfers
}

fn mpu_start() -> Vec<Transaction> {
    let mut transfers = vec![asked(0x68, 0x75, &[0x68])];
    for pair in [
        [0x6b, 0x80],
        [0x6b, 0x01],
        [0x1a, 0x01],
        [0x19, 0x00],
        [0x1b, 0x18],
        [0x1c, 0x10],
        [0x38, 0x01],
    ] {
        transfers.push(written(0x68, &pair));
    }
    transfers
}

fn ads_start() -> Vec<Transaction> {
    vec![
        written(0x48, &[0x01, 0x42, 0xc3]),
        // A conversion is over: OS is set.
        asked(0x48, 0x01, &[0xc2, 0xc3]),
    ]
}

#[test]
fn the_gyroscope_gives_its_words_with_the_high_byte_first() {
    let mut transfers = fxas_start();
    let words = [0x08, 0x01, 0x02, 0xff, 0xfe, 0x80, 0x00];
    transfers.push(asked(0x21, 0x00, &words));
    on(transfers, |bus| {
        let mut gyro = Fxas21002::new(bus, &mut NoopDelay::new()).expect("the part");
        assert_eq!(gyro.read(bus), Ok([0x0102, -2, i16::MIN]));
    });
}

#[test]
fn accelerometer_and_field_come_in_one_transfer() {
    let mut transfers = fxos_start();
    let fresh = [
        0x08, 0x10, 0x00, 0xf0, 0x00, 0x00, 0x04, 0, 1, 0, 2, 0xff, 0xff,
    ];
    let mut stale = fresh;
    stale[0] = 0;
    transfers.push(asked(0x1f, 0x00, &fresh));
    transfers.push(asked(0x1f, 0x00, &stale));
    on(transfers, |bus| {
        let mut part = Fxos8700::new(bus).expect("the part");
        let accel = [0x1000, -0x1000, 4];
        let mag = Some([1, 2, -1]);
        assert_eq!(part.read(bus), Ok(AccelAndField { accel, mag }));
        // The field is given once.
        let mag = None;
        assert_eq!(part.read(bus), Ok(AccelAndField { accel, mag }));
    });
}

#[test]
fn the_temperature_between_the_two_is_left_out() {
    let mut transfers = mpu_start();
    let words = [
        1, 0, 1, 0, 2, 0, 3, 0x77, 0x77, 0xff, 0xff, 0xff, 0xfe, 0x7f, 0xff,
    ];
    transfers.push(asked(0x68, 0x3a, &words));
    on(transfers, |bus| {
        let mut part = Mpu6050::new(bus, &mut NoopDelay::new()).expect("the part");
        let expected = GyroAndAccel {
            gyro: [-1, -2, i16::MAX],
            accel: [1, 2, 3],
        };
        assert_eq!(part.read(bus), Ok(expected));
    });
}

#[test]
fn the_converter_gives_twelve_bits_and_nothing_below_ground() {
    let mut transfers = ads_start();
    for (bytes, _) in [
        ([0x60, 0xa0], 1546),
        ([0x7f, 0xf0], 2047),
        ([0xff, 0xf0], 0),
    ] {
        transfers.push(asked(0x48, 0x00, &bytes));
    }
    on(transfers, |bus| {
        let mut part = Ads1015::new(bus).expect("the part");
        assert_eq!(
            [(); 3].map(|()| part.read(bus)),
            [Ok(1546), Ok(2047), Ok(0)]
        );
    });
}

#[test]
fn the_encoder_gives_twelve_bits() {
    let transfers = vec![asked(0x36, 0x0b, &[0x20]), asked(0x36, 0x0c, &[0xfa, 0xbc])];
    on(transfers, |bus| {
        let mut part = As5600::new(bus).expect("the part");
        assert_eq!(part.read(bus), Ok(0x0abc));
    });
}

#[test]
fn a_bus_that_fails_is_reported() {
    let fails = |address, register, length: usize| {
        asked(address, register, &vec![0; length]).with_error(NOBODY)
    };
    let delay = &mut NoopDelay::new();
    on(vec![fails(0x21, 0x0c, 1)], |bus| {
        assert_eq!(Fxas21002::new(bus, delay).err(), Some(Error::Bus(NOBODY)));
    });
    on(vec![fails(0x1f, 0x0d, 1)], |bus| {
        assert_eq!(Fxos8700::new(bus).err(), Some(Error::Bus(NOBODY)));
    });
    on(vec![fails(0x68, 0x75, 1)], |bus| {
        assert_eq!(Mpu6050::new(bus, delay).err(), Some(Error::Bus(NOBODY)));
    });
    on(vec![fails(0x36, 0x0b, 1)], |bus| {
        assert_eq!(As5600::new(bus).err(), Some(Error::Bus(NOBODY)));
    });
    let write_fails = written(0x48, &[0x01, 0x42, 0xc3]).with_error(NOBODY);
    on(vec![write_fails], |bus| {
        assert_eq!(Ads1015::new(bus).err(), Some(Error::Bus(NOBODY)));
    });
    // While it runs: the reading after the failed one is right again.
    let mut transfers = fxas_start();
    transfers.push(fails(0x21, 0x00, 7));
    transfers.push(asked(0x21, 0x00, &[8, 0, 1, 0, 2, 0, 3]));
    on(transfers, |bus| {
        let mut gyro = Fxas21002::new(bus, delay).expect("the part");
        assert_eq!(gyro.read(bus), Err(Error::Bus(NOBODY)));
        assert_eq!(gyro.read(bus), Ok([1, 2, 3]));
    });
}

#[test]
fn another_part_at_the_address_is_named() {
    let delay = &mut NoopDelay::new();
    let wrong = |found, expected| Some(Error::WrongDevice { found, expected });
    // FXAS21000, the older gyroscope.
    on(vec![asked(0x21, 0x0c, &[0xd1])], |bus| {
        assert_eq!(Fxas21002::new(bus, delay).err(), wrong(0xd1, 0xd7));
    });
    on(vec![asked(0x1f, 0x0d, &[0x00])], |bus| {
        assert_eq!(Fxos8700::new(bus).err(), wrong(0x00, 0xc7));
    });
    // MPU-9250.
    on(vec![asked(0x68, 0x75, &[0x71])], |bus| {
        assert_eq!(Mpu6050::new(bus, delay).err(), wrong(0x71, 0x68));
    });
    let transfers = vec![
        written(0x48, &[0x01, 0x42, 0xc3]),
        asked(0x48, 0x01, &[0x85, 0x83]),
    ];
    on(transfers, |bus| {
        assert_eq!(Ads1015::new(bus).err(), wrong(0x0583, 0x42c3));
    });
    on(vec![asked(0x36, 0x0b, &[0xff])], |bus| {
        assert_eq!(As5600::new(bus).err(), wrong(0xff, 0x20));
    });
}

#[test]
fn a_part_that_does_not_measure_any_more_is_stuck() {
    let stale = usize::from(STALE_MAX);
    let mut transfers = fxas_start();
    transfers.extend(vec![asked(0x21, 0x00, &[0, 0, 1, 0, 2, 0, 3]); stale]);
    transfers.push(asked(0x21, 0x00, &[8, 0, 1, 0, 2, 0, 4]));
    on(transfers, |bus| {
        let mut gyro = Fxas21002::new(bus, &mut NoopDelay::new()).expect("the part");
        for _ in 1..stale {
            assert_eq!(gyro.read(bus), Ok([1, 2, 3]));
        }
        assert_eq!(gyro.read(bus), Err(Error::Stuck));
        assert_eq!(gyro.read(bus), Ok([1, 2, 4]));
    });
    let mut transfers = fxos_start();
    transfers.extend(vec![asked(0x1f, 0x00, &[0; 13]); stale]);
    on(transfers, |bus| {
        let mut part = Fxos8700::new(bus).expect("the part");
        let last = (0..stale).map(|_| part.read(bus)).last();
        assert_eq!(last, Some(Err(Error::Stuck)));
    });
    let mut transfers = mpu_start();
    transfers.extend(vec![asked(0x68, 0x3a, &[0; 15]); stale]);
    on(transfers, |bus| {
        let mut part = Mpu6050::new(bus, &mut NoopDelay::new()).expect("the part");
        let last = (0..stale).map(|_| part.read(bus)).last();
        assert_eq!(last, Some(Err(Error::Stuck)));
    });
}

#[test]
fn a_converter_that_was_reset_and_an_encoder_that_lost_its_magnet_are_seen() {
    let mut transfers = ads_start();
    transfers.extend(vec![asked(0x48, 0x00, &[0x10, 0x00]); 63]);
    transfers.push(asked(0x48, 0x01, &[0x85, 0x83]));
    on(transfers, |bus| {
        let mut part = Ads1015::new(bus).expect("the part");
        assert!((0..63).all(|_| part.read(bus) == Ok(256)));
        assert_eq!(part.read(bus), Err(Error::Stuck));
    });
    let mut transfers = vec![asked(0x36, 0x0b, &[0x20])];
    transfers.extend(vec![asked(0x36, 0x0c, &[0x01, 0x00]); 63]);
    // ML: too weak.
    transfers.push(asked(0x36, 0x0b, &[0x30]));
    on(transfers, |bus| {
        let mut part = As5600::new(bus).expect("the part");
        assert!((0..63).all(|_| part.read(bus) == Ok(256)));
        assert_eq!(part.read(bus), Err(Error::Magnet(0x30)));
    });
    on(vec![asked(0x36, 0x0b, &[0x00])], |bus| {
        assert_eq!(As5600::new(bus).err(), Some(Error::Magnet(0)));
    });
}
