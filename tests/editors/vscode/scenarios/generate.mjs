// Files from a specification: a template is chosen, what it would write is shown, and only then written.
import assert from 'node:assert/strict';
import { existsSync, readFileSync, rmSync, statSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { until } from '../harness.mjs';

export const workspace = 'maneuver';
// A template with a tag too much.
export const files = {
  'templates/print/template.tcl': 'template parse file printed.c file printed.c\n',
  'templates/print/printed.c': "int plain;\nint done; // '>",
};

export function checks(wb) {
  const { page } = wb;
  const at = (name) => join(wb.folder, name);
  const rows = (text) => page.locator('.quick-input-list .monaco-list-row', { hasText: text });
  const notification = (text) => page.locator('.notification-toast', { hasText: text }).last();
  const ready = () => wb.statusItem.locator('.codicon-check').waitFor();

  const more = [
    ['templates are listed at the component', async () => {
      await wb.open('maneuver.gen');
      await ready();
      await wb.endOf('maneuver.gen', 'component maneuver');
      await page.keyboard.press('Home');
      for (let i = 0; i < 'component m'.length; i++) await page.keyboard.press('ArrowRight');
      await wb.action('Generate…', () => wb.shot('generate-1-action.png'), rows('skeleton').first());
      await rows('docs').first().waitFor();
      await wb.shot('generate-2-templates.png');
    }],
    ['the options are those of the template', async () => {
      await rows('skeleton').first().click();
      await rows('Write below DIR').first().waitFor();
      await wb.shot('generate-3-options.png');
      await rows('Leave out documentation').first().click();
      await page.locator('.quick-input-count', { hasText: '1 Selected' }).waitFor();
      await page.locator('.quick-input-action a', { hasText: 'OK' }).click();
    }],
    ['what would be written is shown, and nothing is written', async () => {
      await notification('Nothing is written yet').waitFor();
      await page.locator('.multiDiffEntry').first().waitFor();
      await wb.shot('generate-4-preview.png');
      assert.ok(!existsSync(at('codels')));
    }],
    ['the files are written and the choice is remembered', async () => {
      // The button in the title of the preview.
      await page.locator('.editor-actions .action-item', { hasText: /^Write$/ }).first().click();
      await until('the files exist', () => existsSync(at('codels/Makefile.am')) && existsSync(at('bootstrap.sh')));
      await until('the choice is in dotgen.toml', () => readFileSync(at('dotgen.toml'), 'utf8').includes('[[generate]]'));
      await notification('written').waitFor();
      assert.match(readFileSync(at('dotgen.toml'), 'utf8'), /template = "skeleton"\narguments = \["-t"\]/);
      assert.ok(statSync(at('bootstrap.sh')).mode & 0o100, 'bootstrap.sh can be run');
      assert.ok(!existsSync(at('README.adoc')), 'terse');
      await wb.shot('generate-5-written.png');
    }],
    ['Regenerate finds everything up to date', async () => {
      await wb.open('maneuver.gen');
      await wb.command('dotgen: Regenerate');
      await notification('all files are up to date').waitFor();
      await wb.shot('generate-6-regenerate.png');
    }],
    ['a file that changes after the preview is not overwritten', async () => {
      rmSync(at('bootstrap.sh'));
      rmSync(at('codels/Makefile.am'));
      await wb.command('dotgen: Regenerate');
      await notification('Nothing is written yet').waitFor();
      await page.locator('.multiDiffEntry').first().waitFor();
      writeFileSync(at('codels/Makefile.am'), '# mine\n');
      await page.locator('.editor-actions .action-item', { hasText: /^Write$/ }).first().click();
      await notification('codels/Makefile.am changed after the preview').waitFor();
      await until('the other file exists', () => existsSync(at('bootstrap.sh')));
      assert.equal(readFileSync(at('codels/Makefile.am'), 'utf8'), '# mine\n');
      await wb.shot('generate-8-changed.png');
    }],
    ['a file of a template has its errors as it is edited', async () => {
      await wb.open('printed.c');
      await wb.squiggles().first().waitFor();
      await wb.endOf('templates/print/printed.c', 'int done');
      await wb.shot('generate-7-template-source.png');
      await page.keyboard.press('Backspace');
      await wb.squiggles().first().waitFor({ state: 'detached' });
      await wb.type('>');
      await wb.squiggles().first().waitFor();
      await page.keyboard.press('Backspace');
      await wb.squiggles().first().waitFor({ state: 'detached' });
    }],
  ];
  return { more };
}
