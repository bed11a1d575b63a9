// The list of programs: adding by file, drop or sample, choosing one, removing with undo.

import { find, make } from "../dom.js";
import { clock, size } from "../format.js";

/** @import { Program, State } from "../types.js" */

const SAMPLE = "samples/pocket.nc";
const UNDO_MS = 10_000;

/**
 * @typedef {object} Actions
 * @property {(files: {name: string, bytes: Uint8Array}[]) => void} addPrograms
 * @property {(id: number) => void} select
 * @property {(id: number) => () => void} removeProgram
 */

/** @param {HTMLElement} root @param {Actions} actions */
export function mount(root, actions) {
  const list = find(root, ".programs");
  const input = /** @type {HTMLInputElement} */ (find(document.body, "#files"));
  const undo = find(root, ".undo");
  let timer = 0;
  let putBack = () => {};

  input.addEventListener("change", async () => {
    await add([...(input.files ?? [])], actions);
    input.value = "";
  });
  for (const button of document.querySelectorAll(".sample")) {
    button.addEventListener("click", async () => {
      const response = await fetch(new URL(`../${SAMPLE}`, import.meta.url));
      actions.addPrograms([{ name: "Sample: pocket.nc", bytes: new Uint8Array(await response.arrayBuffer()) }]);
    });
  }
  find(undo, "button").addEventListener("click", () => {
    undo.hidden = true;
    putBack();
  });
  acceptDrops(actions);

  /** @param {Program} program */
  function remove(program) {
    putBack = actions.removeProgram(program.id);
    find(undo, "span").textContent = `${program.name} removed.`;
    undo.hidden = false;
    clearTimeout(timer);
    timer = window.setTimeout(() => (undo.hidden = true), UNDO_MS);
    find(undo, "button").focus();
  }

  return {
    /** @param {State} state */
    update(state) {
      const focused = document.activeElement?.id;
      list.replaceChildren(
        ...state.programs.map((program) => {
          const chosen = make(
            "button",
            { type: "button", className: "choose", id: `program-${program.id}` },
            make("span", { className: "file" }, program.name),
            make("span", { className: "about" }, about(program, state)),
          );
          if (program.id === state.selected) chosen.setAttribute("aria-current", "true");
          chosen.addEventListener("click", () => actions.select(program.id));
          const removed = make("button", { type: "button", className: "remove", title: "Remove" }, "×");
          removed.setAttribute("aria-label", `Remove ${program.name}`);
          removed.addEventListener("click", () => remove(program));
          return make("li", {}, chosen, removed);
        }),
      );
      if (focused?.startsWith("program-")) document.getElementById(focused)?.focus();
    },
  };
}

/** One line on how a program stands. @param {Program} program @param {State} state */
function about(program, state) {
  if (state.progress?.program === program.id) return "computing …";
  if (program.failure) return "failed";
  const times = state.tolerances.flatMap((tolerance) => program.outcome?.runs.get(tolerance)?.summary.cycle_time_s ?? []);
  if (times.length === 0) return `${size(program.bytes.length)}, waiting`;
  const [longest, shortest] = [clock(Math.max(...times)), clock(Math.min(...times))];
  return longest === shortest ? longest : `${shortest} – ${longest}`;
}

/** @param {File[]} files @param {Actions} actions */
async function add(files, actions) {
  const read = async (/** @type {File} */ file) => ({ name: file.name, bytes: new Uint8Array(await file.arrayBuffer()) });
  const results = await Promise.allSettled(files.map(read));
  const programs = results.flatMap((result) => (result.status === "fulfilled" ? [result.value] : []));
  if (programs.length > 0) actions.addPrograms(programs);
}

/** Files may be dropped anywhere on the page. @param {Actions} actions */
function acceptDrops(actions) {
  const cover = find(document.body, ".cover");
  const carriesFiles = (/** @type {DragEvent} */ event) => event.dataTransfer?.types.includes("Files") ?? false;
  let depth = 0;
  const show = (/** @type {number} */ change) => {
    depth = Math.max(0, depth + change);
    cover.hidden = depth === 0;
  };
  document.addEventListener("dragenter", (event) => carriesFiles(event) && show(1));
  document.addEventListener("dragleave", (event) => carriesFiles(event) && show(-1));
  document.addEventListener("dragover", (event) => carriesFiles(event) && event.preventDefault());
  document.addEventListener("drop", (event) => {
    if (!carriesFiles(event)) return;
    event.preventDefault();
    show(-depth);
    add([...(event.dataTransfer?.files ?? [])], actions);
  });
}
