// The menu behind the status item: which release and server are in use, and the way to what concerns the extension as a whole.
import * as vscode from 'vscode';
import type { Server } from './client';
import { LANGUAGE, release } from './protocol';

interface Entry extends vscode.QuickPickItem {
  run?: () => Thenable<unknown> | void;
}

/** The release that the specification in the editor is read as. */
async function releaseEntry(server: Server): Promise<Entry[]> {
  const client = server.running;
  const document = vscode.window.activeTextEditor?.document;
  if (client === undefined || document?.languageId !== LANGUAGE) {
    return [];
  }
  const textDocument = client.code2ProtocolConverter.asTextDocumentIdentifier(document);
  const known = await client.sendRequest(release, { textDocument }).catch(() => undefined);
  if (known === undefined) {
    return [];
  }
  const run = () => vscode.commands.executeCommand('workbench.action.openSettings', 'dotgen.release');
  return [{ label: `$(versions) GenoM3 ${known.release}`, description: known.origin, detail: 'The release that this specification is read as; choose another one', run }];
}

export async function showMenu(server: Server): Promise<void> {
  const { info } = server;
  const command = (label: string, id: string, ...args: unknown[]): Entry => ({ label, run: () => vscode.commands.executeCommand(id, ...args) });
  const entries: Entry[] = [
    ...(await releaseEntry(server)),
    command('$(add) New Component…', 'dotgen.newComponent'),
    command('$(book) Manual', 'dotgen.openManual'),
    command('$(mortar-board) Get Started', 'dotgen.openWalkthrough'),
    command('$(gear) Settings', 'workbench.action.openSettings', '@ext:dotgen.dotgen'),
    { label: '', kind: vscode.QuickPickItemKind.Separator },
    { ...command('$(debug-restart) Restart Server', 'dotgen.restartServer'), ...(info === undefined ? {} : { description: `${info.name} ${info.version}` }) },
    command('$(output) Server Output', 'dotgen.showOutput'),
    command('$(list-flat) Extension Log', 'dotgen.showLogs'),
  ];
  const picked = await vscode.window.showQuickPick(entries, { title: 'dotgen', placeHolder: info === undefined ? 'The server does not run' : info.path });
  await picked?.run?.();
}
