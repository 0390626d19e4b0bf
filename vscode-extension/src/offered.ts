import * as vscode from 'vscode';

/** Far more than a menu shows. The oldest is dropped. */
const KEPT = 256;

/**
 * Commands of code actions, under names without arguments. VS Code drops the arguments of a command when it requests actions again. The edit of the chosen action can
 * cause such a request before the command of the action is executed.
 */
export class OfferedCommands {
  private readonly kept: vscode.Command[] = [];
  private last = 0;

  constructor(subscriptions: vscode.Disposable[]) {
    for (let i = 0; i < KEPT; i++) {
      const execute = () => {
        const command = this.kept[i];
        return command && vscode.commands.executeCommand(command.command, ...(command.arguments ?? []));
      };
      subscriptions.push(vscode.commands.registerCommand(`dotgen.offered.${i}`, execute));
    }
  }

  /** Gives the command of each action a name without arguments. */
  keep(actions: (vscode.Command | vscode.CodeAction)[] | null | undefined): void {
    for (const action of actions ?? []) {
      if (action instanceof vscode.CodeAction && action.command?.arguments !== undefined) {
        this.last = (this.last + 1) % KEPT;
        this.kept[this.last] = action.command;
        action.command = { title: action.command.title, command: `dotgen.offered.${this.last}` };
      }
    }
  }
}
