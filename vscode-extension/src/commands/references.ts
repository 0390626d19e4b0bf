// The command behind the lens "n references": shows what the server found in the editor's own list.
import * as vscode from 'vscode';
import type { Location, Position } from 'vscode-languageclient/node';
import type { Server } from '../client';
import { ready } from './server';

/** Argument of the command, in the words of the protocol. */
export interface ReferencesTarget {
  uri: string;
  position: Position;
  locations: Location[];
}

export async function showReferences(server: Server, { uri, position, locations }: ReferencesTarget): Promise<void> {
  const convert = (await ready(server))?.protocol2CodeConverter;
  if (convert === undefined) return;
  const found = locations.map((location) => convert.asLocation(location));
  await vscode.commands.executeCommand('editor.action.showReferences', convert.asUri(uri), convert.asPosition(position), found);
}
