// A specification and its codels in step: stubs, navigation, drift, told once.
import assert from 'node:assert/strict';
import { existsSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { LOST_MS, until } from '../harness.mjs';

export const workspace = 'drift';

export const settings = {
  // A folder of an earlier day is replaced, the rest is kept.
  'clangd.arguments': ['--background-index', '--compile-commands-dir=/elsewhere'],
  // Whether a refactoring has been applied is seen by what has to be saved.
  'files.refactoring.autoSave': false,
};

// In place of clangd's extension: it says with what it would start.
export const others = {
  'llvm-vs-code-extensions.vscode-clangd': {
    contributes: {
      commands: [{ command: 'clangd.restart', title: 'Restart' }],
      configuration: { properties: { 'clangd.arguments': { type: 'array', default: [] } } },
    },
    main: `
      const vscode = require('vscode');
      exports.activate = (context) => context.subscriptions.push(vscode.commands.registerCommand('clangd.restart', () => {
        const file = vscode.Uri.joinPath(vscode.workspace.workspaceFolders[0].uri, '.clangd-started');
        const given = vscode.workspace.getConfiguration('clangd').get('arguments');
        return vscode.workspace.fs.writeFile(file, Buffer.from(JSON.stringify(given)));
      }));`,
  },
};

export function checks(wb) {
  const { page } = wb;
  const SOURCE = 'tank_control_codels.c';
  const problems = page.locator('.markers-panel .monaco-list-row');
  const text = (name) => readFileSync(join(wb.folder, name), 'utf8');
  const codels = () => text(`codels/${SOURCE}`);
  /** Saves what an applied edit has changed. Its files become dirty one after the other: what comes late is saved again. */
  async function saveAll() {
    const dirty = page.locator('.tab.dirty').first();
    await dirty.waitFor();
    for (let rest = 5; ; rest -= 1) {
      await wb.command('File: Save All Files');
      try {
        return await dirty.waitFor({ state: 'detached', timeout: LOST_MS / 2 });
      } catch (error) {
        if (rest === 0) throw error;
      }
    }
  }

  const lens = (what) => page.locator('.contentWidgets .codelens-decoration a', { hasText: what }).first();

  const quickFix = (title, shot) => wb.action(title, () => wb.shot(shot));

  /** Puts the cursor into the word after `before`, in the line that begins with these. */
  async function into(name, line, before) {
    await wb.endOf(name, line);
    await page.keyboard.press('Home');
    for (let i = 0; i <= before.length; i++) await page.keyboard.press('ArrowRight');
  }

  /** Shows the problems that speak of something: the list draws only what fits. */
  async function problemsOf(what) {
    await wb.command('Problems: Focus on Problems View');
    const filter = page.locator('.panel .viewpane-filter input, .panel input[placeholder^="Filter"]').first();
    await filter.fill(what);
    return problems.filter({ hasText: what });
  }

  /** Applies what the Refactor Preview shows, as it opens: everything ticked, the sources named. */
  async function applyPreview(shot) {
    const apply = page.locator('.panel .monaco-button', { hasText: /^Apply$/ }).first();
    await apply.waitFor();
    const rows = page.locator('.panel .monaco-list-row[aria-level="1"]');
    await rows.filter({ hasText: SOURCE }).first().waitFor();
    // The list draws only what fits: a long one is scrolled to its end.
    const specification = rows.filter({ hasText: 'tank.gen' }).first();
    await rows.first().hover();
    await until('the specification is listed', async () => {
      if (!(await specification.isVisible())) await page.mouse.wheel(0, 200);
      return specification.isVisible();
    });
    const boxes = rows.locator('.edit-checkbox');
    for (let i = 0; i < (await boxes.count()); i++) assert.equal(await boxes.nth(i).getAttribute('aria-checked'), 'true');
    await wb.shot(shot);
    await apply.click();
    await apply.waitFor({ state: 'hidden' });
  }

  /** Nothing asks before a fix is made. */
  const preview = page.locator('.panel .monaco-button', { hasText: /^Apply$/ });

  const more = [
    ['drift is shown in the specification', async () => {
      await wb.open('tank.gen');
      await wb.statusItem.locator('.codicon-check').waitFor();
      // Of a codel without a function only: the others are shown at their functions.
      await wb.endOf('tank.gen', 'codel<wait> tank_drain_wait');
      await wb.squiggles('warning').first().waitFor();
      await wb.shot('codels-01-specification.png');
    }],
    ['and in the sources, although none is open', async () => {
      await wb.command('Problems: Focus on Problems View');
      await problems.filter({ hasText: 'tank_codels.c' }).first().waitFor();
      await wb.shot('codels-02-problems.png');
      await page.keyboard.press('Control+J');
    }],
    ['the quick fix writes the stub, and what is typed goes into its body', async () => {
      await into('tank.gen', 'codel<wait> tank_drain_wait', 'codel<wait> ');
      await quickFix('Write a stub of', 'codels-03-quick-fix.png');
      await page.locator(`.tab.active[data-resource-name="${SOURCE}"]`).first().waitFor();
      const sample = page.locator('.monaco-editor .view-line', { hasText: 'skeleton sample: insert your code' }).first();
      await sample.waitFor();
      await wb.shot('codels-04-stub.png');
      assert.equal(await preview.count(), 0);
      await wb.type('drained();');
      await saveAll();
      await until('the stub is on disk', () => /tank_drain_wait\(double until, const tank_reading \*last,[^{]*\{\n  drained\(\);\n/.test(codels()));
      assert.match(codels(), /return tank_pause_wait;/);
    }],
    ['go to implementation opens it', async () => {
      await wb.open('tank.gen');
      await into('tank.gen', 'codel<wait> tank_drain_wait', 'codel<wait> ');
      await wb.press('Control+F12', page.locator(`.tab.active[data-resource-name="${SOURCE}"]`).first());
      await page.locator('.monaco-editor .view-line', { hasText: 'tank_drain_wait(double until' }).first().waitFor();
      await wb.shot('codels-05-implementation.png');
    }],
    ['a lens above the function says what the specification says, and leads back', async () => {
      await lens('activity drain: wait → pause::wait, ether').waitFor();
      await wb.shot('codels-06-lens.png');
      await wb.click(lens('activity drain: wait → pause::wait, ether'), page.locator('.tab.active[data-resource-name="tank.gen"]').first());
    }],
    ['a changed parameter shows the mismatch at the function', async () => {
      await wb.open(SOURCE);
      await wb.endOf(`codels/${SOURCE}`, 'tank_fill_stop(double *setpoint');
      await page.keyboard.press('Shift+Home');
      await wb.type('tank_fill_stop(float *setpoint, const genom_context self)');
      await wb.squiggles('warning').first().waitFor();
      const told = await problemsOf('`tank_fill_stop` does not have the prototype');
      await told.first().waitFor();
      assert.equal(await told.count(), 1);
      await wb.shot('codels-07-mismatch.png');
      await page.keyboard.press('Control+J');
    }],
    ['and the quick fix mends it', async () => {
      await wb.open(SOURCE);
      await into(`codels/${SOURCE}`, 'tank_fill_stop(double *setpoint', '');
      await quickFix('Update the signature', 'codels-09-signature.png');
      await saveAll();
      await until('the parameter has its type again', () => /tank_fill_stop\(double \*setpoint/.test(codels()));
    }],
    ['rename is on both sides', async () => {
      await wb.open('tank.gen');
      await into('tank.gen', 'codel<wait> tank_drain_wait', 'codel<wait> ');
      const input = await wb.press('F2', page.locator('.rename-box input.rename-input'));
      await input.fill('tank_drain_watch');
      await page.keyboard.press('Enter');
      await applyPreview('codels-11-rename.png');
      await saveAll();
      await until('the function has the new name', () => /\ntank_drain_watch\(/.test(codels()));
      assert.match(text('tank.gen'), /codel<wait> tank_drain_watch\(/);
    }],
    ['one undo takes it back on both sides', async () => {
      await wb.line('tank_drain_watch').click();
      await page.keyboard.press('Control+Z');
      await saveAll();
      await until('both have the old name', () => /\ntank_drain_wait\(/.test(codels()) && /codel<wait> tank_drain_wait\(/.test(text('tank.gen')));
      await page.keyboard.press('Control+Shift+Z');
      await saveAll();
      await until('both have the new name again', () => /\ntank_drain_watch\(/.test(codels()) && /codel<wait> tank_drain_watch\(/.test(text('tank.gen')));
    }],
    ['everything that differs is mended in one go', async () => {
      // The findings of the text that was just saved.
      await (await problemsOf('tank_fill_start')).first().waitFor();
      await into('tank.gen', 'codel tank_mix', 'codel ');
      await quickFix('Fix all differences', 'codels-12-fix-all.png');
      await applyPreview('codels-13-fix-all-preview.png');
      await saveAll();
      await problemsOf('');
      await page.locator('.markers-panel', { hasText: 'No problems have been detected' }).waitFor();
      await wb.shot('codels-14-fixed.png');
      await page.keyboard.press('Control+J');
    }],
    ['headers for clangd are offered once, and written', async () => {
      const offer = page.locator('.notifications-toasts .notification-list-item', { hasText: 'without a build' }).first();
      if (!(await offer.isVisible())) await wb.command('Notifications: Show Notifications');
      const write = page.locator('.notification-list-item .monaco-button', { hasText: 'Write Headers' }).first();
      await write.waitFor();
      await wb.shot('codels-15-offer.png');
      await wb.open(SOURCE);
      if (!(await write.isVisible())) await wb.command('Notifications: Show Notifications');
      await write.click();
      const headers = ['compile_flags.txt', 'tank_c_types.h'].map((name) => `.dotgen/${name}`);
      await until('the headers are there', () => headers.every((it) => existsSync(join(wb.folder, it)) && text(it)));
      assert.match(text('.dotgen/tank_c_types.h'), /tank_reading/);
      await wb.shot('codels-16-headers.png');
    }],
    ['and clangd is told where they are', async () => {
      const use = page.locator('.notification-list-item .monaco-button', { hasText: 'Use in clangd' }).first();
      if (!(await use.isVisible())) await wb.command('Notifications: Show Notifications');
      await use.click();
      // A file exists before its text does.
      await until('clangd is started again', () => existsSync(join(wb.folder, '.clangd-started')) && text('.clangd-started'));
      const given = ['--background-index', `--compile-commands-dir=${join(wb.folder, '.dotgen')}`];
      assert.deepEqual(JSON.parse(text('.clangd-started')), given);
      assert.deepEqual(JSON.parse(text('.vscode/settings.json'))['clangd.arguments'], given);
      await wb.shot('codels-17-clangd.png');
    }],
  ];

  return { more };
}
