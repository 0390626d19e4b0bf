// Edits that the server wants seen before they are made: VS Code's own preview, with everything ticked.
import type { CodeAction, Command, WorkspaceEdit } from 'vscode-languageclient';

/** Name of the annotation that opens the preview. */
const PREVIEW = 'dotgen.preview';

/**
 * The edit as VS Code shows it with every box ticked. It opens the preview for what needs confirmation, but leaves that
 * unticked, so that *Apply* would do nothing. Here nothing of the edit needs it; what does is the creation of a file that is
 * there: the preview does not list it, since there is nothing to do.
 */
export function ticked(edit: WorkspaceEdit): WorkspaceEdit {
  const annotations = edit.changeAnnotations ?? {};
  const changes = edit.documentChanges ?? [];
  const created = new Set(changes.flatMap((it) => ('kind' in it && it.kind === 'create' ? [it.uri] : [])));
  const there = changes.flatMap((it) => ('textDocument' in it && !created.has(it.textDocument.uri) ? [it.textDocument.uri] : []))[0];
  const reviewed = Object.values(annotations).find((it) => it.needsConfirmation);
  if (reviewed === undefined) {
    return edit;
  }
  const confirmed = Object.entries(annotations).map(([id, it]) => [id, { ...it, needsConfirmation: false }]);
  if (there === undefined) {
    // New files alone overwrite nothing, and are as easily removed.
    return { ...edit, changeAnnotations: Object.fromEntries(confirmed) };
  }
  return {
    ...edit,
    changeAnnotations: Object.fromEntries([...confirmed, [PREVIEW, { label: reviewed.label, needsConfirmation: true }]]),
    documentChanges: [...changes, { kind: 'create', uri: there, options: { ignoreIfExists: true }, annotationId: PREVIEW }],
  };
}

/** Says what an action has changed in files that are not in sight. */
export const TELL_CHANGES = 'dotgen.tellChanges';

/** Argument of [[TELL_CHANGES]]: the files that an edit changes and how many changes are in each. */
export interface Changed {
  uri: string;
  edits: number;
}

/** What an edit changes, by file. */
export function changed({ documentChanges, changes }: WorkspaceEdit): Changed[] {
  const all = new Map<string, number>();
  const add = (uri: string, edits: number) => edits > 0 && all.set(uri, (all.get(uri) ?? 0) + edits);
  for (const it of documentChanges ?? []) if ('textDocument' in it) add(it.textDocument.uri, it.edits.length);
  for (const [uri, edits] of Object.entries(changes ?? {})) add(uri, edits.length);
  return [...all].map(([uri, edits]) => ({ uri, edits }));
}

function ofAction<T extends CodeAction | Command>(action: T): T {
  if (!('edit' in action) || action.edit === undefined) {
    return action;
  }
  const edit = ticked(action.edit);
  const told = changed(action.edit);
  // An action with a command goes to its change by itself.
  return action.command !== undefined || told.length === 0
    ? { ...action, edit }
    : { ...action, edit, command: { title: action.title, command: TELL_CHANGES, arguments: [action.title, told] } };
}

/** The answer to a request, with [[ticked]] edits. */
export function reviewed(method: string, answer: unknown): unknown {
  if (answer === null || answer === undefined) {
    return answer;
  }
  switch (method) {
    case 'textDocument/rename':
      return ticked(answer as WorkspaceEdit);
    case 'textDocument/codeAction':
      return (answer as (CodeAction | Command)[]).map(ofAction);
    case 'codeAction/resolve':
      return ofAction(answer as CodeAction);
    default:
      return answer;
  }
}
