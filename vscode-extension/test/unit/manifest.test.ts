// package.json agrees with the sources and with what the server reads.
import assert from 'node:assert/strict';
import { existsSync, readdirSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';

// The bundle of this file is run from the extension's folder (npm run test:unit).
const root = process.cwd();
const read = (path: string) => readFileSync(join(root, path), 'utf8');
const manifest = JSON.parse(read('package.json'));
const settings: Record<string, { default: unknown; scope?: string; type?: string | string[] }> = manifest.contributes.configuration.properties;

// Run by lenses and actions with arguments of theirs; nothing a person could call from the palette.
const calledByServer = ['dotgen.showReferences', 'dotgen.tellChanges'];

test('every contributed command is registered, and the reverse', () => {
  const contributed = manifest.contributes.commands.map((it: { command: string }) => it.command);
  const sources = readdirSync(join(root, 'src'), { recursive: true, encoding: 'utf8' }).filter((it) => it.endsWith('.ts'));
  const registered = sources.flatMap((it) => [...read(`src/${it}`).matchAll(/registerCommand\('([^']+)'/g)].map((match) => match[1]));
  assert.deepEqual(registered.sort(), [...contributed, ...calledByServer].sort());
});

test('every contributed file exists and is packaged', () => {
  const { languages, grammars } = manifest.contributes;
  const contributed: string[] = [...languages.flatMap((it: { configuration?: string }) => it.configuration ?? []), ...grammars.map((it: { path: string }) => it.path)];
  const files = contributed.map((path) => path.replace('./', ''));
  const packaged = read('.vscodeignore');
  for (const file of files) {
    assert.ok(existsSync(join(root, file)), file);
    assert.ok(packaged.includes(`!${file}\n`), `${file} is not in .vscodeignore`);
  }
});

test('settings that name programs are restricted in untrusted folders', () => {
  const restricted: string[] = manifest.capabilities.untrustedWorkspaces.restrictedConfigurations;
  for (const name of ['dotgen.server.path', 'dotgen.server.extraEnv', 'dotgen.run.debugger']) {
    assert.ok(settings[name] !== undefined, name);
    assert.ok(restricted.includes(name), name);
    // A folder may propose them once trusted; they are not synchronized between machines.
    assert.equal(settings[name]?.scope, 'machine-overridable', name);
  }
});

test('nothing but the own languages has other defaults', () => {
  const scopes = Object.keys(manifest.contributes.configurationDefaults);
  assert.deepEqual(scopes.filter((it) => !/^\[genom3(-\w+)?\]$/.test(it)), []);
});

test('settings are checkboxes, lists and fields where they can be', () => {
  // Tables of tables, and a number or a word: VS Code has no fields for these.
  const others = ['dotgen.connections', 'dotgen.format.unit'];
  for (const [name, { type }] of Object.entries(settings)) {
    const kind = [type ?? []].flat().filter((it) => it !== 'null');
    assert.ok(others.includes(name) || kind.length === 1, `${name}: ${type}`);
    assert.ok(type === undefined || !kind.includes('boolean') || kind.length === [type].flat().length, `${name} is no checkbox`);
  }
});

test('the walkthrough leads to commands and pictures that are there', () => {
  const commands = manifest.contributes.commands.map((it: { command: string }) => it.command);
  for (const { steps } of manifest.contributes.walkthroughs) {
    for (const { description, media } of steps) {
      for (const [, command = ''] of description.matchAll(/\(command:([\w.]+)/g)) {
        assert.ok(!command.startsWith('dotgen.') || commands.includes(command), command);
      }
      // VS Code shows `**bold**` and links here; other marks of Markdown are shown as they are.
      assert.doesNotMatch(description.replaceAll('**', ''), /[`*]/, description);
      const path: string = media.image ?? media.markdown;
      assert.ok(existsSync(join(root, path)), path);
      // Wider than the column beside the steps, a picture is scaled down and its text is too small to read.
      if (media.image !== undefined) assert.ok(readFileSync(join(root, path)).readUInt32BE(16) <= 700, path);
    }
  }
});

test('no file names a registry', () => {
  const names = ['package.json', 'package-lock.json', '.npmrc', ...readdirSync(join(root, 'src')).filter((it) => it.endsWith('.ts')).map((it) => `src/${it}`)];
  for (const name of names) {
    assert.doesNotMatch(read(name), /registry\.|\.tgz/, name);
  }
});
