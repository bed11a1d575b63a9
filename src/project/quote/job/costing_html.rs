//! The costing of a job: every time, rate and amount, for the house and not for the customer.

use crate::plot::escaped;
use crate::project::VERSION;
use crate::project::figures::{clock, grouped};
use crate::project::quote::job::report::{JobReport, OperationRow};
use crate::project::quote::offer::html::{document, paragraph, table};
use crate::project::quote::offer::report::Fact;

impl JobReport {
    /// Returns the costing as a self-contained HTML document, with each chart as SVG and its caption.
    pub fn to_costing(&self, charts: &[(String, String)]) -> String {
        let title = self.title();
        let mut body = format!("<h1>Costing: {}</h1>\n", escaped(&title));
        body += &paragraph(&format!("For internal use. Computed by Truefeed {VERSION}."));
        body += &format!("<p class=\"headline\">{}</p>\n", escaped(&self.headline()));
        for sentence in self.warnings() {
            body += &format!("<p class=\"warning\">{}</p>\n", escaped(&sentence));
        }
        let facts = self.facts.iter().map(|fact| vec![fact.name.to_string(), fact.value.clone()]);
        body += &table("", &["", ""], &facts.collect::<Vec<_>>(), None);
        body += &self.operations_table();
        body += &self.addends_table();
        body += &self.breaks_table();
        let sure =
            |row: &OperationRow| [row.name.clone(), row.uncertainty.clone(), row.in_doubt.clone()].to_vec();
        let sure: Vec<Vec<String>> = self.operations.iter().map(sure).collect();
        body += &table("How sure the times are", &["", "", "In doubt"], &sure, None);
        for (picture, caption) in charts {
            let caption = escaped(caption);
            body +=
                &format!("<figure>{picture}<figcaption class=\"small\">{caption}</figcaption></figure>\n");
        }
        body += &self.notes.iter().map(|note| paragraph(note)).collect::<String>();
        document(&title, &body)
    }

    /// Returns the title of the job's documents.
    pub(super) fn title(&self) -> String {
        let first = self.operations.first().map(|row| row.name.clone()).unwrap_or_default();
        if self.name.is_empty() { first } else { self.name.clone() }
    }

    /// Formats an amount with its currency.
    pub(super) fn money(&self, amount: f64) -> String {
        format!("{} {}", grouped(amount, self.decimals), self.currency).trim_end().to_string()
    }

    /// Formats the price of one part, a quotient, with at least two decimals.
    pub(super) fn unit_price(&self, amount: f64) -> String {
        format!("{} {}", grouped(amount, self.decimals.max(2)), self.currency).trim_end().to_string()
    }

    /// Returns the price of a part in a batch.
    fn headline(&self) -> String {
        let price = self.unit_price(self.batch.unit_price);
        match self.batch.quantity {
            1 => format!("{price} for one part"),
            quantity => format!("{price} per part, {} for {quantity}", self.money(self.batch.total)),
        }
    }

    /// Returns one sentence for each missing term and each doubt about the time.
    pub fn warnings(&self) -> Vec<String> {
        let of = |operation: Option<usize>| {
            operation.map(|index| format!(" of {}", self.operations[index].name)).unwrap_or_default()
        };
        let missing: Vec<String> = self
            .missing
            .iter()
            .map(|missing| format!("{}{}", missing.label, of(missing.operation)))
            .collect();
        let missing = (!missing.is_empty()).then(|| format!("Not in the price yet: {}.", missing.join(", ")));
        missing.into_iter().chain(self.doubt()).collect()
    }

    /// Returns the doubts about the time of a part as a sentence; `None` if there are none.
    pub(super) fn doubt(&self) -> Option<String> {
        match (self.in_doubt_s, self.bounded) {
            (0.0, true) => None,
            (seconds, true) => Some(format!("{seconds:.1} s of a part are in doubt.")),
            (_, false) => Some("The time of an operation is in doubt without a bound.".to_string()),
        }
    }

