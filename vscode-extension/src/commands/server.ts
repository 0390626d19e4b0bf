// Commands and messages about the server process.
import * as vscode from 'vscode';
import type { LanguageClient } from 'vscode-languageclient/node';
import type { Server } from '../client';

/** Says what is wrong, and offers what can be done about it. */
export async function reportFailure(server: Server, reason: string): Promise<void> {
  const settings = 'Open Settings';
  const output = 'Show Output';
  const restart = 'Restart Server';
  const choice = await vscode.window.showErrorMessage(reason, settings, output, restart);
  if (choice === settings) {
    await vscode.commands.executeCommand('workbench.action.openSettings', 'dotgen.server');
  } else if (choice === output) {
    server.output.show(true);
  } else if (choice === restart) {
    await server.restart();
  }
}

/**
 * The client of the server, for a command. Waits for a server that is starting: a command may be what starts the extension.
 * Without a server, reports why.
 */
export async function ready(server: Server): Promise<LanguageClient | undefined> {
  if (server.current.kind === 'failed') {
    await reportFailure(server, server.current.reason);
  }
  if (server.current.kind === 'starting' || server.current.kind === 'stopped') {
    const options = { location: vscode.ProgressLocation.Window, title: 'dotgen is starting' };
    await vscode.window.withProgress(options, () => new Promise<void>((resolve) => {
      const changes = server.onDidChange(({ kind }) => {
        if (kind === 'stopped' || kind === 'starting') return;
        changes.dispose();
        resolve();
      });
    }));
  }
  return server.running;
}

/** For a setting that takes effect with the next server process. */
export async function offerRestart(server: Server): Promise<void> {
  // A server that does not run yet loses nothing.
  if (server.running === undefined) {
    await server.restart();
    return;
  }
  const restart = 'Restart Server';
  if ((await vscode.window.showInformationMessage('The dotgen server has to be restarted to use the new settings.', restart)) === restart) {
    await server.restart();
  }
}
