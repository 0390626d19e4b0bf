// A file that only makes sense included is shown as the specification that includes it sees it. Which one that is stands in the
// language status, where it can be changed; the choice is kept for the workspace.
import * as vscode from 'vscode';
import type { Server } from '../client';
import { includingRoots, LANGUAGE } from '../protocol';
import { reported } from '../failure';
import { ready } from './server';

/** A command of the server; without `root` it chooses again. */
const CHOOSE = 'dotgen.chooseRoot';
/** Choices by included file, both as URIs. */
const KEY = 'includingRoots';

export class IncludingRoot implements vscode.Disposable {
  private readonly item = vscode.languages.createLanguageStatusItem('dotgen.includingRoot', { language: LANGUAGE });
  private readonly subscriptions: vscode.Disposable;
  private restored = false;
  // Answers for an older editor are dropped.
  private asked = 0;

  constructor(
    private readonly server: Server,
    private readonly memory: vscode.Memento,
  ) {
    this.item.name = 'Including specification';
    this.subscriptions = vscode.Disposable.from(
      this.item,
      vscode.commands.registerCommand('dotgen.selectIncludingSpecification', () => reported(() => this.select())),
      vscode.window.onDidChangeActiveTextEditor(() => this.show()),
      vscode.workspace.onDidSaveTextDocument(() => this.show()),
      server.onDidChange((state) => {
        if (state.kind === 'starting') {
          this.restored = false;
        }
        void this.show();
      }),
    );
  }

  dispose(): void {
    this.subscriptions.dispose();
  }

  private get choices(): Record<string, string> {
    return this.memory.get(KEY, {});
  }

  /** The roots of the active document, as the server knows them. */
  private async roots(): Promise<{ document: string; current: string | null; roots: string[] } | undefined> {
    const client = this.server.running;
    const document = vscode.window.activeTextEditor?.document;
    if (client === undefined || document?.languageId !== LANGUAGE) {
      return undefined;
    }
    if (!this.restored) {
      for (const [uri, root] of Object.entries(this.choices)) {
        await vscode.commands.executeCommand(CHOOSE, { uri, root });
      }
      this.restored = true;
    }
    const textDocument = client.code2ProtocolConverter.asTextDocumentIdentifier(document);
    return { document: textDocument.uri, ...(await client.sendRequest(includingRoots, { textDocument })) };
  }

  private async show(): Promise<void> {
    const asked = ++this.asked;
    // A server that restarts answers when it is back.
    const known = await this.roots().catch(() => undefined);
    if (asked !== this.asked) {
      return;
    }
    if (known === undefined || known.current === null || known.current === known.document) {
      this.item.text = 'Read on its own';
      this.item.detail = 'a specification, or a file that none includes';
      this.item.command = undefined;
      return;
    }
    this.item.text = `As ${name(known.current)} includes it`;
    this.item.detail = 'the specification this file is read in';
    this.item.command = known.roots.length > 1 ? { command: 'dotgen.selectIncludingSpecification', title: 'Select another' } : undefined;
  }

  private async select(): Promise<void> {
    if ((await ready(this.server)) === undefined) return;
    const known = await this.roots();
    if (known === undefined || known.roots.every((root) => root === known.document)) {
      void vscode.window.showInformationMessage('No specification of the workspace includes this file: it is read on its own.');
      return;
    }
    const items: (vscode.QuickPickItem & { root?: string })[] = known.roots.map((root) => ({
      label: `$(file-code) ${name(root)}`,
      description: vscode.workspace.asRelativePath(vscode.Uri.parse(root)) + (root === known.current ? ' — shown now' : ''),
      root,
    }));
    items.push({ label: '$(sparkle) Let dotgen choose', description: 'the specification opened last, otherwise the first by name' });
    const picked = await vscode.window.showQuickPick(items, { title: 'Read this file as included by', matchOnDescription: true });
    if (picked === undefined) {
      return;
    }
    const { [known.document]: _, ...choices } = this.choices;
    await this.memory.update(KEY, picked.root === undefined ? choices : { ...choices, [known.document]: picked.root });
    await vscode.commands.executeCommand(CHOOSE, { uri: known.document, root: picked.root });
    await this.show();
  }
}

function name(uri: string): string {
  return vscode.Uri.parse(uri).path.split('/').at(-1) ?? uri;
}
