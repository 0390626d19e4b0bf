// A connection to a run that breaks is made again, and shows nothing twice.
import assert from 'node:assert/strict';
import { mkdtempSync, rmSync } from 'node:fs';
import { createServer, type Socket } from 'node:net';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { createInterface } from 'node:readline';
import { test } from 'node:test';
import { Talk } from '../../src/run/talk';

const components = [{ name: 'pump', executed: false, services: [{ name: 'fill', kind: 'activity', doc: null, inputs: [] }], ports: [{ name: 'level', direction: 'out', doc: null }] }];

test('a second connection adds no services and ports again', { skip: process.platform === 'win32', timeout: 10_000 }, async () => {
  const folder = mkdtempSync(join(tmpdir(), 'dotgen-test-'));
  const path = join(folder, 'run.sock');
  const watched: string[] = [];
  const sockets: Socket[] = [];
  const server = createServer((socket) => {
    sockets.push(socket);
    createInterface({ input: socket }).on('line', (line) => {
      const { describe, watch } = JSON.parse(line);
      if (describe === null) socket.write(`${JSON.stringify({ id: 'describe', event: 'description', components })}\n`);
      if (watch !== undefined) watched.push(watch);
    });
  }).listen(path);
  const talk = new Talk(path, () => {});
  while (watched.length < 1) await new Promise((next) => setTimeout(next, 10));
  talk.call('pump.fill', {});
  assert.equal(talk.services[0]?.active, true);
  sockets[0]?.destroy();
  while (watched.length < 2) await new Promise((next) => setTimeout(next, 10));
  assert.deepEqual(watched, ['pump/level', 'pump/level']);
  assert.deepEqual([talk.services.length, talk.ports.length, talk.simulated.length], [1, 1, 1]);
  assert.equal(talk.services[0]?.active, false);
  talk.end();
  server.close();
  rmSync(folder, { recursive: true });
});
