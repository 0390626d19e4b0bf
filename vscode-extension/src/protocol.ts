// What the server offers beyond the Language Server Protocol (docs/protocol.md).
import { NotificationType, RequestType, type Position, type Range, type TextDocumentIdentifier, type WorkspaceEdit } from 'vscode-languageclient/node';
import type { Place } from './place';
import type { Trace } from './trace/form';

export type { Place } from './place';

export const LANGUAGE = 'genom3';

/** Sent with `initialize`. */
export interface InitializationOptions {
  /** Programs (pkg-config, templates) may be run on behalf of the workspace. */
  trusted: boolean;
  /** Notifications about verifications are wanted, and the command that shows one exists. */
  verificationStatus: boolean;
  /** The client executes `dotgen.run` and `dotgen.simulate`. */
  runs: boolean;
  /** The client answers `dotgen/documentText`. */
  documentText: boolean;
}

/** An open document, whole. `null` for one that is not open. */
export interface DocumentText {
  version: number;
  text: string;
}

/** Asked by the server when an edit brought half a character: it cannot know what the text is. */
export const documentText = new RequestType<TextDocumentIdentifier, DocumentText | null, void>('dotgen/documentText');

/** The concrete syntax tree of a file, as indented text. */
export const syntaxTree = new RequestType<{ textDocument: TextDocumentIdentifier }, string, void>('dotgen/syntaxTree');

export interface Expansion {
  /** Name of the macro. */
  name: string;
  /** What the call expands to. */
  expansion: string;
}

/** The full expansion of the macro call at a position; null when there is none. */
export const expandMacro = new RequestType<
  { textDocument: TextDocumentIdentifier; position: Position },
  Expansion | null,
  void
>('dotgen/expandMacro');

/** As included by whom a document is read: the root it is shown in, and all that include it. */
export const includingRoots = new RequestType<
  { textDocument: TextDocumentIdentifier },
  { current: string | null; roots: string[] },
  void
>('dotgen/includingRoots');

/** The release of GenoM3 that a document is read as, and who chose it. */
export const release = new RequestType<
  { textDocument: TextDocumentIdentifier },
  { release: string; verified: boolean; origin: string },
  void
>('dotgen/release');

export type DiagramKind = 'fsm' | 'system' | 'locks';

/** What a picture shows besides the essentials. */
export interface DiagramOptions {
  wcet?: boolean;
  load?: boolean;
  paths?: boolean;
  locks?: boolean;
  interrupts?: boolean;
  chains?: boolean;
}

/** What the reader made of a system: which components are open or closed, and how far nodes were moved, in pixels. */
export interface Arrangement {
  opened: Record<string, boolean>;
  moved: Record<string, [number, number]>;
}

export interface DiagramParams extends DiagramOptions, Partial<Arrangement> {
  textDocument: TextDocumentIdentifier;
  /** What is declared around it wins over the names. */
  position?: Position;
  kind: DiagramKind;
  component?: string;
  owner?: string;
  /** States that the reader goes through. */
  way?: string[];
  /** Only if the position names a task, activity or state, whose machine it is; a state becomes the way. */
  named?: boolean;
  /** Systems: width of the pane, in pixels. */
  width?: number;
  theme?: 'auto' | 'light' | 'dark' | 'light-clear' | 'dark-clear' | 'neutral' | 'editor';
  format?: 'svg' | 'dot' | 'mermaid';
}

/** Where something is written. */
export interface DiagramPlace {
  uri: string;
  /** The whole declaration. */
  range: Range;
  /** Its name. */
  selectionRange: Range;
}

export interface DiagramNode {
  id: string;
  names: string[];
  lines: string[];
  classes: string[];
  description: string;
  place: DiagramPlace | null;
  /** Of its lines; empty if none has a place of its own. */
  parts: (DiagramPlace | null)[];
  /** Of nodes that can be opened and closed: which they are. */
  open: boolean | null;
  /** Names of what is in it, listed or not. */
  holds: string[];
  codel: { name: string; states: string[]; async: boolean; params: string[]; wcet: string | null; excludes: string[] } | null;
}

export interface DiagramAnswer {
  kind: DiagramKind;
  title: string;
  /** The states that are marked. */
  way: string[];
  /** What is said below the picture; of a way with two ends, last. */
  notes: string[];
  component: string | null;
  owner: string | null;
  /** Of the task, activity or component, in this document. */
  place: DiagramPlace | null;
  /** In the format asked for. */
  picture: string;
  width: number;
  height: number;
  nodes: DiagramNode[];
  version: number | null;
  /** Why this is the last good picture and not the present one. */
  stale: string | null;
  /** Why something may be missing. */
  incomplete: string | null;
}

/** A picture of what is declared at a place; null when there is nothing to draw. */
export const diagram = new RequestType<DiagramParams, DiagramAnswer | null, void>('dotgen/diagram');

export interface CodelHeaderFiles {
  /** The folder of all files. */
  folder: string;
  files: { uri: string; text: string }[];
}

/** The headers that the codels of a specification include; null when there is no specification. */
export const codelHeaders = new RequestType<{ textDocument: TextDocumentIdentifier }, CodelHeaderFiles | null, void>(
  'dotgen/codelHeaders',
);

/** The language of scenarios. */
export const SCENARIO = 'genom3-scenario';
/** Sources of templates that the user calls so; others are asked for by the server. */
export const TEMPLATE = 'genom3-template';

export type VerificationState = 'stale' | 'running' | 'proved' | 'conditional' | 'answered' | 'refuted' | 'gave-up' | 'nothing' | 'blocked';

