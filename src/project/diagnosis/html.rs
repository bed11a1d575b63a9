//! A diagnosis as one self-contained HTML document: no scripts, no other files, the charts inline as SVG. The
//! document is well-formed XML except for its first line, and has the content and order of the page.

use crate::plot::{Theme, escaped};
use crate::project::VERSION;
use crate::project::diagnosis::account::{AccountRow, WaterfallStep};
use crate::project::diagnosis::report::DiagnosisReport;
use crate::project::diagnosis::rows::{BeforeAfter, CauseRow, RegionRow};
use crate::project::recording::comparison::lost_label;

const DIAGNOSIS_STYLE: &str = "body{font:15px/1.5 system-ui,sans-serif;color:#1d242c;background:#fff;max-width:1040px;\
    margin:24px auto;padding:0 16px}h1{font-size:24px;line-height:1.3}h2{font-size:17px;margin:28px 0 6px}\
    table{border-collapse:collapse}th,td{text-align:left;padding:3px 18px 3px 0;border-bottom:1px solid #dde1e6;\
    vertical-align:top}.account td{vertical-align:middle}.account td:nth-child(2){text-align:right;white-space:nowrap}\
    .bar{position:relative;width:420px;padding:0}.bar i{position:absolute;top:4px;bottom:4px;min-width:2px;\
    background:#8a949f;print-color-adjust:exact}.bar i.cause{background:#d95f02}.bar i.unexplained{background:#7b3294}figure{margin:12px 0}svg{max-width:100%;height:auto}.small{color:#5b6672;font-size:13px}";

impl DiagnosisReport {
    /// Returns the HTML document, with the chart of each recording as SVG; `theme` applies to the charts that
    /// this function draws.
    pub fn to_html(&self, charts: &[String], theme: &Theme) -> String {
        let names = self.runs.join(", ");
        let mut body = format!("<h1>{}</h1>\n", escaped(&self.sentence));
        body += &format!("<p class=\"small\">Diagnosis of {} by Truefeed {VERSION}.</p>\n", escaped(&names));
        body += &self.account.as_ref().map_or(String::new(), waterfall);
        for cause in &self.causes {
            body += &of_cause(cause);
        }
        if !charts.is_empty() {
            body += "<h2>Before and after</h2>\n";
        }
        for (picture, name) in charts.iter().zip(&self.runs) {
            let caption = format!(
                "{}: feedrate recorded, simulated before and after; below the time lost, before and after",
                escaped(name)
            );
            body +=
                &format!("<figure>{picture}<figcaption class=\"small\">{caption}.</figcaption></figure>\n");
        }
        body += &table("Fit", &["", "Before", "After", ""], &self.numbers());
        let changes: Vec<Vec<String>> = self
            .changes
            .iter()
            .map(|change| {
                [&*change.label, &*change.before, &*change.after, change.unit].map(str::to_string).to_vec()
            })
            .collect();
        body += &table("Changed in the machine", &["", "Before", "After", ""], &changes);
        let regions: Vec<Vec<String>> = self.regions.iter().map(|region| self.of_region(region)).collect();
        let title = "Where simulation and recording differ";
        body += &table(title, &["Lines", "Distance", "Recorded at", "Lost", "Of"], &regions);
        body += &self.measured.as_ref().map_or(String::new(), |measured| measured.to_html(theme));
        if !self.not_excited.is_empty() {
            let words: Vec<String> = self.not_excited.iter().map(|id| id.replace('_', " ")).collect();
            body +=
                &format!("<h2>What this program cannot reveal</h2>\n<p>{}</p>\n", escaped(&words.join(", ")));
        }
        for message in &self.messages {
            body += &format!("<p>{}</p>\n", escaped(message));
        }
        format!(
            "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"/><meta name=\"viewport\" \
             content=\"width=device-width\"/><title>Diagnosis of {}</title><style>{DIAGNOSIS_STYLE}</style></head>\n\
             <body>\n{body}</body></html>\n",
            escaped(&names)
        )
    }

    /// Returns the errors before and after, a row for each known number.
    fn numbers(&self) -> Vec<Vec<String>> {
        let row = |name: &str, sides: BeforeAfter, unit: &str, decimals: usize| {
            let number = |value: f64| {
                // A number that rounds to 0 is written without a sign.
                let size = 10f64.powi(decimals as i32);
                format!("{:.decimals$}", (value * size).round() / size + 0.0).replace('-', "−")
            };
            let (before, after) = (sides.before?, sides.after?);
            Some(vec![name.to_string(), number(before), number(after), unit.to_string()])
        };
        let fit = &self.fit;
        let rows = [
            row("Cycle time, simulated minus recorded", fit.cycle_time_error_s, "s", 3),
            row("Feed RMSE", fit.feed_rmse_mm_min, "mm/min", 1),
            row("Feed RMSE outside the fit", fit.held_out.feed_rmse_mm_min, "mm/min", 1),
            row("Position RMSE", fit.position_rmse_mm, "mm", 4),
        ];
        rows.into_iter().flatten().collect()
    }

    fn of_region(&self, region: &RegionRow) -> Vec<String> {
        vec![
            range(region.lines),
            format!("{:.1} to {:.1} mm", region.distance_mm[0], region.distance_mm[1]),
            format!("{:.2} to {:.2} s", region.time_s[0], region.time_s[1]),
            lost_label(region.seconds),
            self.runs.get(region.run).cloned().unwrap_or_default(),
        ]
    }
}

