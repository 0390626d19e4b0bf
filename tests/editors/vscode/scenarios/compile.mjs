// Errors of compilers are problems with places, from a run and from a build.
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';

export const workspace = 'pump';
export const files = {
  'lamp/lamp.gen': `component lamp {
  version "1.0";
  lang "c";
  ids { long light; };
  task blink { period 10 ms; codel<start> lamp_toggle(ids inout light) yield pause::start wcet 9 ms; };
};
`,
  'lamp/codels/lamp_codels.c': `#include "lamp_c_types.h"

genom_event
lamp_toggle(int32_t *light, const genom_context self)
{
  *light = nowhere;
  return lamp_pause_start;
}
`,
};

export function checks(wb) {
  const { page } = wb;
  const problems = page.locator('.markers-panel .monaco-list-row', { hasText: 'nowhere' });
  const frame = page.frameLocator('iframe.webview.ready:visible').first().frameLocator('iframe#active-frame');
  const source = join(wb.folder, 'lamp/codels/lamp_codels.c');
  const replace = (before, after) => writeFileSync(source, readFileSync(source, 'utf8').replace(before, after));

  async function build() {
    await wb.command('Tasks: Run Build Task');
    const row = page.locator('.quick-input-list .monaco-list-row', { hasText: 'codels build' }).first();
    await row.waitFor();
    await row.click();
    // Its terminal comes to the front when it begins.
    await page.locator('.part.panel .action-item', { hasText: 'Problems' }).locator('.badge-content', { hasText: '1' }).waitFor();
  }

  const more = [
    ['a run that does not compile has its errors in Problems', async () => {
      await wb.open('lamp.gen');
      await wb.statusItem.locator('.codicon-check').waitFor();
      await wb.command('dotgen: Run');
      await wb.command('Problems: Focus on Problems View');
      await problems.first().waitFor();
      await wb.shot('compile-1-run.png');
      await problems.first().dblclick();
      await page.locator('.tab.active[data-resource-name="lamp_codels.c"]').waitFor();
      await wb.squiggles().first().waitFor();
    }],
    ['the next run that compiles removes them', async () => {
      replace('nowhere', '1');
      await wb.open('lamp.gen');
      await wb.command('dotgen: Run');
      await frame.locator('#tasks tbody tr').first().waitFor();
      await wb.command('Problems: Focus on Problems View');
      await problems.first().waitFor({ state: 'detached' });
      await wb.command('dotgen: Stop Run');
    }],
    ['a build reports them too, and a run that compiles removes them', async () => {
      replace('= 1', '= nowhere');
      await build();
      await wb.command('Problems: Focus on Problems View');
      await problems.first().waitFor();
      await wb.shot('compile-2-build.png');
      replace('nowhere', '1');
      await wb.open('lamp.gen');
      await wb.command('dotgen: Run');
      await wb.command('Problems: Focus on Problems View');
      await problems.first().waitFor({ state: 'detached' });
      await wb.command('dotgen: Stop Run');
    }],
  ];
  return { more };
}
