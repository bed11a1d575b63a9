use crate::identification::recording::clock::iso;
use crate::identification::recording::field::{ChannelField, ChannelLabel, LoopSide, is_scope};
use crate::identification::recording::text::{CellContent, decode, number};
use crate::identification::recording::unit::{self, LogUnit};

#[test]
fn names_of_columns_are_understood() {
    let (cmd, act, any) = (LoopSide::Commanded, LoopSide::Actual, LoopSide::Unstated);
    let position = |side, axis| Some(ChannelField::Position(side, axis));
    let known = [
        ("t", Some(ChannelField::Time), None),
        ("t_s", Some(ChannelField::Time), Some(unit::SECOND)),
        ("Time (ms)", Some(ChannelField::Time), Some(unit::MILLISECOND)),
        ("timestamp", Some(ChannelField::Time), None),
        ("Zeit [µs]", Some(ChannelField::Time), Some(unit::MICROSECOND)),
        ("x", position(any, 0), None),
        ("y_mm", position(any, 1), Some(unit::MM)),
        ("Position Z [inch]", position(any, 2), Some(unit::INCH)),
        ("ActPosX", position(act, 0), None),
        ("X1_ActualPosition", position(act, 0), None),
        ("X1_CommandPosition", position(cmd, 0), None),
        ("z_soll_mm", position(cmd, 2), Some(unit::MM)),
        ("x_s_actual", position(act, 0), None),
        ("DES_POS|2", position(cmd, 1), None),
        ("ENC_POS|3", position(act, 2), None),
        ("Yabs", position(act, 1), None),
        ("X1actw", position(act, 0), None),
        ("p1LPathPos", Some(ChannelField::Point(act)), None),
        ("feed_mm_min", Some(ChannelField::Feed(any)), Some(unit::MM_PER_MIN)),
        ("feed_mm_per_s", Some(ChannelField::Feed(any)), Some(unit::MM_PER_S)),
        ("Actual feedrate [inch/min]", Some(ChannelField::Feed(act)), Some(unit::INCH_PER_MIN)),
        ("Feed_Rate", Some(ChannelField::Feed(any)), None),
        ("actFeedRateIpo", Some(ChannelField::Feed(act)), None),
        ("M1_CURRENT_FEEDRATE", Some(ChannelField::Feed(any)), None),
        ("p1Fact", Some(ChannelField::Feed(act)), None),
        ("Feed_Override", Some(ChannelField::FeedOverride), None),
        ("Fovr", Some(ChannelField::FeedOverride), None),
        ("Rapid_Override", Some(ChannelField::RapidOverride), None),
        ("line", Some(ChannelField::Line), None),
        ("Block_Number", Some(ChannelField::Line), None),
        ("M1_sequence_number", Some(ChannelField::Line), None),
        ("p1block", Some(ChannelField::Block), None),
        ("Program_Status", Some(ChannelField::Status), None),
        ("pexecution", Some(ChannelField::Status), None),
        ("Program_Name_Running", Some(ChannelField::Program), None),
        ("Current_Tool", Some(ChannelField::Tool), None),
        ("Spindle_Speed", Some(ChannelField::SpindleSpeed), None),
    ];
    for (name, field, unit) in known {
        let label = ChannelLabel::read(name, None);
        assert_eq!((label.field, label.unit), (field, unit), "{name}");
    }
    let not_read = [
        "X1_ActualVelocity",
        "velocity_x",
        "x_acc",
        "X load",
        "CURRENT|1",
        "CONT_DEV|1",
        "X1actm",
        "Z4actw",
        "p1Fract",
        "p1Fcmd",
        "Spindle_Override",
        "Program_Runtime_Seconds",
        "Program_Name_Editing",
        "A [deg]",
        "x_deg",
        "S1_ActualPosition",
        "Spindle_Time",
        "",
        "_",
        "[mm]",
        "tool offset",
    ];
    for name in not_read {
        assert_eq!(ChannelLabel::read(name, None).field, None, "{name}");
    }
    assert!(is_scope(&["x_s_actual", "y_v_nominal", "s-diff"]));
    assert!(!is_scope(&["x_mm", "y_mm"]));
}

#[test]
fn stamps_of_any_precision_and_zone_are_exact() {
    for (text, expected) in [
        ("1970-01-01T00:00:00Z", 0),
        ("2017-02-06T17:40:26.9218750Z", 1_486_402_826_921_875_000),
        ("2022-08-08T13:51:34.7167146Z", 1_659_966_694_716_714_600),
        ("2026-03-01T10:15:00+02:00", 1_772_352_900_000_000_000),
        ("2026-03-01 08:15:00", 1_772_352_900_000_000_000),
        ("2026-03-01T08:15:00,5Z", 1_772_352_900_500_000_000),
        ("2024-02-29T00:00:00.123456789012Z", 1_709_164_800_123_456_789),
        ("1969-12-31T23:59:59Z", -1_000_000_000),
        ("08:15:00.25", 29_700_250_000_000),
    ] {
        assert_eq!(iso(text), Some(expected), "{text}");
    }
    for text in [
        "",
        "T",
        "2017",
        "20178",
        "2017-02-06",
        "2017-13-01T00:00:00Z",
        "2017-02-06T25:00:00Z",
        "12:5x:00",
        "2017-02-06T17:40:26.9Zulu",
        "1,5",
        "é:é",
        "2017-02-06T17:40:26+é1",
    ] {
        assert_eq!(iso(text), None, "{text}");
    }
}

#[test]
fn numbers_come_with_point_or_comma() {
    for (text, expected) in [("1.5", 1.5), (" -2e3 ", -2000.0), ("0,25", 0.25), ("\"7\"", 7.0), ("+.5", 0.5)]
    {
        assert_eq!(number(text, true), CellContent::Number(expected), "{text}");
    }
    for text in ["", "NaN", "inf", "UNAVAILABLE", "-", "1e999"] {
        assert_eq!(number(text, true), CellContent::Missing, "{text}");
    }
    for text in ["1,234.5", "1,2,3", "12:30", "x", "0x10", "1.2.3"] {
        assert_eq!(number(text, true), CellContent::Other, "{text}");
    }
    assert_eq!(number("0,25", false), CellContent::Other);
}

#[test]
fn text_is_decoded_whatever_wrote_it() {
    assert_eq!(decode("Prüfstand".as_bytes()).expect("UTF-8"), "Prüfstand");
    assert_eq!(decode(b"Pr\xfcfstand").expect("Latin-1"), "Prüfstand");
    assert_eq!(decode(b"\xef\xbb\xbft_s").expect("a byte order mark"), "t_s");
    assert_eq!(decode(b"\xfe\xff\0t\0_\0s").expect("UTF-16"), "t_s");
}

#[test]
fn units_are_read_as_people_write_them() {
    for (text, expected) in [
        ("mm/min", unit::MM_PER_MIN),
        ("[mm/min]", unit::MM_PER_MIN),
        ("mm (Length)", unit::MM),
        ("mm_per_s", unit::MM_PER_S),
        ("IPM", unit::INCH_PER_MIN),
        ("MILLIMETER/SECOND", unit::MM_PER_S),
        ("1/min", unit::RPM),
        ("%", unit::PERCENT),
    ] {
        assert_eq!(LogUnit::parse(text), Some(expected), "{text}");
    }
    assert_eq!(LogUnit::parse("furlong"), None);
}
