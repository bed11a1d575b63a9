//! A diagnosis for people and programs: its report, account, sentences, charts and document.

mod account;
mod chart;
mod html;
mod parameter_text;
mod report;
mod rows;
mod sentence;

pub use chart::{RunChart, diagnosis_chart};
pub use report::{DiagnosisReport, extended};
