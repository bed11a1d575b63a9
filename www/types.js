// The shapes that pass between the modules of the page. Units are in the names where they come from JSON.

/**
 * @typedef {object} Diagnostic
 * @property {number} line
 * @property {"error" | "warning" | "info"} severity
 * @property {string} message
 */

/**
 * @typedef {object} ProgramSummary
 * @property {string} dialect  the word of the control it was read for
 * @property {number} programmed_time_s
 * @property {Diagnostic[]} diagnostics
 * @property {string} version  of the build that computed it
 */

/**
 * @typedef {object} RunSummary
 * @property {number} tolerance_mm
 * @property {number} cycle_time_s
 * @property {Breakdown} breakdown
 * @property {Operation[]} operations  in the order they are run
 * @property {Tool[]} tools  in the order of first use
 * @property {Lost} lost
 * @property {number} max_contour_error_mm
 * @property {Place[]} beyond_tolerance
 * @property {number} price  0 where there is no hourly rate
 * @property {object} [range]  how far off the cycle time may be on a machine that was calibrated; Rust alone reads it
 * @property {string} [in_doubt]  what of the cycle time is in doubt and why; absent where nothing is
 * @property {{seconds_in_doubt: number, bounded: boolean, reasons: string[], causes: {id: string, count: number, lines: [number, number], seconds: number | null}[]}} trust  by how much it may be off, as far as that has a bound, and why
 */

/** @typedef {{value: number, line: number, distance_mm: number}} CutPeak */
/** @typedef {{force_n: CutPeak, torque_nm: CutPeak, power_w: CutPeak, removal_rate_mm3_min: CutPeak}} CutPeaks */

/** Coefficients and where they are from. @typedef {{name: string, source: string, is_checked: boolean, cutting_n_mm2: number[], edge_n_mm: number[]}} CutMaterial */
/** Where the feedrate could be higher. @typedef {{lines: [number, number], distance_mm: [number, number], programmed_mm_min: number, predicted_mm_min: number, factor: number, limit: string | null, saved_s: number}} CutRoom */
/** What the cut of a program on a machine asks of tool and spindle, by operation. @typedef {{program: number, dialect: string | null, motion: string | undefined, column: Column, operations: (CutOfOperation | undefined)[], rooms: CutRoom[], fed: import('./cutting/job.js').Fed[]}} Cut */

/** What the cut of one run asks of tool and spindle. @typedef {{resolution_mm: number, material: CutMaterial, programmed: CutPeaks, predicted: CutPeaks, headroom: CutRoom[], assumptions: string}} Cutting */
/** @typedef {{removed_mm3: number, peak_power_w: CutPeak, peak_force_n: CutPeak}} CutOfOperation */

/**
 * A prediction with one run, and the loads over distance; without `cutting` there are none, and a diagnostic says why.
 * @typedef {object} CutResult
 * @property {{diagnostics: Diagnostic[], runs: {cutting?: Cutting, operations: (Operation & {cutting?: CutOfOperation})[]}[]}} summary
 * @property {Record<"distance" | "programmedForce" | "predictedForce" | "programmedPower" | "predictedPower" | "programmedRate" | "predictedRate" | "predictedPerTooth", Float64Array>} columns
 */

/** What machine functions take. @typedef {{spindle_s: number, coolant_s: number, stops_s: number, pallet_s: number, clamp_s: number, m_words_s: number, start_s: number, halts_s: number}} Functions */

/**
 * Where the time goes; `other` is what `other_s` is made of.
 * @typedef {{cutting_s: number, rapid_s: number, dwell_s: number, tool_change_s: number, other_s: number, other: Functions}} Breakdown
 */

/**
 * What a part of a program takes.
 * @typedef {object} Part
 * @property {number} time_s
 * @property {number} programmed_time_s
 * @property {number} lost_s  time less programmed time
 * @property {Breakdown} breakdown
 * @property {number} feed_mm
 * @property {number} rapid_mm
 * @property {number} blocks
 */

