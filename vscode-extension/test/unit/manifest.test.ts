// package.json agrees with the sources and with what the server reads.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { existsSync, readdirSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';

// The bundle of this file is run from the extension's folder (npm run test:unit).
const root = process.cwd();
const read = (path: string) => readFileSync(join(root, path), 'utf8');
const manifest = JSON.parse(read('package.json'));
const settings: Record<string, { default: unknown; scope?: string; type?: string | string[] }> = manifest.contributes.configuration.properties;

// Run by lenses, actions and links with arguments of theirs; nothing a person could call from the palette.
const calledByServer = ['dotgen.reveal', 'dotgen.showReferences', 'dotgen.tellChanges'];

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

test('nothing but the own languages and the list of comments has other defaults', () => {
  const scopes = Object.keys(manifest.contributes.configurationDefaults);
  // With its own default, a machine between the lines opens the list of comments.
  assert.deepEqual(scopes.filter((it) => !/^\[genom3(-\w+)?\]$/.test(it)), ['comments.openView']);
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

test('the page of the extension has no picture that VS Code would not show', () => {
  const pictures = (text: string) => [...text.matchAll(/!\[[^\]]*\]\(([^)\s]*)|<img[^>]*\ssrc="([^"]*)"/g)].map(([, mark, tag]) => mark ?? tag ?? '');
  const isAbsolute = (it: string) => it.startsWith('https://');
  // In the sources, a picture is one of the manual, which the package contains.
  for (const path of pictures(read('README.md')).filter((it) => !isAbsolute(it))) {
    assert.match(path, /^docs\//);
    assert.ok(existsSync(join(root, '..', path)), path);
    assert.ok(read('.vscodeignore').includes('!docs/**\n'));
  }
  // VS Code shows none from the package on that page: scripts/readme.mjs leaves them out.
  execFileSync(process.execPath, ['scripts/readme.mjs']);
  assert.match(manifest.scripts.package, /readme\.mjs .*--readme-path dist\/readme\.md/);
  const page = read('dist/readme.md');
  assert.ok(page.length > 1000);
  assert.deepEqual(pictures(page).filter((it) => !isAbsolute(it)), []);
});

test('every key is in the documentation, with its command', () => {
  const page = read('../docs/editors.md').toLowerCase();
  const { commands, keybindings } = manifest.contributes;
  for (const { key, command } of keybindings) {
    const { title } = commands.find((it: { command: string }) => it.command === command);
    assert.ok(page.includes(`| \`${key}\` | *dotgen: ${title.toLowerCase()}* |`), key);
  }
});

test('no file names a registry', () => {
  const names = ['package.json', 'package-lock.json', '.npmrc', ...readdirSync(join(root, 'src')).filter((it) => it.endsWith('.ts')).map((it) => `src/${it}`)];
  for (const name of names) {
    assert.doesNotMatch(read(name), /registry\.|\.tgz/, name);
  }
});
