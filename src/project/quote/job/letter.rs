//! The letter around the prices of an offer: sender, customer and conditions.

use serde::Serialize;
use serde_json::{Map, Value};

use crate::project::TextFault;
use crate::project::machine::form::{FormField, filled};
use crate::project::quote::job::fields::Fields;
use crate::units::Unit;

/// The letter around the prices. Texts may be empty.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(in crate::project) struct Letter {
    pub(super) customer: String,
    pub(super) number: String,
    /// Date as printed; the user enters it.
    pub(super) date: String,
    pub(super) valid_until: String,
    pub(super) part_number: String,
    pub(super) lead_time: String,
    pub(super) delivery: String,
    pub(super) payment: String,
    /// Tax on the net price, percent; `None` if the offer does not mention tax.
    pub(super) tax_percent: Option<f64>,
    pub(super) note: String,
    pub(super) company: Company,
}

/// The sender.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(in crate::project) struct Company {
    pub(super) name: String,
    /// Lines of an address.
    pub(super) address: String,
    pub(super) contact: String,
    pub(super) tax_number: String,
    /// Picture as a data URL; empty if there is none.
    pub(super) logo: String,
}

/// A text of a letter.
struct LetterField {
    key: &'static str,
    /// Short name for forms.
    label: &'static str,
    /// One sentence on its content.
    doc: &'static str,
    /// Largest number of characters.
    most: usize,
    /// Kind of input: text, lines, or picture.
    kind: &'static str,
}

const fn text(
    key: &'static str,
    label: &'static str,
    doc: &'static str,
    most: usize,
    kind: &'static str,
) -> LetterField {
    LetterField { key, label, doc, most, kind }
}

/// The text fields of `offer`, in the order of the form.
const OFFER_FIELDS: [LetterField; 9] = [
    text("customer", "Customer", "Name and address, as printed on the offer.", 1000, "lines"),
    text("number", "Offer number", "Your number of this offer.", 100, "text"),
    text("date", "Date", "The date of the offer, as printed on it.", 100, "text"),
    text("valid_until", "Valid until", "How long the prices hold.", 100, "text"),
    text("part_number", "Part number", "Number and revision of the drawing.", 200, "text"),
    text("lead_time", "Lead time", "When the parts are there.", 200, "text"),
    text("delivery", "Delivery", "Terms of delivery and packing.", 500, "text"),
    text("payment", "Payment", "Terms of payment.", 500, "text"),
    text("note", "Note", "Further text for the customer.", 4000, "lines"),
];

const TAX_KEY: &str = "tax_percent";

/// Rates of tax, percent.
const TAX_BOUNDS_PERCENT: (f64, f64) = (0.0, 100.0);

/// The fields of `company`, in the order of the form.
const COMPANY_FIELDS: [LetterField; 5] = [
    text("name", "Company", "Your name on the offer.", 200, "text"),
    text("address", "Address", "Its lines.", 1000, "lines"),
    text("contact", "Contact", "Who answers, telephone, mail.", 1000, "lines"),
    text("tax_number", "Tax number", "As tax law asks for it.", 200, "text"),
    text("logo", "Logo", "A picture, PNG or JPEG, of 300 kB at most.", 400_000, "picture"),
];

/// Returns the letter as a form, JSON text: the fields of `offer` and of `company`.
pub fn letter_form() -> String {
    #[derive(Serialize)]
    struct Form {
        offer: Vec<FormField>,
        company: Vec<FormField>,
    }
    let of = |text: &LetterField| {
        let neutral = Value::from("");
        FormField { kind: text.kind, ..FormField::empty(text.key, text.label, text.doc, "", neutral) }
    };
    let doc = "Tax on the net price; empty: the offer does not mention tax.";
    let tax = FormField {
        kind: "number",
        unit: Some(Unit::Percent.symbol()),
        min: Some(TAX_BOUNDS_PERCENT.0),
        max: Some(TAX_BOUNDS_PERCENT.1),
        ..FormField::empty(TAX_KEY, "Tax", doc, "", Value::Null)
    };
    let mut offer: Vec<FormField> = OFFER_FIELDS.iter().map(of).collect();
    // The note comes last.
    offer.insert(offer.len() - 1, tax);
    let form = Form { offer, company: COMPANY_FIELDS.iter().map(of).collect() };
    serde_json::to_string(&form).expect("text and finite numbers have a JSON form")
}

