// What a newcomer does first: open the example, see an error and its correction, look around.
import assert from 'node:assert/strict';
import { readdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { until } from '../harness.mjs';

export const workspace = 'maneuver';
export const files = { 'typed.gen': '', 'snippet.gen': '' };

/** The words of a process; none if it has ended. */
function commandLine(pid) {
  try {
    return readFileSync(`/proc/${pid}/cmdline`, 'utf8').split('\0');
  } catch {
    return [];
  }
}

/** The checks, in order; those with `demo` are what `cargo xtask demo --check` proves. */
export function checks(wb) {
  const { page } = wb;
  const problems = page.locator('.markers-panel .monaco-list-row');
  const ready = () => wb.statusItem.locator('.codicon-check').waitFor();

  async function correctError() {
    for (let i = 0; i < ' oops'.length; i++) await page.keyboard.press('Backspace');
    await wb.squiggles().first().waitFor({ state: 'detached' });
  }

  async function typeError() {
    await wb.endOf('maneuver.gen', 'yield ether wcet 4 us');
    await page.keyboard.type(' oops');
    await wb.squiggles().first().waitFor();
  }

  /** Replaces what is written in the line that has `text` on disk. */
  async function replaceLine(text, by) {
    await wb.endOf('maneuver.gen', text);
    await page.keyboard.press('Shift+Home');
    await page.keyboard.type(by);
  }

  const demo = [
    ['the server is ready', async () => {
      await wb.open('maneuver.gen');
      await ready();
    }],
    ['a sound specification has no squiggle', async () => {
      assert.equal(await wb.squiggles().count(), 0);
      await wb.shot('01-open.png');
    }],
    ['a typed error gets a squiggle', async () => {
      await typeError();
      await wb.shot('02-squiggle.png');
    }],
    ['the Problems view lists it', async () => {
      await wb.command('Problems: Focus on Problems View');
      await problems.filter({ hasText: 'oops' }).first().waitFor();
      await wb.shot('03-problems.png');
    }],
    ['the squiggle vanishes when it is corrected', async () => {
      await wb.endOf('maneuver.gen', 'yield ether wcet 4 us');
      await correctError();
      await problems.filter({ hasText: 'oops' }).first().waitFor({ state: 'detached' });
      await wb.shot('04-fixed.png');
      await page.keyboard.press('Control+J');
      await wb.save();
      assert.doesNotMatch(readFileSync(join(wb.folder, 'maneuver.gen'), 'utf8'), /oops/);
    }],
  ];

  const more = [
    ['keywords are coloured', async () => {
      const line = wb.line('component maneuver');
      const colours = () =>
        line.evaluate((node) =>
          Object.fromEntries([...node.querySelectorAll('span span')].map((span) => [span.textContent.trim(), getComputedStyle(span).color])),
        );
      await wb.endOf('maneuver.gen', 'component maneuver');
      await until('keyword and name differ', async () => {
        const { component, maneuver } = await colours();
        return component && maneuver && component !== maneuver;
      });
    }],
    ['the outline shows the structure', async () => {
      await wb.command('Explorer: Focus on Outline View');
      const rows = page.locator('.outline-tree .monaco-list-row');
      await rows.filter({ hasText: 'maneuver' }).first().waitFor();
      await wb.shot('05-outline.png');
    }],
    ['hover tells about a name', async () => {
      await wb.endOf('maneuver.gen', 'task exec');
      const hover = await wb.hover('task exec', 'exec');
      // The declaration is shown in the language's colours.
      const spans = hover.locator('.monaco-tokenized-source span');
      await until('the code in the hover is coloured', async () => new Set(await spans.evaluateAll((all) => all.map((span) => getComputedStyle(span).color))).size > 1);
      await wb.shot('06-hover.png');
      await page.mouse.move(5, 5);
    }],
    ['an error of meaning is explained', async () => {
      await replaceLine('yield wait wcet 17 us;', 'yield wiat wcet 17 us;');
      await wb.squiggles().first().waitFor();
      await wb.command('Problems: Focus on Problems View');
      await problems.filter({ hasText: 'did you mean `wait`?' }).first().waitFor();
      await wb.shot('07-state.png');
      await page.keyboard.press('Control+J');
      await replaceLine('yield wait wcet 17 us;', 'yield wait wcet 17 us;');
      await wb.squiggles().first().waitFor({ state: 'detached' });
    }],
    ['a quick fix is applied', async () => {
      await replaceLine('yield wait wcet 17 us;', 'yield wait 17 us;');
      await wb.squiggles('warning').first().waitFor();
      for (let i = 0; i < ' us;'.length; i++) await page.keyboard.press('ArrowLeft');
      await wb.action('Write `wcet` before the duration', () => wb.shot('08-quick-fix.png'));
      await wb.line('yield wait wcet 17 us;').waitFor();
      await wb.squiggles('warning').first().waitFor({ state: 'detached' });
      await wb.save();
    }],
    ['an .idl of this workspace is a GenoM3 file', async () => {
      await wb.open('t3d.idl');
      await page.locator('[id="status.editor.mode"]', { hasText: 'GenoM3' }).waitFor();
      await ready();
      await wb.shot('09-idl.png');
    }],
    ['the syntax tree is shown beside the text', async () => {
      await wb.open('maneuver.gen');
      await wb.command('dotgen: Show Syntax Tree');
      await wb.line('SOURCE_FILE').waitFor();
      await wb.shot('10-syntax-tree.png');
      await wb.command('View: Close Editors in Other Groups');
      await page.locator('.tab', { hasText: 'Syntax Tree' }).waitFor({ state: 'detached' });
    }],
    ['typing keeps the layout', async () => {
      await wb.open('typed.gen');
      await page.locator('.monaco-editor .view-lines').first().click();
      await wb.type('component c {\ntask t {\ncodel<start> f()\nyield ether;\nperiod 5 ms;');
      await wb.save();
      // An empty file has no unit of its own: the editor's, four blanks, counts.
      const lines = ['component c {', '    task t {', '        codel<start> f()', '            yield ether;', '        period 5 ms;', '    }', '}'];
      assert.deepEqual(readFileSync(join(wb.folder, 'typed.gen'), 'utf8').trimEnd().split('\n'), lines);
      await page.keyboard.press('Control+W');
    }],
    ['a snippet writes a declaration', async () => {
      await wb.open('snippet.gen');
      await page.locator('.monaco-editor .view-lines').first().click();
      await wb.type('comp');
      await wb.press('Control+Space', page.locator('.suggest-widget .monaco-list-row', { hasText: 'component' }).first());
      await page.keyboard.press('Enter');
      await wb.type('arm');
      await page.keyboard.press('Escape');
      await wb.save();
      assert.match(readFileSync(join(wb.folder, 'snippet.gen'), 'utf8'), /^component arm \{\n    version "1\.0";\n    lang "c";\n\n {4}\n?\};/);
      await page.keyboard.press('Control+W');
    }],
    ['a server that dies is started again', async () => {
      const [before, ...others] = wb.languageServers();
      assert.ok(before !== undefined && others.length === 0, 'one server process per window');
      process.kill(before, 'SIGKILL');
      await until('another process runs', () => wb.languageServers().some((pid) => pid !== before));
      await ready();
      await wb.open('maneuver.gen');
      await typeError();
      await correctError();
      await wb.save();
    }],
    ['a wrong server path is said, with what to do', async () => {
      wb.folderSettings({ 'dotgen.server.path': '/nowhere/dotgen' });
      const toast = (text) => page.locator('.notification-toast', { hasText: text });
      await toast('has to be restarted').getByRole('button', { name: 'Restart Server' }).click();
      await toast('/nowhere/dotgen is not a program').waitFor();
      await wb.statusItem.locator('.codicon-error').waitFor();
      await until('the old server has ended', () => wb.languageServers().length === 0);
      await wb.shot('11-no-server.png');
      wb.folderSettings({});
      await ready();
    }],
    ['a server that hangs while it starts is given up for a corrected setting; a command waits for the server', async () => {
      const path = join(wb.folder, 'hang.sh');
      writeFileSync(path, '#!/bin/sh\nsleep 1000\n', { mode: 0o755 });
      const hanging = () => readdirSync('/proc').filter((pid) => /^\d+$/.test(pid) && commandLine(pid).includes(path));
      wb.folderSettings({ 'dotgen.server.path': path });
      await page.locator('.notification-toast', { hasText: 'has to be restarted' }).getByRole('button', { name: 'Restart Server' }).click();
      await until('the script runs', () => hanging().length === 1);
      await wb.statusItem.locator('.codicon-loading').waitFor();
      await wb.command('dotgen: Show Verification');
      wb.folderSettings({});
      await ready();
      await page.locator('.tab.active', { hasText: 'Verification' }).waitFor();
      await until('the script has ended', () => hanging().length === 0);
    }],
  ];

  return { demo, more };
}
