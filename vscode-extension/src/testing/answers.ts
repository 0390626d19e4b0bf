// The answers of `dotgen verify --format json` (docs/verify.schema.json) as results of tests. A test passes
// only if every answer to its check is `proved`.
import type { WrittenCheck } from './written';

export interface Answer {
  name?: string;
  check: string;
  of: string;
  verdict: string;
  soundness: string;
  value?: number | 'unbounded';
  limit?: number | 'unbounded';
  note?: string;
  conditional?: { missing: string; codel?: string; interface?: string }[];
  'gave-up'?: { reason: string; states: number };
  counterexample: { time: number; what: string }[];
  why?: { words?: { cause: string; remedy?: string } };
}

export interface Report {
  unit: string;
  checks: Answer[];
}

export interface Result {
  outcome: 'passed' | 'failed' | 'errored';
  /** The reason of each answer that is not `proved`. */
  messages: string[];
  /** All answers, a line each. */
  lines: string[];
}

/** Returns what the program printed; undefined if it is no report. */
export function reportOf(text: string): Report | undefined {
  try {
    const report = JSON.parse(text) as Partial<Report> | null;
    return typeof report?.unit === 'string' && Array.isArray(report.checks) ? (report as Report) : undefined;
  } catch {
    return undefined;
  }
}

/** Returns the result of each written check, in order. */
export function resultsOf(report: Report, written: readonly WrittenCheck[]): Result[] {
  return answersOf(report.checks, written).map((answers) => resultOf(answers, report.unit));
}

/**
 * Returns the answers to each written check. Answers are in the order of the checks. A check of all tasks
 * has an answer for each task. If answers and checks without names do not pair up, the text has changed:
 * these checks have no answers.
 */
function answersOf(answers: readonly Answer[], written: readonly WrittenCheck[]): Answer[][] {
  const rest = answers.filter(({ name }) => name === undefined);
  const whole = written.map(({ name, kind, text }) => {
    if (name !== undefined) return answers.filter((answer) => answer.name === name && answer.check === kind);
    const found: Answer[] = [];
    const isOfAll = /^check [\w-]+ ?(\*|$|<=)/.test(text);
    while (rest[0]?.check === kind && (found.length === 0 || (isOfAll && !found.some(({ of }) => of === rest[0]?.of)))) {
      found.push(...rest.splice(0, 1));
    }
    return found;
  });
  const pairsUp = rest.length === 0;
  return whole.map((found, i) => (pairsUp || written[i]?.name !== undefined ? found : []));
}

function resultOf(answers: Answer[], unit: string): Result {
  if (answers.length === 0) {
    return { outcome: 'errored', messages: ['Not verified: the answers of dotgen lack this check. Save the scenario and run the test again.'], lines: [] };
  }
  const outcomes = answers.map(outcomeOf);
  const open = answers.filter((_, i) => outcomes[i] !== 'passed');
  return {
    outcome: outcomes.includes('failed') ? 'failed' : outcomes.includes('errored') ? 'errored' : 'passed',
    messages: open.map((answer) => message(answer, unit)),
    lines: answers.map((answer) => line(answer, unit)),
  };
}

/** Words that are not known here are of a later dotgen: no reason for a green sign. */
function outcomeOf({ verdict }: Answer): Result['outcome'] {
  if (verdict === 'proved') return 'passed';
  return verdict === 'refuted' || verdict === 'exceeds' ? 'failed' : 'errored';
}

const WORDS: Record<string, string> = { unknown: 'gave up', nothing: 'nothing to verify' };
/** Restrictions of a proof, by soundness. */
const ONLY: Record<string, string> = {
  under: ' (for worst-case execution times only)',
  neither: ' (indicative)',
  wholeunits: ' (for codels that end at whole units of time only)',
};

function line(answer: Answer, unit: string): string {
  const { verdict, soundness, check, of, name, value } = answer;
  const what = [name === undefined ? check : `${name}: ${check}`, of].filter((word) => word !== '').join(' ');
  const shown = value === undefined ? '' : `, ${timeText(value, unit)}`;
  return `${WORDS[verdict] ?? verdict}  ${what}${shown}${verdict === 'proved' ? (ONLY[soundness] ?? '') : ''}`;
}

/** The verdict, its reason, and the end of the run. */
function message(answer: Answer, unit: string): string {
  const { why, counterexample, conditional = [], note, value, limit } = answer;
  const lines = [line(answer, unit)];
  if (limit !== undefined && value !== undefined) lines.push(`limit: ${timeText(limit, unit)}`);
  if (why?.words !== undefined) lines.push(`cause: ${why.words.cause}`);
  if (why?.words?.remedy !== undefined) lines.push(`help: ${why.words.remedy}`);
  const missing = conditional.map((it) => (it.missing === 'interface' ? `interface ${it.interface}` : `execution time of ${it.codel}`));
  if (missing.length > 0) lines.push(`missing: ${some(missing)}`);
  if (answer['gave-up'] !== undefined) lines.push(`limit reached: ${answer['gave-up'].reason}, after ${answer['gave-up'].states} states`);
  if (note !== undefined) lines.push(note);
  if (answer.verdict === 'refuted' && counterexample.length > 0) lines.push(...runText(counterexample, unit));
  return lines.join('\n');
}

const NAMED = 3;
const LAST = 8;

const some = (all: string[]): string => all.slice(0, NAMED).join(', ') + (all.length > NAMED ? ` and ${all.length - NAMED} more` : '');

function runText(events: Answer['counterexample'], unit: string): string[] {
  const last = events.slice(-LAST);
  const before = events.length - last.length;
  const title = before === 0 ? 'run:' : `run, after ${before} other steps:`;
  return [title, ...last.map(({ time, what }) => `  ${timeText(time, unit)}  ${what}`)];
}

const NANOSECONDS: Record<string, number> = { ns: 1, us: 1e3, ms: 1e6, s: 1e9 };
const DIGITS = 4;

/** Returns a number of units (`ms`, `500 us`) as a time. */
export function timeText(value: number | 'unbounded', unit: string): string {
  const [, count = '1', name = ''] = /^(\d*)\s*(ns|us|ms|s)$/.exec(unit) ?? [];
  const scale = NANOSECONDS[name];
  if (value === 'unbounded' || scale === undefined) return value === 'unbounded' ? value : `${value} × ${unit}`;
  const time = value * Number(count || 1) * scale;
  const [shown, size]: [string, number] = time >= 1e9 ? ['s', 1e9] : time >= 1e6 || time === 0 ? ['ms', 1e6] : time >= 1e3 ? ['µs', 1e3] : ['ns', 1];
  return `${Number((time / size).toPrecision(DIGITS + 3))} ${shown}`;
}
