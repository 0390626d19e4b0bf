// What the preview and its page say to each other.
import type { Transition } from '../run/messages';
import type { DiagramKind, DiagramNode, DiagramOptions } from '../protocol';

/** What a preview shows; kept by the page, so that it survives a reload of the window. */
export interface Subject {
  uri: string;
  kind: DiagramKind;
  component?: string;
  owner?: string;
  options: DiagramOptions;
  /** States that the reader goes through. */
  way?: string[];
}

export interface Shown {
  subject: Subject;
  title: string;
  svg: string;
  width: number;
  height: number;
  nodes: DiagramNode[];
  /** What is known of the way, once it has two ends. */
  told: string | undefined;
  /** Chains of data are to be shown, and no scenario asks for one. */
  withoutChains: boolean;
  /** Something was opened, closed or moved by hand. */
  arranged: boolean;
}

/** What a run does in the machine that is shown. */
export interface Live {
  /** Of times. */
  unit: string;
  transitions: Transition[];
  /** The states that activities are in. One that does not execute pauses before its state. */
  activities: { state: string; executes: boolean }[];
}

export type ToPage =
  /** Undefined: nothing of the machine has run. */
  | { type: 'live'; live: Live | undefined }
  | { type: 'picture'; shown: Shown }
  /** Undefined: all is well. */
  | { type: 'notice'; text: string | undefined }
  /** The node of what is under the cursor. */
  | { type: 'highlight'; id: string | undefined }
  | { type: 'diagnostics'; id: string; messages: string[] }
  /** To be turned into a PNG. */
  | { type: 'raster'; svg: string; width: number; height: number };

export type FromPage =
  | { type: 'ready' }
  /** Width of the view, in pixels. */
  | { type: 'width'; width: number }
  /** To the node, or to one of its lines. */
  | { type: 'jump'; id: string; line?: number }
  | { type: 'open'; id: string; open: boolean }
  | { type: 'move'; id: string; by: [number, number] }
  /** Everything where it is laid out, as much of it as at first. */
  | { type: 'arrange' }
  /** A scenario is to be written, to ask for a chain of data. */
  | { type: 'scenario' }
  /** How chains are asked for. */
  | { type: 'aboutChains' }
  | { type: 'way'; states: string[] }
  | { type: 'select'; id: string }
  | { type: 'kind'; kind: DiagramKind }
  | { type: 'options'; options: DiagramOptions }
  | { type: 'export'; format: 'svg' | 'png' }
  /** Base64. */
  | { type: 'png'; data: string };