/** @typedef {Part & {line: number, lines: [number, number], distance_mm: [number, number], tool: number | null, tool_name: string | null, name: string | null}} Operation */
/** @typedef {Part & {tool: number | null, tool_name: string | null, operations: number}} Tool */

/**
 * Where the contour error is above the tolerance.
 * @typedef {object} Place
 * @property {[number, number]} lines
 * @property {[number, number]} distance_mm
 * @property {number} max_contour_error_mm
 */

/** Where time is lost against length over feedrate, and why. @typedef {{reason: string, text: string, lines: [number, number], distance_mm: [number, number], seconds: number}} LostAt */
/** @typedef {{seconds: number, elsewhere_s: number, places: LostAt[]}} Lost */

/** The path in space, mm. @typedef {{points: Float32Array, distance: Float64Array}} Trail */
/** @typedef {{end: Float64Array, feedrate: Float64Array, rapid: Uint8Array, line: Uint32Array}} Steps */
/**
 * A profile over distance (mm, mm/s, s), and the contour errors of its segments (mm).
 * @typedef {{distance: Float64Array, feedrate: Float64Array, time: Float64Array, corner: Float64Array, arcs: Uint32Array, alongArcs: Float64Array, paceEnd: Float64Array, paceFeedrate: Float64Array}} Columns
 */
/** `note` names what the columns leave out; `placesInInches` are the texts of the places that lose most time. @typedef {{summary: RunSummary, columns: Columns, note?: string, placesInInches: string[]}} Run */
/** A contour tolerance in mm; null for the program's own. @typedef {number | null} Column */

/**
 * Where one of the program's own tolerances holds.
 * @typedef {object} Held
 * @property {[number, number]} lines
 * @property {[number, number]} distance_mm
 * @property {number} tolerance_mm
 * @property {"exact_stop" | "machine" | "tolerance" | "distance"} mode
 * @property {string} source  the words that ask for it
 */

/**
 * What one program gave on one machine.
 * @typedef {object} Outcome
 * @property {string} motion  what the simulation read of the machine
 * @property {ProgramSummary} summary
 * @property {Steps} steps
 * @property {Trail} trail
 * @property {Held[]} held  empty where the program sets no tolerance
 * @property {Map<Column, Run>} runs
 */

/** A contour tolerance that an operation has of its own, mm; `programmed`: that of its program; null: that of the job. @typedef {number | "programmed" | null} OwnTolerance */

/**
 * @typedef {object} Program
 * @property {number} id
 * @property {string} name
 * @property {Blob} file
 * @property {import('./lines.js').Lines} lines
 * @property {string | null} dialect  the word of the control that was chosen; null: found by what stands in it
 * @property {string} title  what the estimator calls it; empty: what it calls itself
 * @property {import('./cutting/job.js').Described[] | null} described  its tools, as its comments describe them; null where nobody has looked yet
 * @property {string} found  what it calls itself; empty where it does not say, or nobody has looked yet
 * @property {(MachineForm & {start: string}) | null} machine  that runs it; null: that of the form
 * @property {OwnTolerance} tolerance  of the operation
 * @property {number | null} setUp  min; null: that of the terms
 * @property {number | null} loading  s; null: that of the terms
 * @property {Outcome | null} outcome
 * @property {string | null} failure  why the last run of it ended
 */

/** A value of the form; null where the field is empty. @typedef {number | string | boolean | number[] | Record<string, number> | null} Value */
/** @typedef {Record<string, Value>} Values */
/** @typedef {{key: string | null, message: string}} Fault */

/**
 * @typedef {object} Parameter
 * @property {string} key
 * @property {string} label
 * @property {string} doc
 * @property {"number" | "list" | "choice" | "flag" | "text" | "lines" | "picture" | "codes" | "tools"} kind
 * @property {string | null} unit
 * @property {number | null} min
 * @property {number | null} max
 * @property {boolean} whole
 * @property {string[]} words
 * @property {string} group
 * @property {Value} neutral
 */

