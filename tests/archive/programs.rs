//! Folders of small programs that nobody wrote by hand, the same at each run.

use std::fmt::Write;
use std::fs::{create_dir_all, write};
use std::path::{Path, PathBuf};

/// Marsaglia's xorshift.
struct Random(u64);

impl Random {
    fn below(&mut self, bound: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) % bound
    }

    /// A coordinate, mm.
    fn place(&mut self) -> f64 {
        self.below(100_000) as f64 / 1000.0 - 50.0
    }
}

/// Writes `count` programs into folders below `root`; some are faulty, some say their dialect, some have no extension.
pub fn write_programs(root: &Path, count: usize) -> Vec<PathBuf> {
    let mut random = Random(0x5eed_a4c4);
    let paths = (0..count).map(|number| {
        let folder = root.join(format!("job {}", number % 7)).join(format!("{}", number % 3));
        create_dir_all(&folder).expect("a writable folder");
        let (name, text) = match number % 50 {
            11 => (format!("part{number}.mpf"), siemens(&mut random)),
            21 => (format!("part{number}.H"), klartext(&mut random)),
            31 => (format!("{number}"), milled(&mut random)),
            41 => (format!("empty{number}.nc"), String::new()),
            42 => (format!("noise{number}.nc"), "\u{1}G1 X%%Y\u{7f}\n#1=[1/0\nG2 X\n".to_string()),
            _ => (format!("part{number}.nc"), milled(&mut random)),
        };
        let path = folder.join(name);
        write(&path, text).expect("a writable folder");
        path
    });
    paths.collect()
}

fn milled(random: &mut Random) -> String {
    let mut text = format!("%\nO{}\nT{} M6\nG0 X0 Y0 Z5\n", 1000 + random.below(8000), 1 + random.below(9));
    for _ in 0..5 + random.below(25) {
        let (x, y, feed) = (random.place(), random.place(), 500 + random.below(6000));
        writeln!(text, "G1 X{x} Y{y} F{feed}").expect("text has room");
    }
    text + "G4 P0.5\nM30\n%\n"
}

fn siemens(random: &mut Random) -> String {
    let mut text = "N10 G90 G54 G642\nN20 R1=5\n".to_string();
    for _ in 0..5 + random.below(15) {
        writeln!(text, "G1 X={}+R1 Y={} F3000", random.place(), random.place()).expect("text has room");
    }
    text + "M30\n"
}

fn klartext(random: &mut Random) -> String {
    let mut text = "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S1000\n".to_string();
    let lines = 5 + random.below(15);
    for line in 0..lines {
        writeln!(text, "{} L X{:+} Y{:+} R0 F2000", line + 2, random.place(), random.place())
            .expect("text has room");
    }
    text + &format!("{} END PGM A MM\n", lines + 2)
}
