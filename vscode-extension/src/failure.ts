// Work in the background: its errors are shown.
import * as vscode from 'vscode';
import { overtaken } from './client';

/** Ends when the work ends. An error is shown, unless an edit or newer work has overtaken the work. */
export async function reported(work: () => unknown): Promise<void> {
  try {
    await work();
  } catch (error) {
    if (!overtaken(error)) void vscode.window.showErrorMessage(`dotgen: ${error instanceof Error ? error.message : String(error)}`);
  }
}