/** A machine to begin with; `kept` in this browser. @typedef {{name: string, source: string, caveat: string, values: Values, kept?: boolean}} Preset */
/** A unit in which lengths and feedrates can be shown. @typedef {{word: string, symbol: string, feed_symbol: string, fine_symbol: string, in_mm: number, decimals: number, feed_decimals: number}} LengthUnit */
/** @typedef {{fields: Parameter[], presets: Preset[], lengths: LengthUnit[], version: string}} Form */

/**
 * The form as it is filled now.
 * @typedef {object} MachineForm
 * @property {number} preset
 * @property {Values} values
 * @property {Fault[]} faults
 * @property {string | undefined} motion  what a simulation reads of it; rates are not among it
 */

/** Both values, and the second less the first. @typedef {{first: number, second: number, difference: number}} Difference */
/** An operation of two jobs, or of one alone; `index`: its places in them. @typedef {{name: string, index: [number | null, number | null], cycle_time_s: [number | null, number | null], part_cost: [number | null, number | null], cycle_time_difference_s: number}} OperationPair */
/** Two jobs compared. @typedef {{names: [string, string], operations: OperationPair[], cycle_time_s: Difference, set_up_s: Difference, batch_time_s: Difference, unit_price: Difference, total: Difference, currency: string, remarks: string[]}} JobComparison */
/** Lines of two revisions that are alike, or took the place of each other. @typedef {{lines: [[number, number] | null, [number, number] | null], is_same: boolean, seconds: [number, number], difference_s: number, length_mm: [number, number], distance_mm: [number, number] | null}} RevisedRow */
/** Where two revisions of a program differ. @typedef {{is_same: boolean, cycle_time_s: [number, number], difference_s: number, length_mm: [number, number], runs: RevisedRow[], elsewhere_s: number}} RevisionsReport */
/** How much later a program (mm, s) is than its other revision, or on another machine, whose job has this name. @typedef {{program: number, name: string, columns: {distance: Float64Array, later: Float64Array}}} Revised */

/** What a comparison is drawn from: mm, mm/s, s. @typedef {{recordedDistance: Float64Array, recordedFeedrate: Float64Array, recordedTime: Float64Array, simulatedDistance: Float64Array, simulatedFeedrate: Float64Array, simulatedTime: Float64Array, lostDistance: Float64Array, lostSeconds: Float64Array}} MatchedColumns */

/** Why a recording cannot be compared, and what to do. `asks_interval`: it can be read once the time between its rows is stated. @typedef {{reason: string, advice: string, asks_interval: boolean}} Refusal */

/**
 * A stretch where time was lost.
 * @typedef {object} Stretch
 * @property {[number, number]} lines
 * @property {[number, number]} distance_mm
 * @property {number} seconds  recorded less simulated
 * @property {number} recorded_s
 * @property {number} simulated_s
 * @property {string} kind  motion, or what is waited for
 */

/**
 * A recording beside the simulation.
 * @typedef {object} ComparisonReport
 * @property {string} sentence
 * @property {string} aligned
 * @property {string[]} measures
 * @property {string[]} remarks
 * @property {number} recorded_s
 * @property {number} simulated_s
 * @property {number} time_error
 * @property {{name: string, is_detail: boolean, recorded_s: number, simulated_s: number}[]} parts
 * @property {Stretch[]} stretches
 * @property {number} all_stretches
 */

/**
 * What a calibration gave; texts come from Rust.
 * @typedef {object} CalibrationReport
 * @property {string} sentence
 * @property {{key: string, label: string, unit: string, before: string, after: string, deviation: string | null, verdict: string}[]} estimates
 * @property {{name: string, time: string, motion: string, feed: string | null, cam_feed: string | null}[]} runs
 * @property {Measured | null} [measured]  missing in one that was kept before laws were measured
 * @property {string[]} remarks
 * @property {Values} values
 * @property {number} tolerance_mm
 */

