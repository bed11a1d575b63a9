//! The result of a job for sharing: times, their uncertainty, and pictures, without money, rates or customer.

use crate::plot::escaped;
use crate::project::VERSION;
use crate::project::figures::clock;
use crate::project::quote::job::report::{JobReport, OperationRow};
use crate::project::quote::offer::html::{document, paragraph, table};

impl JobReport {
    /// Returns the result as a self-contained HTML document without scripts, with each picture as SVG and its
    /// caption.
    pub fn to_result(&self, pictures: &[(String, String)]) -> String {
        let title = self.title();
        let mut body = format!("<h1>{}</h1>\n", escaped(&title));
        body += &format!("<p class=\"headline\">{} per part</p>\n", clock(self.cycle_time_s));
        let range = self.cycle_time_range_s.map(|[low, high]| format!("{} to {}", clock(low), clock(high)));
        let range = range.unwrap_or_else(|| "How exact that is, is unknown".to_string());
        let longer = 100.0 * (self.cycle_time_s / self.programmed_time_s - 1.0);
        let cam = if longer.is_finite() { format!(" (real: {longer:+.0} %)") } else { String::new() };
        let mut facts = vec![
            vec!["Range".to_string(), range],
            vec!["CAM estimate".to_string(), format!("{}{cam}", clock(self.programmed_time_s))],
        ];
        facts.extend(self.doubt().map(|doubt| vec!["In doubt".to_string(), doubt]));
        body += &table("", &["", ""], &facts, None);
        let row = |(index, row): (usize, &OperationRow)| {
            vec![
                format!("{}. {}", index + 1, row.name),
                format!("{}, {}, {}", row.program, row.machine, row.tolerance),
                clock(row.programmed_time_s),
                clock(row.cycle_time_s),
            ]
        };
        let rows: Vec<Vec<String>> = self.operations.iter().enumerate().map(row).collect();
        let sum =
            ["Together", "", &clock(self.programmed_time_s), &clock(self.cycle_time_s)].map(str::to_string);
        body += &table("Operations", &["", "", "CAM estimate", "Time"], &rows, Some(&sum));
        for (picture, caption) in pictures {
            let caption = escaped(caption);
            body +=
                &format!("<figure>{picture}<figcaption class=\"small\">{caption}</figcaption></figure>\n");
        }
        let mut sure: Vec<&str> = self.operations.iter().map(|row| row.uncertainty.as_str()).collect();
        sure.dedup();
        body += &sure.into_iter().map(paragraph).collect::<String>();
        body += &paragraph(&format!("Computed by Truefeed {VERSION}."));
        document(&title, &body)
    }
}
