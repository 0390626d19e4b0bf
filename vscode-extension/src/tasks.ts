// Tasks of type `dotgen`: the subcommands of the server's program, with errors in the Problems view.
import * as vscode from 'vscode';
import type { Server } from './client';
import { explicitSettings, serverSettings } from './config';
import { readingOf } from './run/process';
import { argumentsOfTask, OFFERED, type TaskDefinition } from './taskArguments';

const TYPE = 'dotgen';

// Problem matchers come in pairs, for relative and for absolute paths. One with `autoDetect` looks for each
// file, and VS Code drops what is still looked for 100 ms after the end of a task.

export class Tasks implements vscode.TaskProvider {
  constructor(private readonly server: Server) {}

  async provideTasks(): Promise<vscode.Task[]> {
    const tasks: (vscode.Task | undefined)[] = [];
    for (const folder of vscode.workspace.workspaceFolders ?? []) {
      const found = await vscode.workspace.findFiles(new vscode.RelativePattern(folder, '**/*.{gen,scn}'), undefined, 1);
      if (found.length > 0) tasks.push(...OFFERED.map((command) => this.task({ type: TYPE, command }, folder)));
    }
    return tasks.filter((task) => task !== undefined);
  }

  /** Adds the program to a task of tasks.json. */
  resolveTask({ definition, scope }: vscode.Task): vscode.Task | undefined {
    const folder = typeof scope === 'object' ? scope : vscode.workspace.workspaceFolders?.[0];
    return typeof definition['command'] === 'string' ? this.task(definition as vscode.TaskDefinition & TaskDefinition, folder) : undefined;
  }

  private task(definition: vscode.TaskDefinition & TaskDefinition, folder: vscode.WorkspaceFolder | undefined): vscode.Task | undefined {
    const { info } = this.server;
    if (info === undefined || folder?.uri.scheme !== 'file') return undefined;
    const cwd = folder.uri.fsPath;
    const reading = readingOf(explicitSettings(['includePaths', 'defines', 'release'], folder.uri), cwd);
    const execution = new vscode.ProcessExecution(info.path, argumentsOfTask(definition, reading), { cwd, env: serverSettings().extraEnv });
    const isBuild = definition.command === 'codels build';
    const matcher = isBuild ? '$dotgen-codels' : '$dotgen';
    const task = new vscode.Task(definition, folder, definition.command, TYPE, execution, [matcher, `${matcher}-absolute`]);
    if (isBuild) task.group = vscode.TaskGroup.Build;
    return task;
  }
}

export const registerTasks = (server: Server): vscode.Disposable => vscode.tasks.registerTaskProvider(TYPE, new Tasks(server));
