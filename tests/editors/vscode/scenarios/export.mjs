// The formal model of a scenario: as the editor shows it, seen before it is written; what it cannot say is named.
import assert from 'node:assert/strict';
import { existsSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { until } from '../harness.mjs';

export const workspace = 'pump';

export function checks(wb) {
  const { page } = wb;
  const at = (name) => join(wb.folder, name);
  const rows = (text) => page.locator('.quick-input-list .monaco-list-row', { hasText: text });
  const notification = (text) => page.locator('.notification-toast', { hasText: text }).last();

  const more = [
    ['the model of a text that is not saved is shown, and nothing is written', async () => {
      await wb.open('pump.scn');
      await wb.endOf('pump.scn', 'scenario tank {');
      // A brace that is typed again would be closed, depending on what VS Code knows of the brackets by then.
      for (let i = 0; i < ' {'.length; i++) await page.keyboard.press('ArrowLeft');
      await wb.type('s');
      await wb.command('dotgen: Export the Formal Model…');
      await rows('RT-BIP').waitFor();
      await wb.shot('export-1-formats.png');
      await rows('UPPAAL').click();
      await notification('Export: UPPAAL: 3 new. Nothing is written yet').waitFor();
      await page.locator('.multiDiffEntry').first().waitFor();
      await wb.shot('export-2-preview.png');
      assert.ok(!existsSync(at('tanks.xta')));
    }],
    ['the files are written next to the scenario', async () => {
      await page.locator('.editor-actions .action-item', { hasText: /^Write$/ }).first().click();
      await until('the files exist', () => ['tanks.xta', 'tanks.q', 'tanks.xml'].every((name) => existsSync(at(name))));
      await notification('Export: UPPAAL: written').waitFor();
      assert.match(readFileSync(at('tanks.xta'), 'utf8'), /tanks: formal model, written by dotgen export/);
    }],
    ['what is not exported is named with its place', async () => {
      await wb.open('pump.scn');
      await wb.endOf('pump.scn', 'await ended pump.fill;');
      for (let i = 0; i < 'await ended pump.fill;'.length; i++) await page.keyboard.press('Backspace');
      await wb.type('kill pump;');
      await wb.command('dotgen: Export the Formal Model…');
      await rows('RT-BIP').click();
      const refused = notification('Export: RT-BIP: ');
      await refused.filter({ hasText: 'not exported: `kill`' }).waitFor();
      await wb.shot('export-3-refused.png');
      await refused.locator('.monaco-button', { hasText: 'Show' }).click();
      await page.locator('.monaco-editor .line-numbers.active-line-number', { hasText: /^10$/ }).waitFor();
    }],
  ];
  return { more };
}
