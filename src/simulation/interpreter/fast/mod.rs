//! Fast ways that give what the reference path gives: plain blocks, programs read part by part, and modules that leave rare
//! words to another.

pub(super) mod plain;
pub(super) mod rare;
pub(super) mod streaming;
