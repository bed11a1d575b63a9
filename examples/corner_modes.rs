//! What the corner modes cost: cycle times of `paper` and `guaranteed` side by side, with the largest
//! contour error of each, as a Markdown table.
//!
//! `cargo run --release --example corner_modes [PROGRAM...]` prints it for the bundled sample and the
//! programs named; without programs it writes `docs/corner-modes.md`.

use std::path::{Path, PathBuf};

use truefeed::machine::{CornerMode, Machine};
use truefeed::simulation::gcode::read;
use truefeed::simulation::interpreter::trace;
use truefeed::simulation::simulate;

const HEAD: &str = "# What the corner modes cost

Cycle times of the two corner modes on the first preset (three filters, T1 = 0.0255 s) and the largest distance of the motion
from the programmed path. `paper` treats each corner as if it were alone, as published; `guaranteed` corrects the plan until the
filtered path holds the tolerance everywhere, and removes unneeded caution. `cargo run --release --example corner_modes` writes
this page; name programs to see your own.

| program | tolerance µm | paper s | error µm | guaranteed s | error µm | difference |
|---|---:|---:|---:|---:|---:|---:|
";

fn main() -> std::io::Result<()> {
    let named: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let text = page(&named)?;
    if named.is_empty() {
        std::fs::write(project().join("docs/corner-modes.md"), &text)?;
    }
    print!("{text}");
    Ok(())
}

fn project() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The table for the bundled sample and the programs named.
pub fn page(named: &[PathBuf]) -> std::io::Result<String> {
    let sample = project().join("www/samples/pocket.nc");
    let mut text = HEAD.to_string();
    for program in std::iter::once(&sample).chain(named) {
        let name = program.file_name().unwrap_or_default().to_string_lossy().into_owned();
        text += &rows(&name, &std::fs::read(program)?);
    }
    Ok(text)
}

fn rows(name: &str, program: &[u8]) -> String {
    let mut machine = Machine::default();
    let toolpath = trace(&read(program), &machine);
    let rows = [0.010, 0.020, 0.050].map(|tolerance| {
        let mut of = |mode: CornerMode| {
            machine.interpolator.corner_mode = mode;
            let (plan, errors) = simulate::within(&toolpath, &machine, tolerance, &mut |_| {});
            (plan.cycle_time(), 1e3 * errors.largest())
        };
        let (paper, paper_error) = of(CornerMode::Paper);
        let (guaranteed, guaranteed_error) = of(CornerMode::Guaranteed);
        let change = 100.0 * (guaranteed / paper - 1.0);
        let tolerance = 1e3 * tolerance;
        format!(
            "| {name} | {tolerance:.0} | {paper:.2} | {paper_error:.1} | {guaranteed:.2} | {guaranteed_error:.1} | {change:+.2} % |\n"
        )
    });
    rows.concat()
}
