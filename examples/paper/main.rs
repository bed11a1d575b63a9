//! Ward et al. 2021 computed again: writes `docs/paper.md` and the figures in `docs/paper/`.
//!
//! `cargo run --release --example paper`

mod aerostructure;
mod chart;
mod figures;
mod page;
mod path;
mod pockets;

fn main() -> std::io::Result<()> {
    let docs = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
    std::fs::create_dir_all(docs.join("paper"))?;
    for (name, svg) in figures::all() {
        std::fs::write(docs.join("paper").join(name).with_extension("svg"), svg)?;
    }
    let page = page::page();
    std::fs::write(docs.join("paper.md"), &page.text)?;
    println!("Table 1, rows not used for choosing: within {:.1} % of the paper", 100.0 * page.pockets);
    for (section, tolerance, miss) in page.sections {
        println!("Table 4, {section} at {tolerance:.0} µm, not used for choosing: {:+.1} %", 100.0 * miss);
    }
    Ok(())
}
