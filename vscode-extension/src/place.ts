// A place in a file, as the server writes it.
import type { Range } from 'vscode-languageclient/node';

export interface Place {
  uri: string;
  range: Range;
}
