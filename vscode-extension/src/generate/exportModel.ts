// Export the Formal Model…: the model of a scenario or specification for a tool of others, shown before it is written.
import * as vscode from 'vscode';
import type { Server } from '../client';
import { ready } from '../commands/server';
import { reveal } from '../panel/reveal';
import { exportModel as request, LANGUAGE, SCENARIO, type ModelFile, type Refusal } from '../protocol';
import type { FileChange } from './protocol';
import type { Review } from './review';

const FORMATS = [
  { label: 'UPPAAL', format: 'uppaal', detail: 'Network (.xta), queries (.q), and a drawing with both (.xml)' },
  { label: 'TChecker', format: 'tchecker', detail: 'Network (.tck), a label for each query' },
  { label: 'Fiacre', format: 'fiacre', detail: 'Program of TINA (.fcr), a property for each check' },
  { label: 'RT-BIP', format: 'bip', detail: 'BIP 2 with real time (.bip), a place for each check' },
] as const;

/** Asks for a format, and writes the files that the user agrees to. Nothing has to be saved before. */
export async function exportModel(server: Server, review: Review): Promise<void> {
  const document = vscode.window.activeTextEditor?.document;
  if (document === undefined || ![LANGUAGE, SCENARIO].includes(document.languageId)) {
    void vscode.window.showInformationMessage('Open a specification (.gen) or a scenario (.scn) first.');
    return;
  }
  const picked = await vscode.window.showQuickPick(FORMATS, { title: 'Export the formal model: format', placeHolder: 'The tool that reads the model' });
  const client = picked && (await ready(server));
  if (client === undefined) return;
  const title = `Export: ${picked?.label}`;
  const options = { location: vscode.ProgressLocation.Notification, title, cancellable: true };
  const textDocument = client.code2ProtocolConverter.asTextDocumentIdentifier(document);
  const answer = await vscode.window.withProgress(options, async (_, token) => {
    try {
      return await client.sendRequest(request, { textDocument, format: picked?.format ?? '' }, token);
    } catch (error) {
      if (token.isCancellationRequested) return null;
      throw error;
    }
  });
  if (answer === null) return;
  if ('refusals' in answer) return showRefusals(title, answer.refusals);
  const { files } = answer;
  const elsewhere = async (): Promise<FileChange[] | undefined> => {
    const chosen = await vscode.window.showOpenDialog({ canSelectFolders: true, canSelectFiles: false, title: `${title}: folder of the files` });
    return chosen?.[0] && changes(chosen[0], files);
  };
  const first = document.isUntitled ? await elsewhere() : await changes(vscode.Uri.joinPath(document.uri, '..'), files);
  if (first !== undefined && (await review.confirm(title, first, elsewhere))) {
    void vscode.window.showInformationMessage(`${title}: written.`);
  }
}

/** The files in a folder, next to what is there. */
async function changes(folder: vscode.Uri, files: ModelFile[]): Promise<FileChange[]> {
  return Promise.all(
    files.map(async ({ name, text: after }) => {
      const uri = vscode.Uri.joinPath(folder, name);
      const before = await vscode.workspace.fs.readFile(uri).then((it) => new TextDecoder().decode(it), () => null);
      return { uri: uri.toString(), change: before === null ? ('create' as const) : ('change' as const), before, after, mode: null };
    }),
  );
}

/** Shows the first refusal; all of them, with their places, in a list. */
async function showRefusals(title: string, refusals: Refusal[]): Promise<void> {
  const others = refusals.length > 1 ? ` (and ${refusals.length - 1} more)` : '';
  if ((await vscode.window.showErrorMessage(`${title}: ${refusals[0]?.message ?? ''}${others}`, 'Show')) === undefined) return;
  const items = refusals.map(({ message, location }) => {
    const where = location === null ? '' : `${vscode.workspace.asRelativePath(vscode.Uri.parse(location.uri))}:${location.range.start.line + 1}`;
    return { label: message, description: where, location };
  });
  const picked = items.length === 1 ? items[0] : await vscode.window.showQuickPick(items, { title, placeHolder: 'Not exported' });
  if (picked?.location) await reveal(picked.location.uri, picked.location.range);
}
