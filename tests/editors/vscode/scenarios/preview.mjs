// Pictures of a component: the preview beside the text, and between the lines.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { until } from '../harness.mjs';

export const workspace = 'quadcopter';
export const beside = ['maneuver'];
const FILE = 'nhfc.gen';

export function checks(wb) {
  const { page } = wb;
  /** The page of the preview: a frame in a frame. */
  const frame = page.frameLocator('iframe.webview.ready').first().frameLocator('iframe#active-frame');
  const node = (id) => frame.locator(`g.node[data-id="${id}"]`);
  const notice = frame.locator('#notice');
  const cursorLine = () => page.locator('.monaco-editor .line-numbers.active-line-number').first().textContent();
  const lineOf = (text) => readFileSync(join(wb.folder, FILE), 'utf8').split('\n').findIndex((line) => line.includes(text)) + 1;
  const focusText = () => wb.command('View: Focus First Editor Group');
  /** Pictures between the lines. */
  const zones = page.locator('.review-widget img');
  /** The states that are marked in a picture. */
  const marked = async (img) => {
    const svg = Buffer.from((await img.getAttribute('src')).split(',')[1], 'base64').toString();
    return [...svg.matchAll(/class="node[^"]* marked" data-id="(\w+)"/g)].map(([, id]) => id);
  };
  const edges = () => frame.locator('g.edge').evaluateAll((all) => all.map((it) => `${it.dataset.from} ${it.dataset.to}`));

  /** Accepts what the dialog for saving proposes. */
  async function accept(name) {
    const input = page.locator('.quick-input-widget input.input').first();
    await input.waitFor();
    await until('a name is proposed', async () => name.test(await input.inputValue()), () => wb.shot('preview-save.png'));
    await page.keyboard.press('Enter');
    await input.waitFor({ state: 'hidden' });
  }

  const more = [
    ['the preview opens beside the text', async () => {
      await wb.open(FILE);
      await wb.endOf(FILE, 'task main {');
      await wb.command('dotgen: Show State Machine');
      await node('control').waitFor();
      const names = await frame.locator('g.node').evaluateAll((all) => all.map((it) => it.dataset.id));
      for (const state of ['start', 'measure', 'control', 'emergency', 'stop', 'ether']) assert.ok(names.includes(state), `${state} in ${names}`);
      await wb.shot('preview-01-dark.png');
    }],
    ['every node has a name for screen readers and can be reached by keyboard', async () => {
      const nodes = await frame.locator('g.node').evaluateAll((all) => all.map((it) => [it.getAttribute('aria-label'), it.getAttribute('tabindex')]));
      for (const [label, index] of nodes) assert.ok(label && index === '0', `${label} ${index}`);
    }],
    ['it is allowed nothing from elsewhere', async () => {
      const policy = await frame.locator('meta[http-equiv="Content-Security-Policy"]').getAttribute('content');
      assert.match(policy, /^default-src 'none'; img-src data:; style-src 'nonce-[0-9a-f]{32}'; script-src 'nonce-[0-9a-f]{32}'$/);
    }],
    ['a click on a state moves the cursor to its codel', async () => {
      await node('emergency').click();
      await until('the cursor is there', async () => Number(await cursorLine()) === lineOf('codel<emergency>'));
    }],
    ['what is selected is explained', async () => {
      const details = frame.locator('#details');
      await details.waitFor();
      const text = await details.innerText();
      assert.match(text, /hfc_main_emergency/);
      assert.match(text, /out port cmd_velocity/);
      assert.match(text, /30 .s/);
      await wb.shot('preview-02-details.png');
    }],
    ['the state under the cursor is marked', async () => {
      // The click may leave the focus in the picture, where no line can be chosen.
      await focusText();
      await wb.endOf(FILE, 'codel<measure>');
      await until('measure is marked', async () => /current/.test((await node('measure').getAttribute('class')) ?? ''));
    }],
    ['the preview follows the cursor to another machine', async () => {
      await wb.endOf(FILE, 'codel<track>');
      await node('track').waitFor();
      await until('track is marked', async () => /current/.test((await node('track').getAttribute('class')) ?? ''));
    }],
    ['arrow keys walk, and Enter leads to the text', async () => {
      await node('start').focus();
      await page.keyboard.press('ArrowDown');
      await frame.locator('g.node[data-id="track"]:focus').waitFor();
      await page.keyboard.press('ArrowUp');
      await frame.locator('g.node[data-id="start"]:focus').waitFor();
      await page.keyboard.press('Enter');
      await until('the cursor is there', async () => Number(await cursorLine()) === lineOf('codel<start> hfc_servo_start'));
    }],
    ['an edited yield changes the picture', async () => {
      assert.ok(!(await edges()).includes('track ether'));
      await focusText();
      await wb.endOf(FILE, 'codel<track>');
      await page.keyboard.press('ArrowLeft');
      await wb.type(', ether');
      await until('there is another transition', async () => (await edges()).includes('track ether'));
      await wb.shot('preview-03-edited.png');
    }],
    ['a syntax error keeps the last picture, and says so', async () => {
      const before = await frame.locator('#view').innerHTML();
      await wb.type(' (');
      await notice.filter({ hasText: 'last good picture' }).waitFor();
      await node('track').waitFor();
      assert.equal(await frame.locator('g.node').count(), (before.match(/class="node /g) ?? []).length);
      await wb.shot('preview-04-broken.png');
      await page.keyboard.press('Backspace');
      await page.keyboard.press('Backspace');
      await until('the notice goes', () => notice.isHidden());
      await wb.command('File: Revert File');
      await page.locator('.tab.active.dirty').waitFor({ state: 'detached' });
    }],
    ['it finds, zooms and fits', async () => {
      await focusText();
      await wb.endOf(FILE, 'codel<control>');
      await node('control').waitFor();
      const svg = frame.locator('#view svg');
      const width = async () => Number(await svg.getAttribute('width'));
      await frame.locator('#fit').click();
      const fitted = await width();
      await frame.locator('#in').click();
      assert.ok((await width()) > fitted * 1.2);
      await frame.locator('#fit').click();
      assert.ok(Math.abs((await width()) - fitted) < 2);
      await frame.locator('#search').fill('emerg');
      await until('others are faint', async () => (await frame.locator('g.node.missed').count()) > 3);
      assert.ok(!/missed/.test((await node('emergency').getAttribute('class')) ?? ''));
      await wb.shot('preview-05-search.png');
      await frame.locator('#search').fill('');
    }],
    ['it shows longest paths and locks on demand', async () => {
      await frame.locator('#paths').check();
      await frame.locator('text.detail', { hasText: 'Σ' }).first().waitFor();
      await frame.locator('#paths').uncheck();
      await frame.locator('text.detail', { hasText: 'Σ' }).first().waitFor({ state: 'detached' });
    }],
    ['it exports SVG, the bytes of the command line', async () => {
      await frame.locator('#svg').click();
      await accept(/nhfc\.main\.svg$/);
      await until('the file is there', () => readFileSync(join(wb.folder, 'nhfc.main.svg'), 'utf8').startsWith('<svg'));
    }],
    ['it exports PNG', async () => {
      await frame.locator('#png').click();
      await accept(/nhfc\.main\.png$/);
      await until('the file is there', () => readFileSync(join(wb.folder, 'nhfc.main.png')).subarray(1, 4).toString() === 'PNG');
    }],
    ['the system and the locks are one choice away', async () => {
      await frame.locator('#kind').selectOption('system');
      await node('mikrokopter').waitFor();
      assert.equal(await frame.locator('g.node.component').count(), 6);
      assert.ok((await edges()).includes('optitrack.mocap_pose pom'));
      // Letters are at least 9 pixels high, and nothing is scrolled sideways: a wide system is drawn in rows.
      const width = () => frame.locator('#view').evaluate((it) => ({ cut: it.scrollWidth > it.clientWidth + 2, scale: it.querySelector('svg').getBoundingClientRect().width / it.querySelector('svg').viewBox.baseVal.width }));
      await until('the system fits the width', async () => !(await width()).cut, async () => JSON.stringify(await width()));
      assert.ok((await width()).scale * 11 >= 8.9, JSON.stringify(await width()));
      await wb.shot('preview-06-system.png');
      await frame.locator('#kind').selectOption('locks');
      await frame.locator('g.node.data').first().waitFor();
      await wb.shot('preview-07-locks.png');
      await frame.locator('#kind').selectOption('fsm');
      await node('control').waitFor();
    }],
    ['three themes, for screen readers', () => wb.accessible('g.node', 'preview-themes')],
    ['it is as legible in a light theme, and in high contrast', async () => {
      wb.folderSettings({ 'workbench.colorTheme': 'Default Light Modern' });
      const ground = () => frame.locator('body').evaluate((it) => getComputedStyle(it).backgroundColor);
      await until('the page is light', async () => (await ground()) === 'rgb(255, 255, 255)');
      await wb.shot('preview-08-light.png');
      wb.folderSettings({ 'workbench.colorTheme': 'Default High Contrast' });
      await until('the page is black', async () => (await ground()) === 'rgb(0, 0, 0)');
      await wb.shot('preview-09-contrast.png');
      wb.folderSettings({});
      await until('the page is dark again', async () => !['rgb(0, 0, 0)', 'rgb(255, 255, 255)'].includes(await ground()));
    }],
    ['it is there again after a reload of the window', async () => {
      await page.reload();
      await page.locator('.monaco-workbench').waitFor();
      // Which picture: what the workbench had written down last, at times the one of some seconds before.
      await frame.locator('g.node').first().waitFor();
    }],
    ['the hover of a state shows its machine, with the state marked', async () => {
      await focusText();
      await wb.command('View: Close Editors in Other Groups');
      await wb.command('View: Close Primary Side Bar');
      await page.setViewportSize({ width: 1000, height: 700 });
      await wb.open(FILE);
      await wb.endOf(FILE, 'codel<measure>');
      await page.keyboard.press('Home');
      const hover = await wb.hover('yield pause::measure, pause::emergency', 'emergency');
      assert.deepEqual(await marked(hover.locator('img')), ['emergency']);
      const { width, height } = await hover.locator('img').boundingBox();
      assert.ok(width <= 400 && height <= 220, `${width} ${height}`);
      await wb.shot('preview-10-hover.png');
      const task = await wb.hover('task main', 'main');
      assert.deepEqual(await marked(task.locator('img')), []);
      const codel = await wb.hover('codel<stop> hfc_main_stop', 'hfc_main_stop');
      assert.equal(await codel.locator('img').count(), 0);
    }],
    ['a setting removes it', async () => {
      wb.folderSettings({ 'dotgen.diagrams.hover': false });
      await until('the picture is gone', async () => (await (await wb.hover('task main', 'main')).locator('img').count()) === 0);
      wb.folderSettings({});
      await page.mouse.move(5, 5);
    }],
    ['a key toggles the picture between the lines', async () => {
      await wb.endOf(FILE, 'codel<control>');
      await page.keyboard.press('Home');
      await wb.press('Shift+Alt+M', zones.first());
      const body = page.locator('.review-widget .comment-body').first();
      assert.ok(await body.evaluate((it) => it.scrollHeight <= it.clientHeight + 1), 'nothing scrolls inside');
      assert.equal(await page.locator('.part.panel').isVisible(), false, 'the list of comments stays closed');
      await until('control is marked', async () => (await marked(zones.first())).join() === 'control');
      await until('the whole picture is in sight', async () => {
        const { y, height } = await zones.first().boundingBox();
        return y + height < 660;
      });
      assert.ok(await wb.line('codel<control>').isVisible(), 'and so is the cursor');
      await wb.shot('preview-11-inline.png');
    }],
    ['the mark follows the cursor, and the cursor the links', async () => {
      await wb.endOf(FILE, 'codel<measure>');
      await until('measure is marked', async () => (await marked(zones.first())).join() === 'measure');
      await page.locator('.review-widget a', { hasText: 'emergency' }).click();
      await until('the cursor is there', async () => Number(await cursorLine()) === lineOf('codel<emergency>'));
      await until('emergency is marked', async () => (await marked(zones.first())).join() === 'emergency');
    }],
    ['a click on it opens the preview', async () => {
      await zones.first().click();
      await node('emergency').waitFor();
      await focusText();
      await wb.command('View: Close Editors in Other Groups');
    }],
    ['it has the colours of the theme, and is there again after a reload', async () => {
      const dark = await zones.first().getAttribute('src');
      wb.folderSettings({ 'workbench.colorTheme': 'Default Light Modern' });
      await page.locator('.monaco-workbench.vs').waitFor();
      await until('it is light', async () => (await zones.first().getAttribute('src')) !== dark);
      await wb.shot('preview-12-inline-light.png');
      wb.folderSettings({});
      await page.locator('.monaco-workbench.vs-dark').waitFor();
      await page.reload();
      await zones.first().waitFor();
      await until('it is marked', async () => (await marked(zones.first())).length === 1);
    }],
    ['a second one follows the text, and a lens toggles it where the settings say', async () => {
      wb.folderSettings({ 'dotgen.diagrams.open': 'inline' });
      await wb.endOf(FILE, 'codel<track>');
      await wb.press('Shift+Alt+M', page.locator('.review-widget img[alt*="servo"]'));
      const zone = page.locator('.review-widget img[alt*="servo"]');
      const first = await zone.getAttribute('src');
      await page.keyboard.press('ArrowLeft');
      await wb.type(', ether');
      await until('it follows the text', async () => (await zone.getAttribute('src')) !== first);
      await wb.shot('preview-13-inline-two.png');
      await wb.command('dotgen: Toggle State Machine Between the Lines');
      await zone.waitFor({ state: 'detached' });
      await wb.command('File: Revert File');
      await wb.endOf(FILE, 'task main {');
      const lens = page.locator('.codelens-decoration a', { hasText: 'state machine' }).first();
      await wb.click(lens, zones, 'detached');
    }],
  ];
  return { more };
}
