// A scenario is simulated and run where it is written: from the run back into the specification, and to the proof.
import assert from 'node:assert/strict';
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';

export const workspace = 'pump';
export const settings = { 'dotgen.run.margin': 1.1 };

/** A codel that takes longer than it states. */
const SLOW = `#include "acpump.h"
#include <unistd.h>
#include "pump_c_types.h"
genom_event report_start(double level, const genom_context self) { usleep(9000); return pump_pause_start; }
`;

export function checks(wb) {
  const { page } = wb;
  const frame = page.frameLocator('iframe.webview.ready:visible').first().frameLocator('iframe#active-frame');
  const state = (word) => frame.locator('#state', { hasText: word });

  /** Writes another time for the codel of `report`. */
  const time = async (text) => {
    await wb.endOf('pump.gen', 'yield pause::start wcet');
    const [, old] = readFileSync(join(wb.folder, 'pump.gen'), 'utf8').match(/yield pause::start wcet (.*)/);
    for (let i = 0; i < old.length; i++) await page.keyboard.press('Backspace');
    await wb.type(`${text};`);
    await wb.save();
  };

  const more = [
    ['a scenario is simulated: tasks are beside their bounds', async () => {
      await wb.open('pump.scn');
      await wb.statusItem.locator('.codicon-check').waitFor();
      await wb.command('dotgen: Simulate');
      await state('simulated').waitFor();
      const tasks = frame.locator('#tasks tbody tr');
      assert.deepEqual((await tasks.locator('td:first-child').allInnerTexts()), ['pump.control', 'pump.report']);
      const [greatest, bound] = (await tasks.first().locator('td.number').allInnerTexts()).slice(2, 4).map(Number);
      assert.ok(greatest <= bound, `${greatest} ${bound}`);
      await wb.shot('90-simulation.png');
    }],
    ['three themes, for eyes and for screen readers', () => wb.accessible('#tasks', '90-simulation')],
    ['its first run is stepped through', async () => {
      await frame.locator('#trace').click();
      await page.locator('.part.panel', { hasText: 'Trace' }).waitFor();
      await wb.shot('91-simulation-trace.png');
      await wb.command('View: Hide Panel');
    }],
    ['what was simulated is not offered as measured', async () => {
      // Beside the panel, not over it.
      await wb.command('View: Focus First Editor Group');
      await wb.open('pump.gen');
      await page.locator('.contentWidgets .codelens-decoration a').first().waitFor();
      assert.equal(await page.locator('.view-line', { hasText: 'took ' }).count(), 0);
      assert.equal(await page.locator('.contentWidgets .codelens-decoration a', { hasText: 'measured time' }).count(), 0);
      await wb.shot('96-simulated.png');
    }],
    ['a time is broken, and the run violates what was proved', async () => {
      await wb.open('pump.gen');
      await time('19 ms');
      await frame.locator('#again').click();
      await state('violated').waitFor();
      await frame.locator('#violations li', { hasText: 'schedulable pump.control is violated' }).first().waitFor();
      await wb.shot('94-violated.png');
    }],
    ['on the real clock, a service is asked by its form, and the run is stopped', async () => {
      await wb.command('View: Focus First Editor Group');
      await wb.open('pump.scn');
      await wb.command('dotgen: Run');
      const form = frame.getByRole('form', { name: 'pump.fill' });
      await form.waitFor();
      // What has no sources is simulated: that is said from the start.
      assert.equal(await frame.locator('#title').innerText(), 'Simulated run of pump.scn');
      assert.match(await frame.locator('#facts').innerText(), /^without sources: pump/);
      // The form is made from its type: with its default, its unit and its doc text.
      const height = form.getByLabel('height');
      assert.equal(await height.inputValue(), '1');
      assert.equal(await form.locator('.field').innerText(), 'height\nm\nLevel to reach');
      await height.fill('2');
      await form.getByRole('button', { name: 'Send pump.fill' }).click();
      await form.locator('.answer', { hasText: 'done' }).waitFor();
      // While it goes on, tasks are beside their bounds.
      const control = frame.locator('#tasks tbody tr', { hasText: 'pump.control' });
      await control.locator('td.number', { hasText: '%' }).waitFor();
      await wb.shot('92-run.png');
    }],
    ['the picture of a machine shows the state that the run is in, and counts', async () => {
      await wb.command('View: Focus First Editor Group');
      await wb.open('pump.gen');
      await wb.endOf('pump.gen', 'control_main');
      await wb.command('dotgen: Show State Machine');
      await frame.locator('.node.here').first().waitFor();
      await frame.locator('.taken').first().waitFor();
      await wb.shot('95-run-machine.png');
      await page.getByRole('tab', { name: /^Run, Editor Group/ }).click();
      await frame.locator('#stop').click();
      await frame.locator('#facts', { hasText: 'stopped' }).waitFor();
      await wb.shot('93-stopped.png');
    }],
    ['a simulated run offers the stubs of its component', async () => {
      await frame.locator('#stubs').click();
      await page.locator('.action-widget', { hasText: 'missing stubs of component `pump`' }).waitFor();
      await wb.shot('97-stubs.png');
      await page.keyboard.press('Escape');
    }],
    ['a codel that takes longer than it states: the run names the assumption that it breaks', async () => {
      await wb.command('View: Focus First Editor Group');
      await wb.open('pump.gen');
      await time('4400 us');
      mkdirSync(join(wb.folder, 'codels'));
      writeFileSync(join(wb.folder, 'codels/report.c'), SLOW);
      await wb.command('dotgen: Run');
      // The run before may have violated something as well.
      await state('running').waitFor();
      // It is told while the run goes on.
      await frame.locator('#state.violated').waitFor();
      await frame.locator('#stop').click();
      const broken = frame.locator('#violations li', { hasText: 'its wcet is 4.4 ms: what is proved assumes that' });
      await broken.filter({ hasText: 'pump.report.start took' }).waitFor();
      await wb.shot('98-overrun.png');
    }],
  ];
  return { more };
}
