// Questions of commands: how many there are, and that they are in words.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { isWorthAsking, label, questions, titleOf } from '../../src/questions';

const option = (flags: string[], help: string, value: string | null = null) => ({ flags, help, value });

test('an option is asked for by what it does, and by its flags if nothing says that', () => {
  assert.deepEqual(label(option(['-t', '--terse'], 'leave out documentation')), { label: 'Leave out documentation', description: '-t, --terse' });
  assert.deepEqual(label(option(['-C'], 'write below DIR', 'DIR')), { label: 'Write below DIR', description: '-C DIR' });
  assert.deepEqual(label(option(['-x'], ' ')), { label: '-x', description: '' });
});

test('help and second spellings are not asked for', () => {
  const all = [option(['-h', '--help'], 'print this help'), option(['-i'], 'the same as -m interactive'), option(['-f', '--force'], 'overwrite files that exist')];
  assert.deepEqual(all.filter(isWorthAsking), [all[2]]);
});

test('the questions for a component are counted from 1, and as many as are asked', () => {
  const titles = (folders: number, interfaces: number) => questions(folders, interfaces).map((it, _, all) => titleOf(it, all));
  assert.deepEqual(titles(1, 3), ['New Component: name (1/3)', 'New Component: tasks (2/3)', 'New Component: ports (3/3)']);
  assert.deepEqual(titles(1, 0), ['New Component: name (1/2)', 'New Component: tasks (2/2)']);
  assert.deepEqual(titles(2, 1).map((it) => it.slice(15)), ['folder (1/4)', 'name (2/4)', 'tasks (3/4)', 'ports (4/4)']);
});
