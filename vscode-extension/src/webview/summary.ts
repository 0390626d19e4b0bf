// The line of each component on the page of a run, and the filter: pure, for the page and for tests.
import type { OfTask, Port, Report, RunView, Series, Service, Violation } from '../run/messages';

/** Loads of a plot. */
const KEPT = 60;

export interface ComponentLine {
  name: string;
  /** The sum over its tasks; undefined if none of them has a load. */
  load: number | undefined;
  missed: number;
  violations: number;
}

/** The component of a task, service or port: `pump` of `pump.fill` and of `pump/level`. */
export function componentOf(name: string): string {
  return name.split(/[./]/, 1)[0] ?? name;
}

/** Returns groups by component, in the order of their first members. */
export function byComponent<T extends { name: string }>(all: readonly T[]): Map<string, T[]> {
  const groups = new Map<string, T[]>();
  for (const it of all) {
    const name = componentOf(it.name);
    const group = groups.get(name);
    if (group === undefined) groups.set(name, [it]);
    else group.push(it);
  }
  return groups;
}

/** The check that is violated, in words. */
export function checked({ check }: Violation, { checks }: Report): string {
  const found = checks[check ?? -1];
  return found === undefined ? 'a check' : `${found.check} ${found.of}`;
}

/** Returns the line of each component, in the order of the tasks, and then of the services and ports. */
export function componentLines({ report, progress, violations, services, ports, simulated }: RunView): ComponentLine[] {
  const tasks = (report ?? progress)?.tasks ?? [];
  const subjects = report === null
    ? violations.filter((it) => it !== undefined).map((it) => [it.what, it.violation] as const)
    : report.violations.map((it) => [it.kind === 'check' ? checked(it, report) : '', it] as const);
  const names = new Set([...tasks.map((it) => it.task), ...services.map((it) => it.name), ...ports.map((it) => it.name), ...simulated].map(componentOf));
  return [...names].map((name) => {
    const own = tasks.filter((it) => componentOf(it.task) === name);
    const its = subjects.filter(([what, it]) => [what, it.task, it.codel, it.component].some((text) => text !== undefined && isNamed(text, name)));
    return {
      name,
      load: loadOf(own),
      missed: own.reduce((sum, it) => sum + it.missed, 0),
      violations: its.reduce((sum, [, it]) => sum + (it.times ?? 1), 0),
    };
  });
}

/** True if a text names a component: `response pump.control` names `pump`. */
function isNamed(text: string, component: string): boolean {
  return text.split(/[^\w./]+/).some((word) => componentOf(word) === component);
}

function loadOf(tasks: readonly OfTask[]): number | undefined {
  const loads = tasks.flatMap(({ load }) => (load === undefined ? [] : [load]));
  return loads.length === 0 ? undefined : loads.reduce((sum, it) => sum + it, 0);
}

/** The last loads of each component: a report of progress has the load since the start of the run. */
export class Loads {
  private readonly last = new Map<string, number[]>();
  private before: { time: number; busy: Map<string, number> } | undefined;

  /** Adds the loads of a report of progress. The same time adds nothing; an earlier time is another run. */
  add(time: number, lines: readonly ComponentLine[]): void {
    if (this.before !== undefined && time < this.before.time) {
      this.last.clear();
      this.before = undefined;
    }
    const { before } = this;
    const passed = time - (before?.time ?? 0);
    if (passed <= 0) return;
    const busy = new Map<string, number>();
    for (const { name, load } of lines) {
      if (load === undefined) continue;
      busy.set(name, load * time);
      const recent = Math.max(0, (load * time - (before?.busy.get(name) ?? 0)) / passed);
      this.last.set(name, [...(this.last.get(name) ?? []), recent].slice(-KEPT));
    }
    this.before = { time, busy };
  }

  of(component: string): number[] {
    return this.last.get(component) ?? [];
  }
}

/** True if every word of a filter is in a service or port: in its name, its text, or the name of an input. */
export function matches(filter: string, it: Pick<Service, 'name' | 'doc'> & Partial<Pick<Service, 'inputs'>>): boolean {
  const text = [it.name, it.doc ?? '', ...(it.inputs ?? []).map((input) => input.name)].join(' ').toLowerCase();
  return filter.trim().toLowerCase().split(/\s+/).every((word) => text.includes(word));
}

/** The series of a port, with those of time stamps last. */
export function ordered({ series }: Port): Series[] {
  const isStamp = ({ name }: Series) => /(^|\.)n?sec$/.test(name);
  return [...series.filter((it) => !isStamp(it)), ...series.filter(isStamp)];
}

/** The points of a plot in a box, for an SVG polyline. Equal values are a line in the middle. */
export function points(values: readonly number[], width: number, height: number): string {
  const [least, greatest] = [Math.min(...values), Math.max(...values)];
  const range = greatest - least;
  const y = (value: number) => (range > 0 ? height - ((value - least) / range) * height : height / 2);
  const step = width / Math.max(1, values.length - 1);
  return values.map((value, i) => `${rounded(i * step)},${rounded(y(value))}`).join(' ');
}

const rounded = (it: number): number => Math.round(it * 10) / 10;
