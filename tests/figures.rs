//! Figures that one page repeats from another: the page that a command writes has them first, and the others must follow it.

use std::path::Path;

use crate::shared::pages::ROOT;

pub fn page(name: &str) -> String {
    std::fs::read_to_string(Path::new(ROOT).join(name)).expect("pages are text")
}

/// The cells of the table rows between a heading and the next one.
fn table(text: &str, heading: &str) -> Vec<Vec<String>> {
    let (_, after) = text.split_once(&format!("\n## {heading}")).expect("the page has this heading");
    let section = after.split("\n## ").next().expect("a first part");
    let rows = section.lines().filter(|line| line.starts_with("| ") && !line.contains("---"));
    rows.map(|line| line.trim_matches('|').split('|').map(|cell| cell.trim().to_string()).collect()).collect()
}

/// The first number in a cell; a page may write its minus as a sign of mathematics.
pub fn number(cell: &str) -> f64 {
    let plain = cell.replace('−', "-").replace(',', "");
    let text = plain.trim_start_matches(|c: char| !c.is_ascii_digit() && c != '-' && c != '+');
    let end = text.find(|c: char| !c.is_ascii_digit() && !"+-.".contains(c)).unwrap_or(text.len());
    text[..end].parse().unwrap_or_else(|_| panic!("no number in `{cell}`"))
}

/// The numbers of a page's table row that begins with these cells, cell by cell; each may hold several.
pub fn row(name: &str, start: &str) -> Vec<Vec<f64>> {
    let text = page(name);
    let line =
        text.lines().find(|line| line.starts_with(start)).unwrap_or_else(|| panic!("{name}: no {start}"));
    let cells = line[start.len()..].trim_end_matches('|').split('|');
    let numbers = |cell: &str| match cell.contains('%') {
        true => cell.split(',').map(number).collect(),
        false => Vec::new(),
    };
    cells.map(numbers).collect()
}

/// Percentages that a page states, against those found: as good as equal.
pub fn agree(stated: &[f64], found: &[f64], what: &str) {
    let is_near = |(stated, found): (&f64, &f64)| (stated - found).abs() < 0.051;
    assert!(
        stated.len() == found.len() && stated.iter().zip(found).all(is_near),
        "{what}: the page states {stated:?} %, found {found:?} %"
    );
}

fn holds(name: &str, wanted: &[String]) {
    let text = page(name);
    let missing: Vec<_> = wanted.iter().filter(|figure| !text.contains(&***figure)).collect();
    assert!(missing.is_empty(), "{name} does not have {missing:?}");
}

/// Signed and with as many digits as the pages write, with their sign for a minus.
fn signed(value: f64, digits: usize) -> String {
    format!("{value:+.digits$}").replace('-', "−")
}

fn least_and_largest(values: &[f64]) -> (f64, f64) {
    (
        values.iter().copied().fold(f64::INFINITY, f64::min),
        values.iter().copied().fold(-f64::INFINITY, f64::max),
    )
}

#[test]
fn figures_of_the_paper_are_those_of_its_page() {
    let paper = page("docs/paper.md");
    let pockets = table(&paper, "Table 1")[1..].to_vec();
    let part = table(&paper, "Table 4")[1..].to_vec();
    assert_eq!((pockets.len(), part.len()), (8, 9));
    // Cells from the end: ours against measured, …, measured, CAM.
    let ours = |row: &Vec<String>| number(&row[row.len() - 1]);
    let cam = |row: &Vec<String>| 100.0 * (number(&row[row.len() - 6]) / number(&row[row.len() - 5]) - 1.0);
    let of = |name: &str| {
        let found = pockets.iter().find(|row| row[..3] == [name, "3000", "10"]);
        found.expect("the row that the README names")
    };
    let readme: Vec<String> = ["trochoid", "contour"]
        .map(|name| format!("| {} % | {} % |", signed(cam(of(name)), 0), signed(ours(of(name)), 1)))
        .into();
    let times: Vec<f64> = part.iter().map(ours).collect();
    let cams: Vec<f64> = part.iter().map(cam).collect();
    let ((low, high), (cam_low, cam_high)) = (least_and_largest(&times), least_and_largest(&cams));
    let row = format!(
        "| {} to {} % | {} to {} % |",
        signed(cam_high, 0),
        signed(cam_low, 0),
        signed(low, 0),
        signed(high, 0)
    );
    holds("README.md", &[readme, vec![row]].concat());
    let times: Vec<f64> = pockets.iter().map(ours).collect();
    let cams: Vec<f64> = pockets.iter().map(cam).collect();
    let (best, worst) = (least_and_largest(&times), least_and_largest(&cams));
    holds(
        "docs/accuracy.md",
        &[
            format!("{} to {} % of the measured times", signed(best.0, 1), signed(best.1, 1)),
            format!("CAM {} to {} %", signed(worst.1, 1), signed(worst.0, 0)),
            format!(
                "{} to {} %; CAM {} to {} %",
                signed(low, 1),
                signed(high, 1),
                signed(cam_high, 0),
                signed(cam_low, 0)
            ),
        ],
    );
}