    /// Returns the times of the job; terms that are not given are left out.
    pub(super) fn told(&self) -> Vec<Fact> {
        let range = self.cycle_time_range_s.map(|[low, high]| format!(", {} to {}", clock(low), clock(high)));
        let range = range.unwrap_or_else(|| ", how exact is unknown".to_string());
        let facts = [
            ("Job", self.name.clone()),
            ("Cycle time per part", format!("{}{range}", clock(self.cycle_time_s))),
            ("CAM estimate", clock(self.programmed_time_s)),
            ("Loading per part", clock(self.loading_s)),
            ("Set-up of the batch", clock(self.set_up_s)),
            ("The batch, one operation after the other", clock(self.batch_time_s)),
            ("Date", self.offer.date.clone()),
            ("Customer", self.offer.customer.lines().next().unwrap_or_default().to_string()),
            ("Offer number", self.offer.number.clone()),
        ];
        let facts = facts.into_iter().filter(|(_, value)| !value.is_empty());
        facts.map(|(name, value)| Fact { name, value }).collect()
    }

    fn operations_table(&self) -> String {
        let row = |(index, row): (usize, &OperationRow)| {
            let load = match row.parts_per_load {
                1 => String::new(),
                parts => format!(", {parts} parts a load"),
            };
            vec![
                format!("{}. {}", index + 1, row.name),
                format!("{}, {}, {}{load}", row.program, row.machine, row.tolerance),
                clock(row.set_up_s),
                clock(row.loading_s),
                clock(row.cycle_time_s),
                grouped(row.hourly, self.decimals),
                grouped(row.set_up_cost, self.decimals),
                grouped(row.part_cost, self.decimals),
            ]
        };
        let rows: Vec<Vec<String>> = self.operations.iter().enumerate().map(row).collect();
        let amounts =
            |value: fn(&OperationRow) -> f64| grouped(self.operations.iter().map(value).sum(), self.decimals);
        let sum = [
            "Together".to_string(),
            String::new(),
            clock(self.set_up_s),
            clock(self.loading_s),
            clock(self.cycle_time_s),
            String::new(),
            amounts(|row| row.set_up_cost),
            amounts(|row| row.part_cost),
        ];
        let head = ["", "", "Set-up", "Loading", "Cycle", "Per hour", "Per batch", "Per part"];
        table("Operations, before the margin", &head, &rows, Some(&sum))
    }

    fn addends_table(&self) -> String {
        let amount = |amount: f64| grouped(amount, self.decimals);
        let rows = self.addends.iter().map(|addend| {
            let row = &addend.row;
            let of = addend.operation.filter(|_| 1 < self.operations.len());
            let item = of.map_or(row.item.to_string(), |index| {
                format!("{}: {}", self.operations[index].name, row.item)
            });
            let [once, part] = if row.once { [Some(row.amount), None] } else { [None, Some(row.amount)] };
            let [once, part] = [once, part].map(|value| value.map(amount).unwrap_or_default());
            vec![item, row.basis.clone(), once, part, amount(row.of_batch)]
        });
        let sum = ["Total", "", &amount(self.once), &amount(self.part), &amount(self.batch.total)];
        let parts = format!("{} parts, {}", self.batch.quantity, self.currency);
        let head = ["", "", "Per batch", "Per part", &parts];
        table("What the price is made of", &head, &rows.collect::<Vec<_>>(), Some(&sum.map(str::to_string)))
    }

    fn breaks_table(&self) -> String {
        let rows = self.breaks.iter().map(|batch| {
            let range = batch.total_range.map_or("unknown".to_string(), |[low, high]| {
                format!("{} to {}", grouped(low, self.decimals), grouped(high, self.decimals))
            });
            let [unit, total] = [self.unit_price(batch.unit_price), self.money(batch.total)];
            vec![grouped(f64::from(batch.quantity), 0), unit, total, range]
        });
        let head = ["Quantity", "Per part", "Total", "Price range"];
        table("Price by quantity", &head, &rows.collect::<Vec<_>>(), None)
    }
}
