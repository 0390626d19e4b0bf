// The command lines of tasks.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { argumentsOfTask, OFFERED } from '../../src/taskArguments';

test('a task runs a subcommand on its folder, or on what it names', () => {
  assert.deepEqual(argumentsOfTask({ command: 'codels build' }, ['-D', 'SIM']), ['codels', 'build', '-D', 'SIM', '.']);
  assert.deepEqual(argumentsOfTask({ command: 'generate', args: ['skeleton', 'a.gen'] }, []), ['generate', 'skeleton', 'a.gen']);
});

test('tasks.json completes each command, and the matcher of the tasks exists', () => {
  const { taskDefinitions, problemMatchers } = JSON.parse(readFileSync(join(process.cwd(), 'package.json'), 'utf8')).contributes;
  const commands = taskDefinitions[0].properties.command.enum;
  assert.deepEqual(commands, [...OFFERED, 'generate']);
  assert.deepEqual(problemMatchers.map(({ name }: { name: string }) => name), ['dotgen', 'dotgen-absolute', 'dotgen-codels', 'dotgen-codels-absolute']);
});

test('each path is that of one matcher, and none is looked for', () => {
  type Matcher = { name: string; fileLocation: string | string[]; pattern: { regexp: string }[] };
  const { problemMatchers } = JSON.parse(readFileSync(join(process.cwd(), 'package.json'), 'utf8')).contributes;
  const location = (line: string) => (problemMatchers as Matcher[]).filter(({ pattern }) => new RegExp(pattern[1]?.regexp ?? '').test(line)).map((it) => it.fileLocation);
  const relative = ['relative', '${workspaceFolder}'];
  assert.deepEqual(location('  --> lamp/lamp.gen:5:43'), [relative, relative]);
  assert.deepEqual(location(' --> C.gen:5:43'), [relative, relative]);
  for (const path of ['/opt/include/a.gen', 'C:\\a.gen', 'c:/a.gen', '\\\\host\\a.gen']) assert.deepEqual(location(` --> ${path}:1:2`), ['absolute', 'absolute']);
});
