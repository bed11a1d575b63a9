// Which recording is of which program, which is in sight, and which may calibrate the machine.

/** @import { Program, Recording, State } from "./types.js" */

/** A file's name without its extension, in small letters. @param {string} name */
const stem = (name) => name.toLowerCase().replace(/\.[^.]*$/, '')

/** The program a new recording is of: the one whose name its own begins with, else the one in sight. @param {string} name @param {State} state */
export function pairs(name, { programs, selected }) {
  const alike = programs.filter((program) => stem(name).startsWith(stem(program.name)))
  alike.sort((a, b) => b.name.length - a.name.length || b.id - a.id)
  return alike[0]?.id ?? selected
}

/** The program of a recording. @param {Recording} recording @param {State} state @returns {Program | undefined} */
export const programOf = ({ program }, { programs }) => programs.find(({ id }) => id === program)

/** The recording in sight: the one chosen, if it is of the program in sight, else the first that is. @param {State} state */
export function recordingOf({ recordings, recording, selected }) {
  const own = recordings.filter(({ program }) => program === selected)
  return own.find(({ id }) => id === recording) ?? own[0]
}

/** What a diagnosis is made from, to tell later whether it still is: recordings, their programs and how these are read. @param {State} state */
export function evidence(state) {
  const used = state.recordings.filter(({ used, match }) => used && !match?.refusal)
  return JSON.stringify(used.map((recording) => [recording.id, recording.program, programOf(recording, state)?.dialect]))
}

/** The recordings that can calibrate the machine. @param {State} state */
export const usable = (state) =>
  state.recordings.filter((recording) => recording.used && recording.match?.report && programOf(recording, state))
