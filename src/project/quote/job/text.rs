//! A job, and a comparison of two jobs, as text for the command line.

use crate::project::figures::{clock, grouped};
use crate::project::quote::job::comparison::{Difference, JobComparison};
use crate::project::quote::job::report::{JobReport, OperationRow};

/// Widest name of an operation in a table, characters.
const MAX_NAME_WIDTH: usize = 40;

/// Heading of the column of names.
const NAME_HEADING: &str = "operation";

impl JobReport {
    /// Returns a table of operations with the price below it.
    pub fn to_text(&self) -> String {
        let wide = name_width(self.operations.iter().map(|row| row.name.as_str()));
        let parts = |count: u32| {
            if count == 1 { "1 part".to_string() } else { format!("{} parts", grouped(f64::from(count), 0)) }
        };
        let mut text = format!("{}: {}\n", self.title(), parts(self.batch.quantity));
        text += &format!(
            "    {:<wide$}      set-up     loading       cycle   CAM says   cost once  cost a part  program, machine, tolerance",
            NAME_HEADING
        );
        for (index, row) in self.operations.iter().enumerate() {
            text += &format!("\n{:3} {}", index + 1, self.line(row, wide));
        }
        let range =
            self.cycle_time_range_s.map(|[low, high]| format!(" ({} to {})", clock(low), clock(high)));
        let range = range.unwrap_or_else(|| " (how exact is unknown)".to_string());
        text += &format!(
            "\ncycle time of a part {}{range}, programmed {}",
            clock(self.cycle_time_s),
            clock(self.programmed_time_s)
        );
        text += &format!("\nbatch {}, {} of it set-up", clock(self.batch_time_s), clock(self.set_up_s));
        // Without any cost there is no price; 0 would be mistaken for one.
        for batch in self.breaks.iter().filter(|_| !self.addends.is_empty()) {
            let range = batch
                .total_range
                .map(|[low, high]| format!(" ({} to {})", self.money(low), self.money(high)));
            let own = if batch.quantity == self.batch.quantity { "price" } else { "also " };
            text += &format!(
                "\n{own} {:>12}: {} each, {}{}",
                parts(batch.quantity),
                self.unit_price(batch.unit_price),
                self.money(batch.total),
                range.unwrap_or_default()
            );
        }
        for sentence in self.warnings() {
            text += &format!("\n{sentence}");
        }
        for row in self.operations.iter().filter(|row| !row.in_doubt.is_empty()) {
            text += &format!("\n{}: in doubt: {}", row.name, row.in_doubt);
        }
        text
    }

    fn line(&self, row: &OperationRow, wide: usize) -> String {
        let [once, part] = [row.set_up_cost, row.part_cost].map(|cost| grouped(cost, self.decimals));
        let times =
            [row.set_up_s, row.loading_s, row.cycle_time_s].map(|time| format!(" {:>11}", clock(time)));
        let [program, machine, tolerance] = [&row.program, &row.machine, &row.tolerance];
        format!(
            "{}{} {:>10} {once:>11} {part:>12}  {program}, {machine}, {tolerance}",
            padded(&row.name, wide),
            times.concat(),
            clock(row.programmed_time_s),
        )
    }
}

impl JobComparison {
    /// Returns a table of operations with the totals below it.
    pub fn to_text(&self) -> String {
        let wide = name_width(self.operations.iter().map(|row| row.name.as_str()));
        let mut text = format!("{} → {}\n", self.names[0], self.names[1]);
        text += &format!("{:<wide$}        first       second   difference", NAME_HEADING);
        for row in &self.operations {
            let [first, second] = row.cycle_time_s.map(|time| time.map_or("-".to_string(), clock));
            let difference = signed(row.cycle_time_difference_s);
            text += &format!("\n{} {first:>12} {second:>12} {difference:>12}", padded(&row.name, wide));
        }
        let times = [
            ("cycle time of a part", self.cycle_time_s),
            ("set-up of the batch", self.set_up_s),
            ("batch", self.batch_time_s),
        ];
        for (name, Difference { first, second, difference }) in times {
            text += &format!("\n{name}: {} → {}, {}", clock(first), clock(second), signed(difference));
        }
        for (name, Difference { first, second, difference }) in
            [("price of a part", self.unit_price), ("price", self.total)]
        {
            let [first, second] = [first, second].map(|amount| grouped(amount, 2));
            let sign = if 0.0 < difference { "+" } else { "" };
            text +=
                &format!("\n{name}: {first} → {second} {}, {sign}{}", self.currency, grouped(difference, 2));
        }
        self.remarks.iter().fold(text, |text, remark| format!("{text}\n{remark}"))
    }
}

/// Formats a difference of times with its sign.
fn signed(seconds: f64) -> String {
    let sign = if 0.0 < seconds { "+" } else { "" };
    format!("{sign}{} s", grouped(seconds, 1))
}

/// Returns the width of a column of these names, characters.
fn name_width<'a>(names: impl Iterator<Item = &'a str>) -> usize {
    let longest = names.map(|name| name.chars().count()).max().unwrap_or(0);
    longest.clamp(NAME_HEADING.len(), MAX_NAME_WIDTH)
}

fn padded(name: &str, wide: usize) -> String {
    let cut: String = name.chars().take(wide).collect();
    format!("{cut:<wide$}")
}
