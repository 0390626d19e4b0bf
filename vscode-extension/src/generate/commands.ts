// Generate… and Regenerate: runs a template on the specification in the editor and writes what the user agrees to.
import * as vscode from 'vscode';
import type { Server } from '../client';
import { ready } from '../commands/server';
import { LANGUAGE } from '../protocol';
import { offerTrust } from '../restricted';
import { askArguments } from './options';
import type { Choice, Plan, TemplateInfo, Templates, TemplateUsage } from './protocol';
import type { Review } from './review';

const KINDS = { builtin: 'part of dotgen', tcl: 'GenoM3 template', minijinja: 'MiniJinja template' };

interface TemplateItem extends vscode.QuickPickItem {
  template: TemplateInfo;
}

/** Where an action of the server was taken. */
export interface Target {
  uri: string;
}

export class GenerateCommands {
  constructor(
    private readonly server: Server,
    private readonly review: Review,
  ) {}

  /** Asks for a template and its options, and runs it. */
  async generate(target?: Target): Promise<void> {
    await this.with(target, async (uri) => {
      const known = await this.execute<Templates>('dotgen.templates', { uri });
      const template = await pick(known);
      if (template === undefined) {
        return;
      }
      const usage = await this.execute<TemplateUsage>('dotgen.templateOptions', { uri, template: template.name });
      const before = known.remembered.find((it) => it.template === template.name)?.arguments ?? [];
      const args = await askArguments(template.name, usage, before);
      if (args !== undefined) {
        await this.finish(uri, await this.execute<Plan>('dotgen.generate', { uri, template: template.name, arguments: args, apply: false }));
      }
    });
  }

  /** Repeats what was generated before. */
  async regenerate(target?: Target): Promise<void> {
    await this.with(target, async (uri) => {
      const { remembered } = await this.execute<Templates>('dotgen.templates', { uri });
      if (remembered.length === 0) {
        return this.generate(target);
      }
      await this.finish(uri, await this.execute<Plan>('dotgen.regenerate', { uri, apply: false }));
    });
  }

  private async with(target: Target | undefined, work: (uri: string) => Promise<void>): Promise<void> {
    const document = vscode.window.activeTextEditor?.document;
    const uri = target?.uri ?? (document?.languageId === LANGUAGE ? document.uri.toString() : undefined);
    if (uri === undefined) {
      void vscode.window.showInformationMessage('Open the .gen file to generate from first.');
      return;
    }
    if (!vscode.workspace.isTrusted) {
      return offerTrust('Templates are programs: they are run in trusted folders only.');
    }
    if ((await ready(this.server)) === undefined) return;
    try {
      // What is on the disk is compared and merged.
      await vscode.workspace.saveAll(false);
      await work(uri);
    } catch (error) {
      void vscode.window.showErrorMessage(error instanceof Error ? error.message : String(error));
    }
  }

  /** Shows what a run would do, and does it. */
  private async finish(uri: string, plan: Plan): Promise<void> {
    const names = plan.choices.map((it) => it.template).join(', ');
    const title = `Generate: ${names}`;
    switch (plan.status) {
      case 'cancelled':
        return;
      case 'failed':
        return showFailure(title, plan);
      case 'unchanged':
        await this.remember(uri, plan.choices);
        if (plan.output.trim() !== '' && plan.files.length === 0 && !/ is up-to-date$/m.test(plan.output)) {
          await vscode.window.showTextDocument(await vscode.workspace.openTextDocument({ content: plan.output, language: 'c' }));
        } else {
          void vscode.window.showInformationMessage(`${title}: all files are up to date.`);
        }
        return;
      case 'preview':
        if (await this.review.confirm(title, plan.files)) {
          await this.remember(uri, plan.choices);
          void vscode.window.showInformationMessage(`${title}: written.`);
        }
    }
  }

  private async remember(uri: string, choices: Choice[]): Promise<void> {
    for (const choice of choices) {
      await this.execute('dotgen.rememberTemplate', { uri, template: choice.template, arguments: choice.arguments });
    }
  }

  private async execute<T>(command: string, argument: object): Promise<T> {
    const client = this.server.running;
    if (client === undefined) {
      throw new Error('The dotgen server is not running.');
    }
    return client.sendRequest('workspace/executeCommand', { command, arguments: [argument] });
  }
}

async function pick({ templates, remembered }: Templates): Promise<TemplateInfo | undefined> {
  const used = (it: TemplateInfo): boolean => remembered.some((choice) => choice.template === it.name);
  // The options of the last time are in words, and checked, in the question that follows.
  const items = templates.map((template): TemplateItem => ({
    label: template.name,
    description: KINDS[template.kind] + (used(template) ? ', used before' : ''),
    detail: template.about || (template.dir ?? ''),
    template,
  }));
  items.sort((a, b) => Number(used(b.template)) - Number(used(a.template)));
  const picked = await vscode.window.showQuickPick(items, { title: 'Generate: template', placeHolder: 'What to generate', matchOnDetail: true });
  return picked?.template;
}

async function showFailure(title: string, plan: Plan): Promise<void> {
  const { problem } = plan;
  const text = problem?.message ?? plan.messages.trim().split('\n')[0] ?? 'the template failed';
  const answer = await vscode.window.showErrorMessage(`${title}: ${text}`, ...(problem === null ? ['Show Messages'] : ['Open the Template']));
  if (answer === undefined) {
    return;
  }
  if (problem !== null) {
    const line = Math.max(problem.line - 1, 0);
    await vscode.window.showTextDocument(vscode.Uri.parse(problem.uri), { selection: new vscode.Range(line, 0, line, 0) });
  } else {
    await vscode.window.showTextDocument(await vscode.workspace.openTextDocument({ content: plan.messages }));
  }
}
