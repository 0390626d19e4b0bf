// The scale at which a picture opens, and the scale at which it fits.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { fitting, GREATEST, LEGIBLE, opening } from '../../src/webview/geometry';

const view = { width: 700, height: 700 };

test('a picture fits by its longer side', () => {
  assert.equal(fitting({ width: 1400, height: 700 }, view), 0.5);
  assert.equal(fitting({ width: 700, height: 2800 }, view), 0.25);
  assert.equal(fitting({ width: 560, height: 100 }, view), 1.25);
});

test('a small picture is enlarged, up to a limit', () => {
  assert.equal(fitting({ width: 20, height: 20 }, view), GREATEST);
  assert.deepEqual(opening({ width: 20, height: 20 }, view), { scale: GREATEST, whole: true });
});

test('a picture opens whole if its letters are 7 pixels high when it is fitted', () => {
  assert.deepEqual(opening({ width: 1100, height: 200 }, view), { scale: LEGIBLE, whole: true });
  assert.deepEqual(opening({ width: 1101, height: 200 }, view), { scale: 1, whole: false });
  assert.deepEqual(opening({ width: 200, height: 5000 }, view), { scale: 1, whole: false });
});

test('a view or a picture without a size has a scale', () => {
  assert.equal(fitting({ width: 100, height: 100 }, { width: 0, height: 0 }), 1);
  assert.equal(fitting({ width: 100, height: 100 }, { width: -16, height: 300 }), 1);
  assert.equal(fitting({ width: 0, height: 0 }, view), GREATEST);
});
