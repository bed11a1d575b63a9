//! The reference pages are what the parameter table and the commands' help say.

#[allow(dead_code)]
#[path = "../examples/reference.rs"]
mod example;

#[test]
fn the_keys_of_the_machine_file_are_those_of_the_table() {
    assert_eq!(example::machine_file(), include_str!("../docs/machine-file.md"), "{AGAIN}");
}

#[test]
fn the_commands_are_those_of_the_help() {
    assert_eq!(example::commands(), include_str!("../docs/cli.md"), "{AGAIN}");
}

const AGAIN: &str = "run `cargo run --example reference` again";
