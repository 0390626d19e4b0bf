// The search for the server program.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { expandPath, locateServer, type Surroundings } from '../../src/server';

const PACKAGED = '/storage/server/1.0.0/dotgen';

function surroundings(programs: string[], changes: Partial<Surroundings> = {}): Surroundings {
  return {
    setting: '',
    packaged: () => Promise.resolve(programs.find((it) => it === PACKAGED)),
    workspaceRoot: '/ws',
    env: { PATH: '/usr/local/bin:/usr/bin' },
    platform: 'linux',
    homeDirectory: '/home/me',
    isExecutable: (path) => programs.includes(path),
    ...changes,
  };
}

test('the setting wins over the package, and the package over PATH', async () => {
  const all = ['/opt/dotgen', PACKAGED, '/usr/bin/dotgen'];
  assert.deepEqual(await locateServer(surroundings(all, { setting: ' /opt/dotgen ' })), { found: true, path: '/opt/dotgen', origin: 'setting' });
  assert.deepEqual(await locateServer(surroundings(all)), { found: true, path: PACKAGED, origin: 'package' });
  assert.deepEqual(await locateServer(surroundings(['/usr/bin/dotgen'])), { found: true, path: '/usr/bin/dotgen', origin: 'PATH' });
});

test('PATH is searched in order', async () => {
  const both = surroundings(['/usr/bin/dotgen', '/usr/local/bin/dotgen']);
  assert.deepEqual(await locateServer(both), { found: true, path: '/usr/local/bin/dotgen', origin: 'PATH' });
});

test('relative and empty entries of PATH are never searched: the folder is not trusted to hold programs', async () => {
  const found = await locateServer(surroundings(['dotgen', './dotgen', 'bin/dotgen'], { env: { PATH: ':.:bin' } }));
  assert.equal(found.found, false);
});

test('a wrong setting is an error, not a reason to run another server', async () => {
  const found = await locateServer(surroundings([PACKAGED], { setting: '/nowhere/dotgen' }));
  assert.ok(!found.found && found.reason === 'setting');
  assert.match(found.message, /dotgen\.server\.path is "\/nowhere\/dotgen"/);
});

test('a package that cannot be unpacked or run is an error, not a reason to run another server', async () => {
  const damaged = await locateServer(surroundings(['/usr/bin/dotgen'], { packaged: () => Promise.reject(new Error('damaged')) }));
  assert.deepEqual(damaged, { found: false, reason: 'package', message: 'damaged' });
  const found = await locateServer(surroundings(['/usr/bin/dotgen'], { packaged: () => Promise.resolve(PACKAGED) }));
  assert.ok(!found.found && found.reason === 'package');
  assert.match(found.message, /cannot be run from the folder of .*Set dotgen\.server\.path/);
});

test('with a setting nothing is unpacked', async () => {
  const packaged = () => Promise.reject(new Error('unpacked'));
  const found = await locateServer(surroundings(['/opt/dotgen'], { setting: '/opt/dotgen', packaged }));
  assert.equal(found.found, true);
});

test('without any server the message says what to do', async () => {
  const found = await locateServer(surroundings([]));
  assert.ok(!found.found && found.reason === 'nowhere');
  assert.match(found.message, /Install dotgen, or set dotgen\.server\.path/);
});

test('on Windows the program is an .exe and the variable may be Path', async () => {
  const found = await locateServer(surroundings(['/tools/dotgen.exe'], { platform: 'win32', env: { Path: '/tools' } }));
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
