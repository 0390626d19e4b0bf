// Check marks of the walkthrough: a step is done once what the step says has happened.
import * as vscode from 'vscode';
import { LANGUAGE } from './protocol';

export type Step = 'component' | 'machine' | 'repair' | 'stubs' | 'verify' | 'simulate';

const known = new Set<Step>();

export function done(step: Step): void {
  if (known.has(step)) return;
  known.add(step);
  void vscode.commands.executeCommand('setContext', `dotgen.done.${step}`, true);
}

/** Watches for a specification that loses its errors. */
export function watchRepairs(): vscode.Disposable {
  const broken = new Set<string>();
  return vscode.languages.onDidChangeDiagnostics(({ uris }) => {
    for (const uri of uris) {
      const document = vscode.workspace.textDocuments.find((it) => it.uri.toString() === uri.toString());
      if (document?.languageId !== LANGUAGE) continue;
      const hasErrors = vscode.languages.getDiagnostics(uri).some((it) => it.severity === vscode.DiagnosticSeverity.Error);
      if (hasErrors) broken.add(uri.toString());
      else if (broken.delete(uri.toString())) done('repair');
    }
  });
}
