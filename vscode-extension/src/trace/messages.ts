// What the trace viewer and its page say to each other.
import type { Trace } from './form';

/** The state machine around a step, and the state in it. */
export interface Machine {
  title: string;
  svg: string;
  /** `data-id` of the state. */
  node: string | null;
}

/** A change that repairs what the run shows. */
export interface Remedy {
  title: string;
  /** The run with it can be shown. */
  previews: boolean;
}

export type ToPage =
  /** `simulates`: other steps can be chosen. */
  | { type: 'trace'; trace: Trace; simulates: boolean; remedies?: Remedy[] }
  /** The run with a remedy; null: with it there is no such run. */
  | { type: 'preview'; remedy: number; trace: Trace | null }
  /** The steps that may follow a step. */
  | { type: 'next'; step: number; choices: string[] }
  /** There is nothing to show, and why. */
  | { type: 'nothing'; text: string }
  /** Said above the picture; empty: nothing. */
  | { type: 'notice'; text: string }
  /** The answer for a step; null: it is about no state. */
  | { type: 'machine'; step: number; machine: Machine | null };

export type FromPage =
  | { type: 'ready' }
  /** This step is looked at. */
  | { type: 'step'; step: number }
  /** To its codel in the text. */
  | { type: 'go'; step: number }
  /** What may follow this step is wanted. */
  | { type: 'choices'; step: number }
  /** The run goes on with one of these choices. */
  | { type: 'take'; choice: number }
  /** No preview is wanted any more. */
  | { type: 'unpreview' }
  /** The run with this remedy is wanted. */
  | { type: 'preview'; remedy: number }
  /** This remedy is to be written. */
  | { type: 'remedy'; remedy: number }
  /** A recorded run is to be opened. */
  | { type: 'open' }
  /** The run of the present text is wanted. */
  | { type: 'refresh' };
