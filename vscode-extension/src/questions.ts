// The questions of commands: how many there are, and their words. Nothing here needs the editor.
import type { TemplateOption } from './generate/protocol';

/** The questions that are asked: no folder if there is one folder, no ports without interfaces. */
export function questions(folders: number, interfaces: number): Question[] {
  return [...(folders === 1 ? [] : ['folder' as const]), 'name', 'tasks', ...(interfaces === 0 ? [] : ['ports' as const])];
}

export type Question = 'folder' | 'name' | 'tasks' | 'ports';

/** `New Component: name (1/3)` */
export function titleOf(question: Question, all: Question[]): string {
  return `New Component: ${question} (${all.indexOf(question) + 1}/${all.length})`;
}

/** What an option does, for people: its help, else its name. Whoever knows the command line finds its flags behind it. */
export function label({ flags, value, help }: TemplateOption): { label: string; description: string } {
  const written = flags.join(', ') + (value === null ? '' : ` ${value}`);
  const text = help.trim();
  return text === '' ? { label: written, description: '' } : { label: text.charAt(0).toUpperCase() + text.slice(1), description: written };
}

/** Whether to ask about an option: not if it only prints, or is another spelling of an option. */
export function isWorthAsking({ flags, help }: TemplateOption): boolean {
  return !flags.includes('--help') && !/^the same as -/.test(help.trim());
}
