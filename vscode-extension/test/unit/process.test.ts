// A server that hangs while it starts is killed, with what it started.
import assert from 'node:assert/strict';
import { once } from 'node:events';
import { test } from 'node:test';
import { ServerProcess, type Program } from '../../src/process';

const skip = process.platform === 'win32';
const shell = (script: string): Program => ({ command: '/bin/sh', arguments: ['-c', script], env: process.env, cwd: undefined });
// A wrapper script that waits for another program.
const hanging = shell('sleep 1000 & echo $!; wait');

function exists(pid: number): boolean {
  try {
    process.kill(pid, 0);
    return true;
  } catch {
    return false;
  }
}

test('a start that takes too long is ended', { skip }, async () => {
  const late = new Promise<void>((resolve) => {
    const server = new ServerProcess(hanging, 200, resolve);
    void server.spawn();
  });
  await late;
});

test('a start that is given up leaves no process', { skip }, async () => {
  const server = new ServerProcess(hanging, 60_000, () => assert.fail('given up before'));
  const child = await server.spawn();
  const [first] = (await once(child.stdout!, 'data')) as [Buffer];
  const inner = Number(first.toString());
  assert.ok(exists(inner));
  server.kill();
  // The output closes when the last process that has it has ended.
  await once(child, 'close');
  assert.ok(child.signalCode === 'SIGKILL');
  await assert.rejects(server.spawn(), /given up/);
});

test('a server that has answered is not late, and is started again', { skip }, async () => {
  const server = new ServerProcess(shell('sleep 0.3'), 100, () => assert.fail('late'));
  for (let start = 0; start < 2; start++) {
    const child = await server.spawn();
    server.started();
    await once(child, 'exit');
  }
});

test('a program that cannot be started says why, once', { skip }, async () => {
  const server = new ServerProcess({ ...hanging, command: '/nowhere/dotgen' }, 100, () => assert.fail('late'));
  await assert.rejects(server.spawn(), /ENOENT/);
  await new Promise((done) => setTimeout(done, 200));
});
