//! Times of day and dates as cells of a time column: `14:30:00.005`, `2024-03-05T14:30:00.005Z`, `05.03.2024 14:30:00,005`,
//! `2:30:00.5 PM`, and the minutes and seconds that spreadsheets show, `30:00.5`.

/// Seconds of a day.
const DAY_S: f64 = 86_400.0;

/// A time of day as seconds since midnight; with a date whose order is certain, as seconds since 1970-01-01. A date with
/// slashes (5/3 or 3/5?) is left out: within one day it tells nothing, and a log over midnight then goes backwards, which
/// is reported. Zones are left out, since they are the same on every line.
pub(crate) fn clock(cell: &str) -> Option<f64> {
    let cell = cell.trim();
    // Every such cell has a colon, and most cells have none.
    if !cell.contains(':') || !cell.is_ascii() {
        return None;
    }
    let (cell, noon_s) = match cell.rsplit_once(' ') {
        Some((rest, "AM" | "am")) => (rest, Some(0.0)),
        Some((rest, "PM" | "pm")) => (rest, Some(0.5 * DAY_S)),
        _ => (cell, None),
    };
    let (date, time) = match cell.split_once([' ', 'T']) {
        Some((date, time)) => (Some(date), time.trim()),
        None => (None, cell),
    };
    let days = match date {
        None => 0.0,
        Some(date) => days(date)?,
    };
    let mut seconds = time_of_day(without_zone(time))?;
    if let Some(noon_s) = noon_s {
        // Twelve o'clock is the first hour of its half day.
        seconds = noon_s + seconds % (0.5 * DAY_S);
    }
    Some(DAY_S * days + seconds)
}

fn without_zone(time: &str) -> &str {
    let time = time.strip_suffix('Z').unwrap_or(time);
    match time.rfind(['+', '-']) {
        Some(at) => &time[..at],
        None => time,
    }
}

/// `hh:mm:ss` with or without decimals, or `mm:ss` with decimals.
fn time_of_day(text: &str) -> Option<f64> {
    let mut parts: Vec<&str> = text.split(':').collect();
    let last = parts.pop()?.replacen(',', ".", 1);
    let has_decimals = last.contains('.');
    let digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit()) && !text.is_empty();
    let whole = last.split('.').next().unwrap_or("");
    if !digits(whole) || whole.len() != 2 || !digits(&last.replacen('.', "", 1)) {
        return None;
    }
    let seconds: f64 = last.parse().ok()?;
    let number = |text: &str| -> Option<f64> {
        (digits(text) && text.len() <= 2)
            .then(|| text.parse().ok())
            .flatten()
    };
    let (hours, minutes) = match parts[..] {
        [hours, minutes] if minutes.len() == 2 => (number(hours)?, number(minutes)?),
        [minutes] if has_decimals => (0.0, number(minutes)?),
        _ => return None,
    };
    let is_one = hours < 24.0 && minutes < 60.0 && seconds < 61.0;
    is_one.then_some(3600.0 * hours + 60.0 * minutes + seconds)
}

/// Days since 1970-01-01 of `2024-03-05`, `2024/03/05` or `05.03.2024`; 0 for a date with two readings.
fn days(date: &str) -> Option<f64> {
    let mark = date.chars().find(|c| !c.is_ascii_digit())?;
    let parts: Vec<i64> = date
        .split(mark)
        .map(|part| part.parse().ok())
        .collect::<Option<Vec<i64>>>()?;
    let [first, second, third] = parts[..] else {
        return None;
    };
    let (year, month, day) = match mark {
        '-' | '/' if first > 31 => (first, second, third),
        '.' => (third, second, first),
        '-' | '/' => return Some(0.0),
        _ => return None,
    };
    if !(1..=12).contains(&month) || !(1..=31).contains(&day) || !(1970..=2999).contains(&year) {
        return None;
    }
    // The day count of the proleptic Gregorian calendar with years that begin in March (Richards, in: Explanatory
    // Supplement to the Astronomical Almanac, 2013).
    let (y, m) = if month > 2 {
        (year, month - 3)
    } else {
        (year - 1, month + 9)
    };
    let day_count = 365 * y + y / 4 - y / 100 + y / 400 + (153 * m + 2) / 5 + day - 1;
    Some((day_count - 719_468) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_and_dates_are_seconds() {
        for (cell, expected) in [
            ("14:30:00.005", 52_200.005),
            ("14:30:00,005", 52_200.005),
            ("0:00:01", 1.0),
            ("30:00.5", 1800.5),
            ("2:30:00.5 PM", 52_200.5),
            ("12:00:00.0 AM", 0.0),
            ("1970-01-02T00:00:00Z", 86_400.0),
            ("2000-03-01 00:00:00", 951_868_800.0),
            ("2024-03-05T14:30:00.5+01:00", 1_709_649_000.5),
            ("05.03.2024 14:30:00.500", 1_709_649_000.5),
            ("3/5/2024 14:30:00", 52_200.0),
        ] {
            let found = clock(cell).unwrap_or_else(|| panic!("{cell}"));
            assert!((found - expected).abs() < 1e-6, "{cell}: {found}");
        }
        for cell in [
            "14:30",
            "12:60:00",
            "25:00:00",
            "1:2:3",
            "a:00:00",
            "::",
            "",
            "12:34:5x",
            "45.8",
            "05.13.2024 00:00:00",
            "angle:45.8",
        ] {
            assert_eq!(clock(cell), None, "{cell}");
        }
    }
}
