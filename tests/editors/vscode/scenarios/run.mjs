// A scenario is simulated and run where it is written.
import assert from 'node:assert/strict';

export const workspace = 'pump';
export const settings = { 'workbench.colorTheme': 'Default Dark Modern' };

export function checks(wb) {
  const { page } = wb;
  const frame = page.frameLocator('iframe.webview.ready:visible').first().frameLocator('iframe#active-frame');
  const state = (word) => frame.locator('#state', { hasText: word });

  const more = [
    ['a scenario is simulated: tasks are beside their bounds', async () => {
      await wb.open('pump.scn');
      await wb.statusItem.locator('.codicon-check').waitFor();
      await wb.command('dotgen: Simulate');
      await state('kept').waitFor();
      const tasks = frame.locator('#tasks tbody tr');
      assert.deepEqual((await tasks.locator('td:first-child').allInnerTexts()), ['pump.control', 'pump.report']);
      const [greatest, bound] = (await tasks.first().locator('td.number').allInnerTexts()).slice(2, 4).map(Number);
      assert.ok(greatest <= bound, `${greatest} ${bound}`);
      await wb.shot('90-simulation.png');
    }],
    ['its first run is stepped through', async () => {
      await frame.locator('#trace').click();
      await page.locator('.part.panel', { hasText: 'Trace' }).waitFor();
      await wb.shot('91-simulation-trace.png');
      await wb.command('View: Hide Panel');
    }],
    ['a time is broken, and the run violates what was proved', async () => {
      // Beside the panel, not over it.
      await wb.command('View: Focus First Editor Group');
      await wb.open('pump.gen');
      await wb.endOf('pump.gen', 'yield pause::start wcet');
      for (let i = 0; i < '4 ms;'.length; i++) await page.keyboard.press('Backspace');
      await wb.type('9 ms;');
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
      await page.getByRole('tab', { name: 'Run', exact: false }).click();
      await frame.locator('#stop').click();
      await frame.locator('#facts', { hasText: 'stopped' }).waitFor();
      await wb.shot('93-stopped.png');
    }],
  ];
  return { more };
}
