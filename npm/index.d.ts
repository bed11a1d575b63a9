// Types of the package. Lengths are in mm, times in s; prices are in whatever currency the rates of the machine are.

/** A G-code program: its bytes, or its text. */
export type Program = Uint8Array | string

/** What a key of a machine file can be. */
export type MachineValue = number | string | boolean | null | number[] | Record<string, number>

/**
 * A machine: the name of a preset, the text of a machine file (TOML), or values by their key, such as
 * `{ "interpolator.filters": 3, "rates.hourly": 80 }`, laid over a preset if `preset` names one.
 */
export type Machine = string | ({ preset?: string } & Record<string, MachineValue | undefined>)

/** A contour tolerance in mm; null for the program's own. */
export type Tolerance = number | null

export type Dialect = 'iso' | 'linuxcnc' | 'siemens' | 'klartext' | 'heidenhain-iso' | 'grbl' | 'mach' | 'okuma'

export interface QuoteOptions {
  /** What the program is called; it comes back in the quote. */
  name?: string
  /** The control to read it for; without one it is the one that the program shows. */
  dialect?: Dialect | null
  /** Called now and then with the part done, 0 to 1. */
  onProgress?: (part: number) => void
  /** Ends the computation. In Node, which computes in the calling thread, it is heeded before the start only. */
  signal?: AbortSignal
}

/** What machine functions take. */
export interface Functions {
  spindle_s: number
  coolant_s: number
  stops_s: number
  pallet_s: number
  clamp_s: number
  m_words_s: number
  start_s: number
  halts_s: number
}

/** Where the time goes; the parts add up to the whole. */
export interface Breakdown {
  cutting_s: number
  rapid_s: number
  dwell_s: number
  tool_change_s: number
  other_s: number
  /** What `other_s` is made of. */
  other: Functions
}

/** What a part of a program takes. */
export interface Part {
  time_s: number
  programmed_time_s: number
  /** Time less programmed time. */
  lost_s: number
  breakdown: Breakdown
  feed_mm: number
  rapid_mm: number
  blocks: number
}

export interface Operation extends Part {
  /** The line that begins it. */
  line: number
  /** Least and greatest line that it runs. */
  lines: [number, number]
  distance_mm: [number, number]
  tool: number | null
  tool_name: string | null
  name: string | null
}

export interface Tool extends Part {
  tool: number | null
  tool_name: string | null
  operations: number
}

/** Where one of the program's own tolerances holds. */
export interface HeldTolerance {
  lines: [number, number]
  distance_mm: [number, number]
  tolerance_mm: number
  mode: 'exact_stop' | 'machine' | 'tolerance' | 'distance'
  /** The words of the program that ask for it. */
  source: string
}

/** The program at one tolerance. */
export interface Run {
  /** Where the program sets several, the one under which most of the way is cut. */
  tolerance_mm: number
  /** Only for the program's own tolerances. */
  tolerances?: HeldTolerance[]
  cycle_time_s: number
  breakdown: Breakdown
  /** In the order they are run; they add up to the breakdown. */
  operations: Operation[]
  /** In the order of first use; they add up to the breakdown. */
  tools: Tool[]
  /** Time lost against length over feedrate: all of it, the places that cost most, and the rest. */
  lost: {
    seconds: number
    elsewhere_s: number
    places: { reason: string; text: string; lines: [number, number]; distance_mm: [number, number]; seconds: number }[]
  }
  max_contour_error_mm: number
  /** Where the contour error is above the tolerance. */
  beyond_tolerance: { lines: [number, number]; distance_mm: [number, number]; max_contour_error_mm: number }[]
  /** 0 where the machine has no hourly rate. */
  price: number
}

export interface Diagnostic {
  line: number
  severity: 'error' | 'warning' | 'info'
  message: string
}

/** What `truefeed predict --json` prints. */
export interface Quote {
  program: string
  dialect: Dialect
  /** What CAM would say: length over feed. */
  programmed_time_s: number
  /** One for each tolerance asked for, in that order. */
  runs: Run[]
  /** What could not be read, or should be known; the rest is quoted all the same. */
  diagnostics: Diagnostic[]
  /** The version of the build that computed it; another commit has another. */
  version: string
}

/** What is wrong with a request: a word for it and a sentence. */
export interface Refusal {
  /**
   * `machine`, `tolerances`, `dialect`, `request`: that part of the request; `program`: it could not be had; `size`: too large;
   * `cancelled`: ended on request or by a newer one; `failed`: a fault of Truefeed. An iframe also says `version` and `type`.
   */
  kind:
    | 'request'
    | 'machine'
    | 'tolerances'
    | 'dialect'
    | 'program'
    | 'size'
    | 'cancelled'
    | 'failed'
    | 'version'
    | 'type'
  message: string
  /** The values of the machine that are wrong, by key. */
  faults: { key: string | null; message: string }[]
}

/** A refused request. */
export class QuoteError extends Error implements Refusal {
  constructor(refusal: Refusal)
  readonly kind: Refusal['kind']
  readonly faults: Refusal['faults']
}

/**
 * What the machine really does with the program, for each tolerance: cycle time, its parts, contour error and price.
 * Without tolerances those of the program hold, and the machine's where it sets none. Rejects with a `QuoteError`.
 */
export function quote(
  program: Program,
  machine: Machine,
  tolerances?: Tolerance[],
  options?: QuoteOptions,
): Promise<Quote>
