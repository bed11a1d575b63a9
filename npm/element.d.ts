// Types of the web component, <truefeed-quote>. Importing the module defines the element.

import type { Dialect, Machine, Program, Quote, Refusal, Tolerance } from './index.js'

export interface QuoteElementEvents {
  /** There is a quote for what is set now. */
  quote: CustomEvent<Quote>
  /** There is none, and why. It does not bubble, as errors of elements do not. */
  error: CustomEvent<Refusal>
  /** The part done, 0 to 1. */
  progress: CustomEvent<{ part: number }>
}

export class QuoteElement extends HTMLElement {
  /** The program; set, it takes the place of `program-src`. */
  program: Program | null
  /** Several programs that make a part together; set, they take the place of `program`. */
  programs: { name: string; program: Program }[]
  /** What the program is called. */
  name: string
  machine: Machine | null
  tolerances: Tolerance[]
  dialect: Dialect | null
  /** The quote in sight, or none. */
  readonly quote: Quote | null
  /** The quotes of all programs, in their order. */
  readonly quotes: Quote[]
  /** Computes now what is set; resolves with the quote, rejects with a `QuoteError`. */
  compute(): Promise<Quote>
  /** Ends a computation. */
  cancel(): void
  addEventListener<K extends keyof QuoteElementEvents>(
    type: K,
    listener: (event: QuoteElementEvents[K]) => void,
    options?: boolean | AddEventListenerOptions,
  ): void
  addEventListener(
    type: string,
    listener: EventListenerOrEventListenerObject,
    options?: boolean | AddEventListenerOptions,
  ): void
}

declare global {
  interface HTMLElementTagNameMap {
    'truefeed-quote': QuoteElement
  }
}
