//! The fourth case study of Ward et al. 2021, cutting forces in an open pocket, computed again:
//! writes `docs/forces.md` and `docs/forces.svg`.
//!
//! `cargo run --release --example forces`

#[allow(dead_code)]
#[path = "../paper/chart.rs"]
mod chart;
mod page;
mod path;

fn main() -> std::io::Result<()> {
    let docs = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
    let page = page::page();
    std::fs::write(docs.join("forces.svg"), &page.picture)?;
    std::fs::write(docs.join("forces.md"), &page.text)?;
    for (name, section) in [("trochoid", &page.case.trochoid), ("cornering", &page.case.corners)] {
        println!(
            "{name}: {:.0} N by the programmed feed, {:.0} N by the predicted",
            section.programmed, section.predicted
        );
    }
    Ok(())
}
