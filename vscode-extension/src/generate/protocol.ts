// What the server answers to its commands for generating (docs/protocol.md).

/** A template that can be run. */
export interface TemplateInfo {
  name: string;
  kind: 'builtin' | 'tcl' | 'minijinja';
  about: string;
  dir: string | null;
}

/** A template and its options, as `dotgen.toml` keeps them. */
export interface Choice {
  file: string;
  template: string;
  arguments: string[];
}

/** Answer of `dotgen.templates`. */
export interface Templates {
  templates: TemplateInfo[];
  remembered: Choice[];
}

/** An option of a template, from its usage text. */
export interface TemplateOption {
  flags: string[];
  value: string | null;
  help: string;
}

/** Answer of `dotgen.templateOptions`. */
export interface TemplateUsage {
  usage: string;
  options: TemplateOption[];
}

/** A file that would be created or changed. */
export interface FileChange {
  uri: string;
  change: 'create' | 'change';
  before: string | null;
  after: string;
  /** Unix permissions, when the template gives any. */
  mode: number | null;
  /** `hidden`, `executable`, or both: a file that acts later. */
  concern?: string | null;
}

/** Answer of `dotgen.generate` and `dotgen.regenerate` with `apply: false`. */
export interface Plan {
  status: 'preview' | 'unchanged' | 'failed' | 'cancelled';
  files: FileChange[];
  choices: Choice[];
  /** What the templates printed. */
  output: string;
  messages: string;
  /** Where a template failed. */
  problem: { uri: string; line: number; message: string } | null;
}
