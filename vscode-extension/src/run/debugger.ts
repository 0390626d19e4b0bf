// Debuggers, and how one attaches to a component.
import type { Host } from './process';

/** Of debug configurations. */
export const DEBUG_TYPE = 'dotgen';

/** What attaches to a process: a debugger of another extension, or one that speaks the Debug Adapter Protocol itself. */
export type Debugger = { kind: 'lldb' } | { kind: 'cppdbg' } | { kind: 'adapter'; command: string; arguments: string[] };

/** A debug configuration. */
interface Attaching {
  name: string;
  type: string;
  request: string;
  [detail: string]: unknown;
}

/** The configuration by which a debugger attaches to a component. */
export function attaching(it: Debugger, { component, process }: Host, program: string): Attaching {
  const common = { name: component, request: 'attach', program };
  switch (it.kind) {
    case 'lldb':
      return { ...common, type: 'lldb', pid: process };
    case 'cppdbg':
      return { ...common, type: 'cppdbg', processId: String(process), MIMode: 'gdb' };
    case 'adapter':
      return { ...common, type: DEBUG_TYPE, pid: process, adapter: [it.command, ...it.arguments] };
  }
}

/** How a debugger is started that speaks the protocol: gdb is asked for it, others know nothing else. */
export function adapter(command: string): Debugger {
  const isGdb = /(^|[\\/])gdb[^\\/]*$/.test(command);
  return { kind: 'adapter', command, arguments: isGdb ? ['-q', '-i=dap'] : [] };
}
