#!/bin/sh
# Brings docs/scenes.md up to date: everything from "### The scene" on is what `salvo info --keys` prints.
# usage: scripts/key_reference.sh
set -eu
cd "$(dirname "$0")/.."
page=$(sed '/^### The scene$/,$d' docs/scenes.md)
keys=$(./run.sh info --keys)
printf '%s\n\n%s\n' "$page" "$keys" >docs/scenes.md