#[test]
fn figures_of_forces_and_speed_are_those_of_their_pages() {
    let peaks = table(&page("docs/forces.md"), "Peaks")[1..3].to_vec();
    let ratios =
        format!("{} and {}, the paper {} and {}", peaks[0][3], peaks[1][3], peaks[0][6], peaks[1][6]);
    let speed = page("docs/speed.md");
    let plan = table(&speed, "1000000 lines of finishing").into_iter().find(|row| row[0] == "plan");
    let plan = plan.expect("a row for planning");
    holds("docs/accuracy.md", &[ratios, format!("in {} times the time async-gcode takes", plan[2])]);
    let seconds = number(&plan[1]) * 1e-9 * 1e6;
    holds(
        "CHANGELOG.md",
        &[format!("a million lines planned in {seconds:.2} s with {} times the memory of the file", plan[4])],
    );
}

#[test]
fn figures_of_the_diagnosis_are_those_of_its_proof() {
    let proof = page("docs/diagnosis.md");
    let figure = |what: &str| {
        let row = proof.lines().find(|line| line.starts_with(&format!("| {what} |"))).expect("a row");
        row.trim_matches('|').split('|').next_back().expect("a second cell").trim().to_string()
    };
    let first = figure("single causes named first");
    let negatives = figure("negatives with a cause named");
    let (named, of) = negatives.split_once(" of ").expect("a count of a number");
    let clean = number(of) - number(named);
    let within = number(&figure("parameters within their 90 %"));
    let command = proof.lines().rfind(|line| line.starts_with("`scripts/proof ")).expect("the command");
    let after = proof.lines().find(|line| line.starts_with("| the diagnosis |")).expect("a row");
    let median = after.split('|').nth(2).expect("a cell").trim().to_string();
    holds(
        "docs/accuracy.md",
        &[
            format!("{first} hidden causes named first"),
            format!("nothing named in {clean} of {of} clean runs"),
            format!("{within:.0} % of parameters within their 90 % interval"),
            format!("with {median} median error"),
            command.to_string(),
        ],
    );
}

#[test]
fn figures_of_seeds_are_those_of_their_page() {
    let rows = table(&page("docs/seeds.md"), "The newest");
    let of_all = |what: &str| {
        let row = rows.iter().find(|row| row[0] == what).expect("a row of this name");
        row.last().expect("a column of all controls").clone()
    };
    let figures = [
        format!("{} programs", of_all("programs")),
        format!("{} clean runs", of_all("clean runs in which a cause was named")),
        format!("{} named right first", of_all("visible changes whose cause was named first")),
        format!("in {} wrong causes alone", of_all("wrong causes alone were named")),
        format!(
            "{} cycle times of other programs",
            of_all("times of other programs within the stated range")
        ),
    ];
    holds("docs/accuracy.md", &figures);
    holds("README.md", &figures[..4]);
}

#[test]
fn figures_of_doubts_and_executions_add_up() {
    let rows = table(&page("docs/trust.md"), "How well the bound holds")[1..].to_vec();
    let count = |row: &Vec<String>| {
        let (held, all) = row[1].split_once(" of ").expect("a count of a number");
        (number(held), number(all))
    };
    let (parts, all) = rows.split_at(rows.len() - 1);
    let sum = parts.iter().map(count).fold((0.0, 0.0), |sum, part| (sum.0 + part.0, sum.1 + part.1));
    assert_eq!(sum, count(&all[0]), "the rows of docs/trust.md");
    holds("docs/accuracy.md", &[format!("[{} damaged programs]", all[0][1])]);

    let fuzzing = page("docs/fuzzing.md");
    let executions: f64 = table(&fuzzing, "Executions")
        .iter()
        .filter(|row| row.len() == 3)
        .skip(1)
        .map(|row| number(&row[2]))
        .sum();
    assert!(
        fuzzing.contains(&format!("The total is {:.1} million executions", executions / 1e6)),
        "{executions}"
    );
}

#[test]
fn limits_of_the_frame_are_those_of_its_protocol() {
    let protocol = page("www/embed/protocol.js");
    let limit = |name: &str| {
        let (_, after) = protocol.split_once(&format!("{name}: ")).expect("a limit of this name");
        let product = after.split(',').next().expect("a value");
        product.split('*').map(number).product::<f64>()
    };
    let thousands = |value: f64| format!("{},{:03}", (value / 1e3).trunc(), value % 1e3);
    holds(
        "docs/embedding.md",
        &[
            format!("programs above {} MiB", limit("programBytes") / 1024.0 / 1024.0),
            format!("above {} characters of JSON", thousands(limit("machineCharacters"))),
            format!("more than {} tolerances", limit("tolerances")),
            format!("names above {} and theme", limit("nameCharacters")),
            format!("above {} characters", limit("themeCharacters")),
            format!("text of up to {} characters", limit("idCharacters")),
        ],
    );
}
