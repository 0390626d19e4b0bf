// What the verification panel and its page say to each other.
import type { LimitsAnswer, VerificationAnswer, WhatIf } from '../protocol';

/** What a panel shows; kept by the page, so that it survives a reload of the window. */
export interface Subject {
  uri: string;
  check?: number;
  whatIf?: WhatIf;
}

export type ToPage =
  /** A new answer. `pinned`: the run on show is of an earlier text, and stays until it is dismissed. */
  | { type: 'answer'; subject: Subject; answer: VerificationAnswer; pinned: boolean }
  /** A question is under way. */
  | { type: 'busy'; text: string }
  /** Where the search for limits stands. */
  | { type: 'limits'; limits: Limits };

export type Limits =
  /** Nobody has asked, or what was found is of an earlier text. */
  | { state: 'none'; text: string }
  | { state: 'running'; text: string; percentage: number }
  | { state: 'found'; answer: LimitsAnswer };

export type FromPage =
  | { type: 'ready' }
  | { type: 'place'; uri: string; line: number; character: number; endLine: number; endCharacter: number }
  | { type: 'check'; check: number }
  /** The changes that are offered where a check is written. */
  | { type: 'repair'; uri: string; line: number; character: number }
  /** Step through the run on show. */
  | { type: 'trace' }
  | { type: 'dismiss' }
  | { type: 'writeOut' }
  | { type: 'findLimits' }
  | { type: 'stopLimits' }
  | { type: 'whatIf'; whatIf: WhatIf | undefined };
