//! Decimal numbers of G-code words.
//!
//! The value is the f64 nearest to the written number. If all digits form the integer d and k of them are decimals,
//! d / 10^k is correctly rounded for d < 2^53 and k ≤ 22, since d and 10^k are exact. Truefeed divides up to 15
//! digits; the standard library reads longer numbers, which are rare in programs.

/// A number found in a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Number {
    /// Its value; infinite if it is beyond f64.
    pub(super) value: f64,
    /// `true` if it is written with a decimal point.
    pub(super) has_point: bool,
    /// One past its last digit or point.
    pub(super) end: usize,
}

/// The powers of ten that are exact in f64.
const EXACT_POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18,
    1e19, 1e20, 1e21, 1e22,
];

/// Largest deviation of a value from the whole number that it means; it may be the result of a formula.
const MAX_WHOLE_DEVIATION: f64 = 1e-4;
/// Largest whole number that names something: a code, a tool, a label or a program.
const MAX_WHOLE: f64 = 1e9;

/// Returns the whole number that a value means; `None` if the value is negative, too large, or 0.0001 or more from
/// the nearest integer. Source: RS274/NGC version 3, Sect. 3.3.2.1.
pub fn whole_number(value: f64) -> Option<u32> {
    nearest_whole(value).filter(|whole| (0.0..=MAX_WHOLE).contains(whole)).map(|whole| whole as u32)
}

/// Returns the whole number of any size that a value means; `None` if the value is 0.0001 or more from the
/// nearest integer.
pub fn nearest_whole(value: f64) -> Option<f64> {
    let whole = value.round();
    ((value - whole).abs() < MAX_WHOLE_DEVIATION).then_some(whole)
}

/// Returns `true` for space, tab and the control characters of paper tape and serial lines.
pub(super) fn is_blank(byte: u8) -> bool {
    byte <= b' '
}

/// Returns the index of the first byte from `at` on that is not blank.
pub(super) fn skip_blanks(text: &[u8], at: usize) -> usize {
    let rest = text.get(at..).unwrap_or_default();
    rest.iter().position(|byte| !is_blank(*byte)).map_or(text.len(), |offset| at + offset)
}

/// Returns the number that begins at `at`; `None` if there is no digit.
pub(super) fn number(text: &[u8], at: usize) -> Option<Number> {
    let start = skip_blanks(text, at);
    let negative = text.get(start) == Some(&b'-');
    let mut next = start + usize::from(negative || text.get(start) == Some(&b'+'));
    let mut end = next;
    let (mut digits, mut count, mut decimals, mut has_point) = (0_u64, 0_usize, 0_usize, false);
    while let Some(&byte) = text.get(next) {
        match byte {
            b'0'..=b'9' => {
                digits = digits.wrapping_mul(10).wrapping_add(u64::from(byte - b'0'));
                count += 1;
                decimals += usize::from(has_point);
            }
            b'.' if !has_point => has_point = true,
            byte if is_blank(byte) => {
                next += 1;
                continue;
            }
            _ => break,
        }
        next += 1;
        end = next;
    }
    if count == 0 {
        return None;
    }
    // 15 digits are less than 2^53, and the product cannot have wrapped.
    let value = if count <= 15 {
        let magnitude = digits as f64 / EXACT_POWERS[decimals];
        if negative { -magnitude } else { magnitude }
    } else {
        let written = text[start..end].iter().filter(|byte| !is_blank(**byte)).map(|byte| *byte as char);
        written.collect::<String>().parse().ok()?
    };
    Some(Number { value, has_point, end })
}

/// Number of bytes after its sign that hold a plain number and the byte behind it.
const PLAIN_NUMBER_BYTES: usize = 15;

/// Returns the number that begins at `at` if it has no blanks, fewer than 15 bytes after its sign, and text behind
/// it; else `None`. The result equals that of [`number`] unless more of a number follows.
#[inline]
pub(super) fn plain_number(text: &[u8], at: usize) -> Option<Number> {
    let rest = text.get(at..)?;
    let sign = *rest.first()?;
    let is_negative = sign == b'-';
    let first = usize::from(is_negative || sign == b'+');
    let signs = rest.get(first..)?.first_chunk::<PLAIN_NUMBER_BYTES>()?;
    let (mut value, mut past_point) = (0_u64, None);
    for (index, &sign) in signs.iter().enumerate() {
        let digit = sign.wrapping_sub(b'0');
        if digit <= 9 {
            value = value.wrapping_mul(10).wrapping_add(u64::from(digit));
        } else if sign == b'.' && past_point.is_none() {
            past_point = Some(index + 1);
        } else {
            let decimals = past_point.map_or(0, |past| index - past);
            let has_point = past_point.is_some();
            if index == usize::from(has_point) {
                return None;
            }
            // These few digits fit a signed integer, which processors convert to f64 in one step.
            let magnitude = value as i64 as f64 / EXACT_POWERS[decimals];
            let value = if is_negative { -magnitude } else { magnitude };
            return Some(Number { value, has_point, end: at + first + index });
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_whole_number_may_be_the_result_of_a_formula() {
        let third = 1.0 / 3.0;
        assert_eq!(whole_number(3.0 * third + 6.0 * third), Some(3));
        assert_eq!([2.99995, -0.00005, 1e9].map(whole_number), [Some(3), Some(0), Some(1_000_000_000)]);
        assert_eq!([2.9998, -1.0, 1.1e9, f64::NAN, f64::INFINITY].map(whole_number), [None; 5]);
    }

    #[test]
    fn plain_numbers_are_the_same_numbers() {
        let plain = |text: &str| plain_number(format!("{text}\nG1 X5 Y5 Z5 F500").as_bytes(), 0);
        for text in ["5", "-0.125X", "+.5 Y", "5. ", "12345678901234", "-1234567.890123", "0.000", "-0", ".5"]
        {
            assert_eq!(plain(text), number(text.as_bytes(), 0), "{text}");
        }
        for text in ["", ".", "-", "-.", " 5", "123456789012345", "1234567.8901234"] {
            assert_eq!(plain(text), None, "{text}");
        }
        assert_eq!(plain_number(b"5", 0), None);
    }

    fn value(text: &str) -> Option<f64> {
        number(text.as_bytes(), 0).map(|number| number.value)
    }

    #[test]
    fn forms_of_controls_are_read() {
        let cases = [
            ("5", 5.0),
            ("5.", 5.0),
            (".5", 0.5),
            ("-.5", -0.5),
            ("+2.1", 2.1),
            (" - 1 0 . 2 5 ", -10.25),
            ("1E3", 1.0),
            ("007", 7.0),
        ];
        for (text, expected) in cases {
            assert_eq!(value(text), Some(expected), "{text}");
        }
        for text in ["", ".", "-", "+.", "X", "--1", "#1"] {
            assert_eq!(value(text), None, "{text}");
        }
    }

    /// The short way must agree with the standard library bit for bit.
    #[test]
    fn values_are_correctly_rounded() {
        let mut state = 0x2545_f491_4f6c_dd1d_u64;
        for _ in 0..100_000 {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            let digits = format!("{}", state >> (state % 60));
            let point = state as usize % (digits.len() + 1);
            let text = format!("-{}.{}", &digits[..point], &digits[point..]);
            assert_eq!(value(&text), Some(text.parse().expect("a decimal")), "{text}");
        }
        let huge = "9".repeat(400);
        assert_eq!(value(&huge), Some(f64::INFINITY));
    }
}
