// Headers that let clangd understand codels without a build: written on request, offered once.
import * as vscode from 'vscode';
import type { Server } from '../client';
import { ready } from '../commands/server';
import { codelHeaders, LANGUAGE } from '../protocol';

const REMEMBERED = 'dotgen.codelHeaders.offered';
const CLANGD = 'llvm-vs-code-extensions.vscode-clangd';
const FLAG = '--compile-commands-dir=';

export class CodelHeaders implements vscode.Disposable {
  private readonly subscription: vscode.Disposable;

  constructor(
    private readonly server: Server,
    private readonly memory: vscode.Memento,
  ) {
    this.subscription = vscode.window.onDidChangeActiveTextEditor((editor) => void this.offer(editor));
    void this.offer(vscode.window.activeTextEditor);
  }

  dispose(): void {
    this.subscription.dispose();
  }

  /** Writes the headers of the specification, or of the one whose codels are in the active editor. */
  async write(): Promise<void> {
    const document = vscode.window.activeTextEditor?.document;
    if (document === undefined || (document.languageId !== LANGUAGE && !isCode(document))) {
      void vscode.window.showInformationMessage('Open a .gen file, or a source of its codels, first.');
      return;
    }
    const client = await ready(this.server);
    if (client === undefined) return;
    const textDocument = client.code2ProtocolConverter.asTextDocumentIdentifier(document);
    let answer;
    try {
      answer = await client.sendRequest(codelHeaders, { textDocument });
    } catch (error) {
      void vscode.window.showErrorMessage(`The headers cannot be written: ${error instanceof Error ? error.message : String(error)}`);
      return;
    }
    if (answer === null) {
      void vscode.window.showInformationMessage('No specification has its codels in this file.');
      return;
    }
    for (const file of answer.files) {
      await vscode.workspace.fs.writeFile(vscode.Uri.parse(file.uri), new TextEncoder().encode(file.text));
    }
    await this.written(vscode.Uri.parse(answer.folder), document.uri);
  }

  private async written(folder: vscode.Uri, document: vscode.Uri): Promise<void> {
    const shown = vscode.workspace.asRelativePath(folder);
    if (vscode.extensions.getExtension(CLANGD) === undefined) {
      void vscode.window.showInformationMessage(`Headers are in ${shown}. clangd finds them with ${FLAG}${shown}.`);
      return;
    }
    const use = 'Use in clangd';
    if ((await vscode.window.showInformationMessage(`Headers are in ${shown}.`, use)) !== use) {
      return;
    }
    const settings = vscode.workspace.getConfiguration('clangd', document);
    const others = settings.get<string[]>('arguments', []).filter((it) => !it.startsWith(FLAG));
    await settings.update('arguments', [...others, FLAG + folder.fsPath], vscode.ConfigurationTarget.Workspace);
    await vscode.commands.executeCommand('clangd.restart');
  }

  /** Offers the headers in a folder of codels that is opened for the first time and was never built. */
  private async offer(editor: vscode.TextEditor | undefined): Promise<void> {
    const document = editor?.document;
    if (document === undefined || document.uri.scheme !== 'file' || !isCode(document)) {
      return;
    }
    const home = await specificationFolder(document.uri);
    if (home === undefined) {
      return;
    }
    const offered = this.memory.get<string[]>(REMEMBERED, []);
    const key = home.toString();
    const known = ['.dotgen/compile_flags.txt', 'compile_commands.json', 'build/compile_commands.json', 'compile_flags.txt'];
    if (offered.includes(key) || (await Promise.all(known.map((it) => exists(vscode.Uri.joinPath(home, it))))).includes(true)) {
      return;
    }
    await this.memory.update(REMEMBERED, [...offered, key]);
    const write = 'Write Headers';
    const question = 'dotgen can write the headers that these codels include, so that clangd completes and checks them without a build.';
    if ((await vscode.window.showInformationMessage(question, write, 'No')) === write) {
      await this.write();
    }
  }
}

function isCode(document: vscode.TextDocument): boolean {
  return document.languageId === 'c' || document.languageId === 'cpp';
}

/** The folder with the `.gen` whose codels a source is among. */
async function specificationFolder(source: vscode.Uri): Promise<vscode.Uri | undefined> {
  const { folder = 'codels' } = vscode.workspace.getConfiguration('dotgen', source).get<{ folder?: string }>('codels', {}) ?? {};
  const at = source.path.lastIndexOf(`/${folder}/`);
  if (at < 0) {
    return undefined;
  }
  const home = source.with({ path: source.path.slice(0, at) || '/' });
  const entries = await vscode.workspace.fs.readDirectory(home).then(
    (it) => it,
    () => [],
  );
  return entries.some(([name]) => name.endsWith('.gen')) ? home : undefined;
}

async function exists(uri: vscode.Uri): Promise<boolean> {
  return vscode.workspace.fs.stat(uri).then(
    () => true,
    () => false,
  );
}
