//! The table of words says what reading and tracing do with them.

#[allow(dead_code)]
#[path = "../examples/words.rs"]
mod example;

#[test]
fn the_page_is_what_the_command_writes() {
    let page = include_str!("../docs/words.md");
    assert_eq!(example::page(), page, "run `cargo run --example words` again");
}
