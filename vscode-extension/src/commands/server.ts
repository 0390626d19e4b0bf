// Commands and messages about the server process.
import * as vscode from 'vscode';
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

/** For a command that needs a server when there is none. */
export async function notRunning(server: Server): Promise<void> {
  if (server.current.kind === 'failed') {
    await reportFailure(server, server.current.reason);
  } else {
    void vscode.window.showInformationMessage('The dotgen server is not ready yet; try again in a moment.');
  }
}

/** For a setting that takes effect with the next server process. */
export async function offerRestart(server: Server): Promise<void> {
  if (server.current.kind === 'failed' || server.current.kind === 'stopped') {
    await server.restart();
    return;
  }
  const restart = 'Restart Server';
  if ((await vscode.window.showInformationMessage('The dotgen server has to be restarted to use the new settings.', restart)) === restart) {
    await server.restart();
  }
}
