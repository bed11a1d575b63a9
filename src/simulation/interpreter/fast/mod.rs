//! Fast paths with the results of the reference path: plain blocks, programs read part by part, and WebAssembly
//! modules without rare words.

pub(super) mod plain;
pub(super) mod rare;
pub(super) mod streaming;
