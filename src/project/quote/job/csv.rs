//! A job as CSV: tables below each other, each with a head and an empty line after it. Times are in seconds,
//! in minutes for shop systems, and as h:mm:ss for people.

use crate::project::figures::clock;
use crate::project::quote::job::report::JobReport;
use crate::project::quote::offer::csv::table;
use crate::units::SECONDS_PER_MINUTE;

const OPERATION_COLUMNS: &str = "sequence,operation,program,machine,tolerance,parts_per_load,set_up_s,set_up_min,loading_s,\
    cycle_s,cycle_min,cycle_h_mm_ss,cam_s,in_doubt_s,per_hour,set_up_cost,part_cost";

impl JobReport {
    /// Returns the CSV text: operations, times of the job, addends, quantities, and missing terms.
    pub fn to_csv(&self) -> String {
        let minutes = |seconds: f64| format!("{:.3}", seconds / SECONDS_PER_MINUTE);
        let money = |amount: f64| format!("{amount:.*}", self.decimals as usize);
        let each = |amount: f64| format!("{amount:.*}", self.decimals.max(2) as usize);
        let name = |operation: Option<usize>| {
            operation.map(|index| self.operations[index].name.clone()).unwrap_or_default()
        };
        let operations = self.operations.iter().enumerate().map(|(index, row)| {
            vec![
                (index + 1).to_string(),
                row.name.clone(),
                row.program.clone(),
                row.machine.clone(),
                row.tolerance.clone(),
                row.parts_per_load.to_string(),
                row.set_up_s.to_string(),
                minutes(row.set_up_s),
                row.loading_s.to_string(),
                row.cycle_time_s.to_string(),
                minutes(row.cycle_time_s),
                clock(row.cycle_time_s),
                row.programmed_time_s.to_string(),
                if row.bounded { row.in_doubt_s.to_string() } else { "unknown".to_string() },
                row.hourly.to_string(),
                money(row.set_up_cost),
                money(row.part_cost),
            ]
        });
        let times = [
            ("cycle of a part", self.cycle_time_s),
            ("CAM of a part", self.programmed_time_s),
            ("loading of a part", self.loading_s),
            ("set-up of the batch", self.set_up_s),
            ("batch", self.batch_time_s),
        ]
        .map(|(time, seconds)| vec![time.to_string(), seconds.to_string(), minutes(seconds), clock(seconds)]);
        let mut addends: Vec<_> = (self.addends.iter())
            .map(|addend| {
                let row = &addend.row;
                let paid = if row.once { "once" } else { "a part" }.to_string();
                let (item, basis) = (row.item.to_string(), row.basis.clone());
                vec![name(addend.operation), item, basis, paid, money(row.amount), money(row.of_batch)]
            })
            .collect();
        let parts = format!("{} parts", self.batch.quantity);
        let total = [String::new(), "Total".to_string(), parts, String::new(), String::new()];
        addends.push(total.into_iter().chain([money(self.batch.total)]).collect());
        let breaks = self.breaks.iter().map(|batch| {
            let end = |index: usize| batch.total_range.map(|ends| money(ends[index])).unwrap_or_default();
            let [unit, total] = [each(batch.unit_price), money(batch.total)];
            vec![batch.quantity.to_string(), unit, total, end(0), end(1), self.currency.clone()]
        });
        let missing =
            self.missing.iter().map(|missing| vec![missing.label.to_string(), name(missing.operation)]);
        let tables: [(&str, Vec<Vec<String>>); 5] = [
            (OPERATION_COLUMNS, operations.collect()),
            ("time,seconds,minutes,h_mm_ss", times.to_vec()),
            ("operation,item,basis,paid,amount,of_batch", addends),
            ("quantity,unit_price,total,total_low,total_high,currency", breaks.collect()),
            ("not in the price yet,operation", missing.collect()),
        ];
        let tables = tables.into_iter().filter(|(_, rows)| !rows.is_empty());
        tables.map(|(head, rows)| table(head, &rows)).collect::<Vec<_>>().join("\n")
    }
}
