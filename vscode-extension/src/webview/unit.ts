// Units of time as people write them. Data have `us` and `10 us`.

/** The unit after a number of such units: `µs`, `× 10 µs`. */
export function shownUnit(unit: string): string {
  const shown = unit.replace(/\bus$/, 'µs');
  return /^\d/.test(shown) ? `× ${shown}` : shown;
}

/** A time in the unit of the trace, with as many digits as are told apart. */
export function time(at: number, unit: string, apart = 1e-3): string {
  const digits = Math.min(6, Math.max(0, -Math.floor(Math.log10(apart) + 1e-9)));
  const text = at.toFixed(digits);
  return `${digits > 0 ? text.replace(/\.?0+$/, '') : text} ${shownUnit(unit)}`;
}
