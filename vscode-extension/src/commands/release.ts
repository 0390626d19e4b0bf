// The release of GenoM3 that the active specification is read as, in the language status.
import * as vscode from 'vscode';
import type { Server } from '../client';
import { LANGUAGE, release } from '../protocol';

export class ReleaseStatus implements vscode.Disposable {
  private readonly item = vscode.languages.createLanguageStatusItem('dotgen.release', { language: LANGUAGE });
  // Answers for an older editor are dropped.
  private asked = 0;
  private readonly subscriptions: vscode.Disposable;

  constructor(private readonly server: Server) {
    this.item.name = 'Release of GenoM3';
    this.item.command = { command: 'workbench.action.openSettings', title: 'Set', arguments: ['dotgen.release'] };
    this.subscriptions = vscode.Disposable.from(
      this.item,
      vscode.window.onDidChangeActiveTextEditor(() => this.show()),
      vscode.workspace.onDidSaveTextDocument(() => this.show()),
      vscode.workspace.onDidChangeConfiguration((event) => {
        if (event.affectsConfiguration('dotgen')) void this.show();
      }),
      server.onDidChange(() => this.show()),
    );
  }

  dispose(): void {
    this.subscriptions.dispose();
  }

  private async show(): Promise<void> {
    const asked = ++this.asked;
    const client = this.server.running;
    const document = vscode.window.activeTextEditor?.document;
    if (client === undefined || document?.languageId !== LANGUAGE) {
      return;
    }
    const textDocument = client.code2ProtocolConverter.asTextDocumentIdentifier(document);
    // A server that restarts answers when it is back.
    const known = await client.sendRequest(release, { textDocument }).catch(() => undefined);
    if (known === undefined || asked !== this.asked) {
      return;
    }
    this.item.text = `GenoM3 ${known.release}`;
    this.item.detail = known.verified ? known.origin : `${known.origin}; not verified`;
  }
}
