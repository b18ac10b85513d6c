#!/usr/bin/env bash
# Stands in for rustdoc where cargo runs the examples of the documentation: builds the pages of the crate first, and a warning is a failure.
# The libraries that the tests have compiled serve both; `cargo doc` would check every dependency again, four minutes of a processor.
set -euo pipefail

pages=()
skip=no
for argument in "$@"; do
    if [ "$skip" = yes ]; then skip=no && continue; fi
    case $argument in
    --test | --no-run) ;;
    --test-run-directory | --test-args | --test-builder | --test-runtool | --test-runtool-arg | --persist-doctests) skip=yes ;;
    --test-*=*) ;;
    *) pages+=("$argument") ;;
    esac
done
case " $* " in
*' --test '*) rustdoc "${pages[@]}" --out-dir "${CARGO_TARGET_DIR:-target}/pages" -Dwarnings ;;
esac
exec rustdoc "$@"