/** Where the verification of a document stands; sent whenever it changes. */
export interface VerificationStatus {
  /** The scenario, or the specification that is verified without one. */
  uri: string;
  version: number | null;
  status: VerificationState;
  scenario: string;
  written: boolean;
  /** Checks that are answered for this version, and checks that there are. */
  answered: number | null;
  checks: number | null;
  minimumCores: number | null;
  states: number | null;
  seconds: number | null;
}

export const verificationStatus = new NotificationType<VerificationStatus>('dotgen/verificationStatus');

/** What is to be different, for one question. */
export interface WhatIf {
  cores?: number | 'free';
  policy?: string;
  durations?: string;
  /** Longest execution times in microseconds, by codel. */
  wcet?: Record<string, number>;
}

export interface VerificationCheck {
  name: string | null;
  check: string;
  of: string;
  /** `open`: not answered yet. */
  verdict: 'proved' | 'conditional' | 'vacuous' | 'bounded' | 'exceeds' | 'refuted' | 'gave up' | 'nothing' | 'open';
  worth: string | null;
  value: string | null;
  limit: string | null;
  slack: string | null;
  note: string | null;
  /** What the verdict rests on although it is not stated. */
  condition: string | null;
  /** Why it fails in one sentence, and what would make it hold. */
  cause: string | null;
  remedy: string | null;
  /** Why a job is late, a sentence for each wait. */
  reason: string[];
  hasRun: boolean;
  location: Place | null;
}

export interface VerificationAnswer {
  uri: string;
  version: number | null;
  status: VerificationState;
  /** Whether what follows is of an earlier text. */
  earlier: boolean;
  /** How many checks are answered, while some are open. */
  howFar: string | null;
  scenario: string;
  written: boolean;
  platform: string;
  cores: number | null;
  policy: string;
  durations: string;
  errors: string[];
  /** What was assumed of the model. */
  warnings: { message: string; location: Place | null }[];
  /** What to do about checks that were given up. */
  advice: string | null;
  checks: VerificationCheck[];
  bounds: { task: string; bound: string }[];
  minimumCores: number | null;
  /** Changes that repair all that is missed, in sentences, the smallest first. */
  repairs: string[];
  assumptions: string[];
  notes: string[];
  blocking: { codel: string; location: Place | null; by: { codel: string; location: Place | null; time: string; through: string }[] }[];
  codels: { path: string; wcet: number | null; location: Place | null }[];
  /** `shows` says what the run is to its check; `title` names the check first. */
  run: { check: number; title: string; shows: string; events: { text: string; location: Place | null }[] } | null;
  states: number;
  seconds: number;
  whatIf: boolean;
}

/** How far a value can go with every deadline met. */
export interface Limit {
  of: string;
  now: string;
  extreme: string;
  /** What the extreme is worth, if it is not exact. */
  remark: string;
  location: Place | null;
}

export interface LimitsAnswer {
  version: number | null;
  errors: string[];
  /** The deadlines that the limits concern: `every deadline`. */
  deadlines: string;
  cores: string;
  coresRemark: string;
  wcet: Limit[];
  period: Limit[];
}

/** Looks for the limits within which every deadline is met; takes its time. */
export const sensitivity = new RequestType<
  { textDocument: TextDocumentIdentifier; whatIf?: WhatIf; workDoneToken?: string },
  LimitsAnswer | null,
  void
>('dotgen/sensitivity');

/** All that is known about the verification of a document, or about a variation of it. */
export const verification = new RequestType<
  { textDocument: TextDocumentIdentifier; check?: number; whatIf?: WhatIf; theme?: 'editor' },
  VerificationAnswer | null,
  void
>('dotgen/verification');

/** The steps that may follow a run, as texts, and the number of its steps before each chosen one. */
export interface NextSteps {
  choices: string[];
  taken: number[];
}

/** A change that repairs the check of a run. */
export interface Remedy {
  /** The change, in the imperative. */
  title: string;
  edit: WorkspaceEdit;
  /** The same change as a variation; null if a variation cannot say it. */
  whatIf: WhatIf | null;
}

/** The run of a check as data (docs/trace.md); null when there is none. With `after`, that run up to a step, continued by chosen steps. */
export const trace = new RequestType<
  { textDocument: TextDocumentIdentifier; check?: number; whatIf?: WhatIf; after?: number; take?: number[] },
  (Trace & { check: number; next?: NextSteps; remedies?: Remedy[] }) | null,
  void
>('dotgen/trace');

/** A file of a formal model: its name without a folder. */
export interface ModelFile {
  name: string;
  text: string;
}

/** A reason against a formal model. */
export interface Refusal {
  message: string;
  location: Place | null;
}

/** The formal model of a document in a format, as on the command line; null for other languages. Nothing is written. */
export const exportModel = new RequestType<
  { textDocument: TextDocumentIdentifier; format: string },
  { files: ModelFile[] } | { refusals: Refusal[] } | null,
  void
>('dotgen/exportModel');

/** An interface of the workspace that a new component can provide or use. */
export interface InterfaceInfo {
  name: string;
  /** The file that declares it. */
  uri: string;
  /** Its ports as written. */
  ports: string[];
  /** It has ports alone. */
  canBeProvided: boolean;
}

/** A task of a new component; without period it is aperiodic. */
export interface NewTask {
  name: string;
  period?: string;
}

interface NewComponentParams {
  /** The folder of the component, which need not be there. */
  folder: string;
  name: string;
  tasks: NewTask[];
  provides: { name: string; uri: string }[];
  uses: { name: string; uri: string }[];
}

export const interfaces = new RequestType<Record<string, never>, InterfaceInfo[], void>('dotgen/interfaces');
/** The files of a new component, the specification first. Nothing is written. */
export const newComponent = new RequestType<NewComponentParams, { files: { uri: string; text: string }[] }, void>('dotgen/newComponent');