/// Beginnings of logos: formats that contain no script.
const LOGO_BEGINNINGS: [&str; 2] = ["data:image/png;base64,", "data:image/jpeg;base64,"];

impl Letter {
    /// Reads the letter of a job from its fields `offer` and `company`.
    pub(super) fn of(job: &Fields) -> Result<Letter, TextFault> {
        let empty = Value::Object(Map::new());
        let known: Vec<&str> = OFFER_FIELDS.iter().map(|text| text.key).chain([TAX_KEY]).collect();
        let offer = Fields::of(job.value("offer").unwrap_or(&empty), "offer", &known)?;
        let texts = OFFER_FIELDS.map(|text| offer.text(text.key, text.most));
        let [customer, number, date, valid_until, part_number, lead_time, delivery, payment, note] = texts;
        let known = COMPANY_FIELDS.map(|text| text.key);
        let company = Fields::of(job.value("company").unwrap_or(&empty), "company", &known)?;
        let [name, address, contact, tax_number, logo] =
            COMPANY_FIELDS.map(|text| company.text(text.key, text.most));
        let company = Company {
            name: name?,
            address: address?,
            contact: contact?,
            tax_number: tax_number?,
            logo: checked_logo(logo?, &company)?,
        };
        Ok(Letter {
            customer: customer?,
            number: number?,
            date: date?,
            valid_until: valid_until?,
            part_number: part_number?,
            lead_time: lead_time?,
            delivery: delivery?,
            payment: payment?,
            tax_percent: offer.number(TAX_KEY, TAX_BOUNDS_PERCENT)?,
            note: note?,
            company,
        })
    }

    /// Returns `offer` without its empty fields.
    pub(super) fn offer_values(&self) -> Map<String, Value> {
        let Letter { customer, number, date, valid_until, part_number, lead_time, delivery, payment, .. } =
            self;
        let texts =
            [customer, number, date, valid_until, part_number, lead_time, delivery, payment, &self.note];
        let mut values = nonempty(OFFER_FIELDS.iter().zip(texts));
        values.extend(self.tax_percent.map(|percent| (TAX_KEY.to_string(), Value::from(percent))));
        values
    }

    /// Returns `company` without its empty fields.
    pub(super) fn company_values(&self) -> Map<String, Value> {
        let Company { name, address, contact, tax_number, logo } = &self.company;
        nonempty(COMPANY_FIELDS.iter().zip([name, address, contact, tax_number, logo]))
    }
}

/// Returns the texts that are not empty, by their keys.
fn nonempty<'a>(texts: impl Iterator<Item = (&'a LetterField, &'a String)>) -> Map<String, Value> {
    filled(
        texts
            .filter(|(_, text)| !text.is_empty())
            .map(|(row, text)| (row.key.to_string(), Value::from(text.as_str()))),
    )
}

/// Returns a logo if it consists only of a picture in base 64, as documents contain it unescaped.
fn checked_logo(logo: String, company: &Fields) -> Result<String, TextFault> {
    let base64 = |byte: u8| byte.is_ascii_alphanumeric() || matches!(byte, b'+' | b'/' | b'=');
    let is_picture = LOGO_BEGINNINGS
        .iter()
        .filter_map(|start| logo.strip_prefix(start))
        .any(|data| data.bytes().all(base64));
    if logo.is_empty() || is_picture {
        return Ok(logo);
    }
    Err(company.fault("logo", "expected a picture, PNG or JPEG, as a data address: data:image/png;base64,…"))
}
