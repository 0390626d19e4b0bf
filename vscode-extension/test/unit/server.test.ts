// The search for the server program.
import assert from 'node:assert/strict';
import { accessSync, constants, mkdirSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { expandPath, locateServer, packagedProgram, type Surroundings } from '../../src/server';

const PACKAGED = '/extension/server/dotgen';

function surroundings(programs: string[], changes: Partial<Surroundings> = {}): Surroundings {
  return {
    setting: '',
    packaged: programs.find((it) => it === PACKAGED),
    workspaceRoot: '/ws',
    env: { PATH: '/usr/local/bin:/usr/bin' },
    platform: 'linux',
    homeDirectory: '/home/me',
    isExecutable: (path) => programs.includes(path),
    ...changes,
  };
}

test('the setting wins over the package, and the package over PATH', () => {
  const all = ['/opt/dotgen', PACKAGED, '/usr/bin/dotgen'];
  assert.deepEqual(locateServer(surroundings(all, { setting: ' /opt/dotgen ' })), { found: true, path: '/opt/dotgen', origin: 'setting' });
  assert.deepEqual(locateServer(surroundings(all)), { found: true, path: PACKAGED, origin: 'package' });
  assert.deepEqual(locateServer(surroundings(['/usr/bin/dotgen'])), { found: true, path: '/usr/bin/dotgen', origin: 'PATH' });
});

test('PATH is searched in order', () => {
  const both = surroundings(['/usr/bin/dotgen', '/usr/local/bin/dotgen']);
  assert.deepEqual(locateServer(both), { found: true, path: '/usr/local/bin/dotgen', origin: 'PATH' });
});

test('relative and empty entries of PATH are never searched: the folder is not trusted to hold programs', () => {
  const found = locateServer(surroundings(['dotgen', './dotgen', 'bin/dotgen'], { env: { PATH: ':.:bin' } }));
  assert.equal(found.found, false);
});

test('a wrong setting is an error, not a reason to run another server', () => {
  const found = locateServer(surroundings([PACKAGED], { setting: '/nowhere/dotgen' }));
  assert.ok(!found.found && found.reason === 'setting');
  assert.match(found.message, /dotgen\.server\.path is "\/nowhere\/dotgen"/);
});

test('a package whose program cannot be run is an error, not a reason to run another server', () => {
  const found = locateServer(surroundings(['/usr/bin/dotgen'], { packaged: PACKAGED }));
  assert.ok(!found.found && found.reason === 'package');
  assert.match(found.message, /cannot be executed.*Set dotgen\.server\.path/);
});

test('the program of the package gets a missing permission to execute; without a program there is none', () => {
  const folder = mkdtempSync(join(tmpdir(), 'extension-'));
  try {
    assert.equal(packagedProgram(folder), undefined);
    const program = join(folder, 'server', process.platform === 'win32' ? 'dotgen.exe' : 'dotgen');
    mkdirSync(join(folder, 'server'));
    writeFileSync(program, '', { mode: 0o644 });
    assert.equal(packagedProgram(folder), program);
    accessSync(program, constants.X_OK);
  } finally {
    rmSync(folder, { recursive: true });
  }
});

test('without any server the message says what to do', () => {
  const found = locateServer(surroundings([]));
  assert.ok(!found.found && found.reason === 'nowhere');
  assert.match(found.message, /Install dotgen, or set dotgen\.server\.path/);
});

test('on Windows the program is an .exe and the variable may be Path', () => {
  const found = locateServer(surroundings(['/tools/dotgen.exe'], { platform: 'win32', env: { Path: '/tools' } }));
  assert.deepEqual(found, { found: true, path: '/tools/dotgen.exe', origin: 'PATH' });
});

test('paths of settings are expanded', () => {
  const at = surroundings([], { env: { BUILD: '/b', MONEY: '$&' } });
  assert.equal(expandPath('~/bin/dotgen', at), '/home/me/bin/dotgen');
  assert.equal(expandPath('~user/dotgen', at), '/ws/~user/dotgen');
  assert.equal(expandPath('${workspaceFolder}/target/dotgen', at), '/ws/target/dotgen');
  assert.equal(expandPath('${userHome}/dotgen', at), '/home/me/dotgen');
  assert.equal(expandPath('${env:BUILD}/dotgen', at), '/b/dotgen');
  assert.equal(expandPath('/x/${env:MONEY}', at), '/x/$&');
  assert.equal(expandPath('target/dotgen', at), '/ws/target/dotgen');
  assert.equal(expandPath('target/dotgen', { ...at, workspaceRoot: undefined }), 'target/dotgen');
});
