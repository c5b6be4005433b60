#!/bin/sh
# Writes src/bindings.rs anew from the headers in $EMBREE_DIR/include, then runs the layout tests
# against those headers and against the published figures. See README.md.
set -eu
: "${EMBREE_DIR:?set EMBREE_DIR to a folder with include/embree4/rtcore.h of Embree 4.3 or later}"
cd "$(dirname "$0")"

out=$(cargo build -p embree4-sys --features bindgen --message-format=json | python3 -c '
import json, sys
for line in sys.stdin:
    message = json.loads(line)
    if message["reason"] == "build-script-executed" and "embree4-sys" in message["package_id"]:
        print(message["out_dir"])
')
cp "$out/bindings.rs" src/bindings.rs
cargo test -p embree4-sys --features bindgen
cargo test -p embree4-sys
git diff --stat -- src/bindings.rs
