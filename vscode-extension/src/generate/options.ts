// Choosing the options of a template: a list with check marks, then a question for each value.
import * as vscode from 'vscode';
import { isWorthAsking, label } from '../questions';
import type { TemplateOption, TemplateUsage } from './protocol';

/** The words of a command line; quotes keep blanks together. */
export function words(line: string): string[] {
  return [...line.matchAll(/"([^"]*)"|'([^']*)'|(\S+)/g)].map(([, double, single, bare]) => double ?? single ?? bare ?? '');
}

/** Finds the options among arguments used before: what is chosen, and the values. */
export function chosen(options: TemplateOption[], before: string[]): Map<TemplateOption, string> {
  const found = new Map<TemplateOption, string>();
  for (let at = 0; at < before.length; at++) {
    const [flag = '', ...rest] = (before[at] ?? '').split('=');
    const option = options.find((it) => it.flags.includes(flag));
    if (option !== undefined) {
      found.set(option, option.value === null ? '' : rest.length > 0 ? rest.join('=') : (before[++at] ?? ''));
    }
  }
  return found;
}

interface OptionItem extends vscode.QuickPickItem {
  option: TemplateOption;
}

/** Asks for the arguments of a template; `undefined` when the user gives up. */
export async function askArguments(template: string, { options, usage }: TemplateUsage, before: string[]): Promise<string[] | undefined> {
  // A usage text that names no option: there is nothing to ask, unless arguments were used before.
  if (options.length === 0 && before.length === 0 && usage.trim() !== '' && !/\s-/.test(usage)) {
    return [];
  }
  if (options.length === 0) {
    const line = await vscode.window.showInputBox({
      title: `Generate: options of ${template}`,
      prompt: usage.split('\n', 1)[0] || 'Options as on its command line; Enter alone runs the template without any',
      value: before.join(' '),
    });
    return line === undefined ? undefined : words(line);
  }
  const known = chosen(options, before);
  const asked = options.filter((it) => known.has(it) || isWorthAsking(it));
  if (asked.length === 0) {
    return [];
  }
  const items = asked.map((option): OptionItem => ({
    ...label(option),
    picked: known.has(option),
    option,
  }));
  const picked = await vscode.window.showQuickPick(items, {
    title: `Generate: how ${template} works`,
    placeHolder: 'Select the options to use, then press OK',
    canPickMany: true,
    matchOnDescription: true,
  });
  if (picked === undefined) {
    return undefined;
  }
  const result: string[] = [];
  for (const { option } of picked) {
    const flag = option.flags[0] ?? '';
    if (option.value === null) {
      result.push(flag);
      continue;
    }
    const value = await vscode.window.showInputBox({
      title: `Generate: ${label(option).label}`,
      prompt: `${option.value}, for ${flag} of ${template}`,
      placeHolder: option.value,
      value: known.get(option) ?? '',
    });
    if (value === undefined) {
      return undefined;
    }
    result.push(flag, value);
  }
  return result;
}
