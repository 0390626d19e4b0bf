// Codels in a debugger: from the codel in the specification to its function, stopped at a breakpoint.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { mkdtempSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';

const SOURCE = `#include "acpump.h"
#include "pump_c_types.h"
genom_event report_start(double level, const genom_context self) {
  double known = level + 2;
  return known > 0 ? pump_pause_start : NULL;
}
`;

// As somebody would name a debugger: a program.
const program = join(mkdtempSync(join(tmpdir(), 'dotgen-debugger-')), 'adapter');
writeFileSync(program, `#!/bin/sh\nexec '${process.execPath}' '${fileURLToPath(new URL('../gdb-adapter.mjs', import.meta.url))}'\n`, { mode: 0o755 });

export const workspace = 'pump';
export const files = { 'codels/report.c': SOURCE };
export const settings = { 'debug.toolBarLocation': 'docked' };

export function checks(wb) {
  const { page } = wb;
  if (spawnSync('gdb', ['--version']).status !== 0) {
    return { skipped: 'there is no gdb' };
  }
  const here = page.locator('.debug-top-stack-frame-line').first();

  const more = [
    ['a component is debugged at the codel where the cursor is', async () => {
      // Programs are settings of the machine, which the folder may set.
      wb.folderSettings({ 'dotgen.run.debugger': program });
      await wb.open('pump.gen');
      await wb.statusItem.locator('.codicon-check').waitFor();
      await wb.endOf('pump.gen', 'codel<start> report_start');
      await page.keyboard.press('Home');
      // Over `codel<start> ` into the name.
      for (let i = 0; i < 15; i++) await page.keyboard.press('ArrowRight');
      await wb.command('dotgen: Debug');
      await here.waitFor();
      const frame = page.locator('.debug-call-stack .stack-frame', { hasText: 'report_start' }).first();
      await frame.waitFor();
      const value = page.locator('.debug-variables .monaco-list-row', { hasText: 'level' }).first();
      await page.locator('.debug-variables .monaco-list-row', { hasText: 'Locals' }).click();
      await value.waitFor();
      await wb.shot('100-debug.png');
      assert.equal(await page.locator('.tab.active[data-resource-name="report.c"]').count(), 1);
    }],
    ['the run ends with the debugger', async () => {
      await page.keyboard.press('Shift+F5');
      await here.waitFor({ state: 'detached' });
      const run = page.frameLocator('iframe.webview.ready:visible').first().frameLocator('iframe#active-frame');
      await run.locator('#again').waitFor();
      await wb.shot('101-debug-ended.png');
    }],
  ];
  return { more };
}
