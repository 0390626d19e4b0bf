// The page of verifications in Chromium: what screen readers are told, and what the keyboard reaches.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { opener, THEMES, violations } from './page.mjs';

let pages;
before(async () => (pages = await opener('src/verification/page.ts', 'src/webview/verification.ts')));
after(() => pages.close());

const place = { uri: 'file:///a.gen', range: { start: { line: 1, character: 2 }, end: { line: 1, character: 9 } } };
const check = (more) => ({ name: null, check: 'response', of: 'nav.exec', verdict: 'proved', worth: null, value: '8 ms', limit: '10 ms', slack: '20 %', note: null, condition: null, cause: null, remedy: null, reason: [], hasRun: false, location: place, ...more });
const answer = {
  uri: 'file:///a.gen', version: 1, status: 'refuted', earlier: false, howFar: null, scenario: 'nav', written: false, platform: 'free', cores: null, policy: 'fifo', durations: 'interval',
  errors: [], warnings: [{ message: '2 codels have no `wcet`', location: place }], advice: 'write a scenario', bounds: [{ task: 'nav.exec', bound: '9 ms' }], minimumCores: 2, repairs: ['holds with 3 cores', 'holds up to 4 ms'], assumptions: ['any client'], notes: ['a note'],
  checks: [check({}), check({ of: 'nav.plan', verdict: 'refuted', value: '12 ms', cause: 'waits for level', remedy: 'holds up to 4 ms', reason: ['waits 6 ms'], hasRun: true }), check({ check: 'deadlock', verdict: 'gave up', value: null, limit: null, note: 'gave up after 10 s' })],
  blocking: [{ codel: 'nav.a', location: place, by: [{ codel: 'nav.b', location: place, time: '2 ms', through: 'ids.level' }] }],
  codels: [{ path: 'nav.exec.a', wcet: 2000, location: place }, { path: 'nav.exec.b', wcet: null, location: null }],
  run: { check: 1, title: 'response nav.plan: a run that refutes it', shows: 'a run that refutes it', events: [{ text: '0 ms: exec begins', location: place }, { text: '4 ms: plan waits', location: null }] }, states: 120, seconds: 0.4, whatIf: null,
};

for (const theme of Object.keys(THEMES)) {
  test(`names and roles for screen readers: ${theme}`, async () => {
    const it = await pages.open({ theme, width: 700, height: 900 });
    assert.deepEqual(await violations(it.page), [], 'empty');
    await it.send({ type: 'answer', subject: { uri: 'file:///a.gen' }, answer, pinned: true });
    await it.send({ type: 'limits', limits: { state: 'running', text: 'looking', percentage: 40 } });
    for (const closed of await it.page.locator('details').all()) await closed.evaluate((details) => (details.open = true));
    assert.deepEqual(await violations(it.page), [], 'with an answer');
    await it.page.close();
  });
}

test('the keyboard alone reaches everything that can be pressed', async () => {
  const it = await pages.open({ width: 700, height: 900 });
  await it.send({ type: 'answer', subject: { uri: 'file:///a.gen' }, answer, pinned: false });
  for (const closed of await it.page.locator('details').all()) await closed.evaluate((details) => (details.open = true));
  const pressed = ':is(button, select, input, summary, a[href]):visible';
  const count = await it.page.locator(pressed).evaluateAll((all) => all.map((one, number) => one.setAttribute('data-test', number)).length);
  assert.ok(count > 10, String(count));
  await it.page.evaluate(() => { document.body.tabIndex = -1; document.body.focus(); });
  const seen = new Set();
  for (let i = 0; i < count + 20; i++) {
    await it.page.keyboard.press('Tab');
    seen.add(await it.page.evaluate(() => document.activeElement?.getAttribute('data-test')));
  }
  const missed = [];
  for (let i = 0; i < count; i++) if (!seen.has(String(i))) missed.push(await it.page.locator(`[data-test="${i}"]`).evaluate((one) => one.outerHTML.slice(0, 120)));
  assert.deepEqual(missed, []);
  await it.page.close();
});

test('beside half a window nothing is cut, and remedies are reached', async () => {
  for (const width of [380, 700]) {
    const it = await pages.open({ width, height: 900 });
    const long = check({ name: 'begins', check: 'within', of: 'operator_of_the_tank.request => pump.fill.wait_for_the_level', verdict: 'refuted', cause: '`control` waits', remedy: 'holds up to 4 ms', slack: '-11 %' });
    await it.send({ type: 'answer', subject: { uri: 'file:///a.gen' }, answer: { ...answer, checks: [...answer.checks, long] }, pinned: false });
    for (const closed of await it.page.locator('details').all()) await closed.evaluate((details) => (details.open = true));
    const cut = await it.page.evaluate(() => [...document.querySelectorAll('body *')].filter((one) => one.getBoundingClientRect().right > innerWidth).map((one) => one.outerHTML.slice(0, 90)));
    assert.deepEqual(cut, [], String(width));
    await it.page.locator('#checks tr', { hasText: 'Repair' }).first().locator('a', { hasText: 'Repair' }).click();
    assert.deepEqual((await it.said()).at(-1), { type: 'repair', uri: 'file:///a.gen', line: 1, character: 2 });
    await it.page.close();
  }
});

test('title, cause and expression are said once; what repairs everything is listed', async () => {
  const it = await pages.open({ width: 700, height: 900 });
  await it.send({ type: 'answer', subject: { uri: 'file:///a.gen' }, answer, pinned: false });
  assert.equal(await it.page.locator('#runTitle').innerText(), 'A run that refutes it');
  const text = await it.page.evaluate(() => document.body.innerText);
  for (const once of ['response nav.plan', 'waits for level', 'a run that refutes it']) assert.equal(text.toLowerCase().split(once).length - 1, 1, once);
  assert.deepEqual(await it.page.locator('#repairs li').allInnerTexts(), ['holds with 3 cores Repair…'].map((line) => line.replace(' Repair', 'Repair')));
  await it.page.close();
});

test('the events of a run lead to their codels, and the run is opened step by step', async () => {
  const it = await pages.open({ width: 700, height: 900 });
  await it.send({ type: 'answer', subject: { uri: 'file:///a.gen' }, answer, pinned: false });
  await it.page.locator('#run summary').click();
  assert.equal(await it.page.locator('#events a').count(), 1, 'the event without a place is text');
  await it.page.locator('#events a', { hasText: 'exec begins' }).click();
  assert.deepEqual((await it.said()).at(-1), { type: 'place', uri: 'file:///a.gen', line: 1, character: 2, endLine: 1, endCharacter: 9 });
  await it.page.locator('#trace').click();
  assert.deepEqual((await it.said()).at(-1), { type: 'trace' });
  await it.page.close();
});
