//! Contour tolerances as people enter and read them: in the unit that the page shows, µm or inches, unless they
//! write another one.
//!
//! ```text
//! tolerance = number, [ "um" | "µm" | "μm" | "mm" | "in" | '"' | "thou" | "mil" ]      decimal point or comma
//! ```

use crate::machine::{Access, parameter};
use crate::units::{LengthUnit, micrometres, mm_of_micrometres, mm_of_thou};

/// Key of the tolerance in the machine file and on the page.
const TOLERANCE_KEY: &str = "interpolator.contour_tolerance_mm";

/// Decimals of a distance from the path in inches: 0.00001 in is a quarter of a micrometre.
const DEVIATION_DECIMALS_IN: usize = 5;

/// Default tolerances of a quote, mm.
pub const USUAL_TOLERANCES_MM: [f64; 3] = [0.010, 0.020, 0.050];

/// The reason why a text is no tolerance.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ToleranceError {
    /// There is no number, or an unknown unit.
    #[error("“{text}” is not a tolerance. Type {}.", example(*.unit))]
    NotANumber {
        /// The typed text.
        text: String,
        /// Unit of a number alone.
        unit: LengthUnit,
    },
    /// The value is outside the bounds of machines.
    #[error("{} is out of range: a tolerance lies between {} and {}.", tolerance_label_in(*.unit, *.value), tolerance_label_in(*.unit, *.min), tolerance_label_in(*.unit, *.max))]
    OutOfRange {
        /// Unit of the message.
        unit: LengthUnit,
        /// The value, mm.
        value: f64,
        /// Least tolerance, mm.
        min: f64,
        /// Largest tolerance, mm.
        max: f64,
    },
}

/// Returns examples of tolerances in a unit.
fn example(unit: LengthUnit) -> &'static str {
    match unit {
        LengthUnit::Millimetre => "a number of micrometres, for example 15, or 0.015 mm",
        LengthUnit::Inch => "a number of inches, for example 0.0005, or 0.5 thou",
    }
}

/// Returns the tolerance (mm) that a text names; a number alone is in the fine unit of `unit`.
///
/// # Errors
///
/// Returns an error if the text is no number, or no tolerance that a machine can have.
pub fn tolerance_from_text(text: &str, unit: LengthUnit) -> Result<f64, ToleranceError> {
    let trimmed = text.trim();
    let number = trimmed.trim_end_matches(|c: char| c.is_alphabetic() || c.is_whitespace() || c == '"');
    let not_a_number = || ToleranceError::NotANumber { text: trimmed.to_string(), unit };
    let mm: fn(f64) -> f64 = match trimmed[number.len()..].trim() {
        "" if unit == LengthUnit::Inch => |value| LengthUnit::Inch.mm_of_fine(value),
        "" | "um" | "µm" | "μm" => mm_of_micrometres,
        "mm" => |value| value,
        "in" | "\"" => |value| LengthUnit::Inch.to_mm(value),
        "thou" | "mil" => mm_of_thou,
        _ => return Err(not_a_number()),
    };
    if number.split_once(',').is_some_and(|(whole, rest)| !whole.starts_with('0') && rest.len() == 3) {
        // A separator of thousands or of decimals: ambiguous.
        return Err(not_a_number());
    }
    let typed: f64 = number.replace(',', ".").parse().map_err(|_| not_a_number())?;
    checked_tolerance_in(unit, mm(typed))
}

/// Returns the tolerance (mm) if a machine can have it.
///
/// # Errors
///
/// Returns an error if no machine can have it.
pub fn checked_tolerance(value: f64) -> Result<f64, ToleranceError> {
    checked_tolerance_in(LengthUnit::Millimetre, value)
}

fn checked_tolerance_in(unit: LengthUnit, value: f64) -> Result<f64, ToleranceError> {
    let (min, max) = bounds();
    if value.is_nan() || value < min || max < value {
        return Err(ToleranceError::OutOfRange { unit, value, min, max });
    }
    Ok(value)
}

/// Formats a tolerance (mm), for example `10 µm`.
pub fn tolerance_label(tolerance: f64) -> String {
    format!("{} µm", trimmed(micrometres(tolerance), 3))
}

/// Formats a number with at most this number of decimals, without zeros at its end.
fn trimmed(value: f64, decimals: usize) -> String {
    format!("{value:.decimals$}").trim_end_matches('0').trim_end_matches('.').to_string()
}

