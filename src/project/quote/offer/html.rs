//! An offer as one self-contained HTML document for printing: no scripts, no other files, the charts inline
//! as SVG, and a policy that prevents it from loading anything. The document is well-formed XML except for
//! its first line.

use crate::plot::escaped;
use crate::project::VERSION;
use crate::project::quote::offer::report::{Batch, OfferReport, ShareRow};

const OFFER_STYLE: &str = "body{font:14px/1.5 system-ui,sans-serif;color:#1d242c;background:#fff;max-width:860px;\
    margin:24px auto;padding:0 16px}h1{font-size:24px;line-height:1.3;margin:0}h2{font-size:16px;margin:26px 0 6px}\
    table{border-collapse:collapse;width:100%;font-variant-numeric:tabular-nums}th,td{text-align:right;\
    padding:3px 0 3px 14px;border-bottom:1px solid #dde1e6;vertical-align:top}th{font-weight:600}\
    th:first-child,td:first-child,.basis{text-align:left}th:first-child,td:first-child{padding-left:0}\
    .sum td{font-weight:650;border-top:2px solid #1d242c}figure{margin:12px 0;break-inside:avoid}\
    svg{max-width:100%;height:auto}\
    .letterhead{display:flex;justify-content:space-between;gap:24px;margin-bottom:40px}.letterhead img{max-height:72px;\
    max-width:260px}address{font-style:normal;white-space:pre-line}.to{white-space:pre-line;margin:0 0 32px}\
    .headline{font-size:30px;font-weight:650;margin:18px 0 0;font-variant-numeric:tabular-nums}.warning{color:#8a4b00}\
    .sign{display:flex;gap:48px;margin-top:64px}.sign span{flex:1;border-top:1px solid #1d242c;padding-top:4px}.small{color:#5b6672;font-size:12.5px}tr{break-inside:avoid}\
    h2{break-after:avoid}@page{margin:16mm}@media print{body{margin:0;max-width:none;padding:0}}";

const CONTENT_POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; img-src data:";

impl OfferReport {
    /// Returns the subject of the offer: its reference, else its program.
    fn title(&self) -> String {
        match self.reference.as_str() {
            "" => format!("Quote for {}", self.program),
            reference => reference.to_string(),
        }
    }

    /// Returns the costing for the house as an HTML document, with each chart as SVG and its caption.
    pub fn to_html(&self, charts: &[(String, String)]) -> String {
        let title = self.title();
        let currency = &self.currency;
        let mut body = format!("<h1>{}</h1>\n", escaped(&title));
        body += &paragraph(&format!("Computed by Truefeed {VERSION}."));
        let facts: Vec<Vec<String>> =
            self.facts.iter().map(|fact| vec![fact.name.to_string(), fact.value.clone()]).collect();
        body += &table("", &["", ""], &facts, None);
        let addends: Vec<Vec<String>> = self
            .addends
            .iter()
            .map(|addend| {
                let [once, part] =
                    if addend.once { [Some(addend.amount), None] } else { [None, Some(addend.amount)] };
                let amount =
                    |amount: Option<f64>| amount.map(|amount| self.money(amount)).unwrap_or_default();
                vec![
                    addend.item.to_string(),
                    addend.basis.clone(),
                    amount(once),
                    amount(part),
                    self.money(addend.of_batch),
                ]
            })
            .collect();
        let sum =
            ["Total", "", &self.money(self.once), &self.money(self.part), &self.money(self.batch.total)]
                .map(str::to_string);
        let parts = format!("{} parts, {currency}", self.batch.quantity);
        let head = ["", "", "Per batch", "Per part", &parts];
        body += &table("What the price is made of", &head, &addends, Some(&sum));
        let breaks: Vec<Vec<String>> = self.breaks.iter().map(|batch| self.of_batch(batch)).collect();
        body += &table("Price by quantity", &["Quantity", "Per part", "Total", "Price range"], &breaks, None);
        let tolerances: Vec<Vec<String>> = (self.tolerances.iter())
            .map(|row| {
                let [unit, total] = [self.unit_price(row.unit_price), self.money(row.total)];
                vec![row.tolerance.clone(), format!("{:.1} s", row.cycle_time_s), unit, total]
            })
            .collect();
        let head = ["Contour tolerance", "Cycle time", "Per part", &parts];
        body += &table("Price by tolerance", &head, &tolerances, None);
        let shares = |rows: &[ShareRow]| -> Vec<Vec<String>> {
            let row = |row: &ShareRow| {
                let line = row.line.map(|line| format!("line {line}")).unwrap_or_default();
                vec![row.name.clone(), line, format!("{:.1} s", row.time_s), self.money(row.amount)]
            };
            rows.iter().map(row).collect()
        };
        let cost = ["Together", "", &format!("{:.1} s", self.cycle_time_s), &self.money(self.cycle_cost)]
            .map(str::to_string);
        let head = ["", "", "Time", "Cost"];
        body +=
            &table("Cycle by operation, before the margin", &head, &shares(&self.operations), Some(&cost));
        body += &table("Cycle by tool, before the margin", &head, &shares(&self.tools), Some(&cost));
        if !charts.is_empty() {
            body += "<h2>Charts</h2>\n";
        }
        for (picture, caption) in charts {
            body += &format!(
                "<figure>{picture}<figcaption class=\"small\">{}</figcaption></figure>\n",
                escaped(caption)
            );
        }
        body += &self.notes.iter().map(|note| paragraph(note)).collect::<String>();
        document(&title, &body)
    }