/// Returns the account as a table with a bar per row.
fn waterfall(account: &AccountRow) -> String {
    let (steps, notes) = account.table();
    let row = |step: &WaterfallStep| {
        let WaterfallStep { name, text, kind, bar: [from, to] } = step;
        let place = format!("left:{:.2}%;width:{:.2}%", 100.0 * from, 100.0 * (to - from));
        format!(
            "<tr><td>{}</td><td>{text}</td><td class=\"bar\"><i class=\"{kind}\" style=\"{place}\"></i></td></tr>",
            escaped(name)
        )
    };
    let rows: String = steps.iter().map(row).collect();
    let notes = escaped(&notes.join(" "));
    format!("<h2>Account</h2>\n<table class=\"account\">{rows}</table>\n<p class=\"small\">{notes}</p>\n")
}

fn of_cause(cause: &CauseRow) -> String {
    let mut text = format!("<h2>{}</h2>\n<p>{}</p>\n", escaped(&cause.name), escaped(&cause.sentence));
    let mut rows: Vec<Vec<String>> = cause
        .told
        .iter()
        .map(|told| vec![told.name_and_value().0.to_string(), told.name_and_value().1])
        .collect();
    let mut row = |name: &str, value: String| rows.push(vec![name.to_string(), value]);
    if !cause.lines.is_empty() {
        let lines: Vec<String> = cause.lines.iter().map(|lines| range(*lines)).collect();
        row("Lines", lines.join(", "));
    }
    if let Some(confidence) = cause.confidence {
        row("How sure", format!("{:.0} %", 100.0 * confidence));
    }
    if let Some([better, worse]) = cause.sections {
        row("Sections outside the fit", format!("better in {better}, worse in {worse}"));
    }
    let others: Vec<String> = cause.indistinguishable_from.iter().map(|id| id.replace('_', " ")).collect();
    row(
        "Other possible causes",
        if others.is_empty() { "nothing known".to_string() } else { others.join(", ") },
    );
    if !cause.vendors.is_empty() {
        row("Settings", cause.vendors.to_string());
    }
    text += &rows_of(&rows);
    text
}

fn range([first, last]: [u32; 2]) -> String {
    if first == last { first.to_string() } else { format!("{first}–{last}") }
}

/// Returns a table below its title; empty without rows.
fn table(title: &str, head: &[&str], rows: &[Vec<String>]) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let head: String = head.iter().map(|cell| format!("<th>{}</th>", escaped(cell))).collect();
    let rows = rows_of(rows).replacen("<table>", &format!("<table><tr>{head}</tr>"), 1);
    format!("<h2>{}</h2>\n{rows}", escaped(title))
}

fn rows_of(rows: &[Vec<String>]) -> String {
    let cells =
        |row: &Vec<String>| row.iter().map(|cell| format!("<td>{}</td>", escaped(cell))).collect::<String>();
    let rows: String = rows.iter().map(|row| format!("<tr>{}</tr>", cells(row))).collect();
    format!("<table>{rows}</table>\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identification::diagnosis::diagnose;
    use crate::identification::fit::{AlignedRun, Run};
    use crate::plot::{FeedChart, svg};
    use crate::project::{RunChart, diagnosis_chart, machine_from_toml};
    use crate::simulation::gcode::read;
    use crate::simulation::interpreter::trace;

    const PROGRAM: &[u8] = include_bytes!("../../../www/samples/standin.nc");
    const RECORDING: &[u8] = include_bytes!("../../../www/samples/standin.csv");
    const MACHINE: &str = include_str!("../../../www/samples/standin.toml");

    #[test]
    fn the_document_is_well_formed_and_says_what_was_found() {
        let machine = machine_from_toml(MACHINE).expect("the sample's machine can be read");
        let toolpath = trace(&read(PROGRAM), &machine);
        let recorded = AlignedRun::new(toolpath, RECORDING, &machine).expect("the sample can be compared");
        let runs: Vec<Run> = vec![recorded.run_ignoring_overrides()];
        let diagnosis = diagnose(&machine, &runs, &mut |_| {});
        let name = "a <b> & \"c\".csv".to_string();
        let report = DiagnosisReport::new(&diagnosis, &[name]).beside(&machine);
        let drawn = diagnosis_chart(&diagnosis, &machine, &runs, 0).expect("there is a run");
        let picture = svg(&drawn.chart, &Theme::LIGHT, (1040, 560)).expect("it can be drawn");
        let messages = report.messages.clone();
        let report = report.drawn_by(&[drawn]);
        assert_eq!(report.messages, messages, "a chart that leaves nothing out says nothing");
        let report = report.drawn_by(&[RunChart { spacing: Some(0.02), chart: FeedChart::default() }]);
        let html = report.to_html(&[picture], &Theme::LIGHT);
        let (first, rest) = html.split_once('\n').expect("it has lines");
        assert_eq!(first, "<!doctype html>");
        let document = roxmltree::Document::parse(rest).expect("it is well-formed");
        let named = |name: &str| document.descendants().filter(|node| node.tag_name().name() == name).count();
        assert_eq!((named("svg"), named("script"), named("link"), named("img")), (1, 0, 0, 0));
        let all: String = document.descendants().filter_map(|node| node.text()).collect();
        for words in [
            "78 % of the programmed feed",
            "simulated before",
            "simulated after",
            "Time lost",
            "unexplained",
            "Unexplained, added up region by region",
            "a <b> & \"c\".csv",
            "Chart of a <b> & \"c\".csv: The program is long, so there is one point every 0.020 s",
        ] {
            assert!(all.contains(words), "{words} is missing");
        }
        assert!(report.changes.iter().any(|change| change.key == "override.feed" && change.before == "1"));
    }
}
