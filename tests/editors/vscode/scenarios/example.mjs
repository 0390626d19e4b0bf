// A window without a folder: an example is copied to where the user says, never over a folder, and opened.
import { existsSync, mkdirSync, readdirSync } from 'node:fs';
import { join } from 'node:path';
import { until } from '../harness.mjs';

export const workspace = undefined;
export const isEmpty = true;

export function checks(wb) {
  const { page } = wb;
  const input = page.locator('.quick-input-widget input.input').first();
  const listed = (name) => page.locator('.quick-input-list .monaco-list-row', { hasText: name }).first();

  /** Chooses an example, and the folder of the test. */
  async function copy(name, shot) {
    await wb.command('dotgen: Open Example');
    await listed('verification while you type').waitFor();
    if (shot !== undefined) await wb.shot(shot);
    await input.fill(name);
    await page.keyboard.press('Enter');
    await page.locator('.quick-input-title', { hasText: `Folder that gets the folder ${name}` }).waitFor();
    await listed('..').waitFor();
    await input.fill(`${wb.folder}/`);
    await listed('.vscode').waitFor();
    await page.locator('.quick-input-action a', { hasText: 'Copy Here' }).click();
  }

  const more = [
    ['a folder that exists is left alone', async () => {
      mkdirSync(join(wb.folder, 'pump'));
      await copy('pump', 'example-1-choice.png');
      await page.locator('.notification-toast', { hasText: 'The example was not copied' }).waitFor();
      await wb.shot('example-2-exists.png');
      await until('nothing was copied', () => readdirSync(join(wb.folder, 'pump')).length === 0);
    }],
    ['an example is copied and opened', async () => {
      await copy('drift');
      await until('its files are there', () => ['tank.gen', 'codels/tank_codels.c'].every((name) => existsSync(join(wb.folder, 'drift', name))));
      await page.locator('.explorer-folders-view .monaco-list-row', { hasText: 'tank.gen' }).waitFor();
      await wb.shot('example-3-opened.png');
    }],
  ];
  return { more };
}
