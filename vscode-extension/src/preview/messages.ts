// What the preview and its page say to each other.
import type { DiagramKind, DiagramNode, DiagramOptions } from '../protocol';

/** What a preview shows; kept by the page, so that it survives a reload of the window. */
export interface Subject {
  uri: string;
  kind: DiagramKind;
  component?: string;
  owner?: string;
  options: DiagramOptions;
}

export interface Shown {
  subject: Subject;
  title: string;
  svg: string;
  width: number;
  height: number;
  nodes: DiagramNode[];
}

export type ToPage =
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
  | { type: 'jump'; id: string }
  | { type: 'select'; id: string }
  | { type: 'kind'; kind: DiagramKind }
  | { type: 'options'; options: DiagramOptions }
  | { type: 'export'; format: 'svg' | 'png' }
  /** Base64. */
  | { type: 'png'; data: string };
