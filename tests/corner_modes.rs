//! The page on the cost of the corner modes says what the program computes.

#[allow(dead_code)]
#[path = "../examples/corner_modes.rs"]
mod example;

#[test]
fn the_page_is_what_the_command_writes() {
    let page = include_str!("../docs/corner-modes.md");
    assert_eq!(example::page(&[]).expect("the sample is there"), page, "run the example again");
}
