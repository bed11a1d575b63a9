//! The command line: files in, files and text out, over the same core as the page.

fn main() {}
