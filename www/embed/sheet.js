// How <truefeed-quote> looks. Text and ground are those of the page around it; the variables change the rest.

const CSS = `
:host {
  --_accent: var(--truefeed-accent, light-dark(#0b5d91, #6bb7e6));
  --_muted: var(--truefeed-muted, color-mix(in srgb, currentColor 68%, transparent));
  --_line: var(--truefeed-line, color-mix(in srgb, currentColor 18%, transparent));
  --_error: var(--truefeed-error, light-dark(#b3261e, #ff8a80));
  display: block;
  box-sizing: border-box;
  min-width: 0;
  padding: var(--truefeed-padding, 14px 16px);
  font: var(--truefeed-font, 14px/1.45 system-ui, sans-serif);
  color: var(--truefeed-text, inherit);
  background: var(--truefeed-ground, transparent);
  border: 1px solid var(--_line);
  border-radius: var(--truefeed-radius, 8px);
}
:host([hidden]), [hidden] { display: none !important; }
:host(.over) { border-color: var(--_accent); border-style: dashed; }
p { margin: 0; }
.head { display: flex; flex-wrap: wrap; gap: 6px 14px; align-items: baseline; justify-content: space-between; }
.headline { margin-top: 8px; font-size: 1.9em; line-height: 1.15; letter-spacing: -0.02em; font-variant-numeric: tabular-nums; }
.headline .price { margin-left: 0.5em; }
.headline .about { font-size: 0.45em; letter-spacing: 0; }
img { display: block; max-width: 100%; height: auto; margin-top: 10px; border-radius: 6px; }
.title { font-weight: 650; overflow-wrap: anywhere; }
.about, .note { color: var(--_muted); font-size: 0.9em; }
.note { margin-top: 8px; }
label { cursor: pointer; color: var(--_accent); font-weight: 600; border-radius: 4px; white-space: nowrap; }
label:focus-within { outline: 2px solid var(--_accent); outline-offset: 2px; }
input { position: absolute; width: 1px; height: 1px; opacity: 0; }
progress { width: 100%; margin-top: 10px; accent-color: var(--_accent); }
.scroll { overflow-x: auto; container-type: inline-size; }
@container (max-width: 460px) { .minor { display: none; } }
table { width: 100%; margin-top: 10px; border-collapse: collapse; font-variant-numeric: tabular-nums; }
th { font-weight: 550; font-size: 0.9em; color: var(--_muted); }
th, td { padding: 5px 0 5px 12px; text-align: right; white-space: nowrap; }
th:first-child { padding-left: 0; text-align: left; }
tbody th { color: inherit; font-size: inherit; }
tr + tr > *, tbody > tr > * { border-top: 1px solid var(--_line); }
td.time { font-weight: 650; }
.stale, .stale * { color: var(--_muted); font-style: italic; }
.error { margin-top: 10px; padding-left: 10px; border-left: 3px solid var(--_error); overflow-wrap: anywhere; }
details { margin-top: 8px; }
summary { cursor: pointer; color: var(--_muted); font-size: 0.9em; }
ul { margin: 4px 0 0; padding-left: 18px; font-size: 0.9em; overflow-wrap: anywhere; }
`

/** @type {CSSStyleSheet | undefined} */
let sheet

/** One sheet for all elements; made by script, it needs no leave for inline styles from the policy of a page. */
export function sheetOfQuote() {
  if (!sheet) {
    sheet = new CSSStyleSheet()
    sheet.replaceSync(CSS)
  }
  return sheet
}
