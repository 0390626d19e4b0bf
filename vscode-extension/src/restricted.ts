// Folders that are not trusted: what does not work there, said once, and the way to trust them.
import * as vscode from 'vscode';

/** Remembers that it was said in this workspace. */
const TOLD = 'restricted.told';
const MANAGE = 'Manage Trust';

/** Says what needs trust, and offers to give it. */
export async function offerTrust(text: string): Promise<void> {
  if ((await vscode.window.showWarningMessage(text, MANAGE)) === MANAGE) {
    await vscode.commands.executeCommand('workbench.trust.manage');
  }
}

/** Says once in a workspace that is not trusted what is left out. */
export async function tellRestricted(memory: vscode.Memento): Promise<void> {
  if (vscode.workspace.isTrusted || memory.get(TOLD, false)) {
    return;
  }
  await memory.update(TOLD, true);
  await offerTrust('This folder is not trusted: dotgen runs no pkg-config, templates or components, and no simulations. Diagnostics, diagrams and verification work.');
}
