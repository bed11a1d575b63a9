//! Writes programs of every kind in every dialect: `cargo run --release --example corpus -- FOLDER [SEED]`.
//!
//! Each kind of job is drawn once as a list of moves and written in each dialect's own words, so that all files of one
//! kind must give one toolpath. Sizes, feedrates and shapes come from the seed. The programs in `tests/corpus` are those
//! of seed 1.

mod dialects;
mod jobs;

use std::path::PathBuf;

fn main() -> std::io::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let folder = PathBuf::from(arguments.next().expect("usage: corpus FOLDER [SEED]"));
    let seed = arguments.next().map_or(1, |seed| seed.parse().expect("SEED is a whole number"));
    std::fs::create_dir_all(&folder)?;
    for (kind, moves) in jobs::all(seed) {
        for dialect in dialects::ALL {
            let path = folder.join(format!("{kind}-{}.{}", dialect.name, dialect.extension));
            std::fs::write(path, (dialect.write)(&moves))?;
        }
    }
    Ok(())
}
