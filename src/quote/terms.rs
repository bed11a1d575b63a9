//! The terms of an offer: an estimator's inputs in addition to machine and program, with units and bounds.
//!
//! | symbol | term                          | inside       |
//! |--------|-------------------------------|--------------|
//! | n      | quantity                      | parts        |
//! | t_s    | set-up time, once a batch     | s            |
//! | t_l    | load and unload, each part    | s            |
//! | r_o    | operator's rate               | currency / s |
//! | a      | part of the cycle attended    | 0 to 1       |
//! | m      | margin, of the price or on cost | ratio      |
//!
//! The machine's own rate is a parameter of the machine. Amounts of money are in the user's currency.

use crate::units::Unit;

/// The inputs of a price in addition to machine and program.
#[derive(Clone, Debug, PartialEq)]
pub struct Terms {
    /// Subject of the offer; may be empty.
    pub reference: String,
    /// Number of parts.
    pub quantity: u32,
    /// Other quantities to quote.
    pub breaks: Vec<u32>,
    /// Set-up time of the batch, s.
    pub set_up: f64,
    /// Time to load and unload a part, s.
    pub loading: f64,
    /// Price of an operator's time, currency per s.
    pub operator: f64,
    /// Part of the cycle that the operator attends.
    pub attendance: f64,
    /// Material of a part.
    pub material: f64,
    /// Other cost of a part.
    pub other: f64,
    /// Fixed cost of the batch.
    pub fixed: f64,
    /// Margin as a part of `margin_of`.
    pub margin: f64,
    /// The amount that the margin is a part of.
    pub margin_of: MarginOf,
    /// Name of the currency; may be empty.
    pub currency: String,
    /// Step to which amounts are rounded.
    pub rounding: Rounding,
    /// Uncertainty of the cycle time as a part of it; `None`: the machine's.
    pub uncertainty: Option<f64>,
}

/// The amount that a margin is a part of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MarginOf {
    /// The price p of a cost c: p = c / (1 − m).
    Price,
    /// The cost: p = c (1 + m).
    Cost,
}

impl MarginOf {
    /// Keywords in the form.
    pub const WORDS: [&'static str; 2] = ["price", "cost"];
}

/// Steps to which amounts are rounded, in units of the currency.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rounding {
    /// Whole units.
    Units,
    /// Hundredths.
    Hundredths,
    /// Ten-thousandths, for cheap parts.
    TenThousandths,
}

impl Rounding {
    /// Keywords in the form.
    pub const WORDS: [&'static str; 3] = ["0.01", "0.0001", "1"];

    /// Returns the number of steps in a unit of the currency.
    pub fn steps(self) -> f64 {
        match self {
            Rounding::Units => 1.0,
            Rounding::Hundredths => 100.0,
            Rounding::TenThousandths => 10_000.0,
        }
    }

    /// Returns the number of decimals of an amount.
    pub fn decimals(self) -> u32 {
        match self {
            Rounding::Units => 0,
            Rounding::Hundredths => 2,
            Rounding::TenThousandths => 4,
        }
    }
}

/// Neutral terms: the machine's time of one part, and nothing else.
impl Default for Terms {
    fn default() -> Terms {
        Terms {
            reference: String::new(),
            quantity: 1,
            breaks: vec![1, 10, 100, 1000],
            set_up: 0.0,
            loading: 0.0,
            operator: 0.0,
            attendance: 1.0,
            material: 0.0,
            other: 0.0,
            fixed: 0.0,
            margin: 0.0,
            margin_of: MarginOf::Price,
            currency: "EUR".to_string(),
            rounding: Rounding::Hundredths,
            uncertainty: None,
        }
    }
}

/// The description of a term for the form.
pub struct Term {
    /// Key, with the unit in it.
    pub key: &'static str,
    /// Short name for forms.
    pub label: &'static str,
    /// One sentence on its effect.
    pub doc: &'static str,
    /// Type and access.
    pub access: TermAccess,
}

/// Type and access of a term. Numbers are in core units.
pub enum TermAccess {
    /// A number within bounds, entered in its unit.
    Number {
        /// Unit in the form.
        unit: Unit,
        /// Least value allowed, in that unit.
        min: f64,
        /// Largest value allowed, in that unit.
        max: f64,
        /// `true` for whole numbers.
        whole: bool,
        /// Returns the value; `None` if the terms have none.
        get: fn(&Terms) -> Option<f64>,
        /// Sets the value; `None` restores the neutral one.
        set: fn(&mut Terms, Option<f64>),
    },
    /// A list of quantities.
    Quantities {
        /// Largest number of quantities.
        most: usize,
    },
    /// One of several keywords.
    Choice {
        /// Keywords.
        words: &'static [&'static str],
        /// Returns the current keyword.
        get: fn(&Terms) -> &'static str,
        /// Sets a keyword.
        set: fn(&mut Terms, &str),
    },
    /// A text of limited length.
    Text {
        /// Largest number of characters.
        most: usize,
        /// Returns the text.
        get: fn(&Terms) -> &str,
        /// Sets the text.
        set: fn(&mut Terms, &str),
    },
}

