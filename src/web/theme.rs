//! The page's theme: its colours, and its user's number format.

use std::cell::RefCell;

use js_sys::Function;
use wasm_bindgen::prelude::*;

use crate::plot::Theme;

thread_local! {
    static NUMBERS: RefCell<Option<Function>> = const { RefCell::new(None) };
}

/// Sets the formatter of numbers in all pictures: a function of a number and its decimals.
#[wasm_bindgen(js_name = setNumbers)]
pub fn set_numbers(write: Function) {
    NUMBERS.with(|numbers| *numbers.borrow_mut() = Some(write));
}

/// Returns the theme, light on dark or dark on light.
pub(super) fn theme(dark: bool) -> Theme {
    let theme = if dark { Theme::DARK } else { Theme::LIGHT };
    Theme { numbers: written, ..theme }
}

fn written(value: f64, decimals: usize) -> String {
    let text = NUMBERS.with(|numbers| {
        let write = numbers.borrow();
        write.as_ref()?.call2(&JsValue::NULL, &value.into(), &(decimals as f64).into()).ok()?.as_string()
    });
    text.unwrap_or_else(|| (Theme::LIGHT.numbers)(value, decimals))
}