/** A law as the recordings show it; Rust draws it. @typedef {{id: string, title: string, told: string}} Law */
/** @typedef {{laws: Law[], absent: {title: string, reason: string}[]}} Measured */

/** Before and after; null where it is not known. @typedef {{before: number | null, after: number | null}} Sides */

/**
 * What was left out of the machine.
 * @typedef {object} Cause
 * @property {string} name
 * @property {string} sentence
 * @property {number} seconds  what it adds to the simulated time
 * @property {{name: string, value: string, deviation: string | null, unit: string}[]} told
 * @property {[number, number][]} lines
 * @property {number | null} position_mm
 * @property {number | null} confidence
 * @property {[number, number] | null} sections  better and worse where nothing was fitted
 * @property {string} vendors
 * @property {string[]} indistinguishable_from
 */

/** A field of the form that the extended machine has otherwise. @typedef {{key: string, label: string, unit: string, before: string, after: string, number: number | null}} Change */

/** What leads from the simulated time to the recorded one; bars begin and end at parts of the width. @typedef {{steps: {name: string, text: string, kind: "total" | "cause" | "unexplained", bar: [number, number]}[], begins_s?: number, notes: string[]}} Account */

/**
 * What a diagnosis says; texts come from Rust.
 * @typedef {object} DiagnosisReport
 * @property {string} sentence
 * @property {Cause[]} causes
 * @property {Account | null} [account]  missing in one that was kept before there were accounts
 * @property {{lines: [number, number], distance_mm: [number, number], time_s: [number, number], seconds: number, run: number}[]} regions
 * @property {{feed_rmse_mm_min: Sides, position_rmse_mm: Sides, cycle_time_error_s: Sides, held_out: {feed_rmse_mm_min: Sides}}} fit
 * @property {string[]} not_excited
 * @property {Measured | null} [measured]  missing in one that was kept before laws were measured
 * @property {string[]} messages
 * @property {Values | null} values
 * @property {Change[]} changes
 */

/** The lists are of the recorded curve, of the one simulated before, and of the one after. @typedef {Steps & {distances: Float64Array[], feedrates: Float64Array[], times: Float64Array[], lostDistances: Float64Array[], lostSeconds: Float64Array[]}} DiagnosedColumns */
/** @typedef {{name: string, program: Program, columns: DiagnosedColumns}} DiagnosedRun */

/**
 * A diagnosis with its documents; `used`: its machine is in the form instead of the one `before`.
 * @typedef {{report: DiagnosisReport, json: string, html: string, runs: DiagnosedRun[], before: Before, used: boolean, evidence: string, motions: (string | undefined)[]}} Diagnosis
 */

/**
 * What a recording gave on one machine.
 * @typedef {{motion: string, report?: ComparisonReport, refusal?: Refusal, columns: MatchedColumns}} Match
 */

/** Which of several programs a recording is of; `of`: those that were asked about; `among`: those it cannot tell apart. @typedef {{program: number | null, among: number[], of: string}} Found */

/**
 * @typedef {object} Recording
 * @property {number} id
 * @property {string} name
 * @property {Uint8Array} bytes
 * @property {number | null} chosen  the program that a user said it is of; null: nobody did
 * @property {number | null} program  of which it is; null: not there yet, or not found
 * @property {Found | null} found  which of the programs it is of, by what it holds
 * @property {boolean} used  to calibrate and to diagnose
 * @property {number | null} interval  time between its rows, s; null: the file states its times
 * @property {string | null} [dialect]  how its program is read
 * @property {Match | null} match
 * @property {string | null} failure  why the last comparison of it ended
 */

