//! Number formats of documents: times, amounts and fitted numbers.

use crate::units::{MINUTES_PER_HOUR, SECONDS_PER_HOUR, SECONDS_PER_MINUTE};

/// Significant digits of fitted numbers in forms and documents.
pub(super) const FITTED_DIGITS: usize = 5;
/// Separator of thousands: a narrow space, which no language reads as a decimal sign.
const THOUSANDS_SEPARATOR: char = '\u{202f}';

/// Formats a time (s) as h:mm:ss, below a minute with tenths.
pub fn clock(seconds: f64) -> String {
    let tenths = (10.0 * seconds.max(0.0)).round() / 10.0;
    if tenths < SECONDS_PER_MINUTE {
        return format!("0:00:{tenths:04.1}");
    }
    let whole = seconds.round();
    let minutes = (whole / SECONDS_PER_MINUTE).floor() % MINUTES_PER_HOUR;
    format!("{:.0}:{minutes:02.0}:{:02.0}", (whole / SECONDS_PER_HOUR).floor(), whole % SECONDS_PER_MINUTE)
}

/// Formats an amount with a number of decimals and its thousands separated.
pub fn grouped(amount: f64, decimals: u32) -> String {
    let written = format!("{:.*}", decimals as usize, amount.abs());
    let (whole, rest) = written.split_at(written.find('.').unwrap_or(written.len()));
    let is_nothing = written.chars().all(|digit| matches!(digit, '0' | '.'));
    let mut text = String::from(if amount < 0.0 && !is_nothing { "−" } else { "" });
    for (index, digit) in whole.chars().enumerate() {
        if 0 < index && (whole.len() - index).is_multiple_of(3) {
            text.push(THOUSANDS_SEPARATOR);
        }
        text.push(digit);
    }
    text + rest
}

/// Formats a number with at most five digits, without trailing zeros.
pub(super) fn as_short(value: f64) -> String {
    significant(value, FITTED_DIGITS).to_string().replace('-', "−")
}

/// Formats a number with the decimals of a deviation with two digits.
pub(super) fn to_the_digits_of(value: f64, deviation: f64) -> String {
    if 0.0 < deviation && deviation.is_finite() {
        let decimals = (1.0 - deviation.log10().floor()).clamp(0.0, 9.0) as usize;
        format!("{value:.decimals$}").replace('-', "−")
    } else {
        as_short(value)
    }
}

/// Rounds a number to `digits` significant digits.
pub(super) fn significant(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits - 1).parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_hours_minutes_and_seconds() {
        let times = [0.0, 8.44, 59.94, 59.96, 60.4, 3599.6, 4447.5, 360_000.0];
        let written = times.map(clock);
        let expected =
            ["0:00:00.0", "0:00:08.4", "0:00:59.9", "0:01:00", "0:01:00", "1:00:00", "1:14:08", "100:00:00"];
        assert_eq!(written, expected);
    }

    #[test]
    fn thousands_are_set_apart_and_nothing_has_no_sign() {
        assert_eq!(grouped(105_010.0, 2), "105\u{202f}010.00");
        assert_eq!(grouped(999.999, 2), "1\u{202f}000.00");
        assert_eq!(grouped(1_234_567.0, 0), "1\u{202f}234\u{202f}567");
        assert_eq!(grouped(-12.5, 1), "−12.5");
        assert_eq!((grouped(-0.001, 2).as_str(), grouped(7.0, 0).as_str()), ("0.00", "7"));
    }

    #[test]
    fn numbers_have_the_digits_their_deviation_means() {
        assert_eq!(to_the_digits_of(0.0213456, 0.00012), "0.02135");
        assert_eq!(to_the_digits_of(12345.678, 230.0), "12346");
        assert_eq!(to_the_digits_of(2.0, 0.0), "2");
        assert_eq!(as_short(0.025500000000000002), "0.0255");
        assert_eq!(significant(11999.7, 5), 12000.0);
    }
}
