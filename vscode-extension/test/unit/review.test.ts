// What the server wants seen first opens VS Code's preview with everything ticked.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { WorkspaceEdit } from 'vscode-languageclient';
import { changed, reviewed, ticked } from '../../src/review';

const range = { start: { line: 0, character: 0 }, end: { line: 0, character: 0 } };
const change = (uri: string, annotationId: string) => ({ textDocument: { uri, version: null }, edits: [{ range, newText: 'x', annotationId }] });

const several: WorkspaceEdit = {
  changeAnnotations: { reviewed: { label: 'Rename to x', needsConfirmation: true } },
  documentChanges: [
    { kind: 'create', uri: 'file:///new.c', annotationId: 'reviewed' },
    change('file:///new.c', 'reviewed'),
    change('file:///a.gen', 'reviewed'),
    change('file:///a.c', 'reviewed'),
  ],
};

test('nothing of the edit is unticked, and one change that does nothing opens the preview', () => {
  const edit = ticked(several);
  assert.equal(edit.changeAnnotations?.['reviewed']?.needsConfirmation, false);
  assert.deepEqual(edit.documentChanges?.slice(0, 4), several.documentChanges);
  const opener = edit.documentChanges?.[4];
  // A file that is there, and may be: VS Code leaves it out of the list.
  assert.deepEqual(opener, { kind: 'create', uri: 'file:///a.gen', options: { ignoreIfExists: true }, annotationId: 'dotgen.preview' });
  assert.equal(edit.changeAnnotations?.['dotgen.preview']?.needsConfirmation, true);
});

test('what needs no review is left as it is, wherever it is answered', () => {
  const plain: WorkspaceEdit = { documentChanges: [change('file:///a.c', 'none')] };
  assert.equal(ticked(plain), plain);
  assert.equal(reviewed('textDocument/rename', null), null);
  const hover = { contents: 'text' };
  assert.equal(reviewed('textDocument/hover', hover), hover);
});

test('rename, actions and resolved actions are reviewed alike', () => {
  const opens = (edit: WorkspaceEdit | undefined) => edit?.changeAnnotations?.['dotgen.preview'] !== undefined;
  assert.ok(opens(reviewed('textDocument/rename', several) as WorkspaceEdit));
  const [command, action] = reviewed('textDocument/codeAction', [{ title: 'c', command: 'c' }, { title: 'a', edit: several }]) as [object, { edit: WorkspaceEdit }];
  assert.deepEqual(command, { title: 'c', command: 'c' });
  assert.ok(opens(action.edit));
  assert.ok(opens((reviewed('codeAction/resolve', { title: 'a', edit: several }) as { edit: WorkspaceEdit }).edit));
});

test('an action says what it changes, by file, unless it has a command of its own', () => {
  const edit: WorkspaceEdit = { documentChanges: [{ kind: 'create', uri: 'file:///b.c' }, change('file:///b.c', 'a'), change('file:///b.c', 'a'), change('file:///c.c', 'a')] };
  const told = [{ uri: 'file:///b.c', edits: 2 }, { uri: 'file:///c.c', edits: 1 }];
  assert.deepEqual(changed(edit), told);
  assert.deepEqual(changed({ changes: { 'file:///b.c': [{ range, newText: 'x' }], 'file:///c.c': [] } }), [{ uri: 'file:///b.c', edits: 1 }]);
  const own = { title: 'Stub', command: 'dotgen.showCodel' };
  const [plain, goes] = reviewed('textDocument/codeAction', [{ title: 'Fix', edit }, { title: 'Stub', edit, command: own }]) as { command: object }[];
  assert.deepEqual(plain?.command, { title: 'Fix', command: 'dotgen.tellChanges', arguments: ['Fix', told] });
  assert.deepEqual(goes?.command, own);
});
