// What the panel of runs and its page say to each other. The page draws a `RunView` and knows nothing else.

import type { Schema } from './values';

export interface OfTask {
  task: string;
  jobs: number;
  greatest?: number;
  mean?: number;
  bound?: number;
  period?: number;
  missed: number;
  /** Share of the time in which its codels had their locks; none if they have no execution times. */
  load?: number;
}

/** How often it was taken, and the greatest time of its codel then; `to` may begin with `pause::`. */
export interface Transition {
  from: string;
  to: string;
  taken: number;
  greatest?: number;
}

export interface Machine {
  machine: string;
  transitions: Transition[];
}

/** What pictures of state machines show of a run. */
export interface Ran {
  /** Of times. */
  unit: string;
  machines: Machine[];
  /** Nothing where the run is over. */
  activities: Progress['activities'];
}

/** How far a run has come (docs/socket.md). */
export interface Progress {
  unit: string;
  time: number;
  tasks: OfTask[];
  machines: Machine[];
  /** Where activities are. One that does not execute pauses before its state. */
  activities: { machine: string; state: string; executes: boolean }[];
  'violation-count': number;
}

/** The report of `dotgen run --format json` (docs/run.md), as far as it is shown. */
export interface Report {
  scenario: string;
  unit: string;
  seed: number;
  time: number;
  end: string;
  verdict: string;
  tasks: OfTask[];
  'requests-outside-model'?: number;
  services: { service: string; requests: number; refused: number; ended: number }[];
  machines: Machine[];
  checks: { name?: string; check: string; of: string; verdict: string; why?: string; greatest?: number; limit?: number; at?: { time: number }; violations: number }[];
  violations: Violation[];
  'violation-count': number;
  assumptions: string[];
  notes: string[];
}

/** The members depend on the kind. */
export interface Violation {
  at: { time: number };
  times?: number;
  kind: string;
  check?: number;
  task?: string;
  response?: number;
  bound?: number;
  codel?: string;
  event?: string;
  took?: number;
  limit?: number;
  component?: string;
  why?: string;
}

/** A violation of a run that goes on (docs/socket.md). */
export interface ViolationEvent {
  /** Of times. */
  unit: string;
  /** In words. */
  what: string;
  violation: Violation;
}

export interface Input {
  name: string;
  default?: unknown;
  schema: Schema;
}

export interface Service {
  /** With its component: `pump.fill`. */
  name: string;
  kind: string;
  doc: string | null;
  inputs: Input[];
  /** What came of the last request; empty before the first. */
  answer: string;
  /** A request is under way that can be interrupted. */
  active: boolean;
}

/** The last values of a number of a port. */
export interface Series {
  /** Members on the way to it; empty where the value is the number. */
  name: string;
  values: number[];
}

export interface Port {
  /** `pump/level` */
  name: string;
  doc: string | null;
  /** The newest value as JSON; empty before the first. */
  value: string;
  series: Series[];
}

export type RunState = 'starting' | 'running' | 'stopping' | 'ended' | 'failed';

export interface RunView {
  /** Its components wait for a debugger. */
  debug: boolean;
  /** What is run, for people. */
  name: string;
  clock: 'virtual' | 'real';
  state: RunState;
  /** Of the run that has ended. */
  report: Report | null;
  /** While it goes on, on the real clock. */
  progress: Progress | null;
  /** The same. */
  violations: ViolationEvent[];
  /** Components without sources, once known: their codels are simulated. */
  simulated: string[];
  /** Execution times that it took and that are not in the specification. */
  times: number;
  /** The first run can be stepped through. */
  hasTrace: boolean;
  services: Service[];
  ports: Port[];
  log: string[];
}

export type ToPage = { type: 'run'; view: RunView };

export type FromPage =
  | { type: 'ready' }
  | { type: 'stop' }
  | { type: 'again' }
  | { type: 'trace' }
  /** Shows the light bulb of a component without sources, which offers its stubs. */
  | { type: 'stubs' }
  /** Writes what was measured into the specification. */
  | { type: 'import' }
  /** Inputs by name; those left empty are not sent. */
  | { type: 'call'; service: string; inputs: Record<string, unknown> }
  | { type: 'abort'; service: string };
