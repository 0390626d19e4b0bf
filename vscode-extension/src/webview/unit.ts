// Units of time as people write them. Data have `us`.

export function shownUnit(unit: string): string {
  return unit === 'us' ? 'µs' : unit;
}
