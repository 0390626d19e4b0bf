// Unpacking the program of the package.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { createHash } from 'node:crypto';
import { chmodSync, mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync, statSync, utimesSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { afterEach, beforeEach, test } from 'node:test';
import { brotliCompressSync } from 'node:zlib';
import { explained, unpack, type Packed } from '../../src/unpack';

const PROGRAM = '#!/bin/sh\necho dotgen\n';
const DAY_S = 24 * 60 * 60;
let folder = '';
let lines: string[] = [];

/** Writes a package with a program, and returns what unpacks it. */
function packed(text: string, version: string): Packed {
  const from = join(folder, `extension-${version}`, 'server');
  mkdirSync(from, { recursive: true });
  const description = { name: 'dotgen', bytes: text.length, sha256: createHash('sha256').update(text).digest('hex') };
  writeFileSync(join(from, 'dotgen.br'), brotliCompressSync(text));
  writeFileSync(join(from, 'dotgen.json'), JSON.stringify(description));
  return { from, into: join(folder, 'storage', 'server'), version, log: (line) => lines.push(line) };
}

/** The path of the unpacked program. */
async function unpacked(from: Packed): Promise<string> {
  const program = await unpack(from);
  assert.ok(program !== undefined);
  return program;
}

function age(path: string, days: number): void {
  const then = Date.now() / 1000 - days * DAY_S;
  utimesSync(path, then, then);
}

beforeEach(() => {
  folder = mkdtempSync(join(tmpdir(), 'unpack-'));
  lines = [];
});
afterEach(() => rmSync(folder, { recursive: true, force: true }));

test('the program is unpacked once, and can be run', async () => {
  const from = packed(PROGRAM, '1.0.0');
  const program = await unpacked(from);
  assert.equal(execFileSync(program, { encoding: 'utf8' }), 'dotgen\n');
  assert.equal(statSync(program).mode & 0o777, 0o755);
  const { ino } = statSync(program);
  // The compressed file is not read again.
  rmSync(join(from.from, 'dotgen.br'));
  assert.equal(await unpacked(from), program);
  assert.equal(statSync(program).ino, ino);
  assert.equal(lines.length, 1);
});

test('a package without a program has none', async () => {
  const from = { ...packed(PROGRAM, '1.0.0'), from: join(folder, 'universal') };
  assert.equal(await unpack(from), undefined);
});

test('a program that is cut off or cannot be executed is unpacked again', async () => {
  const from = packed(PROGRAM, '1.0.0');
  const program = await unpacked(from);
  writeFileSync(program, PROGRAM.slice(0, 4));
  assert.equal(await unpacked(from), program);
  assert.equal(readFileSync(program, 'utf8'), PROGRAM);
  chmodSync(program, 0o644);
  await unpacked(from);
  assert.equal(statSync(program).mode & 0o777, 0o755);
});

test('a damaged package is reported, and leaves no file', async () => {
  const large = PROGRAM + '# and so on\n'.repeat(1000);
  const damages: [RegExp, (server: string) => void][] = [
    [/dotgen\.br: unexpected end of file/, (it) => writeFileSync(join(it, 'dotgen.br'), readFileSync(join(it, 'dotgen.br')).subarray(0, 30))],
    [/dotgen\.br: /, (it) => writeFileSync(join(it, 'dotgen.br'), Buffer.alloc(64, 0xff))],
    [/dotgen\.br: wrong checksum/, (it) => writeFileSync(join(it, 'dotgen.br'), brotliCompressSync(large.replaceAll('on', 'no')))],
    [/dotgen\.br: ENOENT/, (it) => rmSync(join(it, 'dotgen.br'))],
    [/dotgen\.json: /, (it) => writeFileSync(join(it, 'dotgen.json'), '{')],
    [/ENOENT.*dotgen\.json/, (it) => rmSync(join(it, 'dotgen.json'))],
  ];
  for (const [reason, damage] of damages) {
    const from = packed(large, '1.0.0');
    damage(from.from);
    await assert.rejects(unpack(from), (error: Error) => {
      assert.match(error.message, /^The package of the dotgen extension is damaged \(.*Reinstall the extension/);
      assert.match(error.message, reason);
      return true;
    });
    const files = readdirSync(folder, { recursive: true, encoding: 'utf8' }).filter((it) => it.startsWith('storage'));
    assert.deepEqual(files.filter((it) => statSync(join(folder, it)).isFile()), []);
  }
});

test('a folder that cannot be written is named', async () => {
  const from = packed(PROGRAM, '1.0.0');
  writeFileSync(join(folder, 'storage'), 'a file');
  await assert.rejects(unpack(from), /^Error: The dotgen server cannot be unpacked into .*ENOTDIR.*Make the folder writable and choose Restart Server/);
});

test('a full disk is reported with the size that is needed', () => {
  const full = Object.assign(new Error('ENOSPC: no space left on device, write'), { code: 'ENOSPC', syscall: 'write' });
  assert.match(explained(full, '/extension/server/dotgen.br', 33_400_000, '/storage').message, /^Disk full: the dotgen server needs 34 MB in \/storage\. Free space/);
});

test('windows that unpack at once all get the complete program', async () => {
  const from = packed(PROGRAM.repeat(50_000), '1.0.0');
  const programs = await Promise.all(Array.from({ length: 8 }, () => unpacked(from)));
  assert.equal(new Set(programs).size, 1);
  assert.equal(readFileSync(programs[0] ?? '', 'utf8'), PROGRAM.repeat(50_000));
  assert.equal(readdirSync(from.into).length, 1);
});

test('another program of the same version has a folder of its own', async () => {
  const first = await unpacked(packed(PROGRAM, '1.0.0'));
  const second = await unpacked(packed(`${PROGRAM}# changed\n`, '1.0.0'));
  assert.notEqual(first, second);
  assert.equal(readFileSync(first, 'utf8'), PROGRAM);
});

test('a version that was not started for a day is deleted, with the rest of an interrupted unpacking', async () => {
  const old = await unpacked(packed(PROGRAM, '1.0.0'));
  const { into } = packed(PROGRAM, '1.0.0');
  const rest = join(into, 'rest.partial');
  writeFileSync(rest, '');
  // Its window may still be open.
  await unpacked(packed(PROGRAM, '1.1.0'));
  assert.equal(readdirSync(into).length, 3);
  age(dirname(old), 2);
  age(rest, 2);
  const current = await unpacked(packed(PROGRAM, '1.1.0'));
  assert.deepEqual(readdirSync(into), [dirname(current).slice(into.length + 1)]);
});

test('each start of a version keeps it for another day', async () => {
  const from = packed(PROGRAM, '1.0.0');
  const program = await unpacked(from);
  age(dirname(program), 2);
  await unpacked(from);
  await unpacked(packed(PROGRAM, '1.1.0'));
  assert.equal(readFileSync(program, 'utf8'), PROGRAM);
});
