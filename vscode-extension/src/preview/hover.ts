// The picture of a state machine in the hover of a task, activity or state.
import * as vscode from 'vscode';
import type { LanguageClient } from 'vscode-languageclient/node';
import { LANGUAGE } from '../protocol';
import { drawMachine, image } from './machine';

/** Returns a hover with the picture in the colours of the theme, and with the state under the pointer marked. */
export async function withMachine(client: LanguageClient | undefined, document: vscode.TextDocument, position: vscode.Position, hover: vscode.Hover, token: vscode.CancellationToken): Promise<vscode.Hover> {
  const text = hover.contents.find((it) => it instanceof vscode.MarkdownString);
  if (text === undefined || client === undefined || document.languageId !== LANGUAGE) return hover;
  if (!vscode.workspace.getConfiguration('dotgen', document).get('diagrams.hover', true)) return hover;
  const uri = client.code2ProtocolConverter.asUri(document.uri);
  try {
    const answer = await drawMachine(client, uri, { position, named: true }, token);
    const [state] = answer?.way ?? [];
    const picture = answer === null ? undefined : image(answer, state);
    // A hover shows its first lines. The text of a task repeats the lines under the pointer, that of a state begins with its codel.
    const at = state === undefined ? 0 : (/^```\w*\n[^]*?\n```\n?/.exec(text.value)?.[0].length ?? 0);
    if (picture !== undefined) text.value = `${text.value.slice(0, at)}\n${picture}\n\n${text.value.slice(at)}`;
  } catch {
    // Overtaken by typing: the hover is closed.
  }
  return hover;
}
