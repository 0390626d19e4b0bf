// The command behind the lens "n references": shows what the server found in the editor's own list.

import * as vscode from 'vscode';

interface Position {
  line: number;
  character: number;
}

/** Argument of the command, in the words of the protocol. */
export interface ReferencesTarget {
  uri: string;
  position: Position;
  locations: { uri: string; range: { start: Position; end: Position } }[];
}

const position = (it: Position): vscode.Position => new vscode.Position(it.line, it.character);

export async function showReferences(target: ReferencesTarget): Promise<void> {
  const locations = target.locations.map(
    (it) =>
      new vscode.Location(vscode.Uri.parse(it.uri), new vscode.Range(position(it.range.start), position(it.range.end))),
  );
  const uri = vscode.Uri.parse(target.uri);
  await vscode.commands.executeCommand('editor.action.showReferences', uri, position(target.position), locations);
}
