// The small picture of a state machine, for comments and hovers: an image, and the state that is marked in it.
import * as vscode from 'vscode';
import type { LanguageClient } from 'vscode-languageclient/node';
import { range } from '../panel/reveal';
import { diagram, type DiagramAnswer, type DiagramNode, type DiagramParams } from '../protocol';
import { fitted } from './fit';
import { isDark } from './target';

/** In Base64. VS Code cuts Markdown at 100,000 characters. */
const LONGEST = 60_000;

export interface Wanted {
  position?: vscode.Position;
  component?: string;
  owner?: string;
  /** The state to mark. */
  state?: string | undefined;
  /** Only what is named at the position. */
  named?: boolean;
}

/** Draws a machine for an image, which cannot use the theme of the editor around it. */
export function drawMachine(client: LanguageClient, uri: string, { position, component, owner, state, named }: Wanted, token?: vscode.CancellationToken): Promise<DiagramAnswer | null> {
  const wanted: DiagramParams = {
    textDocument: { uri },
    kind: 'fsm',
    theme: isDark() ? 'dark-clear' : 'light-clear',
    wcet: false,
    load: false,
    ...(position === undefined ? {} : { position: client.code2ProtocolConverter.asPosition(position) }),
    ...(component === undefined ? {} : { component }),
    ...(owner === undefined ? {} : { owner }),
    ...(state === undefined ? {} : { way: [state] }),
    ...(named === true ? { named } : {}),
  };
  return client.sendRequest(diagram, wanted, token);
}

/** Returns the image in Markdown; undefined if the image is too large for Markdown. */
export function image(answer: DiagramAnswer, state: string | undefined): string | undefined {
  const { picture, width, height } = fitted(answer, state);
  const data = Buffer.from(picture, 'utf8').toString('base64');
  return data.length > LONGEST ? undefined : `![state machine ${answer.title}](data:image/svg+xml;base64,${data}|width=${width},height=${height})`;
}

/** Returns the innermost node around a position, else the innermost one on its line. */
export function nodeAt(nodes: DiagramNode[], uri: string, at: vscode.Position): DiagramNode | undefined {
  const places = nodes.flatMap((node) => (node.place?.uri === uri ? [{ node, range: range(node.place.range) }] : []));
  const exact = places.filter((it) => it.range.contains(at));
  const around = exact.length > 0 ? exact : places.filter((it) => it.range.start.line <= at.line && at.line <= it.range.end.line);
  const size = (it: { range: vscode.Range }) => it.range.end.line - it.range.start.line;
  return around.sort((a, b) => size(a) - size(b))[0]?.node;
}
