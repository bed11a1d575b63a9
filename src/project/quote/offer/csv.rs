//! An offer as CSV: tables below each other, each with a head and an empty line after it.

use crate::project::quote::offer::report::OfferReport;

impl OfferReport {
    /// Returns the CSV text: facts, times by kind, addends, quantities, tolerances, operations and tools.
    pub fn to_csv(&self) -> String {
        let text = |cells: &[&str]| cells.iter().map(|cell| cell.to_string()).collect::<Vec<_>>();
        let optional = |value: Option<f64>| value.map(|value| value.to_string()).unwrap_or_default();
        let currency = || self.currency.clone();

        let facts = self.facts.iter().map(|fact| text(&[fact.name, &fact.value])).collect();
        let mut kinds: Vec<_> = self
            .breakdown
            .named()
            .iter()
            .map(|(kind, seconds)| text(&[kind, &seconds.to_string()]))
            .collect();
        kinds.push(text(&["cycle", &self.cycle_time_s.to_string()]));
        kinds.push(text(&["CAM", &self.programmed_time_s.to_string()]));
        let mut addends: Vec<_> = (self.addends.iter())
            .map(|addend| {
                vec![
                    addend.item.to_string(),
                    addend.basis.clone(),
                    if addend.once { "once" } else { "a part" }.to_string(),
                    optional(addend.time_s),
                    optional(addend.hourly),
                    self.money(addend.amount),
                    self.money(addend.of_batch),
                ]
            })
            .collect();
        let parts = format!("{} parts", self.batch.quantity);
        addends.push(text(&["Total", &parts, "", "", "", "", &self.money(self.batch.total)]));
        let breaks = (self.breaks.iter())
            .map(|batch| {
                let end =
                    |index: usize| batch.total_range.map(|ends| self.money(ends[index])).unwrap_or_default();
                let [unit, total] = [self.unit_price(batch.unit_price), self.money(batch.total)];
                vec![batch.quantity.to_string(), unit, total, end(0), end(1), currency()]
            })
            .collect();
        let tolerances = (self.tolerances.iter())
            .map(|row| {
                let [unit, total] = [self.unit_price(row.unit_price), self.money(row.total)];
                vec![row.tolerance.clone(), row.cycle_time_s.to_string(), unit, total, currency()]
            })
            .collect();
        let mut tables = vec![
            ("fact,value", facts),
            ("time,seconds", kinds),
            ("item,basis,paid,time_s,per_hour,amount,of_batch", addends),
            ("quantity,unit_price,total,total_low,total_high,currency", breaks),
            ("tolerance,time_s,unit_price,total,currency", tolerances),
        ];
        let shares = [
            ("operation,line,tool,time_s,cost", &self.operations),
            ("tool,line,tool,time_s,cost", &self.tools),
        ];
        for (head, parts) in shares {
            let number = |value: Option<u32>| value.map(|value| value.to_string()).unwrap_or_default();
            let rows = parts.iter().map(|part| {
                let [line, tool] = [part.line, part.tool].map(number);
                vec![part.name.clone(), line, tool, part.time_s.to_string(), self.money(part.amount)]
            });
            tables.push((head, rows.collect()));
        }
        let tables = tables.into_iter().filter(|(_, rows)| !rows.is_empty());
        tables.map(|(head, rows)| table(head, &rows)).collect::<Vec<_>>().join("\n")
    }
}

/// Returns a table with a head.
pub(in crate::project) fn table(head: &str, rows: &[Vec<String>]) -> String {
    let row =
        |cells: &Vec<String>| cells.iter().map(|cell| cell_of_csv(cell)).collect::<Vec<_>>().join(",") + "\n";
    rows.iter().fold(format!("{head}\n"), |csv, cells| csv + &row(cells))
}

/// Returns a cell for a spreadsheet. Text that a spreadsheet would read as a formula is quoted.
fn cell_of_csv(text: &str) -> String {
    let is_formula = text.starts_with(['=', '+', '-', '@', '\t', '\r']) && text.parse::<f64>().is_err();
    let text = if is_formula { format!("'{text}") } else { text.to_string() };
    if text.contains(['"', ',', '\n', '\r', ';']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::project::quote::offer::request::tests::asked;

    #[test]
    fn a_table_has_every_number_and_no_formula() {
        let terms = serde_json::json!({"reference": "x", "quantity": 2});
        let report = OfferReport::from_json(&asked(0, terms, "=part.nc").to_string()).expect("right");
        let csv = report.to_csv();
        assert!(csv.starts_with("fact,value\nReference,x\nProgram,'=part.nc\nMachine,"), "{csv}");
        for line in [
            "\nContour tolerance,10 µm\n",
            "\nDate,2026-11-22\n",
            "\nRemarks on the program,\"1 error, 2 warnings\"\n",
        ] {
            assert!(csv.contains(line), "{line}: {csv}");
        }
        assert!(csv.contains("\ntime,seconds\ncutting,100\nrapids,15\n"), "{csv}");
        assert!(
            csv.contains("\n\nitem,basis,paid,time_s,per_hour,amount,of_batch\n\"Machine, cutting\","),
            "{csv}"
        );
        assert!(csv.contains("\"face, \"\"rough\"\" T1\",3,1,70,"), "{csv}");
        assert!(csv.contains("\nTotal,2 parts,,,,,6.00\n"), "{csv}");
        assert!(csv.contains("\n20 µm,110,2.75,5.50,EUR\n"), "{csv}");
        assert_eq!(cell_of_csv("=1+1"), "'=1+1");
        assert_eq!(cell_of_csv("-1.5"), "-1.5");
    }
}
