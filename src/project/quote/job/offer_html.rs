//! The offer of a job for the customer: prices by quantity, conditions, tax. The document contains no cost,
//! rate, machine or internal remark.

use crate::plot::escaped;
use crate::project::figures::grouped;
use crate::project::quote::job::letter::Letter;
use crate::project::quote::job::report::JobReport;
use crate::project::quote::offer::html::{document, table};
use crate::units::PERCENT;

impl JobReport {
    /// Returns the offer as a self-contained HTML document.
    pub fn to_offer(&self) -> String {
        let letter = &self.offer;
        let number = if letter.number.is_empty() { String::new() } else { format!(" {}", letter.number) };
        let called = [&self.name, &letter.part_number].into_iter().find(|name| !name.is_empty());
        let part = &called.cloned().unwrap_or_else(|| self.title());
        let title = format!("Offer{number}: {part}");
        let mut body = letterhead(letter);
        if !letter.customer.is_empty() {
            body += &format!("<p class=\"to\">{}</p>\n", escaped(&letter.customer));
        }
        body += &format!("<h1>{}</h1>\n", escaped(&title));
        let price = self.unit_price(self.batch.unit_price);
        let each = match self.batch.quantity {
            1 => price,
            quantity => format!("{price} each for {} parts", grouped(f64::from(quantity), 0)),
        };
        body += &format!("<p class=\"headline\">{}</p>\n", escaped(&each));
        body += &table("", &["", ""], &self.conditions(), None);
        body += &self.total(part);
        let others = self.breaks.iter().filter(|batch| batch.quantity != self.batch.quantity);
        let others = others.map(|batch| {
            let quantity = grouped(f64::from(batch.quantity), 0);
            vec![quantity, self.unit_price(batch.unit_price), self.money(batch.total)]
        });
        body += &table("Other quantities", &["Quantity", "Each", "Net"], &others.collect::<Vec<_>>(), None);
        if !letter.note.is_empty() {
            body += &format!("<p class=\"to\">{}</p>\n", escaped(&letter.note));
        }
        body += "<p class=\"sign\"><span>Date, place</span><span>Signature</span></p>\n";
        document(&title, &body)
    }

    fn conditions(&self) -> Vec<Vec<String>> {
        let letter = &self.offer;
        let rows = [
            ("Offer number", &letter.number),
            ("Date", &letter.date),
            ("Valid until", &letter.valid_until),
            ("Part number", &letter.part_number),
            ("Lead time", &letter.lead_time),
            ("Delivery", &letter.delivery),
            ("Payment", &letter.payment),
        ];
        let rows = rows.into_iter().filter(|(_, value)| !value.is_empty());
        rows.map(|(name, value)| vec![name.to_string(), value.clone()]).collect()
    }

    /// Returns the price of the batch, with tax if the offer has a rate.
    fn total(&self, part: &str) -> String {
        let quantity = grouped(f64::from(self.batch.quantity), 0);
        let net = self.batch.total;
        let row = vec![part.to_string(), quantity, self.unit_price(self.batch.unit_price), self.money(net)];
        let mut rows = vec![row];
        let line = |name: String, amount: f64| vec![name, String::new(), String::new(), self.money(amount)];
        let sum = match self.offer.tax_percent {
            None => line("Total, net".to_string(), net),
            Some(percent) => {
                // Tax is rounded like any amount, so that the printed amounts add up.
                let step = 10f64.powi(self.decimals as i32);
                let tax = (net * percent / PERCENT * step).round() / step;
                rows.push(line("Net".to_string(), net));
                rows.push(line(format!("Tax, {percent} %"), tax));
                line("Total".to_string(), net + tax)
            }
        };
        table("", &["Part", "Quantity", "Each", "Amount"], &rows, Some(&sum))
    }
}

/// Returns the sender: name, address and logo.
fn letterhead(letter: &Letter) -> String {
    let company = &letter.company;
    let tax = if company.tax_number.is_empty() {
        String::new()
    } else {
        format!("Tax number {}", company.tax_number)
    };
    let lines = [&company.name, &company.address, &company.contact, &tax];
    let lines: Vec<String> =
        lines.into_iter().filter(|line| !line.is_empty()).map(|line| escaped(line)).collect();
    let logo = match company.logo.as_str() {
        "" => String::new(),
        address => format!("<img src=\"{}\" alt=\"{}\"/>", escaped(address), escaped(&company.name)),
    };
    if lines.is_empty() && logo.is_empty() {
        return String::new();
    }
    format!("<div class=\"letterhead\"><address>{}</address>{logo}</div>\n", lines.join("\n"))
}