/// Formats a tolerance (mm) in a unit, for example `15 µm` or `0.00059 in`.
pub fn tolerance_label_in(unit: LengthUnit, tolerance: f64) -> String {
    if unit == LengthUnit::Millimetre {
        return tolerance_label(tolerance);
    }
    let length = unit.fine(tolerance);
    // At least two significant digits, so that the finest tolerances do not look alike.
    let decimals = (1.0 - length.log10().floor()).clamp(DEVIATION_DECIMALS_IN as f64, 9.0) as usize;
    format!("{} {}", trimmed(length, decimals), unit.fine_symbol())
}

/// Formats a measured distance from the path (mm) in a unit, for example `21.4 µm` or `0.00084 in`.
pub fn deviation_label(unit: LengthUnit, deviation: f64) -> String {
    let decimals = if unit == LengthUnit::Inch { DEVIATION_DECIMALS_IN } else { 1 };
    format!("{:.decimals$} {}", unit.fine(deviation), unit.fine_symbol())
}

/// Returns the least and the largest tolerance, mm.
fn bounds() -> (f64, f64) {
    match parameter(TOLERANCE_KEY).map(|row| &row.access) {
        Some(Access::Number { unit, min, max, .. }) => (unit.to_core(*min), unit.to_core(*max)),
        _ => (0.0, f64::INFINITY),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn in_mm(text: &str) -> Result<f64, ToleranceError> {
        tolerance_from_text(text, LengthUnit::Millimetre)
    }

    #[test]
    fn a_number_alone_is_in_the_unit_shown_and_a_number_with_a_unit_is_in_its_own() {
        for (text, shown_mm, shown_inch) in [
            ("0.25", 0.00025, 6.35),
            ("0.0005 in", 0.0127, 0.0127),
            (".0005\"", 0.0127, 0.0127),
            ("0.5 thou", 0.0127, 0.0127),
            ("1 mil", 0.0254, 0.0254),
            ("15 µm", 0.015, 0.015),
            ("0,015 mm", 0.015, 0.015),
        ] {
            let read = |unit: LengthUnit| tolerance_from_text(text, unit).expect(text);
            assert!((read(LengthUnit::Millimetre) - shown_mm).abs() < 1e-15, "{text}");
            assert!((read(LengthUnit::Inch) - shown_inch).abs() < 1e-12, "{text}");
        }
        let fault = |text: &str| tolerance_from_text(text, LengthUnit::Inch).expect_err(text).to_string();
        // Somebody who means 15 µm.
        assert!(
            fault("15").starts_with("15 in is out of range") && fault("15").contains("0.3937 in"),
            "{}",
            fault("15")
        );
        assert!(fault("ten").contains("inches, for example 0.0005"));
    }

    #[test]
    fn reads_micrometres_and_millimetres() {
        for (text, tolerance) in [
            ("15", 0.015),
            (" 15 µm", 0.015),
            ("0,5um", 0.0005),
            ("0.02 mm", 0.02),
            ("0,015 mm", 0.015),
            ("1e1", 0.01),
        ] {
            let read = in_mm(text).expect(text);
            assert!((read - tolerance).abs() < 1e-15, "{text}: {read}");
        }
    }

    #[test]
    fn refuses_what_is_none_and_says_the_bounds() {
        for text in ["", "x", "10 inch", "10 \"in", "1 2", "NaN", "1,000", "12,500 mm"] {
            assert!(matches!(in_mm(text), Err(ToleranceError::NotANumber { .. })), "{text}");
        }
        for text in ["0", "-3", "1e9", "inf 3"] {
            assert!(in_mm(text).is_err(), "{text}");
        }
        let message = in_mm("20000").expect_err("20 mm is too much").to_string();
        assert!(message.contains("10000 µm"), "{message}");
    }

    #[test]
    fn deviations_have_one_decimal() {
        assert_eq!(deviation_label(LengthUnit::Millimetre, 0.0214351), "21.4 µm");
    }

    #[test]
    fn what_is_shown_reads_back() {
        for tolerance in USUAL_TOLERANCES_MM {
            let read = in_mm(&tolerance_label(tolerance)).expect("a label is a tolerance");
            assert!((read - tolerance).abs() < 1e-12);
        }
    }

    #[test]
    fn inches_have_five_decimals_or_two_digits() {
        let label = |tolerance: f64| tolerance_label_in(LengthUnit::Inch, tolerance);
        assert_eq!([0.01, 0.05, 0.0254].map(label), ["0.00039 in", "0.00197 in", "0.001 in"]);
        assert_eq!([0.0001, 0.0011, 25.4].map(label), ["0.0000039 in", "0.000043 in", "1 in"]);
        assert_eq!(tolerance_label_in(LengthUnit::Millimetre, 0.0125), "12.5 µm");
        assert_eq!(deviation_label(LengthUnit::Inch, 0.0214351), "0.00084 in");
        assert_eq!(deviation_label(LengthUnit::Inch, 0.0), "0.00000 in");
    }
}