/** What was in the form before a calibration, or with `programmed`, `terms` and `lengthUnit` before settings from elsewhere. `start`: the machine to begin with. @typedef {{start?: string, values: Values, tolerances: number[], quoted?: string, programmed?: boolean, terms?: Values, lengthUnit?: string}} Before */

/** @typedef {{quantity: number, unit_price: number, total: number, unit_price_range: [number, number] | null, total_range: [number, number] | null}} OfferBatch */
/** @typedef {{line: number | null, tool: number | null, name: string, time_s: number, amount: number}} OfferShare */

/**
 * The price of a batch and all it is made of; texts come from Rust.
 * @typedef {object} Offer
 * @property {{name: string, value: string}[]} facts  what it is of
 * @property {string} currency
 * @property {number} decimals
 * @property {number} cycle_time_s
 * @property {{kind: string, ratio: number | null, cycle_time_s: [number, number] | null, sentence: string}} uncertainty
 * @property {{item: string, basis: string, once: boolean, amount: number, of_batch: number}[]} addends
 * @property {number} once
 * @property {number} part
 * @property {OfferBatch} batch
 * @property {OfferBatch[]} breaks
 * @property {{tolerance: string, cycle_time_s: number, unit_price: number, total: number}[]} tolerances  where there are several
 * @property {OfferShare[]} operations
 * @property {OfferShare[]} tools
 * @property {number} cycle_cost
 * @property {string[]} notes
 */
/**
 * The price of a job and all it is made of; texts come from Rust.
 * @typedef {Omit<Offer, "operations" | "tools" | "tolerances" | "cycle_cost" | "addends"> & {programmed_time_s: number, cycle_time_range_s: [number, number] | null, in_doubt_s: number, bounded: boolean, set_up_s: number, loading_s: number, addends: (Offer["addends"][number] & {operation: number | null})[], operations: JobOperation[], missing: {key: string, label: string, operation: number | null}[]}} JobReport
 */
/** @typedef {{name: string, program: string, machine: string, tolerance: string, set_up_s: number, cycle_time_s: number, cycle_time_range_s: [number, number] | null, set_up_cost: number, part_cost: number}} JobOperation */
/** @typedef {{report: CalibrationReport, before: Before}} Calibration */

/** @typedef {{program: number | null, stage: string, part: number}} Progress */

/**
 * @typedef {object} State
 * @property {Program[]} programs
 * @property {number | null} selected
 * @property {boolean} programmed  the program's own tolerances are shown, where it sets any
 * @property {number[]} tolerances  mm, ascending
 * @property {MachineForm} machine
 * @property {{values: Values, faults: Fault[]}} terms  of the quote
 * @property {string} lengthUnit  the word of the unit in which lengths are shown
 * @property {Before | null} beforeSettings  what settings from a link or file took the place of
 * @property {Recording[]} recordings
 * @property {number | null} recording  the one in sight
 * @property {Calibration | null} calibration
 * @property {boolean} calibrating  a calibration was asked for and is not there yet
 * @property {Diagnosis | null} diagnosis
 * @property {boolean} diagnosing  a diagnosis was asked for and is not there yet
 * @property {Cut | null} cut  the last one that was computed
 * @property {Revised | null} revised  the program in sight beside that of another job
 * @property {Before | null} sample  what was in the form before the sample's machine
 * @property {number | null} beside  the machine to begin with that is compared with; null: none
 * @property {string} job  what the job is called; may be empty
 * @property {number | null} fixture  how many parts stand on the machine at a time; null: one
 * @property {Values} letter  what stands on an offer beside its prices
 * @property {Values} company  who offers
 * @property {string} quoted  what the tolerance of the quote is called; empty: the first
 * @property {import('./job/pricing.js').Price | null} price  of the job; null where a program of it is still to be computed
 * @property {Progress | null} progress
 * @property {boolean} paused  the user cancelled; nothing runs until something changes
 */

export {}