    fn of_batch(&self, batch: &Batch) -> Vec<String> {
        let range = match batch.total_range {
            Some([low, high]) => format!("{} to {}", self.money(low), self.money(high)),
            None => "unknown".to_string(),
        };
        vec![batch.quantity.to_string(), self.unit_price(batch.unit_price), self.money(batch.total), range]
    }
}

/// Returns a self-contained document with this body.
pub(in crate::project) fn document(title: &str, body: &str) -> String {
    format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"/><meta http-equiv=\"Content-Security-Policy\" \
         content=\"{CONTENT_POLICY}\"/><meta name=\"viewport\" content=\"width=device-width\"/><title>{}</title>\
         <style>{OFFER_STYLE}</style></head>\n<body>\n{body}</body></html>\n",
        escaped(title)
    )
}

/// Returns a remark in small print.
pub(in crate::project) fn paragraph(text: &str) -> String {
    format!("<p class=\"small\">{}</p>\n", escaped(text))
}

/// Returns a table below its title, its sum last; empty without rows.
pub(in crate::project) fn table(
    title: &str,
    head: &[&str],
    rows: &[Vec<String>],
    sum: Option<&[String]>,
) -> String {
    if rows.is_empty() {
        return String::new();
    }
    // A second column without a heading describes the first.
    let is_basis = head.get(1) == Some(&"");
    let cells = |row: &[String]| -> String {
        let cell = |(index, cell): (usize, &String)| {
            let class = if index == 1 && is_basis { " class=\"basis\"" } else { "" };
            format!("<td{class}>{}</td>", escaped(cell))
        };
        row.iter().enumerate().map(cell).collect()
    };
    let head: String = head.iter().map(|cell| format!("<th>{}</th>", escaped(cell))).collect();
    let rows: String = rows.iter().map(|row| format!("<tr>{}</tr>", cells(row))).collect();
    let sum = sum.map(|row| format!("<tr class=\"sum\">{}</tr>", cells(row))).unwrap_or_default();
    let title = if title.is_empty() { String::new() } else { format!("<h2>{}</h2>\n", escaped(title)) };
    format!("{title}<table><thead><tr>{head}</tr></thead><tbody>{rows}{sum}</tbody></table>\n")
}

#[cfg(test)]
mod tests {
    use crate::plot::escaped;
    use crate::project::quote::offer::report::OfferReport;
    use crate::project::quote::offer::request::tests::asked;

    #[test]
    fn the_document_is_well_formed_and_says_every_amount() {
        let terms =
            serde_json::json!({"reference": "<b>&\u{1}\"", "quantity": 3, "set_up_min": 20, "material": 2.5});
        let request = asked(0, terms, "<script>alert(1)</script>").to_string();
        let report = OfferReport::from_json(&request).expect("right");
        let html = report
            .to_html(&[("<svg xmlns=\"http://www.w3.org/2000/svg\"/>".to_string(), "a <chart>".to_string())]);
        let (first, rest) = html.split_once('\n').expect("it has lines");
        assert_eq!(first, "<!doctype html>");
        roxmltree::Document::parse(rest).expect("it is well-formed");
        assert!(!html.contains("<script"));
        for addend in &report.addends {
            assert!(html.contains(&format!("<td>{}</td>", report.money(addend.of_batch))), "{}", addend.item);
        }
        assert!(html.contains(&report.money(report.batch.total)));
        for fact in &report.facts {
            assert!(
                html.contains(&format!("<td class=\"basis\">{}</td>", escaped(&fact.value))),
                "{}",
                fact.name
            );
        }
        assert!(html.contains("<td>20 µm</td><td>110.0 s</td>"), "{html}");
    }
}
