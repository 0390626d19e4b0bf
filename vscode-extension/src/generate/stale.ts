// The comparison of a file with the text that a preview was made from.

/** Whether a file has changed since its preview. `undefined` and `null`: the file does not exist. */
export function isStale(now: string | undefined, before: string | null): boolean {
  return now === undefined || before === null ? now !== undefined || before !== null : plain(now) !== plain(before);
}

/** The editor has no byte order mark in its text, and one kind of line end. */
function plain(text: string): string {
  return text.replace(/^\uFEFF/, '').replace(/\r\n?/g, '\n');
}
