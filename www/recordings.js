// Which recording is of which program, which is in sight, and which may calibrate the machine.

/** @import { Program, Recording, State } from "./types.js" */

/** A file's name without its extension, in small letters. @param {string} name */
const stem = (name) => name.toLowerCase().replace(/\.[^.]*$/, '')

/** Which of these programs a recording is called after; none where its name begins with none of theirs. @param {string} name @param {readonly {id: number, name: string}[]} programs */
export function namesake(name, programs) {
  const alike = programs.filter((program) => stem(name).startsWith(stem(program.name)))
  alike.sort((a, b) => b.name.length - a.name.length || b.id - a.id)
  return alike[0]?.id ?? null
}

/** The programs that a recording may be of, as text to be compared. @param {readonly {id: number, dialect: string | null}[]} programs */
export const candidates = (programs) => JSON.stringify(programs.map(({ id, dialect }) => [id, dialect]))

/**
 * The program of a recording: the one chosen, else the only one, else the one that it was compared with, else the one that
 * was found; null where it is still to be found.
 * @param {number | null} chosen
 * @param {Pick<Recording, "program" | "match" | "found"> | undefined} before
 * @param {readonly {id: number, dialect: string | null}[]} programs
 */
export function programFor(chosen, before, programs) {
  if (chosen !== null) return chosen
  if (programs.length === 1) return programs[0].id
  if (before?.match?.report && programs.some(({ id }) => id === before.program)) return before.program
  return before?.found?.of === candidates(programs) ? before.found.program : null
}

/** Whether a recording fits none of the programs that are open. @param {Recording} recording */
export const isOfNone = ({ chosen, found, match }) => chosen === null && found?.among.length === 0 && !match?.report

/** Whether it is still to be found which program a recording is of. @param {Recording} recording @param {State} state */
export const isToPair = ({ program, found }, { programs }) => program === null && programs.length > 1 && found?.of !== candidates(programs)

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
export const usable = (state) => state.recordings.filter((recording) => recording.used && recording.match?.report && programOf(recording, state))
