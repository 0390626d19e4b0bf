// package.json agrees with the sources and with what the server reads.
import assert from 'node:assert/strict';
import { existsSync, readdirSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';

// The bundle of this file is run from the extension's folder (npm run test:unit).
const root = process.cwd();
const read = (path: string) => readFileSync(join(root, path), 'utf8');
const manifest = JSON.parse(read('package.json'));
const settings: Record<string, { default: unknown; scope?: string }> = manifest.contributes.configuration.properties;

// Run by the server's lenses with arguments of theirs; nothing a person could call from the palette.
const calledByServer = ['dotgen.showReferences'];

test('every contributed command is registered, and the reverse', () => {
  const contributed = manifest.contributes.commands.map((it: { command: string }) => it.command);
  const sources = readdirSync(join(root, 'src'), { recursive: true, encoding: 'utf8' }).filter((it) => it.endsWith('.ts'));
  const registered = sources.flatMap((it) => [...read(`src/${it}`).matchAll(/registerCommand\('([^']+)'/g)].map((match) => match[1]));
  assert.deepEqual(registered.sort(), [...contributed, ...calledByServer].sort());
});

test('every contributed file exists and is packaged', () => {
  const { languages, grammars, snippets } = manifest.contributes;
  const contributed: string[] = [...languages.flatMap((it: { configuration?: string }) => it.configuration ?? []), ...[...grammars, ...snippets].map((it: { path: string }) => it.path)];
  const files = contributed.map((path) => path.replace('./', ''));
  const packaged = read('.vscodeignore');
  for (const file of files) {
    assert.ok(existsSync(join(root, file)), file);
    assert.ok(packaged.includes(`!${file}\n`), `${file} is not in .vscodeignore`);
  }
});

test('settings that name programs are restricted in untrusted folders', () => {
  const restricted: string[] = manifest.capabilities.untrustedWorkspaces.restrictedConfigurations;
  for (const name of ['dotgen.server.path', 'dotgen.server.extraEnv']) {
    assert.ok(settings[name] !== undefined, name);
    assert.ok(restricted.includes(name), name);
    // A folder may propose them once trusted; they are not synchronized between machines.
    assert.equal(settings[name]?.scope, 'machine-overridable', name);
  }
});

test('snippets have distinct prefixes and whole bodies', () => {
  const snippets: Record<string, { prefix: string; description: string; body: string[] }> = JSON.parse(read('snippets/genom3.json'));
  const prefixes = Object.values(snippets).map((snippet) => snippet.prefix);
  assert.equal(new Set(prefixes).size, prefixes.length);
  for (const [name, { body }] of Object.entries(snippets)) {
    const text = body.join('\n').replace(/\\\$/g, '');
    const opened = (text.match(/[{(]/g) ?? []).length;
    const closed = (text.match(/[})]/g) ?? []).length;
    assert.equal(opened, closed, name);
  }
});

test('no file names a registry', () => {
  const names = ['package.json', 'package-lock.json', '.npmrc', ...readdirSync(join(root, 'src')).filter((it) => it.endsWith('.ts')).map((it) => `src/${it}`)];
  for (const name of names) {
    assert.doesNotMatch(read(name), /registry\.|\.tgz/, name);
  }
});