/// Least and largest quantity of an offer.
pub const QUANTITY_BOUNDS: (f64, f64) = (1.0, 1e6);

/// Bounds of amounts of money.
const AMOUNT_BOUNDS: (f64, f64) = (0.0, 1e7);

/// Largest margin on the price: it must leave some of the price for the cost.
pub const MAX_MARGIN_OF_PRICE: f64 = 0.95;

/// A term that is one number: key, label, unit, bounds as in the form, field with its neutral value, sentence on its
/// effect.
macro_rules! number {
    ($key:literal, $label:literal, $unit:ident $bounds:expr, $field:ident or $neutral:literal, $doc:literal) => {
        number!($key, $label, $unit $bounds, |t| Some(t.$field), |t, v| t.$field = v.unwrap_or($neutral), $doc)
    };
    ($key:literal, $label:literal, $unit:ident $bounds:expr, $get:expr, $set:expr, $doc:literal) => {
        Term {
            key: $key,
            label: $label,
            doc: $doc,
            access: TermAccess::Number {
                unit: Unit::$unit,
                min: $bounds.0,
                max: $bounds.1,
                whole: false,
                get: $get,
                set: $set,
            },
        }
    };
}

/// All terms in the order of the form.
pub static TERMS: [Term; 15] = [
    Term {
        key: "reference",
        label: "Reference",
        doc: "Subject of the quote, printed on it: part, customer, number.",
        access: TermAccess::Text {
            most: 200,
            get: |t| &t.reference,
            set: |t, v| t.reference = v.to_string(),
        },
    },
    Term {
        key: "quantity",
        label: "Quantity",
        doc: "Number of parts made with one set-up.",
        access: TermAccess::Number {
            unit: Unit::Number,
            min: QUANTITY_BOUNDS.0,
            max: QUANTITY_BOUNDS.1,
            whole: true,
            get: |t| Some(f64::from(t.quantity)),
            set: |t, v| t.quantity = v.unwrap_or(1.0) as u32,
        },
    },
    Term {
        key: "breaks",
        label: "Price breaks",
        doc: "Other quantities to quote beside it, for example 1; 10; 100.",
        access: TermAccess::Quantities { most: 12 },
    },
    number!("set_up_min", "Set-up", Minute (0.0, 10_000.0), set_up or 0.0,
        "Machine and operator, once for the batch."),
    number!("loading_s", "Load and unload", Second (0.0, 36_000.0), loading or 0.0,
        "Machine and operator, for each part; the machine waits meanwhile."),
    number!("operator_hourly", "Operator’s rate", PerHour (0.0, 1e6), operator or 0.0,
        "Price of an hour of the operator; 0 where the machine’s rate includes it."),
    number!("attendance_percent", "Operator attendance", Percent (0.0, 100.0), attendance or 1.0,
        "Part of the cycle for which the operator is paid; set-up and loading are attended in full."),
    number!("material", "Material per part", Number AMOUNT_BOUNDS, material or 0.0,
        "Stock of one part."),
    number!("other", "Other cost per part", Number AMOUNT_BOUNDS, other or 0.0,
        "Tools, treatment, packing of one part."),
    number!("fixed", "Fixed cost per batch", Number AMOUNT_BOUNDS, fixed or 0.0,
        "Programming, fixtures, first inspection; once."),
    number!("margin_percent", "Margin", Percent (0.0, 1000.0), margin or 0.0,
        "Added to every cost, the fixed ones too."),
    Term {
        key: "margin_of",
        label: "Margin on",
        doc: "price: price = cost ÷ (1 − margin), 95 % at most; cost: price = cost × (1 + margin).",
        access: TermAccess::Choice {
            words: &MarginOf::WORDS,
            get: |t| MarginOf::WORDS[t.margin_of as usize],
            set: |t, v| t.margin_of = if v == "cost" { MarginOf::Cost } else { MarginOf::Price },
        },
    },
    Term {
        key: "currency",
        label: "Currency",
        doc: "Currency of all amounts, including the machine’s hourly rate; Truefeed converts nothing.",
        access: TermAccess::Text { most: 12, get: |t| &t.currency, set: |t, v| t.currency = v.to_string() },
    },
    Term {
        key: "rounding",
        label: "Round amounts to",
        doc: "Each amount is rounded, and the total is the sum of the rounded ones.",
        access: TermAccess::Choice {
            words: &Rounding::WORDS,
            get: |t| match t.rounding {
                Rounding::Hundredths => Rounding::WORDS[0],
                Rounding::TenThousandths => Rounding::WORDS[1],
                Rounding::Units => Rounding::WORDS[2],
            },
            set: |t, v| {
                t.rounding = match v {
                    "0.0001" => Rounding::TenThousandths,
                    "1" => Rounding::Units,
                    _ => Rounding::Hundredths,
                }
            },
        },
    },
    number!(
        "uncertainty_percent",
        "Uncertainty of the cycle time",
        Percent(0.0, 95.0),
        |t| t.uncertainty,
        |t, v| t.uncertainty = v,
        "Your own figure. Empty: the error at the machine’s calibration, if known."
    ),
];
