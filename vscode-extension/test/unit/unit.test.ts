// Units of time as people write them.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { shownUnit, time } from '../../src/webview/unit';

test('microseconds are written as people write them', () => {
  assert.deepEqual(['ms', 'us', '10 us', '10 ms'].map(shownUnit), ['ms', 'µs', '× 10 µs', '× 10 ms']);
  assert.equal(time(1.5, 'us'), '1.5 µs');
});
