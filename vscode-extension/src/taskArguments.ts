// The command line of a task of type `dotgen`.

export interface TaskDefinition {
  /** Subcommand of dotgen, for example `codels build`. */
  command: string;
  /** Options and files. By default, the folder of the workspace. */
  args?: string[];
}

/** Subcommands that are offered for each folder. `generate` needs a template, which tasks.json names. */
export const OFFERED = ['check', 'verify', 'codels build'];

/** Arguments of the program. `reading` says how specifications are read. */
export function argumentsOfTask({ command, args = ['.'] }: TaskDefinition, reading: string[]): string[] {
  return [...command.split(' '), ...reading, ...args];
}
