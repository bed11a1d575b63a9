//! The page's theme: its colours, and its user's number format and unit of length.

use std::cell::RefCell;

use js_sys::Function;
use wasm_bindgen::prelude::*;

use crate::plot::Theme;
use crate::units::LengthUnit;

thread_local! {
    static NUMBERS: RefCell<Option<Function>> = const { RefCell::new(None) };
    static UNIT: RefCell<Option<Function>> = const { RefCell::new(None) };
}

/// Sets the formatter of numbers in all pictures: a function of a number and its decimals.
#[wasm_bindgen(js_name = setNumbers)]
pub fn set_numbers(write: Function) {
    NUMBERS.with(|numbers| *numbers.borrow_mut() = Some(write));
}

/// Sets the function that returns the word of the unit in which pictures and labels show lengths.
#[wasm_bindgen(js_name = setLengthUnit)]
pub fn set_length_unit(word: Function) {
    UNIT.with(|unit| *unit.borrow_mut() = Some(word));
}

/// Returns the unit in which the page shows lengths; millimetres in a worker, which has no such function.
pub(super) fn length_unit() -> LengthUnit {
    let word = UNIT.with(|word| word.borrow().as_ref()?.call0(&JsValue::NULL).ok()?.as_string());
    word.and_then(|word| LengthUnit::from_word(&word)).unwrap_or_default()
}

/// Returns the theme of the page, light on dark or dark on light.
pub(super) fn theme(dark: bool) -> Theme {
    let theme = if dark { Theme::DARK } else { Theme::LIGHT };
    Theme { numbers: written, unit: length_unit(), ..theme }
}

/// Returns the theme of documents for others: dark on light, in millimetres.
#[cfg(not(first_visit))]
pub(super) fn theme_of_documents() -> Theme {
    Theme { numbers: written, ..Theme::LIGHT }
}

fn written(value: f64, decimals: usize) -> String {
    let text = NUMBERS.with(|numbers| {
        let write = numbers.borrow();
        write.as_ref()?.call2(&JsValue::NULL, &value.into(), &(decimals as f64).into()).ok()?.as_string()
    });
    text.unwrap_or_else(|| (Theme::LIGHT.numbers)(value, decimals))
}
